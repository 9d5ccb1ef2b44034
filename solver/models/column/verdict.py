"""The verdict: overturned, standing or undecided; whether a column whose base has come to rest can still fall.

On a still base the mechanical energy of a column never grows: its joints return at most the energy they took. To fall,
some block has to turn beyond its angle of no return. For every block i choose a limit alpha_i below that angle. A
column stands for ever if all blocks are within their limits and its energy is less than that of any column with one
block at its limit and the others within theirs. The barrier is that least energy, for the limits that make it largest.

With rigid joints the energy above rest is a sum over blocks and joints of x = sin(theta),
-A_i (1 - sqrt(1 - x_i^2)) + B_i |x_i - x_(i+1)|. A_i is the toppling moment of the block and the load on it, B_i the
weight on the joint times half its width. The sum is concave wherever the order of the x does not change, so its minimum
is at a corner: a group of blocks on its edge, the rest upright. Elastic joints deform a little; the minimum is then
found over a grid of rotations, in one pass down the chain, since the energy of a joint depends on its two blocks only.
Rotations of both signs need more energy than their absolute values.

Bonds only add to the resistance of a joint, and lose energy where they break. So the barrier is that of the column
without bonds, and the energy includes theirs.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .kinematics import Chain, chain_of
from .leaning import always_leans, least_of_chain
from .linearization import with_all_joints
from .model import Column
from .packing import FloatArray, IntArray, pack_model
from .sticking import always_sticks

# the limits, as fractions of the angles at which the blocks from the top to each one stand on their edge; the most
# frequent optimum first
PARTS = (0.9, 1.0, 0.8, 0.65, 0.5, 0.35, 0.2, 0.1)
GRID = 32  # rotations up to the largest limit, denser near upright, where joints are closed
# The largest energy of a column that stands for certain is the barrier times `Chain.safe`: the remainder covers the
# grid (measured: at most 1 % too high), the error of the motion, and effects that its equations neglect.
CREEPS = 0.9  # factor on that for a column whose joints may slide
CREEPS_UNDER = 0.5  # fraction of the weight on a joint, assumed to act while it slides
SHARES = (0.25, 1.0)  # limits for many columns, as `part` of `least_energies`
GRAZED = (0.2, 0.7)  # lengths of the contact, as `grazed` of `least_energies`
MOST_TURNED = 0.25  # rad, less than half of any angle of no return (kernels/column/model/assembly.py, LEAST_FALL)
TOGETHER = 32  # columns whose barriers are computed at once: their data fit into the cache
NEXT = 1.0 + 1e-9  # of a limit, which a grid may round up a little (`_grid`)
REST = 1e-12  # rounding error, relative to the energy that would lift the column by a width


class Barrier(NamedTuple):
    """The least energy (J) of a column in which some block is turned by its limit, rad (n,); or of many columns."""

    energy: Any
    limits: FloatArray


def cannot_fall(column: Column, phase: FloatArray) -> bool:
    """Return True if a column with this phase, (4 n,), stands for ever on a still base."""
    if column.other_law:  # the barrier assumes the linear law; with another the column may fall with less energy
        return False
    if column.is_brittle and column.off_axis:  # its rest depends on the bonds, and energies count from there
        return False
    if column.slides:  # slips lower the barrier, and may grow
        return cannot_creep_to_fall(column, phase) or always_sticks(column, phase)
    if column.off_axis:
        return always_leans(column, phase)
    chain = chain_of(column)
    return is_held(column, chain.energy(phase), np.abs(chain.places(phase).theta))


def is_held(column: Column, energy: float, turned: FloatArray) -> bool:
    """Return True if a column with this energy (J) and absolute rotations, rad (n,), stands for ever."""
    return _barriers(column).hold_first(energy, turned)


def cannot_creep_to_fall(column: Column, phase: FloatArray) -> bool:
    """Return True if a column with sliding joints lacks the energy to fall from any position it may slide to.

    The barrier is proportional to the square of the lever over which a group of blocks topples: half the width of the
    joint under the group, less the distance of its centroid from the middle of that joint. Slips shorten the levers,
    and further sliding takes energy. This is no proof, for a joint may slide while it carries less than assumed. The
    creep of columns is measured (docs/sliding.md).
    """
    straight = on_its_axis(column)
    if straight is None:
        return False
    chain = chain_of(column)
    energy, places = chain.energy(phase), chain.places(phase)
    left = remaining_lever_fraction(column, np.asarray(places.slip), energy)
    return left > 0.0 and is_held(straight, energy / (CREEPS * left**2), np.abs(places.theta) / left)


def remaining_lever_fraction(column: Column, slip: FloatArray, energy: float) -> float:
    """Return the least remaining fraction of the lever of any group of blocks, 0 if a group may lose all of it.

    With the remaining energy E, a joint under the weight W slides by at most E / (mu W), if it carries that weight
    while it slides; CREEPS_UNDER of it is assumed. `slip` has the slips, m (n,); `energy` is that above rest (J).
    """
    chain = chain_of(column)
    joints = [block.joint for block in column.blocks]
    friction = np.array([np.inf if joint.friction is None else joint.friction for joint in joints])
    dowel = np.array([joint.dowel or 0.0 for joint in joints])
    reach = max(0.0, energy) / (CREEPS_UNDER * friction * chain.weight + dowel)
    moved = np.cumsum((np.abs(slip) + reach) * chain.weight) / chain.weight
    return max(0.0, 1.0 - float(np.max(moved / (0.5 * chain.width))))


@lru_cache(maxsize=256)
def on_its_axis(column: Column) -> Column | None:
    """Return the column without offsets, bonds and sliding; None if it is off its axis for another reason.

    Without bonds, as tension only adds to the resistance of a column.
    """
    straight = with_all_joints(column, friction=None, dowel=None, offset=None, tensile_strength=0.0, cohesion=0.0)
    return None if straight.off_axis else straight


def surely_stand(chain: Chain, energy: FloatArray, turned: FloatArray) -> NDArray[np.bool_]:
    """Return the mask of the columns that a quick bound proves to stand for ever.

    `energy` (columns,) is theirs above rest (J), `turned` (columns, n) their absolute rotations (rad).
    """
    theta = np.max(turned, axis=-1)
    stands = np.zeros(len(energy), dtype=bool)
    for part, grazed in product(SHARES, GRAZED):
        least, limit = least_energies(chain, part, grazed)
        stands |= (energy <= chain.safe * least) & (theta < limit)
    return stands


def least_energies(chain: Chain, part: float, grazed: float) -> tuple[FloatArray, FloatArray]:
    """Return a lower bound of the energy (J) for a block of each of many columns to turn by a limit, and that limit.

    To turn block i by alpha, the joints under it have to turn by alpha together. Under a weight W the energy of a joint
    over the sine of its turn is convex, and lies above each of its tangents: where the contact has the part c =
    `grazed` of the width, that of slope W x, which passes W^2 ((x - e) / (2 k S) - 1 / (2 k A)) below the origin; x and
    e are the distances of the resultant and the edge from the middle, S is the first moment about the edge, A the whole
    area. In a rectangle of the width b that is W b (1/2 - c/3) and W^2 / (k A) (2/(3 c) - 1/2). The blocks give back (1
    - cos alpha) of their toppling moments. alpha is `part` of that with the largest bound.
    """
    toppling = np.sum(chain.toppling, axis=-1)
    weight = chain.weight
    lever, gives = chain.grazed(grazed)
    best = np.min(weight * lever, axis=-1) / np.maximum(toppling, np.finfo(float).tiny)
    alpha = np.minimum(part * best, MOST_TURNED)
    weight = weight * np.cos(alpha)[:, None]
    slope = np.min(weight * lever, axis=-1)
    missed = np.sum(weight**2 * gives, axis=-1)
    return np.sin(alpha) * slope - missed - 2.0 * np.sin(0.5 * alpha) ** 2 * toppling, alpha


class Barriers:
    """The barriers of many columns, whose data are in `chain` (Chain.of_many); each is computed when it is needed."""

    def __init__(self, chain: Chain) -> None:
        self._chain = chain
        self._rounding = REST * chain.g[:, 0] * np.sum(chain.mass * chain.width, axis=-1)
        self._limits = np.array([limits_at(chain, part) for part in PARTS])
        self._ceilings = np.array([turned_together(chain, limits) for limits in self._limits])
        self._energies = np.full(self._ceilings.shape, np.nan)

    def hold(self, some: IntArray, energy: FloatArray, turned: FloatArray) -> NDArray[np.bool_]:
        """Return the mask of the columns with the indices `some` that stand for ever, as `is_held`.

        An index may occur more than once. Each has an energy (J) and absolute rotations `turned`, rad (some, n).
        """
        held = np.zeros(len(some), dtype=bool)
        safe = self._chain.safe
        rounding = self._rounding[some]
        within = energy <= safe * self._ceilings[:, some] + rounding  # for each of the parts
        within &= np.all(turned < NEXT * self._limits[:, some], axis=-1)
        for k, possible in enumerate(within):
            if held.all():
                break
            left = np.flatnonzero(possible & ~held)
            if not left.size:
                continue
            places = some[left]
            if (missing := np.isnan(self._energies[k, places])).any():
                self._find(k, np.unique(places[missing]))
            enough = safe * self._energies[k, places] + rounding[left]
            held[left] = (energy[left] <= enough) & np.all(turned[left] < self._limits[k, places], axis=-1)
        return held

    def hold_first(self, energy: float, turned: FloatArray) -> bool:
        """Return `hold` of the first column alone, without the overhead of arrays: every run calls it at each check."""
        safe, rounding = self._chain.safe, self._rounding[0]
        for k, ceiling in enumerate(self._ceilings[:, 0].tolist()):
            if energy > safe * ceiling + rounding:
                continue
            if np.isnan(self._energies[k, 0]):
                self._find(k, np.zeros(1, dtype=np.int64))
            if energy <= safe * self._energies[k, 0] + rounding and (turned < self._limits[k, 0]).all():
                return True
        return False

    def _find(self, k: int, missing: IntArray) -> None:
        for first in range(0, len(missing), TOGETHER):
            few = missing[first : first + TOGETHER]
            found = least_energy(self._chain.some(few), self._limits[k, few])
            # the energy last: other threads take a barrier as computed where it is set
            self._limits[k, few] = found.limits
            self._energies[k, few] = np.maximum(0.0, found.energy)


@lru_cache(maxsize=256)
def _barriers(column: Column) -> Barriers:
    """Return the barriers of one column."""
    return Barriers(column.kind.chain.of_many(pack_model(column)[None], column.n))


def limits_at(chain: Chain, part: float) -> FloatArray:
    """Return limits of the blocks, `part` of the angles on edge, rad (..., n), of one column or of many."""
    most = chain.fall_angle.copy()
    # a joint reaches its limit only if one of its two blocks has turned by half of it
    half = 0.5 * most[..., :-1]
    most[..., :-1] = np.minimum(most[..., :-1], half)
    most[..., 1:] = np.minimum(most[..., 1:], half)
    toppling = np.maximum(np.cumsum(chain.toppling, axis=-1), np.finfo(float).tiny)
    on_edge = chain.weight * 0.5 * chain.width / toppling
    return np.minimum(part * on_edge, most)


def turned_together(chain: Chain, limits: FloatArray) -> FloatArray:
    """Return the energy of many columns with all blocks turned by their least limit, J (columns,): the barrier is less.

    It is a quick bound, as `least_energy` is slow.
    """
    angles, last = _grid(limits)
    angle = np.take_along_axis(angles, np.min(last, axis=-1, keepdims=True), axis=-1)[..., None]
    turns = [*(angle for _ in range(chain.n)), np.zeros(1)]
    joints = [chain.joint_energy(i, turns[i], turns[i + 1])[..., 0, 0] for i in range(chain.n)]
    released = 2.0 * np.sin(0.5 * angle[..., 0, 0]) ** 2 * np.sum(chain.toppling, axis=-1)
    energy: FloatArray = np.sum(joints, axis=0) - released
    return np.maximum(0.0, energy)


def _grid(limits: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the rotations of the grid, rad (..., GRID + 1), and the index of the limit of each block, (..., n)."""
    angles = np.max(limits, axis=-1, keepdims=True) * np.linspace(0.0, 1.0, GRID + 1) ** 2
    within_limit = angles[..., None, :] <= limits[..., None] * (1.0 + 1e-12)
    return angles, np.maximum(1, np.count_nonzero(within_limit, axis=-1) - 1)


