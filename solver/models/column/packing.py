"""A column as the flat arrays that the kernels read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.errors import InputError, shown
from ...common.ranges import has_masked
from ...kernels.column.api.engine import scratch_room
from ...kernels.column.model.description import (
    DETAILS,
    GIVEN,
    GIVEN_BLOCK,
    GIVEN_JOINT,
    GIVEN_SETTINGS,
    NO_REST,
    UNKNOWN_SECTION,
)
from ...kernels.layout import spaces as at
from ..protocol import NoRestError
from .block import Block
from .model import Column
from .settings import SKIP_CODES

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_of_block, _of_joint = attrgetter(*GIVEN_BLOCK), attrgetter(*GIVEN_JOINT)
_TOLERANCE, _WITHOUT = GIVEN_SETTINGS.fields.index("tolerance"), GIVEN_SETTINGS.fields.index("without")


@dataclass(frozen=True)
class InitialState:
    """The start of a run; None is rest, static equilibrium under gravity.

    All are sequences of n numbers, block 1 (the top) first, relative to the column as built.

    Attributes
    ----------
    rotation, rotation_rate
        The clockwise rotations (rad) and their rates (rad/s).
    opening, opening_rate
        The openings of the joint under each block along its normal (m, negative: compressed) and their rates (m/s).
    slip, slip_rate
        The slips of each block over the body under it, to +x (m), and their rates (m/s).
    """

    rotation: Sequence[float] | FloatArray | None = None
    rotation_rate: Sequence[float] | FloatArray | None = None
    opening: Sequence[float] | FloatArray | None = None
    opening_rate: Sequence[float] | FloatArray | None = None
    slip: Sequence[float] | FloatArray | None = None
    slip_rate: Sequence[float] | FloatArray | None = None


class Arrays(NamedTuple):
    """The flat arrays of a column or structure in motion: copying `state`, `counts` and `base` saves it.

    Their layout: kernels/layout/spaces.py, kernels/structure/layout.py.
    """

    model: FloatArray
    state: FloatArray
    counts: IntArray
    base: FloatArray
    work: FloatArray


def arrays_of(column: Column) -> Arrays:
    """Return the arrays of a column at rest.

    Raises InputError for a fixed step that is not stable, NoRestError for a column that cannot stand.
    """
    return copied(_assembled(column))


def arrays_at(column: Column, tolerance: float, without: int) -> Arrays:
    """Return the arrays at another tolerance, without the features whose codes sum to `without`; not cached."""
    given = described(column)
    given[_TOLERANCE], given[_WITHOUT] = tolerance, without
    return _assemble(column, given)


def copied(arrays: Arrays) -> Arrays:
    """Return a copy of the arrays."""
    return Arrays(
        arrays.model.copy(), arrays.state.copy(), arrays.counts.copy(), arrays.base.copy(), arrays.work.copy()
    )


def coordinates_of(rigid: FloatArray, slips: FloatArray, n: int) -> FloatArray:
    """Return coordinates and rates as in models/column/kinematics.py, (..., 4 n), or (..., 6 n) with slips.

    `rigid` begins with the first part of phases, `slips` with the second part; it may be empty.
    """
    moving = rigid[..., : 4 * n]
    if not slips.shape[-1]:
        return moving
    places = [(at.PHASE.fields.index(name) - at.RIGID_FIELDS) * n for name in ("slip", "slip_rate")]
    return np.concatenate([moving, *(slips[..., k : k + n] for k in places)], axis=-1)


def pack_model(column: Column) -> FloatArray:
    """Return the packed model, read-only (layout/spaces.py, MODEL).

    Raises InputError for a fixed step that is not stable, NoRestError for a column that cannot stand.
    """
    return _assembled(column).model


@lru_cache(maxsize=64)
def _assembled(column: Column) -> Arrays:
    made = _assemble(column, described(column))
    for array in made:
        array.flags.writeable = False
    return made


def _assemble(column: Column, given: FloatArray) -> Arrays:
    n, ports = column.n, len(column.ports)
    made = Arrays(
        np.zeros(at.model_room(n) + at.PORTS.size(ports)),
        np.zeros(at.STATE.size(n) + at.SPOTS.size(ports)),
        np.zeros(at.COUNTS.beside, dtype=np.int64),
        np.zeros(at.BASE.beside + 2 * len(at.LOAD) * ports),
        np.zeros(at.work_size(n, ports)),
    )
    detail = np.zeros(DETAILS)
    code = column.kind.entries.assemble(n, *made, given, 1, np.zeros(scratch_room(n)), detail)
    if code == NO_REST:
        as_they_are = "its blocks, offset or inclined as they are, have no stable rest under their weight"
        if column.other_law:
            as_they_are = f"with joint.{column.other_law} as it is a joint does not carry the weight above it at rest"
        raise NoRestError(f"{column.name} cannot stand: {as_they_are}")
    if code == UNKNOWN_SECTION:
        raise InputError(f"block[{int(detail[0])}]: solver/kernels/sections has no kernels of its section or contact")
    if code != at.OK:  # the column has made the other checks
        raise InputError(f"block[{int(detail[0])}].inertia: beyond the range of float64")
    if column.kind.fixed:
        column.kind.check_step(column)
    return made


def described(column: Column) -> FloatArray:
    """Return the column as `engine.assemble` reads it: settings, then a record for each block."""
    settings = column.settings
    # settings
    values = {
        "g": column.g,
        "step": settings.step,
        "tolerance": settings.tolerance,
        "without": sum(SKIP_CODES[name] for name in set(settings.without)),
        "drive": at.ACCELERATION,
        "slope": at.SLOPE_PARABOLA,
        "bodies": 0.0,
        "ports": float(len(column.ports)),
        "bonded": float(column.is_brittle),
    }
    given = [values[name] for name in GIVEN_SETTINGS.fields]
    # a record for each block, then the ports
    for block in column.blocks:
        given += [value or 0.0 for value in (*_of_block(block), *_of_joint(block.joint))]
        given += shape_of(block)
    assert len(given) == GIVEN_SETTINGS.beside + GIVEN.beside * column.n
    given += ports_of(column).tolist()
    return np.array(given, dtype=np.float64)


def shape_of(block: Block) -> list[float]:
    """Return the numbers of a block's shape and of the contact under it (description.py, GIVEN_SHAPE)."""
    strips = block.joint.strips or ()
    unused = [0.0] * (at.MOST_STRIPS - len(strips))
    return [*block.shape, float(block.joint_section), block.joint_bore, float(len(strips)), *strips, *unused]


