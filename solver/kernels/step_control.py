"""Which method makes the next step, whether the step is good enough, and how long the one after is to be."""

import math

from .integrators import central_difference, dormand_prince, modal, order_8, rosenbrock
from .jit import kernel, leaf
from .layout import (
    ELASTIC_STEP,
    ELASTIC_STEPS,
    ELASTIC_WAIT,
    EXACT,
    EXPLICIT_ORDER,
    EXPLICIT_STEP,
    FORMULATION,
    IMPLICIT,
    IMPLICIT_METHOD,
    IMPLICIT_STEPS,
    IN_FLIGHT,
    INPUT_AMPLITUDE,
    INPUT_OMEGA,
    LAST_ERROR,
    NEXT_STEP,
    OK,
    RATE_SCALE,
    REJECTED,
    ROTATION_SCALE,
    SINCE_PROBE,
    SLACK,
    WITHOUT,
)

# methods
FIXED = 0  # central differences
ORDER_5 = 1
ORDER_8 = 2
LINEARLY_IMPLICIT = 3
MODES = 4

SAFETY = 0.9
SHRINK = 0.2
GROW = 5.0
# step control with memory (K. Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533-554), parts of one over the order: a
# step at the edge of stability is not tried beyond it every other time
INTEGRAL = 0.7
PROPORTIONAL = 0.4
LEAST_ERROR = 1e-4
# when `auto` changes its method
GAIN = 2.2  # the implicit method has to step further than the explicit one by so much
PROBE = 4.0  # times the explicit step: how far the implicit method is tried
STEPS_PER_PROBE = 100
SMOOTHING = 0.2
# when the modal method is used: a step of it costs half of one of the others
ELASTIC_COST = 0.5
WAIT_OPEN = 10  # steps of the others after a joint was found open before it is tried again
WAIT_SHORT = 30  # and after its steps had become too short
SPARE = 0.3  # of the tolerance: with a smaller error the step becomes longer


@kernel
def _general_method(model, state, counters, step, left):
    """The method by which `auto` makes its next step, of so many seconds.

    An implicit step costs about as much as an explicit one of order 5 and half as much as one of order 8, so the method
    that goes further at the same cost is the better. The implicit one is left where it does not; from time to time it
    is tried with a longer step.
    """
    if model[FORMULATION] != EXACT:
        return ORDER_5
    explicit = ORDER_8 if model[EXPLICIT_ORDER] == 8.0 else ORDER_5
    if int(model[WITHOUT]) & IMPLICIT_METHOD:
        return explicit
    worth = 0.5 if explicit == ORDER_8 else 1.0
    if counters[IMPLICIT] == 1:
        return LINEARLY_IMPLICIT if min(step, left) > GAIN * worth * state[EXPLICIT_STEP] else explicit
    if counters[IN_FLIGHT] == 1:  # nothing there is stiff, and an implicit step would see too little of the landing
        return explicit
    if counters[SINCE_PROBE] >= STEPS_PER_PROBE and PROBE * worth * step <= left:
        return LINEARLY_IMPLICIT
    return explicit


@kernel
def _elastic_step(model, state, counters, work, most):
    """What `auto` makes its next step by, s, if that is to be the modal method with all joints in contact; else 0."""
    if not modal.available(model) or most < modal.LEAST_STEP:
        return 0.0
    if counters[ELASTIC_WAIT] > 0:
        return 0.0
    if modal.longest_step(model) < ELASTIC_COST * state[NEXT_STEP]:
        return 0.0
    if not modal.suits(model, work):
        counters[ELASTIC_WAIT] = WAIT_OPEN
        return 0.0
    return min(state[ELASTIC_STEP], modal.longest_step(model))


