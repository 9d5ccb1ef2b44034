"""A column as the flat arrays that the kernels read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .column import Column
from .errors import InputError
from .kernels import layout as at
from .kernels.assembly import derive_fields
from .modal import modal_data

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

FORMULATION_CODES = {"exact": at.EXACT, "paper": at.PAPER}
INTEGRATOR_CODES = {"auto": at.AUTO, "central-difference": at.CENTRAL_DIFFERENCE}
SKIP_CODES = {
    "elastic": at.ELASTIC,
    "rest": at.REST,
    "dashpots": at.DASHPOTS,
    "resultants": at.RESULTANTS,
    "implicit": at.IMPLICIT_METHOD,
}


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
    model[at.GRAVITY] = column.g
    model[at.FORMULATION] = FORMULATION_CODES[settings.formulation]
    model[at.INTEGRATOR] = INTEGRATOR_CODES[settings.integrator]
    model[at.STEP] = settings.step
    model[at.WITHOUT] = sum(SKIP_CODES[name] for name in set(settings.without))
    model[at.TOLERANCE] = settings.tolerance
    derive_fields(model)
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
