"""One evaluation of the accelerations: the solver's kernel, for one column and for eight at once, against others.

The others are the same arithmetic in C, and the earlier recursion (articulated.py), on the same states.
`python -m benchmarks.evaluation 3` prints the times of the kernel for 3 blocks, alone and in lanes; other instruction
sets are measured by such processes.
"""

from __future__ import annotations

import ctypes
import json
import math
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from llvmlite.binding import get_host_cpu_features

from solver import Column
from solver.kernels.column.formulations.exact import JOINT_ROW, Motion, exact_accelerations
from solver.kernels.column.joint import regimes
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext import numbers
from solver.kernels.numba_ext.jit import from_python, kernel
from solver.kernels.numba_ext.lanes import WIDTH
from solver.kernels.numba_ext.views import FieldTable, LayoutPart, Record, Space, lanes_of, row_of
from solver.models.column.lanes import aligned
from solver.models.column.packing import pack_model
from solver.models.column.stepper import Stepper

from . import articulated, timing
from .right_hand_side import Array
from .scenes import ROOT, G, shaft

SOURCE = Path(__file__).with_name("evaluation.c")
FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC")
SIZES = (3, 10, 50)  # blocks
STATES = 64  # evaluated in turn, from a run: few enough to stay in the fast memory, as those of a run do
SPACING = 0.03  # s between them
PASSES = 50  # over the states in one call; a call from Python into C costs more than a pass
SHORT, ROUNDS = 1e-3, 500  # s; lanes need many short rounds, since other work on the same core slows them down more
BASE = np.array([0.3, 0.0, 0.0, 0.0, 0.0])  # motion of the base: ax, az, theta, omega, alpha

# instruction sets that lanes are compiled for beside those of this processor, as LLVM names processors that have them
INSTRUCTION_SETS = {"AVX2": "haswell", "SSE2": "x86-64"}

SCRATCH = Space(joints=at.JOINTS, hold=at.HOLD, room=at.ROOM)  # of an evaluation
_model, _phase, _scratch = at.MODEL.over, at.PHASE.over, SCRATCH.over
PHASE_FIELDS = at.PHASE.per_n


# --- the kernel


@kernel
def _repeat(n, model, phases, count, rounds, scratch, motion):
    column, room = _model(model, n), _scratch(scratch, n)
    for _ in range(rounds):
        for k in range(count):
            phase = _phase(phases[PHASE_FIELDS * n * k :], n)
            exact_accelerations(column, phase, motion, None, None, room.joints, room.hold, room.room)


@from_python
def repeat(n, model, phases, rounds, base, scratch):
    """Compute the accelerations of the phases, flat, one after the other, `rounds` times."""
    motion = Motion(base[0], base[1], base[2], base[3], base[4])
    count = phases.size // (PHASE_FIELDS * n)
    _repeat(n, row_of(model), row_of(phases), count, rounds, row_of(scratch), motion)


@from_python
def repeat_in_lanes(n, model, phases, rounds, base, scratch):
    """Run `repeat` for phases (..., 8), flat, of eight columns at once, and models, scratch and base (..., 8)."""
    lanes = lanes_of(base)
    motion = Motion(lanes[0], lanes[1], lanes[2], lanes[3], lanes[4])
    count = phases.size // (PHASE_FIELDS * n * WIDTH)
    _repeat(n, lanes_of(model), lanes_of(phases), count, rounds, lanes_of(scratch), motion)


def scratch(n: int) -> Array:
    """Return scratch arrays of one evaluation."""
    return np.zeros(SCRATCH.size(n))


