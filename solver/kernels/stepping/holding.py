"""Regimes of the joints within a step: held while it is made, then the moment is found at which the first one ends.

The law of a joint is smooth while its regime lasts and has a kink where another one begins: an edge parts, a corner
comes down. A step that is held in the regimes of its start has smooth equations from end to end, so that the order of
the integrator and the interpolation inside the step hold up to the moment of the change, where it is cut off.
"""

from ..jit import kernel, leaf
from ..joint.regimes import ANY, contact_regime, regime_margin
from ..numbers import sine_cosine
from .interpolation import interpolate_one

NO_CHANGE = 2.0  # a fraction of the step that is never reached
AHEAD = 1e-7  # of the step: at the very moment of a change the regime is that of so much later
CLOSE_ENOUGH = 1e-6  # of the step: the error of going on in the wrong regime is of the second order in it
MOST_TRIALS = 40
PREDICTIONS = 4  # trials
OVERSHOOT = 1.03  # a step that is to end just beyond a change is longer than expected by so much,
AFTER = 0.01  # and by this part of the one proposed
PARTS = 4  # of the step, looked into one after the other


@kernel
def hold(column, h):
    """Hold every joint in the regime in which a step of h seconds begins."""
    blocks, start, rows = column.model.blocks, column.work.start, column.work.hold
    ahead = AHEAD * h
    turn_below = 0.0
    spin_below = 0.0
    for i in range(column.model.n - 1, -1, -1):
        turn = start.theta[i] + ahead * start.theta_rate[i]
        spin = start.theta_rate[i] + ahead * start.theta_acceleration[i]
        opening = start.opening[i] + ahead * start.opening_rate[i]
        opening_rate = start.opening_rate[i] + ahead * start.opening_acceleration[i]
        sine, cosine = sine_cosine(0.5 * (turn - turn_below))
        slope_rate = cosine * (spin - spin_below)
        regime = contact_regime(blocks.width[i], blocks.damping[i], opening, 2.0 * sine, opening_rate, slope_rate)
        rows.held[i] = regime
        rows.regime[i] = regime
        rows.outside[i] = 0
        turn_below = turn
        spin_below = spin


@kernel
def release(column):
    """Let the joints go; what they were held in is remembered."""
    for i in range(column.model.n):
        column.work.hold.held[i] = ANY


@leaf
def _margin(model, i, regime, turn, opening, spin, opening_rate):
    """How far joint i, turned by so much, is from leaving a regime, m."""
    sine, cosine = sine_cosine(0.5 * turn)
    return regime_margin(
        regime, model.blocks.width[i], model.blocks.damping[i], opening, 2.0 * sine, opening_rate, cosine * spin
    )


@leaf
def _less_below(row, i, n):
    return row[i] - row[i + 1] if i + 1 < n else row[i]


@kernel
def _stays(model, phase, i, regime):
    """Whether joint i is in this regime at a phase."""
    turn = _less_below(phase.theta, i, model.n)
    spin = _less_below(phase.theta_rate, i, model.n)
    return _margin(model, i, regime, turn, phase.opening[i], spin, phase.opening_rate[i]) >= 0.0


@kernel
def _margin_ahead(model, start, i, regime, s):
    """The margin of joint i in s seconds from a phase if its accelerations stay what they are."""
    n = model.n
    turn, spin = _less_below(start.theta, i, n), _less_below(start.theta_rate, i, n)
    spin_rate = _less_below(start.theta_acceleration, i, n)
    opening, opening_rate, rate_of_rate = start.opening[i], start.opening_rate[i], start.opening_acceleration[i]
    turn += s * (spin + 0.5 * s * spin_rate)
    opening += s * (opening_rate + 0.5 * s * rate_of_rate)
    return _margin(model, i, regime, turn, opening, spin + s * spin_rate, opening_rate + s * rate_of_rate)


