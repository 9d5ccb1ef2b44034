"""Step control: the method of the next step, acceptance of a step, and the length of the next one."""

from ...engine.control import ELASTIC_COST, STEPS_PER_PROBE, WAIT_OPEN, go_on, may_be_elastic, shorten
from ...layout.spaces import IMPLICIT
from ...numba_ext.jit import kernel, leaf
from ..formulations.base_motion import wave_amplitude
from ..formulations.loads import is_loaded
from ..formulations.slips import something_slides
from ..integrators import modal
from ..integrators.traits import LINEARLY_IMPLICIT, ORDER_8, explicit_method, traits_of

# when `auto` changes its method
GAIN = 2.2  # ratio of implicit to explicit step from which the implicit method is used
PROBE = 4.0  # times the explicit step: length of a trial step of the implicit method
MANY = 8  # blocks from which the implicit method mostly pays: probed sooner, and with shorter steps besides order 8
PROBE_OF_MANY = 1.5
STEPS_OF_MANY = 40
SMOOTHING = 0.2


@leaf
def within_a_cycle(column, step):
    """Return the step (s), limited to one radian of the harmonic base motion."""
    if wave_amplitude(column.base, column.samples) != 0.0:
        return min(step, 1.0 / column.base.wave_omega)
    return step


@kernel
def elastic_step(column, most):
    """Return the next modal step of `auto` (s, at most `most`), or 0 if the modal method should not be attempted."""
    model, counts, control = column.model, column.counts, column.state.control
    if not modal.available(model) or is_loaded(column):  # modes know of no loads
        return 0.0
    longest = modal.longest_step(model)
    if not may_be_elastic(counts, control, longest, most, ELASTIC_COST):
        return 0.0
    if not modal.suits(column):
        counts.elastic_wait = WAIT_OPEN
        return 0.0
    return within_a_cycle(column, min(control.elastic_step, longest))


@kernel
def general_step(column, left):
    """Return (method, step in s) of the next general step of `auto`, where joints may open; `left` s remain.

    An implicit step costs about as much as an explicit one of order 5, and half as much as one of order 8: the method
    with the longer step at equal cost is used. The implicit one is given up when its step is not longer; occasionally
    it is attempted with a longer step.
    """
    counts, control = column.counts, column.state.control
    step = within_a_cycle(column, control.next_step)
    explicit = explicit_method(column.model.settings.explicit_order)
    if int(column.model.settings.without) & IMPLICIT or something_slides(column.work):
        return explicit, min(step, control.explicit_step) if counts.implicit == 1 else step
    # relative cost, and length of a probe
    worth = 0.5 if explicit == ORDER_8 else 1.0
    many = column.model.n >= MANY
    probe = PROBE_OF_MANY if many and explicit == ORDER_8 else PROBE
    if counts.implicit == 1:
        further = min(step, left) > GAIN * worth * control.explicit_step
        return LINEARLY_IMPLICIT if further else explicit, step
    if counts.in_flight == 1:  # in flight the column is not stiff, and an implicit step would not resolve the landing
        return explicit, step
    if counts.since_probe >= (STEPS_OF_MANY if many else STEPS_PER_PROBE) and probe * step <= left:
        counts.since_probe = 0
        return LINEARLY_IMPLICIT, probe * step
    return explicit, step


@kernel
def accepts(column, method, step, error):
    """Return True if the attempted step (s) is accurate enough; set the length of the next one in either case."""
    counts, control = column.counts, column.state.control
    traits = traits_of(method)
    per_order = 1.0 / traits.order
    if not error <= 1.0:
        counts.rejected += 1
        if traits.implicit and counts.implicit == 0:  # a failed probe: continue with the explicit method
            return False
        shorten(control, step, error, per_order)
        return False
    # accepted: next step, counters, and the mean length of explicit steps
    whole = go_on(control, step, error, per_order)
    if traits.implicit:
        counts.implicit_steps += 1
        counts.implicit = 1
    else:
        counts.since_probe += 1
        if whole:
            control.explicit_step += SMOOTHING * (step - control.explicit_step)
            counts.implicit = 0
    return True
