"""Step size control: growth with memory, limits of the work of a call, and when modal steps pay."""

import math

from ..layout.spaces import OK, SLACK
from ..numba_ext.jit import in_both, kernel, leaf
from ..numba_ext.lanes import greater, magnitude, where
from .modal_steps import ORDER as MODAL_ORDER

SAFETY = 0.9


SHRINK = 0.2


GROW = 5.0


# step control with memory (K. Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533-554), in units of one over the order:
# without it every second step at the edge of stability would be tried beyond the edge
INTEGRAL = 0.7


PROPORTIONAL = 0.4


LIGHTLY_DAMPED = 0.02  # damping ratio of a contact, below which steps of the higher order are taken


LEAST_TOLERANCE = 1e-13  # of a step


LEAST_STEP = 1e-13  # of the time scale: below this the error control has failed


# of the first step: shorter times are rounding errors of a caller's clock. Rates interpolated in so short a step would
# be rounding errors of coordinates over its length
INSTANT = 1e-8


LEAST_ERROR = 1e-4


STEPS_PER_PROBE = 100  # explicit steps before such a trial


# when the modal method is used: a step of it costs half of one of the others
ELASTIC_COST = 0.5


WAIT_OPEN = 10  # steps of other methods before the next trial, after a joint was found open


WAIT_SHORT = 30  # the same after its steps had become too short


LENGTHEN_BELOW = 0.3  # of the tolerance: with a smaller error the step becomes longer


LEAST_ELASTIC_STEP = 1e-9  # s


# limit of evaluations and sweeps in a call: a constant, plus a number for each `first_step` of its length. Scenes of
# the benchmarks and columns of examples/ take 7 for each at most, at a tolerance of 1e-11
MOST_AT_ONCE = 1e5


MOST_PER_FIRST_STEP = 1e4


# limit of evaluations times blocks in a call of any length, for an answer within seconds; 30 to 190 ns each, measured
MOST_OF_A_CALL = 4e7


WORK_OF_A_STEP = 8.0  # evaluations that a step costs besides its own


@in_both
def most_work(settings, h):
    """Return the limit of evaluations and sweeps for h s; beyond it the motion cannot be followed."""
    return MOST_AT_ONCE + MOST_PER_FIRST_STEP * h / settings.first_step


@in_both
def most_of_a_call(blocks):
    """Return the limit of the work in a call: evaluations and sweeps, plus WORK_OF_A_STEP for each step.

    blocks: number of blocks; of a structure, blocks and joints, all the work of whose steps is in their evaluations.
    """
    return MOST_OF_A_CALL / blocks


@leaf
def may_be_elastic(counts, control, longest, most, cost):
    """Return True if a modal step is worth an attempt.

    Parameters
    ----------
    counts, control : record
        Counters and step control of the state.
    longest : float
        Longest modal step (s).
    most : float
        Remaining time (s).
    cost : float
        Cost of a modal step relative to a step of the other methods.
    """
    # time left, no wait after a failure, and cheaper than the next general step
    return most >= LEAST_ELASTIC_STEP and counts.elastic_wait <= 0 and longest >= cost * control.next_step


@leaf
def growth(previous_error, error, per_order):
    """Return the ratio of the next step to the last one, from the errors of the last two steps (in tolerances)."""
    factor = SAFETY * math.exp(per_order * (PROPORTIONAL * math.log(previous_error) - INTEGRAL * math.log(error)))
    return min(GROW, max(SHRINK, factor))


@leaf
def worse(largest, error):
    """Return the larger of two errors; NaN if either is."""
    return where((error <= largest) | (largest != largest), largest, error)


@leaf
def shared(step, left):
    """Return the next step (s) of the `left` s that remain: all of them, two equal steps, or `step`."""
    return where(2.0 * step > left, where(step * (1.0 + SLACK) >= left, left, 0.5 * left), step)


@leaf
def is_too_short(step, first_step, t):
    """Return True if the next step (s) is so short at time t (s) that the error control has failed."""
    return step < LEAST_STEP * greater(first_step, magnitude(t))


@leaf
def shorten(control, step, error, per_order):
    """Set the next step (s) after a rejected one; an error that is not finite shortens it most."""
    factor = max(SHRINK, SAFETY * error**-per_order) if math.isfinite(error) else SHRINK
    control.next_step, control.previous_error = step * factor, 1.0


@leaf
def go_on(control, step, error, per_order):
    """Set the next step (s) after an accepted one. Returns True if that was as long as proposed.

    A step that was shortened does not change the longer one proposed before.
    """
    error = max(error, LEAST_ERROR)
    factor = growth(control.previous_error, error, per_order)
    # a step that an event has shortened says nothing of the error of a whole one
    whole = step >= control.next_step * (1.0 - SLACK)
    if whole:
        control.previous_error = error
    # lengthen from a short step only beyond what was proposed
    control.next_step = step * factor if factor < 1.0 else max(step * factor, control.next_step)
    return whole


@kernel
def accepts_elastic(counts, control, step, code, error, cost):
    """Return True if the attempted modal step (s) is accurate enough; set the length of the next one in either case."""
    # a joint opened or slid: wait before the next attempt
    if code != OK:
        counts.rejected += 1
        counts.elastic_wait = WAIT_OPEN
        return False
    # shorten, and wait if steps of other methods are as good
    if error > 1.0:
        counts.rejected += 1
        control.elastic_step = step * max(SHRINK, SAFETY * error ** (-1.0 / MODAL_ORDER))
        if control.elastic_step < cost * control.next_step:
            counts.elastic_wait = WAIT_SHORT
            control.elastic_step = control.next_step
        return False
    counts.elastic_steps += 1
    # steps of equal length share their responses: it is changed only when needed
    if error > SAFETY:
        control.elastic_step = step * SAFETY
    elif error < LENGTHEN_BELOW and step * GROW > control.elastic_step:
        longer = step * min(GROW, SAFETY * max(error, LEAST_ERROR) ** (-1.0 / MODAL_ORDER))
        control.elastic_step = max(control.elastic_step, longer)
    return True
