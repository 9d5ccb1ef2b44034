"""The column in motion, and the equations that other kernels dispatch to: here those of exact.py.

Where the type of its model is that of other equations, these have versions of their own (kernels/paper/).
"""

from typing import NamedTuple

from ...layout.spaces import OK
from ...numba_ext.jit import kernel, varied_leaf
from ..joint.resultants import bonds_of, is_bonded
from .base_motion import base_motion, base_turn, moved_and_loaded
from .exact import Motion, exact_accelerations, exact_top_motion
from .loads import loads_of, ports_of


class Column(NamedTuple):
    """A column in motion: the spaces and records of spaces.py, in the one order in which kernels take them."""

    model: object
    state: object
    counts: object
    base: object
    samples: object
    work: object


@kernel
def evaluate(column, phase, motion):
    """Compute the accelerations of a phase for a motion of the base; return a code.

    `work.joints` holds the resultants of its joints.
    """
    work = column.work
    column.counts.evaluations += 1
    if work.loading.general != 0.0:
        _accelerate_general(column, phase, motion)
    else:
        exact_accelerations(column.model, phase, motion, None, None, work.joints, work.hold, work.room)
    return OK


@kernel
def _accelerate_general(column, phase, motion):
    """Compute the accelerations of a column with ports or mortar."""
    model, work = column.model, column.work
    joints, hold, room = work.joints, work.hold, work.room
    if not is_bonded(model):
        exact_accelerations(model, phase, motion, loads_of(column), None, joints, hold, room)
    elif ports_of(column) > 0:
        exact_accelerations(model, phase, motion, loads_of(column), bonds_of(model, joints), joints, hold, room)
    else:
        exact_accelerations(model, phase, motion, None, bonds_of(model, joints), joints, hold, room)


@varied_leaf
def evaluate_at(column, phase, t):
    """Evaluate a phase under the motion of the base at time t, for one column or for lanes (batch/); return a code."""
    if column.work.loading.general != 0.0:
        return _evaluate_general_at(column, phase, t)
    return evaluate(column, phase, base_motion(column, t))


@kernel
def _evaluate_general_at(column, phase, t):
    column.counts.evaluations += 1
    _accelerate_general(column, phase, moved_and_loaded(column, t))
    return OK


@varied_leaf
def base_as_shown(column, t):
    """Return the motion of the base at time t as far as output rows show it: its rotation, all of it with ports."""
    if ports_of(column) > 0:
        return moved_and_loaded(column, t)
    return Motion(0.0, 0.0, base_turn(column.base, t), 0.0, 0.0)


@varied_leaf
def top_motion(column, phase, ux, rate, turn, spin):
    """Fill `ux` and `rate` with displacement (m) and velocity (m/s) of the top faces relative to the base: rows of n.

    turn, spin: rotation of the base, rad clockwise, and its rate.
    """
    exact_top_motion(column.model, phase, ux, rate, turn, spin)


@varied_leaf
def reach_of(column, first, last, i):
    """Return an upper bound of block i's part of the magnitude of u_x (m).

    first, last: rows of coordinates; with rows of rates, the bound of its rate (m/s).
    """
    return column.model.blocks.height[i] * abs(first[i]) + abs(last[i])
