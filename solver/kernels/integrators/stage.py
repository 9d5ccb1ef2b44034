"""The phases inside a step: the inner stages of a Runge-Kutta method."""

from ..jit import leaf
from ..layout import PHASE, PHASE_FIELDS

_phase = PHASE.over


@leaf
def stage(work, k):
    """The phase of inner stage k, counted from 1."""
    n = work.n
    return _phase(work.stages[PHASE_FIELDS * n * (k - 1) :], n)
