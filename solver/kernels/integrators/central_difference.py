"""Central differences at a fixed step, the paper's integrator.

Written with the velocities at the steps (velocity Verlet), which gives the same displacements as u(t+h) - 2 u(t) +
u(t-h) = h^2 u''(t) and its usual start, without the loss of digits in the second difference. Order 2, symplectic. The
rates that dampers and velocity terms need at the new time are the half-step rates extrapolated with the last
acceleration.
"""

from ..formulations.dispatch import evaluate_at
from ..numba_ext.jit import kernel, leaf


@leaf
def predict(work, h):
    """Coordinates at the end of a step of h seconds, with rates and accelerations extrapolated from the start."""
    start, end = work.start, work.end
    for i in range(2 * work.n):
        acceleration = start.accelerations[i]
        half_rate = start.rates[i] + 0.5 * h * acceleration
        end.coordinates[i] = start.coordinates[i] + h * half_rate
        end.rates[i] = half_rate + 0.5 * h * acceleration
        end.accelerations[i] = acceleration


@leaf
def correct(work, h):
    """Rates at the end of a step from the accelerations there."""
    start, end = work.start, work.end
    for i in range(2 * work.n):
        change = end.accelerations[i] - start.accelerations[i]
        end.rates[i] += 0.5 * h * change


@kernel
def attempt(column, t, h):
    """One step of h seconds from work.start to work.end; returns (code, 0.0): the error is not estimated."""
    predict(column.work, h)
    code = evaluate_at(column, column.work.end, t + h)
    correct(column.work, h)
    return code, 0.0
