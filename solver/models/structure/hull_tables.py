"""Tables of blocks from points or meshes; a mesh becomes points with its volume, centroid and inertia."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import InputError, InputWarning, check_number, check_whole, shown
from ...common.ranges import check_choice, check_keys
from ...common.tables import vector_of
from ...kernels.structure.layout import MOST_CORNERS
from .blocks.cuts import convex_parts
from .blocks.faces import NEAR, FloatArray, polygon_moments
from .blocks.hulls import Bulk, Hull, block_of_hulls, bulk_of, checked, convex_surface, feet_of, hull_of, middle_of
from .blocks.meshes import UP, triangles_of
from .blocks.outlines import outline_of
from .blocks.parts import Solid
from .blocks.shapes import placed

OF_HULL = ("points", "foot", "feet", "level", "scale", "faces", "parts", "volume", "centroid", "inertia")
OF_MESH = ("file", "unit", "up", "foot", "feet", "level", "scale", "parts", "repair")
FIXED = frozenset(OF_HULL + OF_MESH) - {"scale"}  # no study varies them
OF_FILE = ("file", "unit", "up", "feet", "parts", "repair")  # keys of a mesh that its hull does not have
MOST_POINTS = 100_000
MOST_FEET = 64
MOST_PARTS = 64
LEVEL = 1e-3  # of the height of a mesh: points this close to the lowest one bear
WHOLE = 1e-2  # of its volume: a mesh whose hull exceeds it by less is convex
HOLLOW = 0.8  # of the area of a foot: a mesh with less area there is hollow or rough below
FACTOR = (1e-6, 1e6), "a positive factor, from 1e-6 to 1e6"
POINTS = f"a list of 4 to {MOST_POINTS} points [x, y, z] in m"
FOOT = "a list of corners [x, y] in m of a convex polygon, or a list of such polygons"
_LEVEL = (0.0, 0.5), "a share of the height, from 0 to 0.5"
_SIZE = (1e-18, 1e18), "a positive volume in m3"
_MOMENT = (-1e30, 1e30), "a moment in m5, of density 1"
_SIX = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]  # xx, yy, zz, xy, xz, yz


def in_folder(data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return the mapping of a file with the folder of the file prepended to the paths of its meshes."""

    def placed_in(table: Any) -> Any:
        file = table.get("file") if _shape(table) == "mesh" else None
        return {**table, "file": str(folder / file)} if isinstance(file, str) and file else table

    return _with_tables(data, placed_in)


def with_hulls(data: Mapping[str, Any]) -> tuple[Mapping[str, Any], dict[int, FloatArray]]:
    """Replace meshes by numbers, and add the faces of hulls, so that the mapping needs neither files nor scipy.

    Return it, and the triangles of meshes (k, 3, 3), m, by the number of their table from 1. Raises InputError.
    """
    surfaces, number = {}, 0

    def resolved(table: Any) -> Any:
        nonlocal number
        number += 1
        if _shape(table) == "hull" and "faces" not in table:
            return _hull_table(f"block[{number}]", table)
        if _shape(table) == "mesh":
            table, surfaces[number] = _mesh_table(f"block[{number}]", table)
        return table

    return _with_tables(data, resolved), surfaces


