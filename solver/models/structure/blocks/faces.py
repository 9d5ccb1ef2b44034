"""Plane faces of blocks, and the intersection of two of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....common.errors import InputError

FloatArray = NDArray[np.float64]

NEAR = 1e-6  # of the size of a face: planes and edges closer than this are the same
SLIVER = 1e-9  # of the area of a face
SIDES = 60  # of the polygon of equal area that replaces a round face where another face cuts it


@dataclass(frozen=True, eq=False)
class Face:
    """A plane face: a polygon, or a disc or ring about its centre."""

    centre: FloatArray  # (3,) m
    axes: FloatArray  # (3, 3), columns e1, e2 and the normal away from the block
    outline: FloatArray  # (corners, 2) m along e1, e2 from the centre, anticlockwise against the normal; empty: round
    radius: float = 0.0  # m, of a round face
    bore: float = 0.0  # m, radius of the hole

    @property
    def normal(self) -> FloatArray:
        """The unit normal away from the block, (3,)."""
        return self.axes[:, 2]

    @cached_property
    def size(self) -> float:
        """The largest distance of a point from the centre (m)."""
        return self.radius or float(np.max(np.hypot(*self.outline.T)))

    @property
    def width(self) -> float:
        """The least distance between two parallel lines that enclose the face (m)."""
        if self.radius:
            return 2.0 * self.radius
        return float(np.min(np.ptp(outward_normals(self.outline) @ self.outline.T, axis=1)))

    @cached_property
    def moments(self) -> tuple[float, float, float, float]:
        """The area (m2), and the integrals of x^2, y^2 and x y (m4) about the centre, which is the centroid."""
        if self.radius:
            second = 0.25 * math.pi * (self.radius**4 - self.bore**4)
            return math.pi * (self.radius**2 - self.bore**2), second, second, 0.0
        area, _, about = polygon_moments(self.outline)
        return area, float(about[0, 0]), float(about[1, 1]), float(about[0, 1])

    @cached_property
    def arm(self) -> float:
        """The mean distance of the points from the centre (m): the arm of friction against twisting."""
        if self.radius:
            return 2.0 / 3.0 * (self.radius**3 - self.bore**3) / (self.radius**2 - self.bore**2)
        corners = zip(self.outline, np.roll(self.outline, -1, axis=0), strict=True)
        return sum(_first_polar(a, b) for a, b in corners) / self.moments[0]

    def points(self, sides: int = 24) -> FloatArray:
        """Return the points of the rim in space, (points, 3) m; a round rim has `sides` points."""
        return self.centre + self._rim(sides) @ self.axes[:, :2].T

    def _rim(self, sides: int) -> FloatArray:
        if not self.radius:
            return self.outline
        angle = 2.0 * math.pi * np.arange(sides) / sides
        return self.radius * np.column_stack([np.cos(angle), np.sin(angle)])

    def seen_from(self, other: Face) -> FloatArray:
        """Project the rim to the axes of another face, (corners, 2) m, anticlockwise there.

        A round face becomes a polygon of equal area.
        """
        rim = self._rim(SIDES)
        if self.radius:
            rim = rim * math.sqrt(2.0 * math.pi / (SIDES * math.sin(2.0 * math.pi / SIDES)))
        flat = (self.centre + rim @ self.axes[:, :2].T - other.centre) @ other.axes[:, :2]
        a, b = (flat[1:-1] - flat[0]).T, (flat[2:] - flat[0]).T
        return flat if float(np.sum(a[0] * b[1] - a[1] * b[0])) > 0.0 else flat[::-1].copy()


def _first_polar(a: FloatArray, b: FloatArray) -> float:
    """Integrate the distance from the origin over the triangle of the origin, a and b (m3).

    With the distance d of the side a b from the origin, it is d^3 / 3 times the integral of 1 / cos^3 over the angle,
    negative if a, b and the origin are clockwise.
    """
    side = b - a
    length = float(np.hypot(*side))
    d = float(a[0] * b[1] - a[1] * b[0]) / length if length else 0.0
    if d == 0.0:
        return 0.0
    tangents = float(a @ side) / (length * abs(d)), float(b @ side) / (length * abs(d))
    first, last = (0.5 * (t * math.hypot(1.0, t) + math.asinh(t)) for t in tangents)
    return d**3 / 3.0 * (last - first)


def polygon_moments(corners: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Return area (m2), first moments (2,) (m3) and second moments (2, 2) (m4) of a polygon, by Green's formulas."""
    a, b = corners, np.roll(corners, -1, axis=0)
    doubled = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area = 0.5 * float(np.sum(doubled))
    first: FloatArray = (doubled @ (a + b)) / 6.0
    total = a + b
    second: FloatArray = (np.einsum("k,ki,kj->ij", doubled, a, a) + np.einsum("k,ki,kj->ij", doubled, b, b)) / 24.0
    second = second + np.einsum("k,ki,kj->ij", doubled, total, total) / 24.0
    return area, first, second


def edge_distance(outline: FloatArray) -> float:
    """Return the distance of the nearest edge of a convex polygon from the origin (m); negative if it lies outside."""
    sides = np.roll(outline, -1, axis=0) - outline
    return float(np.min((outline[:, 0] * sides[:, 1] - outline[:, 1] * sides[:, 0]) / np.hypot(*sides.T)))


def outward_normals(outline: FloatArray) -> FloatArray:
    """Return the unit normals of the sides of an anticlockwise polygon, (corners, 2), each from its corner on."""
    side = np.roll(outline, -1, axis=0) - outline
    found: FloatArray = np.column_stack([side[:, 1], -side[:, 0]]) / np.hypot(*side.T)[:, None]
    return found


