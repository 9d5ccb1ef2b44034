"""The FMU in masters that others wrote; those that are not installed are skipped (pip install -e ".[masters]")."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
import sysconfig
from pathlib import Path

import pytest
from support.child import call, command, returned
from support.fmus import Fmus, finish_in, run, stack_file
from support.inside import masters

H, STOP = 0.01, 2.0  # s

pytestmark = pytest.mark.long

COMPLAINTS = ("error", "warn", "fatal", "fail")


@pytest.fixture(scope="module")
def alone(fmus: Fmus) -> list[float]:
    """Return the column under FMPy."""
    return list(call(masters.alone, fmus.damped))


def said(*command: object, cwd: Path | None = None, **variables: str) -> tuple[str, str]:
    """Return the output and error output of a process; fails unless it ends with 0."""
    done = finish_in(cwd, *command, **variables)
    assert done.returncode == 0, f"exit code {done.returncode}: {done.stderr}"
    return done.stdout, done.stderr


def libraries() -> str:
    """Return the folder of pip's shared libraries, such as the tbb that ecos is linked with."""
    return os.pathsep.join((str(Path(sys.prefix) / "lib"), os.environ.get("LD_LIBRARY_PATH", "")))


def package(name: str) -> Path:
    """Return the folder of an installed package; skips where it is absent."""
    spec = importlib.util.find_spec(name)
    if spec is None or spec.origin is None:
        pytest.skip(f"{name} is not installed")
    return Path(spec.origin).parent


@pytest.mark.campaign
def test_the_table_of_masters_has_every_cell_run_or_the_reason_why_not(
    fmus: Fmus, native: Path, native3: Path, native_coupled: Path, tmp_path: Path
) -> None:
    for name, built in (("python", fmus.damped), ("native", native), ("fmi3", native3)):
        (tmp_path / f"{name}.fmu").symlink_to(built)
    (tmp_path / "coupled").symlink_to(native_coupled)
    table = (sys.executable, Path(__file__).parents[1] / "masters" / "run.py", "--folder", tmp_path)
    head, _, *rows = run(*table).splitlines()  # exit code 0: none that is there complains
    cells = {
        name.partition(" (")[0]: row  # without its version
        for name, *row in ([cell.strip() for cell in line.strip("|").split("|")] for line in rows)
    }
    assert len(cells) == 13
    kinds = len(head.strip("|").split("|")) - 1
    assert all(len(row) == kinds and all(row) for row in cells.values())
    assert not any("not run" in cell for cell in cells["FMPy"])
    if not any("not run" in cell for cell in cells["C host"][:2]):
        for _ in range(4):  # without the clean exit every such process aborts
            run(*table, "--master", "C host")


def test_libcosim(fmus: Fmus, alone: list[float]) -> None:
    package("libcosimpy")
    out, err = said(*command(masters.libcosim, fmus.damped))
    log = [line for line in (out + err).splitlines() if line.startswith("[")]
    ignored = [line for line in log if "Enumeration variable type not supported" in line]  # they stay as built
    assert len(ignored) == 1  # verdict
    log = [line for line in log if line not in ignored]
    assert not [line for line in log if any(f"[{word}" in line for word in COMPLAINTS)]
    assert returned(out) == pytest.approx(alone, rel=1e-9)


def test_ecos_inside_python(fmus: Fmus, alone: list[float]) -> None:
    package("ecospy")
    if importlib.util.find_spec("ecospy") and not list((Path(sys.prefix) / "lib").glob("libtbb.so.12")):
        pytest.skip("ecospy needs libtbb.so.12, which pip install tbb brings")
    out, err = said(*command(masters.ecos, fmus.damped), LD_LIBRARY_PATH=libraries())
    assert not any(word in err.lower() for word in COMPLAINTS)
    assert returned(out) == pytest.approx(alone, rel=1e-9)


def test_ecos_on_the_command_line_starts_python_itself(fmus: Fmus, tmp_path: Path) -> None:
    binary = tmp_path / "ecos"
    shutil.copy(package("ecospy") / "binaries" / "ecos", binary)
    binary.chmod(0o755)  # the wheel forgets it
    python = Path(sysconfig.get_config_var("LIBDIR")) / (sysconfig.get_config_var("INSTSONAME") or "")
    if not python.is_file() or not list((Path(sys.prefix) / "lib").glob("libtbb.so.12")):
        pytest.skip("needs a shared libpython and libtbb.so.12")
    out, err = said(
        *(binary, "simulate", "--path", fmus.damped, "--stopTime", STOP, "--stepSize", H),
        cwd=tmp_path,
        LD_PRELOAD=str(python),
        LD_LIBRARY_PATH=libraries(),
        PYTHONPATH=sysconfig.get_paths()["purelib"],
    )
    assert "[error]" not in out + err
    assert "zero for the whole run" in err  # ecos has no way to set an input here: our own warning, and no other
    assert err.count("\n") == 1
    assert (tmp_path / f"{fmus.damped.stem}.csv").stat().st_size > 1000


@pytest.mark.parametrize("n", [1, 3, 40])
def test_fmu_manipulation_toolbox_checks_any_column(fmus: Fmus, tmp_path: Path, n: int) -> None:
    package("fmu_manipulation_toolbox")
    out, err = said("fmutool", "-input", fmus.build(stack_file(tmp_path, n), tmp_path / "stack.fmu"), "-check")
    assert "seems to be compliant" in out + err
    assert "No semantic error" in out + err
    assert not any(word in (out + err) for word in ("ERROR", "WARNING"))


def test_two_columns_merged_into_one_fmu(fmus: Fmus, tmp_path: Path, alone: list[float]) -> None:
    package("fmu_manipulation_toolbox")
    shutil.copy(fmus.damped, tmp_path / "damped.fmu")
    shutil.copy(fmus.phocas, tmp_path / "phocas.fmu")
    (tmp_path / "both.json").write_text(
        '{"name": "both.fmu", "fmu": ["damped.fmu", "phocas.fmu"], "step_size": 0.01, "auto_link": false,'
        '"auto_input": false, "auto_output": false, "auto_parameter": false, "link": [], "start": [],'
        '"input": [["ax", "damped.fmu", "base.ax"], ["ax", "phocas.fmu", "base.ax"]],'
        '"output": [["damped.fmu", "block[1].ux", "damped"], ["phocas.fmu", "block[1].ux", "phocas"]]}'
    )
    said("fmucontainer", "-container", "both.json", cwd=tmp_path)
    assert "No problems found" in run("fmpy", "validate", tmp_path / "both.fmu")
    damped, phocas = call(masters.container, tmp_path / "both.fmu")
    assert damped == pytest.approx(alone[0], rel=1e-9)
    assert phocas == pytest.approx(call(masters.alone, fmus.phocas)[0], rel=1e-6)
