"""The evaluation of one stage of an explicit Runge-Kutta method."""

from ..dynamics import accelerate
from ..jit import kernel
from ..layout import N_BLOCKS


@kernel
def evaluate_stage(model, inputs, work, counters, here, t):
    """Accelerations of the phase at work[here:] at time t. Returns a code."""
    size = 2 * int(model[N_BLOCKS])
    for i in range(size):  # first guess for an iterated formulation
        work[here + 2 * size + i] = work[2 * size + i]
    return accelerate(model, inputs, work, here, t, work, counters)
