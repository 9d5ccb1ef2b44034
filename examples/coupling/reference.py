"""The coupled systems solved as one: column and partner integrated together, by classical Runge-Kutta at a small step.

No FMU and no communication: the column's equations are the kernels', the partner's are written down here once more, the
acceleration of the base is solved for in every evaluation. The joints' law has kinks, so the step is small, and two
steps tell how far the result is to be trusted.
"""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np

os.environ["MULTIBLOCK_COMPILES"] = "1"  # kernels of its own: before the solver is imported

from multiblock import Column
from solver.kernels.column.api.engine import column_over
from solver.kernels.column.formulations.dispatch import evaluate
from solver.kernels.column.formulations.exact import Motion
from solver.kernels.column.formulations.feedthrough import split_reaction
from solver.kernels.column.formulations.outputs import observe
from solver.kernels.engine.samples import no_samples
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python, kernel
from solver.kernels.numba_ext.views import row_of
from solver.models.column.packing import arrays_of

LINEAR, LEAD_RUBBER, PENDULUM, SOIL = range(4)
KINDS = {"linear": LINEAR, "lead-rubber": LEAD_RUBBER, "friction-pendulum": PENDULUM, "soil": SOIL}
# parameters of an isolator, by the names of isolator.py
ISOLATOR = ("mass", "stiffness", "damping", "strength", "yield", "radius", "friction", "g")
DEFAULTS = (40e3, 1.2e6, 0.0, 6e4, 5e-3, 2.0, 0.05, 9.80665)
_row, _split = at.ROW.over, at.SPLIT.over
OWN = 7  # unknowns of a partner: x, v, z; or x, v, z, w, theta, omega, inner rate


@kernel
def partner_rates(kind, p, own, ground, split, rates):
    """Return the rates of the partner's unknowns under the ground acceleration; returns (ax, az, alpha) of the base."""
    x, v, z = own[0], own[1], own[2]
    if kind != SOIL:
        normal = p[0] * p[7] - split.R0z
        if kind == LINEAR:
            force = -(p[1] * x + p[2] * v)
        elif kind == LEAD_RUBBER:
            force = -(p[1] * x + p[2] * v + p[3] * z)
        else:
            force = -(normal / p[5] * x + p[2] * v + p[6] * normal * z)
        ax = (force + split.R0x) / (p[0] + split.mxx)
        rates[0], rates[1] = v, ax - ground
        rates[2] = (v - 0.5 * (abs(v) * z + v * abs(z))) / p[4]
        return ax, 0.0, 0.0
    # p: mass, inertia, weight, springs and dashpots of sway, vertical, rocking, rate of the inner rotation
    w, theta, omega, inner = own[3], own[4], own[5], own[6]
    f_x = split.R0x - p[3] * x - p[4] * v
    f_z = split.R0z + p[2] - p[5] * z - p[6] * w
    f_t = split.R0m - p[7] * theta - p[8] * (omega - inner)
    # (M_own + mu g g') a = f by Sherman and Morrison: a = a_0 - M_own^-1 g mu (g . a_0) / (1 + mu g M_own^-1 g)
    mu = split.mxx + split.mzz
    g_x = math.sqrt(split.mxx / mu)
    g_z, g_t = split.mxz / (mu * g_x), split.mxt / (mu * g_x)
    a_x, a_z, a_t = f_x / p[0], f_z / p[0], f_t / p[1]
    met = mu * (g_x * a_x + g_z * a_z + g_t * a_t) / (1.0 + mu * ((g_x * g_x + g_z * g_z) / p[0] + g_t * g_t / p[1]))
    a_x, a_z, a_t = a_x - g_x / p[0] * met, a_z - g_z / p[0] * met, a_t - g_t / p[1] * met
    rates[0], rates[1], rates[2], rates[3] = v, a_x - ground, w, a_z
    rates[4], rates[5], rates[6] = omega, a_t, p[9] * (omega - inner)
    return a_x, a_z, a_t


