"""One evaluation of eight columns, each on its own base."""

from typing import NamedTuple

from ..formulations.base import base_motion
from ..formulations.either import evaluate_at
from ..formulations.exact import Motion, exact_accelerations
from ..jit import by_width, kernel, leaf
from ..lanes import WIDTH, LanesType, any_of, lane, splat, where, with_lane
from ..layout import OK
from ..numbers import sine
from ..views import one_lane
from .runs import SPACE, samples_of

_space = SPACE.over


class Batch(NamedTuple):
    """Eight columns: the parts of SPACE over lanes by the names of a column, and the queue that they come from."""

    model: object
    state: object
    base: object
    work: object
    lane: object
    row: object
    queue: object


@leaf
def single(batch, k):
    """The space of lane k alone."""
    return _space(one_lane(batch.row, k), batch.model.n)


@kernel
def motion_of_lanes(batch, t):
    """Motion of the eight bases at the times t; they do not rotate."""
    base = batch.base
    past = t - base.t0
    ax = base.ax + base.jx * past
    az = base.az + base.jz * past
    waves = base.wave_amplitude != 0.0
    if any_of(waves):
        ax += base.wave_amplitude * sine(base.wave_omega * t + base.wave_phase)
    sampled = batch.lane.count > 0.0
    if any_of(sampled):
        sampled_ax, sampled_az = ax, az
        for k in range(WIDTH):
            one = single(batch, k)
            if one.lane.count > 0.0:
                motion = base_motion(one.base, samples_of(batch.queue, one.lane), lane(t, k))
                sampled_ax = with_lane(sampled_ax, k, motion.ax)
                sampled_az = with_lane(sampled_az, k, motion.az)
        ax = where(sampled, sampled_ax, ax)
        az = where(sampled, sampled_az, az)
    zero = splat(0.0)
    return Motion(ax, az, zero, zero, zero)


@kernel
def evaluate_lanes(batch, phase, t):
    """Accelerations of the eight columns at a phase and at the times t. Returns OK."""
    work = batch.work
    exact_accelerations(batch.model, phase, motion_of_lanes(batch, t), work.joints, work.hold, work.room)
    return OK


@by_width(evaluate_at)
def _choose(column, phase, t):
    if isinstance(t, LanesType):
        return lambda column, phase, t: evaluate_lanes(column, phase, t)
    return None
