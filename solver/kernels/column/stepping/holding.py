"""Regimes of the joints, held constant within a step, and location of the first change of a regime in it.

The law of a joint is smooth within a regime and has a kink at a change: an edge parts, a corner closes. A step held in
the regimes of its start has smooth equations throughout, so that integrator and interpolation keep their order up to
the instant of the change, where the step is cut.
"""

from typing import NamedTuple

from ...engine.bracket import bracket, narrowed, trial_within
from ...engine.interpolation import Quintic, quintic_through, value_of
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.numbers import sine_cosine
from ..integrators.interpolation import quintic_of, refine, slips_of
from ..joint.regimes import ANY
from ..joint.resultants import margin_of, regime_of
from ..joint.sliding import can_slide, less_below, opening_felt, opening_rate_felt, slip_of

NO_CHANGE = 2.0  # a fraction of the step that is never reached
AHEAD = 1e-7  # of the step: the regime at a change is taken this much later
CLOSE_ENOUGH = 1e-6  # of the step: the error of continuing in the wrong regime is of the second order in it
MOST_TRIALS = 40
PREDICTIONS = 4  # trials
OVERSHOOT = 1.03  # a step that should end just beyond a change is made longer than expected by this factor,
AFTER = 0.01  # and by this part of the one proposed


@kernel
def hold(column, h):
    """Hold every joint in its regime at the start of a step of `h` s."""
    start, rows = column.work.start, column.work.hold
    slides = can_slide(column.model)
    ahead = AHEAD * h
    turn_below = 0.0
    spin_below = 0.0
    for i in range(column.model.n - 1, -1, -1):
        # motion of the joint slightly after the start
        turn = start.theta[i] + ahead * start.theta_rate[i]
        spin = start.theta_rate[i] + ahead * start.theta_acceleration[i]
        opening = start.opening[i] + ahead * start.opening_rate[i]
        opening_rate = start.opening_rate[i] + ahead * start.opening_acceleration[i]
        sine, cosine = sine_cosine(0.5 * (turn - turn_below))
        slope_rate = cosine * (spin - spin_below)
        slip = 0.0
        if slides:
            slip = start.slip[i] + ahead * start.slip_rate[i]
            slip_rate = start.slip_rate[i] + ahead * start.slip_acceleration[i]
            opening = opening_felt(opening, slip, 2.0 * sine)
            opening_rate = opening_rate_felt(opening_rate, slip, slip_rate, 2.0 * sine, slope_rate)
        # hold that regime
        regime = regime_of(column.model, column.work.joints, i, slip, opening, 2.0 * sine, opening_rate, slope_rate)
        rows.held[i] = regime
        rows.regime[i] = regime
        rows.outside[i] = 0
        turn_below = turn
        spin_below = spin


@kernel
def release(column):
    """Release the joints; keep the regimes that they were held in."""
    for i in range(column.model.n):
        column.work.hold.held[i] = ANY


@leaf
def _margin(column, i, regime, turn, opening, slip, spin, opening_rate, slip_rate):
    """Return the distance (m) of joint i from leaving a regime at a joint rotation `turn` (rad) of rate `spin`."""
    sine, cosine = sine_cosine(0.5 * turn)
    slope, slope_rate = 2.0 * sine, cosine * spin
    felt = opening_felt(opening, slip, slope)
    felt_rate = opening_rate_felt(opening_rate, slip, slip_rate, slope, slope_rate)
    return margin_of(column.model, column.work.joints, i, regime, slip, felt, slope, felt_rate, slope_rate)


@kernel
def _stays(column, phase, i, regime):
    """Return True if joint i is in a regime at `phase`."""
    model = column.model
    turn = less_below(phase.theta, i, model.n)
    spin = less_below(phase.theta_rate, i, model.n)
    slip, slip_rate = slip_of(model, phase, i)
    return _margin(column, i, regime, turn, phase.opening[i], slip, spin, phase.opening_rate[i], slip_rate) >= 0.0


@kernel
def _margin_ahead(column, start, i, regime, s):
    """Return the margin (m) of joint i in `s` seconds after `start`, by constant accelerations."""
    model, n = column.model, column.model.n
    turn, spin = less_below(start.theta, i, n), less_below(start.theta_rate, i, n)
    spin_rate = less_below(start.theta_acceleration, i, n)
    opening, opening_rate, rate_of_rate = start.opening[i], start.opening_rate[i], start.opening_acceleration[i]
    # parabolas
    turn += s * (spin + 0.5 * s * spin_rate)
    opening += s * (opening_rate + 0.5 * s * rate_of_rate)
    slip, slip_rate = slip_of(model, start, i)
    if can_slide(model):
        slip += s * (slip_rate + 0.5 * s * start.slip_acceleration[i])
        slip_rate += s * start.slip_acceleration[i]
    spin += s * spin_rate
    return _margin(column, i, regime, turn, opening, slip, spin, opening_rate + s * rate_of_rate, slip_rate)


