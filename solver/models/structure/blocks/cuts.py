"""Decomposition of a non-convex mesh by planes into parts whose convex hulls have little more volume than the mesh."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....common.errors import InputError, needing
from .faces import NEAR, FloatArray
from .hulls import THINNEST_HULL
from .shells import EXTRA

FINE = 1e-4  # of the volume of the mesh: a part whose hull exceeds it by less is not cut again
BENT = 12  # planes of triangles at reentrant edges that are tried for a cut
LEVELS = 6  # planes across each axis that are tried
ALIKE = 1e-3  # difference of normals, and of distances over the extent, below which planes are merged
OUT = 1e-9  # of the extent: offset of planes above their triangles, so that no cut leaves a skin of these
SURE = 1e-9  # of the volume: the least improvement of a better cut, so that rounding does not choose


def convex_parts(triangles: FloatArray, most: int) -> list[FloatArray]:
    """Return the corners (n, 3) of the convex hulls of at most `most` parts of a closed surface (k, 3, 3), m.

    The part whose hull exceeds it most in volume is cut first, by the plane that leaves the least volume of hulls.
    Where no single cut reduces it, the first of two cuts that do is made. Raises InputError if the surface bounds no
    solid, or more separate solids than `most`.
    """
    with needing(EXTRA, "manifold3d"):
        from manifold3d import Error, Manifold, Mesh64
    middle = np.mean(triangles, axis=(0, 1))
    corners, number = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    mesh = Mesh64(corners - middle, number.reshape(-1, 3).astype(np.uint64))
    whole = Manifold(mesh)
    if whole.status() != Error.NoError:
        raise InputError(f"cannot be split: {whole.status().name}, must be a mesh whose surface bounds a solid")
    left = [(solid, solid.hull().volume()) for solid in whole.decompose() if solid.volume() > 0.0]  # voids have no part
    if len(left) > most:
        raise InputError(f"is {len(left)} solids that do not touch, must be as many parts at least")
    volume = sum(solid.volume() for solid, _ in left)
    found: list[tuple[Any, float]] = []
    while left:
        beside = [around - solid.volume() for solid, around in left]
        part = left.pop(int(np.argmax(beside)))
        further = most - len(left) - len(found)
        pieces = _cut(part[0], further, SURE * volume) if further > 1 and max(beside) > FINE * volume else []
        if not pieces and further > 2 and max(beside) > FINE * volume:
            pieces = _halves(part[0], further, FINE * volume)
        left += pieces
        found += [] if pieces else [part]
    return [middle + _corners(solid.hull()) for solid, _ in found]


def _cut(solid: Any, most: int, sure: float) -> list[tuple[Any, float]]:
    """Return the pieces of the best cut of a solid, without skins, and the volumes of their hulls (m3).

    The best cut leaves the least volume of hulls, in at most `most` pieces. The list is empty if no cut reduces the
    volume by more than `sure`, m3.
    """
    best, least = [], solid.hull().volume() - sure
    for plane in np.concatenate([_bent(solid), _levels(solid)]):
        pieces = _pieces(solid, plane)
        if len(pieces) <= most:
            around = [piece.hull().volume() for piece in pieces]
            if sum(around) < least:
                best, least = list(zip(pieces, around, strict=True)), sum(around) - sure
    return best


def _halves(solid: Any, most: int, sure: float) -> list[tuple[Any, float]]:
    """Return the pieces of the cut near the middle that leaves the least volume of hulls after one more cut; as `_cut`.

    A single cut of a ring does not help: each half contains half of the hollow. Empty if two cuts do not help either.
    """
    best, least = [], solid.hull().volume() - sure
    for plane in _levels(solid)[3 * (LEVELS // 2 - 1) : 3 * (LEVELS // 2 + 1)]:
        pieces = _pieces(solid, plane)
        around = [piece.hull().volume() for piece in pieces]
        for k, piece in enumerate(pieces if 1 < len(pieces) < most else []):
            further = _cut(piece, most - len(pieces) + 1, sure)
            total = sum(around) - around[k] + sum(hull for _, hull in further)
            if further and total < least:
                best, least = list(zip(pieces, around, strict=True)), total
    return best


def _pieces(solid: Any, plane: FloatArray) -> list[Any]:
    """Return the pieces of a solid on both sides of a plane, without skins."""
    halves = solid.split_by_plane(plane[:3], plane[3])
    pieces = [piece for half in halves for piece in half.decompose()]
    return [piece for piece in pieces if piece.volume() > THINNEST_HULL * _extent(piece) ** 3]


def _bent(solid: Any) -> FloatArray:
    """Return the planes of the triangles at reentrant edges, the most bent first, (planes, 4): normal, distance (m)."""
    mesh = solid.to_mesh64()
    corners, faces = _corners(solid), np.asarray(mesh.tri_verts).astype(np.int64)
    places = corners[faces]
    normals = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    # reentrant edges, weighted by their length times the sine of their angle
    ends = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    order = np.lexsort((ends.min(axis=1), ends.max(axis=1))).reshape(-1, 2)  # both triangles of an edge
    one, other = (order % len(faces)).T
    edge = corners[ends[order[:, 0], 1]] - corners[ends[order[:, 0], 0]]
    bend = -np.sum(np.cross(normals[one], normals[other]) * edge, axis=1)  # length times the sine of the angle
    inwards = bend > ALIKE**2 * _extent(solid)
    # planes of their triangles; coinciding planes are merged and their weights added
    triangle, weight = np.concatenate([one[inwards], other[inwards]]), np.tile(bend[inwards], 2)
    planes = np.column_stack([normals[triangle], np.sum(normals[triangle] * places[triangle, 0], axis=1)])
    steepest = np.argmax(np.abs(planes[:, :3]), axis=1)
    upwards = planes * np.sign(planes[np.arange(len(planes)), steepest])[:, None]
    rounded = np.round(upwards / (ALIKE * np.array([1.0, 1.0, 1.0, _extent(solid)])))
    _, first, group = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    heaviest = np.argsort(-np.bincount(group.ravel(), weight, len(first)), kind="stable")[:BENT]
    found: FloatArray = planes[first[heaviest]]
    # shift each plane just above all corners in it
    above = corners @ found[:, :3].T - found[:, 3]
    above[np.abs(above) > NEAR * _extent(solid)] = 0.0  # only corners in the plane but for rounding
    found[:, 3] += np.max(above, axis=0, initial=0.0) + OUT * _extent(solid)
    return found


def _levels(solid: Any) -> FloatArray:
    """Return LEVELS equally spaced planes across each axis, (3 LEVELS, 4): normal, distance (m)."""
    box = np.reshape(solid.bounding_box(), (2, 3))
    places = np.linspace(box[0], box[1], LEVELS + 2)[1:-1]
    return np.column_stack([np.tile(np.eye(3), (LEVELS, 1)), places.ravel()])


def _corners(solid: Any) -> FloatArray:
    return np.array(solid.to_mesh64().vert_properties[:, :3], dtype=np.float64)


def _extent(solid: Any) -> float:
    return float(np.max(np.ptp(np.reshape(solid.bounding_box(), (2, 3)), axis=0)))
