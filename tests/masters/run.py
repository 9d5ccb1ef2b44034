"""Try an FMU of this project in masters that pip does not install: `python tests/masters/run.py FILE.fmu [...]`.

Fetches nothing; a master that is absent is skipped with a reason. Exit code 1 if one that is there complains.

    C host          host.c of this folder, compiled with cc, with libpython preloaded
    PyFMI           imported
    fmusim          of the Reference-FMUs, on the PATH; once more with its state saved and restored
    fmuCheck        the FMU Compliance Checker, on the PATH as fmuCheck.linux64
    VDMCheck        on the PATH as VDMCheck2.sh
    OMSimulator     on the PATH
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable
from pathlib import Path

from fmpy import extract, read_model_description

CHILD = Path(__file__).resolve().parents[1] / "child.py"

HERE = Path(__file__).resolve().parent


class AbsentError(Exception):
    """Why a master cannot be tried here."""


def main(fmus: list[str]) -> int:
    """Try every FMU in every master; returns the exit code."""
    complaints = 0
    for fmu in fmus:
        for name, master in MASTERS.items():
            try:
                verdict = master(Path(fmu).resolve())
            except AbsentError as reason:
                verdict = f"skipped: {reason}"
            except subprocess.CalledProcessError as error:
                verdict = f"COMPLAINS: exit code {error.returncode}: {(error.stderr or error.stdout).strip()}"
                complaints += 1
            print(f"{Path(fmu).name}: {name}: {verdict}")
    return 1 if complaints else 0


def _libpython() -> Path:
    library = Path(sysconfig.get_config_var("LIBDIR") or "") / (sysconfig.get_config_var("INSTSONAME") or "absent")
    if library.suffix == ".a" or not library.is_file():
        raise AbsentError("this Python has no shared library")
    return library


def _outside_python() -> dict[str, str]:
    """The environment in which a host that is not Python finds Python, numpy and numba."""
    site = os.pathsep.join(path for path in sys.path if path.endswith("site-packages"))
    return os.environ | {"LD_PRELOAD": str(_libpython()), "PYTHONPATH": site}


def _run(*command: object, environment: dict[str, str] | None = None, cwd: str | None = None) -> str:
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, cwd=cwd, check=False)
    text = done.stdout + done.stderr
    if done.returncode or any(word in text.lower() for word in ("[error]", "[warning]", "[fatal]", "traceback")):
        raise subprocess.CalledProcessError(done.returncode, words, done.stdout, text)
    return text.strip()


def _found(name: str) -> str:
    path = shutil.which(name)
    if path is None:
        raise AbsentError(f"no {name} on the PATH")
    return path


def c_host(fmu: Path) -> str:
    """Status, state and exit of a process that starts Python by itself."""
    compiler = _found("cc")
    description = read_model_description(str(fmu))
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    identifier = description.coSimulation.modelIdentifier
    with tempfile.TemporaryDirectory() as folder:
        host = Path(folder) / "host"
        _run(compiler, "-O1", "-Wall", "-o", host, HERE / "host.c", "-ldl")
        unpacked = Path(extract(str(fmu), Path(folder) / "fmu"))
        library = unpacked / "binaries" / "linux64" / f"{identifier}.so"
        said = _run(
            *(host, library, f"file://{unpacked}/resources", description.guid),
            *(references["base.ax"], references["block[1].ux"]),
            environment=_outside_python(),
        )
        return f"the same twice: {said}"


def pyfmi(fmu: Path) -> str:
    """Loading and 20 s with PyFMI's own master."""
    if importlib.util.find_spec("pyfmi") is None:
        raise AbsentError("pyfmi is not installed")
    with tempfile.TemporaryDirectory() as folder:
        return _run(sys.executable, CHILD, "inside.masters", "pyfmi", json.dumps([[str(fmu)], {}]), cwd=folder)


def fmusim(fmu: Path) -> str:
    """A run, and one in two parts through a state file."""
    program = _found("fmusim")
    with tempfile.TemporaryDirectory() as folder:
        common = ["--interface-type", "cs", "--output-interval", "0.01"]
        environment = _outside_python()
        _run(program, *common, "--stop-time", "2", "--output-file", "a.csv", fmu, environment=environment, cwd=folder)
        half = ["--stop-time", "1", "--final-fmu-state-file", "half.bin", "--output-file", "b.csv"]
        _run(program, *common, *half, fmu, environment=environment, cwd=folder)
        rest = ["--start-time", "1", "--stop-time", "2", "--initial-fmu-state-file", "half.bin"]
        _run(program, *common, *rest, "--output-file", "c.csv", fmu, environment=environment, cwd=folder)
        whole, second = (Path(folder, name).read_text().splitlines()[-1] for name in ("a.csv", "c.csv"))
        if whole != second:
            raise subprocess.CalledProcessError(0, [program], f"{whole} is not {second} after a restored state")
        return "runs, and goes on from its state"


def fmu_check(fmu: Path) -> str:
    """The FMU Compliance Checker."""
    program = _found("fmuCheck.linux64")
    _run(program, "-l", "4", "-h", "0.01", "-s", "1", "-o", os.devnull, fmu, environment=_outside_python())
    return "no complaint"


def vdm_check(fmu: Path) -> str:
    """The formal model of the FMI rules."""
    text = _run(_found("VDMCheck2.sh"), fmu)
    if "No errors found" not in text:
        raise subprocess.CalledProcessError(1, ["VDMCheck2.sh"], text)
    return "no errors found"


def omsimulator(fmu: Path) -> str:
    """OMSimulator from the command line."""
    with tempfile.TemporaryDirectory() as folder:
        program, environment = _found("OMSimulator"), _outside_python()
        _run(program, "--stopTime=2", "--stepSize=0.01", fmu, environment=environment, cwd=folder)
    return "runs"


MASTERS: dict[str, Callable[[Path], str]] = {
    "C host": c_host,
    "PyFMI": pyfmi,
    "fmusim": fmusim,
    "fmuCheck": fmu_check,
    "VDMCheck": vdm_check,
    "OMSimulator": omsimulator,
}


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
