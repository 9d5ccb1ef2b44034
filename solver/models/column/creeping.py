"""The test whether a column whose joints may slide can still fall on a still base, while it still rocks and creeps.

Its energy never grows. Without slips the column needs the energy of the barrier to fall (verdict.py). The barrier is
proportional to the square of the lever over which a group of blocks topples: half the width of the joint under the
group, less the distance of its centroid from the middle of that joint. Slips shorten the levers, and further sliding
takes energy. With the remaining energy E, a joint under the weight W slides by at most E / (mu W), if it carries that
weight while it slides. The factor `SHARE` of the weight is assumed.

This is no proof, for a joint may slide while it carries less. The creep of columns is measured (docs/sliding.md).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .kinematics import chain_of
from .linearization import with_all_joints
from .model import Column
from .packing import FloatArray

SHARE = 0.5  # fraction of the weight on a joint, assumed to act while it slides


def levers_left(column: Column, slip: FloatArray, energy: float) -> float:
    """Return the least remaining fraction of the lever of any group of blocks, 0 if a group may lose all of it.

    Parameters
    ----------
    column : Column
        The column.
    slip : ndarray of shape (n,)
        The slips (m).
    energy : float
        The energy above rest (J).
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
    """Return the column without offsets, bonds and sliding; None if it is off its axis for another reason.

    Without bonds, as tension only adds to the resistance of a column.
    """
    straight = with_all_joints(column, friction=None, dowel=None, offset=None, tensile_strength=0.0, cohesion=0.0)
    return None if straight.off_axis else straight
