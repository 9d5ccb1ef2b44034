"""A column as the flat arrays that the kernels read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .column import Column
from .errors import InputError
from .kernels import layout as at
from .modal import modal_data

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

FORMULATION_CODES = {"exact": at.EXACT, "paper": at.PAPER}
INTEGRATOR_CODES = {"auto": at.AUTO, "central-difference": at.CENTRAL_DIFFERENCE}
SKIP_CODES = {"elastic": at.ELASTIC, "rest": at.REST, "dashpots": at.DASHPOTS, "resultants": at.RESULTANTS}
NO_DAMPING = 1e-300  # s: what a dashpot that does nothing is computed with

# Errors are measured against the largest rotation so far, and at least against this part of the rotation at which the
# base joint opens: a column at rest, or nearly, need not be followed digit by digit.
FLOOR = 1e-2

# Order 8 is the cheaper explicit method where the tolerance is tight, or where joint modes go on ringing because they
# are damped by less than this part of the critical damping.
TIGHT = 2e-5
LIGHTLY_DAMPED = 0.02
# The errors of steps add up: each is allowed this part of the tolerance that the user asks for.
STEP_PART = 0.1
LEAST_TOLERANCE = 1e-13

# A column has overturned when a block, or the joint under it, has turned by more than this many times the angle at
# which the block alone would stand on its edge (below that angle gravity still rights it), and by at least LEAST_FALL,
# at most a quarter turn.
FALL_MARGIN = 1.5
LEAST_FALL = 0.5  # rad


@dataclass(frozen=True)
class InitialState:
    """Where a run starts; None is rest, and for the openings static equilibrium under gravity.

    Sequences of n numbers, block 1 (the top) first: `rotation` rad clockwise, `rotation_rate` rad/s, `opening` m of
    the joint under each block along its normal (negative: compressed), `opening_rate` m/s.
    """

    rotation: Sequence[float] | FloatArray | None = None
    rotation_rate: Sequence[float] | FloatArray | None = None
    opening: Sequence[float] | FloatArray | None = None
    opening_rate: Sequence[float] | FloatArray | None = None


def pack_model(column: Column) -> FloatArray:
    """The packed model: header and one row of fields per block (see kernels/layout.py)."""
    n = column.n
    model = np.zeros(at.MODEL_HEADER + at.BLOCK_FIELDS * n)
    model[at.N_BLOCKS] = n
    rows = block_rows(model)
    for row, block in zip(rows, column.blocks, strict=True):
        row[at.HEIGHT] = block.height
        row[at.CENTROID] = block.resolved_centroid
        row[at.MASS] = block.mass
        row[at.INERTIA] = block.resolved_inertia
        row[at.STIFFNESS] = block.joint.stiffness
        row[at.JOINT_WIDTH] = block.joint_width
        row[at.JOINT_DEPTH] = block.joint_depth
        row[at.DAMPING] = block.joint.damping
    settings = column.settings
    if "dashpots" in settings.without:
        rows[:, at.DAMPING] = np.maximum(rows[:, at.DAMPING], NO_DAMPING)
    rows[:, at.OPEN_SIZE] = rows[:, at.JOINT_WIDTH] / math.sqrt(12.0)
    rows[:, at.TURN_SIZE] = 1.0
    if settings.formulation == "paper":
        rows[:, at.TURN_SIZE] = np.cumsum(rows[::-1, at.HEIGHT])[::-1]
    edge_angle = np.arctan2(0.5 * rows[:, at.JOINT_WIDTH], rows[:, at.CENTROID])
    rows[:, at.FALL_ANGLE] = np.clip(FALL_MARGIN * edge_angle, LEAST_FALL, 0.5 * math.pi)
    rows[:, at.PIVOT], rows[:, at.COUPLING] = factorized_horizontal_mass(rows)

    model[at.GRAVITY] = column.g
    model[at.FORMULATION] = FORMULATION_CODES[settings.formulation]
    model[at.INTEGRATOR] = INTEGRATOR_CODES[settings.integrator]
    model[at.STEP] = settings.step
    model[at.WITHOUT] = sum(SKIP_CODES[name] for name in set(settings.without))
    model[at.TOLERANCE] = max(LEAST_TOLERANCE, STEP_PART * settings.tolerance)
    # an upper bound of the joint modes, from each block between two stiff joints
    area = rows[:, at.JOINT_WIDTH] * rows[:, at.JOINT_DEPTH]
    spring = rows[:, at.STIFFNESS] * area
    spring[1:] += spring[:-1]
    fastest = math.sqrt(2.0 * float(np.max(spring / rows[:, at.MASS])))
    model[at.FIRST_STEP] = 0.1 / fastest
    ringing = 0.5 * float(np.max(rows[:, at.DAMPING])) * fastest < LIGHTLY_DAMPED
    model[at.EXPLICIT_ORDER] = 8 if ringing or settings.tolerance <= TIGHT else 5
    opening_rotation = 2.0 * settlements(column) / rows[:, at.JOINT_WIDTH]
    model[at.ROTATION_FLOOR] = max(1e-9, FLOOR * float(np.min(opening_rotation)))
    height = float(np.sum(rows[:, at.HEIGHT]))
    model[at.RATE_FLOOR] = model[at.ROTATION_FLOOR] * math.sqrt(max(column.g, 1e-3) / height)
    if settings.formulation == "exact" and settings.integrator == "auto":
        modal = modal_data(rows, column.g, model[at.TOLERANCE])
        if modal is not None:
            model[at.MODAL] = model.size
            model = np.concatenate([model, modal])
    return model


def block_rows(model: FloatArray) -> FloatArray:
    """The rows of fields of a packed model, (n, BLOCK_FIELDS): a view."""
    n = int(model[at.N_BLOCKS])
    return model[at.MODEL_HEADER : at.MODEL_HEADER + at.BLOCK_FIELDS * n].reshape(n, at.BLOCK_FIELDS)


def factorized_horizontal_mass(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """LDL' of the tridiagonal B' m B + C' H^-1 I H^-1 C (theory.md section 3): inverse pivots 1/kg and multipliers."""
    height, centroid = rows[:, at.HEIGHT], rows[:, at.CENTROID]
    mass, turning = rows[:, at.MASS], rows[:, at.INERTIA] / rows[:, at.HEIGHT] ** 2
    low, high = centroid / height, 1.0 - centroid / height
    diagonal = mass * low**2 + turning
    diagonal[1:] += mass[:-1] * high[:-1] ** 2 + turning[:-1]
    side = mass * low * high - turning  # between block i and block i + 1
    pivot = diagonal.copy()
    multiplier = np.zeros_like(pivot)
    for i in range(1, len(pivot)):
        multiplier[i] = side[i - 1] / pivot[i - 1]
        pivot[i] -= side[i - 1] * multiplier[i]
    return 1.0 / pivot, multiplier


