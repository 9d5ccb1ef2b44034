"""The project as it is installed: a wheel that works from any folder, extras that are named where they are missing."""

from __future__ import annotations

import io
import os
import pickle
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest
from support import disc
from support.fmus import ROOT, finish_in

import build_fmu
import fmu_src
from multiblock.__main__ import main
from solver import Column, InputError, Motion, __version__, simulate
from solver.common import errors
from solver.ground.motion import STANDARD_GRAVITY

MOTION = Motion.harmonic(0.05 * STANDARD_GRAVITY, 2.0, 0.5)


PIP: list[str | Path] = [sys.executable, "-m", "pip", "-q", "--disable-pip-version-check"]


def wheel_in(folder: Path, **environment: str) -> Path:
    """Return the wheel of the project, built in a folder."""
    source = folder / "source"  # a copy: a build leaves files behind
    for name in ("solver", "fmu_src", "multiblock", "examples"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE", "build_fmu.py"):
        shutil.copy(ROOT / name, source)
    stale = source / "build" / "lib" / "solver" / "stale.py"  # what an earlier build may have left
    stale.parent.mkdir(parents=True)
    stale.touch()
    wheel: list[str | Path] = [*PIP, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", folder, source]
    subprocess.run(wheel, check=True, capture_output=True, env=os.environ | environment)
    (made,) = folder.glob("*.whl")
    with zipfile.ZipFile(made) as archive:
        assert "solver/stale.py" not in archive.namelist()
    return made


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder that the wheel is installed in, away from the checkout; what it depends on is this
    interpreter's.
    """
    folder = tmp_path_factory.mktemp("wheel")
    made = wheel_in(folder)
    assert made.name == f"multiblock_fmu-{__version__}-py3-none-any.whl"
    subprocess.run([*PIP, "install", "--no-deps", "--target", folder / "site", made], check=True, capture_output=True)
    return folder / "site"


def from_wheel(installed: Path, folder: Path, *command: object) -> subprocess.CompletedProcess[str]:
    """Run a command of the installed project in `folder`, from which the checkout is out of reach."""
    return finish_in(folder, *command, PYTHONPATH=str(installed))


@pytest.mark.long  # compiles the kernels at a place of their own
@pytest.mark.skipif(sys.platform == "win32", reason="pip puts the command elsewhere on Windows")
def test_the_wheel_builds_the_default_column_from_any_folder(installed: Path, tmp_path: Path) -> None:
    """Build it; .ci/run simulates with it, where nothing but what the solver needs is installed."""
    done = from_wheel(installed, tmp_path, sys.executable, "-c", "import solver; print(solver.__file__)")
    assert done.stdout.strip() == str(installed / "solver" / "__init__.py")
    done = from_wheel(installed, tmp_path, installed / "bin" / "multiblock", "build-fmu")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.strip() == "phocas_damped.fmu"
    with zipfile.ZipFile(tmp_path / "phocas_damped.fmu") as fmu:
        names = fmu.namelist()
        carried = zipfile.ZipFile(io.BytesIO(fmu.read("resources/python.zip"))).namelist()
    for suffix in ("py", "pyc"):
        assert any(re.fullmatch(rf"solver_\w+/runs/simulate\.{suffix}", name) for name in carried)
    assert "documentation/signs.png" in names
    assert any("resources/code/column." in name for name in names)


RUN_ALL = """
import sys, time
begun = time.perf_counter()
from multiblock import Column, Motion, Structure, simulate, simulate_many
examples = sys.argv[1]
column = Column.from_toml(f"{examples}/columns/phocas-damped.toml")
motion = Motion.harmonic(0.5, 2.0, 2.0)
response = simulate(column, motion)
many = simulate_many(column, [motion] * 16)
structure = simulate(Structure.from_toml(f"{examples}/structures/trilith.toml"), Motion.harmonic(0.5, 2.0, 0.5))
assert not {"numba", "llvmlite"} & {name.partition(".")[0] for name in sys.modules}
found = response.peak_top_ux[0], structure.peaks["ux"][0], many["peak_top_ux"][0, 0]
print(*(repr(float(one)) for one in found))
"""


@pytest.mark.long  # makes all machine code, and two environments
@pytest.mark.skipif(sys.platform != "linux", reason="builds the wheel for Linux, and runs it")
def test_a_wheel_for_a_platform_needs_numpy_alone_and_keeps_nothing(tmp_path: Path) -> None:
    """Check that installed without numba on an account without a home, it runs everything, and builds an FMU that runs
    there.
    """
    pytest.importorskip("ziglang", reason="needs the extra native")
    wheel = wheel_in(tmp_path / "made", MULTIBLOCK_WHEEL="manylinux_2_17_x86_64")
    assert wheel.name == f"multiblock_fmu-{__version__}-py3-none-manylinux_2_17_x86_64.whl"
    assert wheel.stat().st_size < 6e6
    with zipfile.ZipFile(wheel) as archive:
        (metadata,) = (name for name in archive.namelist() if name.endswith("/METADATA"))
        required = re.findall(r"^Requires-Dist: ([\w-]+)[^;\n]*$", archive.read(metadata).decode(), re.MULTILINE)
    assert required == ["numpy", "tqdm"]
    python = tmp_path / "venv" / "bin" / "python"
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    install: list[str | Path] = [python, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    alone = os.environ | {"PYTHONPATH": ""}  # pip takes a checkout on the path for the project installed
    subprocess.run([*install, wheel], check=True, capture_output=True, env=alone)
    absent = {"HOME": "/nonexistent", "XDG_CACHE_HOME": "", "MULTIBLOCK_CACHE_DIR": "", "PYTHONPATH": ""}
    before = files_below(tmp_path / "venv")
    done = finish_in(tmp_path, python, "-B", "-c", RUN_ALL, ROOT / "examples", **absent)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    here = finish_in(tmp_path, sys.executable, "-c", RUN_ALL.replace("assert not", "0 and"), ROOT / "examples")
    assert done.stdout == here.stdout
    assert files_below(tmp_path / "venv") == before
    fmu = tmp_path / "phocas_damped.fmu"
    subprocess.run([sys.executable, ROOT / "build_fmu.py", build_fmu.DEFAULT_COLUMN, "-o", fmu], check=True)
    subprocess.run([*install, "fmpy"], check=True, capture_output=True, env=alone)
    rows = tmp_path / "rows.csv"
    fmpy = ["-m", "fmpy", "simulate", fmu, "--stop-time", "0.1", "--start-values", "base.jx", "1.0"]
    done = finish_in(tmp_path, python, *fmpy, "--output-file", rows, **absent)
    assert done.returncode == 0, done.stderr
    assert np.abs(np.genfromtxt(rows, delimiter=",", names=True, deletechars="")["block[1].ux"]).max() > 0.0


def test_a_wheel_for_an_unknown_platform_is_refused(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    setup: list[str | Path] = [sys.executable, "setup.py", "-q", "egg_info", "--egg-base", tmp_path]
    command = [*setup, "build_py", "--build-lib", tmp_path / "lib"]
    environment = os.environ | {"MULTIBLOCK_WHEEL": "solaris"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("MULTIBLOCK_WHEEL = solaris: must be of manylinux_2_17_x86_64, ")


@pytest.mark.long  # makes an environment
@pytest.mark.skipif(sys.platform == "win32", reason="its environments have other folders")
def test_nothing_is_left_where_the_wheel_was_installed(installed: Path, tmp_path: Path) -> None:
    """Check that machine code outlives the project in the cache folder of the user alone."""
    (wheel,) = installed.parent.glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv"], check=True)
    python = tmp_path / "venv" / "bin" / "python"
    pip: list[str | Path] = [*PIP, "--python", python]
    before = files_below(tmp_path / "venv")
    subprocess.run([*pip, "install", "--no-deps", wheel], check=True, capture_output=True)
    places = {"PYTHONPATH": str(Path(np.__file__).parents[1]), "MULTIBLOCK_CACHE_DIR": str(tmp_path / "kept")}
    done = finish_in(tmp_path, python, "-c", disc.PROGRAM, **places)
    assert (done.returncode, round(float(done.stdout or "nan"), 12)) == (0, 1.0), done.stderr
    assert len([*(tmp_path / "kept" / "code").glob("statics.*.o")]) == 1
    assert not [name for name in files_below(tmp_path / "venv") if name.suffix in (".o", ".so", ".bc")]
    subprocess.run([*pip, "uninstall", "-y", "multiblock-fmu"], check=True, capture_output=True)
    assert files_below(tmp_path / "venv") <= before  # pip takes the empty folder with it


def files_below(folder: Path) -> set[Path]:
    """Return everything in a folder, by path within it."""
    return {path.relative_to(folder) for path in folder.rglob("*")}


def test_every_name_of_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("simulate", "convert", "build-fmu", "--version"))
    assert main(["build-fmu", "none.toml"]) == 2
    assert capsys.readouterr().err == "multiblock: none.toml: No such file or directory\n"
    assert main(["build-fmu", "--frob"]) == 2
    assert capsys.readouterr().err == "multiblock: unrecognized arguments: --frob (--help shows the options)\n"
    assert build_fmu.main(["none.toml"]) == 2
    assert capsys.readouterr().err == "build_fmu.py: none.toml: No such file or directory\n"


def take_away(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    """Let imports fail as if `package` were not installed."""
    monkeypatch.setitem(sys.modules, package, None)
    for name in [name for name in sys.modules if name.startswith(f"{package}.")]:
        monkeypatch.setitem(sys.modules, name, None)


@pytest.mark.parametrize(
    ("absent", "extra", "line"),
    [
        ("matplotlib", "plot", "simulate {column} {motion} --plot x.png"),
        ("pythonfmu", "fmu", "build-fmu {column} -o x.fmu"),
        ("matplotlib", "native", "build-fmu {column} --native -o x.fmu"),
        ("jinja2", "report", "check {column} {motion} --report x.html"),
    ],
)
def test_what_is_missing_is_named_with_its_extra(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    absent: str,
    extra: str,
    line: str,
) -> None:
    take_away(monkeypatch, absent)
    for name in ("documentation", "native"):  # to be imported again
        monkeypatch.delattr(fmu_src, name, raising=False)
    needed = ("fmu_src.native", "fmu_src.documentation", "solver.checks.report")
    for name in [name for name in sys.modules if name.startswith(needed)]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.chdir(tmp_path)
    MOTION.to_csv("motion.csv", step=0.01)
    assert main(line.format(column=build_fmu.DEFAULT_COLUMN, motion="motion.csv").split()) == 2
    printed = capsys.readouterr()
    assert printed.err == f'multiblock: {absent} is not installed: pip install -e "{ROOT}[{extra}]"\n'
    assert printed.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["motion.csv"]


@pytest.mark.parametrize("name", ["a&\x01.csv", "a\0.csv", "\udcff.csv", "a<b.csv"])
@pytest.mark.parametrize("options", [[], ["--native"]])
def test_a_record_whose_name_no_fmu_can_hold(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str, options: list[str]
) -> None:
    """Check that the name of a record stands in the XML and in a path: a bad one would end in a traceback or an
    unreadable FMU.
    """
    monkeypatch.chdir(tmp_path)
    assert build_fmu.main([str(build_fmu.DEFAULT_COLUMN), "--record", name, *options]) == 2
    err = capsys.readouterr().err
    assert err.startswith("build_fmu.py: the name of --record = ")
    assert "must have no control characters" in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_an_fmu_is_overwritten_by_force_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.fmu"
    path.write_text("before")
    assert build_fmu.main([str(build_fmu.DEFAULT_COLUMN), "-o", str(path)]) == 2
    assert capsys.readouterr().err == f"build_fmu.py: {path}: is there already, --force overwrites it\n"
    assert path.read_text() == "before"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--native --scalars", "--scalars: with --fmi 3 only"),
        ("--fmi 3", "--fmi 3: with --native only"),
        ("--terminals", "--terminals: with --native only"),
        ("--source", "--source: with --native only"),
        ("--platforms linux64", "--platforms: with --native only"),
        ("--bodies 2", "--bodies: must be left out without --drive body or horizontal"),
        ("--slope line", "--slope: must be left out without --drive body or horizontal"),
        ("--native --platforms linux64,amiga", "amiga: must be of linux64, win64, darwin64, aarch64-linux"),
    ],
)
def test_options_that_an_fmu_does_not_have(capsys: pytest.CaptureFixture[str], options: str, said: str) -> None:
    assert build_fmu.main([str(build_fmu.DEFAULT_COLUMN), *options.split()]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line


def test_hints_can_be_typed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def hint() -> str:
        with pytest.raises(InputError) as caught, errors.needing("plot", "absent"):
            raise ModuleNotFoundError(name="absent")
        return str(caught.value).partition(": ")[2]

    monkeypatch.chdir(ROOT)
    assert hint() == 'pip install -e ".[plot]"'
    monkeypatch.setattr(errors, "__file__", str(tmp_path / "solver" / "errors.py"))  # no checkout
    assert hint() == 'pip install "multiblock-fmu[plot]"'


@pytest.mark.long  # an environment of setuptools' own is copied, as the wheel's
def test_the_source_distribution_has_all_that_the_repository_has(tmp_path: Path) -> None:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split(
        "\n"
    )
    if listed == [""]:
        pytest.skip("no repository here to compare with")
    source = tmp_path / "source"
    for name in filter(None, listed):
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, source / name)
    make = "from setuptools import build_meta; print(build_meta.build_sdist('made'))"
    subprocess.run([sys.executable, "-c", make], cwd=source, check=True, capture_output=True)
    (made,) = (source / "made").iterdir()
    with tarfile.open(made) as archive:
        within = {name.partition("/")[2] for name in archive.getnames()}
    assert {name for name in listed if name and (ROOT / name).is_file()} <= within


def test_drawing_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    response = simulate(Column.from_toml(build_fmu.DEFAULT_COLUMN), MOTION)
    take_away(monkeypatch, "matplotlib")
    for name in ("solver.plotting.of_column", "solver.plotting.plots"):  # to be imported again
        monkeypatch.delitem(sys.modules, name, raising=False)
        monkeypatch.delattr(name, raising=False)
    with pytest.raises(InputError, match=r'pip install -e ".*\[plot\]"$'):
        response.plot()


def test_a_response_can_be_pickled() -> None:
    response = simulate(Column.from_toml(build_fmu.DEFAULT_COLUMN), MOTION, check=True, ensemble=2)
    again = pickle.loads(pickle.dumps(response))
    assert again.model == response.model
    assert again.stats == response.stats
    for name in ("time", *(output.field for output in response.outputs if not output.only_peak), "peak_top_ux"):
        np.testing.assert_array_equal(getattr(again, name), getattr(response, name))
    for name in ("overturned", "verdict", "reason", "horizon"):
        assert getattr(again, name) == getattr(response, name)
    assert response.estimated_error is not None
    assert response.ensemble is not None
    assert again.estimated_error.ux == response.estimated_error.ux
    np.testing.assert_array_equal(again.ensemble.ux, response.ensemble.ux)
    assert pickle.loads(pickle.dumps(again)).ux.shape == response.ux.shape


def test_one_version_everywhere() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {__version__}\n" in citation
    assert f"\n## {__version__}\n" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_a_commit_is_linted_as_continuous_integration_does() -> None:
    hooks = re.findall(r" entry: ([^,]+),", (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))
    run = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    (linted,) = re.findall(r"PATH=.*bin:.*\n((?: +.*\n)+?) +python -m sphinx", run)
    assert [line.strip() for line in linted.splitlines()] == hooks


def test_every_package_is_installed() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    listed = settings["tool"]["setuptools"]["packages"]
    found = [file.parent for name in ("solver", "fmu_src", "multiblock") for file in (ROOT / name).rglob("__init__.py")]
    names = {".".join(folder.relative_to(ROOT).parts) for folder in found}
    assert names == set(listed) - {build_fmu.COLUMNS_PACKAGE}
