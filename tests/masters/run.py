"""The FMUs of this project in the masters of this machine, as a table: `python tests/masters/run.py`.

    --folder FOLDER   where the FMUs are built, or were before (default: a temporary one)
    --master NAME     one row alone; may be repeated
    --structure FILE  a structure in space in place of the column, without the SSP

One column is run as PythonFMU, native with FMI 2.0, with FMI 3.0 and with FMI 3.0 without arrays: 2 s under a held 0.5
m/s2, in steps of 0.01 s; a number is the largest deviation of the base's forces from those of the PythonFMU under FMPy,
in parts of them. The SSP is examples/coupling's column on isolators, native: 0.3 s; the deviation is that from the same
calls made one by one in Python. The master in C runs it for 3 s and is held against the system solved as one too. Where
a master was not run the cell says why. Fetches nothing. Exit code 1 if one that is there fails.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, read_model_description

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support.child import CHILD_FILE
from support.inside import masters, systems
from support.processes import (
    EXAMPLE,
    ROOT,
    AbsentError,
    ComplaintError,
    called,
    found,
    needs,
    needs_ecos,
    run,
    versioned,
    with_example,
)

PYTHON, NATIVE, FMI_3, SCALARS, SSP = KINDS = (
    *("PythonFMU", "native, FMI 2.0", "native, FMI 3.0", "native, FMI 3.0, scalars"),
    "SSP, native",
)
BUILT = {PYTHON: "python.fmu", NATIVE: "native.fmu", FMI_3: "fmi3.fmu", SCALARS: "scalars.fmu", SSP: "coupled"}
OPTIONS = {
    PYTHON: (),
    NATIVE: ("--native", "--platforms", "linux64"),
    FMI_3: ("--native", "--fmi", "3", "--platforms", "x86_64-linux"),
    SCALARS: ("--native", "--fmi", "3", "--scalars", "--platforms", "x86_64-linux"),
}
HERE = Path(__file__).resolve().parent
FORCES = ["base.Fx", "base.Fz"]
STEPS = 300  # of the coupled system
IN_C = 3000  # of the same in C, which is held against the system solved as one too
AGREEMENT = 1e-9
COMPLAINTS = "[error] [warning] [fatal] traceback"
ONLY_2 = "knows FMI 1.0 and 2.0"
NO_SSP = "opens no SSP"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; returns the exit code."""
    parser = argparse.ArgumentParser(description="Run the FMUs of this project in the masters of this machine.")
    parser.add_argument("--folder", type=Path, help="where the FMUs are built, or were before")
    parser.add_argument("--master", action="append", choices=[*MASTERS], help="one row alone; may be repeated")
    parser.add_argument("--structure", type=Path, help="a structure in space in place of the column, without the SSP")
    options = parser.parse_args(arguments)
    kinds = KINDS[:-1] if options.structure else KINDS
    complaints = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.folder or Path(temporary)).resolve()
        build(folder, options.structure)
        print(f"| master | {' | '.join(kinds)} |\n|---|{'---|' * len(kinds)}")
        for name in options.master or MASTERS:
            cells = []
            for kind in kinds:
                try:
                    cells.append(MASTERS[name](kind, folder / BUILT[kind]))
                except AbsentError as reason:
                    cells.append(f"not run: {reason}")
                except ComplaintError as complaint:
                    cells.append(f"COMPLAINS: {complaint}")
                    complaints += 1
            print(
                f"| {versioned(name, PACKAGES.get(name))} | {' | '.join(' '.join(cell.split()) for cell in cells)} |",
                flush=True,
            )
    return 1 if complaints else 0


def build(folder: Path, structure: Path | None = None) -> None:
    """Build what is not there yet."""
    file = () if structure is None else (structure,)
    for kind, options in OPTIONS.items():
        if not (folder / BUILT[kind]).exists():
            run(sys.executable, ROOT / "build_fmu.py", *file, "-o", folder / BUILT[kind], *options)
    if structure is not None:
        return
    if not (folder / BUILT[SSP]).exists():
        run(
            *(sys.executable, EXAMPLE / "build.py", "-o", folder / BUILT[SSP]),
            *("--native", "--platforms", "linux64"),
            environment=with_example(),
        )


# --- environments


def _libpython() -> Path:
    library = Path(sysconfig.get_config_var("LIBDIR") or "") / (sysconfig.get_config_var("INSTSONAME") or "absent")
    if library.suffix == ".a" or not library.is_file():
        raise AbsentError("this Python has no shared library")
    return library


def _outside_python(kind: str) -> dict[str, str]:
    """Return the environment in which a host that is not Python finds Python, numpy and numba, where the FMU needs
    them.
    """
    if kind != PYTHON:
        return dict(os.environ)
    site = os.pathsep.join(path for path in sys.path if path.endswith("site-packages"))
    return os.environ | {"LD_PRELOAD": str(_libpython()), "PYTHONPATH": site}


def _knows(kind: str, **reasons: str) -> None:
    """Raise AbsentError where there is a reason not to run this kind: `fmi_3` or `ssp`."""
    reason = {FMI_3: reasons.get("fmi_3"), SCALARS: reasons.get("fmi_3"), SSP: reasons.get("ssp")}.get(kind)
    if reason:
        raise AbsentError(reason)


