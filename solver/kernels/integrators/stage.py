"""The phases inside a step: the inner stages of a Runge-Kutta method, and what is summed up to make one."""

from ..jit import by_width, leaf
from ..joint.sliding import has_no_slips
from ..lanes import LANES
from ..layout import PHASE, PHASE_FIELDS

_phase = PHASE.over


@leaf
def stage(work, k):
    """The phase of inner stage k, counted from 1."""
    n = work.n
    return _phase(work.stages[PHASE_FIELDS * n * (k - 1) :], n)


def summed(work):
    """How many numbers of a phase, from its first, hold all that a step carries on by the numbers 2 n behind them."""
    raise NotImplementedError("for kernels only")


@by_width(summed)
def _choose(work):
    if has_no_slips(work):
        return lambda work: 4 * work.n
    if work.kind is LANES:
        return lambda work: 9 * work.n
    return lambda work: 9 * work.n if work.slips.count != 0.0 else 4 * work.n