@kernel
def choose(model, state, counters, inputs, work, left):
    """(method, s) of the next step of `auto`, of which `left` s remain to the end of the call."""
    step = _elastic_step(model, state, counters, work, left)
    elastic = step > 0.0
    if not elastic:
        step = state[NEXT_STEP]
    if inputs[INPUT_AMPLITUDE] != 0.0:  # never skip over a cycle of the motion
        step = min(step, 1.0 / inputs[INPUT_OMEGA])
    if elastic:
        return MODES, step
    method = _general_method(model, state, counters, step, left)
    if method == LINEARLY_IMPLICIT and counters[IMPLICIT] == 0:
        counters[SINCE_PROBE] = 0
        step *= PROBE
    return method, step


@kernel
def attempt(method, model, state, counters, inputs, work, t, step):
    """One step by this method; returns (code, error in tolerances)."""
    scale, rate_scale = state[ROTATION_SCALE], state[RATE_SCALE]
    if method == ORDER_5:
        return dormand_prince.attempt(model, inputs, work, counters, scale, rate_scale, t, step)
    if method == ORDER_8:
        return order_8.attempt(model, inputs, work, counters, scale, rate_scale, t, step)
    if method == LINEARLY_IMPLICIT:
        return rosenbrock.attempt(model, inputs, work, counters, scale, rate_scale, t, step)
    if method == MODES:
        return modal.attempt(model, inputs, work, counters, scale, rate_scale, t, step)
    return central_difference.attempt(model, inputs, work, counters, scale, rate_scale, t, step)


@leaf
def order_of(method):
    """Order of a method with error control."""
    if method == ORDER_8:
        return order_8.ORDER
    return rosenbrock.ORDER if method == LINEARLY_IMPLICIT else dormand_prince.ORDER


@kernel
def accepts(method, state, counters, step, code, error):
    """Whether a step just tried is good enough; proposes the next one either way."""
    order = order_of(method)
    implicit = method == LINEARLY_IMPLICIT
    if code != OK or not error <= 1.0:
        counters[REJECTED] += 1
        if implicit and counters[IMPLICIT] == 0:  # a probe that failed: go on as before
            return False
        factor = SHRINK
        if code == OK and math.isfinite(error):
            factor = max(SHRINK, SAFETY * error ** (-1.0 / order))
        state[NEXT_STEP] = step * factor
        state[LAST_ERROR] = 1.0
        return False
    error = max(error, LEAST_ERROR)
    factor = SAFETY * error ** (-INTEGRAL / order) * state[LAST_ERROR] ** (PROPORTIONAL / order)
    factor = min(GROW, max(SHRINK, factor))
    # one cut short says nothing against the longer one proposed before
    whole = step >= state[NEXT_STEP] * (1.0 - SLACK)
    if whole:
        state[LAST_ERROR] = error
    if implicit:
        counters[IMPLICIT_STEPS] += 1
        counters[IMPLICIT] = 1
    else:
        counters[SINCE_PROBE] += 1
        if whole:
            state[EXPLICIT_STEP] += SMOOTHING * (step - state[EXPLICIT_STEP])
            counters[IMPLICIT] = 0
    state[NEXT_STEP] = step * factor if factor < 1.0 else max(step * factor, state[NEXT_STEP])
    return True


@kernel
def accepts_elastic(state, counters, step, code, error):
    """Whether a modal step just tried is good enough; proposes the next one either way."""
    if code != OK:
        counters[REJECTED] += 1
        counters[ELASTIC_WAIT] = WAIT_OPEN
        return False
    if error > 1.0:
        counters[REJECTED] += 1
        state[ELASTIC_STEP] = step * max(SHRINK, SAFETY * error ** (-1.0 / modal.ORDER))
        if state[ELASTIC_STEP] < ELASTIC_COST * state[NEXT_STEP]:
            counters[ELASTIC_WAIT] = WAIT_SHORT
            state[ELASTIC_STEP] = state[NEXT_STEP]
        return False
    counters[ELASTIC_STEPS] += 1
    # steps that stay the same share their responses: no change without need
    if error > SAFETY:
        state[ELASTIC_STEP] = step * SAFETY
    elif error < SPARE:
        longer = step * min(GROW, SAFETY * max(error, LEAST_ERROR) ** (-1.0 / modal.ORDER))
        state[ELASTIC_STEP] = max(state[ELASTIC_STEP], longer)
    return True
