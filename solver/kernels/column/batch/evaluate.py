"""One evaluation of eight columns, each on its own base."""

from typing import NamedTuple

from ...layout.spaces import OK
from ...numba_ext.jit import kernel, leaf, varied_leaf
from ...numba_ext.lanes import (
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
from ...numba_ext.numbers import sine, sine_cosine
from ...numba_ext.views import one_lane
from ..formulations.base_motion import SOON, record_line
from ..formulations.dispatch import evaluate_at
from ..formulations.exact import Motion, exact_accelerations
from .runs import SPACE, samples_of

_space = SPACE.over


class Batch(NamedTuple):
    """Eight columns: the parts of SPACE over lanes by the names of a column, and the queue of their runs."""

    model: object
    state: object
    base: object
    work: object
    lane: object
    row: object
    queue: object


@varied_leaf
def single(batch, k):
    """Return the space of lane k alone."""
    return _space(one_lane(batch.row, k), batch.model.n)


@leaf
def anchor_waves(base, t):
    """Compute the sines and cosines of the harmonic parts at the times t (s)."""
    if any_of(base.wave_amplitude != 0.0):
        base.anchor_sine, base.anchor_cosine = sine_cosine(base.wave_omega * t + base.wave_phase)
        base.anchor = t


@leaf
def anchor_far_waves(base, t):
    """Recompute the sines in lanes whose anchor is too far from t, as formulations/base_motion.py, `anchor_wave`."""
    # lanes with a harmonic part and an anchor too far from t
    far = (base.wave_amplitude != 0.0) & ~(magnitude(base.wave_omega * (t - base.anchor)) <= 0.5 * SOON)
    if any_of(far):
        # sine and cosine of the phase at t
        sines, cosines = sine_cosine(base.wave_omega * t + base.wave_phase)
        base.anchor_sine = where(far, sines, base.anchor_sine)
        base.anchor_cosine = where(far, cosines, base.anchor_cosine)
        base.anchor = where(far, t, base.anchor)


@leaf
def wave_of_lanes(base, t):
    """Return the sines of the harmonic parts at the times t (s), as formulations/base_motion.py, `wave`."""
    # turn since the anchor, by the addition theorem with Taylor polynomials
    x = base.wave_omega * (t - base.anchor)
    y = x * x
    rise = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + y * (1.0 / 362880.0)))))
    dip = y * (-0.5 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40320.0))))
    found = base.anchor_sine + (base.anchor_sine * dip + base.anchor_cosine * rise)
    # far from the anchor
    far = magnitude(x) > SOON
    if any_of(far):
        found = where(far, sine(base.wave_omega * t + base.wave_phase), found)
    return found


@kernel
def _accelerations_of_lanes(batch, t):
    """Return the accelerations (m/s2) of the eight bases at the times t (s), along x and z; they do not rotate."""
    base = batch.base
    # straight lines of the records
    within = t - base.piece_begin
    ax = base.piece_ax + base.piece_jx * within
    az = base.piece_az + base.piece_jz * within
    late = bits(t > base.piece_end)
    if late != 0:  # a step crosses kinks of the straight lines
        for k in range(WIDTH):
            if (late >> k) & 1:
                # lane k: the segment of its record that contains t
                one = single(batch, k)
                samples = samples_of(batch.queue, one.lane)
                segment = int(one.base.segment)
                while 0 <= segment < samples.size - 2 and lane(t, k) > samples.times[segment + 1]:
                    segment += 1
                line_ax, _, line_az, _ = record_line(samples, segment, lane(t, k))
                ax = with_lane(ax, k, line_ax)
                az = with_lane(az, k, line_az)
    # harmonic parts
    if any_of(base.wave_amplitude != 0.0):
        ax += base.wave_amplitude * wave_of_lanes(base, t)
    return ax, az


@leaf
def motion_of_lanes(batch, t):
    """Return the motion of the eight bases at the times t (s)."""
    zero = splat(0.0)
    ax, az = _accelerations_of_lanes(batch, t)
    return Motion(ax, az, zero, zero, zero)


@kernel
def evaluate_lanes(batch, phase, t):
    """Fill the accelerations of the eight columns at `phase` and the times t (s). Returns OK."""
    work = batch.work
    exact_accelerations(batch.model, phase, motion_of_lanes(batch, t), None, None, work.joints, work.hold, work.room)
    return OK


@evaluate_at.version(lambda column, phase, t: isinstance(t, LanesType))
def _evaluate_lanes_at(column, phase, t):
    return evaluate_lanes(column, phase, t)
