"""Regimes of the joints within a step: held while it is made, then the moment is found at which the first one ends.

The law of a joint is smooth while its regime lasts and has a kink where another one begins: an edge parts, a corner
comes down. A step that is held in the regimes of its start has smooth equations from end to end, so that the order of
the integrator and the interpolation inside the step hold up to the moment of the change, where it is cut off.
"""

from .exact import LEFT, LOCK, REGIME, sine_cosine
from .interpolation import interpolate_one
from .jit import kernel, leaf, place
from .joint import ANY, contact_regime, regime_margin
from .layout import BLOCK_FIELDS, DAMPING, JOINT_WIDTH, MODEL_HEADER, N_BLOCKS, PHASE_END, SCRATCH_FIELDS

NO_CHANGE = 2.0  # a fraction of the step that is never reached
AHEAD = 1e-7  # of the step: at the very moment of a change the regime is that of so much later
CLOSE_ENOUGH = 1e-6  # of the step: the error of going on in the wrong regime is of the second order in it
MOST_TRIALS = 40
PREDICTIONS = 4  # trials
OVERSHOOT = 1.03  # a step that is to end just beyond a change is longer than expected by so much,
AFTER = 0.01  # and by this part of the one proposed
PARTS = 4  # of the step, looked into one after the other


@kernel
def hold(model, work, start, scratch, h):
    """Hold every joint in the regime in which a step of h seconds from the phase at work[start:] begins."""
    n = int(model[N_BLOCKS])
    ahead = AHEAD * h
    turn_below = 0.0
    spin_below = 0.0
    for i in range(n - 1, -1, -1):
        row = place(MODEL_HEADER + BLOCK_FIELDS * i)
        q = place(start + i)
        turn = work[q] + ahead * work[q + 2 * n]
        spin = work[q + 2 * n] + ahead * work[q + 4 * n]
        opening = work[q + n] + ahead * work[q + 3 * n]
        opening_rate = work[q + 3 * n] + ahead * work[q + 5 * n]
        sine, cosine = sine_cosine(0.5 * (turn - turn_below))
        slope_rate = cosine * (spin - spin_below)
        regime = contact_regime(
            model[row + JOINT_WIDTH], model[row + DAMPING], opening, 2.0 * sine, opening_rate, slope_rate
        )
        work[scratch + SCRATCH_FIELDS * i + LOCK] = regime
        work[scratch + SCRATCH_FIELDS * i + REGIME] = regime
        work[scratch + SCRATCH_FIELDS * i + LEFT] = 0.0
        turn_below = turn
        spin_below = spin


@kernel
def release(model, work, scratch):
    """Let the joints go; what they were held in is remembered."""
    for i in range(int(model[N_BLOCKS])):
        work[scratch + SCRATCH_FIELDS * i + LOCK] = ANY


@leaf
def _margin(model, i, regime, turn, opening, spin, opening_rate):
    """How far joint i, turned by so much, is from leaving a regime, m."""
    row = place(MODEL_HEADER + BLOCK_FIELDS * i)
    sine, cosine = sine_cosine(0.5 * turn)
    return regime_margin(
        regime, model[row + JOINT_WIDTH], model[row + DAMPING], opening, 2.0 * sine, opening_rate, cosine * spin
    )


@kernel
def _stays(model, x, o, i, regime):
    """Whether joint i is in this regime at the phase x[o:]."""
    n = place(int(model[N_BLOCKS]))
    q = place(o + i)
    turn = x[q]
    spin = x[q + 2 * n]
    if i + 1 < n:
        turn -= x[q + 1]
        spin -= x[q + 2 * n + 1]
    return _margin(model, i, regime, turn, x[q + n], spin, x[q + 3 * n]) >= 0.0


@kernel
def _margin_ahead(model, work, start, i, regime, s):
    """The margin of joint i in s seconds from the phase at work[start:] if its accelerations stay what they are."""
    n = int(model[N_BLOCKS])
    q = place(start + i)
    turn, spin, spin_rate = work[q], work[q + 2 * n], work[q + 4 * n]
    if i + 1 < n:
        turn -= work[q + 1]
        spin -= work[q + 2 * n + 1]
        spin_rate -= work[q + 4 * n + 1]
    opening, opening_rate, opening_rate_rate = work[q + n], work[q + 3 * n], work[q + 5 * n]
    turn += s * (spin + 0.5 * s * spin_rate)
    opening += s * (opening_rate + 0.5 * s * opening_rate_rate)
    return _margin(model, i, regime, turn, opening, spin + s * spin_rate, opening_rate + s * opening_rate_rate)


