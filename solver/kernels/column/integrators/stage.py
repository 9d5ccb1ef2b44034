"""The phases within a step: the inner stages of a Runge-Kutta method, and the numbers that its sums take."""

from ...layout.spaces import PHASE
from ...numba_ext.jit import by_width, leaf
from ...numba_ext.lanes import LANES
from ..joint.sliding import has_no_slips

_phase, _PHASE_PER_N = PHASE.over, PHASE.per_n


@leaf
def stage(work, k):
    """Return the phase of inner stage k, counted from 1."""
    n = work.n
    return _phase(work.stages[_PHASE_PER_N * n * (k - 1) :], n)


@by_width
def summed(work):
    """Return the number of leading values of a phase that a step sums, each with its rate 2 n places behind it."""
    # coordinates and rates of rotations and openings; slips, friction work and their rates too
    if has_no_slips(work):
        return lambda work: 4 * work.n
    if work.kind is LANES:
        return lambda work: 9 * work.n
    return lambda work: 9 * work.n if work.slips.count != 0.0 else 4 * work.n
