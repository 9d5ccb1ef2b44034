"""Overturned, standing or undecided: what can still fall of a column whose base has come to rest.

Upon a still base the mechanical energy of a column never grows: its joints give back at most what they took. To fall,
some block has to turn beyond its angle of no return. So let every block i have a limit alpha_i below that: a column in
which all blocks are within their limits, and whose energy is less than any column has in which one is at its limit and
the rest within theirs, stands for ever. `barrier` is that least energy, for the limits by which it is largest.

With rigid joints the energy above rest is a sum over blocks and joints of x = sin(theta),
-A_i (1 - sqrt(1 - x_i^2)) + B_i |x_i - x_(i+1)|, with A_i what the block and the load on it topple by and B_i the
weight on the joint times half its width. It is concave wherever the order of the x does not change, so that it is
least in a corner: a group of blocks on its edge, the rest upright. Elastic joints give way a little; the least energy
is then found over a grid of rotations, in one pass down the chain, since the energy of a joint depends on its two
blocks only. Rotations of both signs need more energy than their absolute values.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .chain import Chain
from .column import Column
from .packing import FloatArray, model_of
from .sticking import stays_closed, sticks_for_good

OVERTURNED, STANDING, UNDECIDED = "overturned", "standing", "undecided"

# limits that are tried, in parts of the angles at which the blocks from the top to each one stand on their edge; first
# those that are most often the best
PARTS = (0.9, 1.0, 0.8, 0.65, 0.5, 0.35, 0.2, 0.1)
GRID = 32  # rotations up to the largest limit, closer together near upright, where joints are closed
# Of the barrier: what a column that stands for good may have. It covers the grid (measured: at most 1 % too high) and
# the error of the motion; and what the first-order formulation neglects.
SAFE = {"exact": 0.97, "paper": 0.9}
SHARES = (0.25, 1.0)  # limits that are tried for many columns, as `least_energies` counts them
GRAZED = (0.2, 0.7)  # and lengths of the contact
MOST_TURNED = 0.25  # rad, less than half of any angle of no return (kernels/column/assembly.py, LEAST_FALL)
REST = 1e-12  # of the energy that would lift the column by a width: rounding


class Barrier(NamedTuple):
    """Least energy J that a column has in which some block is turned as far as its limit, rad (n,)."""

    energy: float
    limits: FloatArray


def cannot_fall(column: Column, phase: FloatArray) -> bool:
    """Whether a column with this phase, (4 n,), stands for ever upon a base that stays still."""
    if column.off_axis:
        return stays_closed(column, phase)
    if column.slides:  # what slides has less to overcome, and may slide on
        return sticks_for_good(column, phase)
    chain = Chain(column)
    return is_held(column, chain.energy(phase), np.abs(chain.places(phase).theta))


def is_held(column: Column, energy: float, turned: FloatArray) -> bool:
    """The same of a column with this energy, J, whose blocks are turned by so much either way, rad (n,)."""
    rounding = REST * column.g * sum(block.mass * block.joint_width for block in column.blocks)
    safe = SAFE[column.settings.formulation]
    return any(
        energy <= safe * energy_to_fall + rounding and bool(np.all(turned < limits))
        for energy_to_fall, limits in (_barrier_at(column, part) for part in PARTS)
    )


def surely_stand(chain: Chain, energy: FloatArray, turned: FloatArray) -> NDArray[np.bool_]:
    """Of many columns (Chain.of_many) with energies J and blocks turned by so much, those soon seen to stand for ever.

    energy: (columns,), turned: rad either way, (columns, n).
    """
    theta = np.max(turned, axis=-1)
    stands = np.zeros(len(energy), dtype=bool)
    for part, grazed in product(SHARES, GRAZED):
        least, limit = least_energies(chain, part, grazed)
        stands |= (energy <= SAFE["exact" if chain.exact else "paper"] * least) & (theta < limit)
    return stands


def least_energies(chain: Chain, part: float, grazed: float) -> tuple[FloatArray, FloatArray]:
    """No more than the energy J that each of many columns needs for a block to turn by a limit, rad; (columns,) each.

    To turn block i by alpha, the joints under it have to turn by alpha together. Under a weight W the energy of a joint
    over the sine of its turn is convex, and lies above each of its tangents: where the contact has the part c =
    `grazed` of the width b, that of slope W b (1/2 - c/3), which passes W^2 / (k b) (2/(3 c) - 1/2) below the origin,
    with k the rigidity. The blocks give back (1 - cos alpha) of what they topple by. part: alpha, in parts of that
    with the largest bound.
    """
    toppling = np.sum(chain.toppling, axis=-1)
    weight = chain.g * chain.carried
    steepness = 0.5 - grazed / 3.0
    best = steepness * np.min(weight * chain.width, axis=-1) / np.maximum(toppling, np.finfo(float).tiny)
    alpha = np.minimum(part * best, MOST_TURNED)
    weight = weight * np.cos(alpha)[:, None]
    slope = steepness * np.min(weight * chain.width, axis=-1)
    missed = np.sum(weight**2 / (chain.rigidity * chain.width), axis=-1) * (2.0 / (3.0 * grazed) - 0.5)
    return np.sin(alpha) * slope - missed - 2.0 * np.sin(0.5 * alpha) ** 2 * toppling, alpha


def barrier(column: Column) -> Barrier:
    """The energy that a column needs to fall, from rest; zero where its rest is not stable."""
    return max((_barrier_at(column, part) for part in PARTS), key=lambda found: found.energy)


@lru_cache(maxsize=256)
def _barrier_at(column: Column, part: float) -> Barrier:
    """The barrier of limits that are this part of the angles on edge; no less than zero."""
    chain = Chain(column)
    most = np.asarray(model_of(column).blocks.fall_angle, dtype=np.float64).copy()
    # a joint has turned too far only if one of its two blocks has turned by half of that
    half = 0.5 * most[:-1]
    most[:-1] = np.minimum(most[:-1], half)
    most[1:] = np.minimum(most[1:], half)
    on_edge = chain.carried * chain.g * 0.5 * chain.width / np.maximum(np.cumsum(chain.toppling), np.finfo(float).tiny)
    energy, limits = least_energy(chain, np.minimum(part * on_edge, most))
    return Barrier(max(0.0, energy), limits)


def least_energy(chain: Chain, limits: FloatArray) -> Barrier:
    """Least energy, J above rest, with a block at its limit and the others within theirs, which a grid rounds off."""
    angles = float(np.max(limits)) * np.linspace(0.0, 1.0, GRID + 1) ** 2
    last = np.maximum(1, np.searchsorted(angles, limits * (1.0 + 1e-12), side="right") - 1)  # of each block's rotations
    own = -2.0 * np.sin(0.5 * angles) ** 2
    # least energy of all above by the rotation of a block: with everybody within the limits, and with somebody at them
    within, reached = np.zeros(GRID + 1), np.full(GRID + 1, np.inf)
    for i, end in enumerate(last):
        if i > 0:
            between = chain.joint_energy(i - 1, angles[:, None], angles[None, :])
            within, reached = (np.min(least[:, None] + between, axis=0) for least in (within, reached))
        within, reached = within + chain.toppling[i] * own, reached + chain.toppling[i] * own
        reached[end] = min(within[end], reached[end])
        within[end:] = np.inf
        reached[end + 1 :] = np.inf
    on_base = chain.joint_energy(chain.n - 1, angles, np.zeros(GRID + 1))
    return Barrier(float(np.min(reached + on_base)), angles[last])
