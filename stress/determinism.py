"""Equal input gives equal bits: in a second run, in threads, in another process, after a restore.

On other processors results are equal to rounding.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from solver import Column, Motion
from solver.models.column.stepper import Stepper

from .cases import Case, draw
from .energy import Array

ROOT = Path(__file__).resolve().parent.parent
ROWS = 20
STEP = 1e-3  # s, of the runs that are interrupted
DAMPED = Path(__file__).resolve().parent.parent / "examples" / "columns" / "phocas-damped.toml"

# parts that depend on the processor: machine code, the C library's functions, the linear algebra of the modes
PROCESSORS = {
    "machine code for any x86-64": {"MULTIBLOCK_LEVEL": "x86-64-v2"},
    "C library without FMA and AVX2": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"},
    "linear algebra for SSE3": {"OPENBLAS_CORETYPE": "Prescott"},
}


def small_case(seed: int, number: int) -> Case:
    """Return a case that ends soon."""
    return draw(seed, number, most_blocks=8)


def rows_of(case: Case) -> Array:
    """Return the output rows of a case, cut at a number of steps of the motion that any machine follows soon."""
    motion = case.motion
    stepper = Stepper(case.column)
    times = motion.start + np.linspace(0.0, motion.duration, ROWS)
    return stepper.rows_of(stepper.run(motion, motion.end, times))


def digest(seed: int, number: int) -> str:
    """Hash of the rows of a case; the reason if the solver gives up."""
    try:
        return hashlib.sha256(rows_of(small_case(seed, number)).tobytes()).hexdigest()
    except ValueError as error:
        return str(error)


def scene() -> tuple[Column, Motion]:
    """Return a damped column that rocks."""
    return Column.from_toml(DAMPED), Motion.harmonic(0.05 * 9.80665, 2.0, 5.0)


def scene_rows() -> list[list[float]]:
    """Return the displacements of `scene` every 0.1 s."""
    column, motion = scene()
    stepper = Stepper(column.with_settings(tolerance=1e-9))
    times = np.linspace(0.0, motion.duration, 51)
    rows: list[list[float]] = stepper.rows_of(stepper.run(motion, motion.duration, times))[:, : column.n].tolist()
    return rows


def restored(formulation: str, damping: bool) -> bool:
    """Return True if a run saved and restored at every hundredth step continues with equal bits."""
    column, _ = scene()
    column = column.with_settings(formulation=formulation)
    if not damping:
        blocks = tuple(replace(block, joint=replace(block.joint, damping=0.0)) for block in column.blocks)
        column = replace(column, blocks=blocks)

    def drive(stepper: Stepper, first: int, last: int) -> None:
        for k in range(first, last):
            stepper.drive(k * STEP, ax=1.5 * np.sin(0.0126 * k))
            stepper.advance(k * STEP, STEP)

    straight, broken = Stepper(column), Stepper(column)
    drive(straight, 0, 1000)
    for first in range(0, 1000, 100):
        drive(broken, first, first + 100)
        saved = [array.copy() for array in (broken.arrays.state, broken.arrays.counts, broken.arrays.base)]
        drive(broken, first + 100, first + 150)
        broken = Stepper(column)  # as in another process
        broken.arrays.state[:], broken.arrays.counts[:], broken.arrays.base[:] = saved
    return straight.arrays.state.tobytes() == broken.arrays.state.tobytes()


def elsewhere(function: str, *arguments: object, **environment: str) -> Any:
    """Return the result of a function of in_process.py in another process."""
    done = subprocess.run(
        [sys.executable, "-m", "stress.in_process", function, json.dumps(arguments)],
        cwd=ROOT,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def run(seed: int, count: int, processors: bool = True) -> dict[str, dict[str, object]]:
    """Return {name: {"tried", "failures"}}; "largest difference" of the peak where processors are compared."""
    numbers = range(count)
    first = [digest(seed, k) for k in numbers]
    results: dict[str, dict[str, object]] = {}

    def compare(name: str, others: list[str]) -> None:
        wrong = [f"case {seed}-{k}" for k in numbers if others[k] != first[k]]
        results[name] = {"tried": count, "failures": wrong}

    compare("again", [digest(seed, k) for k in numbers])
    with ThreadPoolExecutor(4) as pool:
        compare("in four threads", list(pool.map(lambda k: digest(seed, k), numbers)))
    compare("in another process", elsewhere("digests", seed, count, PYTHONHASHSEED="7"))
    ways = [(f, d) for f in ("exact", "paper") for d in (True, False)]
    wrong = [f"{way}" for way in ways if not restored(*way)]
    results["after a restore"] = {"tried": len(ways), "failures": wrong}
    if processors:
        here = np.array(scene_rows())
        for name, variables in PROCESSORS.items():
            there = np.array(elsewhere("scene_rows", **variables))
            difference = float(np.max(np.abs(there - here)) / np.max(np.abs(here)))
            failures = [] if difference < 1e-8 else [f"{difference:.2g} of the peak"]
            results[name] = {"tried": 1, "failures": failures, "largest difference": difference}
    return results
