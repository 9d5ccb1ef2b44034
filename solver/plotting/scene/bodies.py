"""The bodies of a response, their joints, and where they are at each row. Lengths in m, z up."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...kernels.sections.faces import is_round
from ...models.column.block import Block
from ...models.column.model import Column
from ...models.structure.blocks.faces import Face, FloatArray
from ...models.structure.blocks.parts import Solid
from ...models.structure.model import Structure

SIDES = 32  # of a round face
TOO_CLOSE = 1e-6  # s: rows that a sampled time may miss


@dataclass(frozen=True, eq=False)
class Surface:
    """A plane polygon of a body, anticlockwise from outside, (corners, 3) m from its centroid."""

    points: FloatArray
    edged: bool = True  # its sides are edges of the body


@dataclass(frozen=True, eq=False)
class Body:
    """A block as built."""

    name: str
    centroid: FloatArray  # (3,) m
    surfaces: tuple[Surface, ...]


@dataclass(frozen=True, eq=False)
class Rim:
    """The rim of a joint, (points, 3) m from the centroid of its upper body as built."""

    name: str
    body: int
    points: FloatArray


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, and at some rows of a response their poses: a point at an arm from the centroid, as built, is displaced
    by `u` and by `turn` of its arm (models/structure/blocks/shapes.py, turned)."""

    name: str
    bodies: tuple[Body, ...]
    rims: tuple[Rim, ...]
    time: FloatArray  # s (rows,)
    u: FloatArray  # m (rows, n, 3)
    turn: FloatArray  # axis times angle, rad (rows, n, 3)
    contact: FloatArray  # 0..1 (rows, joints)

    @property
    def corners(self) -> FloatArray:
        """All corners as built, (points, 3) m."""
        return np.concatenate([body.centroid + part.points for body in self.bodies for part in body.surfaces])


def scene_of(response: Any, fps: float) -> Scene:
    """The scene of a Response or SpatialResponse, of rows at most `fps` a second, the last one among them."""
    rows = _rows(response.time, fps)
    model = response.model
    bodies, rims, u, turn = (_of_structure if model.kind.across else _of_column)(response, rows)
    return Scene(model.name, bodies, rims, response.time[rows], u, turn, response.contact[rows])


def _rows(time: FloatArray, fps: float) -> Any:
    """Rows whose times are apart by 1 / fps at least, the first and the last among them."""
    found, due = [], -math.inf
    for k, t in enumerate(time[:-1].tolist()):
        if t >= due - TOO_CLOSE:
            found.append(k)
            due = t + 1.0 / fps
    return np.array([*found, len(time) - 1])


def _of_structure(response: Any, rows: Any) -> tuple[Any, ...]:
    structure: Structure = response.structure
    bodies = tuple(Body(block.name, block.centroid, _surfaces(block)) for block in structure.blocks)
    rims = tuple(
        Rim(name, joint.upper, joint.face.points(SIDES) - structure.blocks[joint.upper].centroid)
        for name, joint in zip(structure.joint_names, structure.joints, strict=True)
    )
    u = np.stack([response.ux, response.uy, response.uz], axis=-1)[rows]
    return bodies, rims, u, response.rotation[rows]


def _surfaces(block: Solid) -> tuple[Surface, ...]:
    """The surface of a block in space."""
    round_faces = [face for face in block.faces if face.radius]
    if len(block.faces) != 2:
        return tuple(Surface(face.points() - block.centroid) for face in block.faces)
    low, high = (face.points(SIDES) - block.centroid for face in block.faces)
    if len(round_faces) == 2:
        high = np.roll(high[::-1], 1, axis=0)  # seen from the other side
        bore = [_inner(face) - block.centroid for face in block.faces] if block.faces[0].bore else []
        if bore:
            bore[1] = np.roll(bore[1][::-1], 1, axis=0)
        return _between(low[::-1], high[::-1], [ring[::-1] for ring in bore])
    high = high[[int(np.argmin(np.linalg.norm(high[:, :2] - corner[:2], axis=1))) for corner in low]]
    return _between(low[::-1], high[::-1], edged=True)  # a box that tapers


