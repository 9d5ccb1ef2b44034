"""Steps for joints that are stiff and heavily damped: a Runge-Kutta-Legendre method of order 2.

The eigenvalues of such joints are real and negative, and their motion dies out long before the blocks have moved. A
step of s stages is stable up to (s^2 + s - 2)/2 over the largest of them, instead of 3.3 (C. D. Meyer, D. S. Balsara,
T. D. Aslam, J. Comput. Phys. 257 (2014) 594-626, the method RKL2). No Jacobian is needed: the joints may open, slide
and twist in any stage. The error is the difference to the trapezoidal rule (B. P. Sommeijer, L. F. Shampine, J. G.
Verwer, J. Comput. Appl. Math. 88 (1998) 315-326).
"""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import packs, packs_of
from .attempt import error_of_step, evaluate_at, rate, scale_quaternions
from .evaluate import moving
from .layout import PHASE, STAGES
from .watch import BETWEEN, END, RATES, STAGE, START, row

_phase = PHASE.over
ORDER = 2
LEAST_STAGES, MOST_STAGES = 3, 61
MARGIN = 1.1  # safety factor on the fastest rate
LONGEST_REACH = 0.5 * (MOST_STAGES * MOST_STAGES + MOST_STAGES - 2) / MARGIN  # longest step times the fastest rate
TIGHTER = 16.0  # factor on the error: steps of order 5 between stiff joints err far less than allowed
PLACE, SLOPE = 12.0 / 15.0, 6.0 / 15.0  # weights of the error: both states, and their rates times the step


@leaf
def stages_of(reach):
    """Return the number of stages, odd, that is stable over a step; reach: its length times the fastest rate."""
    least = 0.5 * (math.sqrt(9.0 + 8.0 * MARGIN * reach) - 1.0)
    stages = max(LEAST_STAGES, math.ceil(least))
    return stages + 1 - stages % 2


@leaf
def _weight(j):
    """Return b_j of the method."""
    return 1.0 / 3.0 if j < 2 else 0.5 * (j * j + j - 2.0) / (j * (j + 1.0))


@kernel
def attempt_stabilized(scene, segment, t, h, stages):
    """Make one step of h seconds in `stages` stages from row START to row END; return its error in tolerances."""
    begin, count = row(scene, START), packs(row(scene, START), moving(scene))
    # the start, and stage 1 by Euler's method
    y, f0, f = packs_of(begin), packs_of(rate(scene, 0)), packs_of(rate(scene, 1))
    per = 4.0 / (stages * stages + stages - 2.0)
    # three rows hold the last stages in turn
    older, newer, spare = RATES + 2, RATES + 3, STAGE
    first = packs_of(row(scene, newer))
    packs_of_start = packs_of(row(scene, older))
    for i in range(count):
        packs_of_start[i] = y[i]
        first[i] = y[i] + (h * per / 3.0) * f0[i]
    node = per / 3.0
    for j in range(2, stages + 1):
        # rates at the last stage
        evaluate_at(scene, segment, row(scene, newer), rate(scene, 1), t + node * h)
        # recursion of the shifted Legendre polynomials
        weight, before, earlier = _weight(j), _weight(j - 1), _weight(j - 2)
        mu, nu = (2.0 * j - 1.0) / j * weight / before, -(j - 1.0) / j * weight / earlier
        own, start = h * mu * per, -h * (1.0 - before) * mu * per
        into = END if j == stages else spare
        target, last, earliest = packs_of(row(scene, into)), packs_of(row(scene, newer)), packs_of(row(scene, older))
        for i in range(count):
            # differences to the start keep the digits of what hardly moves
            moved = mu * (last[i] - y[i]) + nu * (earliest[i] - y[i])
            target[i] = y[i] + (moved + (own * f[i] + start * f0[i]))
        # the two latest stages are kept
        older, newer, spare = newer, into, older
        node = (j * j + j - 2.0) * 0.25 * per
    # end of the step, and its rates
    scale_quaternions(scene.n, _phase(row(scene, END), scene.n))
    evaluate_at(scene, segment, row(scene, END), rate(scene, STAGES - 1), t + h)
    # the difference to the trapezoidal rule
    end, last, error = packs_of(row(scene, END)), packs_of(rate(scene, STAGES - 1)), packs_of(row(scene, BETWEEN))
    for i in range(count):
        error[i] = PLACE * (y[i] - end[i]) + SLOPE * h * (f0[i] + last[i])
    return TIGHTER * error_of_step(scene, h)
