"""Overlaps of blocks in a run that the contacts of the model do not describe.

The convex bodies of every two blocks are compared that neither a joint connects nor the table of neighbours lets meet.
Two bodies with joints are compared while one of their joints has ended, that is, its faces no longer share an area: a
joint on a narrow strip ends once it has slid by the width of the strip.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...kernels.structure.layout import JOINED_GAP
from .blocks.faces import Face, FloatArray
from .blocks.parts import BASE, SpatialJoint
from .blocks.shapes import turned
from .convex import TOUCH, ConvexPart, along_axes, distance, hulls_of, near_as_built
from .model import Structure
from .outputs import StructureHistories

ROWS = 1000  # instants at once, which limits the memory
FEW = 50  # instants whose overlap is worked out at once
OF_SIZE = 1e-3  # of the smaller of two bodies: depth that is reported where it is less than TOUCH
BEYOND = 0.05  # of the depth of a contact: an overlap deeper by up to this is still ascribed to it
UPRIGHT = 1e-6  # of the vertical part of a normal: the base below such a face is a half-space
UNJOINED, ENDED = "unjoined", "ended"
WHY = {  # why two bodies do not meet: for a sentence, and for a row of a check
    UNJOINED: (
        "no joint connects them, and no [neighbours] lets them meet within its reach; move them apart, or",
        "no joint, no neighbours",
    ),
    ENDED: (
        "a joint between them has slid until its faces share no area, and bears nothing; join whole faces (with a rim, "
        "if they touch along their edges), or",
        "a joint between them has slid off its faces",
    ),
}


class Overlap(NamedTuple):
    """The deepest overlap of two blocks in a run that no contact of the model describes, beyond that as built."""

    depth: float = 0.0  # m
    between: tuple[str, ...] = ()  # their names; empty without an overlap
    time: float = float("nan")  # s
    cause: str = UNJOINED  # a key of WHY

    @property
    def sentence(self) -> str:
        """The warning for the user."""
        names, depth, why = " and ".join(self.between), 1e3 * self.depth, WHY[self.cause][0]
        return f"{names} pass into each other by {depth:.3g} mm at {self.time:.4g} s: {why} do not rely on this run"

    @property
    def why(self) -> str:
        """The reason why these two do not meet in the model."""
        return WHY[self.cause][1]


def deepest_overlap(structure: Structure, time: FloatArray, rows: StructureHistories) -> Overlap:
    """Return the deepest overlap in the rows at the instants `time`, s.

    Pairs that cannot come near each other are skipped.
    """
    n = structure.n
    u = np.stack([rows.ux, rows.uy, rows.uz], axis=-1)
    rotation = rows.rotation
    there = np.isfinite(u).all(axis=(1, 2)) & np.isfinite(rotation).all(axis=(1, 2))
    # the first of the pairs of two blocks; some meet only after a fall
    meet = {frozenset((pair.one, pair.other)): k for k, pair in reversed([*enumerate(structure.neighbours)])}
    time, u, rotation = time[there], u[there], rotation[there]
    if not len(time):
        return Overlap()
    hulls = [hulls_of(block) for block in structure.blocks]
    found = _deepest_at_ended_joints(structure, hulls, time, u, rotation)
    if n < 2:
        return found
    # a pair is compared where the displacements of both could close its distance as built
    reach = np.array([block.reach for block in structure.blocks])
    turning = reach * np.linalg.norm(rotation, axis=2)
    most = np.max(np.linalg.norm(u, axis=2) + turning, axis=0)
    for i, j in np.argwhere(near_as_built(structure.blocks, structure.joints, most[:, None] + most[None])):
        between, moved = structure.blocks[j].centroid - structure.blocks[i].centroid, u[:, j] - u[:, i]
        far = np.linalg.norm(moved, axis=1) + turning[:, i] + turning[:, j]
        k, unmet = meet.get(frozenset((int(i), int(j)))), np.ones(len(time), dtype=np.bool_)
        if k is not None:
            if not structure.neighbours[k].joined:
                continue
            unmet = rows.gap[there, k] == JOINED_GAP
        for one, other in product(hulls[i], hulls[j]):
            still = np.zeros((1, 3))
            built = float(distance(one, other, still, still, between[None])[0])
            near = np.flatnonzero(unmet & (far >= built))
            least = max(found.depth, _least_depth(structure, i, j))
            places = rotation[near, i], rotation[near, j], between + moved[near]
            depth, row = _deepest_row(one, other, places, min(built, 0.0), least)
            if depth > least:
                found = Overlap(depth, (structure.names[i], structure.names[j]), float(time[near[row]]))
    return found


def _least_depth(structure: Structure, *bodies: int) -> float:
    """Return the depth (m) above which an overlap of two bodies is reported; the base has the number after the last."""
    return min(TOUCH, *(OF_SIZE * structure.blocks[i].reach for i in bodies if i < structure.n))


def _deepest_row(
    one: ConvexPart, other: ConvexPart, places: tuple[FloatArray, FloatArray, FloatArray], built: float, least: float
) -> tuple[float, int]:
    """Return the largest depth of two parts, m, if it is more than `least`, and its row; else `least` and -1.

    `places` are their rotations and what is between them, as of `distance`; `built` is the distance from which the
    depth is measured, m. The depth is at most that along a few axes: only rows in which it may be the largest so far
    are worked out.
    """
    r1, r2, between = places
    rows = len(between)
    chunks = [slice(first, first + ROWS) for first in range(0, rows, ROWS)]
    bounds = [along_axes(one, other, r1[chunk], r2[chunk], between[chunk]) for chunk in chunks]
    bound = built - np.concatenate([np.empty(0), *bounds])
    deepest, row = least, -1
    # from the largest bound on, a few rows at once
    order = np.argsort(-bound, kind="stable")
    for first in range(0, rows, FEW):
        some = order[first : first + FEW]
        some = some[bound[some] > deepest]
        if not len(some):
            break
        depth = built - distance(one, other, r1[some], r2[some], between[some])
        k = int(np.argmax(depth))
        if depth[k] > deepest:
            deepest, row = float(depth[k]), int(some[k])
    return deepest, row


def _deepest_at_ended_joints(
    structure: Structure, hulls: list[list[ConvexPart]], time: FloatArray, u: FloatArray, rotation: FloatArray
) -> Overlap:
    """Return the deepest overlap of joined bodies while a joint of theirs has ended, beyond that in their others."""
    joints: dict[tuple[int, int], list[SpatialJoint]] = {}
    for joint in structure.joints:
        joints.setdefault((joint.upper, joint.lower), []).append(joint)
    names, found = (*structure.names, BASE), Overlap()
    for (i, j), between in joints.items():
        if any(joint.bearing is not None for joint in between) or structure.after_fall:
            continue
        sides = [_Sides.of(structure, joint, u, rotation) for joint in between]
        ended = np.zeros(len(time), dtype=np.bool_)
        for side in sides:
            ended |= side.ended
        at = np.flatnonzero(ended)
        if not len(at):
            continue
        # the depth in the joints that have not ended
        known = np.max([np.where(side.ended[at], 0.0, side.depth(at)) for side in sides], axis=0)
        for first in range(0, len(at), ROWS):
            some = at[first : first + ROWS]
            depth = _depth_of_bodies(structure, hulls, between, u[some], rotation[some])
            depth -= (1.0 + BEYOND) * known[first : first + ROWS]
            k = int(np.argmax(depth))
            if depth[k] > max(found.depth, _least_depth(structure, i, j)):
                found = Overlap(float(depth[k]), (names[i], names[j]), float(time[some[k]]), ENDED)
    return found


def _depth_of_bodies(
    structure: Structure, hulls: list[list[ConvexPart]], joints: list[SpatialJoint], u: FloatArray, rotation: FloatArray
) -> FloatArray:
    """Return the depth of the overlap of two joined bodies, beyond that as built, m (rows,)."""
    i, j = joints[0].upper, joints[0].lower
    depth, still = np.zeros(len(u)), np.zeros((1, 3))
    if j == structure.n:  # the half-space below each upright face
        for joint in joints:
            normal = joint.face.normal[None, None]
            if joint.face.normal[2] >= 1.0 - UPRIGHT:
                place = structure.blocks[i].centroid - joint.face.centre
                for hull in hulls[i]:
                    axes = np.broadcast_to(normal, (len(u), 1, 3))
                    low, built = hull.extent(rotation[:, i], axes)[0][:, 0], hull.extent(still, normal)[0][0, 0]
                    height = (place + u[:, i]) @ joint.face.normal + low
                    depth = np.maximum(depth, np.minimum(place @ joint.face.normal + built, 0.0) - height)
        return depth
    between = structure.blocks[j].centroid - structure.blocks[i].centroid
    for one, other in product(hulls[i], hulls[j]):
        built = min(float(distance(one, other, still, still, between[None])[0]), 0.0)
        apart = distance(one, other, rotation[:, i], rotation[:, j], between + u[:, j] - u[:, i])
        depth = np.maximum(depth, built - apart)
    return depth


@dataclass(frozen=True)
class _Sides:
    """Both faces of a joint in the rows: the corners of the upper one, seen along the axes of the lower one."""

    corners: FloatArray  # (rows, corners, 3) m, from the centre of the joint on its lower body
    lower: FloatArray  # (corners, 2) m
    ended: NDArray[np.bool_]  # mask of the rows in which they share no area

    @classmethod
    def of(cls, structure: Structure, joint: SpatialJoint, u: FloatArray, rotation: FloatArray) -> _Sides:
        """Return the faces of a joint in the rows; a joint that does not slide never ends."""
        face, none = joint.face, np.zeros(len(u), dtype=np.bool_)
        upper, lower = (_outline(part or face, face) for part in (joint.above, joint.below))
        moved, turns = [], []
        for body in (joint.upper, joint.lower):
            is_block = body < structure.n
            turn = rotation[:, body] if is_block else np.zeros_like(u[:, 0])
            arm = face.centre - structure.blocks[body].centroid if is_block else np.zeros(3)
            moved.append((u[:, body] if is_block else np.zeros_like(turn)) + turned(turn, arm[None]))
            turns.append(turn)
        # corners of the upper face from the moved centre, along the moved axes of the lower face
        points = upper @ face.axes[:, :2].T
        corners = (moved[0] - moved[1])[:, None] + points + turned(turns[0][:, None], points[None])
        axes = [axis + turned(turns[1], axis[None]) for axis in face.axes.T]
        seen = np.stack([np.einsum("rck,rk->rc", corners, axis) for axis in axes], axis=-1)
        if joint.bed.friction is None:
            return cls(seen, lower, none)
        return cls(seen, lower, _are_apart(seen[..., :2], lower))

    def depth(self, at: NDArray[np.intp]) -> FloatArray:
        """Return the depth of the upper face below the plane of the lower one, m."""
        return np.maximum(0.0, -np.min(self.corners[at, :, 2], axis=1))


def _outline(face: Face, joint: Face) -> FloatArray:
    """Return the rim of a face along the axes of a joint, m (corners, 2)."""
    flat: FloatArray = (face.points() - joint.centre) @ joint.axes[:, :2]
    return flat


def _are_apart(moved: FloatArray, still: FloatArray) -> NDArray[np.bool_]:
    """Return the mask of convex polygons (rows, corners, 2) that share no area with another one (corners, 2)."""
    apart = np.zeros(len(moved), dtype=np.bool_)
    # along the normals of the one that is still, then of the one that moves
    for side in np.roll(still, -1, axis=0) - still:
        one, other = moved @ _across(side), still @ _across(side)
        apart |= (np.min(one, axis=1) >= np.max(other)) | (np.max(one, axis=1) <= np.min(other))
    for normal in np.moveaxis(_across(np.roll(moved, -1, axis=1) - moved), 1, 0):
        one, other = np.einsum("rck,rk->rc", moved, normal), normal @ still.T
        apart |= np.min(one, axis=1) >= np.max(other, axis=1)
        apart |= np.max(one, axis=1) <= np.min(other, axis=1)
    return apart


def _across(side: FloatArray) -> FloatArray:
    """Return the normal to each side."""
    return np.stack([side[..., 1], -side[..., 0]], axis=-1)
