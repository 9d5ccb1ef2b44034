"""Which method makes the next step, whether the step is good enough, and how long the one after is to be."""

import math

from ..formulations.base import wave_amplitude
from ..formulations.either import is_exact
from ..formulations.slips import something_slides
from ..integrators import modal
from ..integrators.traits import LINEARLY_IMPLICIT, ORDER_5, ORDER_8, traits_of
from ..jit import kernel, leaf
from ..layout import IMPLICIT, OK, SLACK

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
STEPS_PER_PROBE = 100  # explicit steps before that
MANY = 8  # blocks: from here on it mostly pays, and is tried sooner, and no further than it has to beyond order 8
PROBE_OF_MANY = 1.5
STEPS_OF_MANY = 40
SMOOTHING = 0.2
# when the modal method is used: a step of it costs half of one of the others
ELASTIC_COST = 0.5
WAIT_OPEN = 10  # steps of the others after a joint was found open before it is tried again
WAIT_SHORT = 30  # and after its steps had become too short
SPARE = 0.3  # of the tolerance: with a smaller error the step becomes longer
LEAST_ELASTIC_STEP = 1e-9  # s


@leaf
def within_a_cycle(column, step):
    """The step, s, shortened so that it does not skip over a cycle of a harmonic motion."""
    if wave_amplitude(column.base, column.samples) != 0.0:
        return min(step, 1.0 / column.base.wave_omega)
    return step


@kernel
def elastic_step(column, most):
    """What `auto` makes its next step by, s, if that is to be the modal method with all joints in contact; else 0."""
    model, counts, control = column.model, column.counts, column.state.control
    if not modal.available(model) or most < LEAST_ELASTIC_STEP:
        return 0.0
    if counts.elastic_wait > 0:
        return 0.0
    if modal.longest_step(model) < ELASTIC_COST * control.next_step:
        return 0.0
    if not modal.suits(column):
        counts.elastic_wait = WAIT_OPEN
        return 0.0
    return within_a_cycle(column, min(control.elastic_step, modal.longest_step(model)))


@kernel
def general_step(column, left):
    """(method, s) of the next step of `auto` where joints may open; `left` s remain.

    An implicit step costs about as much as an explicit one of order 5 and half as much as one of order 8, so the method
    that goes further at the same cost is the better. The implicit one is left where it does not; from time to time it
    is tried with a longer step.
    """
    counts, control = column.counts, column.state.control
    step = within_a_cycle(column, control.next_step)
    if not is_exact(column.model):
        return ORDER_5, step
    explicit = ORDER_8 if column.model.settings.explicit_order == 8.0 else ORDER_5
    if int(column.model.settings.without) & IMPLICIT or something_slides(column.work):
        return explicit, min(step, control.explicit_step) if counts.implicit == 1 else step
    worth = 0.5 if explicit == ORDER_8 else 1.0
    many = column.model.n >= MANY
    probe = PROBE_OF_MANY if many and explicit == ORDER_8 else PROBE
    if counts.implicit == 1:
        further = min(step, left) > GAIN * worth * control.explicit_step
        return LINEARLY_IMPLICIT if further else explicit, step
    if counts.in_flight == 1:  # nothing there is stiff, and an implicit step would see too little of the landing
        return explicit, step
    if counts.since_probe >= (STEPS_OF_MANY if many else STEPS_PER_PROBE) and probe * step <= left:
        counts.since_probe = 0
        return LINEARLY_IMPLICIT, probe * step
    return explicit, step


@kernel
def accepts(column, method, step, code, error):
    """Whether a step just tried is good enough; proposes the next one either way."""
    counts, control = column.counts, column.state.control
    traits = traits_of(method)
    per_order = 1.0 / traits.order
    if code != OK or not error <= 1.0:
        counts.rejected += 1
        if traits.implicit and counts.implicit == 0:  # a probe that failed: go on as before
            return False
        factor = SHRINK
        if code == OK and math.isfinite(error):
            factor = max(SHRINK, SAFETY * error**-per_order)
        control.next_step = step * factor
        control.previous_error = 1.0
        return False
    error = max(error, LEAST_ERROR)
    factor = SAFETY * math.exp(
        per_order * (PROPORTIONAL * math.log(control.previous_error) - INTEGRAL * math.log(error))
    )
    factor = min(GROW, max(SHRINK, factor))
    # one cut short says nothing against the longer one proposed before
    whole = step >= control.next_step * (1.0 - SLACK)
    if whole:
        control.previous_error = error
    if traits.implicit:
        counts.implicit_steps += 1
        counts.implicit = 1
    else:
        counts.since_probe += 1
        if whole:
            control.explicit_step += SMOOTHING * (step - control.explicit_step)
            counts.implicit = 0
    control.next_step = step * factor if factor < 1.0 else max(step * factor, control.next_step)
    return True


@kernel
def accepts_elastic(column, step, code, error):
    """Whether a modal step just tried is good enough; proposes the next one either way."""
    counts, control = column.counts, column.state.control
    if code != OK:
        counts.rejected += 1
        counts.elastic_wait = WAIT_OPEN
        return False
    if error > 1.0:
        counts.rejected += 1
        control.elastic_step = step * max(SHRINK, SAFETY * error ** (-1.0 / modal.ORDER))
        if control.elastic_step < ELASTIC_COST * control.next_step:
            counts.elastic_wait = WAIT_SHORT
            control.elastic_step = control.next_step
        return False
    counts.elastic_steps += 1
    # steps that stay the same share their responses: no change without need
    if error > SAFETY:
        control.elastic_step = step * SAFETY
    elif error < SPARE and step * GROW > control.elastic_step:
        longer = step * min(GROW, SAFETY * max(error, LEAST_ERROR) ** (-1.0 / modal.ORDER))
        control.elastic_step = max(control.elastic_step, longer)
    return True