@kernel
def expected_change(column, h):
    """Seconds until just after a joint is expected to leave its regime; h if not before that.

    Expected is what happens if accelerations stay what they are. A step that ends there is nearly used up when it is
    cut off, and interpolates well where that happens.
    """
    model, start = column.model, column.work.start
    first = h
    for i in range(model.n):
        regime = column.work.hold.regime[i]
        hi = first
        at_hi = _margin_ahead(model, start, i, regime, hi)
        if at_hi >= 0.0:
            continue
        lo = 0.0
        at_lo = _margin_ahead(model, start, i, regime, lo)
        if at_lo <= 0.0:
            continue
        for _ in range(PREDICTIONS):
            trial = (lo * at_hi - hi * at_lo) / (at_hi - at_lo)
            at_trial = _margin_ahead(model, start, i, regime, trial)
            if at_trial < 0.0:
                hi, at_hi = trial, at_trial
                at_lo *= 0.5
            else:
                lo, at_lo = trial, at_trial
                at_hi *= 0.5
        first = hi
    return min(h, OVERSHOOT * first + AFTER * h)


@kernel
def _leaves(column, looked_at, i, regime):
    """Whether joint i is not in this regime at the end of the step, or at one of the phases inside it."""
    if not _stays(column.model, column.work.end, i, regime):
        return True
    for k in range(3):  # noqa: SIM110  numba compiles no any() over a generator
        if not _stays(column.model, looked_at[k], i, regime):
            return True
    return False


@kernel
def changes(column, looked_at):
    """Whether a joint has left the regime it is held in, at the end of the step or at one of the phases inside it.

    looked_at: three phases inside the step, for joints that leave and come back.
    """
    rows = column.work.hold
    for i in range(column.model.n):
        outside = rows.outside[i] != 0
        if outside and _leaves(column, looked_at, i, rows.regime[i]):
            return True
    return False


@kernel
def _margin_between(column, i, regime, h, s):
    """The margin of joint i at fraction s of the step."""
    n, work = column.model.n, column.work
    turn, spin = interpolate_one(work, i, h, s)
    opening, opening_rate = interpolate_one(work, n + i, h, s)
    if i + 1 < n:
        turn_below, spin_below = interpolate_one(work, i + 1, h, s)
        turn -= turn_below
        spin -= spin_below
    return _margin(column.model, i, regime, turn, opening, spin, opening_rate)


@kernel
def _end_of_regime(column, i, regime, h, lo, hi):
    """Fraction of the step, between lo with a margin and hi without, where the margin of joint i is spent.

    The false position with halved weights (M. Dowell, P. Jarratt, BIT 11 (1971) 168-174, the Illinois algorithm).
    """
    at_lo = _margin_between(column, i, regime, h, lo)
    at_hi = _margin_between(column, i, regime, h, hi)
    side = 0
    for _ in range(MOST_TRIALS):
        if hi - lo <= CLOSE_ENOUGH:
            break
        trial = (lo * at_hi - hi * at_lo) / (at_hi - at_lo)
        if not lo < trial < hi:
            trial = 0.5 * (lo + hi)
        at_trial = _margin_between(column, i, regime, h, trial)
        if at_trial < 0.0:
            hi, at_hi = trial, at_trial
            if side == 1:
                at_lo *= 0.5
            side = 1
        else:
            lo, at_lo = trial, at_trial
            if side == -1:
                at_hi *= 0.5
            side = -1
    return hi


@kernel
def first_change(column, looked_at, h):
    """Fraction of the step at which a joint first leaves the regime that it was held in; NO_CHANGE if none does."""
    rows = column.work.hold
    first = NO_CHANGE
    for i in range(column.model.n):
        regime = rows.regime[i]
        if rows.outside[i] == 0 or not _leaves(column, looked_at, i, regime):
            continue
        lo, hi = 0.0, 0.0
        for k in range(1, PARTS + 1):
            lo, hi = hi, k / PARTS
            if _margin_between(column, i, regime, h, hi) < 0.0:
                if lo < first:
                    first = min(first, _end_of_regime(column, i, regime, h, lo, hi))
                break
    return first
