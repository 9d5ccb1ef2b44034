"""Location of the start and end of sliding of joints within a step.

Within a step each joint sticks or slides in one direction, so that the equations are smooth. A joint stops where its
slip rate crosses zero, which the interpolation gives. It starts where sticking would need more than the shear capacity,
which takes an evaluation at every trial. The step is cut there, and `evaluate_after_jump` decides how it continues.
"""

from ...engine.bracket import bracket, narrowed, trial_within
from ...engine.interpolation import value_of
from ...numba_ext.jit import kernel, leaf
from ..formulations.dispatch import evaluate_at
from ..formulations.slips import shear_margin
from ..integrators.interpolation import interpolate_phase, quintic_of, refine, slips_of

NEVER = 2.0  # a fraction of the step that is not reached
CLOSE_ENOUGH = 1e-12  # of the step: the remaining rate there is taken as zero
NEAR = 1e-9  # of the step, for the start of sliding, at which no force jumps; also the least part that a step is cut to
# least part of the step that is kept where the held law stops a joint that starts sliding there by its own law, or
# starts one that sticks: otherwise thousands of such tiny steps could follow each other
LATE = 1e-3
MOST_TRIALS = 60
MOST_HALVINGS = 20


@kernel
def begin_step(column, h):
    """Clear the marks of the last step; return the time (s) until just after a joint is expected to stop, at most h."""
    work = column.work
    start, joints = work.start, work.joints
    first = h
    for i in range(int(work.slips.count)):
        joints.overcome[i] = 0.0
        rate, slows = start.slip_rate[i], start.slip_acceleration[i]
        if rate * slows < 0.0 and -rate / slows < first:
            first = -rate / slows
    return first


@kernel
def first_slip_change(column, looked_at, nodes, t, h):
    """Return the fraction of the step at which a joint first starts or stops sliding; NEVER if none does.

    Parameters
    ----------
    column : Column
        The column after the attempted step.
    looked_at : tuple of 3 phases
        Phases inside the step, for joints that turn twice.
    nodes : tuple of 3 floats
        Fractions of the step at which these are.
    t, h : float
        Start and length of the step (s).
    """
    work, joints = column.work, column.work.joints
    # joints that stop
    if any_passes_zero(work, looked_at):
        refine(column, t, h)
    first = first_stop(work, looked_at, nodes, h)
    # joints that start: those seen beyond their shear capacity
    for i in range(work.n):
        if joints.sliding[i] == 0.0 and joints.overcome[i] != 0.0:
            first = min(first, _beginning(column, i, nodes, t, h, first))
    return first


@leaf
def any_passes_zero(work, looked_at):
    """Return True if a joint slides backwards at the end of the step or at a phase inside; a mask for lanes."""
    passes = work.joints.sliding[0] != work.joints.sliding[0]  # false in every lane
    first, second, third = looked_at
    for i in range(work.n):
        way = work.joints.sliding[i]
        passes = passes | (way * first.slip_rate[i] < 0.0) | (way * second.slip_rate[i] < 0.0)
        passes = passes | (way * third.slip_rate[i] < 0.0) | (way * work.end.slip_rate[i] < 0.0)
    return passes


@kernel
def first_stop(work, looked_at, nodes, h):
    """Return the fraction of the step of `h` s at which a joint first stops sliding; NEVER if none does."""
    sliding = work.joints.sliding
    first = NEVER
    for i in range(work.n):
        if sliding[i] == 0.0:
            continue
        # bracket the zero of the slip rate by the phases inside and the end
        lo, hi = 0.0, NEVER
        for k in range(3):
            if sliding[i] * looked_at[k].slip_rate[i] < 0.0:
                hi = nodes[k]
                break
            lo = nodes[k]
        if hi == NEVER and sliding[i] * work.end.slip_rate[i] < 0.0:
            hi = 1.0
        if hi != NEVER and lo < first:
            first = min(first, _stop(work, i, lo, hi, h))
    return first


@kernel
def _stop(work, i, lo, hi, h):
    """Return the fraction of the step in (lo, hi) where the rate of slip i crosses zero; NEVER if it does not."""
    course = quintic_of(work, slips_of(work)[0] + i, -1, h)
    way = work.joints.sliding[i]
    at_hi = way * value_of(course, hi)[1]
    if at_hi >= 0.0:  # a stage is less accurate than the step
        lo, hi = hi, 1.0
        at_hi = way * value_of(course, hi)[1]
        if at_hi >= 0.0:
            return NEVER
    at_lo = way * value_of(course, lo)[1]
    if at_lo < 0.0:
        lo, at_lo = 0.0, max(0.0, way * value_of(course, 0.0)[1])
    if at_lo == 0.0:  # it starts here, and stops after it has moved
        lo, at_lo = _moving(course, way, lo, hi)
        if at_lo == 0.0:
            return max(lo, LATE)
    # bracketed root of the slip rate
    known = bracket(lo, hi, at_lo, at_hi)
    for _ in range(MOST_TRIALS):
        if known.hi - known.lo <= CLOSE_ENOUGH:
            break
        trial = trial_within(known)
        known = narrowed(known, trial, way * value_of(course, trial)[1])
    return known.hi


@kernel
def _moving(course, way, lo, hi):
    """Return (fraction, slip rate) shortly after `lo` where a slip at rest at lo moves; (lo, 0) if none is found."""
    reach = hi - lo
    for _ in range(MOST_HALVINGS):
        reach *= 0.5
        rate = way * value_of(course, lo + reach)[1]
        if rate > 0.0:
            return lo + reach, rate
    return lo, 0.0


@kernel
def _beginning(column, i, nodes, t, h, before):
    """Return the fraction, below `before`, where joint i first exceeds its shear capacity; NEVER if it does not."""
    refine(column, t, h)
    lo, at_lo = 0.0, _margin_within(column, i, t, h, 0.0)
    if at_lo <= 0.0:
        return LATE
    # bracket the zero of the margin by the phases inside and the end
    hi, at_hi = NEVER, 0.0
    for k in range(4):
        place = min(before, nodes[k] if k < 3 else 1.0)
        value = _margin_within(column, i, t, h, place)
        if value < 0.0:
            hi, at_hi = place, value
            break
        lo, at_lo = place, value
        if place == before:
            break
    if hi == NEVER:
        return NEVER
    known = bracket(lo, hi, at_lo, at_hi)
    for _ in range(MOST_TRIALS):
        if known.hi - known.lo <= NEAR:
            break
        trial = trial_within(known)
        # bracketed root of the margin
        known = narrowed(known, trial, _margin_within(column, i, t, h, trial))
    return known.hi


@kernel
def _margin_within(column, i, t, h, s):
    """Return the shear capacity of joint i less its tangential force (N) at fraction s of the step."""
    interpolate_phase(column.work, h, s)
    evaluate_at(column, column.work.between, t + s * h)
    return shear_margin(column.work.joints, i)
