"""Dormand and Prince's explicit Runge-Kutta method of order 8 with the error estimate of Hairer, Norsett and Wanner.

P. J. Prince, J. R. Dormand, High order embedded Runge-Kutta formulae, J. Comp. Appl. Math. 7 (1981) 67-75; E. Hairer,
S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), section II.10: DOP853. The
evaluation at the end is the first stage of the next step.
"""

import math

from ..formulations.dispatch import evaluate_stage
from ..layout.spaces import OK
from ..numba_ext.jit import kernel
from ..numba_ext.views import packs, packs_of
from .error import error_in_tolerances
from .stage import stage, summed

ORDER = 8
LEEWAY = 2.0  # times a step's share: largest estimate, which is that of a lower order

C1, C2, C3, C4, C5, C6, C7, C8, C9, C10, C11 = (
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    1 / 3,
    1 / 4,
    4 / 13,
    127 / 195,
    3 / 5,
    6 / 7,
    1.0,
)
A1_0 = 0.05260015195876773
A2_0, A2_1 = 0.0197250569845379, 0.0591751709536137
A3_0, A3_2 = 0.02958758547680685, 0.08876275643042054
A4_0, A4_2, A4_3 = 0.2413651341592667, -0.8845494793282861, 0.924834003261792
A5_0, A5_3, A5_4 = 0.037037037037037035, 0.17082860872947386, 0.12546768756682242
A6_0, A6_3, A6_4, A6_5 = 0.037109375, 0.17025221101954405, 0.06021653898045596, -0.017578125
A7_0, A7_3, A7_4, A7_5, A7_6 = (
    0.03709200011850479,
    0.17038392571223998,
    0.10726203044637328,
    -0.015319437748624402,
    0.008273789163814023,
)
A8_0, A8_3, A8_4, A8_5, A8_6, A8_7 = (
    0.6241109587160757,
    -3.3608926294469414,
    -0.868219346841726,
    27.59209969944671,
    20.154067550477894,
    -43.48988418106996,
)
A9_0, A9_3, A9_4, A9_5, A9_6, A9_7, A9_8 = (
    0.47766253643826434,
    -2.4881146199716677,
    -0.590290826836843,
    21.230051448181193,
    15.279233632882423,
    -33.28821096898486,
    -0.020331201708508627,
)
A10_0, A10_3, A10_4, A10_5, A10_6, A10_7, A10_8, A10_9 = (
    -0.9371424300859873,
    5.186372428844064,
    1.0914373489967295,
    -8.149787010746927,
    -18.52006565999696,
    22.739487099350505,
    2.4936055526796523,
    -3.0467644718982196,
)
A11_0, A11_3, A11_4, A11_5, A11_6, A11_7, A11_8, A11_9, A11_10 = (
    2.273310147516538,
    -10.53449546673725,
    -2.0008720582248625,
    -17.9589318631188,
    27.94888452941996,
    -2.8589982771350235,
    -8.87285693353063,
    12.360567175794303,
    0.6433927460157636,
)
B_0, B_5, B_6, B_7, B_8, B_9, B_10, B_11 = (
    0.054293734116568765,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    0.3111643669578199,
    -0.1521609496625161,
    0.20136540080403034,
    0.04471061572777259,
)
# order 8 less an embedded order 5, and less one of order 3
ERROR_5_0, ERROR_5_5, ERROR_5_6, ERROR_5_7, ERROR_5_8, ERROR_5_9, ERROR_5_10, ERROR_5_11 = (
    0.01312004499419488,
    -1.2251564463762044,
    -0.4957589496572502,
    1.6643771824549864,
    -0.35032884874997366,
    0.3341791187130175,
    0.08192320648511571,
    -0.022355307863886294,
)
ERROR_3_0, ERROR_3_5, ERROR_3_6, ERROR_3_7, ERROR_3_8, ERROR_3_9, ERROR_3_10, ERROR_3_11 = (
    -0.18980075407240762,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    -0.4226823213237919,
    -0.1521609496625161,
    0.20136540080403034,
    0.02265179219836082,
)


