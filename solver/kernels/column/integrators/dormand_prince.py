"""The explicit Runge-Kutta pair of Dormand and Prince of orders 5(4) with the larger region of stability.

J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26, RK5(4)7S.
Its steps may be 12 % longer than those of RK5(4)7M for joint modes at 0.6 of the critical damping, 70 % for modes
damped critically. The last stage is the first of the next step. Sums are taken over packs of eight numbers: eight
unknowns of one column, or one unknown of eight columns.
"""

from ...engine.dormand_prince import (
    A1_0,
    A2_0,
    A2_1,
    A3_0,
    A3_1,
    A3_2,
    A4_0,
    A4_1,
    A4_2,
    A4_3,
    A5_0,
    A5_1,
    A5_2,
    A5_3,
    A5_4,
    B_0,
    B_2,
    B_3,
    B_4,
    B_5,
    C1,
    C2,
    C3,
    C4,
    C5,
    ERROR_0,
    ERROR_2,
    ERROR_3,
    ERROR_4,
    ERROR_5,
    ERROR_LAST,
)
from ...numba_ext.jit import kernel
from ...numba_ext.views import packs, packs_of
from ..formulations.dispatch import evaluate_at
from .error import error_in_tolerances
from .stage import stage, summed


@kernel
def attempt(column, t, h):
    """Make one step of h s from `work.start` to `work.end`; return the error in tolerances."""
    work = column.work
    one, two, three, four, five = stage(work, 1), stage(work, 2), stage(work, 3), stage(work, 4), stage(work, 5)
    count = packs(work.start.row, summed(work))  # coordinates and rates, whose slopes are rates and accelerations
    # packs of the values y and slopes f of the stages
    y, f0 = packs_of(work.start.row), packs_of(work.start.rates)
    y1, f1 = packs_of(one.row), packs_of(one.rates)
    y2, f2 = packs_of(two.row), packs_of(two.rates)
    y3, f3 = packs_of(three.row), packs_of(three.rates)
    y4, f4 = packs_of(four.row), packs_of(four.rates)
    y5, f5 = packs_of(five.row), packs_of(five.rates)
    end, last = packs_of(work.end.row), packs_of(work.end.rates)
    # stages 1 to 5
    for i in range(count):
        y1[i] = y[i] + h * (A1_0 * f0[i])
    evaluate_at(column, one, t + C1 * h)
    for i in range(count):
        y2[i] = y[i] + h * (A2_0 * f0[i] + A2_1 * f1[i])
    evaluate_at(column, two, t + C2 * h)
    for i in range(count):
        y3[i] = y[i] + h * (A3_0 * f0[i] + A3_1 * f1[i] + A3_2 * f2[i])
    evaluate_at(column, three, t + C3 * h)
    for i in range(count):
        y4[i] = y[i] + h * (A4_0 * f0[i] + A4_1 * f1[i] + A4_2 * f2[i] + A4_3 * f3[i])
    evaluate_at(column, four, t + C4 * h)
    for i in range(count):
        y5[i] = y[i] + h * (A5_0 * f0[i] + A5_1 * f1[i] + A5_2 * f2[i] + A5_3 * f3[i] + A5_4 * f4[i])
    evaluate_at(column, five, t + C5 * h)
    # the end, of order 5
    for i in range(count):
        end[i] = y[i] + h * (B_0 * f0[i] + B_2 * f2[i] + B_3 * f3[i] + B_4 * f4[i] + B_5 * f5[i])
    evaluate_at(column, work.end, t + h)
    # embedded error estimate
    error = packs_of(work.between.row)
    for i in range(count):
        error[i] = h * (
            (ERROR_0 * f0[i] + ERROR_2 * f2[i] + ERROR_3 * f3[i])
            + (ERROR_4 * f4[i] + ERROR_5 * f5[i] + ERROR_LAST * last[i])
        )
    return error_in_tolerances(column, work.between)