def carried_weights(column: Column) -> FloatArray:
    """Return the weight that each joint carries at rest, N (n,) from the top joint down."""
    return column.g * np.cumsum([block.mass for block in column.blocks])


def settlements(column: Column) -> FloatArray:
    """Return the compression of each joint at rest under gravity, m (n,) from the top joint down."""
    return carried_weights(column) / np.array(column.springs)


def ports_of(column: Column) -> FloatArray:
    """Return the ports of a column as the kernels read them (layout/spaces.py, PORTS)."""
    rows = [[float(port.body), *port.at] for port in column.ports]
    return np.array(rows).reshape(-1, at.PORTS.per_n).T.ravel()


def set_initial(column: Column, state: FloatArray, initial: InitialState) -> None:
    """Set an initial state in `state`, which holds the rest as assembled.

    Raises InputError if `initial` does not suit the column.
    """
    if not isinstance(initial, InitialState):
        raise InputError(f"initial = {shown(initial)}: must be an InitialState")
    n = column.n
    phase = at.STATE.see(state, n).phase
    # values that are not given are those at rest
    at_rest = (np.zeros(n), -settlements(column))
    if column.off_axis:
        at_rest = (phase.theta.copy(), phase.opening.copy())
    rotation = _given("rotation", initial.rotation, at_rest[0])
    _within("rotation", rotation, np.full(n, 0.5 * np.pi), "a quarter turn either way at most, in rad")
    spin = _given("rotation_rate", initial.rotation_rate, np.zeros(n))
    opening = _given("opening", initial.opening, at_rest[1])
    heights = np.array([block.height for block in column.blocks])
    _within("opening", np.minimum(opening, 0.0), heights, "no deeper than the block is high, in m")
    opening_rate = _given("opening_rate", initial.opening_rate, np.zeros(n))
    # slips, relative to the offsets as built
    never = np.array([block.joint.friction is None for block in column.blocks])
    whole = np.array([block.joint.is_brittle for block in column.blocks])
    for key in ("slip", "slip_rate"):
        given = _given(key, getattr(initial, key), np.zeros(n))
        _within(key, given, np.where(never, 0.0, np.inf), "zero where the joint has no friction: it never slides")
        _within(key, given, np.where(whole, 0.0, np.inf), "zero where the joint is bonded: it slides once it breaks")
        getattr(phase, key)[:] = given
    phase.slip += np.array([block.joint.offset or 0.0 for block in column.blocks])
    phase.sliding[:] = np.sign(phase.slip_rate)
    # conversion to the coordinates of the formulation
    coordinates = column.kind.chain.coordinates
    phase.theta[:], phase.opening[:] = coordinates(heights, rotation, opening)
    phase.theta_rate[:], phase.opening_rate[:] = coordinates(heights, spin, opening_rate)


def _given(key: str, values: Sequence[float] | FloatArray | None, default: FloatArray) -> FloatArray:
    if values is None:
        return default
    gaps = has_masked(values)
    try:
        array = np.asarray(values)
    except ValueError:  # ragged
        array = np.array(None)
    if gaps or array.dtype.kind not in "iuf" or array.shape != default.shape or not np.all(np.isfinite(array)):
        raise InputError(f"initial.{key} = {shown(values)}: must be {len(default)} finite numbers, one per block")
    return array.astype(np.float64)


def _within(key: str, values: FloatArray, limits: FloatArray, meaning: str) -> None:
    beyond = np.flatnonzero(np.abs(values) > limits)
    if beyond.size:
        i = int(beyond[0])
        raise InputError(f"initial.{key}[{i}] = {values[i]:g}: must be {meaning}")
