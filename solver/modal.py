"""The column with all joints in full contact, linear about its rest state: normal modes, as the kernels want them.

At rest rotations and openings do not act on each other (theory.md section 4 to second order), so that there are n modes
of rocking and n of vertical vibration. Both problems M y'' + C y' + K y = -b a are small, symmetric and written down in
closed form, the negative stiffness of gravity included.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .kernels import layout as at

FloatArray = NDArray[np.float64]

# Damping that couples the modes is left to the nonlinear remainder, which a step takes to change little within it: the
# step times the rate of that damping is at most this.
COUPLED_PART = 0.03
LEAST_TURN = 10.0  # rad of the fastest mode in such a step: with fewer the general methods do as well

# Third over second difference of a remainder that varies as fast as twice the fastest motion resolved, for one radian
# of the latter per step: the third of sin(2 x s) is (2 x)^3 / (72 sqrt 3), the second (2 x)^2 / 8.
THIRD_DIFFERENCE = 2.0 * 8.0 / (72.0 * math.sqrt(3.0))


def modal_data(blocks: FloatArray, g: float, tolerance: float) -> FloatArray | None:
    """What kernels/layout.py lists as modal data, read-only; None where there is none.

    blocks: (n, BLOCK_FIELDS) of the packed model; g: m/s2; tolerance: of the packed model. There is none without
    gravity, which leaves the joints open, where the rest state is not stable, where damping couples the modes, and for
    more than MODAL_MOST blocks.
    """
    if len(blocks) > at.MODAL_MOST or not g > 0.0:
        return None
    return _modal_data(np.ascontiguousarray(blocks).tobytes(), g, tolerance)


@lru_cache(maxsize=64)
def _modal_data(content: bytes, g: float, tolerance: float) -> FloatArray | None:
    blocks = np.frombuffer(content).reshape(-1, at.BLOCK_FIELDS)
    n = len(blocks)
    mass, damping, stiffness, push = _equations(blocks, g)
    try:
        root = np.linalg.inv(np.linalg.cholesky(mass))
    except np.linalg.LinAlgError:  # masses too far apart for float64
        return None
    upper = root.transpose(0, 2, 1)
    squares, vectors = np.linalg.eigh(root @ stiffness @ upper)
    if not squares.min() > 0.0:
        return None
    shapes = upper @ vectors  # Phi, columns of unit modal mass
    back = shapes.transpose(0, 2, 1)
    modal_damping = back @ damping @ shapes
    rates = modal_damping.diagonal(axis1=1, axis2=2)
    coupled = float((np.abs(modal_damping).sum(axis=2) - rates).max())

    data = np.zeros(at.modal_size(n))
    resolved = (at.INTERPOLATION_BOUND * at.INTERPOLATION_PART * tolerance) ** (1.0 / 6.0)
    data[at.MODAL_THIRD] = min(1.0, THIRD_DIFFERENCE * resolved)
    data[at.MODAL_LONGEST] = COUPLED_PART / max(coupled, 1e-300)
    data[at.MODAL_SWEEPS] = 1.0 if rates.any() else 2.0
    fields = data[at.MODAL_HEADER : at.MODAL_HEADER + 2 * n * at.MODE_FIELDS].reshape(2, n, at.MODE_FIELDS)
    fields[:, :, at.MODE_SQUARE] = squares
    fields[:, :, at.MODE_DAMPING] = rates
    fields[:, :, at.MODE_PUSH] = -(back @ push)[:, :, 0]
    sizes = blocks[:, [at.TURN_SIZE, at.OPEN_SIZE]].T
    fields[:, :, at.MODE_SIZE] = (np.abs(shapes) / sizes[:, :, None]).max(axis=1)
    matrices = data[at.MODAL_HEADER + 2 * n * at.MODE_FIELDS :].reshape(2, 2, n, n)
    matrices[0] = shapes
    matrices[1] = back @ mass
    if not np.isfinite(data).all() or data[at.MODAL_LONGEST] * math.sqrt(float(squares.max())) < LEAST_TURN:
        return None
    data.flags.writeable = False
    return data


def _equations(blocks: FloatArray, g: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """M, C, K (2, n, n) and b (2, n, 1): first of the rotations under base_ax, then of the openings under base_az + g.

    The coordinates about which the equations are linear are those of the rest state; the openings count from zero.
    """
    n = len(blocks)
    height, centroid, m, eta = blocks[:, at.HEIGHT], blocks[:, at.CENTROID], blocks[:, at.MASS], blocks[:, at.DAMPING]
    width = blocks[:, at.JOINT_WIDTH]
    spring = blocks[:, at.STIFFNESS] * width * blocks[:, at.JOINT_DEPTH]
    turning = spring * width**2 / 12.0
    carried = np.cumsum(m)
    opening = -g * carried / spring
    one = np.eye(n)
    side = np.eye(n, k=1)
    from_base = np.triu(np.ones((n, n)))  # row i: the joints under block i
    step = one - side  # rotation of a joint
    mean = 0.5 * (one + side)  # and of its normal
    # horizontal displacement of the centroids for unit rotations
    sway = one * (centroid - height) + from_base * height + from_base @ (opening[:, None] * mean)
    lowered = mean.T @ ((opening * carried)[:, None] * mean) + one * (m * centroid + height * (carried - m))
    mass, damping, stiffness = np.empty((3, 2, n, n))
    push = np.empty((2, n, 1))
    mass[0] = sway.T @ (m[:, None] * sway) + one * blocks[:, at.INERTIA]
    mass[1] = np.minimum(carried[:, None], carried)
    damping[0] = step.T @ ((eta * turning)[:, None] * step)
    damping[1] = one * (eta * spring)
    stiffness[0] = step.T @ (turning[:, None] * step) - g * lowered
    stiffness[1] = one * spring
    push[0, :, 0] = m @ sway
    push[1, :, 0] = carried
    return mass, damping, stiffness, push
