"""Dormand and Prince's explicit Runge-Kutta pair of orders 5(4).

J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26, RK5(4)7M.
The last stage is the first of the next step.
"""

import numpy as np

from ..dynamics import accelerate, base_acceleration
from ..jit import kernel
from ..layout import (
    BLOCK_FIELDS,
    MODEL_HEADER,
    N_BLOCKS,
    OK,
    OPEN_SIZE,
    PHASE_END,
    PHASE_STAGE,
    PHASE_START,
    TOLERANCE,
    TURN_SIZE,
)

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
def _stage_offset(stage, size):
    """Offset of a stage's phase in the work array: the first is the step's start, the last its end."""
    if stage == 0:
        return 3 * size * PHASE_START
    if stage == STAGES - 1:
        return 3 * size * PHASE_END
    return 3 * size * (PHASE_STAGE + stage - 1)


@kernel
def attempt(model, inputs, work, counters, scale, rate_scale, t, h):
    """One step and its error, relative to tolerance times scale (rad) and rate_scale (rad/s)."""
    n = int(model[N_BLOCKS])
    size = 2 * n
    start = _stage_offset(0, size)
    for stage in range(1, STAGES):
        here = _stage_offset(stage, size)
        for i in range(size):
            work[here + i] = 0.0
            work[here + size + i] = 0.0
        for j in range(stage):
            weight = STAGE_WEIGHTS[stage, j]
            if weight != 0.0:
                there = _stage_offset(j, size)
                for i in range(2 * size):
                    work[here + i] += weight * work[there + size + i]
        for i in range(2 * size):
            work[here + i] = work[start + i] + h * work[here + i]
        for i in range(size):  # first guess for an iterated formulation
            work[here + 2 * size + i] = work[start + 2 * size + i]
        base_ax, base_az = base_acceleration(inputs, t + NODES[stage] * h)
        code = accelerate(model, work, here, base_ax, base_az, work, counters)
        if code != OK:
            return code, 0.0

    error = 0.0
    for i in range(2 * size):
        difference = 0.0
        for stage in range(STAGES):
            difference += ERROR_WEIGHTS[stage] * work[_stage_offset(stage, size) + size + i]
        k = i if i < size else i - size
        unit = scale if i < size else rate_scale
        if k < n:
            unit *= model[MODEL_HEADER + BLOCK_FIELDS * k + TURN_SIZE]
        else:
            unit *= model[MODEL_HEADER + BLOCK_FIELDS * (k - n) + OPEN_SIZE]
        part = abs(h * difference) / (model[TOLERANCE] * unit)
        if not part <= error:  # keeps a part that is not a number
            error = part
    return OK, error
