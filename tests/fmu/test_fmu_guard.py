"""The PythonFMU where PythonFMU's own library alone would end the process: folders, URIs, statuses; by exit code."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

import pytest
from fmpy import extract, read_model_description
from support.child import call, ended, returned
from support.fmus import DAMPED, Fmus, c_host, finish, read_results, run
from support.inside import guarded

import build_fmu
from fmu_src.native import guard, library

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time

if not sys.platform.startswith("linux"):
    pytest.skip("the guard is built for Linux", allow_module_level=True)
if not library.has_tools():
    pytest.skip("needs ziglang, the extra native", allow_module_level=True)

OPTIONS = ("--stop-time", 0.05, "--start-values", "base.ax", 0.5, "--output-file")


FOLDERS = ("Müller", "a#b", "100% sure", "a b", "柱", "a%2")


@pytest.mark.parametrize("folder", ["".join(FOLDERS), *(it for it in FOLDERS)])
def test_it_runs_below_any_folder(fmus: Fmus, tmp_path: Path, folder: str) -> None:
    """Check that without the guard all but the one with a blank end with 139."""
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


def test_what_cannot_be_instantiated_is_refused_with_a_reason(fmus: Fmus, tmp_path: Path) -> None:
    """Check that without the guard a missing URI ends the process with 134, a wrong one with 139; the rest passes."""
    done = ended(guarded.instantiate, fmus.damped, tmp_path)
    assert done.returncode == 0, done.stderr
    made = returned(done.stdout)
    said = done.stderr.split("=\n")
    reasons = ["URI of the resources is missing", *["are not there"] * 3, *["the GUID is not"] * 2]
    reasons += ["for co-simulation only", *["needs a name"] * 2]
    for reason, line in zip(reasons, said, strict=False):
        assert reason in line
        assert line.count("\n") == 1
    assert made == [False] * len(reasons) + [True] * 7


def test_the_status_of_the_last_step(fmus: Fmus) -> None:
    """Check that a discarded step does not mean that the slave wants to end the run; a wrong one is no step to try
    halved.
    """
    found = call(guarded.statuses, fmus.damped)
    assert found["steps"] == [[[0] * 4, 0, 0.1, 0, ""], [[0] * 4, 2, 0.1, 0, ""], [[0] * 4, 0, 0.2, 0, ""]]
    assert all(answer.endswith("(error).") for answer in found["wrong"])
    assert found["after"] == [0, 3]
    assert found["unknown"] == [2, 2]


def test_a_host_without_python_hears_what_is_missing(fmus: Fmus, tmp_path: Path) -> None:
    host = c_host(tmp_path)
    folder = Path(extract(str(fmus.damped), unzipdir=tmp_path / "fmu"))
    guid = read_model_description(str(fmus.damped)).guid
    binary = folder / "binaries/linux64/phocas_damped.so"
    done = finish(host, binary, (folder / "resources").as_uri(), guid, 1, 10001)
    assert done.returncode == 1
    assert "PythonFMU's library cannot be loaded" in done.stderr
    assert "LD_PRELOAD" in done.stderr


def test_without_a_compiler_the_fmu_says_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(build_fmu, "has_tools", lambda: False)
    monkeypatch.setattr(guard, "has_tools", lambda: False)
    assert build_fmu.main([str(DAMPED), "-o", str(tmp_path / "bare.fmu")]) == 0
    assert capsys.readouterr().err == ""
    with zipfile.ZipFile(tmp_path / "bare.fmu") as archive:
        assert [name for name in archive.namelist() if "linux64" in name] == ["binaries/linux64/phocas_damped.so"]
        assert "has no guard" in archive.read("documentation/index.html").decode()
    run("fmpy", "simulate", tmp_path / "bare.fmu", *OPTIONS, tmp_path / "out.csv")
