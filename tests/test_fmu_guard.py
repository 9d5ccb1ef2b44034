"""The PythonFMU where PythonFMU's own library alone would end the process: folders, URIs, statuses; by exit code."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

import pytest
from fmpy import extract, read_model_description
from fmus import ROOT, Fmus, finish, read_results, run

import build_fmu
from fmu_src.native import guard, library

if not sys.platform.startswith("linux"):
    pytest.skip("the guard is built for Linux", allow_module_level=True)
if not library.has_tools():
    pytest.skip("needs ziglang, the extra native", allow_module_level=True)

OPTIONS = ("--stop-time", 0.05, "--start-values", "base.ax", 0.5, "--output-file")


@pytest.mark.parametrize("folder", ["Müller", "a#b", "100% sure", "a b", "柱", "a%2"])
def test_it_runs_below_any_folder(fmus: Fmus, tmp_path: Path, folder: str) -> None:
    """Without the guard all but the one with a blank end with 139."""
    there = tmp_path / folder
    there.mkdir()
    run("fmpy", "simulate", fmus.damped, *OPTIONS, there / "out.csv", TMPDIR=str(there))
    run("fmpy", "simulate", fmus.damped, *OPTIONS, tmp_path / "out.csv")
    assert (there / "out.csv").read_text() == (tmp_path / "out.csv").read_text()
    assert read_results(there / "out.csv")["block[1].ux"][-1] != 0.0


def test_the_one_folder_that_it_cannot_run_below_is_refused(fmus: Fmus, tmp_path: Path) -> None:
    there = tmp_path / "a%20b"
    there.mkdir()
    done = finish("fmpy", "simulate", fmus.damped, *OPTIONS, there / "out.csv", TMPDIR=str(there))
    assert done.returncode == 1
    assert "PythonFMU's library takes no folder with %20 in its name" in done.stderr


# argv: FMU. Instantiates in the wrong way, then in the ways in which hosts write the URI; prints what came of it.
INSTANTIATE = """
import ctypes, sys
from pathlib import Path
from fmpy import extract
from instance import Instance
folder = Path(sys.argv[2], "Rødgrød 7%").resolve()
folder.mkdir()
extract(sys.argv[1], unzipdir=str(folder))
column = Instance(sys.argv[1], folder=str(folder))
dll, guid, own = column.fmi.dll, column.fmi.guid.encode(), (folder / "resources").as_uri().encode()
plain = str(folder / "resources").encode()

def instantiate(name=b"column", kind=1, guid=guid, uri=own, functions=ctypes.byref(column.fmi.callbacks)):
    made = dll.fmi2Instantiate(name, kind, guid, uri, functions, 0, 0)
    if made:
        dll.fmi2FreeInstance(ctypes.c_void_p(made))
    print("=" + ("made" if made else "refused"), flush=True)
    print("=", file=sys.stderr, flush=True)

instantiate(uri=None)
instantiate(uri=b"file:///nowhere/at/all")
instantiate(uri=b"")
instantiate(uri=b"x" * 10000)
instantiate(guid=b"{other}")
instantiate(guid=None)
instantiate(kind=0)
instantiate(name=b"")
instantiate(name=None)
for uri in (own, own + b"/", b"file:" + own[7:], b"file://localhost" + own[7:], plain, b"file://" + plain):
    instantiate(uri=uri)
