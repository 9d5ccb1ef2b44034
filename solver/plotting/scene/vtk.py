"""A response as files for ParaView: the blocks, and the compressed parts of their joints with the pressure."""

from __future__ import annotations

import base64
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...common.errors import POSITIVE, InputError, check_number
from ...common.files import whole_file
from ...models.outputs import BLOCK, JOINT
from ...models.structure.blocks.faces import Face, FloatArray, clipped, inset, outside_parts, without_doubles
from ...models.structure.blocks.shapes import turned
from .bodies import Rims, Scene, SceneContact, normal_of, scene_of
from .gltf import quaternions

POLYGON = 7  # VTK cell type
ROUNDING = 1e-12  # of the size of a polygon: a distance from its edges that does not count
LISTS = "blocks", "joints"  # .pvd
WALLS = "walls.vtu"
OWN = re.compile(r"walls\.vtu|(?:blocks|joints)_\d{5,}\.vtu")  # names of the files that a run writes
NAMES = {"float64": "Float64", "int64": "Int64", "uint8": "UInt8"}
PAGE = """<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt32">
<UnstructuredGrid><Piece NumberOfPoints="{points}" NumberOfCells="{cells}">
{parts}
</Piece></UnstructuredGrid></VTKFile>
"""
SERIES = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian"><Collection>
{lines}
</Collection></VTKFile>
"""


def write_vtk(response: Any, folder: str | os.PathLike[str], fps: float) -> None:
    """Write blocks.pvd and joints.pvd, with a file of each for every instant, and walls.vtu if there are walls.

    Files of these names that an older run left there are removed.
    Cells carry the number of their block or joint and its outputs; points of joints carry the elastic pressure, Pa.
    Raises InputError if `folder` is not a folder, or `fps` (instants per second, at most) is not positive; OSError.
    """
    fps = check_number("fps", fps, POSITIVE, "a positive number of rows a second")
    where = Path(folder)
    if not where.is_dir() and (where.suffix or where.exists()):
        raise InputError(f"{folder}: must be a folder, for one file at each instant")
    scene = scene_of(response, fps)
    where.mkdir(parents=True, exist_ok=True)
    # without the lists until all files are there: after an interrupt none leads to files of two runs
    for name in LISTS:
        (where / f"{name}.pvd").unlink(missing_ok=True)
    outputs = {owner: _histories(response, owner) for owner in (BLOCK, JOINT)}
    slips = outputs[JOINT].get("slip", np.zeros((len(response.time), len(scene.contacts))))
    for k, row in enumerate(scene.rows):
        _write_cells(where / f"blocks_{k:05d}.vtu", *_blocks(scene, k), BLOCK, outputs[BLOCK], row)
        loaded = _joints(scene, k, slips[row], outputs[JOINT]["contact"][row])
        _write_cells(where / f"joints_{k:05d}.vtu", *loaded, JOINT, outputs[JOINT], row)
    if scene.walls:
        walls = [wall.centroid + wall.surfaces[0].points for wall in scene.walls]
        _write_cells(where / WALLS, walls, range(len(walls)), {}, "wall", {}, 0)
    for name in LISTS:
        lines = (f'<DataSet timestep="{t:.9g}" file="{name}_{k:05d}.vtu"/>' for k, t in enumerate(scene.time))
        with whole_file(where / f"{name}.pvd") as partial:
            partial.write_text(SERIES.format(lines="\n".join(lines)), encoding="ascii")
    # files of an older, longer run, and its walls
    written = {f"{name}_{k:05d}.vtu" for name in LISTS for k in range(len(scene.rows))}
    for path in where.iterdir():
        if OWN.fullmatch(path.name) and path.name not in written and not (scene.walls and path.name == WALLS):
            path.unlink()


def _histories(response: Any, owner: str) -> dict[str, FloatArray]:
    """Return the outputs of blocks or joints by name, (rows, count) each."""
    seen = [output for output in response.outputs if output.owner == owner and not output.only_peak]
    return {output.key: getattr(response, output.field) for output in seen}


def _blocks(scene: Scene, k: int) -> tuple[list[FloatArray], list[int], dict[str, FloatArray]]:
    """Return the polygons of the surfaces at an instant, m, the indices of their blocks, and no point data."""
    found, owners = [], []
    for i, body in enumerate(scene.bodies):
        counts = [len(surface.points) for surface in body.surfaces]
        points = _placed(scene, k, i, body.centroid + np.concatenate([surface.points for surface in body.surfaces]))
        found += np.split(points, np.cumsum(counts)[:-1])
        owners += [i] * len(counts)
    return found, owners, {}


def _joints(
    scene: Scene, k: int, slips: FloatArray, touching: FloatArray
) -> tuple[list[FloatArray], list[int], dict[str, FloatArray]]:
    """Return the compressed parts of the joints as polygons, m, their joints, and the pressure at corners, Pa.

    slips: sizes of the slips of the joints, m; touching: the parts in contact, 0 of a joint that has ended in a fall.
    """
    found, owners, pressures = [], [], []
    for j, contact in enumerate(scene.contacts):
        if not touching[j] > 0.0:
            continue
        shift, centroid = _shift(scene, k, contact, float(abs(slips[j]))), scene.bodies[contact.body].centroid
        normal = _normal(scene, k, contact)
        upper, lower = _placed_parts(scene, k, contact, list(_shared(contact, shift, centroid)))
        for points, below in zip(upper, lower, strict=True):
            part, closed = _loaded(points, _depths(points - below, normal, contact))
            if len(part) > 2:
                found.append(part)
                owners.append(j)
                pressures.append(contact.stiffness * closed)
    return found, owners, {"pressure": np.concatenate(pressures) if pressures else np.empty(0)}


class _Shift(NamedTuple):
    """The place of the upper face of a joint over the lower one, along axes of the joint as built."""

    centre: FloatArray  # (3,) m, as built
    axes: FloatArray  # (3, 2)
    twist: FloatArray  # (2, 2)
    slip: FloatArray  # (2,) m

    def flat(self, points: FloatArray) -> FloatArray:
        """Return points as built along the axes, (points, 2) m."""
        return (points - self.centre) @ self.axes

    def upper(self, flat: FloatArray) -> FloatArray:
        """Return the points of the upper face as built that lie over points of the lower one."""
        return self.lower((flat - self.slip) @ self.twist)

    def lower(self, flat: FloatArray) -> FloatArray:
        """Return the points as built of points along the axes, (points, 3) m."""
        return self.centre + flat @ self.axes.T


def _shift(scene: Scene, k: int, contact: SceneContact, slip: float) -> _Shift:
    """Return the shift of a joint at an instant from its slip (m), whose direction is that between the bodies."""
    points, built = scene.bodies[contact.body].centroid + contact.points, normal_of(contact.points)
    centre, along = np.mean(points, axis=0), points[1] - points[0]
    along = along / np.linalg.norm(along)
    axes = np.column_stack([along, np.cross(built, along)])
    if not slip > 0.0 or contact.at_point:
        return _Shift(centre, axes, np.eye(2), np.zeros(2))
    # twist of the upper body relative to the lower one about the normal
    u, v = (quaternions(_turn(scene, k, body)) for body in (contact.body, contact.below))
    vector = v[3] * u[:3] - u[3] * v[:3] - np.cross(v[:3], u[:3])
    twist = 2.0 * math.atan2(float(vector @ built), float(u @ v))
    # slip of the centres along the axes half-way between both bodies, then along those of the lower one
    moved = _placed(scene, k, contact.body, centre[None]) - _placed(scene, k, contact.below, centre[None])
    between = 2.0 * axes + turned(_turn(scene, k, contact.body), axes.T).T
    between = between + turned(_turn(scene, k, contact.below), axes.T).T
    found = moved[0] @ (between / np.linalg.norm(between, axis=0))
    found = found * min(1.0, slip / max(float(np.hypot(*found)), 1e-300))  # the rest is elastic
    return _Shift(centre, axes, _rotation(twist), _rotation(0.5 * twist) @ found)


def _turn(scene: Scene, k: int, i: int) -> FloatArray:
    """Return the rotation vector of a body at an instant, rad; zero for the base."""
    return scene.turn[k, i] if i < len(scene.bodies) else np.zeros(3)


def _rotation(angle: float) -> FloatArray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def _shared(contact: SceneContact, shift: _Shift, centroid: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield convex polygons of the bearing area as built: on the upper face, and below them on the lower one, m."""
    slipped = bool(np.any(shift.slip))
    above = contact.above if slipped and contact.above is not None else Rims(contact.points, contact.hole)

    def shifted(ring: FloatArray) -> FloatArray:
        return _anticlockwise(shift.flat(centroid + ring) @ shift.twist.T + shift.slip)

    faces = [[shifted(ring) for ring in above]]
    if contact.under is not None:
        faces.append([_anticlockwise(shift.flat(centroid + ring)) for ring in contact.under])
    holes = [hole for _, hole in faces if len(hole)]
    # strips are convex pieces; a ring is cut into them between its rims
    (outer, inner), *unders = faces
    pieces = [np.array([outer[k - 1], outer[k], inner[k], inner[k - 1]]) for k in range(len(inner))] or [outer]
    pieces = [shifted(strip) for strip in contact.strips] or pieces
    parts = _without([_common([piece, *(rim for rim, _ in unders)]) for piece in pieces], [hole for _, hole in unders])
    # a rim leaves the common inside of both faces open, but for the rims of their holes
    if contact.rim:
        inside = _common([_inset(rim, contact.rim) for rim, _ in faces])
        within = [part for part in (_common([part, inside]) for part in parts) if len(part)]
        parts = _without(parts, [inside])
        for hole in (_outset(hole, contact.rim) for hole in holes):
            parts += [_common([part, hole]) for part in within]
            within = _without(within, [hole])
    for part in parts:
        if len(part):
            yield shift.upper(part), shift.lower(part)


