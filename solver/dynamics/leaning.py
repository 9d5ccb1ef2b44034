"""Whether a column off its axis, whose joints never slide, can still fall on a still base.

As in verdict.py, the energy never grows. So a column stands for ever if all its blocks are within limits and its energy
is less than that of any column with one block at its limit and the others within theirs. Here the limits to either side
are separate, and energies are counted from that of the bent rest (theory.md section 12).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..column.column import Column
from ..column.packing import FloatArray, model_of
from .kinematics import Chain

# limits that are tried, as parts of the angles at which the blocks from the top to each one stand on their edge
PARTS = (0.8, 0.95, 0.6, 0.4, 0.2)
GRID = 24  # rotations to either side, denser near upright, where joints are closed
SAFE = 0.97  # of the least energy; the rest covers the error of the grid


def leans_for_good(column: Column, phase: FloatArray) -> bool:
    """Whether a column with this phase (chain.py) stands for ever on a base that stays still."""
    chain = Chain(column)
    energy, turned = chain.energy(phase), np.abs(chain.places(phase).theta)
    found = (least_energy(column, part) for part in PARTS)
    return any(energy <= SAFE * least and bool(np.all(turned < limits)) for least, limits in found)


@lru_cache(maxsize=64)
def least_energy(column: Column, part: float) -> tuple[float, FloatArray]:
    """Least energy, J above rest, with a block turned either way by its limit and the rest within; limits, rad (n,)."""
    chain = Chain(column)
    most = limits_of(chain, column, part)
    side = float(np.max(most)) * np.linspace(0.0, 1.0, GRID + 1) ** 2
    angles = np.concatenate([-side[:0:-1], side])
    last = np.maximum(1, np.count_nonzero(side <= most[:, None] * (1.0 + 1e-12), axis=1) - 1)
    away = np.abs(np.arange(angles.size) - GRID)
    # least energy of all blocks above, by the rotation of a block: all within the limits, and at least one at its limit
    within, reached = np.zeros(angles.size), np.full(angles.size, np.inf)
    for i, end in enumerate(last):
        if i > 0:
            between = chain.built_energy(i - 1, angles[:, None], angles[None, :])
            within, reached = (np.min(least[:, None] + between, axis=0) for least in (within, reached))
        own = chain.toppling[i] * np.cos(angles + np.broadcast_to(chain.tilt, most.shape)[i])
        within, reached = within + own, reached + own
        reached = np.where(away == end, np.minimum(within, reached), reached)
        within[away >= end] = np.inf
        reached[away > end] = np.inf
    on_base = chain.built_energy(chain.n - 1, angles, np.zeros(angles.size))
    return float(np.min(reached + on_base)) - _at_rest(chain), side[last]


def limits_of(chain: Chain, column: Column, part: float) -> FloatArray:
    """Limits of the blocks, rad (n,), below half of any angle of no return, so that joints stay below theirs too."""
    on_edge = chain.weight * 0.5 * chain.width / np.maximum(np.cumsum(chain.toppling), np.finfo(float).tiny)
    limits: FloatArray = np.minimum(part * on_edge, 0.5 * np.min(model_of(column).blocks.fall_angle))
    return limits


def _at_rest(chain: Chain) -> float:
    """The energy of the rest, in the sum of `least_energy`."""
    theta = chain.places(chain.rest).theta
    below = np.append(theta[1:], 0.0)
    joints = [float(chain.built_energy(i, theta[i : i + 1], below[i : i + 1])[0]) for i in range(chain.n)]
    return sum(joints) + float(np.sum(chain.toppling * np.cos(theta + chain.tilt)))