@kernel
def all_rates(column, kind, p, y, ground, row, split, rates):
    """Return the rates (4n + OWN,) of y, rotations of the blocks absolute; returns the displacement of the top, m."""
    n, phase = column.model.n, column.state.phase
    own = y[4 * n :]
    theta, omega = (own[4], own[5]) if kind == SOIL else (0.0, 0.0)
    for i in range(4 * n):
        phase.row[i] = y[i]
    for i in range(n):
        phase.theta[i] -= theta
        phase.theta_rate[i] -= omega
    still = Motion(0.0, 0.0, theta, omega, 0.0)
    observe(column, phase, still, row)
    split_reaction(column, phase, still, row, split)
    a_x, a_z, a_t = partner_rates(kind, p, own, ground, split, rates[4 * n :])
    evaluate(column, phase, Motion(a_x, a_z, theta, omega, a_t))
    for i in range(2 * n):
        rates[i] = y[2 * n + i]
        rates[2 * n + i] = phase.row[4 * n + i]
    for i in range(n):
        rates[2 * n + i] += a_t
    return row.joints.ux[0]


@from_python
def integrate(n, arrays, kind, p, y, dt, samples, h, per, seen, parts, k, stage, out):
    """Return steps of h s under samples every dt s, linear in between; after every `per` of them a row of (ux,
    unknowns).
    """
    model, state, counts, base, work = arrays
    none = no_samples(row_of(base))
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), none, row_of(work))
    row, split = _row(row_of(seen), n), _split(row_of(parts), 0)
    size = y.size
    last = samples.size - 1
    for r in range(out.shape[0]):
        for part in range(per):
            step = r * per + part
            for s in range(4):
                c = 0.0 if s == 0 else (1.0 if s == 3 else 0.5)
                past = (step + c) * h / dt
                left = min(int(past), last - 1)
                ground = samples[left] + (past - left) * (samples[left + 1] - samples[left]) if past < last else 0.0
                for i in range(size):
                    stage[i] = y[i] + c * h * (k[s - 1, i] if s else 0.0)
                top = all_rates(column, kind, p, stage, ground, row, split, k[s])
                if step % per == 0 and s == 0:
                    out[r, 0] = top
                    for i in range(size):
                        out[r, 1 + i] = y[i]
            for i in range(size):
                y[i] += h / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])


def solve_as_one(
    column: Column,
    kind: str,
    parameters: dict[str, float],
    dt: float,
    samples: np.ndarray,
    stop: float,
    every: float = 1e-3,
    h: float = 1e-5,
) -> dict[str, Any]:
    """Return the histories every `every` s up to `stop`: time, top (ux of block 1), x, v, z, theta; and the unknowns as
    `all`.

    kind: linear, lead-rubber, friction-pendulum or soil; parameters by the names of the FMU's. samples: ground
    acceleration at k dt, m/s2.
    """
    n = column.n
    arrays = arrays_of(column)
    y = np.concatenate([arrays.state[at.CONTROL.beside :][: 4 * n], np.zeros(OWN)])
    p = _packed(column, kind, parameters)
    count, per = round(stop / every) + 1, round(every / h)
    out = np.zeros((count, 1 + y.size))
    row, split = np.zeros(at.ROW.size(n)), np.zeros(at.SPLIT.beside)
    k, stage = np.zeros((4, y.size)), np.zeros(y.size)
    integrate(n, arrays, KINDS[kind], p, y, dt, np.asarray(samples, float), every / per, per, row, split, k, stage, out)
    names = ("x", "v", "z", "w", "theta", "omega", "inner")
    own = {name: out[:, 1 + 4 * n + i] for i, name in enumerate(names)}
    return {"time": every * np.arange(count), "top": out[:, 0], "all": out, **own}


def _packed(column: Column, kind: str, parameters: dict[str, float]) -> np.ndarray:
    """Return the parameters in the order of `partner_rates`."""
    if kind != "soil":
        values = dict(zip(ISOLATOR, DEFAULTS, strict=True)) | parameters
        return np.array([values[name] for name in ISOLATOR])
    values = {"mass": 60e3, "inertia": 1.2e5, "radius": 3.0, "density": 1900.0, "shear_velocity": 250.0, "poisson": 0.3}
    values |= parameters
    r, rho, vs, nu = (values[name] for name in ("radius", "density", "shear_velocity", "poisson"))
    vp = vs * math.sqrt(2.0 * (1.0 - nu) / (1.0 - 2.0 * nu))
    area, second = math.pi * r**2, math.pi * r**4 / 4.0
    weight = column.g * sum(block.mass for block in column.blocks)
    shear = rho * vs**2
    return np.array([
        values["mass"], values["inertia"], weight, 8 * shear * r / (2 - nu), rho * vs * area,
        4 * shear * r / (1 - nu), rho * vp * area, 8 * shear * r**3 / (3 * (1 - nu)), rho * vp * second,
        vp / (9 * math.pi / 32 * (1 - nu) * (vp / vs) ** 2 * r),
    ])  # fmt: skip
