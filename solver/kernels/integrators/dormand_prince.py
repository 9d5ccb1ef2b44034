"""Dormand and Prince's explicit Runge-Kutta pair of orders 5(4).

J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26, RK5(4)7M.
The last stage is the first of the next step. Written out, because a compiler that sees each sum whole works on several
unknowns at once.
"""

from ..jit import kernel, place
from ..layout import N_BLOCKS, OK, PHASE_BETWEEN, PHASE_END
from .error import error_in_tolerances
from .stage import evaluate_stage

ORDER = 5
INSIDE = (2, 2, 3)  # stages at 0.3 and 0.8 of the step

C1, C2, C3, C4, C5 = 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0
A1_0 = 1 / 5
A2_0, A2_1 = 3 / 40, 9 / 40
A3_0, A3_1, A3_2 = 44 / 45, -56 / 15, 32 / 9
A4_0, A4_1, A4_2, A4_3 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
A5_0, A5_1, A5_2, A5_3, A5_4 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
B_0, B_2, B_3, B_4, B_5 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
# order 5 less the embedded order 4
ERROR_0, ERROR_2, ERROR_3, ERROR_4, ERROR_5, ERROR_LAST = (
    71 / 57600,
    -71 / 16695,
    71 / 1920,
    -17253 / 339200,
    22 / 525,
    -1 / 40,
)


@kernel
def attempt(model, inputs, work, counters, scale, rate_scale, t, h):
    """One step and its error, relative to tolerance times scale (rad) and rate_scale (rad/s)."""
    size = place(2 * int(model[N_BLOCKS]))
    p = 3 * size  # stage k is phase k of the work array
    rates = size  # slopes are rates and accelerations
    end = PHASE_END * p
    for i in range(2 * size):
        work[p + i] = work[i] + h * (A1_0 * work[rates + i])
    code = evaluate_stage(model, inputs, work, counters, p, t + C1 * h)
    if code != OK:
        return code, 0.0
    for i in range(2 * size):
        work[2 * p + i] = work[i] + h * (A2_0 * work[rates + i] + A2_1 * work[p + rates + i])
    code = evaluate_stage(model, inputs, work, counters, 2 * p, t + C2 * h)
    if code != OK:
        return code, 0.0
    for i in range(2 * size):
        work[3 * p + i] = work[i] + h * (
            A3_0 * work[rates + i] + A3_1 * work[p + rates + i] + A3_2 * work[2 * p + rates + i]
        )
    code = evaluate_stage(model, inputs, work, counters, 3 * p, t + C3 * h)
    if code != OK:
        return code, 0.0
    for i in range(2 * size):
        work[4 * p + i] = work[i] + h * (
            A4_0 * work[rates + i]
            + A4_1 * work[p + rates + i]
            + A4_2 * work[2 * p + rates + i]
            + A4_3 * work[3 * p + rates + i]
        )
    code = evaluate_stage(model, inputs, work, counters, 4 * p, t + C4 * h)
    if code != OK:
        return code, 0.0
    for i in range(2 * size):
        work[5 * p + i] = work[i] + h * (
            A5_0 * work[rates + i]
            + A5_1 * work[p + rates + i]
            + A5_2 * work[2 * p + rates + i]
            + A5_3 * work[3 * p + rates + i]
            + A5_4 * work[4 * p + rates + i]
        )
    code = evaluate_stage(model, inputs, work, counters, 5 * p, t + C5 * h)
    if code != OK:
        return code, 0.0
    for i in range(2 * size):
        work[end + i] = work[i] + h * (
            B_0 * work[rates + i]
            + B_2 * work[2 * p + rates + i]
            + B_3 * work[3 * p + rates + i]
            + B_4 * work[4 * p + rates + i]
            + B_5 * work[5 * p + rates + i]
        )
    code = evaluate_stage(model, inputs, work, counters, end, t + h)
    if code != OK:
        return code, 0.0
    difference = PHASE_BETWEEN * p
    for i in range(2 * size):
        work[difference + i] = h * (
            ERROR_0 * work[rates + i]
            + ERROR_2 * work[2 * p + rates + i]
            + ERROR_3 * work[3 * p + rates + i]
            + ERROR_4 * work[4 * p + rates + i]
            + ERROR_5 * work[5 * p + rates + i]
            + ERROR_LAST * work[end + rates + i]
        )
    error = error_in_tolerances(model, work, difference, scale, rate_scale)
    return OK, error
