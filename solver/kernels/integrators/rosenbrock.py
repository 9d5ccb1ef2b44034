"""A linearly implicit W-method of order 3 with an embedded order 2, L-stable and stiffly accurate: ROS34PW2.

J. Rang, L. Angermann, New Rosenbrock W-methods of order 3 for partial differential algebraic equations of index 1, BIT
45 (2005) 761-787. A W-method keeps its order whatever stands for the Jacobian; here it is that of the joints' forces
alone, which is what makes a column stiff, so that a stage costs one evaluation and one O(n) solution (implicit.py).
Slips, where there are any, stay what they are: no step is made while a joint slides.

The stages are written for u = (u_q, u_v) as in E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
section IV.7, eq. 7.25:

    u_q = h gamma (u_v + F_q),     (M + G) u_v = h gamma M F_v - (h gamma)^2 K F_q
"""

import numpy as np

from ..formulations.either import evaluate_at
from ..formulations.implicit import factorize, solve
from ..formulations.slips import phase_size
from ..jit import kernel
from ..layout import OK
from .error import error_in_tolerances
from .stage import stage

ORDER = 3
STAGES = 4
STRICTNESS = 1.5  # errors of implicit steps add up, those of the others are mostly far below what they may be
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
    """rows @ inverse(GAMMAS), by back substitution: the same bits on every machine."""
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


@kernel
def attempt(column, t, h):
    """One step of h seconds from work.start to work.end; returns (code, error in tolerances)."""
    model, work = column.model, column.work
    n = work.n
    size = 2 * n
    start, end = work.start.row, work.end.row
    # inner stage k = 1 to 4 keeps (u_q, u_v, F_q); the phase at which its accelerations are taken is inner stage 5
    here = stage(work, 5)
    part = h * GAMMA
    for i in range(3 * size, phase_size(work)):
        here.row[i] = start[i]
        end[i] = start[i]
    factorize(model, work.start, work.tangent, part)
    for s in range(STAGES):
        u = stage(work, s + 1).row
        rates, accelerations = start[size:], start[2 * size :]  # those of the start are known
        if s > 0:
            for i in range(2 * size):
                value = start[i]
                for j in range(s):
                    value += A[s, j] * stage(work, j + 1).row[i]
                here.row[i] = value
            for i in range(size):
                here.row[2 * size + i] = start[2 * size + i]
            code = evaluate_at(column, here, t + NODES[s] * h)
            if code != OK:
                return code, 0.0
            rates, accelerations = here.row[size:], here.row[2 * size :]
        for i in range(size):
            f_q = rates[i]
            f_v = accelerations[i]
            for j in range(s):
                f_q += C[s, j] / h * stage(work, j + 1).row[i]
                f_v += C[s, j] / h * stage(work, j + 1).row[size + i]
            u[2 * size + i] = f_q
            u[size + i] = part * f_v
        solve(model, work.tangent, u[size:], u[2 * size :], part)
        for i in range(size):
            u[i] = part * (u[size + i] + u[2 * size + i])
    for i in range(2 * size):
        value = 0.0
        error = 0.0
        for j in range(STAGES):
            u_j = stage(work, j + 1).row[i]
            value += M[j] * u_j
            error += E[j] * u_j
        end[i] = start[i] + value
        work.between.row[i] = error
    for i in range(3 * size, phase_size(work)):
        work.between.row[i] = 0.0
    for i in range(size):
        end[2 * size + i] = start[2 * size + i]
    error = STRICTNESS * error_in_tolerances(column, work.between)
    return evaluate_at(column, work.end, t + h), error
