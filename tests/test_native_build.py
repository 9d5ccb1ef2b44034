"""What `build_fmu.py --native` makes: libraries for three systems, what they need, and a host without Python."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from child import call
from fmpy import extract, read_model_description
from fmus import ROOT, Fmus, finish, run
from inside import inputs

from build_fmu import main
from fmu_src.native import library, symbols

if importlib.util.find_spec("ziglang") is None:
    pytest.skip("needs ziglang, the extra native", allow_module_level=True)

DAMPED = ROOT / "examples/columns/phocas-damped.toml"
MATHEMATICS = {"atan2", "cos", "exp", "expm1", "hypot", "log", "pow", "sin", "sincos"}
FORMATS = {"linux64": ["ELF x86-64"], "win64": ["PE x86-64"], "darwin64": ["Mach-O x86_64", "Mach-O arm64"]}


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The damped example for all platforms."""
    return Fmus.build(DAMPED, tmp_path_factory.mktemp("native") / "damped.fmu", "--native")


def test_libraries_for_three_systems_need_no_python(fmu: Path) -> None:
    assert fmu.stat().st_size < 1e6
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith("binaries/")]
        parts = {name.split("/")[1]: symbols.read(archive.read(name)) for name in names}
    assert {platform: [part.format for part in found] for platform, found in parts.items()} == FORMATS
    header = (library.headers() / "fmi2Functions.h").read_text(encoding="utf-8")
    for found in parts.values():
        for part in found:
            assert part.foreign == []
            offered = {name for name in part.offered if name.startswith("fmi2")}
            assert len(offered) >= 31
            assert all(f"#define {name} " in header for name in offered)
            assert not [name for name in part.offered if name.startswith("kernel")]
    (linux,) = parts["linux64"]
    strange = set(linux.needed) - MATHEMATICS
    assert all(hasattr(__import__("ctypes").CDLL(None), name) for name in strange), strange


def test_a_symbol_of_python_is_found() -> None:
    part = symbols.Symbols("ELF", ("sin", "PyErr_Clear", "NRT_Free", "_numba_hypot"), (), ("libpython3.11.so",))
    assert part.foreign == ["PyErr_Clear", "NRT_Free", "_numba_hypot"]


def test_a_host_in_c_runs_it(fmu: Path, tmp_path: Path) -> None:
    if not sys.platform.startswith("linux"):
        pytest.skip("the host is built for Linux")
    host = tmp_path / "host"
    compile_host = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-target",
        "x86_64-linux-gnu",
        "-O1",
        ROOT / "tests/masters/host.c",
        "-o",
        host,
        "-ldl",
    ]
    run(*compile_host)
    folder = Path(extract(str(fmu), unzipdir=tmp_path / "fmu"))
    description = read_model_description(str(fmu))
    reference = {variable.name: str(variable.valueReference) for variable in description.modelVariables}
    binary = folder / "binaries/linux64/phocas_damped.so"
    (needed,) = symbols.read(host.read_bytes())
    (library_needs,) = symbols.read(binary.read_bytes())
    assert not [name for name in (*needed.libraries, *library_needs.libraries) if "python" in name]
    command = [host, binary, "file:///nowhere", description.guid, reference["base.ax"], reference["block[1].ux"]]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, env={}, check=False)
    assert done.returncode == 0, done.stderr
    once, again = (float(word) for word in done.stdout.split())
    assert once == again == call(inputs.pushed, fmu)


def test_what_is_needed_is_printed_and_the_same_input_builds_the_same_bytes(tmp_path: Path) -> None:
    built = []
    for k in range(2):
        output = tmp_path / f"{k}.fmu"
        done = finish(
            sys.executable, ROOT / "build_fmu.py", DAMPED, "-o", output, *("--native", "--platforms", "linux64")
        )
        assert done.returncode == 0
        assert "linux64 (ELF x86-64) needs: " in done.stderr
        built.append(output.read_bytes())
    assert built[0] == built[1]


def test_a_wrong_platform_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(DAMPED), "--native", "--platforms", "linux64,amiga"]) == 2
    assert capsys.readouterr().err == "build_fmu.py: --platforms amiga: must be of linux64, win64, darwin64\n"


def test_without_ziglang_the_build_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == "ziglang" else find_spec(name, *rest)
    )
    assert main([str(DAMPED), "-o", str(tmp_path / "x.fmu"), "--native"]) == 2
    assert 'pip install "multiblock-fmu[native]"' in capsys.readouterr().err
