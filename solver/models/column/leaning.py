"""The test whether a column off its axis, whose joints never slide, can still fall on a still base.

As in verdict.py, the energy never grows. So a column stands for ever if all its blocks are within limits and its energy
is less than that of any column with one block at its limit and the others within theirs. Here the limits to either side
are separate, and energies count from that of the bent rest (theory.md section 12).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from .kinematics import Chain, chain_of
from .model import Column
from .packing import FloatArray, IntArray

# the limits, as fractions of the angles at which the blocks from the top to each one stand on their edge
PARTS = (0.8, 0.95, 0.6, 0.4, 0.2)
GRID = 24  # rotations to either side, denser near upright, where joints are closed
SAFE = 0.97  # of the least energy; the remainder covers the error of the grid


def always_leans(column: Column, phase: FloatArray) -> bool:
    """Return True if a column with this phase (kinematics.py) stands for ever on a still base."""
    chain = chain_of(column)
    energy, turned = chain.energy(phase), np.abs(chain.places(phase).theta)
    found = (least_energy(column, part) for part in PARTS)
    return any(energy <= SAFE * least and bool(np.all(turned < limits)) for least, limits in found)


@lru_cache(maxsize=64)
def least_energy(column: Column, part: float) -> tuple[float, FloatArray]:
    """Return the least energy above rest (J) with a block at its limit to either side and the others within theirs.

    The limits, rad (n,), are `part` of the angles on edge, rounded to the grid; they are returned second.
    """
    chain = chain_of(column)
    most = limits_of(chain, part)
    side = float(np.max(most)) * np.linspace(0.0, 1.0, GRID + 1) ** 2
    angles = np.concatenate([-side[:0:-1], side])
    last = np.maximum(1, np.count_nonzero(side <= most[:, None] * (1.0 + 1e-12), axis=1) - 1)
    own = [toppling * np.cos(angles + tilt) for toppling, tilt in zip(chain.toppling, chain.tilt, strict=True)]
    on_base = chain.built_energy(chain.n - 1, angles, np.zeros(angles.size))

    def between(i: int) -> FloatArray:
        return chain.built_energy(i, angles[:, None], angles[None, :])

    away = np.abs(np.arange(angles.size) - GRID)
    return float(least_of_chain(own, between, on_base, away, last)) - _at_rest(chain), side[last]


def least_of_chain(
    own: Sequence[FloatArray],
    between: Callable[[int], FloatArray],
    on_base: FloatArray,
    number: IntArray,
    last: IntArray,
) -> FloatArray:
    """Return the least energy with a block at its limit and the others within theirs (J), in one pass down the chain.

    Parameters
    ----------
    own : sequence of ndarray of shape (..., grid)
        The energy of each block over a grid of rotations (J).
    between : callable
        Returns the energies of joint i (J), (..., grid, grid).
    on_base : ndarray of shape (..., grid)
        The energy of the joint on the base (J).
    number : ndarray of int of shape (grid,)
        The index of each rotation, counted from upright.
    last : ndarray of int of shape (..., n)
        The index of the limit of each block.
    """
    # least energy of all blocks above, by the rotation of a block: all within the limits, and at least one at its limit
    within, reached = np.zeros_like(on_base), np.full_like(on_base, np.inf)
    for i, energy in enumerate(own):
        if i > 0:
            both = between(i - 1)
            within, reached = (np.min(least[..., :, None] + both, axis=-2) for least in (within, reached))
        within, reached, end = within + energy, reached + energy, last[..., i, None]
        reached = np.where(number == end, np.minimum(within, reached), reached)
        within[number >= end] = np.inf
        reached[number > end] = np.inf
    return np.min(reached + on_base, axis=-1)


def limits_of(chain: Chain, part: float) -> FloatArray:
    """Return limits of the blocks, rad (n,): at most half of any angle of no return, so that joints keep theirs."""
    on_edge = chain.weight * 0.5 * chain.width / np.maximum(np.cumsum(chain.toppling), np.finfo(float).tiny)
    return np.minimum(part * on_edge, 0.5 * np.min(chain.fall_angle))


def _at_rest(chain: Chain) -> float:
    """Return the energy of the rest (J), in the sum of `least_energy`."""
    assert chain.rest is not None
    theta = chain.places(chain.rest).theta
    below = np.append(theta[1:], 0.0)
    joints = [float(chain.built_energy(i, theta[i : i + 1], below[i : i + 1])[0]) for i in range(chain.n)]
    return sum(joints) + float(np.sum(chain.toppling * np.cos(theta + chain.tilt)))
