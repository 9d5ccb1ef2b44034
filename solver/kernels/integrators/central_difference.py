"""Central differences at a fixed step, the paper's integrator.

Written with the velocities at the steps (velocity Verlet), which gives the same displacements as u(t+h) - 2 u(t) +
u(t-h) = h^2 u''(t) and its usual start, without the loss of digits in the second difference. Order 2, symplectic. The
rates that dampers and velocity terms need at the new time are the half-step rates carried on with the last
acceleration.
"""

from ..dynamics import accelerate
from ..jit import kernel
from ..layout import N_BLOCKS, PHASE_END, PHASE_START


@kernel
def attempt(model, inputs, work, counters, scale, rate_scale, t, h):
    """One step; the error is not estimated."""
    size = 2 * int(model[N_BLOCKS])
    start = 3 * size * PHASE_START
    end = 3 * size * PHASE_END
    for i in range(size):
        acceleration = work[start + 2 * size + i]
        half_rate = work[start + size + i] + 0.5 * h * acceleration
        work[end + i] = work[start + i] + h * half_rate
        work[end + size + i] = half_rate + 0.5 * h * acceleration
        work[end + 2 * size + i] = acceleration
    code = accelerate(model, inputs, work, end, t + h, work, counters)
    for i in range(size):
        change = work[end + 2 * size + i] - work[start + 2 * size + i]
        work[end + size + i] += 0.5 * h * change
    return code, 0.0