_FIRST, _SECOND = np.tril_indices(GRID + 1)  # all pairs of rotations of a grid, each once
_PAIR = np.zeros((GRID + 1, GRID + 1), dtype=np.int64)  # index of the pair of two rotations
_PAIR[_FIRST, _SECOND] = _PAIR[_SECOND, _FIRST] = np.arange(len(_FIRST))


def _bends(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the slopes of a joint and cosines of the mean rotation for all pairs of rotations, (..., 1, pairs).

    The addition theorems are used: functions of every pair would take as long as all the rest.
    """
    sine, cosine = np.sin(0.5 * angles)[..., None, :], np.cos(0.5 * angles)[..., None, :]
    sines, cosines = ((values[..., _FIRST], values[..., _SECOND]) for values in (sine, cosine))
    slope = 2.0 * np.abs(sines[0] * cosines[1] - sines[1] * cosines[0])
    return slope, cosines[0] * cosines[1] - sines[0] * sines[1]


def least_energy(chain: Chain, limits: FloatArray) -> Barrier:
    """Return the least energy above rest with a block at its limit, rounded to the grid, and the others within theirs.

    `limits` are in rad, (..., n), of one column or of many.
    """
    angles, last = _grid(limits)
    slope, cosine = _bends(angles)
    own = -2.0 * np.sin(0.5 * angles) ** 2

    def between(i: int) -> FloatArray:
        return np.asarray(np.take(chain.bent_energy(i, slope, cosine)[..., 0, :], _PAIR, axis=-1))

    on_base = chain.joint_energy(chain.n - 1, angles[..., :, None], np.zeros(1))[..., 0]
    released = [chain.toppling[..., i, None] * own for i in range(chain.n)]
    energy = least_of_chain(released, between, on_base, np.arange(GRID + 1), last)
    return Barrier(energy, np.take_along_axis(angles, last, axis=-1))
