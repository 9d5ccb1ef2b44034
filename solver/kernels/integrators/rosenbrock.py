"""A linearly implicit W-method of order 3 with an embedded order 2, L-stable and stiffly accurate: ROS34PW2.

J. Rang, L. Angermann, New Rosenbrock W-methods of order 3 for partial differential algebraic equations of index 1, BIT
45 (2005) 761-787. A W-method keeps its order with any approximation of the Jacobian; here it is that of the joints'
forces alone, which make a column stiff, so that a stage costs one evaluation and one O(n) solution (implicit.py).
Slips, if there are any, stay constant: no step is made while a joint slides.

The stages are written for u = (u_q, u_v) as in E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
section IV.7, eq. 7.25:

    u_q = h gamma (u_v + F_q),     (M + G) u_v = h gamma M F_v - (h gamma)^2 K F_q
"""

import numpy as np

from ..formulations.dispatch import evaluate_at
from ..formulations.implicit import factorize, solve
from ..formulations.slips import keep_slips, phase_size
from ..layout.spaces import OK, RIGID_FIELDS
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import packs, packs_of
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
    """rows @ inverse(GAMMAS), by back substitution: equal bits on every machine."""
    result = np.zeros_like(rows)
    for i in range(len(rows)):
        for j in range(STAGES - 1, -1, -1):
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


# coefficients of the sums below, by stage and by those before it
A1_0, A2_0, A2_1, A3_0, A3_1, A3_2 = (float(A[i, j]) for i in range(STAGES) for j in range(i))
C1_0, C2_0, C2_1, C3_0, C3_1, C3_2 = (float(C[i, j]) for i in range(STAGES) for j in range(i))
M_0, M_1, M_2, M_3 = M.tolist()
E_0, E_1, E_2, E_3 = E.tolist()


@leaf
def _solve(column, u, part):
    """Finish an inner stage; its F_q, and h gamma F_v in the place of u_v, are known."""
    n = column.work.n
    solve(column.model, column.work.tangent, u.rates, u.accelerations, part)
    for i in range(2 * n):
        u.coordinates[i] = part * (u.rates[i] + u.accelerations[i])


@kernel
def attempt(column, t, h):
    """One step of h seconds from work.start to work.end; returns (code, error in tolerances)."""
    work = column.work
    n = work.n
    # an inner stage keeps (u_q, u_v, F_q); the phase at which its accelerations are taken is the fifth
    one, two, three, four, here = stage(work, 1), stage(work, 2), stage(work, 3), stage(work, 4), stage(work, 5)
    every, half = packs(work.start.row, 4 * n), packs(work.start.row, 2 * n)
    y, v, f = packs_of(work.start.row), packs_of(work.start.rates), packs_of(work.start.accelerations)
    y_here, v_here, f_here = packs_of(here.row), packs_of(here.rates), packs_of(here.accelerations)
    u1, v1, f1 = packs_of(one.row), packs_of(one.rates), packs_of(one.accelerations)
    u2, v2, f2 = packs_of(two.row), packs_of(two.rates), packs_of(two.accelerations)
    u3, v3, f3 = packs_of(three.row), packs_of(three.rates), packs_of(three.accelerations)
    u4, v4, f4 = packs_of(four.row), packs_of(four.rates), packs_of(four.accelerations)
    end, error = packs_of(work.end.row), packs_of(work.between.row)
    part, per = h * GAMMA, 1.0 / h
    factorize(column.model, work.start, work.tangent, part)
    # F_q after u_v; the last pack of eight reaches beyond its end
    for i in range(half):
        v1[i] = part * f[i]
    for i in range(half):
        f1[i] = v[i]
    _solve(column, one, part)
    for i in range(every):
        y_here[i] = y[i] + A1_0 * u1[i]
    keep_slips(work, here)
    code = evaluate_at(column, here, t + NODES[1] * h)
    if code != OK:
        return code, 0.0
    for i in range(half):
        v2[i] = part * (f_here[i] + per * (C1_0 * v1[i]))
    for i in range(half):
        f2[i] = v_here[i] + per * (C1_0 * u1[i])
    _solve(column, two, part)
    for i in range(every):
        y_here[i] = y[i] + (A2_0 * u1[i] + A2_1 * u2[i])
    keep_slips(work, here)
    code = evaluate_at(column, here, t + NODES[2] * h)
    if code != OK:
        return code, 0.0
    for i in range(half):
        v3[i] = part * (f_here[i] + per * (C2_0 * v1[i] + C2_1 * v2[i]))
    for i in range(half):
        f3[i] = v_here[i] + per * (C2_0 * u1[i] + C2_1 * u2[i])
    _solve(column, three, part)
    for i in range(every):
        y_here[i] = y[i] + (A3_0 * u1[i] + A3_1 * u2[i] + A3_2 * u3[i])
    keep_slips(work, here)
    code = evaluate_at(column, here, t + NODES[3] * h)
    if code != OK:
        return code, 0.0
    for i in range(half):
        v4[i] = part * (f_here[i] + per * (C3_0 * v1[i] + C3_1 * v2[i] + C3_2 * v3[i]))
    for i in range(half):
        f4[i] = v_here[i] + per * (C3_0 * u1[i] + C3_1 * u2[i] + C3_2 * u3[i])
    _solve(column, four, part)
    for i in range(every):
        end[i] = y[i] + (M_0 * u1[i] + M_1 * u2[i] + M_2 * u3[i] + M_3 * u4[i])
        error[i] = E_0 * u1[i] + E_1 * u2[i] + E_2 * u3[i] + E_3 * u4[i]
    keep_slips(work, work.end)
    for i in range(RIGID_FIELDS * n, phase_size(work)):
        work.between.row[i] = 0.0
    found = STRICTNESS * error_in_tolerances(column, work.between)
    return evaluate_at(column, work.end, t + h), found
