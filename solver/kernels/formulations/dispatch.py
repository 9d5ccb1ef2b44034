"""One evaluation for both formulations, and quantities of blocks and joints in both."""

from typing import NamedTuple

from ..layout.spaces import EXACT, OK, ROTATES
from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import LanesType
from .base_motion import base_motion
from .exact import exact_accelerations, exact_top_motion
from .first_order import difference, paper_accelerations, tilt


class Column(NamedTuple):
    """A column in motion: the spaces and records of spaces.py, in the one order in which kernels take them."""

    model: object
    state: object
    counts: object
    base: object
    samples: object
    work: object


@leaf
def is_exact(model):
    """Whether the formulation is `exact`."""
    return model.settings.formulation == EXACT


@kernel
def evaluate(column, phase, motion):
    """Accelerations of a phase for a given motion of the base; work.joints holds the resultants. Returns a code.

    The iterated formulation takes the accelerations in the phase as its first guess.
    """
    model, work = column.model, column.work
    column.counts.evaluations += 1
    if is_exact(model):
        exact_accelerations(model, phase, motion, work.joints, work.hold, work.room)
        return OK
    if motion.theta != 0.0 or motion.omega != 0.0 or motion.alpha != 0.0:
        return ROTATES
    sweeps = paper_accelerations(model, phase, motion, work.joints, work.hold, work.room)
    if sweeps < 0:
        return sweeps
    column.counts.sweeps += sweeps
    return OK


@by_width
def evaluate_at(column, phase, t):
    """`evaluate` under the motion of the base at time t, for one column or for lanes (batch/)."""
    return None if isinstance(t, LanesType) else _evaluate_one_at


def _evaluate_one_at(column, phase, t):
    return evaluate(column, phase, base_motion(column.base, column.samples, t))


@by_width
def evaluate_stage(column, phase, t):
    """`evaluate_at` for a stage of a Runge-Kutta step, which has no guess of the accelerations yet."""
    if isinstance(t, LanesType):
        return lambda column, phase, t: evaluate_at(column, phase, t)
    return _evaluate_stage_of_one


def _evaluate_stage_of_one(column, phase, t):
    if not is_exact(column.model):
        start = column.work.start
        for i in range(column.model.n):
            phase.theta_acceleration[i] = start.theta_acceleration[i]
            phase.opening_acceleration[i] = start.opening_acceleration[i]
    return evaluate_at(column, phase, t)


@leaf
def rotation(model, row, i):
    """Rotation of block i relative to the base, rad clockwise, from the first coordinates; the base is block n.

    A row of their rates gives the rate.
    """
    if not is_exact(model):
        return tilt(model.blocks, row, i, model.n)
    return row[i] if i < model.n else 0.0


@leaf
def joint_opening(model, row, i):
    """Opening of joint i, m, from the last coordinates; a row of their rates gives the rate."""
    return row[i] if is_exact(model) else -difference(row, i, model.n)


@leaf
def reach_of(model, first, last, i):
    """Upper bound of block i's part of |u_x|, m, from these rows of coordinates; of its rate from rows of rates."""
    if is_exact(model):
        return model.blocks.height[i] * abs(first[i]) + abs(last[i])
    return abs(difference(first, i, model.n))


@kernel
def top_motion(model, phase, ux, rate, turn=0.0, spin=0.0):
    """Displacement (m) and velocity (m/s) of the top faces relative to the base: rows of n."""
    if is_exact(model):
        exact_top_motion(model, phase, ux, rate, turn, spin)
        return
    for i in range(model.n):
        ux[i] = phase.theta[i]
        rate[i] = phase.theta_rate[i]