def _inner(face: Face) -> FloatArray:
    """Points of the rim of its hole."""
    found: FloatArray = face.centre + (face.points(SIDES) - face.centre) * (face.bore / face.radius)
    return found


def _between(
    low: FloatArray, high: FloatArray, bore: Sequence[FloatArray] = (), edged: bool = False
) -> tuple[Surface, ...]:
    """The surface between two rings, both anticlockwise seen from above; bore: those of a hole."""
    found = [Surface(np.array([low[k - 1], low[k], high[k], high[k - 1]]), edged) for k in range(len(low))]
    if not bore:
        return *found, Surface(low[::-1]), Surface(high)
    within, above = bore
    for k in range(len(low)):
        found.append(Surface(np.array([within[k], within[k - 1], above[k - 1], above[k]]), False))
        found.append(Surface(np.array([high[k - 1], high[k], above[k], above[k - 1]]), False))
        found.append(Surface(np.array([low[k], low[k - 1], within[k - 1], within[k]]), False))
    return tuple(found)


def _of_column(response: Any, rows: Any) -> tuple[Any, ...]:
    column: Column = response.column
    bodies, rims = [], []
    u, turn = np.zeros((2, len(rows), column.n, 3))
    turn[:, :, 1] = response.theta[rows]  # clockwise, as x points to the right: about y
    u[:, :, 2] = response.uz[rows]
    foot = np.zeros(3)  # middle of the bottom face as built
    for i in range(column.n - 1, -1, -1):
        block = column.blocks[i]
        lean = block.joint.inclination or 0.0
        tilt = lean + (block.tilt or 0.0)
        lean_above = (column.blocks[i - 1].joint.inclination or 0.0) if i else tilt
        foot = foot + (block.joint.offset or 0.0) * np.array([math.cos(lean), 0.0, -math.sin(lean)])
        up = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
        rise = block.resolved_centroid
        surfaces, rim = _of_block(block, tilt, lean - tilt, lean_above - tilt)
        bodies.append(Body(f"block {i + 1}", foot + rise * up, surfaces))
        rims.append(Rim(f"joint {i + 1}", i, rim))
        reach = block.height - rise  # ux is that of the top face
        u[:, i, 0] = response.ux[rows, i] - reach * (np.sin(tilt + turn[:, i, 1]) - math.sin(tilt))
        foot = foot + block.height * up
    return tuple(bodies[::-1]), tuple(rims[::-1]), u, turn


def _of_block(block: Block, tilt: float, below: float, above: float) -> tuple[tuple[Surface, ...], FloatArray]:
    """The surface of a column's block and the rim of its bottom face; below, above: obliqueness of its faces, rad."""
    ends = (block.width, block.depth), (block.top_width or block.width, block.top_depth or block.depth)
    is_drum = is_round(block.shape[0])
    heights = -block.resolved_centroid, block.height - block.resolved_centroid
    cos, sin = math.cos(tilt), math.sin(tilt)
    turned = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])

    def ring(wide: float, deep: float, height: float, oblique: float) -> FloatArray:
        if is_drum:
            angle = 2.0 * math.pi * np.arange(SIDES) / SIDES
            x, y = 0.5 * wide * np.cos(angle), 0.5 * wide * np.sin(angle)
        else:
            x, y = 0.5 * wide * np.array([-1, 1, 1, -1]), 0.5 * deep * np.array([-1, -1, 1, 1])
        found: FloatArray = np.column_stack([x, y, height - x * math.tan(oblique)]) @ turned.T
        return found

    low, high = (ring(*end, z, oblique) for end, z, oblique in zip(ends, heights, (below, above), strict=True))
    hole = block.bore or 0.0
    bore = [ring(hole, hole, z, o) for z, o in zip(heights, (below, above), strict=True)] if hole else []
    return _between(low, high, bore, edged=not is_drum), low
