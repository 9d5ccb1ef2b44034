"""Joints where faces of two blocks, or of a block and the base, lie on each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....common.errors import InputError
from .faces import NEAR, Face, FloatArray, inset, polygon_moments, shared
from .parts import BASE, JointLaw, Solid, SpatialJoint
from .shapes import rectangle

FACING = -0.99  # largest cosine of the angle between the normals of faces that may touch
ENDLESS = 1e4  # m, side of the square that stands for the base
GROUND = Face(np.zeros(3), np.eye(3), rectangle(ENDLESS, ENDLESS))


def is_endless(face: Face) -> bool:
    """Return True for a plane of the base."""
    return not face.radius and np.array_equal(face.outline, GROUND.outline)


def joints_between(
    solids: tuple[Solid, ...],
    upper: int,
    lower: int,
    bed: JointLaw,
    key: str,
    sides: bool = False,
    ground: Face = GROUND,
) -> list[SpatialJoint]:
    """Return the joints of all pairs of faces that two bodies share; the base is body `len(solids)`, its face `ground`.

    Faces on top of the lower body count; others only if there are none on top, or with `sides`. `key` names the table
    of the joints in messages. Raises InputError if the bodies share no face.
    """
    below = (ground,) if lower == len(solids) else solids[lower].faces
    above = solids[upper].faces
    found = [(face, a, b) for a, b in facing(above, below, FACING) if (face := shared(a, b, key)) is not None]
    if not sides:  # a block on another one touches it from above
        found = [faces for faces in found if faces[0].normal[2] > 1e-6] or found
    if not found:
        names = [*(solid.name for solid in solids), BASE]
        raise InputError(f"{key}: {names[upper]} and {names[lower]} share no face: they must lie on each other")
    return [with_rim(SpatialJoint(upper, lower, turned_face(face), bed, key, a, b)) for face, a, b in found]


def with_rim(joint: SpatialJoint) -> SpatialJoint:
    """Return the joint with the open inside of its rim, about the centroid of the bearing area (theory.md section 13).

    The open inside is the intersection of the insides of both faces. If the rim is half as wide as a face or wider,
    nothing is open.
    """
    rim, face = joint.bed.rim, joint.face
    if rim is None:
        return joint
    above, below = (inside_of(part or face, rim) for part in (joint.above, joint.below))
    if above is None or below is None:
        return joint
    inside = above if above is below or joint.above is joint.below else shared(above, below, joint.key)
    if inside is None:  # nothing as built, but perhaps after a slip
        return replace(joint, inside=replace(face, outline=np.zeros((3, 2)), radius=0.0, bore=0.0))
    if inside.radius and face.radius:
        return replace(joint, inside=replace(face, radius=inside.radius, bore=inside.bore))
    outline = inside.seen_from(face)
    area, first, _ = polygon_moments(outline)
    middle = -first / (face.moments[0] - area)
    if np.hypot(*middle) <= NEAR * face.size:
        return replace(joint, inside=replace(face, outline=outline, radius=0.0, bore=0.0))
    centre = face.centre + face.axes[:, :2] @ middle
    own = replace(face, centre=centre, outline=face.outline - middle)
    return replace(joint, face=own, inside=replace(own, outline=outline - middle))


def with_law(joint: SpatialJoint, bed: JointLaw) -> SpatialJoint:
    """Return the joint with another law, and with the open inside of the rim of that law."""
    if bed.rim == joint.bed.rim:
        return replace(joint, bed=bed)
    face = joint.face
    if joint.inside is not None and not face.radius:  # back about the centroid of the whole face
        area, first, _ = polygon_moments(face.outline)
        middle = first / area
        if np.hypot(*middle) > NEAR * face.size:
            centre = face.centre + face.axes[:, :2] @ middle
            face = replace(face, centre=centre, outline=face.outline - middle)
    return with_rim(replace(joint, face=face, bed=bed, inside=None))


def inside_of(face: Face, rim: float) -> Face | None:
    """Return the inside of a face that touches in a rim of this width (m); None if all of it touches."""
    return face if is_endless(face) else inset(face, rim)


def facing(above: Sequence[Face], below: Sequence[Face], cosine: float) -> list[tuple[Face, Face]]:
    """Return the pairs of faces whose normals have a cosine below `cosine`.

    This is a fast filter: most faces do not look at each other, and a prism has many.
    """
    ways = np.array([face.normal for face in above]) @ np.array([face.normal for face in below]).T
    return [(above[i], below[k]) for i, k in np.argwhere(ways < cosine).tolist()]


def axis_of(normal: FloatArray) -> FloatArray:
    """Return the first axis of a face with this normal.

    It lies in the plane x, z unless the normal is nearly along y. So the second axis is y where the normal lies in that
    plane.
    """
    along = np.array([normal[2], 0.0, -normal[0]])
    if np.linalg.norm(along) < 0.1:  # the normal is along y
        along = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    return along / np.linalg.norm(along)


def axes_of(normal: FloatArray) -> FloatArray:
    """Return the axes of a face with this normal by columns, (3, 3); the first as `axis_of` defines it."""
    along = axis_of(normal)
    axes = np.column_stack([along, np.cross(normal, along), normal])
    axes[np.abs(axes) < 1e-15] = 0.0
    return axes


def turned_face(face: Face) -> Face:
    """Return the same face with its axes as `axes_of` defines them."""
    axes = axes_of(face.normal)
    outline = face.outline @ (face.axes[:, :2].T @ axes[:, :2]) if not face.radius else face.outline
    return Face(face.centre, axes, outline, face.radius, face.bore)
