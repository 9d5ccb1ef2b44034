"""The bed of a joint in space, compiled once for all tests that ask for it."""

from __future__ import annotations

from typing import Any

import numpy as np

from solver.kernels.numba_ext.jit import from_python
from solver.kernels.structure.bed import Plane
from solver.kernels.structure.joint import bed_of_joint
from solver.models.structure.blocks.faces import FloatArray
from solver.models.structure.model import Structure
from solver.models.structure.stepper import SpatialStepper
from support.scenes import seen


@from_python
def _bed_after(arrays, slips, p, q, found):
    """Return the bed of joint 0 for two planes after slips and a twist, if given, and the integral of p squared."""
    scene, _ = seen(arrays)
    if slips.size:
        scene.slips.p1[0], scene.slips.p2[0], scene.slips.p3[0] = slips[0], slips[1], slips[2]
    first, second = Plane(p[0], p[1], p[2]), Plane(q[0], q[1], q[2])
    bed, square = bed_of_joint(scene, 0, first, second), bed_of_joint(scene, 0, first, first)
    found[5] = p[0] * square.force + p[1] * square.first_x + p[2] * square.first_y
    found[0], found[1], found[2], found[3], found[4] = bed.force, bed.first_x, bed.first_y, bed.area, bed.largest


def bed_and_square(structure: Structure, p: FloatArray, q: FloatArray, slips: Any = ()) -> FloatArray:
    """Return force, first moments, area, the largest pressure, and the integral of p squared.

    slips: of the joint and its twist; by default it has not slid.
    """
    stepper, found = SpatialStepper(structure), np.zeros(6)
    _bed_after(stepper.arrays, np.array(slips, dtype=np.float64), p, q, found)
    return found