def solid_from_hull(
    key: str, name: str, table: Mapping[str, Any], density: float, surface: FloatArray | None, stands: bool
) -> Solid:
    """Return the block of a table of points, as `with_hulls` writes it, with a density in kg/m3.

    `key` names the table in messages; `surface` has triangles (k, 3, 3) m to draw it by. If it `stands`, the block is
    shifted so that the centroid of its feet is the origin. Raises InputError if a value is wrong, or if it should stand
    and has no foot.
    """
    points = _points(key, table)
    hulls = _hulls(key, table, points)
    bulk = _bulk(key, table) or _within(f"{key}.points", bulk_of, np.concatenate([hull.triangles for hull in hulls]))
    # scale all lengths, and the inertia of density 1 with their fifth power
    scale = _optional(f"{key}.scale", table, 1.0, FACTOR)
    level = float(np.ptp(points[:, 2])) * _optional(f"{key}.level", table, NEAR, _LEVEL)
    feet = _feet(key, table, points, level)
    made = block_of_hulls(
        name,
        [hull._replace(points=scale * hull.points) for hull in hulls],
        Bulk(bulk.volume * scale**3, bulk.centroid * scale, bulk.inertia * scale**5),
        density,
        [scale * foot for foot in feet],
        scale * level,
        np.empty((0, 3, 3)) if surface is None else scale * surface,
    )
    if not stands:
        return made
    if not feet:
        raise InputError(f"{key}.foot: stands on a point or an edge, must be given as {FOOT}, or the block a position")
    return placed(made, -middle_of(made.faces[: len(feet)]), np.eye(3))


def _hull_table(key: str, table: Mapping[str, Any]) -> Mapping[str, Any]:
    points = _points(key, table)
    surface = _within(f"{key}.points", convex_surface, points)
    bulk = _bulk(key, table) or bulk_of(surface)
    share = _optional(f"{key}.level", table, NEAR, _LEVEL)
    feet = _feet(key, table, points, share * float(np.ptp(points[:, 2])))
    rest = {word: value for word, value in table.items() if word != "feet"}
    return {**rest, **_known([hull_of(surface)], bulk, feet, share)}


def _mesh_table(key: str, table: Mapping[str, Any]) -> tuple[Mapping[str, Any], FloatArray]:
    file = table.get("file")
    if not isinstance(file, str) or not file:
        raise InputError(f"{key}.file = {shown(file)}: must be the name of a mesh, from the folder of the TOML file")
    if "up" in table:
        check_choice(f"{key}.up", table["up"], UP)
    check_keys(f"{key}.", table.keys() & (set(OF_HULL) - set(OF_MESH)), OF_MESH, " of a mesh")
    unit, scale = (_optional(f"{key}.{word}", table, 1.0, FACTOR) for word in ("unit", "scale"))
    share = _optional(f"{key}.level", table, LEVEL, _LEVEL)
    repair = table.get("repair", False)
    if not isinstance(repair, bool):
        raise InputError(f"{key}.repair = {shown(repair)}: must be true or false")
    # surface, points and convex parts
    triangles = _within(f"{key}.file", triangles_of, Path(file), unit, table.get("up"), repair, scale)
    points = np.unique(triangles.reshape(-1, 3), axis=0)
    if "parts" in table:
        count = check_whole(f"{key}.parts", table["parts"], 1, MOST_PARTS, f"a whole number, 1 to {MOST_PARTS}")
        clouds = _within(f"{key}.parts = {count}: {file}", convex_parts, triangles, count)
    else:
        clouds = [points]
    hulls = [hull_of(_within(f"{key}.file: {file}", convex_surface, cloud)) for cloud in clouds]
    bulk = _within(f"{key}.file: {file}", bulk_of, triangles)
    around = bulk_of(hulls[0].triangles).volume / bulk.volume
    if table.get("parts", 1) > 1 and len(hulls) == 1 and around > 1.0 + WHOLE:
        warnings.warn(
            f"{key}.parts = {table['parts']}: {file}: no parts hold less than its hull, which others meet: "
            f"{around:.3g} times its volume",
            InputWarning,
            stacklevel=2,
        )
    # feet
    level = share * float(np.ptp(points[:, 2]))
    feet = _feet(key, table, points, level)
    if "foot" not in table:
        _warn_of_hollow_foot(f"{key}.foot", file, triangles, feet, level)
    rest = {word: value for word, value in table.items() if word not in OF_FILE}
    return {**rest, **_known(hulls, bulk, feet, share)}, triangles


