"""Seconds until a first result, and the memory of a run, in processes of their own.

    python -m benchmarks.start [--python PYTHON] [--against FOLDER [--against-python OTHER]] [--repeats 7]
                               [--first-need]

Parts: the import, a first result of a column, a structure and lanes, each a whole process; the command `multiblock
simulate`; the start of a PythonFMU in FMPy; the memory of a run. PYTHON is another interpreter, as of an environment
that a wheel is installed in. With another checkout as FOLDER, installed for the interpreter OTHER, both are measured
by turns, and the ratio is printed. With `--first-need` each begins with an empty cache folder, so that it compiles what
it does not carry.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
COLUMN, STRUCTURE = "examples/columns/phocas-damped.toml", "examples/structures/trilith.toml"
_BEGIN = (
    "from multiblock import Column, Motion, Structure, simulate, simulate_many; motion = Motion.harmonic(0.5, 2.0, 1.0)"
)
MEMORY = "import resource; print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)"
_COLUMN = f"column = Column.from_toml({str(ROOT / COLUMN)!r})"
PROGRAMS = {
    "import multiblock": "import multiblock",
    "first result, column": f"{_BEGIN}; {_COLUMN}; simulate(column, motion).peaks",
    "first result, structure": f"{_BEGIN}; simulate(Structure.from_toml({str(ROOT / STRUCTURE)!r}), motion).peaks",
    "first result, lanes": f"{_BEGIN}; {_COLUMN}; simulate_many(column, [motion] * 16)",
}


def command_of(part: str, python: str, fmu: Path) -> list[str]:
    """Return the command line of a part."""
    if part in PROGRAMS:
        return [python, "-c", PROGRAMS[part]]
    if part == "multiblock simulate":
        motion = str(fmu.with_name("motion.csv"))
        return [python, "-m", "multiblock", "simulate", str(ROOT / COLUMN), motion, "--no-check"]
    rows = str(fmu.with_name("rows.csv"))
    return [python, "-m", "fmpy", "simulate", str(fmu), "--stop-time", "0.01", "--output-file", rows]


def once(command: Sequence[str], folder: Path, cache: str | None) -> float:
    """Return the seconds of the clock of a process. Raises subprocess.CalledProcessError."""
    environment = {name: value for name, value in os.environ.items() if name != "MULTIBLOCK_COMPILES"}
    environment |= {"PYTHONPATH": str(folder)} | ({} if cache is None else {"MULTIBLOCK_CACHE_DIR": cache})
    begun = time.perf_counter()
    pipes: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, env=environment, cwd=tempfile.gettempdir(), **pipes)
    _, said = process.communicate()
    taken = time.perf_counter() - begun
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command, stderr=said)
    return taken


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a row for each part: the shortest of all repeats."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--against-python", default=sys.executable)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--first-need", action="store_true")
    options = parser.parse_args(arguments)
    here = Path("/nonexistent") if options.python != sys.executable else ROOT  # what is installed there
    folders = [here, *([options.against] if options.against else [])]
    pythons = {here: options.python, options.against: options.against_python}
    with tempfile.TemporaryDirectory() as temporary:
        work = Path(temporary)
        (work / "motion.csv").write_text("time,base.ax\n0,0\n0.5,1\n1,0\n", encoding="utf-8")
        fmus = {folder: work / str(k) / "column.fmu" for k, folder in enumerate(folders)}
        for folder, fmu in fmus.items():
            fmu.parent.mkdir()
            (fmu.parent / "motion.csv").write_bytes((work / "motion.csv").read_bytes())
            source = ROOT if folder == here else folder
            python = sys.executable if folder == here else pythons[folder]
            build = [python, str(source / "build_fmu.py"), str(ROOT / COLUMN), "-o", str(fmu)]
            environment = os.environ | {"PYTHONPATH": str(source)}
            subprocess.run(build, check=True, stdout=subprocess.DEVNULL, env=environment, cwd=fmu.parent)
        parts = [*PROGRAMS, "multiblock simulate", "FMU in FMPy"]
        for part in parts[:-1] if options.first_need else parts:
            found: dict[Path, list[float]] = {folder: [] for folder in folders}
            for k in range(1 if options.first_need else options.repeats):
                for folder in folders:
                    cache = str(work / f"cache{k}{folders.index(folder)}{part[-6:]}") if options.first_need else None
                    found[folder].append(once(command_of(part, pythons[folder], fmus[folder]), folder, cache))
            least = [min(found[folder]) for folder in folders]
            ratio = f"  {least[1] / least[0]:5.2f} times as long" if len(least) > 1 else ""
            print(f"{part:26s}" + "".join(f"{value:9.3f} s" for value in least) + ratio, flush=True)
        program = f"{PROGRAMS['first result, column']}; {MEMORY}"
        for folder in folders:
            environment = os.environ | {"PYTHONPATH": str(folder)}
            command = [pythons[folder], "-c", program]
            done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True, cwd=work)
            print(f"memory of a run, {folder}: {float(done.stdout):.0f} MB")


if __name__ == "__main__":
    main()
