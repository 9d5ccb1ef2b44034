"""Sliding joints in lanes: directions hold within a step, which ends where a joint starts or stops sliding.

As stepping/sliding.py and formulations/slips.py for one column. Where a slip stops is read from the interpolation of
that lane alone; where a joint starts takes evaluations, of all lanes at a time, each at its own instant. Lanes whose
columns have no slips are compiled without any of it.
"""

from ...engine import dormand_prince
from ...engine.interpolation import quintic_through, value_without_bump
from ...layout.spaces import PHASE, PHASE_FIELDS
from ...numba_ext.jit import by_width, kernel, leaf
from ...numba_ext.lanes import (
    WIDTH,
    any_of,
    bits,
    greater,
    lane,
    lesser,
    where,
    with_lane,
)
from ...numba_ext.views import copy
from ..formulations.slips import change_directions, shear_margin, stop_what_is_still
from ..integrators.interpolation import spent
from ..integrators.stage import stage
from ..joint.sliding import has_no_slips
from ..sections.section import ends_of
from ..stepping.sliding import NEAR, NEVER, any_passes_zero, first_stop
from .evaluate import evaluate_lanes, single

JUST_AFTER = 1.02  # factor on the time at which a slip is expected to stop
# of the step: tolerance of the instant at which a joint starts sliding. No force jumps there, so that the error is of
# second order in it
LATE = 1e-3
MOST_TRIALS = 30
PROBES = (1.0 / 3.0, 2.0 / 3.0)  # of the step: where a joint within its capacity at the end is examined
PLENTY = 1e300  # N
INSIDE = (2, 3, 4)  # inner stages
NODES = (dormand_prince.C2, dormand_prince.C3, dormand_prince.C4)  # their fractions of the step
_SLIP, _SLIP_RATE, _POWER = (PHASE.places[name][0] for name in ("slip", "slip_rate", "friction_power"))  # fields


# --- called by the stepping of lanes with or without slips


@by_width
def steps_to_stops(batch, step):
    """Return the steps (s), shortened to just after a joint is expected to stop."""
    return (lambda batch, step: step) if has_no_slips(batch.types[0]) else _steps_to_stops


@by_width
def end_at_changes(batch, step, good):
    """End the steps of the good lanes where a joint first starts or stops sliding.

    Returns the steps (s), and the mask of the lanes with a change.
    """
    if has_no_slips(batch.types[0]):
        return lambda batch, step, good: (step, good & ~good)
    return lambda batch, step, good: _end_at_changes(batch, step, good)


@by_width
def decide_slips(batch, changed):
    """Let the joints of the lanes in a mask stick or slide according to their forces, and fill their accelerations."""
    return (lambda batch, changed: None) if has_no_slips(batch.types[0]) else _decide


@by_width
def slid_off(model, phase, i):
    """Return the mask of the lanes in which block i has slid off its support."""
    if has_no_slips(model):
        return lambda model, phase, i: phase.theta[i] != phase.theta[i]
    return _slid_off


def _slid_off(model, phase, i):
    left, right = ends_of(model.blocks, i, phase.slip[i])
    return left >= right


# --- steps


def _steps_to_stops(batch, step):
    begin, joints = batch.work.start, batch.work.joints
    for i in range(batch.model.n):
        joints.overcome[i] = 0.0 * step
        # the instant just after a slip rate vanishes, by its present deceleration
        rate, slows = begin.slip_rate[i], begin.slip_acceleration[i]
        soon = JUST_AFTER * (-rate / slows)
        step = where((rate * slows < 0.0) & (soon < step), soon, step)
    return step


@kernel
def _end_at_changes(batch, step, good):
    work = batch.work
    # fraction of the step at which a joint starts
    cut = greater(_first_begins(batch, step, good), NEAR)
    # or stops, of the lanes in which one does
    looked_at = (stage(work, INSIDE[0]), stage(work, INSIDE[1]), stage(work, INSIDE[2]))
    passes = bits(good & any_passes_zero(work, looked_at))
    if passes != 0:
        for k in range(WIDTH):
            # lane k: the fraction of the step at which the first joint stops
            if (passes >> k) & 1:
                one = single(batch, k).work
                inside = (stage(one, INSIDE[0]), stage(one, INSIDE[1]), stage(one, INSIDE[2]))
                first = max(NEAR, first_stop(one, inside, NODES, lane(step, k)))
                cut = with_lane(cut, k, min(lane(cut, k), first))
    # cut the steps of these lanes: interpolated phase, evaluated there
    changed = good & (cut <= 1.0)
    if any_of(changed):
        end = work.end
        _interpolate(work, step, where(changed, cut, 1.0))
        n, between = work.n, work.between
        _copy_where(end.row, between.row, changed, 4 * n)  # coordinates and rates
        _copy_where(end.row[_SLIP * n :], between.row[_SLIP * n :], changed, 3 * n)  # slips, friction work, rates
        step = where(changed, cut * step, step)
        _copy_phase(between, end)
        evaluate_lanes(batch, between, batch.lane.t + step)
        _copy_where(end.accelerations, between.accelerations, changed, 2 * n)
        _copy_where(end.row[_POWER * n :], between.row[_POWER * n :], changed, 2 * n)  # and accelerations of slips
    # margin at the end of a whole step, and state of sliding there
    batch.lane.shear_margin = where(good & ~changed, batch.lane.shear_margin_ahead, batch.lane.shear_margin)
    copy(work.end.sliding, work.joints.sliding, work.n)
    return step, changed


@leaf
def _copy_where(to, row, lanes, count):
    """Copy the first `count` elements of `row` into `to` in the lanes of a mask."""
    for i in range(count):
        to[i] = where(lanes, row[i], to[i])