# --- agreement


def _agreement(seen: Any, expected: Any) -> str:
    seen, expected = np.atleast_2d(np.array(seen)), np.atleast_2d(np.array(expected))
    size = np.max(np.abs(expected), axis=0)
    apart = float(np.max(np.abs(seen - expected) / size))
    if not apart < AGREEMENT:
        raise ComplaintError(f"differs by {apart:.1e}")
    return f"{apart:.0e}" if apart else "the same bits"


def _forces(fmu: Path) -> Any:
    return called(masters.alone, fmu.with_name(BUILT[PYTHON]), FORCES)


def _system(way: Callable[..., object], folder: Path, *as_fmpy: bool) -> str:
    """Run a master that hands every value over once a step, and the same calls made one by one."""
    seen = called(way, folder, "isolator", STEPS)
    return _agreement(seen, called(systems.one_pass, folder, "isolator", STEPS, *as_fmpy))


# --- masters


def fmpy(kind: str, fmu: Path) -> str:
    if kind == SSP:
        return _system(systems.fmpy, fmu, True)
    way = masters.alone3 if kind in (FMI_3, SCALARS) else masters.alone
    return _agreement(called(way, fmu, FORCES), _forces(fmu))


def validation(kind: str, fmu: Path) -> str:
    _knows(kind, ssp="validates FMUs; the SSP is held to its schema in tests/coupling/test_coupling_hosts.py")
    return run(found("fmpy"), "validate", fmu)


def c_host(kind: str, fmu: Path) -> str:
    """Return the status, state and exit of a process that starts Python itself, or has none; coupled: master.c."""
    _knows(kind, fmi_3="tests/masters/host.c speaks FMI 2.0")
    compiler = found("cc")
    with tempfile.TemporaryDirectory() as folder:
        host = Path(folder) / "host"
        if kind == SSP:
            run(compiler, "-O1", "-Wall", "-o", host, EXAMPLE / "master.c", "-ldl")
            text = run(host, fmu / "in_c" / "isolated.txt", systems.STEP, IN_C * systems.STEP)
            rows = np.array([[float(word) for word in line.split(",")] for line in text.splitlines()])[1:, 1:]
            expected = np.array(called(systems.one_pass, fmu, "isolator", IN_C))[:, :2]
            truth = np.array(called(systems.as_one, fmu, "isolator", IN_C))
            apart = np.max(np.abs(rows - truth), axis=0) / np.max(np.abs(truth), axis=0)
            return f"master.c: {_agreement(rows, expected)}; from the system solved as one {np.max(apart):.0e}"
        run(compiler, "-O1", "-Wall", "-o", host, HERE / "host.c", "-ldl")
        description = read_model_description(str(fmu))
        references = {variable.name: variable.valueReference for variable in description.modelVariables}
        unpacked = Path(extract(str(fmu), Path(folder) / "fmu"))
        library = unpacked / "binaries" / "linux64" / f"{description.coSimulation.modelIdentifier}.so"
        run(
            *(host, library, f"file://{unpacked}/resources", description.guid),
            *(references["base.ax"], references["block[1].ux"]),
            environment=_outside_python(kind),
            bad=COMPLAINTS,
        )
    return "runs; the same bits from a restored state"


def libcosim(kind: str, fmu: Path) -> str:
    _knows(kind, fmi_3=f"{ONLY_2}; 0.0.6 ends with a signal under any FMU of FMI 3.0")
    needs("libcosimpy")
    if kind == SSP:
        return _system(systems.libcosim, fmu)
    return _agreement(called(masters.libcosim, fmu, FORCES), _forces(fmu))


def ecos(kind: str, fmu: Path) -> str:
    needs_ecos()
    if kind == SSP:
        return _system(systems.ecos, fmu)
    agreement = _agreement(called(masters.ecos, fmu, FORCES), _forces(fmu))
    if kind == SCALARS:
        outputs = ["block[1].ux", "joint[2].N"]
        expected = called(masters.alone, fmu.with_name(BUILT[PYTHON]), outputs)
        return f"{agreement}; of blocks and joints {_agreement(called(masters.ecos, fmu, outputs), expected)}"
    return f"{agreement}; knows no arrays" if kind == FMI_3 else agreement


def toolbox(kind: str, fmu: Path) -> str:
    _knows(kind, ssp="the container that it makes gives another motion; not looked into")
    needs("fmu_manipulation_toolbox")
    text = run(found("fmutool"), "-input", fmu, "-check", bad="error: warning:")
    if "seems to be compliant" not in text or "No semantic error" not in text:
        raise ComplaintError(text)
    return "compliant, no semantic error"


def pyfmi(kind: str, fmu: Path) -> str:
    """Load it, and run 20 s with PyFMI's own master."""
    needs("pyfmi")
    _knows(kind, fmi_3="co-simulation of FMI 2.0 only", ssp=NO_SSP)
    with tempfile.TemporaryDirectory() as folder:
        words = (sys.executable, CHILD_FILE, "inside.masters", "pyfmi", json.dumps([[str(fmu)], {}]))
        return run(*words, cwd=folder, environment=with_example(), bad=COMPLAINTS)


