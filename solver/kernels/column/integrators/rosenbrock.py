"""A linearly implicit W-method of order 3 with an embedded order 2, L-stable and stiffly accurate: ROS34PW2.

J. Rang, L. Angermann, New Rosenbrock W-methods of order 3 for partial differential algebraic equations of index 1, BIT
45 (2005) 761-787. A W-method keeps its order with any approximation of the Jacobian; here it is that of the joint
forces alone, which make a column stiff, so that a stage costs one evaluation and one O(n) solution (implicit.py).
Slips, if there are any, stay constant: no step is made while a joint slides.

The stages are written for u = (u_q, u_v) as in E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
section IV.7, eq. 7.25:

    u_q = h gamma (u_v + F_q),     (M + G) u_v = h gamma M F_v - (h gamma)^2 K F_q
"""

import numpy as np

from ...layout.spaces import RIGID_FIELDS
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import copy, packs, packs_of
from ..formulations.dispatch import evaluate_at
from ..formulations.implicit import factorize, solve
from ..formulations.slips import keep_slips, phase_size
from .error import error_in_tolerances
from .stage import stage

ORDER = 3
STAGES = 4
STRICTNESS = 1.5  # errors of implicit steps add up; those of other steps are mostly far below the limit
GAMMA = 4.3586652150845900e-01
ALPHA = np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [8.7173304301691801e-01, 0.0, 0.0, 0.0],
        [8.4457060015369423e-01, -1.1299064236484185e-01, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]
)
GAMMAS = np.array(
    [
        [GAMMA, 0.0, 0.0, 0.0],
        [-8.7173304301691801e-01, GAMMA, 0.0, 0.0],
        [-9.0338057013044082e-01, 5.4180672388095326e-02, GAMMA, 0.0],
        [2.4212380706095346e-01, -1.2232505839045147e00, 5.4526025533510214e-01, GAMMA],
    ]
)
WEIGHTS = np.array([2.4212380706095346e-01, -1.2232505839045147e00, 1.5452602553351020e00, 4.3586652150845900e-01])
EMBEDDED = np.array([3.7810903145819369e-01, -9.6042292212423178e-02, 0.5, 2.1793326075422950e-01])


def _over_gammas(rows: np.ndarray) -> np.ndarray:
    """Return rows @ inverse(GAMMAS), by back substitution: equal bits on every machine."""
    result = np.zeros_like(rows)
    for i in range(len(rows)):
        for j in range(STAGES - 1, -1, -1):
            # element j less the columns that are solved already
            rest = rows[i, j]
            for k in range(j + 1, STAGES):
                rest -= result[i, k] * GAMMAS[k, j]
            result[i, j] = rest / GAMMAS[j, j]
    return result


NODES = np.array([sum(row) for row in ALPHA.tolist()])
A = _over_gammas(ALPHA)
C = np.eye(STAGES) / GAMMA - _over_gammas(np.eye(STAGES))
M = _over_gammas(WEIGHTS[None, :])[0]
E = _over_gammas((WEIGHTS - EMBEDDED)[None, :])[0]


@leaf
def _solve(column, u, part):
    """Solve for an inner stage u; its F_q and, in the place of u_v, h gamma F_v are known."""
    n = column.work.n
    # u_v, then u_q (eq. 7.25)
    solve(column.model, column.work.tangent, u.rates, u.accelerations, part)
    for i in range(2 * n):
        u.coordinates[i] = part * (u.rates[i] + u.accelerations[i])


@leaf
def _summed(work, weights, count, i):
    """Return pack i of the weighted sum of inner stages 1 to `count`."""
    found = weights[0] * packs_of(stage(work, 1).row)[i]
    for k in range(1, count):
        found += weights[k] * packs_of(stage(work, k + 1).row)[i]
    return found


@leaf
def _summed_rates(work, weights, count, i):
    """Return pack i of the weighted sum of the rates (u_v) of inner stages 1 to `count`."""
    found = weights[0] * packs_of(stage(work, 1).rates)[i]
    for k in range(1, count):
        found += weights[k] * packs_of(stage(work, k + 1).rates)[i]
    return found


@kernel
def attempt(column, t, h):
    """Make one step of `h` s from `work.start` to `work.end`; return the error in tolerances."""
    work = column.work
    n = work.n
    # an inner stage keeps (u_q, u_v, F_q); the phase at which its accelerations are taken is the fifth
    here = stage(work, STAGES + 1)
    # packs of coordinates y, rates v and accelerations f
    every, half = packs(work.start.row, 4 * n), packs(work.start.row, 2 * n)
    y, v, f = packs_of(work.start.row), packs_of(work.start.rates), packs_of(work.start.accelerations)
    y_here, v_here, f_here = packs_of(here.row), packs_of(here.rates), packs_of(here.accelerations)
    end, error = packs_of(work.end.row), packs_of(work.between.row)
    part, per = h * GAMMA, 1.0 / h
    # factorize M + G at the start
    factorize(column.model, work.start, work.tangent, part)
    for k in range(STAGES):
        one = stage(work, k + 1)
        u_v, f_q = packs_of(one.rates), packs_of(one.accelerations)
        # F_q after u_v; the last pack of eight reaches beyond its end
        # right-hand sides h gamma F_v and F_q of the stage
        if k == 0:
            for i in range(half):
                u_v[i] = part * f[i]
            copy(f_q, v, half)
        else:
            for i in range(every):
                y_here[i] = y[i] + _summed(work, A[k], k, i)
            keep_slips(work, here)
            evaluate_at(column, here, t + NODES[k] * h)
            for i in range(half):
                u_v[i] = part * (f_here[i] + per * _summed_rates(work, C[k], k, i))
            for i in range(half):
                f_q[i] = v_here[i] + per * _summed(work, C[k], k, i)
        # u of the stage
        _solve(column, one, part)
    # end and embedded error
    for i in range(every):
        end[i] = y[i] + _summed(work, M, STAGES, i)
        error[i] = _summed(work, E, STAGES, i)
    keep_slips(work, work.end)
    # slips have no error
    for i in range(RIGID_FIELDS * n, phase_size(work)):
        work.between.row[i] = 0.0
    found = STRICTNESS * error_in_tolerances(column, work.between)
    evaluate_at(column, work.end, t + h)
    return found