@kernel
def expected_change(column, h):
    """Return the time (s) until just after a joint is expected to leave its regime, at most h.

    The prediction takes constant accelerations. A step that ends there loses little when it is cut, and its
    interpolation is accurate near the change.
    """
    model, start = column.model, column.work.start
    first = h
    for i in range(model.n):
        # is joint i expected to leave its regime before the earliest change so far?
        regime = column.work.hold.regime[i]
        hi = first
        at_hi = _margin_ahead(column, start, i, regime, hi)
        if at_hi >= 0.0:
            continue
        lo = 0.0
        at_lo = _margin_ahead(column, start, i, regime, lo)
        if at_lo <= 0.0:
            continue
        # false position with halved weights
        for _ in range(PREDICTIONS):
            trial = (lo * at_hi - hi * at_lo) / (at_hi - at_lo)
            at_trial = _margin_ahead(column, start, i, regime, trial)
            if at_trial < 0.0:
                hi, at_hi = trial, at_trial
                at_lo *= 0.5
            else:
                lo, at_lo = trial, at_trial
                at_hi *= 0.5
        first = hi
    return min(h, OVERSHOOT * first + AFTER * h)


class Course(NamedTuple):
    """The motion of a joint within a step: rotation (rad), opening (m) and slip (m)."""

    turn: Quintic
    opening: Quintic
    slip: Quintic


@leaf
def course_of(column, i, h):
    """Return the motion of joint i within the step of `h` s."""
    work, n = column.work, column.model.n
    # a joint that cannot slide has zero slip
    slip = quintic_through(h, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if can_slide(column.model):
        slip = quintic_of(work, slips_of(work)[0] + i, -1, h)
    return Course(quintic_of(work, i, i + 1 if i + 1 < n else -1, h), quintic_of(work, n + i, -1, h), slip)


@leaf
def margin_within(column, i, regime, course, s):
    """Return the margin (m) of joint i at fraction s of the step."""
    q, v = value_of(course.turn, s)
    o, o_rate = value_of(course.opening, s)
    slip, slip_rate = value_of(course.slip, s)
    return _margin(column, i, regime, q, o, slip, v, o_rate, slip_rate)


@kernel
def end_of_regime(column, i, regime, course, lo, hi):
    """Return the fraction of the step in (lo, hi) where the margin of joint i crosses zero; it is negative at hi."""
    # start the bracket where the margin is not negative
    at_lo = margin_within(column, i, regime, course, lo)
    if at_lo < 0.0:
        lo = 0.0
        at_lo = max(0.0, margin_within(column, i, regime, course, lo))
    at_hi = margin_within(column, i, regime, course, hi)
    known = bracket(lo, hi, at_lo, at_hi)
    for _ in range(MOST_TRIALS):
        if known.hi - known.lo <= CLOSE_ENOUGH:
            break
        trial = trial_within(known)
        known = narrowed(known, trial, margin_within(column, i, regime, course, trial))
    return known.hi


@kernel
def _bracket(column, looked_at, nodes, i, regime):
    """Return the fractions (lo, hi) of the step between which joint i leaves its regime; hi is NO_CHANGE if it stays.

    The three phases `looked_at` inside the step, at the fractions `nodes`, and its end are examined.
    """
    lo = 0.0
    # first phase inside at which the joint has left
    for k in range(3):
        if not _stays(column, looked_at[k], i, regime):
            return lo, nodes[k]
        lo = nodes[k]
    if _stays(column, column.work.end, i, regime):
        return lo, NO_CHANGE
    return lo, 1.0


@kernel
def first_change(column, looked_at, nodes, t, h):
    """Return the fraction of the step at which a joint first leaves its held regime; NO_CHANGE if none does.

    Parameters
    ----------
    column : Column
        The column after the attempted step.
    looked_at : tuple of 3 phases
        Phases inside the step, for joints that leave and return.
    nodes : tuple of 3 floats
        Fractions of the step at which these are.
    t, h : float
        Start and length of the step (s).
    """
    model, rows = column.model, column.work.hold
    first = NO_CHANGE
    for i in range(model.n):
        if rows.outside[i] == 0:
            continue
        # only joints that an evaluation saw outside
        regime = rows.regime[i]
        lo, hi = _bracket(column, looked_at, nodes, i, regime)
        if hi == NO_CHANGE or lo >= first:
            continue
        # locate the change on the interpolated motion
        refine(column, t, h)
        course = course_of(column, i, h)
        if hi < 1.0 and margin_within(column, i, regime, course, hi) >= 0.0:
            # a stage is less accurate than the step
            if margin_within(column, i, regime, course, 1.0) >= 0.0:
                continue
            lo, hi = hi, 1.0
        first = min(first, end_of_regime(column, i, regime, course, lo, hi))
    return first
