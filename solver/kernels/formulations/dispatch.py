"""The column in motion, and the equations that other kernels dispatch to: here those of exact.py.

Where the type of its model is that of other equations, these have versions of their own (kernels/paper/).
"""

from typing import NamedTuple

from ..layout.spaces import OK
from ..numba_ext.jit import kernel, varied_leaf
from .base_motion import base_motion, base_turn
from .exact import Motion, exact_accelerations, exact_top_motion


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
    exact_accelerations(column.model, phase, motion, work.joints, work.hold, work.room)
    return OK


@varied_leaf
def evaluate_at(column, phase, t):
    """Evaluate a phase under the motion of the base at time t, for one column or for lanes (batch/); return a code."""
    return evaluate(column, phase, base_motion(column.base, column.samples, t))


@varied_leaf
def base_as_shown(column, t):
    """Return the motion of the base at time t as far as output rows show it: its rotation."""
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
