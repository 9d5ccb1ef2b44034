"""Convex polyhedra that stand for blocks and their convex parts where neighbours meet (kernels/structure/cells.py)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....common.errors import InputError
from ....kernels.structure import layout as at
from .faces import Face, FloatArray, half_of, polygon_moments

SIDES = 24  # of the prism within a drum
WITHIN = math.cos(math.pi / SIDES)  # radius of the edges of that prism over that of the drum; of its sides the square
BEYOND = 1e-2  # by which an outline is enlarged before all planes cut it
SAME = 1e-9  # of the size: corners closer than this are one


class Plane(NamedTuple):
    """A plane of a polyhedron with its face, from the centroid of the block."""

    normal: FloatArray  # (3,) outward
    distance: float  # m
    axis: FloatArray  # (3,) first axis of the outline
    outline: FloatArray  # (corners, 2) m from the foot of the centroid, anticlockwise


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A convex polyhedron; of a drum the prism within it."""

    planes: tuple[Plane, ...]
    axis: FloatArray  # (3,) m, half the axis of a drum; else 0
    radius: float = 0.0  # m, of the edges of the prism

    @cached_property
    def corners(self) -> FloatArray:
        """The corners, each once, (corners, 3) m."""
        every = np.concatenate([_points(plane) for plane in self.planes])
        size = SAME * float(np.max(np.abs(every)))
        _, first = np.unique(np.round(every / size), axis=0, return_index=True)
        return every[np.sort(first)]

    @cached_property
    def mean_area(self) -> float:
        """The area of its shadow, averaged over all directions, m2: a quarter of its surface (Cauchy)."""
        return 0.25 * sum(float(polygon_moments(plane.outline)[0]) for plane in self.planes)

    def moved(self, by: FloatArray) -> Polyhedron:
        """Return the polyhedron moved by a vector, (3,) m, along the axes of its block; of a drum its prism alone."""
        planes = []
        for plane in self.planes:
            second = np.cross(plane.normal, plane.axis)
            along = np.array([by @ plane.axis, by @ second])
            planes.append(
                plane._replace(distance=plane.distance + float(by @ plane.normal), outline=plane.outline + along)
            )
        return Polyhedron(tuple(planes), np.zeros(3))

    def row(self) -> FloatArray:
        """Return the numbers for the kernels (layout.py, SOLID)."""
        corners, half = self.corners, float(np.linalg.norm(self.axis))
        head = np.zeros(at.SOLID.beside)
        record = at.SOLID.see(head)
        record.planes, record.corners, record.half, record.radius = len(self.planes), len(corners), half, self.radius
        record.size = self.mean_area
        if half:
            record.ux, record.uy, record.uz = self.axis / half
        place, planes = at.SOLID_CORNERS + corners.size + at.SOLID_PLANE * len(self.planes), []
        for plane in self.planes:
            planes.append([*plane.normal, plane.distance, *plane.axis, place, len(plane.outline)])
            place += plane.outline.size
        return np.concatenate(
            [head, corners.ravel(), np.ravel(planes), *(plane.outline.ravel() for plane in self.planes)]
        )


def _points(plane: Plane) -> FloatArray:
    """Return the corners of a face in space, (corners, 3) m."""
    axes = np.array([plane.axis, np.cross(plane.normal, plane.axis)])
    return plane.distance * plane.normal + plane.outline @ axes


def _plane_through(points: FloatArray, inside: FloatArray) -> Plane:
    """Return the plane of a polygon in space, (corners, 3) m, whose normal points away from a point inside."""
    middle = points - np.mean(points, axis=0)
    normal = np.sum(np.cross(middle, np.roll(middle, -1, axis=0)), axis=0)
    normal = normal / np.linalg.norm(normal)
    if float(normal @ (points[0] - inside)) < 0.0:
        normal, points = -normal, points[::-1]
    along = points[1] - points[0]
    axis = along - float(along @ normal) * normal
    axis = axis / np.linalg.norm(axis)
    distance = float(np.mean(points @ normal))
    outline = np.column_stack([points @ axis, points @ np.cross(normal, axis)])
    return Plane(normal, distance, axis, outline)


