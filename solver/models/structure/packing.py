"""The flat arrays of a structure for the kernels (kernels/structure/layout.py)."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np

from ...kernels.structure import layout as at
from ...kernels.structure.modal_layout import AXES, MODAL_ROOM
from ..column.packing import Arrays as Arrays
from ..ports import Port
from .blocks.contacts import inside_of, is_endless
from .blocks.faces import Face, FloatArray, edge_distance, polygon_moments
from .blocks.parts import Pair, Side, Solid, SpatialJoint, Tie

FLOOR = 1e-3  # of the settlement under weight: the least motion relative to which errors are measured
# least damping along a joint that may slide, times the frequency of the fastest joint: the elastic slip follows the
# motion within that time, which explicit steps must resolve
RELAXATION = 0.1


class PackedModel(NamedTuple):
    """The description of a structure for the kernels."""

    sizes: at.Sizes
    numbers: FloatArray  # layout.py, MODEL

    @property
    def names(self) -> Any:
        """The numbers by name: settings, bodies, joints, ties, corners, modal."""
        return at.MODEL.see(self.numbers, self.sizes)


def arrays_of(model: PackedModel) -> Arrays:
    """Return the arrays of a structure, zero except for its model and its unbroken bonds."""
    state = np.zeros(at.STATE.size(model.sizes))
    names = at.STATE.see(state, model.sizes)
    _put_bonds(names.bonded, model.names)
    names.remembered.stretches.touches[:] = np.where(model.names.pairs.joined == 1.0, at.JOINED, at.APART)
    return Arrays(
        model.numbers.copy(),
        state,
        np.zeros(at.COUNTS.beside, dtype=np.int64),
        np.zeros(at.INPUT_MOTION.size(model.sizes)),
        np.zeros(at.WORK.size(model.sizes)),
    )


def _put_bonds(bonded: FloatArray, names: Any) -> None:
    """Set the unbroken polygon of each bond to its whole section."""
    for left, j in zip(bonded.reshape(-1, at.OF_POLYGON.size(1)), names.bonds.joint.astype(int), strict=False):
        first, count = int(names.joints.first[j]), int(names.joints.corners[j])
        at.BONDED.see(left).corners = count
        corners = names.corners[2 * first : 2 * (first + count)]
        left[at.BONDED.beside :][: corners.size] = corners


def unbroken_shares(state: FloatArray, model: PackedModel) -> FloatArray:
    """Return the unbroken share of the area of each bonded joint in a state, (bonds,)."""
    sizes, names = model.sizes, model.names
    left = state[at.place_of_bonds(sizes) : sizes.state].reshape(sizes.bonds, at.OF_POLYGON.size(1))
    counts, corners = left[:, 0], left[:, at.BONDED.beside :].reshape(sizes.bonds, at.MOST_BONDED, 2)
    there = np.arange(at.MOST_BONDED) < counts[:, None]
    x, y = (np.where(there, corners[..., axis] - corners[:, :1, axis], 0.0) for axis in range(2))
    doubled = np.sum(x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1], axis=1)
    shares: FloatArray = 0.5 * doubled / names.joints.area[names.bonds.joint.astype(int)]
    return shares


def with_modes(model: PackedModel, modal: FloatArray) -> PackedModel:
    """Return a copy of a model without modes, with the modal data appended."""
    room = MODAL_ROOM.size((AXES * model.sizes.n, model.sizes.k))
    sizes = at.sizes_of(*model.sizes[:8], modal.size, room if modal.size else 0)
    made = PackedModel(sizes, np.concatenate([model.numbers, modal]))
    made.numbers[: len(sizes)] = sizes
    made.names.settings.has_modes = float(modal.size > 0)
    return made


class Parts(NamedTuple):
    """The parts of a structure."""

    solids: tuple[Solid, ...]
    joints: tuple[SpatialJoint, ...]
    ties: tuple[Tie, ...]
    ports: tuple[Port, ...]
    pairs: tuple[Pair, ...]


def model_of(parts: Parts, g: float, tolerance: float) -> PackedModel:
    """Return the model of a structure without modes, with gravity (m/s2) and a tolerance relative to the motion."""
    made = _model_of(parts, g)
    made = made._replace(numbers=made.numbers.copy())
    settings = made.names.settings
    settings.tolerance = tolerance
    settings.step_tolerance = at.step_tolerance(settings.order, tolerance)
    settings.stabilizes = at.stabilizes(settings.order, tolerance)
    return made


@lru_cache(maxsize=64)
def _model_of(parts: Parts, g: float) -> PackedModel:
    """Return the model of a structure, without tolerances."""
    solids, joints, ties, ports, pairs = parts
    # corners: sections of the joints, their faces, insides of rims, faces and bodies of pairs
    outlines = [joint.face.outline.ravel() for joint in joints]
    faces = [_faces_of(joint, joint.above, joint.below) for joint in joints]
    insides = [_inside_of(joint) for joint in joints]
    corners = np.concatenate([np.zeros(0), *outlines, *(part for parts in (*faces, *insides) for part in parts)])
    sides = [pair.beside.outline.ravel() if isinstance(pair.beside, Face) else np.zeros(0) for pair in pairs]
    met = {id(body): body for pair in pairs for body in pair.bodies}
    rows = {number: body.row() for number, body in met.items()}
    bodies = dict(zip(rows, corners.size + np.cumsum([0, *map(len, rows.values())]), strict=False))
    corners = np.concatenate([corners, *rows.values(), *sides])
    # sizes
    bearings = sum(joint.bearing is not None for joint in joints)
    bonds = [j for j, joint in enumerate(joints) if joint.bed.is_bonded]
    parts_too = len(ports), len(pairs), len(bonds)
    sizes = at.sizes_of(len(solids), len(joints), len(ties), bearings, corners.size, *parts_too)
    model = PackedModel(sizes, np.zeros(at.MODEL.size(sizes)))
    model.numbers[: len(sizes)] = sizes
    names = model.names
    names.corners[:] = corners
    _fill_bodies(names.bodies, solids)
    table, settings = names.joints, names.settings
    # joints, with the offsets of their corners
    place, behind = 0, sum(outline.size for outline in outlines)
    for j, joint in enumerate(joints):
        _fill_joint(table, j, joint, solids, place)
        place += len(joint.face.outline)
        if faces[j]:
            above, below = faces[j]
            table.above[j], table.below[j] = behind, behind + above.size
            table.rim_a[j], table.rim_b[j] = _rim(above), _rim(below)
            behind += above.size + below.size
    for j, inside in enumerate(insides):
        if inside:
            section, above, below = inside
            table.inside[j], record = behind + 1, at.INSIDE.see(names.corners[behind:])
            record.above, record.below = behind + section.size, behind + section.size + above.size
            behind += section.size + above.size + below.size
    # bonds, ties, ports
    for e, j in enumerate(bonds):
        table.bond[j], names.bonds.joint[e] = e + 1.0, j
        names.bonds.strength[e] = joints[j].bed.tensile_strength
        names.bonds.cohesion[e] = joints[j].bed.cohesion
    for e, tie in enumerate(ties):
        _fill_tie(names.ties, e, tie, solids)
    for p, port in enumerate(ports):
        names.ports.body[p] = port.body
        names.ports.x[p], names.ports.y[p], names.ports.z[p] = port.at
    # pairs of neighbours
    place = corners.size - sum(side.size for side in sides)
    for p, pair in enumerate(pairs):
        _fill_pair(names.pairs, p, pair, solids, place)
        names.pairs.body_a[p], names.pairs.body_b[p] = (bodies[id(body)] for body in pair.bodies)
        for i in {pair.one, pair.other} - {len(solids)}:
            names.bodies.reach[i] = max(names.bodies.reach[i], solids[i].reach + pair.beyond)
        place += sides[p].size
        if pair.joined:
            for j, joint in enumerate(joints):
                if {joint.upper, joint.lower} == {pair.one, pair.other} and not table.pair[j]:
                    table.pair[j] = p + 1.0
    # settings; elastic slip at which friction yields, least damping along sliding joints
    _fill_settings(settings, table, solids, joints, g)
    slides = any(joint.bed.friction is not None for joint in joints)
    settlement = settings.motion_floor * settings.extent / FLOOR
    for j, joint in enumerate(joints):
        table.reach[j] = math.inf
        if joint.bed.friction is not None:
            table.reach[j] = joint.bed.friction * settlement / joint.bed.shear_ratio + joint.bed.dowel / table.shear[j]
        table.shear_damping[j] = at.shear_damping_of(table.shear_damping[j], table.friction[j], settings.relaxation)
    settings.gives_way = float(slides or bool(pairs) or any(tie.yield_ is not None for tie in ties))
    return model


def centroid_of(solids: tuple[Solid, ...], i: int) -> FloatArray:
    """Return the centroid of a body (m); for the base the origin."""
    return solids[i].centroid if i < len(solids) else np.zeros(3)


def _fill_bodies(table: Any, solids: tuple[Solid, ...]) -> None:
    for i, solid in enumerate(solids):
        table.mass[i], table.per_mass[i] = solid.mass, 1.0 / solid.mass
        for prefix, tensor in (("j", solid.inertia), ("i", _inverse(solid.inertia))):
            for row, column in combinations_with_replacement(range(3), 2):
                getattr(table, prefix + "xyz"[row] + "xyz"[column])[i] = tensor[row, column]
        table.x[i], table.y[i], table.z[i] = solid.centroid
        table.size[i], table.drop[i], table.reach[i] = solid.size, solid.drop, solid.reach


def _inverse(tensor: FloatArray) -> FloatArray:
    """Return the inverse of a symmetric tensor, (3, 3), by its minors: the same bits with any linear algebra."""
    a, b, c = tensor
    minors = np.array([np.cross(b, c), np.cross(c, a), np.cross(a, b)])
    return minors.T / float(a @ minors[0])


@lru_cache(maxsize=64)
def _extent_of(solids: tuple[Solid, ...]) -> float:
    """Return the length (m) that converts rotations of the whole to displacements.

    It is the height, or a tenth of the largest extent if that is more.
    """
    corners = np.concatenate([solid.corners for solid in solids])
    return max(float(np.max(corners[:, 2])), 0.1 * float(np.max(np.ptp(corners, axis=0))))


def _fill_joint(table: Any, j: int, joint: SpatialJoint, solids: tuple[Solid, ...], place: int) -> None:
    face, bed = joint.face, joint.bed
    table.upper[j], table.lower[j] = joint.upper, joint.lower
    for prefix, body in (("a", joint.upper), ("b", joint.lower)):
        arm = face.centre - centroid_of(solids, body)
        for axis, length in zip("xyz", arm, strict=True):
            getattr(table, prefix + axis)[j] = length
    for k in range(3):
        for axis, part in zip("xyz", face.axes[:, k], strict=True):
            getattr(table, f"e{k + 1}{axis}")[j] = part
    # section, stiffness, friction
    area, ixx, iyy, ixy = joint.moments
    table.area[j], table.ixx[j], table.iyy[j], table.ixy[j] = area, ixx, iyy, ixy
    table.stiffness[j], table.damping[j] = bed.stiffness, bed.damping
    shear = bed.shear_ratio * bed.stiffness
    table.shear[j], table.twist[j] = shear * area, shear * (ixx + iyy)
    table.shear_damping[j] = shear_damping_in_file(joint)
    table.friction[j] = math.inf if bed.friction is None else bed.friction
    table.dowel[j], table.arm[j] = bed.dowel, joint.arm
    table.section[j] = at.ROUND if face.radius else at.POLYGON
    table.outer[j], table.inner[j] = face.radius, face.bore
    table.first[j], table.corners[j] = place, len(face.outline)
    table.rim_a[j], table.rim_b[j] = math.inf, math.inf
    if joint.bearing is not None:
        table.section[j], table.twist[j] = at.POINT, 0.0
        table.rim_a[j], table.rim_b[j] = 0.0, 0.0  # a point has no edges: a slip moves no contact
        for name in ("pendulum", "spring", "dashpot", "ring", "ring_stiffness", "ring_damping", "capacity", "holds"):
            getattr(table, name)[j] = getattr(joint.bearing, name)


def shear_damping_in_file(joint: SpatialJoint) -> float:
    """Return the shear damping that the file gives a joint (s), of which sliding may need more."""
    bed = joint.bed
    return bed.damping if bed.shear_damping is None else bed.shear_damping


def _faces_of(joint: SpatialJoint, above: Face | None, below: Face | None) -> tuple[FloatArray, ...]:
    """Return both faces of a joint that may slide, for the kernels (layout.py, FACE); empty for others."""
    if joint.bed.friction is None or joint.bearing is not None:
        return ()
    return _face_of(joint, above or joint.face), _face_of(joint, below or joint.face)


def _inside_of(joint: SpatialJoint) -> tuple[FloatArray, ...]:
    """Return the open inside of the rim of a joint (layout.py, INSIDE), and those of its faces; empty without a rim."""
    inside, rim = joint.inside, joint.bed.rim
    if inside is None or rim is None:
        return ()
    _, first, _ = polygon_moments(inside.outline) if not inside.radius else (0.0, np.zeros(2), 0.0)
    area, ixx, iyy, ixy = inside.moments
    record = np.zeros(at.INSIDE.beside)
    names = at.INSIDE.see(record)
    names.section, names.corners = at.ROUND if inside.radius else at.POLYGON, len(inside.outline)
    names.area, names.x, names.y, names.ixx, names.iyy, names.ixy = area, *first, ixx, iyy, ixy
    names.outer, names.inner = inside.radius, inside.bore
    faces = (inside_of(part or joint.face, rim) for part in (joint.above, joint.below))
    return np.concatenate([record, inside.outline.ravel()]), *(_faces_of(joint, *faces) or 2 * (np.zeros(0),))


def _face_of(joint: SpatialJoint, face: Face) -> FloatArray:
    """Return the record of a face along the axes of a joint, from its centre."""
    if is_endless(face):
        return np.array([0.0, 0.0, 0.0, math.inf, 0.0])
    if face.radius:
        x, y = (face.centre - joint.face.centre) @ joint.face.axes[:, :2]
        return np.array([0.0, x, y, face.radius, face.bore])
    outline = face.seen_from(joint.face)
    radius = float(np.max(np.hypot(*outline.T)))
    return np.array([len(outline), 0.0, 0.0, radius, 0.0, *outline.ravel()])


def _rim(face: FloatArray) -> float:
    """Return the distance of the nearest edge of a face from the centre of its joint (m)."""
    if not face[0]:
        return float(face[3] - math.hypot(face[1], face[2]))
    return edge_distance(face[at.FACE.beside :].reshape(-1, 2))


def _fill_tie(table: Any, e: int, tie: Tie, solids: tuple[Solid, ...]) -> None:
    table.one[e], table.other[e] = tie.one, tie.other
    for prefix, arm in (("a", tie.from_), ("b", tie.to)):
        for axis, length in zip("xyz", arm, strict=True):
            getattr(table, prefix + axis)[e] = length
    built = centroid_of(solids, tie.other) + tie.to - centroid_of(solids, tie.one) - tie.from_
    table.stiffness[e], table.damping[e] = tie.stiffness, tie.damping
    table.length[e] = float(np.linalg.norm(built)) + tie.slack - tie.pretension / tie.stiffness
    table.tension_only[e] = 1.0 if tie.tension_only else 0.0
    table.yields_at[e] = math.inf if tie.yield_ is None else tie.yield_


def _fill_pair(table: Any, p: int, pair: Pair, solids: tuple[Solid, ...], place: int) -> None:
    table.one[p], table.other[p], table.kind[p] = pair.one, pair.other, at.CONVEX
    table.farther[p], table.joined[p] = pair.farther, float(pair.joined)
    if pair.side is not None:
        table.kind[p] = at.DRUMS if isinstance(pair.beside, Side) else at.PLANE
        _fill_side(table, p, pair, solids, place)
    # the law
    blocks = [solids[i] for i in (pair.one, pair.other) if i < len(solids)]
    frequency = math.sqrt(2.0 * pair.stiffness * pair.size / min(solid.mass for solid in blocks))
    table.stiffness[p], table.damping[p] = pair.stiffness, pair.damping
    table.body_stiffness[p] = 2.0 * pair.body_stiffness  # of each of both, as springs in series
    table.friction[p], table.shear[p] = pair.friction, pair.shear
    table.shear_damping[p] = RELAXATION / frequency
    table.decay[p] = 1.0 / (pair.damping * frequency**2) if pair.damping else math.inf
    reach = sum(solid.reach for solid in blocks) + pair.beyond
    table.reach[p] = math.inf if pair.other == len(solids) else reach


def _fill_side(table: Any, p: int, pair: Pair, solids: tuple[Solid, ...], place: int) -> None:
    """Fill the side of the first drum of pair p, and the other drum or face that it is before."""
    table.radius_a[p] = -pair.farther
    for body, side, arm, along in ((pair.one, pair.side, "a", "u"), (pair.other, pair.beside, "b", "v")):
        if isinstance(side, Face):
            table.first[p], table.corners[p] = place, len(side.outline)
            table.e1x[p], table.e1y[p], table.e1z[p] = side.axes[:, 0]
            middle, direction = side.centre, side.normal
        elif side is not None:
            getattr(table, f"radius_{arm}")[p] += side.radius
            getattr(table, f"half_{arm}")[p] = side.half
            middle, direction = side.middle, side.axis
        for prefix, vector in ((arm, middle - centroid_of(solids, body)), (along, direction)):
            for name, part in zip("xyz", vector, strict=True):
                getattr(table, prefix + name)[p] = part


def _fill_settings(
    settings: Any, table: Any, solids: tuple[Solid, ...], joints: tuple[SpatialJoint, ...], g: float
) -> None:
    extent = _extent_of(solids)
    fastest = 1e-12
    for j, joint in enumerate(joints):
        for body in (joint.upper, joint.lower):
            if body < len(solids):
                across = float(table.stiffness[j] * table.area[j])
                if joint.bearing is not None:
                    along = table.shear[j] + joint.bearing.spring + joint.bearing.ring_stiffness
                    across = max(across, float(along))
                fastest = max(fastest, across / solids[body].mass)
    # first step and order of the method
    frequency = math.sqrt(2.0 * fastest)
    settings.gravity = g
    settings.first_step = at.FIRST_STEP / frequency
    along = [d if joint.bearing else s for joint, d, s in zip(joints, table.damping, table.shear_damping, strict=True)]
    damping = max(map(min, table.damping, along), default=0.0)  # without that of sliders
    settings.order = at.order_of(damping, settings.first_step)
    # floors of the errors
    settings.extent = extent
    settings.motion_floor = max(1e-12, FLOOR * max(g, 1e-3) / fastest / extent)
    settings.rate_floor = settings.motion_floor * math.sqrt(max(g, 1e-3) / extent)
    settings.relaxation = RELAXATION / frequency
    settings.watches = 1.0
