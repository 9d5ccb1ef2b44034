"""Checks of positions: blocks in the same place, contacts counted twice, joints far from their blocks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from ....common.errors import InputError
from .faces import NEAR, Face, shared
from .parts import BASE, Solid, SpatialJoint

SAME = 1e-6  # of the size of a block: places closer than this are one
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
    """Raise InputError for a joint away from its blocks, and for two joints of a pair that share an area."""
    pairs: dict[tuple[int, int], list[SpatialJoint]] = defaultdict(list)
    for joint in joints:
        for body in (joint.upper, joint.lower):
            if body < len(blocks):
                _check_near(joint, blocks[body])
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


def _overlap(one: Face, other: Face, key: str) -> bool:
    """Return True if two coplanar faces share an area, whichever way their normals point."""
    if float(one.normal @ other.normal) > 0.0:
        across = np.diag([1.0, -1.0, -1.0])
        one = Face(one.centre, one.axes @ across, one.outline * [1.0, -1.0], one.radius, one.bore)
        one = Face(one.centre, one.axes, one.outline[::-1].copy(), one.radius, one.bore)
    face = shared(one, other, key)
    return face is not None and face.moments[0] > NEAR * min(one.moments[0], other.moments[0])
