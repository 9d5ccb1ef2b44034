"""Blocks that rock and slide as free bodies with regularized friction: the reference of sliding scenes.

It uses nothing of the solver but the column's data. Each block is a body in the plane, (x, z) of its centroid and its
rotation; each joint transmits pressure and mu N tanh(slip rate / width) along itself (theory.md sections 2 and 9). No
joint sticks, so there are no decisions, and a general integrator is enough. It must be a stiff one, since a joint that
would stick creeps with a part of `width`, m/s. As the width goes to zero the motion becomes that of Coulomb's law; the
error is proportional to the width.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from solver import Block
from solver.models.column.packing import settlements

from .scenes import Scene

Array = NDArray[np.float64]

LENGTH, TURN = 1e-6, 1e-6  # m, rad: absolute tolerances at a tolerance of 1e-3, in proportion
RATE = 30.0  # 1/s, rates over these


class Motion(NamedTuple):
    """A scene solved: (rows, n) of the blocks' tops and of the joints' slips, m."""

    ux: Array
    slip: Array
    evaluations: int


@numba.njit
def _interval(value: float, slope: float, low: float, high: float) -> tuple[float, float]:
    """Return the part of low to high in which value + slope * s is positive."""
    if slope == 0.0:
        return (low, high) if value > 0.0 else (low, low)
    zero = -value / slope
    return (max(low, zero), high) if slope > 0.0 else (low, min(high, zero))


@numba.njit
def _rates(y: Array, ax: float, width: float, g: float, blocks: Array, joints: Array) -> Array:
    """Compute dy/dt of y = (x, z, theta) of all blocks, then their rates. Rows of blocks, joints: `_body`, `_joint`."""
    n = y.size // 6
    out = np.empty_like(y)
    out[: 3 * n] = y[3 * n :]
    force_x, force_z, couple = np.zeros(n), np.zeros(n), np.zeros(n)
    for i in range(n):
        half, depth, stiffness, damping, friction, dowel, rim = joints[i]
        low = blocks[i, 2]  # centroid above the bottom
        th, om = y[2 * n + i], y[5 * n + i]
        rx, rz = y[i] - low * math.sin(th), y[n + i] - low * math.cos(th)
        vx = y[3 * n + i] - low * math.cos(th) * om
        vz = y[4 * n + i] + low * math.sin(th) * om
        th2, om2, up = 0.0, 0.0, 0.0
        if i + 1 < n:
            up = blocks[i + 1, 3]
            th2, om2 = y[2 * n + i + 1], y[5 * n + i + 1]
            rx -= y[i + 1] + up * math.sin(th2)
            rz -= y[n + i + 1] + up * math.cos(th2)
            vx -= y[3 * n + i + 1] + up * math.cos(th2) * om2
            vz -= y[4 * n + i + 1] - up * math.sin(th2) * om2
        phi, phi_rate = 0.5 * (th + th2), 0.5 * (om + om2)
        nx, nz, tx, tz = math.sin(phi), math.cos(phi), math.cos(phi), -math.sin(phi)
        delta, slip = rx * nx + rz * nz, rx * tx + rz * tz
        delta_rate = vx * nx + vz * nz + slip * phi_rate
        slip_rate = vx * tx + vz * tz - delta * phi_rate
        turned = 0.5 * (th - th2)
        slope, slope_rate = 2.0 * math.sin(turned), math.cos(turned) * (om - om2)
        felt = delta - 0.5 * slip * slope
        felt_rate = delta_rate - 0.5 * (slip_rate * slope + slip * slope_rate)
        left, right = max(-half, -rim - slip), min(half, rim - slip)
        # pressed: slope s - felt > 0; never pulling: that and damping times its rate > 0
        value, steep = -felt - damping * felt_rate, slope + damping * slope_rate
        a, b = _interval(-felt, slope, left, right)
        a, b = _interval(value, steep, a, b)
        normal = moment = 0.0
        if b > a:
            middle, length = 0.5 * (a + b), b - a
            normal = stiffness * depth * length * (value + steep * middle)
            moment = middle * normal + stiffness * depth * steep * length**3 / 12.0
        along = -(friction * normal + dowel) * math.tanh(slip_rate / width)
        for edge, whole, sign in ((left, -half, -1.0), (right, half, 1.0)):
            if edge != whole:
                along += sign * 0.5 * stiffness * depth * max(0.0, slope * edge - felt) ** 2
        # virtual work: on the relative displacement, on the mean rotation, on the relative rotation
        across = along - 0.5 * normal * slope
        fx, fz = normal * nx + across * tx, normal * nz + across * tz
        mean = normal * slip - across * delta
        relative = -(moment + 0.5 * slip * normal) * math.cos(turned)
        force_x[i] += fx
        force_z[i] += fz
        couple[i] += 0.5 * mean + relative - fx * low * math.cos(th) + fz * low * math.sin(th)
        if i + 1 < n:
            force_x[i + 1] -= fx
            force_z[i + 1] -= fz
            couple[i + 1] += 0.5 * mean - relative - fx * up * math.cos(th2) + fz * up * math.sin(th2)
    for i in range(n):
        out[3 * n + i] = force_x[i] / blocks[i, 0] - ax
        out[4 * n + i] = force_z[i] / blocks[i, 0] - g
        out[5 * n + i] = couple[i] / blocks[i, 1]
    return out


def _body(block: Block) -> tuple[float, ...]:
    low = block.resolved_centroid
    return block.mass, block.resolved_inertia, low, block.height - low, block.height


def _joint(block: Block, below: Block | None) -> tuple[float, ...]:
    joint, half = block.joint, 0.5 * block.joint_width
    rim = math.inf if below is None else max(half, 0.5 * (below.top_width or below.width))
    return half, block.joint_depth, joint.stiffness, joint.damping, joint.friction or 0.0, joint.dowel or 0.0, rim


def solve(scene: Scene, times: Array, width: float, tolerance: float) -> Motion:
    """Solve the scene at the times, with friction that rises over `width` m/s.

    Raises RuntimeError if it cannot be solved.
    """
    column, n = scene.column, scene.column.n
    parts = zip(column.blocks, [*column.blocks[1:], None], strict=True)
    blocks, joints = np.array([_body(block) for block in column.blocks]), np.array([_joint(*pair) for pair in parts])
    bottoms = np.cumsum((blocks[:, 4] - settlements(column))[::-1])[::-1] - blocks[:, 4]
    start = np.concatenate([np.zeros(n), bottoms + blocks[:, 2], np.zeros(4 * n)])
    amplitude, omega = scene.motion.amplitude, 2.0 * math.pi * scene.motion.frequency
    calls = 0

    def rates(t: float, y: Array) -> Array:
        nonlocal calls
        calls += 1
        found: Array = _rates(y, amplitude * math.sin(omega * t), width, column.g, blocks, joints)
        return found

    little = np.repeat([LENGTH, LENGTH, TURN, RATE * LENGTH, RATE * LENGTH, RATE * TURN], n)
    run = solve_ivp(
        rates, (0.0, times[-1]), start, "LSODA", times, rtol=tolerance, atol=1e3 * tolerance * little, min_step=0.0
    )
    if not run.success:
        raise RuntimeError(str(run.message))
    x, z, theta = np.split(run.y[: 3 * n].T, 3, axis=1)
    up, low = blocks[:, 3], blocks[:, 2]
    tops = np.stack([x + up * np.sin(theta), z + up * np.cos(theta)])
    feet = np.stack([x - low * np.sin(theta), z - low * np.cos(theta)])
    apart = feet - np.concatenate([tops[:, :, 1:], np.zeros((2, len(times), 1))], axis=2)
    mean = 0.5 * (theta + np.hstack([theta[:, 1:], np.zeros((len(times), 1))]))
    return Motion(tops[0], apart[0] * np.cos(mean) - apart[1] * np.sin(mean), calls)
