"""Whether blocks pass into each other that no joint connects and that are no neighbours: in the model they do not meet.

Two convex blocks are apart where some axis separates them; blocks that are not convex are compared part by part. Of
boxes and prisms the axes are the normals of faces and the cross products of edges, which are all that are needed. Of
drums they are those in which two of them, or a drum and a corner, face each other: an upright drum needs no more. Along
an axis the extent of a block is that of its corners and rims.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .blocks.faces import Face, FloatArray
from .blocks.parts import Solid
from .blocks.shapes import turned
from .model import Structure
from .outputs import StructureHistories

TOUCH = 1e-4  # m, of overlap: joints give as much under their load
ROWS = 1000  # instants at once: memory
PARALLEL = 1e-6  # sine of the angle between two edges; of the size of a block: corners closer than this are one
PAIRS = 2000  # of edges; where two hulls have more, their many normals have to do: overlaps seem deeper, never less


class Overlap(NamedTuple):
    """The deepest overlap of two blocks that do not meet in the model, beyond what it is as built."""

    depth: float = 0.0  # m
    between: tuple[str, ...] = ()  # their names; empty without an overlap
    time: float = float("nan")  # s

    @property
    def sentence(self) -> str:
        """What a user should know of it."""
        return (
            f"{' and '.join(self.between)} pass into each other by {1e3 * self.depth:.3g} mm at {self.time:.4g} s: no "
            "joint connects them and no [neighbours] lets them meet; move them apart, or do not rely on this run"
        )


@dataclass(frozen=True, eq=False)
class _Hull:
    """Corners, rims and axes of a convex block or part, from the centroid of the block, along the axes of the base."""

    block: Solid
    part: tuple[Face, ...] = ()

    @property
    def faces(self) -> tuple[Face, ...]:
        """Of the part, or of all of the block."""
        return self.part or self.block.faces

    @cached_property
    def corners(self) -> FloatArray:
        """(corners, 3) m, of its polygons."""
        found = [face.points() - self.block.centroid for face in self.faces if not face.radius]
        if not found:
            return np.empty((0, 3))
        every = np.concatenate(found)
        _, first = np.unique(np.round(every / (PARALLEL * self.block.size)), axis=0, return_index=True)
        return every[np.sort(first)]

    @cached_property
    def rims(self) -> list[tuple[FloatArray, FloatArray, float]]:
        """Centre, normal and radius of its round faces."""
        faces = [face for face in self.faces if face.radius]
        return [(face.centre - self.block.centroid, face.normal, face.radius) for face in faces]

    @cached_property
    def edges(self) -> FloatArray:
        """Directions of its edges, of a drum that of its axis (edges, 3)."""
        if self.rims:
            return self.rims[0][1][None]
        outlines = [face.points() for face in self.faces]
        found = [np.roll(outline, -1, axis=0) - outline for outline in outlines]
        return _directions(np.concatenate([*found, self._sides]))

    @cached_property
    def normals(self) -> FloatArray:
        """Normals of its faces, (normals, 3)."""
        found = [face.normal[None] for face in self.faces]
        if len(self._sides):  # of a box that tapers: each contains an edge of the bottom and one to the top
            bottom = self.faces[0].points()
            along = np.roll(bottom, -1, axis=0) - bottom
            found += [np.cross(along, side) for side in (self._sides, np.roll(self._sides, -1, axis=0))]
        return _directions(np.concatenate(found))

    @cached_property
    def _sides(self) -> FloatArray:
        """Edges from the bottom to the top of a box that tapers, whose other faces are not among its faces."""
        if self.rims or len(self.faces) != 2:
            return np.empty((0, 3))
        bottom, top = (face.points() for face in self.faces)
        nearest = np.argmin(np.linalg.norm(bottom[:, None] - top[None], axis=2), axis=1)
        return top[nearest] - bottom

    def extent(self, rotation: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Least and largest place along axes (rows, axes, 3) from the centroid, m (rows, axes)."""
        own = axes + turned(-rotation[:, None], axes)  # the axes, along those of the block
        low, high = np.full(own.shape[:2], np.inf), np.full(own.shape[:2], -np.inf)
        for corner in self.corners:
            place = own @ corner
            low, high = np.minimum(low, place), np.maximum(high, place)
        for centre, normal, radius in self.rims:
            place, half = own @ centre, radius * np.sqrt(np.maximum(0.0, 1.0 - (own @ normal) ** 2))
            low, high = np.minimum(low, place - half), np.maximum(high, place + half)
        return low, high

    def facing(self, rotation: FloatArray, other: _Hull, turn: FloatArray, between: FloatArray) -> FloatArray:
        """Axes in which a drum faces another block, whose centroid is `between` away (rows, axes, 3)."""
        if not self.rims:
            return np.empty((len(between), 0, 3))
        upright = self.rims[0][1] + turned(rotation, self.rims[0][1])
        corners = other.corners if len(other.corners) else np.zeros((1, 3))
        places = between[:, None] + corners + turned(turn[:, None], corners[None])
        return places - np.sum(places * upright[:, None], axis=2, keepdims=True) * upright[:, None]


