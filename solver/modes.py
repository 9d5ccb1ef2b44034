"""The column about its rest state, all joints in full contact: its natural frequencies."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .column import Column
from .errors import InputError, SolverError
from .kernels import layout as at
from .packing import FloatArray, InitialState, settlements
from .stepper import Stepper

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


def _frequency_squares(column: Column, compression: FloatArray) -> NDArray[Any]:
    """Eigenvalues of M^-1 K, 1/s2, from central differences of the undamped accelerations at that compression, m."""
    n = column.n
    undamped = replace(column, blocks=tuple(replace(b, joint=replace(b.joint, damping=0.0)) for b in column.blocks))
    stepper = Stepper(undamped.with_settings(integrator="auto"), InitialState(opening=-compression))
    blocks = stepper.model.blocks
    phase = stepper.state.phase
    between = at.WORK.see(stepper.arrays.work, n).between
    tilt = PART * float(np.min(2.0 * compression / blocks.width))
    rows = [*((phase.theta, k, blocks.turn_size[k]) for k in range(n))]
    rows += [*((phase.opening, k, blocks.open_size[k]) for k in range(n))]

    def accelerations(row: FloatArray, k: int, change: float) -> FloatArray:
        kept = row[k]
        row[k] += change
        stepper.observe(0.0)
        row[k] = kept
        return np.concatenate([between.theta_acceleration, between.opening_acceleration])

    stiffness = np.zeros((2 * n, 2 * n))
    for column_of, (row, k, size) in enumerate(rows):
        change = tilt * size
        difference = accelerations(row, k, change) - accelerations(row, k, -change)
        stiffness[:, column_of] = -difference / (2.0 * change)
    return np.asarray(np.linalg.eigvals(stiffness))
