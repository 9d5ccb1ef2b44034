"""Overlaps of blocks in a run: where the model does not let them meet, and of neighbours beyond their contacts.

Neighbours meet by the sides that were paired as built: a block that turns, or that comes round a corner, may enter its
neighbour where no sides are paired. So every two blocks without a joint are compared by their convex bodies.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from .blocks.faces import FloatArray
from .convex import TOUCH, distance, hulls_of, near_as_built
from .model import Structure
from .outputs import StructureHistories

ROWS = 1000  # instants at once: memory
BEYOND = 0.05  # of the depth in which a contact bears: so much more is still taken as that


class Overlap(NamedTuple):
    """The deepest overlap of two blocks in a run that the model knows nothing of, beyond what it is as built."""

    depth: float = 0.0  # m
    between: tuple[str, ...] = ()  # their names; empty without an overlap
    time: float = float("nan")  # s
    paired: bool = False  # whether they are neighbours, outside of the range of their contact

    @property
    def sentence(self) -> str:
        """What a user should know of it."""
        why = "no joint connects them and no [neighbours] lets them meet; move them apart, or"
        if self.paired:
            why = "sides of neighbours are paired as built, and none of theirs meets there;"
        names, depth = " and ".join(self.between), 1e3 * self.depth
        return f"{names} pass into each other by {depth:.3g} mm at {self.time:.4g} s: {why} do not rely on this run"


def deepest_overlap(structure: Structure, time: FloatArray, rows: StructureHistories) -> Overlap:
    """Return the deepest overlap in the rows, which belong to instants, s. Pairs that cannot meet cost nothing."""
    n = structure.n
    u = np.stack([rows.ux, rows.uy, rows.uz], axis=-1)
    rotation = rows.rotation
    there = np.isfinite(u).all(axis=(1, 2)) & np.isfinite(rotation).all(axis=(1, 2))
    bears = _depth_of_contacts(structure, rows)
    time, u, rotation = time[there], u[there], rotation[there]
    if n < 2 or not len(time):
        return Overlap()
    hulls = [hulls_of(block) for block in structure.blocks]
    reach = np.array([block.reach for block in structure.blocks])
    turning = reach * np.linalg.norm(rotation, axis=2)
    most = np.max(np.linalg.norm(u, axis=2) + turning, axis=0)
    found = Overlap()
    for i, j in np.argwhere(near_as_built(structure.blocks, structure.joints, most[:, None] + most[None])):
        between, moved = structure.blocks[j].centroid - structure.blocks[i].centroid, u[:, j] - u[:, i]
        far = np.linalg.norm(moved, axis=1) + turning[:, i] + turning[:, j]
        known = bears.get((int(i), int(j)))
        for one, other in product(hulls[i], hulls[j]):
            still = np.zeros((1, 3))
            built = float(distance(one, other, still, still, between[None])[0])
            near = np.flatnonzero(far >= built)
            for first in range(0, len(near), ROWS):
                at = near[first : first + ROWS]
                depth = min(built, 0.0) - distance(one, other, rotation[at, i], rotation[at, j], between + moved[at])
                if known is not None:
                    depth -= (1.0 + BEYOND) * known[there][at]
                k = int(np.argmax(depth))
                if depth[k] > max(found.depth, TOUCH):
                    names = structure.names[i], structure.names[j]
                    found = Overlap(float(depth[k]), names, float(time[at[k]]), known is not None)
    return found


def _depth_of_contacts(structure: Structure, rows: StructureHistories) -> dict[tuple[int, int], FloatArray]:
    """Return how deep the blocks of each pair of neighbours overlap by their contacts, m (rows,).

    As deep at most as where a contact bears something: a gap is also below 0 behind a face that is not met.
    """
    found: dict[tuple[int, int], FloatArray] = {}
    for k, pair in enumerate(structure.neighbours):
        if not pair.wall:
            key = min(pair.one, pair.other), max(pair.one, pair.other)
            depth = np.nan_to_num(np.maximum(pair.farther - rows.gap[:, k], 0.0))
            depth = np.minimum(depth, np.max(depth, where=rows.hit[:, k] > 0.0, initial=0.0))
            found[key] = np.maximum(depth, found[key]) if key in found else depth
    return found