def _warn_of_hollow_foot(key: str, file: str, triangles: FloatArray, feet: Sequence[FloatArray], level: float) -> None:
    """Warn if the convex outlines of the feet, (corners, 2) m, are far larger than the area of the mesh `file` there.

    That is so under a ring. The mesh has triangles (k, 3, 3), m, and touches up to `level` above its lowest point (m).
    """
    lowest = triangles[np.max(triangles[:, :, 2], axis=1) <= np.min(triangles[:, :, 2]) + level]
    a, b = lowest[:, 1, :2] - lowest[:, 0, :2], lowest[:, 2, :2] - lowest[:, 0, :2]
    touches = 0.5 * float(np.sum(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])))
    taken = sum(polygon_moments(foot)[0] for foot in feet)
    if 0.0 < touches < HOLLOW * taken:
        warnings.warn(
            f"{key}: {file}: is taken as the convex outline of {taken:.3g} m2, the mesh has {touches:.3g} m2 there; "
            f"give feet or foot, or the joint a rim, if that matters",
            InputWarning,
            stacklevel=3,
        )


def _known(hulls: Sequence[Hull], bulk: Bulk, feet: Sequence[FloatArray], level: float) -> dict[str, Any]:
    """Return the keys of a complete table of a hull, or of the hulls of parts."""
    polygons = [foot.tolist() for foot in feet]
    before = np.cumsum([0, *(len(hull.points) for hull in hulls)]).tolist()
    return {
        "shape": "hull",
        "points": np.concatenate([hull.points for hull in hulls]).tolist(),
        "faces": [[first + k for k in face] for first, hull in zip(before, hulls, strict=False) for face in hull.faces],
        **({"parts": [len(hull.faces) for hull in hulls]} if len(hulls) > 1 else {}),
        "foot": polygons if len(polygons) > 1 else [corner for polygon in polygons for corner in polygon],
        "level": level,
        "volume": bulk.volume,
        "centroid": bulk.centroid.tolist(),
        "inertia": bulk.inertia[_SIX].tolist(),
    }


def _hulls(key: str, table: Mapping[str, Any], points: FloatArray) -> list[Hull]:
    """Return the hull with the faces in the table, or those of its parts. Raises InputError."""
    faces = _numbers(f"{key}.faces", table.get("faces"), len(points))
    if "parts" not in table:
        return [_within(key, checked, points, faces)]
    counts = table["parts"]
    meaning = "how many of the faces each part has, at least 4, one part after the other"
    good = isinstance(counts, (list, tuple)) and all(type(count) is int and count >= 4 for count in counts)
    if not good or sum(counts) != len(faces):
        raise InputError(f"{key}.parts = {shown(counts)}: must be {meaning}: {len(faces)} in all")
    # the faces of each part follow each other; renumber its corners
    found, left = [], iter(faces)
    for count in counts:
        own = list(islice(left, count))
        used = sorted(set(chain(*own)))
        number = {corner: k for k, corner in enumerate(used)}
        found.append(_within(key, checked, points[used], [[number[corner] for corner in face] for face in own]))
    return found


def _feet(key: str, table: Mapping[str, Any], points: FloatArray, level: float) -> tuple[FloatArray, ...]:
    """Return the corners of each foot, (corners, 2) m, anticlockwise; empty if there is none."""
    if "foot" not in table:
        count = check_whole(f"{key}.feet", table.get("feet", 1), 1, MOST_FEET, f"a whole number, 1 to {MOST_FEET}")
        found = feet_of(points, level, count)
        if count > 1 and not found:
            raise InputError(
                f"{key}.feet = {count}: the points within level of the lowest are not as many polygons, "
                f"must be another number or level, or foot = {FOOT}"
            )
        return found
    if "feet" in table:
        raise InputError(f"{key}.feet: must be left out beside foot, which has their corners")
    # one polygon, or a list of them
    given = table["foot"]
    if isinstance(given, (list, tuple)) and not given:
        return ()
    several = isinstance(given, (list, tuple)) and all(_is_polygon(one) for one in given)
    if several and len(given) > MOST_FEET:
        raise InputError(f"{key}.foot: {len(given)} polygons, must be {MOST_FEET} at most")
    listed = {f"{key}.foot[{k}]": one for k, one in enumerate(given)} if several else {f"{key}.foot": given}
    return tuple(outline_of(at, list(_rows(at, one, 2, (3, MOST_CORNERS + 1), FOOT))) for at, one in listed.items())


