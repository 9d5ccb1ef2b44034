"""One evaluation of the accelerations: the solver's kernel against the same arithmetic in C, on the same states."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from solver import Column
from solver.kernels import exact
from solver.kernels import layout as at
from solver.kernels.exact import exact_accelerations
from solver.kernels.jit import OPTIONS
from solver.packing import pack_model
from solver.stepper import Stepper

from . import timing
from .right_hand_side import Array
from .scenes import G, shaft

SOURCE = Path(__file__).with_name("evaluation.c")
FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC")
SIZES = (3, 10, 50)  # blocks
STATES = 400  # evaluated in turn, from a run
SPACING = 5e-3  # s between them
PASSES = 25  # over the states in one call, which costs more from Python into C than a pass
BASE_AX = 0.3  # m/s2


def _definitions() -> list[str]:
    """Where things lie in the arrays, for the compiler."""
    places = {**vars(at), **vars(exact)}
    return [f"-D{name}={value!r}" for name, value in places.items() if name.isupper() and type(value) in (int, float)]


def compiled_c(folder: Path) -> Any:
    """The C of evaluation.c, compiled into a folder. Raises OSError where that cannot be done."""
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


@njit(**OPTIONS)
def repeat(model, phases, rounds, scratch):
    """`rounds` times the accelerations of the phases (count, 6n), flat, one after the other."""
    size = 6 * int(model[at.N_BLOCKS])
    for _ in range(rounds):
        for k in range(phases.size // size):
            exact_accelerations(model, phases, k * size, (BASE_AX, 0.0, 0.0, 0.0, 0.0), scratch, 0)


def states_of_a_run(column: Column, count: int = STATES, spacing: float = SPACING) -> Array:
    """Phases (count * 6n,) that a rocking column passes through, `spacing` s apart: branches as in a run."""
    stepper = Stepper(column)
    stepper.inputs[at.INPUT_AMPLITUDE] = 0.1 * G
    stepper.inputs[at.INPUT_OMEGA] = 2.0 * math.pi
    phases = np.empty((count, 6 * column.n))
    for k in range(count):
        stepper.advance(k * spacing, spacing)
        phases[k] = stepper.state[at.STATE_HEADER : at.STATE_HEADER + 6 * column.n]
    return phases.ravel()


def scratch(n: int) -> Array:
    """The scratch of the acceleration kernels."""
    return np.zeros(at.SCRATCH_FIELDS * n)


def kernel_loop(column: Column, phases: Array) -> Callable[[], None]:
    """The solver's kernel on all phases in turn, PASSES times, as a compiled loop to be timed."""
    model, room = pack_model(column), scratch(column.n)
    repeat(model, phases, 1, room)
    return lambda: repeat(model, phases, PASSES, room)


def c_loop(library: Any, column: Column, phases: Array) -> Callable[[], None]:
    """The same in C."""
    model, room = pack_model(column), scratch(column.n)
    count = phases.size // (6 * column.n)
    base = np.array([BASE_AX, 0.0, 0.0, 0.0, 0.0])
    library.repeat(model, phases, count, 1, base, room)
    return lambda: library.repeat(model, phases, count, PASSES, base, room)


def measure(sizes: tuple[int, ...] = SIZES) -> dict[str, Any]:
    """Time of one evaluation in both languages, by number of blocks."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            library = compiled_c(Path(folder))
        except OSError as error:
            return {"absent": f"not available: {error}"}
        rows = []
        for n in sizes:
            column = shaft(n)
            mine = states_of_a_run(column)
            other = mine.copy()
            python, c = (
                seconds / (PASSES * STATES)
                for seconds in timing.loops([kernel_loop(column, mine), c_loop(library, column, other)])
            )
            difference = float(np.max(np.abs(mine - other) / (np.abs(mine) + np.abs(other) + 1e-300)))
            rows.append({"n": n, "seconds": python, "c_seconds": c, "ratio": python / c, "difference": difference})
    return {"flags": " ".join(FLAGS), "rows": rows}