def phase_of(q: Array, rate: Array) -> Array:
    """Return the phase of a column with these coordinates and rates (2n,); accelerations and slips are zero."""
    return np.concatenate([q, rate, np.zeros(at.PHASE.size(len(q) // 2) - 2 * len(q))])


def in_lanes(rows: Array, size: int) -> Array:
    """Return the rows of `size` numbers, flat, in groups of eight columns: number i of all eight, then number i + 1."""
    return np.ascontiguousarray(rows.reshape(-1, WIDTH, size).swapaxes(1, 2)).ravel()


def lined_up(lanes: Array) -> Array:
    """Return a copy aligned in memory as the lanes of runs are."""
    copy = aligned(lanes.size)
    copy[:] = lanes
    return copy


def out_of_lanes(lanes: Array, size: int) -> Array:
    """Return the inverse of `in_lanes`."""
    return np.ascontiguousarray(lanes.reshape(-1, size, WIDTH).swapaxes(1, 2)).ravel()


def states_of_a_run(column: Column, count: int = STATES, spacing: float = SPACING) -> Array:
    """Return the phases, flat, that a rocking column passes through, `spacing` s apart: branches as in a run."""
    stepper = Stepper(column)
    stepper.base.wave_amplitude = 0.1 * G
    stepper.base.wave_omega = 2.0 * math.pi
    size = at.PHASE.size(column.n)
    phases = np.empty((count, size))
    for k in range(count):
        stepper.advance(k * spacing, spacing)
        phases[k] = stepper.arrays.state[at.CONTROL.beside :][:size]
    return phases.ravel()


# --- the functions that are timed: compiled loops over all phases in turn, PASSES times


def kernel_loop(column: Column, phases: Array) -> Callable[[], None]:
    """Return the solver's kernel for one column."""
    n, model, room = column.n, pack_model(column).copy(), scratch(column.n)
    repeat(n, model, phases, 1, BASE, room)
    return lambda: repeat(n, model, phases, PASSES, BASE, room)


def lanes_loop(column: Column, phases: Array) -> Callable[[], None]:
    """Return the solver's kernel in lanes: eight columns of one kind in eight of the phases, which stay unchanged."""
    n = column.n
    model = lined_up(np.repeat(pack_model(column), WIDTH))
    base, room = lined_up(np.repeat(BASE, WIDTH)), lined_up(np.repeat(scratch(n), WIDTH))
    lanes = lined_up(in_lanes(phases, at.PHASE.size(n)))
    repeat_in_lanes(n, model, lanes, 1, base, room)
    return lambda: repeat_in_lanes(n, model, lanes, PASSES, base, room)


def articulated_loop(column: Column, phases: Array) -> Callable[[], None]:
    """Return the earlier recursion."""
    rows, n, gravity, room = articulated.rows_of(column), column.n, column.g, articulated.scratch_of(column)
    base = tuple(BASE.tolist())
    articulated.repeat(rows, n, gravity, phases, 1, base, room)
    return lambda: articulated.repeat(rows, n, gravity, phases, PASSES, base, room)


def c_loop(library: Any, column: Column, phases: Array) -> Callable[[], None]:
    """Return the kernel's arithmetic in C."""
    model, room = pack_model(column).copy(), scratch(column.n)
    count = phases.size // at.PHASE.size(column.n)
    library.repeat(model, phases, count, 1, BASE, room)
    return lambda: library.repeat(model, phases, count, PASSES, BASE, room)


# --- C


def _definitions() -> list[str]:
    """Return the positions of fields in the arrays, for the compiler: number in a record, or first element for n
    blocks.
    """
    found: dict[str, Any] = {"SMALL": numbers.SMALL, "PHASE_FIELDS": PHASE_FIELDS, "JOINT_ROW": JOINT_ROW.beside}
    found |= {name: value for name, value in vars(regimes).items() if name.isupper()}

    def place(name: str, part: LayoutPart) -> None:
        if isinstance(part, Record):
            found.update({f"{name}_{field}": k for k, field in enumerate(part.fields)})
        elif isinstance(part, FieldTable):
            found.update({f"{name}_{field}(n)": f"({k}*(n))" for k, field in enumerate(part.fields)})
        elif isinstance(part, Space):
            per_n = beside = 0
            for key, inner in part.parts.items():
                found[f"{name}_{key}(n)"] = f"({per_n}*(n)+{beside})"
                per_n, beside = per_n + inner.per_n, beside + inner.beside

    tables = {"SETTINGS": at.SETTINGS, "BLOCKS": at.BLOCKS, "PHASE": at.PHASE, "JOINTS": at.JOINTS, "HOLD": at.HOLD}
    spaces = {"MODEL": at.MODEL, "SCRATCH": SCRATCH, "JOINT_ROW": JOINT_ROW}
    for name, part in (tables | spaces).items():
        place(name, part)
    return [f"-D{name.upper().replace('(N)', '(n)')}={value}" for name, value in found.items()]


def compiled_c(folder: Path) -> Any:
    """Return the library of evaluation.c, compiled into a folder. Raises OSError if it cannot be compiled."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise OSError("no C compiler")
    target = folder / "evaluation.so"
    command = [compiler, *FLAGS, *_definitions(), str(SOURCE), "-lm", "-o", str(target)]
    made = subprocess.run(command, capture_output=True, text=True)
    if made.returncode:
        raise OSError(f"{' '.join(command[:4])} ...: {made.stderr[-500:]}")
    library = ctypes.CDLL(str(target))
    array = np.ctypeslib.ndpointer(np.float64, flags="C")
    library.accelerations.argtypes = (array, array, array, array)
    library.repeat.argtypes = (array, array, ctypes.c_int, ctypes.c_int, array, array)
    library.accelerations.restype = library.repeat.restype = None
    return library


# --- measuring


def difference(one: Array, other: Array, n: int) -> float:
    """Return the largest difference of the accelerations in two arrays of phases, in parts of the largest of each
    phase.
    """
    mine, others = (phases.reshape(-1, PHASE_FIELDS * n)[:, 4 * n : 6 * n] for phases in (one, other))
    return float(np.max(np.abs(mine - others) / np.max(np.abs(mine), axis=1, keepdims=True)))


def instructions() -> str:
    """Return the instruction set that lanes use on this processor, by the names of the targets."""
    features = get_host_cpu_features()
    known = {"AVX-512": "avx512f", "AVX2": "avx2", "SSE2": "sse2"}
    return next((name for name, feature in known.items() if features.get(feature)), platform.machine())


def measure_kernel(sizes: tuple[int, ...] = SIZES) -> list[dict[str, Any]]:
    """Time of one evaluation by the kernel, alone and in lanes (a column), by number of blocks."""
    rows = []
    for n in sizes:
        column = shaft(n)
        phases = states_of_a_run(column)
        times = timing.loops([kernel_loop(column, phases), lanes_loop(column, phases)], SHORT, ROUNDS)
        one, lanes = (seconds / (PASSES * STATES) for seconds in times)
        rows.append({"n": n, "seconds": one, "lanes_seconds": lanes})
    return rows


def measure_lanes(sizes: tuple[int, ...]) -> dict[str, list[dict[str, Any]]]:
    """Run `measure_kernel` by instruction set: this processor's, and smaller ones in processes that compile
    for them.
    """
    found = {instructions(): measure_kernel(sizes)}
    if platform.machine() not in ("x86_64", "AMD64"):
        return found
    for name, processor in INSTRUCTION_SETS.items():
        if name in found:
            continue
        changed = {"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": "", "MULTIBLOCK_COMPILES": "1"}
        command = [sys.executable, "-m", "benchmarks.evaluation", *map(str, sizes)]
        done = subprocess.run(command, cwd=ROOT, env=os.environ | changed, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{name}: {done.stderr[-500:]}")
        found[name] = json.loads(done.stdout)
    return found


def round_ratio() -> float:
    """Return how many times as long an evaluation of three blocks takes if their joints are circles, not rectangles."""
    square = shaft(3)
    drums = Column("drums", tuple(replace(block, section="circle") for block in square.blocks))
    loops = [kernel_loop(column, states_of_a_run(column)) for column in (square, drums)]
    rectangles, circles = timing.loops(loops)
    return circles / rectangles


def measure(sizes: tuple[int, ...] = SIZES) -> dict[str, Any]:
    """Time of one evaluation by all of them, by number of blocks.

    If C cannot be compiled, `absent` gives the reason.
    """
    results: dict[str, Any] = {"flags": " ".join(FLAGS), "instructions": instructions(), "rows": []}
    library = None
    with tempfile.TemporaryDirectory() as folder:
        try:
            library = compiled_c(Path(folder))
        except OSError as error:
            results["absent"] = f"not available: {error}"
        for n in sizes:
            column = shaft(n)
            mine = states_of_a_run(column)
            old, other = mine.copy(), mine.copy()
            loops = [kernel_loop(column, mine), lanes_loop(column, mine), articulated_loop(column, old)]
            if library is not None:
                loops.append(c_loop(library, column, other))
            times = [seconds / (PASSES * STATES) for seconds in timing.loops(loops)]
            row = {"n": n, "seconds": times[0], "lanes_seconds": times[1], "articulated_seconds": times[2]}
            row |= {"articulated_difference": difference(mine, old, n)}
            if library is not None:
                row |= {"c_seconds": times[3], "ratio": times[0] / times[3], "difference": difference(mine, other, n)}
            results["rows"].append(row)
    results["round_ratio"] = round_ratio()
    return results


if __name__ == "__main__":
    print(json.dumps(measure_kernel(tuple(map(int, sys.argv[1:])) or SIZES)))
