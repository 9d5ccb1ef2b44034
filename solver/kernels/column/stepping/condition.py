"""The condition of the column: standing or overturned, at rest or not, in contact, rocking or in flight."""

import math

from ...engine.samples import is_silent
from ...layout.spaces import NOT_FINITE, OK, REST
from ...numba_ext.jit import kernel, leaf, varied_leaf
from ..formulations.base_motion import base_rotates
from ..integrators.interpolation import interpolate_phase
from ..joint.sliding import can_slide, slip_of
from ..sections.section import ends_of, full_stiffness

# Weight of openings in the scale of errors: an error that is small in flight is large at the landing.
FLIGHT_PART = 1e-3
SLID_OFF = 1e-9  # of the width: a narrower contact is none
HALVINGS = 40  # bisections of a step to locate the instant of overturning


@varied_leaf
def rotation(model, row, i):
    """Return the rotation of block i relative to the base (rad, clockwise) from the first coordinates; 0 if i = n."""
    return row[i] if i < model.n else 0.0


@kernel
def has_fallen(model, phase):
    """Return True if a block or its joint has turned beyond its angle of no return, or slid off its seat."""
    fallen = False
    below = 0.0
    for i in range(model.n - 1, -1, -1):
        # rotation of the block, and of the joint under it
        turn = rotation(model, phase.theta, i)
        limit = model.blocks.fall_angle[i]
        fallen = fallen or abs(turn - below) > limit or abs(turn) > limit
        if can_slide(model):
            left, right = ends_of(model.blocks, i, phase.slip[i])
            fallen = fallen or not left < right
        below = turn
    return fallen


@kernel
def fallen_joint(model, phase):
    """Return the number, from 1, of the joint whose block slid off its seat, else of that with the largest rotation."""
    widest = 0
    most = -1.0
    for i in range(model.n):
        if can_slide(model):
            left, right = ends_of(model.blocks, i, phase.slip[i])
            if right - left <= SLID_OFF * model.blocks.width[i]:
                return i + 1
        turned = abs(rotation(model, phase.theta, i) - rotation(model, phase.theta, i + 1))
        if turned > most:
            widest, most = i + 1, turned
    return widest


@kernel
def moment_of_overturning(column, h):
    """Return the fraction of the step of `h` s at which the column overturns, by bisection; fill `work.between`."""
    lo, hi = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (lo + hi)
        interpolate_phase(column.work, h, middle)
        if has_fallen(column.model, column.work.between):
            hi = middle
        else:
            lo = middle
    interpolate_phase(column.work, h, hi)
    return hi


@kernel
def take_stock(column, phase, h):
    """Update the scales of errors, the regime counters and the times in them after a step of `h` s to `phase`.

    Returns `OK`, or `NOT_FINITE` if an acceleration is not finite.
    """
    blocks, control, joints = column.model.blocks, column.state.control, column.work.joints
    turned = control.rotation_scale
    spun = control.rate_scale
    full, flight = True, False
    sum_all = 0.0
    for i in range(column.model.n):
        # largest rotation, rad, and rate, rad/s; openings and slips as equivalent rotations
        turned = max(turned, abs(phase.theta[i]))
        spun = max(spun, abs(phase.theta_rate[i]))
        opening = phase.opening[i]
        if opening > 0.0:  # an opening counts as the rotation about the other corner
            half_width = 0.5 * blocks.width[i]
            turned = max(turned, FLIGHT_PART * opening / half_width)
            spun = max(spun, abs(phase.opening_rate[i]) / half_width)
        if can_slide(column.model):
            per_slip = column.model.settings.per_slip
            turned = max(turned, abs(phase.slip[i] - blocks.offset[i]) * per_slip)
            spun = max(spun, abs(phase.slip_rate[i]) * per_slip)
            sum_all += phase.slip_acceleration[i]
        # contact over the full length, partial or none
        length = joints.length[i]
        left, right = ends_of(blocks, i, slip_of(column.model, phase, i)[0])
        full = full and length >= right - left
        flight = flight or not length > 0.0
        sum_all += phase.theta_acceleration[i] + phase.opening_acceleration[i]
    # store the scales, and the time spent in each kind of contact
    control.rotation_scale = turned
    control.rate_scale = spun
    column.counts.in_flight = 1 if flight else 0
    if full:
        control.time_full += h
    elif not flight:
        control.time_rocking += h
    else:
        control.time_flight += h
    # a coordinate or rate that is not finite makes the accelerations not finite too
    return OK if math.isfinite(sum_all) else NOT_FINITE


@leaf
def is_quiet(base, samples):
    """Return True if the base neither accelerates nor rotates, nor is tilted, until the present segment ends."""
    steady = base.ax == 0.0 and base.az == 0.0 and base.jx == 0.0 and base.jz == 0.0 and not base_rotates(base)
    if samples.size == 0:
        return steady and base.wave_amplitude == 0.0
    # the record: zero at both ends of the segment
    k = int(base.segment)
    if is_silent(samples, k):
        return steady
    still = samples.ax[k] == 0.0 and samples.az[k] == 0.0
    if not samples.held:
        still = still and samples.ax[k + 1] == 0.0 and samples.az[k + 1] == 0.0
    return steady and still and base.wave_amplitude == 0.0


@kernel
def rests(column, phase):
    """Return True if the column is at rest under its weight at `phase`, apart from a motion below the tolerance."""
    settings, blocks, control = column.model.settings, column.model.blocks, column.state.control
    if int(settings.without) & REST:
        return False
    turn = settings.tolerance * control.rotation_scale
    spin = settings.tolerance * control.rate_scale
    weight = 0.0
    for i in range(column.model.n):
        # rotation and opening of the joint under the weight above it
        weight += settings.gravity * blocks.mass[i]
        turned, settled = phase.theta[i], -weight / full_stiffness(blocks, i)
        if settings.off_axis != 0.0:
            turned, settled = turned - blocks.rest_turn[i], blocks.rest_opening[i]
        # deviations from the rest
        size = blocks.open_size[i]
        if can_slide(column.model) and (phase.sliding[i] != 0.0 or phase.slip[i] != blocks.offset[i]):
            return False  # a slip changes the rest
        if abs(turned) > turn or abs(phase.opening[i] - settled) > turn * size:
            return False
        if abs(phase.theta_rate[i]) > spin or abs(phase.opening_rate[i]) > spin * size:
            return False
    return True