def _is_polygon(value: object) -> bool:
    """Return True if a value is a list of lists, as a polygon is and a corner is not."""
    return isinstance(value, (list, tuple)) and bool(value) and isinstance(value[0], (list, tuple))


def _points(key: str, table: Mapping[str, Any]) -> FloatArray:
    return _rows(f"{key}.points", table.get("points"), 3, (4, MOST_POINTS), POINTS)


def _bulk(key: str, table: Mapping[str, Any]) -> Bulk | None:
    """Return volume, centroid and inertia from the table, or None if they are to be those of the hull.

    They are given for a block that differs from its hull or is not of uniform density.
    """
    known = [word for word in ("volume", "centroid", "inertia") if word in table]
    if not known:
        return None
    if len(known) < 3:
        raise InputError(f"{key}.{known[0]}: must be beside volume, centroid and inertia, all three of them, or none")
    volume = check_number(f"{key}.volume", table["volume"], *_SIZE)
    centroid = vector_of(f"{key}.centroid", table["centroid"], 3)
    inertia = np.zeros((3, 3))
    inertia[_SIX] = inertia[_SIX[1], _SIX[0]] = vector_of(f"{key}.inertia", table["inertia"], 6, _MOMENT)
    if not np.min(np.linalg.eigvalsh(inertia)) > 0.0:
        raise InputError(f"{key}.inertia: must be xx, yy, zz, xy, xz, yz of a body in m5, of density 1")
    return Bulk(volume, centroid, inertia)


def _shape(table: Any) -> Any:
    return table.get("shape") if isinstance(table, Mapping) else None


def _with_tables(data: Mapping[str, Any], changed: Callable[[Any], Any]) -> Mapping[str, Any]:
    """Apply a function to the tables of blocks if any is of a hull or mesh.

    Anything but a list of tables is returned as it is, for the reader to refuse.
    """
    tables = data.get("block")
    if not isinstance(tables, list) or not {"hull", "mesh"} & {str(_shape(table)) for table in tables}:
        return data
    return {**data, "block": [changed(table) for table in tables]}


def _within(key: str, function: Any, *arguments: Any) -> Any:
    """Call a function, prefixing the message of its InputError by the key."""
    try:
        return function(*arguments)
    except InputError as error:
        dot = "." if str(error).startswith("faces") else ": "
        raise InputError(f"{key}{dot}{error}") from None


def _optional(key: str, table: Mapping[str, Any], usual: float, limits: tuple[tuple[float, float], str]) -> float:
    word = key.rpartition(".")[2]
    return check_number(key, table[word], *limits) if word in table else usual


def _rows(key: str, value: object, width: int, counts: tuple[int, int], meaning: str) -> FloatArray:
    if not isinstance(value, (list, tuple, np.ndarray)):
        raise InputError(f"{key} = {shown(value)}: must be {meaning}")
    if not counts[0] <= len(value) <= counts[1]:
        raise InputError(f"{key}: {len(value)} points, must be {meaning}")
    return np.array([vector_of(f"{key}[{k}]", row, width) for k, row in enumerate(value)])


def _numbers(key: str, value: object, count: int) -> Sequence[Sequence[int]]:
    """Return the corners of faces by index, checked."""
    good = isinstance(value, (list, tuple)) and all(isinstance(face, (list, tuple)) for face in value)
    faces: Iterable[Any] = value if good else ()  # type: ignore[assignment]
    if good and all(type(k) is int and 0 <= k < count for k in chain(*faces)):
        found = [tuple(face) for face in faces]
        if all(len(set(face)) == len(face) >= 3 for face in found) and len(found) >= 4:
            return found
    raise InputError(
        f"{key}: must be lists of at least 3 numbers of points, from 0 to {count - 1}, a list for each face"
    )