def _anticlockwise(flat: FloatArray) -> FloatArray:
    x, y = (flat - flat[:1]).T
    return flat if float(np.sum(x[1:-1] * y[2:] - y[1:-1] * x[2:])) > 0.0 else flat[::-1]


def _common(polygons: Sequence[FloatArray]) -> FloatArray:
    """Return what convex polygons share, anticlockwise; empty if they do not overlap."""
    first, *others = polygons
    for other in others:
        if len(first) and len(other):
            outside = _outside(other, -ROUNDING)
            values = outside[:, :1] + outside[:, 1:] @ first.T
            if np.any(np.all(values >= 0.0, axis=1)):
                first = first[:0]
            elif np.any(values > 0.0):
                first = without_doubles(clipped(first, other))
        else:
            first = first[:0]
    return first if len(first) > 2 else first[:0]


def _outside(polygon: FloatArray, margin: float) -> FloatArray:
    """Return linear functions, one of which is positive outside a convex polygon, as of `outside_parts`.

    Points farther inside than `margin` of its size lie within.
    """
    side = np.roll(polygon, -1, axis=0) - polygon
    outwards = np.column_stack([side[:, 1], -side[:, 0]])
    at = margin * float(np.max(np.abs(polygon))) * np.hypot(*side.T) - np.sum(outwards * polygon, axis=1)
    return np.column_stack([at, outwards])


