"""The column about its rest state, all joints in full contact: natural frequencies, and the longest stable step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .column import Column
from .errors import InputError, SolverError
from .kernels import layout as at
from .kernels.advance import observe_state
from .packing import FloatArray, InitialState, block_rows, pack_model, pack_state, settlements

LEAST_COMPRESSION = 1e-6  # m, that the joints are given to be in contact where gravity does not compress them
PART = 1e-2  # of the rotation that opens a joint: how far accelerations are differenced


def natural_frequencies(column: Column, formulation: str | None = None) -> FloatArray:
    """Undamped natural frequencies in Hz, ascending, (2 n,), gravity included.

    Raises InputError without gravity, which leaves the joints open at rest; SolverError if the rest state is unstable.
    """
    column = column.with_settings(formulation=formulation)
    if column.g == 0.0:
        raise InputError("g = 0.0: must be positive for joints that are in contact at rest")
    squares = _frequency_squares(column, settlements(column))
    if np.min(squares.real) <= 0.0:
        raise SolverError("the rest state is not stable: the joints are too soft for the weight above them")
    frequencies: FloatArray = np.sort(np.sqrt(squares.real)) / (2.0 * math.pi)
    return frequencies


def longest_stable_step(column: Column) -> float:
    """Stability limit of central differences in s: 2 / (omega (sqrt(1 + d^2) + d)), omega that of the highest mode.

    d = eta omega counts because rates are carried on explicitly: a mode x'' + eta omega^2 x' + omega^2 x = 0, stepped
    as in kernels/integrators/central_difference.py, reaches the amplification factor -1 where
    (omega h)^2 / 4 + d omega h = 1. Joints that open only become softer.
    """
    squares = _frequency_squares(column, np.maximum(settlements(column), LEAST_COMPRESSION))
    omega = math.sqrt(float(np.max(np.abs(squares))))
    d = omega * max(block.joint.damping for block in column.blocks)
    return 2.0 / (omega * (math.hypot(1.0, d) + d))


def _frequency_squares(column: Column, compression: FloatArray) -> NDArray[Any]:
    """Eigenvalues of M^-1 K, 1/s2, from central differences of the undamped accelerations at that compression, m."""
    n = column.n
    model = pack_model(column)
    rows = block_rows(model)
    rows[:, at.DAMPING] = 0.0
    state, counters = pack_state(column, InitialState(opening=-compression))
    inputs = np.zeros(at.INPUTS)
    work = np.zeros(at.work_size(n))
    row = np.zeros((1, at.row_size(n)))
    split = np.zeros(at.SPLIT)
    between = 6 * n * at.PHASE_BETWEEN
    tilt = PART * float(np.min(2.0 * compression / rows[:, at.JOINT_WIDTH]))
    changes = tilt * np.concatenate([rows[:, at.TURN_SIZE], rows[:, at.OPEN_SIZE]])

    def accelerations(k: int, change: float) -> FloatArray:
        moved = state.copy()
        moved[at.STATE_HEADER + k] += change
        code = observe_state(model, moved, counters, inputs, work, 0.0, row, split)
        if code != at.OK:
            raise SolverError("the accelerations about the rest state cannot be computed")
        return work[between + 4 * n : between + 6 * n].copy()

    stiffness = np.zeros((2 * n, 2 * n))
    for k, change in enumerate(changes):
        stiffness[:, k] = -(accelerations(k, change) - accelerations(k, -change)) / (2.0 * change)
    return np.asarray(np.linalg.eigvals(stiffness))