def polyhedron_of(faces: tuple[Face, ...], centroid: FloatArray, key: str) -> Polyhedron:
    """Return the polyhedron of a convex block or part by its faces. Raises InputError for too many planes."""
    rims = [face for face in faces if face.radius]
    if rims:
        return _prism_in(rims, centroid)
    outlines = [face.points() - centroid for face in faces]
    inside = np.mean(np.concatenate(outlines), axis=0)
    if len(outlines) == 2:
        outlines = _lofted(*outlines)
    if len(outlines) > at.SOLID_PLANES:
        raise InputError(f"{key}: {len(outlines)} faces, must be {at.SOLID_PLANES} at most beside neighbours")
    planes = [_plane_through(points, inside) for points in outlines]
    return Polyhedron(tuple(cut for plane in planes if (cut := _cut(plane, planes)) is not None), np.zeros(3))


def _cut(plane: Plane, planes: list[Plane]) -> Plane | None:
    """Return a plane with the outline that all others leave of it; None if nothing is left."""
    middle = np.mean(plane.outline, axis=0)
    outline = middle + (1.0 + BEYOND) * (plane.outline - middle)
    for other in planes:
        if other is plane or float(plane.normal @ other.normal) > 1.0 - SAME:
            continue
        # depth below the other plane: at + along . (x, y)
        along = -np.array([other.normal @ plane.axis, other.normal @ np.cross(plane.normal, plane.axis)])
        depth = other.distance - plane.distance * float(plane.normal @ other.normal)
        if np.min(depth + outline @ along) < 0.0:
            outline = np.array(half_of(outline.tolist(), (depth + outline @ along).tolist()))
            if len(outline) < 3:
                return None
    return plane._replace(outline=outline)


def _lofted(bottom: FloatArray, top: FloatArray) -> list[FloatArray]:
    """Return the faces, (corners, 3) m, between two outlines, each corner joined to the nearest one of the other."""
    nearest = np.argmin(np.linalg.norm(bottom[:, None] - top[None], axis=2), axis=1)
    top = top[nearest]
    sides = zip(bottom, np.roll(bottom, -1, axis=0), np.roll(top, -1, axis=0), top, strict=True)
    return [bottom, top, *(np.array(side) for side in sides)]


def _prism_in(rims: list[Face], centroid: FloatArray) -> Polyhedron:
    """Return the prism within a drum, whose edges lie WITHIN of its radius from the axis."""
    (low, bottom), (high, top) = ((rim.centre - centroid, rim.radius) for rim in rims)
    axis = 0.5 * (high - low)
    along = axis / np.linalg.norm(axis)
    across = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    across = across / np.linalg.norm(across)
    angle = 2.0 * math.pi * np.arange(SIDES) / SIDES
    circle = np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * np.cross(along, across)
    ends = [centre + WITHIN * radius * circle for centre, radius in ((low, bottom), (high, top))]
    planes = tuple(_plane_through(points, 0.5 * (low + high)) for points in _lofted(*ends))
    is_drum = math.isclose(bottom, top, rel_tol=SAME) and np.linalg.norm(low + high) <= SAME * bottom
    return Polyhedron(planes, axis, WITHIN * bottom) if is_drum else Polyhedron(planes, np.zeros(3))


def slab_behind(face: Face) -> Polyhedron:
    """Return the box behind a wall, as thick as the wall is wide or high, from the origin of the base."""
    points, thick = face.points(), float(np.max(np.ptp(face.outline, axis=0)))
    behind = points - thick * face.normal
    middle = np.mean(points, axis=0) - 0.5 * thick * face.normal
    return Polyhedron(tuple(_plane_through(part, middle) for part in _lofted(points, behind)), np.zeros(3))