def _without(parts: Sequence[FloatArray], holes: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the parts of convex polygons outside some convex holes, as convex polygons."""
    found = [part for part in parts if len(part)]
    for hole in (hole for hole in holes if len(hole)):
        outside = _outside(hole, ROUNDING)
        found = [piece for part in found for piece in outside_parts(part, outside)]
    return found


def _inset(flat: FloatArray, rim: float) -> FloatArray:
    """Return the part of a convex polygon farther than `rim` (m) from its edges; empty if there is none."""
    found = inset(Face(np.zeros(3), np.eye(3), flat), rim)
    return np.empty((0, 2)) if found is None else found.outline


def _outset(circle: FloatArray, rim: float) -> FloatArray:
    """Return the polygon of a circle whose radius is larger by `rim` (m)."""
    centre = np.mean(circle, axis=0)
    return centre + (circle - centre) * (1.0 + rim / float(np.linalg.norm(circle[0] - centre)))


def _placed(scene: Scene, k: int, i: int, points: FloatArray) -> FloatArray:
    """Return the positions at an instant of points of a body given as built; those of the base stay."""
    if i >= len(scene.bodies):
        return points
    return points + scene.u[k, i] + turned(scene.turn[k, i], points - scene.bodies[i].centroid)


def _placed_parts(
    scene: Scene, k: int, contact: SceneContact, parts: Sequence[tuple[FloatArray, FloatArray]]
) -> list[list[FloatArray]]:
    """Return the polygons on the upper face and those below them on the lower one at their places at an instant, m."""
    ends, bodies = np.cumsum([len(upper) for upper, _ in parts])[:-1], (contact.body, contact.below)
    if not parts:
        return [[], []]
    return [
        np.split(_placed(scene, k, body, np.concatenate(polygons)), ends)
        for body, polygons in zip(bodies, zip(*parts, strict=True), strict=True)
    ]


def _normal(scene: Scene, k: int, contact: SceneContact) -> FloatArray:
    """Return the mean of the normals of both faces, along which a joint opens (theory.md section 13), (3,)."""
    built = normal_of(contact.points)
    normal = 2.0 * built + turned(_turn(scene, k, contact.body), built) + turned(_turn(scene, k, contact.below), built)
    return normal / np.linalg.norm(normal)


def _depths(apart: FloatArray, normal: FloatArray, contact: SceneContact) -> FloatArray:
    """Return the depths of the corners of the upper face in the lower one, from which they are `apart`, m (corners, 3).

    That of a bearing is the depth at its centre, in the surface on which it slides.
    """
    if not contact.at_point:
        return -apart @ normal
    centre = np.mean(apart, axis=0)
    height = float(centre @ normal)
    return np.full(len(apart), 0.5 * contact.pendulum * (float(centre @ centre) - height**2) - height)


def _loaded(points: FloatArray, closed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the part of a polygon of the upper face that penetrates the lower one, m, and its depth at the corners, m.

    `closed` are the depths at the corners of the whole polygon.
    """
    found, depths = [], []
    # clip the polygon at zero closure
    for a, b in zip(range(-1, len(points) - 1), range(len(points)), strict=True):
        if (closed[a] > 0.0) != (closed[b] > 0.0):
            part = closed[a] / (closed[a] - closed[b])
            found.append(points[a] + part * (points[b] - points[a]))
            depths.append(0.0)
        if closed[b] > 0.0:
            found.append(points[b])
            depths.append(closed[b])
    return np.array(found), np.array(depths)


def _write_cells(
    path: Path,
    polygons: Sequence[FloatArray],
    owners: Sequence[int],
    of_points: Mapping[str, FloatArray],
    owner: str,
    histories: Mapping[str, FloatArray],
    row: int,
) -> None:
    """Write polygons with the number of their block or joint, and its outputs at a row."""
    counts, of = np.array([len(polygon) for polygon in polygons], dtype=np.int64), np.array(owners, dtype=np.int64)
    points = np.concatenate(polygons) if polygons else np.empty((0, 3))
    cells = {owner: of + 1} | {name: values[row][of] for name, values in histories.items()}
    topology = {
        "connectivity": np.arange(len(points), dtype=np.int64),
        "offsets": np.cumsum(counts),
        "types": np.full(len(counts), POLYGON, dtype=np.uint8),
    }
    parts: dict[str, Mapping[str, Any]] = {
        "Points": {"points": points},
        "Cells": topology,
        "PointData": of_points,
        "CellData": cells,
    }
    text = "\n".join(
        f"<{kind}>{''.join(_array(name, values) for name, values in arrays.items())}</{kind}>"
        for kind, arrays in parts.items()
    )
    with whole_file(path) as partial:
        partial.write_text(PAGE.format(points=len(points), cells=len(counts), parts=text), encoding="ascii")


def _array(name: str, values: Any) -> str:
    size = np.uint32(values.nbytes).tobytes()  # before the numbers
    content = base64.b64encode(size + np.ascontiguousarray(values).tobytes()).decode()
    wide = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    return f'<DataArray type="{NAMES[values.dtype.name]}" Name="{name}"{wide} format="binary">{content}</DataArray>\n'