@leaf
def _copy_phase(to, phase):
    copy(to.row, phase.row, PHASE_FIELDS * to.n)


@kernel
def _interpolate(work, h, s):
    """Fill `work.between` with coordinates, rates and friction work at fractions s of the steps of `h` s."""
    n = work.n
    start, end, between = work.start, work.end, work.between
    # rotations, openings and slips
    for place in range(3 * n):
        i = place if place < 2 * n else 4 * n + place
        q0, v0, a0 = start.coordinates[i], start.rates[i], start.accelerations[i]
        q1, v1, a1 = end.coordinates[i], end.rates[i], end.accelerations[i]
        between.coordinates[i], rate = value_without_bump(quintic_through(h, q0, v0, a0, q1, v1, a1, 0.0), s)
        between.rates[i] = rate / h
    # friction work
    for i in range(7 * n, 8 * n):
        between.coordinates[i] = spent(work, i, h, s)


# --- starts of sliding


@leaf
def _least_margin(joints, n):
    """Return the least shear margin (N) of the joints that stick."""
    least = 0.0 * joints.shear_capacity[0] + PLENTY
    for i in range(n):
        least = where(joints.sliding[i] == 0.0, lesser(shear_margin(joints, i), least), least)
    return least


@kernel
def _margin_within(batch, step, s):
    """Return the least shear margin (N) of the joints that stick at fractions s of the steps (s)."""
    work = batch.work
    _interpolate(work, step, s)
    evaluate_lanes(batch, work.between, batch.lane.t + s * step)
    return _least_margin(work.joints, work.n)


@kernel
def _first_begins(batch, step, good):
    """Return the fraction of the step at which a sticking joint first exceeds its capacity; NEVER where none does."""
    work, n = batch.work, batch.work.n
    at_hi = _least_margin(work.joints, n)  # at the end, which was evaluated last
    batch.lane.shear_margin_ahead = at_hi
    # lanes in which a joint is or was beyond its capacity
    flagged = at_hi < 0.0
    for i in range(n):
        flagged = flagged | ((work.joints.sliding[i] == 0.0) & (work.joints.overcome[i] != 0.0))
    flagged = good & flagged
    # bracket of the zero of the margin
    lo, at_lo = 0.0 * step, greater(batch.lane.shear_margin, 0.0)
    hi = where(flagged & (at_hi < 0.0), 1.0 + lo, NEVER)
    unsure = flagged & (at_hi >= 0.0)
    if any_of(unsure):  # beyond the capacity at a stage, not at the end: the joint may start sliding in between
        # inner points, until the margin is negative
        for k in range(2):
            value = _margin_within(batch, step, 0.0 * step + PROBES[k])
            found = unsure & (value < 0.0)
            hi, at_hi = where(found, PROBES[k], hi), where(found, value, at_hi)
            unsure = unsure & ~found
            lo, at_lo = where(unsure, PROBES[k], lo), where(unsure, value, at_lo)
    return _narrow_brackets(batch, step, flagged & (hi <= 1.0), lo, hi, at_lo, at_hi)


@kernel
def _narrow_brackets(batch, step, open_, lo, hi, at_lo, at_hi):
    """Return the fractions hi, moved down to just after the zero of the shear margin, as in engine/bracket.py."""
    moved = 0.0 * lo  # the end that moved last: -1 or 1
    for _ in range(MOST_TRIALS):
        # lanes whose bracket is still wider than the accuracy
        width = hi - lo
        open_ = open_ & (width > LATE) & (-at_hi * width > LATE * (at_lo - at_hi))
        if not any_of(open_):
            break
        # false position, or bisection where that leaves the bracket
        trial = lo + width * (at_lo / (at_lo - at_hi)) + 0.5 * LATE
        trial = where((trial > lo) & (trial < hi), trial, 0.5 * (lo + hi))
        value = _margin_within(batch, step, where(open_, trial, 1.0))
        # narrow the brackets, halving the value of an end that stays
        below, above = open_ & (value < 0.0), open_ & ~(value < 0.0)
        at_lo = where(below & (moved > 0.0), 0.5 * at_lo, at_lo)
        at_hi = where(above & (moved < 0.0), 0.5 * at_hi, at_hi)
        hi, at_hi = where(below, trial, hi), where(below, value, at_hi)
        lo, at_lo = where(above, trial, lo), where(above, value, at_lo)
        moved = where(below, 1.0, where(above, -1.0, moved))
    return hi


# --- directions of sliding after a change


def _decide(batch, changed):
    _decide_for(batch, changed)


@kernel
def _decide_for(batch, changed):
    work, n = batch.work, batch.work.n
    begin, between, joints = work.start, work.between, work.joints
    if any_of(changed):
        # evaluate with the present directions
        _copy_phase(between, begin)
        stop_what_is_still(joints, between, n)
        evaluate_lanes(batch, between, batch.lane.t)
        # change directions until forces and rates agree with them
        for _ in range(2 * n + 2):
            if not any_of(changed & change_directions(joints, between, n)):
                break
            evaluate_lanes(batch, between, batch.lane.t)
        # keep the result in the lanes of the mask
        _copy_where(begin.accelerations, between.accelerations, changed, 2 * n)
        _copy_where(
            begin.row[_SLIP_RATE * n :], between.row[_SLIP_RATE * n :], changed, 3 * n
        )  # rates, power, accelerations
        for i in range(n):
            begin.sliding[i] = where(changed, joints.sliding[i], begin.sliding[i])
        batch.lane.shear_margin = where(changed, _least_margin(joints, n), batch.lane.shear_margin)
    copy(joints.sliding, begin.sliding, n)
