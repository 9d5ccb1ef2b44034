"""Natural frequencies of a column about its rest state, all joints in full contact, gravity included."""

from __future__ import annotations

import math

import numpy as np

from .column import Column
from .errors import SolverError
from .kernels import layout as at
from .kernels.advance import observe_state
from .packing import FloatArray, pack_model, pack_state


def natural_frequencies(column: Column, formulation: str | None = None) -> FloatArray:
    """Undamped natural frequencies in Hz, ascending, (2 n,).

    From central differences of the accelerations about static equilibrium, small enough to stay in full contact.
    Raises SolverError if the rest state is not stable (an imaginary frequency).
    """
    column = column.with_settings(formulation=formulation)
    n = column.n
    model = pack_model(column)
    rows = model[at.MODEL_HEADER :].reshape(n, at.BLOCK_FIELDS)
    rows[:, at.DAMPING] = 0.0
    state, counters = pack_state(column)
    inputs = np.zeros(at.INPUTS)
    work = np.zeros(at.work_size(n))
    row = np.zeros((1, at.row_size(n)))
    sizes = np.concatenate([rows[:, at.TURN_SIZE], rows[:, at.OPEN_SIZE]])
    between = 6 * n * at.PHASE_BETWEEN
    tilt = model[at.ROTATION_FLOOR]  # a small part of the rotation that opens a joint

    def accelerations(k: int, change: float) -> FloatArray:
        moved = state.copy()
        moved[at.STATE_HEADER + k] += change
        code = observe_state(model, moved, counters, inputs, work, 0.0, row)
        if code != at.OK:
            raise SolverError("the accelerations about the rest state cannot be computed")
        return work[between + 4 * n : between + 6 * n].copy()

    stiffness = np.zeros((2 * n, 2 * n))
    for k in range(2 * n):
        change = tilt * sizes[k]
        stiffness[:, k] = -(accelerations(k, change) - accelerations(k, -change)) / (2.0 * change)
    squares = np.linalg.eigvals(stiffness)
    if np.min(squares.real) <= 0.0:
        raise SolverError("the rest state is not stable: the joints are too soft for the weight above them")
    frequencies: FloatArray = np.sort(np.sqrt(squares.real)) / (2.0 * math.pi)
    return frequencies