def settlements(column: Column) -> FloatArray:
    """Compression of each joint at rest under gravity, m, (n,) from the top joint down."""
    carried = column.g * np.cumsum([block.mass for block in column.blocks])
    spring = [block.joint.stiffness * block.joint_width * block.joint_depth for block in column.blocks]
    settled: FloatArray = carried / np.array(spring)
    return settled


def pack_state(column: Column, initial: InitialState | None = None) -> tuple[FloatArray, IntArray]:
    """State and counters at the start of a run. Raises InputError if `initial` does not fit the column."""
    n = column.n
    initial = initial or InitialState()
    rotation = _given("rotation", initial.rotation, np.zeros(n))
    spin = _given("rotation_rate", initial.rotation_rate, np.zeros(n))
    opening = _given("opening", initial.opening, -settlements(column))
    opening_rate = _given("opening_rate", initial.opening_rate, np.zeros(n))
    state = np.zeros(at.state_size(n))
    phase = state[at.STATE_HEADER : at.STATE_HEADER + 4 * n].reshape(4, n)
    if column.settings.formulation == "exact":
        phase[:] = rotation, opening, spin, opening_rate
    else:
        height = np.array([block.height for block in column.blocks])
        phase[:] = (
            _from_base(height * rotation),
            -_from_base(opening),
            _from_base(height * spin),
            -_from_base(opening_rate),
        )
    return state, np.zeros(at.COUNTERS, dtype=np.int64)


def _from_base(steps: FloatArray) -> FloatArray:
    """Sum from the base up to each block."""
    summed: FloatArray = np.cumsum(steps[::-1])[::-1]
    return summed


def _given(key: str, values: Sequence[float] | FloatArray | None, default: FloatArray) -> FloatArray:
    if values is None:
        return default
    array = np.asarray(values, dtype=np.float64)
    if array.shape != default.shape or not np.all(np.isfinite(array)):
        raise InputError(f"initial.{key} = {values!r}: must be {len(default)} finite numbers, one per block")
    return array
