"""A response as files for ParaView: the blocks, and the compressed parts of their joints with the pressure."""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import POSITIVE, InputError, check_number
from ...models.outputs import BLOCK, JOINT
from ...models.structure.blocks.faces import FloatArray
from ...models.structure.blocks.shapes import turned
from .bodies import Scene, SceneContact, normal_of, scene_of

POLYGON = 7  # VTK cell type
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

    Cells carry the number of their block or joint and its outputs; points of joints carry the elastic pressure, Pa.
    Raises InputError if `folder` is not a folder, or `fps` (instants per second, at most) is not positive; OSError.
    """
    fps = check_number("fps", fps, POSITIVE, "a positive number of rows a second")
    where = Path(folder)
    if where.suffix or (where.exists() and not where.is_dir()):
        raise InputError(f"{folder}: must be a folder, for one file at each instant")
    scene = scene_of(response, fps)
    where.mkdir(parents=True, exist_ok=True)
    outputs = {owner: _histories(response, owner) for owner in (BLOCK, JOINT)}
    for k, row in enumerate(scene.rows):
        _write_cells(where / f"blocks_{k:05d}.vtu", *_blocks(scene, k), BLOCK, outputs[BLOCK], row)
        _write_cells(where / f"joints_{k:05d}.vtu", *_joints(scene, k), JOINT, outputs[JOINT], row)
    if scene.walls:
        walls = [wall.centroid + wall.surfaces[0].points for wall in scene.walls]
        _write_cells(where / "walls.vtu", walls, range(len(walls)), {}, "wall", {}, 0)
    for name in ("blocks", "joints"):
        lines = (f'<DataSet timestep="{t:.9g}" file="{name}_{k:05d}.vtu"/>' for k, t in enumerate(scene.time))
        (where / f"{name}.pvd").write_text(SERIES.format(lines="\n".join(lines)), encoding="ascii")


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


def _joints(scene: Scene, k: int) -> tuple[list[FloatArray], list[int], dict[str, FloatArray]]:
    """Return the compressed parts of the joints as polygons, m, their joints, and the pressure at corners, Pa."""
    found, owners, pressures = [], [], []
    for j, contact in enumerate(scene.contacts):
        for piece in _pieces(contact):
            points, closed = _loaded(scene, k, contact, scene.bodies[contact.body].centroid + piece)
            if len(points) > 2:
                found.append(points)
                owners.append(j)
                pressures.append(contact.stiffness * closed)
    return found, owners, {"pressure": np.concatenate(pressures) if pressures else np.empty(0)}


def _pieces(contact: SceneContact) -> list[FloatArray]:
    """Return convex polygons that make up the face of a joint."""
    outer, inner = contact.points, contact.hole
    if not len(inner):
        return [outer]
    return [np.array([outer[k - 1], outer[k], inner[k], inner[k - 1]]) for k in range(len(outer))]


def _placed(scene: Scene, k: int, i: int, points: FloatArray) -> FloatArray:
    """Return the positions at an instant of points of a body given as built; those of the base stay."""
    if i >= len(scene.bodies):
        return points
    found: FloatArray = points + scene.u[k, i] + turned(scene.turn[k, i], points - scene.bodies[i].centroid)
    return found


def _loaded(scene: Scene, k: int, contact: SceneContact, piece: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the part of a polygon of the upper face that penetrates the lower one, m, and its depth at the corners, m.

    A joint opens along the mean of both faces' normals (theory.md section 13).
    """
    # closure of the joint at the corners along the mean normal
    built, below = normal_of(contact.points), contact.below
    normal = 2.0 * built + turned(scene.turn[k, contact.body], built)
    if below < len(scene.bodies):
        normal = normal + turned(scene.turn[k, below], built)
    points = _placed(scene, k, contact.body, piece)
    closed = (_placed(scene, k, below, piece) - points) @ normal / np.linalg.norm(normal)
    if contact.at_point:
        closed = np.full(len(points), np.mean(closed))
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
    path.write_text(PAGE.format(points=len(points), cells=len(counts), parts=text), encoding="ascii")


def _array(name: str, values: Any) -> str:
    size = np.uint32(values.nbytes).tobytes()  # before the numbers
    content = base64.b64encode(size + np.ascontiguousarray(values).tobytes()).decode()
    wide = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    return f'<DataArray type="{NAMES[values.dtype.name]}" Name="{name}"{wide} format="binary">{content}</DataArray>\n'
