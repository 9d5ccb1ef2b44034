"""The coefficients of the Runge-Kutta method of order 8 of Dormand and Prince, and its sums over stages.

P. J. Prince, J. R. Dormand, High order embedded Runge-Kutta formulae, J. Comp. Appl. Math. 7 (1981) 67-75; E. Hairer,
S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), section II.10: DOP853. The
evaluation at the end is the first stage of the next step.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..numba_ext.jit import leaf
from ..numba_ext.views import packs_of

ORDER = 8


LEEWAY = 2.0  # times a step's share: largest estimate, which is that of a lower order


STAGES = 11  # inner ones


C4, C9, C10 = 0.2816496580927726, 3 / 5, 6 / 7


# fmt: off
NODES = np.array([
    0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, C4, 1 / 3, 1 / 4, 4 / 13, 127 / 195, C9, C10, 1.0
])


# of the sums for the stages and the end, and of order 8 less an embedded order 5, and less one of order 3: the weight
# of the first slope, then those of the latest slopes; slopes in between have none
_SUMS = (
    (0.05260015195876773,),
    (0.0197250569845379, 0.0591751709536137),
    (0.02958758547680685, 0.08876275643042054),
    (0.2413651341592667, -0.8845494793282861, 0.924834003261792),
    (0.037037037037037035, 0.17082860872947386, 0.12546768756682242),
    (0.037109375, 0.17025221101954405, 0.06021653898045596, -0.017578125),
    (0.03709200011850479, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023),
    (0.6241109587160757, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894,
     -43.48988418106996),
    (0.47766253643826434, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423,
     -33.28821096898486, -0.020331201708508627),
    (-0.9371424300859873, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696,
     22.739487099350505, 2.4936055526796523, -3.0467644718982196),
    (2.273310147516538, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996,
     -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636),
    (0.054293734116568765, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199,
     -0.1521609496625161, 0.20136540080403034, 0.04471061572777259),
    (0.01312004499419488, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366,
     0.3341791187130175, 0.08192320648511571, -0.022355307863886294),
    (-0.18980075407240762, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919,
     -0.1521609496625161, 0.20136540080403034, 0.02265179219836082),
)
# fmt: on


# fmt: on
END, ERROR_5, ERROR_3 = 12, 13, 14  # rows of the table, as the stages by their numbers


WEIGHTS = np.zeros((len(_SUMS) + 1, STAGES + 1))


FIRST = np.zeros(len(_SUMS) + 1, dtype=np.int64)  # of the latest slopes


for _row, (_of_first, *_latest) in enumerate(_SUMS, start=1):
    _last = min(_row, STAGES + 1)
    FIRST[_row] = _last - len(_latest)
    WEIGHTS[_row, 0], WEIGHTS[_row, FIRST[_row] : _last] = _of_first, _latest


def sum_by(row: int, slope: Callable[..., Any]) -> Any:
    """Return a leaf (work, i): pack i of the sum of slopes by a row of WEIGHTS.

    slope(work, k) returns the slope at stage k, 0 the start. Compiled once a row, with its weights as constants and the
    sum unrolled: a loop over rows takes 2 % of a run.
    """
    first, last = int(FIRST[row]), min(row, STAGES + 1)

    @leaf
    def sum_of(work, i):
        # weight of the start, then of the latest stages; those in between are zero
        found = WEIGHTS[row, 0] * packs_of(slope(work, 0))[i]
        for k in range(first, last):
            found += WEIGHTS[row, k] * packs_of(slope(work, k))[i]
        return found

    return sum_of


@leaf
def error_of(error_5, error_3):
    """Return the error estimate from the two embedded ones."""
    if error_5 == 0.0:
        return 0.0
    return error_5 * error_5 / math.sqrt(error_5 * error_5 + 0.01 * error_3 * error_3) / LEEWAY