def _motion(folder: str) -> str:
    """Return a file of inputs: without one the base stays still, and the FMU warns that it was never shaken."""
    file = Path(folder) / "motion.csv"
    file.write_text('"time","base.ax"\n0,0\n0.5,0.5\n2,0.5\n', encoding="utf-8")
    return str(file)


def fmusim(kind: str, fmu: Path) -> str:
    """Make a run, and one in two parts through a state file."""
    program = found("fmusim")
    _knows(kind, ssp=NO_SSP)
    with tempfile.TemporaryDirectory() as folder:
        common = ["--interface-type", "cs", "--output-interval", "0.01", "--input-file", _motion(folder)]
        settings: dict[str, Any] = {"environment": _outside_python(kind), "cwd": folder, "bad": COMPLAINTS}
        run(program, *common, "--stop-time", "2", "--output-file", "a.csv", fmu, **settings)
        half = ["--stop-time", "1", "--final-fmu-state-file", "half.bin", "--output-file", "b.csv"]
        run(program, *common, *half, fmu, **settings)
        whole = Path(folder, "a.csv").read_text().splitlines()[-1]
        rest = ["--start-time", "1", "--stop-time", "2", "--initial-fmu-state-file", "half.bin"]
        try:
            run(program, *common, *rest, "--output-file", "c.csv", fmu, **settings)
        except ComplaintError as complaint:
            if "exit code -" in str(complaint):  # a signal: 0.0.39 hands over FMUState where &FMUState is wanted
                return "runs; ends by its own fault as it restores a state"
            raise
        second = Path(folder, "c.csv").read_text().splitlines()[-1]
        if whole != second:
            raise ComplaintError(f"{whole} is not {second} after a restored state")
    return "runs, and goes on from its state"


def fmu_check(kind: str, fmu: Path) -> str:
    """Run the FMU Compliance Checker."""
    program = found("fmuCheck.linux64")
    _knows(kind, fmi_3=ONLY_2, ssp=NO_SSP)
    with tempfile.TemporaryDirectory() as folder:
        options = ("-l", "4", "-h", "0.01", "-s", "1", "-i", _motion(folder), "-o", os.devnull)
        run(program, *options, fmu, environment=_outside_python(kind), bad=COMPLAINTS)
    return "no complaint"


def vdm_check(version: int) -> Callable[[str, Path], str]:
    """Run the formal model of the rules of one version of FMI."""

    def check(kind: str, fmu: Path) -> str:
        program = found(f"VDMCheck{version}.sh")
        _knows(kind, ssp=NO_SSP)
        if (kind in (FMI_3, SCALARS)) != (version == 3):
            raise AbsentError(f"checks FMI {version}.0")
        text = run(program, fmu)
        if "No errors found" not in text:
            raise ComplaintError(text)
        return "no errors found"

    return check


def omsimulator(kind: str, fmu: Path) -> str:
    """Run OMSimulator from the command line; coupled, tests/coupling/test_coupling_hosts.py compares its results."""
    program = found("OMSimulator")
    _knows(kind)
    if kind == FMI_3:
        raise AbsentError("takes arrays for single values; see the column of scalars")
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "result.csv"
        what = ("--mode=cs", fmu / "isolated.ssp") if kind == SSP else ("--stopTime=2", "--stepSize=0.01", fmu)
        settings: dict[str, Any] = {"environment": _outside_python(kind), "cwd": folder, "bad": COMPLAINTS}
        run(program, f"--resultFile={result}", *what, **settings)
        table = np.loadtxt(result, delimiter=",", skiprows=1, ndmin=2)
    instants = int(np.count_nonzero(np.diff(table[:, 0]) > 0.0)) + 1  # two rows each: the last has the values after it
    if not np.all(np.isfinite(table)):
        raise ComplaintError("there are numbers that are not finite")
    return f"runs; {instants} instants"


def openmodelica(kind: str, fmu: Path) -> str:
    found("omc")
    raise AbsentError("examples/modelica/ was never tried with it")


MASTERS: dict[str, Callable[[str, Path], str]] = {
    "FMPy": fmpy,
    "FMPy validate": validation,
    "C host": c_host,
    "libcosim": libcosim,
    "ecos": ecos,
    "FMU Manipulation Toolbox": toolbox,
    "PyFMI": pyfmi,
    "fmusim": fmusim,
    "fmuCheck": fmu_check,
    "VDMCheck2": vdm_check(2),
    "VDMCheck3": vdm_check(3),
    "OMSimulator": omsimulator,
    "OpenModelica": openmodelica,
}


PACKAGES = {
    "FMPy": "fmpy",
    "FMPy validate": "fmpy",
    "libcosim": "libcosimpy",
    "ecos": "ecospy",
    "FMU Manipulation Toolbox": "fmu-manipulation-toolbox",
    "PyFMI": "PyFMI",
    "OMSimulator": "OMSimulator",
}


if __name__ == "__main__":
    raise SystemExit(main())
