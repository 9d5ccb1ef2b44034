"""Dormand and Prince's explicit Runge-Kutta pair of orders 5(4).

J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26, RK5(4)7M.
The last stage is the first of the next step.
"""

import numpy as np

from ..dynamics import accelerate, base_acceleration
from ..jit import kernel
from ..layout import N_BLOCKS, OK, PHASE_BETWEEN
from .error import error_in_tolerances

STAGES = 7
ORDER = 5

NODES = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
STAGE_WEIGHTS = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
        [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
# order 5 less the embedded order 4
ERROR_WEIGHTS = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])


@kernel
def attempt(model, inputs, work, counters, scale, rate_scale, t, h):
    """One step and its error, relative to tolerance times scale (rad) and rate_scale (rad/s)."""
    size = 2 * int(model[N_BLOCKS])
    phase = 3 * size  # stage k is the phase k of the work array
    for stage in range(1, STAGES):
        here = phase * stage
        for i in range(2 * size):
            slope = STAGE_WEIGHTS[stage, 0] * work[size + i]
            for j in range(1, stage):
                slope += STAGE_WEIGHTS[stage, j] * work[phase * j + size + i]
            work[here + i] = work[i] + h * slope
        for i in range(size):  # first guess for an iterated formulation
            work[here + 2 * size + i] = work[2 * size + i]
        base_ax, base_az = base_acceleration(inputs, t + NODES[stage] * h)
        code = accelerate(model, work, here, base_ax, base_az, work, counters)
        if code != OK:
            return code, 0.0

    difference = PHASE_BETWEEN * phase
    for i in range(2 * size):
        value = ERROR_WEIGHTS[0] * work[size + i]
        for stage in range(2, STAGES):
            value += ERROR_WEIGHTS[stage] * work[phase * stage + size + i]
        work[difference + i] = h * value
    return OK, error_in_tolerances(model, work, difference, scale, rate_scale)