instantiate(functions=None)
column.step(0.0, 0.1)
column.close()
"""


def test_what_cannot_be_instantiated_is_refused_with_a_reason(fmus: Fmus, tmp_path: Path) -> None:
    """Without the guard a missing URI ends the process with 134, a wrong one with 139, the rest is accepted."""
    done = finish(sys.executable, "-c", INSTANTIATE, fmus.damped, tmp_path)
    assert done.returncode == 0, done.stderr
    answers = [line[1:] for line in done.stdout.splitlines() if line in ("=made", "=refused")]
    said = done.stderr.split("=\n")
    reasons = ["URI of the resources is missing", *["are not there"] * 3, *["the GUID is not"] * 2]
    reasons += ["for co-simulation only", *["needs a name"] * 2]
    for reason, line in zip(reasons, said, strict=False):
        assert reason in line
        assert line.count("\n") == 1
    assert answers[: len(reasons)] == ["refused"] * len(reasons)
    assert answers[len(reasons) :] == ["made"] * 7


STATUS = """
import ctypes, sys
from instance import Instance
from fmpy.fmi2 import fmi2Boolean, fmi2Real, fmi2Status, fmi2String
nan = float("nan")
column = Instance(sys.argv[1], {"base.ax": 0.5})
dll, c = column.fmi.dll, ctypes.c_void_p(column.fmi.component)
status, time, flag, text = fmi2Status(), fmi2Real(), fmi2Boolean(), fmi2String()

def told():
    codes = [dll.fmi2GetStatus(c, 0, ctypes.byref(status)), dll.fmi2GetRealStatus(c, 2, ctypes.byref(time)),
             dll.fmi2GetBooleanStatus(c, 3, ctypes.byref(flag)), dll.fmi2GetStringStatus(c, 1, ctypes.byref(text))]
    print(codes, status.value, round(time.value, 9), flag.value, text.value)

column.step(0.0, 0.1)
told()
column.set({"base.ax": nan})
column.attempt("step", 0.1, 0.1)
told()
column.set({"base.ax": 0.5})
column.step(0.1, 0.1)
told()
for h in (0.0, -0.1, nan):
    print(column.attempt("step", 0.2, h)[-8:])
print(dll.fmi2GetStatus(c, 0, ctypes.byref(status)), status.value)
print(dll.fmi2GetIntegerStatus(c, 0, ctypes.byref(status)), dll.fmi2GetStatus(c, 1, ctypes.byref(status)))
column.step(0.2, 0.1)
column.close()
"""


def test_the_status_of_the_last_step(fmus: Fmus) -> None:
    """A discarded step does not mean that the slave wants to end the run; a wrong one is no step to try halved."""
    done = finish(sys.executable, "-c", STATUS, fmus.damped)
    assert done.returncode == 0, done.stderr
    lines = [line for line in done.stdout.splitlines() if not line.startswith(("[OK", "[DISCARD"))]
    assert lines == [
        "[0, 0, 0, 0] 0 0.1 0 b''",
        "[0, 0, 0, 0] 2 0.1 0 b''",
        "[0, 0, 0, 0] 0 0.2 0 b''",
        *["(error)."] * 3,
        "0 3",
        "2 2",
    ]


def test_a_host_without_python_hears_what_is_missing(fmus: Fmus, tmp_path: Path) -> None:
    host = tmp_path / "host"
    run(sys.executable, "-m", "ziglang", "cc", "-O1", ROOT / "tests/masters/host.c", "-o", host, "-ldl")
    folder = Path(extract(str(fmus.damped), unzipdir=tmp_path / "fmu"))
    guid = read_model_description(str(fmus.damped)).guid
    binary = folder / "binaries/linux64/phocas_damped.so"
    done = finish(host, binary, (folder / "resources").as_uri(), guid, 1, 10001)
    assert done.returncode == 1
    assert "PythonFMU's library cannot be loaded" in done.stderr
    assert "LD_PRELOAD" in done.stderr


def test_without_a_compiler_the_build_says_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(build_fmu, "has_tools", lambda: False)
    monkeypatch.setattr(guard, "has_tools", lambda: False)
    column = ROOT / "examples/columns/phocas-damped.toml"
    assert build_fmu.main([str(column), "-o", str(tmp_path / "bare.fmu")]) == 0
    assert "without ziglang the FMU holds PythonFMU's library alone" in capsys.readouterr().err
    with zipfile.ZipFile(tmp_path / "bare.fmu") as archive:
        assert [name for name in archive.namelist() if "linux64" in name] == ["binaries/linux64/phocas_damped.so"]
    run("fmpy", "simulate", tmp_path / "bare.fmu", *OPTIONS, tmp_path / "out.csv")