def clipped(corners: FloatArray, by: FloatArray) -> FloatArray:
    """Clip a convex polygon to another one, both anticlockwise; empty if they do not overlap."""
    left = corners.tolist()
    for (x0, y0), (x1, y1) in zip(by.tolist(), np.roll(by, -1, axis=0).tolist(), strict=True):
        left = half_of(left, [(x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) for x, y in left])
    return np.array(left) if len(left) > 2 else np.empty((0, 2))


def half_of(corners: Sequence[Sequence[float]], depth: Sequence[float]) -> list[Sequence[float]]:
    """Clip a convex polygon to the half-plane in which a linear function is positive.

    depth: values of the function at the corners.
    """
    kept: list[Sequence[float]] = []
    for k, (point, d) in enumerate(zip(corners, depth, strict=True)):
        before, b = corners[k - 1], depth[k - 1]
        if (b > 0.0) != (d > 0.0):
            part = b / (b - d)
            kept.append([p + part * (q - p) for p, q in zip(before, point, strict=True)])
        if d > 0.0:
            kept.append(point)
    return kept


def inset(face: Face, rim: float) -> Face | None:
    """Return the part of a face farther than `rim` (m) from its edges, about the same centre; None if it is empty.

    A part of at most `SLIVER` of the area is what rounding leaves of a rim half as wide as the face.
    """
    if face.radius:
        radius, bore = face.radius - rim, face.bore + rim if face.bore else 0.0
        if radius <= bore:
            return None
        found = replace(face, radius=radius, bore=bore)
    else:
        left = face.outline.tolist()
        for (x0, y0), (x1, y1) in zip(face.outline.tolist(), np.roll(face.outline, -1, axis=0).tolist(), strict=True):
            length = math.hypot(x1 - x0, y1 - y0)
            left = half_of(left, [((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / length - rim for x, y in left])
        outline = without_doubles(np.array(left)) if len(left) > 2 else np.empty((0, 2))
        if len(outline) < 3:
            return None
        found = replace(face, outline=outline)
    return found if found.moments[0] > SLIVER * face.moments[0] else None


def outside_parts(corners: FloatArray, outside: FloatArray) -> list[FloatArray]:
    """Return the parts of a convex polygon where any of some linear functions is positive, as convex polygons.

    outside: (functions, 3), the value of each at the origin and its slopes along x and y.
    """
    values = outside[:, :1] + outside[:, 1:] @ corners.T
    if np.any(np.all(values >= 0.0, axis=1)):
        return [corners]
    found, left = [], corners.tolist()
    for at, along_x, along_y in outside[np.any(values > 0.0, axis=1)].tolist():
        value = [at + along_x * x + along_y * y for x, y in left]
        found.append(half_of(left, value))
        left = half_of(left, [-part for part in value])
        if len(left) < 3:
            return [corners]
    return [np.array(part) for part in found if len(part) > 2]


def shared(upper: Face, lower: Face, key: str) -> Face | None:
    """Return the intersection of two faces, with the axes of the lower one; None if they do not touch.

    Faces touch if their planes coincide and their normals are opposite. The centre is the centroid of the intersection.
    Raises InputError, which begins with `key`, if a bore bounds it and something else than a circle about its axis.
    """
    # planes must coincide
    size = min(upper.size, lower.size)
    between = upper.centre - lower.centre
    if float(upper.normal @ lower.normal) > -1.0 + NEAR or abs(float(between @ lower.normal)) > NEAR * size:
        return None
    off = float(np.linalg.norm(between - (between @ lower.normal) * lower.normal))
    # concentric round faces
    if upper.radius and lower.radius and off <= NEAR * size:
        outer, inner = min(upper.radius, lower.radius), max(upper.bore, lower.bore)
        return replace(lower, radius=outer, bore=inner) if outer > inner else None
    # a round face within the other face
    for inside, outside in ((upper, lower), (lower, upper)):
        if inside.radius and _holds(outside, inside):
            centre = inside.centre - ((inside.centre - lower.centre) @ lower.normal) * lower.normal
            return Face(centre, lower.axes, np.empty((0, 2)), inside.radius, inside.bore)
    # polygons
    outline = clipped(upper.seen_from(lower), lower.seen_from(lower))
    if not len(outline):
        return None
    area, first, _ = polygon_moments(outline)
    if area <= NEAR * size * size:
        return None
    if upper.bore or lower.bore:
        if _within_bore(upper, lower) or _within_bore(lower, upper):
            return None
        raise InputError(f"{key}: a hollow face must share its axis with a round one, or lie wholly on the other")
    middle = first / area
    return Face(lower.centre + lower.axes[:, :2] @ middle, lower.axes, without_doubles(outline - middle))


def _holds(outside: Face, inside: Face) -> bool:
    """Return True if a round face lies within another face."""
    centre = (inside.centre - outside.centre) @ outside.axes[:, :2]
    if outside.radius:
        return not outside.bore and float(np.hypot(*centre)) + inside.radius <= outside.radius * (1.0 + NEAR)
    return edge_distance(outside.outline - centre) >= inside.radius * (1.0 - NEAR)


def _within_bore(inside: Face, ring: Face) -> bool:
    """Return True if a face lies within the bore of a ring."""
    return float(np.max(np.hypot(*inside.seen_from(ring).T))) <= ring.bore


def without_doubles(outline: FloatArray) -> FloatArray:
    """Remove corners of a polygon that coincide with the one before."""
    apart = np.hypot(*(outline - np.roll(outline, 1, axis=0)).T) > NEAR * float(np.max(np.abs(outline)))
    return outline[apart]
