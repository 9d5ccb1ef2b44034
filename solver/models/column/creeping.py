"""Whether a column whose joints may slide can still fall on a still base, though it may still rock and creep.

Its energy never grows. Without slips the column needs the energy of the barrier to fall (verdict.py). The barrier is
proportional to the square of the lever over which a group of blocks topples: half the width of the joint under the
group, less the distance of its centroid from the middle of that joint. Slips shorten the levers, and further sliding
takes energy. With the energy E left, a joint under the weight W slides by at most E / (mu W), if it bears that weight
while it slides. `SHARE` of the weight is counted.

This is no proof, for a joint may slide while it bears less. The creep of columns is measured (docs/sliding.md).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .kinematics import chain_of
from .linearization import with_all_joints
from .model import Column
from .packing import FloatArray

SHARE = 0.5  # of the weight on a joint, which it bears while it slides


def levers_left(column: Column, slip: FloatArray, energy: float) -> float:
    """Least part of the lever of any group of blocks that is left with these slips, m (n,), and energy, J.

    0 where a group may lose all of its lever.
    """
    chain = chain_of(column)
    joints = [block.joint for block in column.blocks]
    friction = np.array([np.inf if joint.friction is None else joint.friction for joint in joints])
    dowel = np.array([joint.dowel or 0.0 for joint in joints])
    reach = max(0.0, energy) / (SHARE * friction * chain.weight + dowel)
    moved = np.cumsum((np.abs(slip) + reach) * chain.weight) / chain.weight
    return max(0.0, 1.0 - float(np.max(moved / (0.5 * chain.width))))


@lru_cache(maxsize=256)
def on_its_axis(column: Column) -> Column | None:
    """The column without offsets, whose joints never slide; None for columns that are off axis in another way.

    It has no bonds: tension only adds to what a column bears.
    """
    straight = with_all_joints(column, friction=None, dowel=None, offset=None, tensile_strength=0.0, cohesion=0.0)
    return None if straight.off_axis else straight
