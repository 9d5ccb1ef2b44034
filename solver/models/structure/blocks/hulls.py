"""Convex blocks from points, and blocks from closed meshes: mass properties, faces of the hull, feet."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import compress, pairwise, product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....common.errors import InputError, needing
from ....kernels.structure.layout import MOST_CORNERS
from .contacts import axis_of
from .faces import NEAR, Face, FloatArray, outside_parts, polygon_moments, without_doubles
from .outlines import THINNEST, bent_corners, corners_around, is_convex
from .parts import Solid
from .shells import EXTRA

THIN = 1e-12  # of the cube of its extent: the least volume
FEW = 100  # corners of a hull that is kept as it is; larger ones become the hull of the farthest in DIRECTIONS
DIRECTIONS = 300
THINNEST_HULL = 1e-5  # of the cube of its extent: the least volume of a hull, whose faces must differ
COARSE = 1e-4  # of the extent: largest distance of corners of a noisy flat side from its plane
MERGED = 1e-5  # of the height of a triangle: corners nearer to its plane belong to its face
STRAIGHT = 1e-9  # of the area of a face: a corner that takes away less is dropped
BLUNT = 1e-4  # the same for a foot found among the points of a mesh
SLIVER = 1e-2  # of the area of a face: smaller uncovered parts of it are dropped
ZERO = 1e-14  # of the trace: smaller products of inertia are set to 0, so that symmetric blocks stay in their plane


class Bulk(NamedTuple):
    """The volume, centroid and inertia of a solid bounded by a closed surface."""

    volume: float  # m3
    centroid: FloatArray  # (3,) m
    inertia: FloatArray  # (3, 3) m5, about the centroid, of density 1


def bulk_of(triangles: FloatArray) -> Bulk:
    """Return the volume, centroid and inertia within a closed surface, by Green's theorem.

    Each triangle makes a tetrahedron with a point amid the triangles. The volumes and moments of these tetrahedra have
    closed forms and are added with their signs.

    triangles: (k, 3, 3) m, all anticlockwise from outside or all clockwise. Raises InputError if there is no volume.
    """
    middle = np.mean(triangles, axis=(0, 1))
    a, b, c = np.moveaxis(triangles - middle, 1, 0)
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volume = float(np.sum(parts))
    extent = float(np.max(np.ptp(triangles, axis=(0, 1)), initial=0.0))
    if not abs(volume) > THIN * extent**3:
        raise InputError("has no volume")
    total = a + b + c
    first = parts @ total / (4.0 * volume)
    products = sum(np.einsum("i,ij,ik->jk", parts, point, point) for point in (a, b, c, total)) / 20.0
    second = np.asarray(products) / volume - np.outer(first, first)
    inertia = abs(volume) * (np.trace(second) * np.eye(3) - second)
    inertia[np.abs(inertia) < ZERO * np.trace(inertia)] = 0.0
    return Bulk(abs(volume), middle + first, inertia)


class Hull(NamedTuple):
    """A convex polyhedron: corners (n, 3) m, and the indices of those of each face, anticlockwise from outside."""

    points: FloatArray
    faces: tuple[tuple[int, ...], ...]

    @property
    def triangles(self) -> FloatArray:
        """The triangles of the surface, (k, 3, 3) m."""
        fans = [(face[0], one, other) for face in self.faces for one, other in pairwise(face[1:])]
        found: FloatArray = self.points[np.array(fans)]
        return found


def _hull_around(points: FloatArray) -> Any:
    """Return the convex hull of points (n, 2) or (n, 3), near the origin, by scipy; None if it is flat."""
    with needing(EXTRA, "scipy"):
        from scipy.spatial import ConvexHull, QhullError
    with suppress(QhullError):
        return ConvexHull(points)
    return None


def convex_surface(points: FloatArray) -> FloatArray:
    """Return the triangles (k, 3, 3) m of the convex hull of points (n, 3) m, anticlockwise from outside.

    Raises InputError if the hull has no volume, or hardly any.
    """
    local = points - points[0]
    made = _hull_around(local)
    if made is None:
        raise InputError("has no volume, must be points that do not all lie in a plane")
    if not made.volume > THINNEST_HULL * float(np.max(np.ptp(points, axis=0))) ** 3:
        raise InputError("has hardly any volume, must be points that do not all lie in a plane")
    corners = local[made.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = np.einsum("ij,ij->i", normals, made.equations[:, :3]) < 0.0
    found: FloatArray = points[np.where(inwards[:, None], made.simplices[:, ::-1], made.simplices)]
    return found


def hull_of(surface: FloatArray) -> Hull:
    """Return the hull of a surface from `convex_surface`, with coplanar triangles merged into faces.

    If there are more than FEW corners, the hull of the farthest points in DIRECTIONS directions is taken. If the merged
    faces do not close, as with noisy flat sides, corners that protrude by less than a coarser tolerance are left out
    and faces are merged within it. If that does not close either, the faces are the triangles.
    """
    points = np.unique(surface.reshape(-1, 3), axis=0)
    if len(points) > FEW:
        points = _farthest(points)
        surface = convex_surface(points)
    extent = float(np.max(np.ptp(points, axis=0)))
    hull = _merged(points, surface, NEAR * extent, MERGED)
    if _closes(hull):
        return hull
    fewer = _outermost(points, COARSE * extent)
    with suppress(InputError):  # without volume at this tolerance
        hull = _merged(fewer, convex_surface(fewer), COARSE * extent, math.inf)
        if _closes(hull):
            return hull
    return _merged(points, surface, NEAR * extent, 0.0)


def _closes(hull: Hull) -> bool:
    """Return True if the faces are those of a convex polyhedron."""
    try:
        checked(hull.points, hull.faces)
    except InputError:
        return False
    return True


def _outermost(points: FloatArray, within: float) -> FloatArray:
    """Return a subset of the points (n, 3) whose hull contains all points to within `within`, m.

    It starts with the farthest points along axes and diagonals and adds the point farthest outside until none is.
    """
    local = points - points[0]
    ways = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    chosen = np.unique(np.argmax(local @ ways.T, axis=0)).tolist()
    while (hull := _hull_around(local[chosen])) is not None:
        # distance of each point from the hull of the chosen ones
        outside = np.max(local @ hull.equations[:, :3].T + hull.equations[:, 3], axis=1)
        farthest = int(np.argmax(outside))
        if outside[farthest] <= within or farthest in chosen:
            return points[np.sort(chosen)]
        chosen.append(farthest)
    return points


def _merged(points: FloatArray, surface: FloatArray, most: float, share: float) -> Hull:
    """Return the hull whose faces are the triangles of a surface, merged where they are coplanar.

    Planes are taken from the largest triangles first. All corners near a plane belong to its face, and triangles
    between them are removed. Near means closer than `most`, m, and than `share` times the height of the triangle; share
    0 merges none.
    """
    local = points - points[0]
    extent = float(np.max(np.ptp(points, axis=0)))
    # triangles by the indices of their corners; their normals and heights
    number = {tuple(point): k for k, point in enumerate(points.tolist())}
    triangles = np.array([[number[tuple(point)] for point in triangle] for triangle in surface.tolist()])
    sides = np.roll(local[triangles], -1, axis=1) - local[triangles]
    normals = np.cross(sides[:, 0], sides[:, 1])
    size = np.linalg.norm(normals, axis=1)
    height = size / np.max(np.linalg.norm(sides, axis=2), axis=1)
    left = height > NEAR * extent  # thinner ones are rounding
    faces = []
    for k in np.argsort(-size):
        if left[k]:
            normal = normals[k] / size[k]
            near = np.abs((local - local[triangles[k, 0]]) @ normal) < min(share * height[k], most)
            near[triangles[k]] = True
            left &= ~near[triangles].all(axis=1)
            corners = np.flatnonzero(near)
            flat = local[corners] @ _axes(normal)[:, :2]
            order = np.array(corners_around(flat))
            kept = order[thinned(flat[order], STRAIGHT)]
            faces.append(tuple(corners[kept].tolist()))
    # keep used corners only, and renumber them
    used = np.unique([corner for face in faces for corner in face])
    place = {int(corner): k for k, corner in enumerate(used)}
    return Hull(points[used], tuple(tuple(place[corner] for corner in face) for face in faces))


def _farthest(points: FloatArray) -> FloatArray:
    """Return the points that are farthest in DIRECTIONS directions and along the axes."""
    k = np.arange(DIRECTIONS) + 0.5
    upwards, angle = 1.0 - 2.0 * k / DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * k  # a spiral of equal areas
    level = np.sqrt(1.0 - upwards**2)
    ways = np.stack([level * np.cos(angle), level * np.sin(angle), upwards])
    ways = np.concatenate([ways, np.eye(3), -np.eye(3)], axis=1)
    found: FloatArray = points[np.unique(np.argmax((points - points[0]) @ ways, axis=0))]
    return found


def feet_of(points: FloatArray, level: float, count: int = 1) -> tuple[FloatArray, ...]:
    """Return the convex polygons (corners, 2) around the lowest of points (n, 3), m; empty if one has no area.

    Points within `level` (m) of the lowest belong to feet. Single linkage divides them into `count` groups: points that
    are nearer to each other than the groups are belong to one group.
    """
    low = np.unique(points[points[:, 2] <= np.min(points[:, 2]) + level, :2], axis=0)
    extent = float(np.max(np.ptp(points, axis=0)))
    found = [polygon for group in _apart(low, count) if len(polygon := _polygon_around(group, extent))]
    return tuple(found) if len(found) == count else ()


def _apart(points: FloatArray, count: int) -> list[FloatArray]:
    """Divide points (n, 2) into `count` groups by single linkage.

    The longest edges of their minimum spanning tree are removed; its edges are among those of the Delaunay triangles.
    """
    if count == 1 or len(points) < 3 * count:
        return [points]
    with needing(EXTRA, "scipy"):
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
        from scipy.spatial import Delaunay, QhullError
    try:
        triangles = Delaunay(points - points[0]).simplices
    except QhullError:
        return [points]
    one, other = triangles[:, [0, 1, 2]].ravel(), triangles[:, [1, 2, 0]].ravel()
    edges = np.unique(np.sort(np.column_stack([one, other]), axis=1), axis=0)
    length = np.hypot(*(points[edges[:, 0]] - points[edges[:, 1]]).T)
    size = len(points), len(points)
    # cut the count - 1 longest edges of the minimum spanning tree
    tree = minimum_spanning_tree(coo_array((length, edges.T), shape=size)).tocoo()
    kept = np.argsort(tree.data, kind="stable")[: len(tree.data) - (count - 1)]
    left = coo_array((tree.data[kept], (tree.row[kept], tree.col[kept])), shape=size)
    group = connected_components(left, directed=False)[1]
    return [points[group == k] for k in range(count)]


def _polygon_around(points: FloatArray, extent: float) -> FloatArray:
    """Return the convex hull of points (n, 2), thinned to few corners, (corners, 2); empty if it has no area."""
    if len(points) < 3:
        return np.empty((0, 2))
    hull = _hull_around(points - points[0])
    if hull is None:
        return np.empty((0, 2))
    found = points[hull.vertices]
    if polygon_moments(found - found[0])[0] <= THINNEST * extent**2:
        return np.empty((0, 2))
    return found[thinned(found, BLUNT, MOST_CORNERS)]


def middle_of(feet: Sequence[Face]) -> FloatArray:
    """Return the centroid of the area of faces, (3,) m."""
    if len(feet) == 1:
        return feet[0].centre
    areas = np.array([face.moments[0] for face in feet])
    found: FloatArray = areas @ np.array([face.centre for face in feet]) / np.sum(areas)
    return found


def thinned(outline: FloatArray, least: float, most: int = 10**9) -> NDArray[np.intp]:
    """Return the indices of the corners of a convex polygon that are kept.

    The corner that takes away the least area is removed first, while that area is below `least` times the whole or more
    than `most` corners are left.
    """
    kept = np.arange(len(outline))
    whole = polygon_moments(outline - outline[0])[0]
    while len(kept) > 2:
        now = outline[kept]
        before, after = np.roll(now, 1, axis=0) - now, np.roll(now, -1, axis=0) - now
        ears = 0.5 * (after[:, 0] * before[:, 1] - after[:, 1] * before[:, 0])
        k = int(np.argmin(ears))
        if ears[k] > least * whole and len(kept) <= most:
            break
        kept = np.delete(kept, k)
    return kept


def block_of_hulls(
    name: str,
    hulls: Sequence[Hull],
    bulk: Bulk,
    density: float,
    feet: Sequence[FloatArray],
    level: float,
    surface: FloatArray,
) -> Solid:
    """Return a block that touches others by the faces of a hull, or of the hulls of its parts.

    The faces of a part count where no other part covers them. The feet, polygons (corners, 2) m, replace the faces
    within `level` (m) of the lowest point; empty keeps these. They come first, then the faces from the most upward one
    down. The density is in kg/m3; `surface` has triangles (k, 3, 3) m to draw it by, empty: its faces.
    """
    bottom = float(np.min([np.min(hull.points[:, 2]) for hull in hulls]))
    # faces, without those that the feet replace
    parts = [tuple(_face(hull.points[list(face)]) for face in hull.faces) for hull in hulls]
    stays = [[not feet or np.max(hull.points[list(face), 2]) > bottom + level for face in hull.faces] for hull in hulls]
    upper = [list(compress(part, stay)) for part, stay in zip(parts, stays, strict=True)]
    faces = upper[0] if len(hulls) == 1 else _outer(upper, parts)
    faces.sort(key=lambda face: -float(face.normal[2]))
    faces = [_face(np.column_stack([foot[::-1], np.full(len(foot), bottom)])) for foot in feet] + faces
    inertia = density * bulk.inertia
    made = Solid(name, density * bulk.volume, bulk.centroid, inertia, tuple(faces), np.eye(3), bulk.volume, surface)
    if len(hulls) > 1:
        return replace(made, parts=tuple(parts))
    # neighbours meet the whole underside, also where no foot stands
    underside = sum(face.moments[0] for face, stay in zip(parts[0], stays[0], strict=True) if not stay)
    covered = sum(polygon_moments(foot)[0] for foot in feet)
    return replace(made, hull=parts[0]) if covered < (1.0 - SLIVER) * underside else made


def _outer(upper: Sequence[Sequence[Face]], parts: Sequence[Sequence[Face]]) -> list[Face]:
    """Return the parts of the faces of each hull that no other hull covers."""
    extent = float(np.max(np.ptp([corner for part in parts for face in part for corner in face.points()], axis=0)))
    bounds = [
        (np.array([face.normal for face in part]), np.array([face.normal @ face.centre for face in part]))
        for part in parts
    ]
    found: list[Face] = []
    for k, own in enumerate(upper):
        for face in own:
            place, left = face.centre + NEAR * extent * face.normal, [face.outline]
            # cut away what lies inside of each other part
            for normals, off in bounds[:k] + bounds[k + 1 :]:
                outside = np.column_stack([normals @ place - off, normals @ face.axes[:, :2]])
                left = [part for outline in left for part in outside_parts(outline, outside)]
            found += [face] if left and left[0] is face.outline else _pieces(face, left)
    return found


def _pieces(face: Face, outlines: Sequence[FloatArray]) -> Iterator[Face]:
    """Yield the parts of a face with these outlines, without slivers."""
    for outline in outlines:
        area, first, _ = polygon_moments(outline)
        if area > SLIVER * face.moments[0]:
            middle = first / area
            yield Face(face.centre + face.axes[:, :2] @ middle, face.axes, without_doubles(outline - middle))


def _face(corners: FloatArray) -> Face:
    """Return the face with corners (k, 3) m in a plane, anticlockwise from outside, its centre at the centroid."""
    sides = corners - corners[0]
    axes = _axes(np.sum(np.cross(sides[1:-1], sides[2:]), axis=0))
    outline = sides @ axes[:, :2]
    area, first, _ = polygon_moments(outline)
    return Face(corners[0] + axes[:, :2] @ first / area, axes, outline - first / area)


def _axes(normal: FloatArray) -> FloatArray:
    unit = normal / np.linalg.norm(normal)
    unit[np.abs(unit) < 1e-15] = 0.0
    along = axis_of(unit)
    return np.column_stack([along, np.cross(unit, along), unit])


def checked(points: FloatArray, faces: Sequence[Sequence[int]]) -> Hull:
    """Return the hull with these faces, without corners on a straight line of faces that are not convex.

    Raises InputError if the faces are not those of a convex polyhedron.
    """
    extent = float(np.max(np.ptp(points, axis=0)))
    closing, kept = np.zeros(3), []
    for k, numbers in enumerate(faces):
        corners = points[list(numbers)]
        sides = corners - corners[0]
        # plane, with all points behind it
        area = np.sum(np.cross(sides[1:-1], sides[2:]), axis=0)
        closing += area
        size = float(np.linalg.norm(area))
        if not size > 0.0 or np.max((points - corners[0]) @ area) > 10.0 * MERGED * extent * size:
            raise InputError(f"faces[{k}]: must be plane, anticlockwise from outside, with all points behind it")
        flat = sides @ _axes(area)[:, :2]
        # convex, once straight corners are dropped
        bent = np.arange(len(numbers)) if is_convex(flat) else bent_corners(flat)
        if not is_convex(flat[bent]):
            raise InputError(f"faces[{k}]: must be a convex polygon, its corners one after the other")
        kept.append(tuple(numbers[corner] for corner in bent))
    if np.linalg.norm(closing) > 10.0 * MERGED * extent**2:
        raise InputError("faces: do not close, must be all those of the hull of the points")
    return Hull(points, tuple(kept))