@kernel
def expected_change(model, work, start, scratch, h):
    """Seconds until just after a joint is expected to leave its regime; h if not before that.

    Expected is what happens if accelerations stay what they are. A step that ends there is nearly used up when it is
    cut off, and interpolates well where that happens.
    """
    first = h
    for i in range(int(model[N_BLOCKS])):
        regime = int(work[place(scratch + SCRATCH_FIELDS * i + REGIME)])
        hi = first
        at_hi = _margin_ahead(model, work, start, i, regime, hi)
        if at_hi >= 0.0:
            continue
        lo = 0.0
        at_lo = _margin_ahead(model, work, start, i, regime, lo)
        if at_lo <= 0.0:
            continue
        for _ in range(PREDICTIONS):
            trial = (lo * at_hi - hi * at_lo) / (at_hi - at_lo)
            at_trial = _margin_ahead(model, work, start, i, regime, trial)
            if at_trial < 0.0:
                hi, at_hi = trial, at_trial
                at_lo *= 0.5
            else:
                lo, at_lo = trial, at_trial
                at_hi *= 0.5
        first = hi
    return min(h, OVERSHOOT * first + AFTER * h)


@kernel
def _leaves(model, work, inside, i, regime):
    """Whether joint i is not in this regime at the end of the step, or at one of the stages inside it."""
    n = int(model[N_BLOCKS])
    left = not _stays(model, work, 6 * n * PHASE_END, i, regime)
    for stage in inside:
        left = left or not _stays(model, work, 6 * n * stage, i, regime)
    return left


@kernel
def changes(model, work, inside, scratch):
    """Whether a joint has left the regime it is held in, at the end of the step or at one of the stages inside it."""
    for i in range(int(model[N_BLOCKS])):
        if work[place(scratch + SCRATCH_FIELDS * i + LEFT)] == 0.0:
            continue
        if _leaves(model, work, inside, i, int(work[place(scratch + SCRATCH_FIELDS * i + REGIME)])):
            return True
    return False


@kernel
def _margin_between(model, work, i, regime, h, s):
    """The margin of joint i at fraction s of the step."""
    n = int(model[N_BLOCKS])
    size = 2 * n
    turn, spin = interpolate_one(work, size, i, h, s)
    opening, opening_rate = interpolate_one(work, size, n + i, h, s)
    if i + 1 < n:
        turn_below, spin_below = interpolate_one(work, size, i + 1, h, s)
        turn -= turn_below
        spin -= spin_below
    return _margin(model, i, regime, turn, opening, spin, opening_rate)


@kernel
def _end_of_regime(model, work, i, regime, h, lo, hi):
    """Fraction of the step, between lo with a margin and hi without, where the margin of joint i is spent.

    The false position with halved weights (M. Dowell, P. Jarratt, BIT 11 (1971) 168-174, the Illinois algorithm).
    """
    at_lo = _margin_between(model, work, i, regime, h, lo)
    at_hi = _margin_between(model, work, i, regime, h, hi)
    side = 0
    for _ in range(MOST_TRIALS):
        if hi - lo <= CLOSE_ENOUGH:
            break
        trial = (lo * at_hi - hi * at_lo) / (at_hi - at_lo)
        if not lo < trial < hi:
            trial = 0.5 * (lo + hi)
        at_trial = _margin_between(model, work, i, regime, h, trial)
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
def first_change(model, work, inside, scratch, h):
    """Fraction of the step at which a joint first leaves the regime that it was held in; NO_CHANGE if none does.

    inside: stages of the step that are looked at for joints that leave and come back.
    """
    first = NO_CHANGE
    for i in range(int(model[N_BLOCKS])):
        regime = int(work[place(scratch + SCRATCH_FIELDS * i + REGIME)])
        if work[place(scratch + SCRATCH_FIELDS * i + LEFT)] == 0.0 or not _leaves(model, work, inside, i, regime):
            continue
        lo, hi = 0.0, 0.0
        for k in range(1, PARTS + 1):
            lo, hi = hi, k / PARTS
            if _margin_between(model, work, i, regime, h, hi) < 0.0:
                if lo < first:
                    first = min(first, _end_of_regime(model, work, i, regime, h, lo, hi))
                break
    return first
