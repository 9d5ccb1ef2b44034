"""One evaluation of eight columns, each on its own base."""

from typing import NamedTuple

from ..formulations.base_motion import SOON, record_line
from ..formulations.dispatch import evaluate_at
from ..formulations.exact import Motion, exact_accelerations
from ..layout.spaces import OK
from ..numba_ext.jit import kernel, leaf, varied_leaf
from ..numba_ext.lanes import (
    WIDTH,
    LanesType,
    any_of,
    bits,
    lane,
    magnitude,
    splat,
    where,
    with_lane,
)
from ..numba_ext.numbers import sine, sine_cosine
from ..numba_ext.views import one_lane
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


@varied_leaf
def single(batch, k):
    """The space of lane k alone."""
    return _space(one_lane(batch.row, k), batch.model.n)


@leaf
def anchor_waves(base, t):
    """Compute the sines of the harmonic parts at the times t."""
    if any_of(base.wave_amplitude != 0.0):
        base.anchor_sine, base.anchor_cosine = sine_cosine(base.wave_omega * t + base.wave_phase)
        base.anchor = t


@leaf
def anchor_far_waves(base, t):
    """Compute the sines in lanes whose last ones are too old; as formulations/base_motion.py, `anchor_wave`."""
    far = (base.wave_amplitude != 0.0) & ~(magnitude(base.wave_omega * (t - base.anchor)) <= 0.5 * SOON)
    if any_of(far):
        sines, cosines = sine_cosine(base.wave_omega * t + base.wave_phase)
        base.anchor_sine = where(far, sines, base.anchor_sine)
        base.anchor_cosine = where(far, cosines, base.anchor_cosine)
        base.anchor = where(far, t, base.anchor)


@leaf
def wave_of_lanes(base, t):
    """As formulations/base_motion.py, `wave`."""
    x = base.wave_omega * (t - base.anchor)
    y = x * x
    rise = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + y * (1.0 / 362880.0)))))
    dip = y * (-0.5 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40320.0))))
    found = base.anchor_sine + (base.anchor_sine * dip + base.anchor_cosine * rise)
    far = magnitude(x) > SOON
    if any_of(far):
        found = where(far, sine(base.wave_omega * t + base.wave_phase), found)
    return found


@kernel
def motion_of_lanes(batch, t):
    """Motion of the eight bases at the times t; they do not rotate."""
    base = batch.base
    within = t - base.piece_begin
    ax = base.piece_ax + base.piece_jx * within
    az = base.piece_az + base.piece_jz * within
    late = bits(t > base.piece_end)
    if late != 0:  # a step crosses kinks of the straight lines
        for k in range(WIDTH):
            if (late >> k) & 1:
                one = single(batch, k)
                samples = samples_of(batch.queue, one.lane)
                segment = int(one.base.segment)
                while 0 <= segment < samples.size - 2 and lane(t, k) > samples.times[segment + 1]:
                    segment += 1
                line_ax, _, line_az, _ = record_line(samples, segment, lane(t, k))
                ax = with_lane(ax, k, line_ax)
                az = with_lane(az, k, line_az)
    if any_of(base.wave_amplitude != 0.0):
        ax += base.wave_amplitude * wave_of_lanes(base, t)
    zero = splat(0.0)
    return Motion(ax, az, zero, zero, zero)


@kernel
def evaluate_lanes(batch, phase, t):
    """Accelerations of the eight columns at a phase and at the times t. Returns OK."""
    work = batch.work
    exact_accelerations(batch.model, phase, motion_of_lanes(batch, t), work.joints, work.hold, work.room)
    return OK


@evaluate_at.version(lambda column, phase, t: isinstance(t, LanesType))
def _evaluate_lanes_at(column, phase, t):
    return evaluate_lanes(column, phase, t)
