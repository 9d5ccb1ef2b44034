"""Limit analysis of a chain of rigid blocks that do not slide: the truth that arches are compared with."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.optimize import linprog

from multiblock import Structure

from .rigid_block import FloatArray


def largest_push(arch: Structure) -> float:
    """Return the largest steady acceleration along x, over gravity, under which some line of thrust lies in all joints.

    The blocks follow each other from base to base in the plane x, z, joint k under block k, as `multiblock.arch` makes
    them. J. Heyman (1969), International Journal of Mechanical Sciences 11: rigid blocks, no tension, no sliding; the
    safe theorem as a linear program. NaN where the arch does not stand without a push.
    """
    places, ways, half = _joints_of(arch)
    weight = np.array([block.mass for block in arch.blocks])
    middle = np.array([block.centroid[[0, 2]] for block in arch.blocks])
    unknown = 4  # force on the first block (x, z), its moment about the origin, push
    force = np.zeros((arch.n + 1, 2, unknown + 1))  # of each joint on the block after it, by the unknowns and 1
    moment = np.zeros((arch.n + 1, unknown + 1))
    force[:, 0, 0] = force[:, 1, 1] = moment[:, 2] = 1.0
    force[1:, 0, 3] = np.cumsum(weight)
    force[1:, 1, 4] = -np.cumsum(weight)
    moment[1:, 3] = -np.cumsum(middle[:, 1] * weight)
    moment[1:, 4] = -np.cumsum(middle[:, 0] * weight)
    thrust = np.einsum("ij,ijk->ik", ways, force)
    about = moment - (places[:, :1] * force[:, 1] - places[:, 1:] * force[:, 0])
    rows = np.concatenate([about - half[:, None] * thrust, -about - half[:, None] * thrust]) / np.sum(weight)
    push = np.array([0.0, 0.0, 0.0, -1.0])
    bounds = [(None, None)] * 3 + [(0.0, None)]
    found: Any = linprog(push, A_ub=rows[:, :unknown], b_ub=-rows[:, unknown], bounds=bounds, method="highs")
    return float(found.x[3]) if found.success else math.nan


def _joints_of(arch: Structure) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return centres (n + 1, 2) m, directions of thrust from block to block (n + 1, 2), and half widths (n + 1,) m."""
    places = np.array([joint.face.centre[[0, 2]] for joint in arch.joints])
    ways = np.array([joint.face.normal[[0, 2]] for joint in arch.joints])
    ways[-1] *= -1.0  # its normal points from the base to the block before it
    half = np.array([np.max(joint.face.outline[:, 0]) for joint in arch.joints])
    return places, ways, half