@kernel
def attempt(column, t, h):
    """One step of h seconds from work.start to work.end; returns (code, error in tolerances)."""
    work = column.work
    count = packs(work.start.row, summed(work))  # coordinates and rates, whose slopes are rates and accelerations
    y, f0 = packs_of(work.start.row), packs_of(work.start.rates)
    y1, f1 = packs_of(stage(work, 1).row), packs_of(stage(work, 1).rates)
    y2, f2 = packs_of(stage(work, 2).row), packs_of(stage(work, 2).rates)
    y3, f3 = packs_of(stage(work, 3).row), packs_of(stage(work, 3).rates)
    y4, f4 = packs_of(stage(work, 4).row), packs_of(stage(work, 4).rates)
    y5, f5 = packs_of(stage(work, 5).row), packs_of(stage(work, 5).rates)
    y6, f6 = packs_of(stage(work, 6).row), packs_of(stage(work, 6).rates)
    y7, f7 = packs_of(stage(work, 7).row), packs_of(stage(work, 7).rates)
    y8, f8 = packs_of(stage(work, 8).row), packs_of(stage(work, 8).rates)
    y9, f9 = packs_of(stage(work, 9).row), packs_of(stage(work, 9).rates)
    y10, f10 = packs_of(stage(work, 10).row), packs_of(stage(work, 10).rates)
    y11, f11 = packs_of(stage(work, 11).row), packs_of(stage(work, 11).rates)
    end, error = packs_of(work.end.row), packs_of(work.between.row)
    for i in range(count):
        y1[i] = y[i] + h * (A1_0 * f0[i])
    code = evaluate_stage(column, stage(work, 1), t + C1 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y2[i] = y[i] + h * (A2_0 * f0[i] + A2_1 * f1[i])
    code = evaluate_stage(column, stage(work, 2), t + C2 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y3[i] = y[i] + h * (A3_0 * f0[i] + A3_2 * f2[i])
    code = evaluate_stage(column, stage(work, 3), t + C3 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y4[i] = y[i] + h * (A4_0 * f0[i] + A4_2 * f2[i] + A4_3 * f3[i])
    code = evaluate_stage(column, stage(work, 4), t + C4 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y5[i] = y[i] + h * (A5_0 * f0[i] + A5_3 * f3[i] + A5_4 * f4[i])
    code = evaluate_stage(column, stage(work, 5), t + C5 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y6[i] = y[i] + h * (A6_0 * f0[i] + A6_3 * f3[i] + A6_4 * f4[i] + A6_5 * f5[i])
    code = evaluate_stage(column, stage(work, 6), t + C6 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y7[i] = y[i] + h * (A7_0 * f0[i] + A7_3 * f3[i] + A7_4 * f4[i] + A7_5 * f5[i] + A7_6 * f6[i])
    code = evaluate_stage(column, stage(work, 7), t + C7 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y8[i] = y[i] + h * (A8_0 * f0[i] + A8_3 * f3[i] + A8_4 * f4[i] + A8_5 * f5[i] + A8_6 * f6[i] + A8_7 * f7[i])
    code = evaluate_stage(column, stage(work, 8), t + C8 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y9[i] = y[i] + h * (
            A9_0 * f0[i] + A9_3 * f3[i] + A9_4 * f4[i] + A9_5 * f5[i] + A9_6 * f6[i] + A9_7 * f7[i] + A9_8 * f8[i]
        )
    code = evaluate_stage(column, stage(work, 9), t + C9 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y10[i] = y[i] + h * (
            A10_0 * f0[i]
            + A10_3 * f3[i]
            + A10_4 * f4[i]
            + A10_5 * f5[i]
            + A10_6 * f6[i]
            + A10_7 * f7[i]
            + A10_8 * f8[i]
            + A10_9 * f9[i]
        )
    code = evaluate_stage(column, stage(work, 10), t + C10 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        y11[i] = y[i] + h * (
            A11_0 * f0[i]
            + A11_3 * f3[i]
            + A11_4 * f4[i]
            + A11_5 * f5[i]
            + A11_6 * f6[i]
            + A11_7 * f7[i]
            + A11_8 * f8[i]
            + A11_9 * f9[i]
            + A11_10 * f10[i]
        )
    code = evaluate_stage(column, stage(work, 11), t + C11 * h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        end[i] = y[i] + h * (
            B_0 * f0[i]
            + B_5 * f5[i]
            + B_6 * f6[i]
            + B_7 * f7[i]
            + B_8 * f8[i]
            + B_9 * f9[i]
            + B_10 * f10[i]
            + B_11 * f11[i]
        )
    code = evaluate_stage(column, work.end, t + h)
    if code != OK:
        return code, 0.0
    for i in range(count):
        error[i] = h * (
            ERROR_5_0 * f0[i]
            + ERROR_5_5 * f5[i]
            + ERROR_5_6 * f6[i]
            + ERROR_5_7 * f7[i]
            + ERROR_5_8 * f8[i]
            + ERROR_5_9 * f9[i]
            + ERROR_5_10 * f10[i]
            + ERROR_5_11 * f11[i]
        )
    error_5 = error_in_tolerances(column, work.between)
    for i in range(count):
        error[i] = h * (
            ERROR_3_0 * f0[i]
            + ERROR_3_5 * f5[i]
            + ERROR_3_6 * f6[i]
            + ERROR_3_7 * f7[i]
            + ERROR_3_8 * f8[i]
            + ERROR_3_9 * f9[i]
            + ERROR_3_10 * f10[i]
            + ERROR_3_11 * f11[i]
        )
    error_3 = error_in_tolerances(column, work.between)
    if error_5 == 0.0:
        return OK, 0.0
    return OK, error_5 * error_5 / math.sqrt(error_5 * error_5 + 0.01 * error_3 * error_3) / LEEWAY
