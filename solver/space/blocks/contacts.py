"""Joints where faces of two blocks, or of a block and the base, lie on each other."""

from __future__ import annotations

import numpy as np

from ...common.errors import InputError
from .faces import Face, FloatArray, shared
from .parts import BASE, Bed, Joint, Solid
from .shapes import rectangle

ENDLESS = 1e4  # m, of the base
GROUND = Face(np.zeros(3), np.eye(3), rectangle(ENDLESS, ENDLESS))


def joints_between(
    solids: tuple[Solid, ...], upper: int, lower: int, bed: Bed, key: str, sides: bool = False
) -> list[Joint]:
    """The joints of all faces that two bodies share. Raises InputError if they share none."""
    below = (GROUND,) if lower == len(solids) else solids[lower].faces
    found = [face for a in solids[upper].faces for b in below if (face := shared(a, b)) is not None]
    if not sides:  # what stands on a block touches it from above
        found = [face for face in found if face.normal[2] > 1e-6] or found
    if not found:
        names = [*(solid.name for solid in solids), BASE]
        raise InputError(f"{key}: {names[upper]} and {names[lower]} share no face: they must lie on each other")
    return [Joint(upper, lower, _level(face), bed, key) for face in found]


def _level(face: Face) -> Face:
    """The face with its first axis along x as far as that lies in it."""
    normal, x = face.normal, np.array([1.0, 0.0, 0.0])
    along = x - (x @ normal) * normal
    if np.linalg.norm(along) < 0.1:
        along = np.array([0.0, 1.0, 0.0]) - normal[1] * normal
    return turned_face(face, along / np.linalg.norm(along))


def turned_face(face: Face, along: FloatArray) -> Face:
    """The face with this direction, in its plane, as its first axis."""
    axes = np.column_stack([along, np.cross(face.normal, along), face.normal])
    axes[np.abs(axes) < 1e-15] = 0.0
    outline = face.outline @ (face.axes[:, :2].T @ axes[:, :2]) if not face.radius else face.outline
    return Face(face.centre, axes, outline, face.radius, face.bore)
