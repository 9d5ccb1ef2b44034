"""Distance and overlap of convex blocks; non-convex blocks are compared part by part.

Two convex blocks are apart if some axis separates them. For boxes and prisms it is sufficient to test the normals of
faces and the cross products of edges. For drums the axes are those along which two drums, or a drum and a corner, face
each other; where these do not separate drums or hulls of many edges, tangents of rims are edges too, and the nearest
point of the Minkowski difference decides (E. Gilbert, SIAM J. Control 4, 1966, p. 61). The extent of a block along an
axis is that of its corners and rims.

Along these axes the distance of blocks whose corners or edges are nearest is too small. As built it is that of the
nearest points (`apart`; E. G. Gilbert, D. W. Johnson, S. S. Keerthi, IEEE J. Robotics and Automation 4, 1988, p. 193).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .blocks.faces import Face, FloatArray
from .blocks.parts import Solid, SpatialJoint
from .blocks.shapes import cross, turned

PARALLEL = 1e-6  # sine of the angle between two edges; of the size of a block: corners closer than this are one
PAIRS = 2000  # of edges; with more, their cross products are not tested: overlaps may seem deeper, never less deep
TOUCH, TOUCH_PART = 1e-4, 1e-4  # m, and of the size of a block: blocks that overlap by less as built touch
TANGENTS = 12  # to a rim, in half a turn
NEAREST = 200  # iterations for the nearest point
CLOSE, SAME, ROUNDING = 1e-13, 1e-12, 1e-15  # of the size: by which supports are nearer; equal distances; of sums


@dataclass(frozen=True, eq=False)
class ConvexPart:
    """The corners, rims and axes of a convex block or part, from the centroid of the block, along the base's axes."""

    block: Solid
    part: tuple[Face, ...] = ()

    @property
    def faces(self) -> tuple[Face, ...]:
        """The faces of the part, or of the whole block."""
        return self.part or self.block.faces

    @cached_property
    def corners(self) -> FloatArray:
        """The corners of the polygonal faces, each once, (corners, 3) m."""
        found = [face.points() - self.block.centroid for face in self.faces if not face.radius]
        if not found:
            return np.empty((0, 3))
        every = np.concatenate(found)
        _, first = np.unique(np.round(every / (PARALLEL * self.block.size)), axis=0, return_index=True)
        return every[np.sort(first)]

    @cached_property
    def rims(self) -> list[tuple[FloatArray, FloatArray, float]]:
        """The centre (m), normal and radius (m) of each round face."""
        faces = [face for face in self.faces if face.radius]
        return [(face.centre - self.block.centroid, face.normal, face.radius) for face in faces]

    @cached_property
    def edges(self) -> FloatArray:
        """The directions of the edges, (edges, 3); of a drum that of its axis."""
        if self.rims:
            return self.rims[0][1][None]
        outlines = [face.points() for face in self.faces]
        found = [np.roll(outline, -1, axis=0) - outline for outline in outlines]
        return _directions(np.concatenate([*found, self._sides]))

    @cached_property
    def edges_and_tangents(self) -> FloatArray:
        """The directions of the edges; of a drum with those of tangents of its rims."""
        if not self.rims:
            return self.edges
        angles = np.pi / TANGENTS * np.arange(TANGENTS)[:, None]
        x, y, _ = next(face for face in self.faces if face.radius).axes.T
        return np.concatenate([self.edges, np.cos(angles) * x + np.sin(angles) * y])

    @cached_property
    def normals(self) -> FloatArray:
        """The normals of the faces, (normals, 3)."""
        found = [face.normal[None] for face in self.faces]
        if len(self._sides):  # of a box that tapers: each contains an edge of the bottom and one to the top
            bottom = self.faces[0].points()
            along = np.roll(bottom, -1, axis=0) - bottom
            found += [np.cross(along, side) for side in (self._sides, np.roll(self._sides, -1, axis=0))]
        return _directions(np.concatenate(found))

    @cached_property
    def _sides(self) -> FloatArray:
        """The edges from the bottom to the top of a tapering box, whose lateral faces are not among its faces."""
        if self.rims or len(self.faces) != 2:
            return np.empty((0, 3))
        bottom, top = (face.points() for face in self.faces)
        nearest = np.argmin(np.linalg.norm(bottom[:, None] - top[None], axis=2), axis=1)
        return top[nearest] - bottom

    def extent(self, rotation: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the least and the largest coordinate along axes (rows, axes, 3) from the centroid, m (rows, axes).

        rotation: (rows, 3), rad, since built.
        """
        own = axes + turned(-rotation[:, None], axes)  # the axes, along those of the block
        low, high = np.full(own.shape[:2], np.inf), np.full(own.shape[:2], -np.inf)
        for corner in self.corners:
            place = own @ corner
            low, high = np.minimum(low, place), np.maximum(high, place)
        for centre, normal, radius in self.rims:
            place, half = own @ centre, radius * np.sqrt(np.maximum(0.0, 1.0 - (own @ normal) ** 2))
            low, high = np.minimum(low, place - half), np.maximum(high, place + half)
        return low, high

    def farthest(self, rotation: FloatArray, along: FloatArray) -> FloatArray:
        """Return the farthest point along a direction from the centroid, m (rows, 3): the support point.

        rotation: (rows, 3), rad, since built; along: (rows, 3).
        """
        own = along + turned(-rotation, along)
        found, most = np.zeros_like(own), np.full(len(own), -np.inf)
        for corner in self.corners:
            place = own @ corner
            found, most = np.where((place > most)[:, None], corner, found), np.maximum(most, place)
        for centre, normal, radius in self.rims:
            across = own - (own @ normal)[:, None] * normal
            length = np.linalg.norm(across, axis=1, keepdims=True)
            point = centre + radius * across / np.maximum(length, PARALLEL)
            place = np.einsum("rk,rk->r", own, point)
            found, most = np.where((place > most)[:, None], point, found), np.maximum(most, place)
        return found + turned(rotation, found)

    def support(self, along: FloatArray) -> FloatArray:
        """Return the farthest point along a direction (3,) from the centroid as built, m (3,)."""
        found = [self.corners[np.argmax(self.corners @ along)]] if len(self.corners) else []
        for centre, normal, radius in self.rims:
            across = along - (along @ normal) * normal
            across -= (across @ normal) * normal  # rounding of a direction nearly along the normal
            length = float(np.linalg.norm(across))
            found.append(centre + radius / length * across if length else centre)
        return max(found, key=lambda point: float(point @ along))

    def facing(self, rotation: FloatArray, other: ConvexPart, turn: FloatArray, between: FloatArray) -> FloatArray:
        """Return the axes along which a drum faces another block, (rows, axes, 3).

        `rotation` and `turn` are those of the drum and of the other block since built, rad (rows, 3); `between` is from
        the centroid of the drum to that of the other block, m (rows, 3).
        """
        if not self.rims:
            return np.empty((len(between), 0, 3))
        upright = self.rims[0][1] + turned(rotation, self.rims[0][1])
        corners = other.corners if len(other.corners) else np.zeros((1, 3))
        places = between[:, None] + corners + turned(turn[:, None], corners[None])
        return places - np.sum(places * upright[:, None], axis=2, keepdims=True) * upright[:, None]


def _directions(vectors: FloatArray) -> FloatArray:
    """Return unit vectors of the distinct directions, regardless of sign."""
    units = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    kept: list[FloatArray] = []
    for unit in units:
        if all(abs(float(unit @ other)) < 1.0 - PARALLEL**2 for other in kept):
            kept.append(unit)
    return np.array(kept)


def along_axes(
    one: ConvexPart, other: ConvexPart, r1: FloatArray, r2: FloatArray, between: FloatArray, tangents: bool = False
) -> FloatArray:
    """Return the distance of two convex blocks along the axes that may separate them; arguments as in `distance`.

    tangents: whether those of rims count as edges.
    """
    mine, yours = ((hull, rotation[:, None]) for hull, rotation in ((one, r1), (other, r2)))
    # candidate axes: normals, cross products of edges, axes of drums, line of centroids
    normals = [hull.normals + turned(rotation, hull.normals[None]) for hull, rotation in (mine, yours)]
    across = np.empty((len(between), 0, 3))
    own, opposite = (hull.edges_and_tangents if tangents else hull.edges for hull in (one, other))
    if len(own) * len(opposite) <= PAIRS:
        edges = own + turned(r1[:, None], own[None]), opposite + turned(r2[:, None], opposite[None])
        across = np.cross(edges[0][:, :, None], edges[1][:, None]).reshape(len(between), -1, 3)
    facing = one.facing(r1, other, r2, between), other.facing(r2, one, r1, -between)
    axes = np.concatenate([*normals, across, *facing, between[:, None]], axis=1)
    # unit vectors; vanishing ones are masked
    length = np.linalg.norm(axes, axis=2)
    none = length < PARALLEL
    axes = axes / np.where(none, 1.0, length)[:, :, None]
    # gap along each axis
    low1, high1 = one.extent(r1, axes)
    low2, high2 = other.extent(r2, axes)
    away = np.einsum("rak,rk->ra", axes, between)
    gap = np.maximum(away + low2 - high1, low1 - high2 - away)
    return np.max(np.where(none, -np.inf, gap), axis=1)


def _nearest(one: ConvexPart, other: ConvexPart, r1: FloatArray, r2: FloatArray, between: FloatArray) -> FloatArray:
    """Return a lower bound of the distance of two convex bodies, m (rows,), exact where they are apart (Gilbert)."""
    point, bound = between.copy(), np.full(len(between), -np.inf)
    for _ in range(NEAREST):
        length = np.linalg.norm(point, axis=1)
        along = point / np.maximum(length, PARALLEL)[:, None]
        support = between + other.farthest(r2, -along) - one.farthest(r1, along)
        bound = np.where(length > PARALLEL, np.maximum(bound, np.einsum("rk,rk->r", support, along)), bound)
        step = support - point
        square = np.einsum("rk,rk->r", step, step)
        part = -np.einsum("rk,rk->r", point, step) / np.maximum(square, PARALLEL**2)
        point += np.clip(part, 0.0, 1.0)[:, None] * step
    return bound


def distance(one: ConvexPart, other: ConvexPart, r1: FloatArray, r2: FloatArray, between: FloatArray) -> FloatArray:
    """Return the signed distance of two convex bodies, m (rows,), negative by their overlap.

    `r1` and `r2` are their rotations since built, rad (rows, 3); `between` is from the centroid of `one` to that of
    `other`, m (rows, 3).
    """
    found = along_axes(one, other, r1, r2, between)
    unclear = np.flatnonzero(found < 0.0)
    complete = not (one.rims or other.rims) and len(one.edges) * len(other.edges) <= PAIRS
    if len(unclear) and not complete:
        rows = r1[unclear], r2[unclear], between[unclear]
        nearest, by_tangents = _nearest(one, other, *rows), along_axes(one, other, *rows, tangents=True)
        found[unclear] = np.maximum(found[unclear], np.maximum(nearest, by_tangents))
    return found


def _nearest_of(corners: list[FloatArray]) -> tuple[list[FloatArray], FloatArray]:
    """Return the point nearest to the origin of a simplex of up to four points (3,), m, and the corners that it needs.

    The last corner is among them, and no tetrahedron holds the origin. A convex combination is never too near.
    """
    last = corners[-1]
    edges = [corner - last for corner in corners[:-1]]
    found, nearest, least = [last], last, float(last @ last)
    for count in (1, 2):
        for some in combinations(range(len(edges)), count):
            a, b = edges[some[0]], edges[some[-1]]
            if count == 1:
                square, parts = float(a @ a), [-float(last @ a)]
            else:
                normal = cross(a, b)
                square = float(normal @ normal)
                parts = [-float(cross(last, b) @ normal), -float(cross(a, last) @ normal)]
            if not (square > 0.0 and min(parts) > 0.0 and sum(parts) < square):
                continue
            point = last + sum(part / square * edges[k] for part, k in zip(parts, some, strict=True))
            if float(point @ point) < least:
                found, nearest, least = [*(corners[k] for k in some), last], point, float(point @ point)
    return found, nearest


def apart(one: ConvexPart, other: ConvexPart, between: FloatArray) -> tuple[float, FloatArray | None]:
    """Return the distance of two convex bodies as built, m, and the vector between their nearest points.

    `between` (3,) is from the centroid of `one` to that of `other`, m. The distance is negative by their overlap. The
    vector (3,), m, from the first to the second, is None where the distance is that along the axes of `distance`, as of
    faces, or negative.
    """
    still = np.zeros((1, 3))
    along = float(distance(one, other, still, still, between[None])[0])
    if not along > 0.0:
        return along, None
    size = one.block.reach + other.block.reach
    # support points of the Minkowski difference, from the line of centroids on
    point = between + other.support(-between) - one.support(between)
    corners, length = [point], float(np.linalg.norm(point))
    for _ in range(NEAREST):
        unit = point / length
        support = between + other.support(-unit) - one.support(unit)
        if length - float(support @ unit) <= CLOSE * size or any(np.array_equal(support, c) for c in corners):
            break
        # where several corners are equally far, a turn that shortens by less than rounding leads to the right one
        corners, nearer = _nearest_of([*corners, support])
        if float(np.linalg.norm(nearer)) > length + ROUNDING * size:
            break
        point, length = nearer, float(np.linalg.norm(nearer))
    return (length, point) if length - along > SAME * size else (along, None)


def hulls_of(block: Solid) -> list[ConvexPart]:
    """Return the convex body of a block, or those of its convex parts."""
    return [ConvexPart(block, part) for part in block.parts or (block.hull,)]


class BuiltOverlap(NamedTuple):
    """Two blocks that overlap as built."""

    one: int  # numbers of the blocks
    other: int
    depth: float  # m


def touching(*blocks: Solid) -> float:
    """Return the largest overlap as built that counts as touching (m), since surveyed lengths are rounded."""
    return max(TOUCH, TOUCH_PART * min(block.reach for block in blocks))


def near_as_built(blocks: Sequence[Solid], joints: Iterable[SpatialJoint], within: FloatArray) -> NDArray[np.bool_]:
    """Return the mask of pairs (i, j), i < j, without a joint that are nearer than `within` (m), (n, n).

    The distance is bounded from below by those of the bounding spheres and of the boxes along the axes of the base.
    """
    n = len(blocks)
    # bounding spheres and boxes
    centre = np.array([block.centroid for block in blocks])
    reach = np.array([block.reach for block in blocks])
    corners = [np.concatenate([face.points() for face in (*block.faces, *block.hull)]) for block in blocks]
    low, high = (np.array([extreme(part, axis=0) for part in corners]) for extreme in (np.min, np.max))
    spread = np.array([max((face.radius for face in block.faces), default=0.0) for block in blocks])
    low, high = low - 0.01 * spread[:, None], high + 0.01 * spread[:, None]  # rims lie beyond the corners drawn on them
    apart = np.linalg.norm(centre[:, None] - centre[None], axis=2) - reach[:, None] - reach[None]
    for axis in range(3):
        gap = low[None, :, axis] - high[:, None, axis]
        apart = np.maximum(apart, np.maximum(gap, gap.T))
    found: NDArray[np.bool_] = apart <= within
    # each pair once, without joined ones
    found &= np.triu(np.ones((n, n), dtype=np.bool_), 1)
    for joint in joints:
        if joint.lower < n:
            found[joint.upper, joint.lower] = found[joint.lower, joint.upper] = False
    return found


def built_overlaps(blocks: Sequence[Solid], joints: Iterable[SpatialJoint]) -> list[BuiltOverlap]:
    """Return the pairs of blocks without a joint whose overlap as built is more than touching, the deepest first."""
    found = []
    for i, j in np.argwhere(near_as_built(blocks, joints, np.array(-TOUCH))):
        one, other = blocks[i], blocks[j]
        still, between = np.zeros((1, 3)), (other.centroid - one.centroid)[None]
        pairs = product(hulls_of(one), hulls_of(other))
        depth = -min(float(distance(a, b, still, still, between)[0]) for a, b in pairs)
        if depth > touching(one, other):
            found.append(BuiltOverlap(int(i), int(j), depth))
    return sorted(found, key=lambda overlap: -overlap.depth)
