"""Checks of positions: blocks in the same place, contacts counted twice, joints far from their blocks."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....common.errors import InputError
from .faces import NEAR, Face, FloatArray, outward_normals, shared
from .outlines import corners_around
from .parts import BASE, Solid, SpatialJoint

SAME = 1e-6  # of the size of a block: places closer than this are one
RIM = 360  # points of a round rim
BEYOND = 0.1  # of the diagonal of a block: largest distance of the centre of a joint from the box around it


def check_places(keys: Sequence[str], blocks: Sequence[Solid]) -> None:
    """Raise InputError for two blocks that fill the same space; keys: names of their tables."""
    taken: dict[tuple[int, ...], str] = {}
    for key, block in zip(keys, blocks, strict=True):
        low, high = _box(block)
        place = tuple(np.round(np.concatenate([low, high, block.centroid]) / (SAME * block.size)).tolist())
        if place in taken:
            raise InputError(f"{key}: {block.name} fills the same place as {taken[place]}, must lie elsewhere")
        taken[place] = block.name


def check_joints(blocks: Sequence[Solid], joints: Sequence[SpatialJoint]) -> None:
    """Raise InputError for a joint away from or wider than its blocks, and for two of a pair that share an area."""
    pairs: dict[tuple[int, int], list[SpatialJoint]] = defaultdict(list)
    for joint in joints:
        for body in (joint.upper, joint.lower):
            if body < len(blocks):
                _check_near(joint, blocks[body])
                _check_within(joint, blocks[body])
        pairs[min(joint.upper, joint.lower), max(joint.upper, joint.lower)].append(joint)
    names = [*(block.name for block in blocks), BASE]
    for (one, other), found in pairs.items():
        for k, joint in enumerate(found):
            for before in found[:k]:
                if _overlap(joint.face, before.face, joint.key):
                    what = f"the contact of {names[one]} and {names[other]} counts twice, it is that of"
                    raise InputError(f"{joint.key}: {what} {before.key} too, must be left out in one of them")


def _box(block: Solid) -> tuple[np.ndarray, np.ndarray]:
    corners = block.corners
    return np.min(corners, axis=0), np.max(corners, axis=0)


def _check_near(joint: SpatialJoint, block: Solid) -> None:
    low, high = _box(block)
    outside = np.maximum(0.0, np.maximum(low - joint.face.centre, joint.face.centre - high))
    far, most = float(np.linalg.norm(outside)), BEYOND * float(np.linalg.norm(high - low))
    if far > most:
        raise InputError(f"{joint.key}.at: is {far:.4g} m away from {block.name}, must be {most:.4g} m at most")


def _check_within(joint: SpatialJoint, block: Solid) -> None:
    """Raise InputError for a section that reaches beyond a block, seen along the normal of the joint.

    It must lie on the faces of the block in its plane, without one on the outline of the whole block. A joint of faces
    that touch lies within them; the force of a bearing acts at a point.
    """
    if joint.above is not None or joint.bearing is not None:
        return
    flat = joint.face.axes[:, :2]
    section = (joint.face.points(RIM) - joint.face.centre) @ flat
    level = [face for face in block.faces if _is_in_plane(face, joint.face, block.reach)]
    corners = (np.concatenate([_around(face) for face in level or block.faces]) - joint.face.centre) @ flat
    # extents along the normals of the sides of the outline
    outline = corners[corners_around(corners)]
    normals = outward_normals(outline)
    own, most = section @ normals.T, outline @ normals.T
    beyond = np.max(own, axis=0) - np.max(most, axis=0)
    k = int(np.argmax(beyond))
    if beyond[k] > SAME * max(joint.face.size, block.reach):
        wide, most_wide = float(np.ptp(own[:, k])), float(np.ptp(most[:, k]))
        raise InputError(
            f"{joint.key}.section: is {wide:.4g} m wide and reaches {beyond[k]:.4g} m beyond {block.name}, which is "
            f"{most_wide:.4g} m wide there, must lie on it"
        )


def _is_in_plane(face: Face, other: Face, size: float) -> bool:
    """Return True if two faces lie in one plane, whichever way their normals point."""
    off = abs(float((face.centre - other.centre) @ other.normal))
    return abs(float(face.normal @ other.normal)) >= 1.0 - NEAR and off <= SAME * size


def _around(face: Face) -> FloatArray:
    """Return the corners of a face (corners, 3), m; of a round one those of a polygon around it."""
    wide = replace(face, radius=face.radius / math.cos(math.pi / RIM)) if face.radius else face
    return wide.points(RIM)


def _overlap(one: Face, other: Face, key: str) -> bool:
    """Return True if two coplanar faces share an area, whichever way their normals point."""
    if float(one.normal @ other.normal) > 0.0:
        outline = (one.outline * [1.0, -1.0])[::-1].copy()
        one = replace(one, axes=one.axes @ np.diag([1.0, -1.0, -1.0]), outline=outline)
    face = shared(one, other, key)
    return face is not None and face.moments[0] > NEAR * min(one.moments[0], other.moments[0])