def _directions(vectors: FloatArray) -> FloatArray:
    """Unit vectors, each direction once, whichever way it points."""
    units = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    kept: list[FloatArray] = []
    for unit in units:
        if all(abs(float(unit @ other)) < 1.0 - PARALLEL**2 for other in kept):
            kept.append(unit)
    return np.array(kept)


def deepest_overlap(structure: Structure, time: FloatArray, rows: StructureHistories) -> Overlap:
    """The deepest overlap in the rows, which belong to instants, s. Pairs that cannot meet cost nothing."""
    n = structure.n
    u = np.stack([rows.ux, rows.uy, rows.uz], axis=-1)
    rotation = rows.rotation
    there = np.isfinite(u).all(axis=(1, 2)) & np.isfinite(rotation).all(axis=(1, 2))
    time, u, rotation = time[there], u[there], rotation[there]
    if n < 2 or not len(time):
        return Overlap()
    hulls = [[_Hull(block, part) for part in block.parts or ((),)] for block in structure.blocks]
    reach = np.array([block.reach for block in structure.blocks])
    turning = reach * np.linalg.norm(rotation, axis=2)
    most = np.max(np.linalg.norm(u, axis=2) + turning, axis=0)
    found = Overlap()
    for i, j in np.argwhere(_may_meet(structure, reach, most)):
        between, moved = structure.blocks[j].centroid - structure.blocks[i].centroid, u[:, j] - u[:, i]
        far = np.linalg.norm(moved, axis=1) + turning[:, i] + turning[:, j]
        for one, other in product(hulls[i], hulls[j]):
            still = np.zeros((1, 3))
            built = float(_apart(one, other, still, still, between[None])[0])
            near = np.flatnonzero(far >= built)
            for first in range(0, len(near), ROWS):
                at = near[first : first + ROWS]
                depth = min(built, 0.0) - _apart(one, other, rotation[at, i], rotation[at, j], between + moved[at])
                k = int(np.argmax(depth))
                if depth[k] > max(found.depth, TOUCH):
                    found = Overlap(float(depth[k]), (structure.names[i], structure.names[j]), float(time[at[k]]))
    return found


def _may_meet(structure: Structure, reach: FloatArray, most: FloatArray) -> NDArray[np.bool_]:
    """Which pairs (i, j), i < j, that no joint connects, are as near as built as both move, (n, n).

    The distance is not below that of the spheres about both, nor below that of the boxes along the axes of the base.
    """
    n, blocks = structure.n, structure.blocks
    centre = np.array([block.centroid for block in blocks])
    low = np.array([np.min(block.corners, axis=0) for block in blocks])
    high = np.array([np.max(block.corners, axis=0) for block in blocks])
    spread = np.array([max((face.radius for face in block.faces), default=0.0) for block in blocks])
    low, high = low - 0.01 * spread[:, None], high + 0.01 * spread[:, None]  # rims lie beyond the corners drawn on them
    apart = np.linalg.norm(centre[:, None] - centre[None], axis=2) - reach[:, None] - reach[None]
    for axis in range(3):
        gap = low[None, :, axis] - high[:, None, axis]
        apart = np.maximum(apart, np.maximum(gap, gap.T))
    found: NDArray[np.bool_] = apart <= most[:, None] + most[None]
    found &= np.triu(np.ones((n, n), dtype=np.bool_), 1)
    for joint in structure.joints:
        if joint.lower < n:
            found[joint.upper, joint.lower] = found[joint.lower, joint.upper] = False
    for pair in (pair for pair in structure.neighbours if not pair.wall):
        found[pair.one, pair.other] = found[pair.other, pair.one] = False
    return found


def _apart(one: _Hull, other: _Hull, r1: FloatArray, r2: FloatArray, between: FloatArray) -> FloatArray:
    """Distance along the axis that separates best, below 0 by the overlap, m (rows,).

    r1, r2: rotations since built, rad (rows, 3); between: from the centroid of the one to that of the other, m.
    """
    mine, yours = ((hull, rotation[:, None]) for hull, rotation in ((one, r1), (other, r2)))
    normals = [hull.normals + turned(rotation, hull.normals[None]) for hull, rotation in (mine, yours)]
    across = np.empty((len(between), 0, 3))
    if len(one.edges) * len(other.edges) <= PAIRS:
        edges = [hull.edges + turned(rotation, hull.edges[None]) for hull, rotation in (mine, yours)]
        across = np.cross(edges[0][:, :, None], edges[1][:, None]).reshape(len(between), -1, 3)
    facing = one.facing(r1, other, r2, between), other.facing(r2, one, r1, -between)
    axes = np.concatenate([*normals, across, *facing, between[:, None]], axis=1)
    length = np.linalg.norm(axes, axis=2)
    none = length < PARALLEL
    axes = axes / np.where(none, 1.0, length)[:, :, None]
    low1, high1 = one.extent(r1, axes)
    low2, high2 = other.extent(r2, axes)
    away = np.einsum("rak,rk->ra", axes, between)
    gap = np.maximum(away + low2 - high1, low1 - high2 - away)
    return np.max(np.where(none, -np.inf, gap), axis=1)
