"""Dormand and Prince's explicit Runge-Kutta pair of orders 5(4) with the larger region of stability.

J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26, RK5(4)7S.
Its steps may be 12 % longer than those of RK5(4)7M for joint modes at 0.6 of the critical damping, 70 % for modes
damped critically. The last stage is the first of the next step. Written out, because a compiler that sees each sum
whole works on several unknowns at once.
"""

from ..jit import kernel, place
from ..layout import N_BLOCKS, OK, PHASE_BETWEEN, PHASE_END
from .error import error_in_tolerances
from .stage import evaluate_stage

ORDER = 5
INSIDE = (2, 3, 4)  # stages at 1/3, 5/9 and 2/3 of the step

C1, C2, C3, C4, C5 = 2 / 9, 1 / 3, 5 / 9, 2 / 3, 1.0
A1_0 = 2 / 9
A2_0, A2_1 = 1 / 12, 1 / 4
A3_0, A3_1, A3_2 = 55 / 324, -25 / 108, 50 / 81
A4_0, A4_1, A4_2, A4_3 = 83 / 330, -13 / 22, 61 / 66, 9 / 110
A5_0, A5_1, A5_2, A5_3, A5_4 = -19 / 28, 9 / 4, 1 / 7, -27 / 7, 22 / 7
B_0, B_2, B_3, B_4, B_5 = 19 / 200, 3 / 5, -243 / 400, 33 / 40, 7 / 80
# order 5 less the embedded order 4
ERROR_0, ERROR_2, ERROR_3, ERROR_4, ERROR_5, ERROR_LAST = (
    11 / 1250,
    -33 / 500,
    891 / 5000,
    -33 / 250,
    -9 / 1000,
    1 / 50,
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
