"""The bodies of a response, their joints, and their poses at each row. Lengths in m, z up."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.errors import InputError
from ...kernels.column.sections.faces import SECTIONS
from ...models.column.block import Block
from ...models.column.model import Column
from ...models.structure.blocks.contacts import is_endless
from ...models.structure.blocks.faces import Face, FloatArray
from ...models.structure.blocks.parts import Solid, SpatialJoint
from ...models.structure.model import Structure

SIDES = 32  # of a round face
_ANGLES = 2.0 * math.pi * np.arange(SIDES) / SIDES
# corners of faces of width and depth 2 about their middle, by section: x, y
ROUND, SQUARE = np.array([np.cos(_ANGLES), np.sin(_ANGLES)]), np.array([[-1.0, 1, 1, -1], [-1, -1, 1, 1]])
OUTLINES = {"rectangle": SQUARE, "circle": ROUND, "annulus": ROUND, "strips": SQUARE}
AROUND = 0.3  # of the largest extent: a wall is clipped at this distance from the blocks
TOO_CLOSE = 1e-6  # s: tolerance on the distance of two rows


@dataclass(frozen=True, eq=False)
class Surface:
    """A plane polygon of a body, (corners, 3) m from its centroid, anticlockwise from outside."""

    points: FloatArray
    edged: bool = True  # its sides are edges of the body


@dataclass(frozen=True, eq=False)
class SceneBody:
    """A block as built."""

    name: str
    centroid: FloatArray  # (3,) m
    surfaces: tuple[Surface, ...]
    meshed: bool = False  # its surfaces are those of a mesh, and may be hollow
    reach: float = 0.0  # m, from the centroid to the top face: a column's ux is that of its middle
    tilt: float = 0.0  # rad, of the block as built


class Rims(NamedTuple):
    """A face: its rim, (points, 3) m from the centroid of the upper body as built, and that of its hole, or empty."""

    points: FloatArray
    hole: FloatArray


@dataclass(frozen=True, eq=False)
class SceneContact:
    """The face of a joint, (points, 3) m from the centroid of its upper body as built, anticlockwise from above."""

    name: str
    body: int
    below: int  # index of the lower body; the number of bodies for the base
    points: FloatArray
    hole: FloatArray  # the inner rim, empty without one
    stiffness: float  # N/m3
    at_point: bool = False  # a bearing, which bears at its centre
    pendulum: float = 0.0  # 1/m, curvature of the surface on which a bearing slides
    rim: float = 0.0  # m, width of the band along the edges in which the faces touch; 0: all over
    above: Rims | None = None  # the face of the upper body, which bounds the contact after a slip; None: `points`
    under: Rims | None = None  # that of the lower body; None: unbounded
    strips: tuple[FloatArray, ...] = ()  # rectangles of the face that touch; empty: all of it


@dataclass(frozen=True, eq=False)
class Scene:
    """The bodies of a model, and their poses at some rows of a response.

    A point whose arm from the centroid, as built, is r is displaced by `u` and by the rotation `turn` of r
    (models/structure/blocks/shapes.py, turned).
    """

    name: str
    bodies: tuple[SceneBody, ...]
    contacts: tuple[SceneContact, ...]
    walls: tuple[SceneBody, ...]  # of one surface each; they stay
    rows: NDArray[np.intp]  # of the response
    time: FloatArray  # s (rows,)
    u: FloatArray  # m (rows, n, 3)
    turn: FloatArray  # axis times angle, rad (rows, n, 3)

    @property
    def corners(self) -> FloatArray:
        """The corners of all bodies and walls as built, (points, 3) m."""
        every = (*self.bodies, *self.walls)
        return np.concatenate([body.centroid + part.points for body in every for part in body.surfaces])


def scene_of(response: Any, fps: float) -> Scene:
    """Return the scene of a Response or SpatialResponse, with at most `fps` rows per second and the last row."""
    rows, model = _rows(response.time, fps), response.model
    bodies, contacts = parts_of(model)
    u, turn = poses(bodies, response)
    return Scene(model.name, bodies, contacts, walls_of(model), rows, response.time[rows], u[rows], turn[rows])


@singledispatch
def parts_of(model: Any) -> tuple[tuple[SceneBody, ...], tuple[SceneContact, ...]]:
    """Return the blocks and joints of a model, by a function registered for its class.

    Raises InputError for a class without one.
    """
    raise InputError(f"scene: a {model.kind.word} has none, parts_of.register (plotting/scene/bodies.py) adds it")


def has_parts(model: Any) -> bool:
    """Return True if `parts_of` has a function for the class of a model."""
    return parts_of.dispatch(type(model)) is not parts_of.dispatch(object)


def walls_of(model: Any) -> tuple[SceneBody, ...]:
    """Return the walls that blocks of a structure may meet, clipped near the blocks; none of other models."""
    neighbours = getattr(model, "neighbours", ())
    faces = {pair.wall: pair.beside for pair in neighbours if pair.wall and isinstance(pair.beside, Face)}
    if not faces:
        return ()
    corners = np.concatenate([block.corners for block in model.blocks])
    beyond = AROUND * float(np.max(np.ptp(corners, axis=0)))
    found = []
    for number, face in sorted(faces.items()):
        seen = (corners - face.centre) @ face.axes[:, :2]
        low, high = face.outline.min(axis=0), face.outline.max(axis=0)
        near = np.clip(
            face.outline, np.maximum(low, seen.min(axis=0) - beyond), np.minimum(high, seen.max(axis=0) + beyond)
        )
        found.append(SceneBody(f"wall {number}", face.centre, (Surface(near @ face.axes[:, :2].T),)))
    return tuple(found)


def poses(bodies: Sequence[Any], histories: Any) -> tuple[FloatArray, FloatArray]:
    """Return displacements, m, and rotations, rad, (rows, n, 3) each, of a response.

    The bodies have `reach` and `tilt` of a SceneBody; the histories, (rows, n) each, ux, uy, uz, rx, ry, rz, or those
    of a column, ux, uz, ry.
    """
    if hasattr(histories, "rz"):
        found = [np.stack([getattr(histories, f"{kind}{axis}") for axis in "xyz"], axis=-1) for kind in "ur"]
        return found[0], found[1]
    u, turn = np.zeros((2, *histories.ry.shape, 3))
    turn[..., 1] = histories.ry  # clockwise, as x points to the right: about y
    reach, tilt = (np.array([getattr(body, name) for body in bodies]) for name in ("reach", "tilt"))
    u[..., 0] = histories.ux - reach * (np.sin(tilt + histories.ry) - np.sin(tilt))
    u[..., 2] = histories.uz
    return u, turn


def _rows(time: FloatArray, fps: float) -> Any:
    """Return the indices of rows at least 1 / fps apart, including the first and the last."""
    found, due = [], -math.inf
    for k, t in enumerate(time[:-1].tolist()):
        if t >= due - TOO_CLOSE:
            found.append(k)
            due = t + 1.0 / fps
    return np.array([*found, len(time) - 1])


@parts_of.register
def _of_structure(structure: Structure) -> tuple[tuple[SceneBody, ...], tuple[SceneContact, ...]]:
    bodies = tuple(
        SceneBody(block.name, block.centroid, surfaces(block), len(block.surface) > 0) for block in structure.blocks
    )
    contacts = zip(structure.joint_names, structure.joints, strict=True)
    return bodies, tuple(_contact(name, joint, bodies[joint.upper].centroid) for name, joint in contacts)


def _contact(name: str, joint: SpatialJoint, centroid: FloatArray) -> SceneContact:
    def rims(face: Face) -> Rims:
        hole = _inner(face) - centroid if face.bore else np.empty((0, 3))
        return Rims(face.points(SIDES) - centroid, hole)

    face, at_point = joint.face, joint.bearing is not None
    curvature = joint.bearing.pendulum if joint.bearing is not None else 0.0
    made = SceneContact(
        name, joint.upper, joint.lower, *rims(face), joint.bed.stiffness, at_point, curvature, joint.bed.rim or 0.0
    )
    if joint.bed.friction is None or at_point:
        return made
    under = joint.below or face
    return replace(made, above=rims(joint.above or face), under=None if is_endless(under) else rims(under))


def surfaces(block: Solid) -> tuple[Surface, ...]:
    """Return the surface of a block in space."""
    if len(block.surface):
        return tuple(Surface(triangle - block.centroid, False) for triangle in block.surface)
    round_faces = [face for face in block.faces if face.radius]
    if len(block.faces) != 2:
        return tuple(Surface(face.points() - block.centroid) for face in block.faces)
    # two faces: a drum, or a box that tapers
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
    """Return the points of the rim of the hole of a face."""
    return face.centre + (face.points(SIDES) - face.centre) * (face.bore / face.radius)


def _between(
    low: FloatArray, high: FloatArray, bore: Sequence[FloatArray] = (), edged: bool = False
) -> tuple[Surface, ...]:
    """Return the surface between two rings, both anticlockwise from above; `bore` has the two rings of a hole."""
    found = [Surface(np.array([low[k - 1], low[k], high[k], high[k - 1]]), edged) for k in range(len(low))]
    if not bore:
        return *found, Surface(low[::-1]), Surface(high)
    within, above = bore
    for k in range(len(low)):
        found.append(Surface(np.array([within[k], within[k - 1], above[k - 1], above[k]]), False))
        found.append(Surface(np.array([high[k - 1], high[k], above[k], above[k - 1]]), False))
        found.append(Surface(np.array([low[k], low[k - 1], within[k - 1], within[k]]), False))
    return tuple(found)


def normal_of(points: FloatArray) -> FloatArray:
    """Return the unit normal of a plane polygon."""
    arms = points - points[0]
    area = np.sum(np.cross(arms[1:-1], arms[2:]), axis=0)
    return area / max(float(np.linalg.norm(area)), 1e-300)


@parts_of.register
def _of_column(column: Column) -> tuple[tuple[SceneBody, ...], tuple[SceneContact, ...]]:
    bodies, contacts = [], []
    foot = np.zeros(3)  # centre of the bottom face as built
    top: Rims | None = None  # of the block below, from the origin; None: the base
    for i in range(column.n - 1, -1, -1):
        block = column.blocks[i]
        lean = block.joint.inclination or 0.0
        tilt = lean + (block.tilt or 0.0)
        lean_above = (column.blocks[i - 1].joint.inclination or 0.0) if i else tilt
        foot = foot + (block.joint.offset or 0.0) * np.array([math.cos(lean), 0.0, -math.sin(lean)])
        up = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
        rise = block.resolved_centroid
        made, rims, upper, strips = _of_block(block, tilt, lean - tilt, lean_above - tilt)
        centroid = foot + rise * up
        bodies.append(SceneBody(f"block {i + 1}", centroid, made, False, block.height - rise, tilt))
        under = None if top is None else Rims(*(ring - centroid for ring in top))
        rim = block.joint.rim or 0.0
        law = block.joint.stiffness
        contacts.append(SceneContact(f"joint {i + 1}", i, i + 1, *rims, law, rim=rim, under=under, strips=strips))
        top = Rims(*(centroid + ring for ring in upper))
        foot = foot + block.height * up
    return tuple(bodies[::-1]), tuple(contacts[::-1])


def _of_block(
    block: Block, tilt: float, below: float, above: float
) -> tuple[tuple[Surface, ...], Rims, Rims, tuple[FloatArray, ...]]:
    """Return the surface of a column's block, the rims of its joint and of its top, and the strips of its joint.

    below, above: angles of its faces, rad.
    """
    ends = (block.width, block.depth), (block.top_width or block.width, block.top_depth or block.depth)
    own, joint = (OUTLINES[SECTIONS[int(code)]] for code in (block.shape[0], block.joint_section))
    heights = -block.resolved_centroid, block.height - block.resolved_centroid
    cos, sin = math.cos(tilt), math.sin(tilt)
    turned = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])

    def ring(wide: float, deep: float, height: float, oblique: float, outline: FloatArray = ROUND) -> FloatArray:
        x, y = 0.5 * wide * outline[0], 0.5 * (wide if outline is ROUND else deep) * outline[1]
        return np.column_stack([x, y, height - x * math.tan(oblique)]) @ turned.T

    # bottom, top, hole and rims of the joint
    low, high = (ring(*end, z, oblique, own) for end, z, oblique in zip(ends, heights, (below, above), strict=True))
    hole = block.bore or 0.0
    bore = [ring(hole, hole, z, o) for z, o in zip(heights, (below, above), strict=True)] if hole else []
    rim = ring(block.joint_width, block.joint_depth, heights[0], below, joint)
    inner = ring(block.joint_bore, block.joint_bore, heights[0], below) if block.joint_bore else np.empty((0, 3))
    top = Rims(high, bore[1] if bore else np.empty((0, 3)))
    # strips, of equal width
    depths = block.joint.strips or ()
    edges = np.linspace(-1.0, 1.0, len(depths) + 1)
    outlines = [(deep, np.array([edges[[k, k + 1, k + 1, k]], SQUARE[1]])) for k, deep in enumerate(depths) if deep]
    strips = tuple(ring(block.joint_width, deep, heights[0], below, outline) for deep, outline in outlines)
    return _between(low, high, bore, edged=own is SQUARE), Rims(rim, inner), top, strips
