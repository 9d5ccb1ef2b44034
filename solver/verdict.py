"""Overturned, standing or undecided: what can still fall of a column whose base has come to rest.

Upon a still base the mechanical energy of a column never grows: its joints give back at most what they took. To fall,
some block has to turn past any angle alpha below the angle of no return. So a column in which no block is turned by
alpha, and whose energy is less than any column has in which some block is, stands for ever. `barrier` is that least
energy at the alpha where it is largest.

With rigid joints the energy above rest is a sum over blocks and joints of x = sin(theta),
-A_i (1 - sqrt(1 - x_i^2)) + B_i |x_i - x_(i+1)|, with A_i what the block and the load on it topple by and B_i the
weight on the joint times half its width: concave wherever the order of the x does not change. Where no |x| exceeds
sin(alpha) it is least in a corner, in which every block is upright or turned by alpha: one group of blocks on its edge,
the rest upright. Elastic joints give way a little; the least energy is then found over a grid of rotations, which takes
one pass down the chain, since the energy of a joint depends on its two blocks only.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .chain import Chain
from .column import Column
from .packing import FloatArray, model_of

OVERTURNED, STANDING, UNDECIDED = "overturned", "standing", "undecided"

ANGLES = 24  # alpha is one of so many parts of the angle of no return
GRID = 32  # rotations between upright and alpha, closer together near upright, where joints are closed
# Of the barrier: what a column that stands for good may have. It covers the grid (measured: at most 1 % too high), the
# error of the motion, and what the first-order formulation neglects.
SAFE = 0.9
REST = 1e-12  # of the energy that would lift the column by a width: rounding


class Barrier(NamedTuple):
    """Least energy J that a column has when some block is turned by `angle`, rad."""

    energy: float
    angle: float


def cannot_fall(column: Column, phase: FloatArray) -> bool:
    """Whether a column with this phase, (4 n,), stands for ever upon a base that stays still."""
    chain = Chain(column)
    least = barrier(column)
    rounding = REST * chain.g * float(np.sum(chain.mass * chain.width))
    turned = float(np.max(np.abs(chain.places(phase).theta)))
    return turned < least.angle and chain.energy(phase) <= SAFE * least.energy + rounding


@lru_cache(maxsize=64)
def barrier(column: Column) -> Barrier:
    """The energy that a column needs to fall, from rest; zero where its rest is not stable."""
    chain = Chain(column)
    limits = model_of(column).blocks.fall_angle
    # a joint has turned too far only if one of its two blocks has turned by half of that
    furthest = min(float(np.min(limits)), 0.5 * float(np.min(limits[:-1], initial=np.inf)))
    best = Barrier(0.0, furthest)
    for alpha in furthest * np.arange(1, ANGLES + 1) / ANGLES:
        energy = least_energy(chain, float(alpha))
        if energy > best.energy:
            best = Barrier(energy, float(alpha))
    return best


def least_energy(chain: Chain, alpha: float) -> float:
    """Least energy, J above rest, with no block turned by more than alpha rad and one turned by just that."""
    angles = alpha * np.linspace(0.0, 1.0, GRID + 1) ** 2
    least = np.full(GRID + 1, np.inf)  # of all above, by the rotation of this block, with nobody at alpha
    reached = np.full(GRID + 1, np.inf)  # the same with somebody at alpha
    for i in range(chain.n):
        own = -chain.toppling[i] * 2.0 * np.sin(0.5 * angles) ** 2
        if i == 0:
            least[:-1], reached[-1] = own[:-1], own[-1]
        else:
            between = chain.joint_energy(i - 1, angles[:, None], angles[None, :])
            from_least = np.min(least[:, None] + between, axis=0) + own
            from_reached = np.min(reached[:, None] + between, axis=0) + own
            reached = from_reached
            reached[-1] = min(from_reached[-1], from_least[-1])
            least = from_least
            least[-1] = np.inf
    return float(np.min(reached + chain.joint_energy(chain.n - 1, angles, np.zeros(GRID + 1))))
