"""Central differences at a fixed step, the paper's integrator.

Written with the velocities at the steps (velocity Verlet), which gives the same displacements as u(t+h) - 2 u(t) +
u(t-h) = h^2 u''(t) and its usual start, without the loss of digits in the second difference. Order 2, symplectic. The
rates that dampers and velocity terms need at the new time are the half-step rates carried on with the last
acceleration.
"""

from ..formulations.either import evaluate_at
from ..jit import kernel, leaf


@leaf
def predict(work, h):
    """Coordinates at the end of a step of h seconds; rates and accelerations as the start has them carried on."""
    size = 2 * work.n
    start, end = work.start.row, work.end.row
    for i in range(size):
        acceleration = start[2 * size + i]
        half_rate = start[size + i] + 0.5 * h * acceleration
        end[i] = start[i] + h * half_rate
        end[size + i] = half_rate + 0.5 * h * acceleration
        end[2 * size + i] = acceleration


@leaf
def correct(work, h):
    """Rates at the end of a step from the accelerations there."""
    size = 2 * work.n
    start, end = work.start.row, work.end.row
    for i in range(size):
        change = end[2 * size + i] - start[2 * size + i]
        end[size + i] += 0.5 * h * change


@kernel
def attempt(column, t, h):
    """One step of h seconds from work.start to work.end; returns (code, 0.0): the error is not estimated."""
    predict(column.work, h)
    code = evaluate_at(column, column.work.end, t + h)
    correct(column.work, h)
    return code, 0.0
