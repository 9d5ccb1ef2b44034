"""A column as a structure in space, and the column that a structure is equivalent to, if any."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...common.errors import InputError
from ...kernels.column.sections.faces import (
    ANNULUS,
    CIRCLE,
    RECTANGLE,
    SECTIONS,
    STRIPS,
    FaceShape,
    is_round,
)
from ..column import block as planar
from ..column.model import Column
from ..column.settings import Settings
from ..ports import Port
from .blocks.contacts import GROUND, with_rim
from .blocks.faces import Face, FloatArray, shared
from .blocks.parts import OF_COLUMN, SKIPS, JointLaw, Solid, SpatialJoint
from .blocks.shapes import box, drum, placed, rectangle

if TYPE_CHECKING:
    from .model import Structure

IN_SPACE = (RECTANGLE, CIRCLE, ANNULUS, STRIPS)  # sections with a form in space; of strips a message says more
CLOSE = 1e-9  # relative difference of a structure from the stack of its column


def stacked(column: Column) -> dict[str, Any]:
    """Return the fields of the structure with the blocks and joints of a column, the top one first.

    Raises InputError if the column has no form in space.
    """
    if column.settings.formulation == "paper":
        raise InputError('solver.formulation = paper: must be "exact" in space')
    if column.other_law:
        raise InputError(f"joint.{column.other_law}: must be left out in space")
    for number, block in enumerate(column.blocks, start=1):
        for key, section in (("section", int(block.shape[0])), ("joint.section", block.joint_section)):
            if section not in IN_SPACE:
                raise InputError(f'block[{number}].{key} = "{SECTIONS[section]}": has no form in space')
    heights = np.cumsum([0.0, *(block.height for block in reversed(column.blocks))])[::-1][1:]
    solids = tuple(
        _solid(f"block{number}", block, float(foot))
        for number, (block, foot) in enumerate(zip(column.blocks, heights, strict=True), start=1)
    )
    joints = tuple(_joint(column, i, float(foot)) for i, foot in enumerate(heights))
    tolerance, without = column.settings.tolerance, tuple(name for name in column.settings.without if name in SKIPS)
    ports = tuple(Port(port.name, port.body, (port.at[0], 0.0, port.at[1])) for port in column.ports)
    found = {"name": column.name, "blocks": solids, "joints": joints, "g": column.g, "ports": ports}
    return found | {"tolerance": tolerance, "without": without, "described": {OF_COLUMN: column.to_dict()}}


def in_three(data: Mapping[str, Any]) -> dict[str, Any]:
    """Convert the ports of a column's file to those of a structure: points [x, z] of the plane become [x, 0, z]."""
    tables = data["port"]
    if not isinstance(tables, list):
        return {"port": tables}
    found = []
    for table in tables:
        at = table.get("at") if isinstance(table, Mapping) else None
        if isinstance(at, (list, tuple)) and len(at) == 2:
            table = {**table, "at": [at[0], 0.0, at[1]]}
        found.append(table)
    return {"port": found}


def _solid(name: str, block: planar.Block, foot: float) -> Solid:
    top = block.top_width or block.width, block.top_depth or block.depth
    if is_round(block.shape[0]):
        made = drum(name, block.width, top[0], block.bore or 0.0, block.height, 1.0)
    else:
        made = box(name, (block.width, block.depth), top, block.height, 1.0)
    made = placed(made, np.array([0.0, 0.0, foot]), np.eye(3))
    load = block.given.load if block.given is not None and block.is_as_given else None
    inertia = made.inertia * ((block.mass - (load.mass if load else 0.0)) / made.mass)
    beyond = block.resolved_inertia - inertia[1, 1]  # of a load, or as given: the same about both horizontal axes
    inertia = inertia + np.diag([beyond, beyond, 0.0])
    centroid = np.array([0.0, 0.0, foot + block.resolved_centroid])
    return replace(made, mass=block.mass, centroid=centroid, inertia=inertia)


def _joint(column: Column, i: int, foot: float) -> SpatialJoint:
    block, key = column.blocks[i], f"block[{i + 1}]"
    if block.is_off_axis or block.joint_section == STRIPS:
        raise InputError(f"{key}: must stand on its axis, and not on strips, to be stacked in space")
    below = GROUND if i == column.n - 1 else _level(column.blocks[i + 1].top_face, foot, 1.0)
    above = _level(block.contact_face, foot, -1.0)
    face = shared(above, below, key)
    if face is None:
        raise InputError(f"{key}: its face and the one below do not meet")
    # law of the joint in space
    law = block.joint
    same = {key: getattr(law, key) for key in ("friction", "strength", "tensile_strength", "cohesion", "rim")}
    bed = JointLaw(law.stiffness, law.damping, dowel=law.dowel or 0.0, **same)
    return with_rim(SpatialJoint(i, i + 1, face, bed, f"{key}.joint", above, below))


def _level(face: FaceShape, height: float, way: float) -> Face:
    axes, centre = np.diag([1.0, way, way]), np.array([0.0, 0.0, height])
    if is_round(face.section):
        return Face(centre, axes, np.empty((0, 2)), 0.5 * face.width, 0.5 * face.bore)
    return Face(centre, axes, rectangle(face.width, face.depth))


def column_of(structure: Structure) -> Column | None:
    """Return the column whose stack (`Structure.stack`) is this structure; None if there is none.

    The structure must consist of boxes or drums, each centred on the one below, without ties, bearings, neighbours,
    bonds or ports. A structure is elastic along its joints and a column is rigid: a run of the column neglects that.
    The axis of the column is that of the lowest block, wherever it stands.
    """
    # blocks from the top, each on one joint to the next block
    order = np.argsort([-float(block.centroid[2]) for block in structure.blocks], kind="stable")
    solids = [structure.blocks[i] for i in order]
    under = {joint.carried(structure.n): joint for joint in structure.joints}
    if structure.ties or structure.bearings or structure.neighbours or structure.bonds or structure.ports:
        return None
    if not len(under) == len(structure.joints) == structure.n:
        return None
    joints = [under[i] for i in order]
    lowers = [*order[1:], structure.n]
    if any(joint.carrier(structure.n) != lower for joint, lower in zip(joints, lowers, strict=True)):
        return None
    # shift the axis of the lowest block to the origin
    by = np.append(-solids[-1].centroid[:2], 0.0)
    solids = [placed(solid, by, np.eye(3)) for solid in solids]
    joints = [replace(joint, face=replace(joint.face, centre=joint.face.centre + by)) for joint in joints]
    # build the column and compare its stack with the structure
    settings = Settings(tolerance=structure.tolerance, without=structure.without)
    try:
        blocks = tuple(_block(solid, joint) for solid, joint in zip(solids, joints, strict=True))
        column = Column(structure.name, blocks, settings, structure.g)
        again = stacked(column)
    except (InputError, IndexError):  # neither boxes nor drums, or outside the limits of a column
        return None
    same = all(map(_same_solid, again["blocks"], solids))
    same = same and all(_same_face(a.face, b.face) for a, b in zip(again["joints"], joints, strict=True))
    return column if same else None


def highest_alone(structure: Structure) -> list[Column]:
    """Return each box or drum that carries nothing as a column of one block, along x, then along y; drums once.

    Blocks on several joints, and those that are neither boxes nor drums, are left out.
    """
    joints_of = Counter(number for joint in structure.joints for number in (joint.upper, joint.lower))
    columns: list[Column] = []
    for joint in structure.joints:
        carried, is_level = joint.carried(structure.n), abs(joint.face.normal[2]) >= 1.0 - CLOSE
        solid = structure.blocks[carried]
        if joints_of[carried] > 1 or joint.bearing is not None or not is_level:
            continue
        with suppress(InputError, IndexError):  # of blocks without faces or sizes of a column
            block = _block(solid, joint)
            if _same(block.volume, solid.volume, solid.volume):  # else neither box nor drum
                column = Column(solid.name, (block,), Settings(), structure.g)
                columns += [column] if column.is_alike_across else [column, column.across()]
    return columns


def _block(solid: Solid, joint: SpatialJoint) -> planar.Block:
    """Return the column block of a box or a drum; its faces are bottom and top first (shapes.py)."""
    bottom, top = solid.faces[:2]
    section, width, depth, bore = _section(bottom)
    _, top_width, top_depth, _ = _section(top)
    bed, foot = joint.bed, float(bottom.centre[2])
    dowel, strength = bed.dowel or None, bed.strength
    law = planar.Joint(bed.stiffness, bed.damping, friction=bed.friction, dowel=dowel, strength=strength, rim=bed.rim)
    # the section of the joint, where it differs from that of the block
    contact, *sizes = _section(joint.face)
    own = (width, depth, bore)
    if contact != section or any(abs((a or 0.0) - (b or 0.0)) > CLOSE * width for a, b in zip(sizes, own, strict=True)):
        round_ = contact != "rectangle"
        law = replace(law, section=contact, width=sizes[0], depth=None if round_ else sizes[1], bore=sizes[2])
    return planar.Block(
        height=float(top.centre[2]) - foot,
        width=width,
        depth=depth,
        mass=solid.mass,
        joint=law,
        centroid=float(solid.centroid[2]) - foot,
        inertia=float(solid.inertia[1, 1]),
        section=section,
        top_width=None if top_width == width else top_width,
        top_depth=None if top_depth == depth else top_depth,
        bore=bore,
    )


def _section(face: Face) -> tuple[str, float, float, float | None]:
    """Return section, width, depth and bore of a horizontal face in the terms of a column (m)."""
    if face.radius:
        wide, bore = 2.0 * face.radius, 2.0 * face.bore
        return ("annulus" if bore else "circle"), wide, wide, bore or None
    width, depth = np.ptp(face.points(), axis=0)[:2]
    return "rectangle", float(width), float(depth), None


def _same(one: FloatArray | float, other: FloatArray | float, size: float) -> bool:
    return np.shape(one) == np.shape(other) and bool(np.all(np.abs(np.subtract(one, other)) <= CLOSE * size))


def _same_solid(one: Solid, other: Solid) -> bool:
    return (
        _same(one.mass, other.mass, other.mass)
        and _same(one.centroid, other.centroid, float(np.max(other.corners[:, 2])))
        and _same(one.inertia, other.inertia, float(np.max(other.inertia)))
        and all(_same_face(a, b) for a, b in zip(one.faces[:2], other.faces[:2], strict=True))
    )


def _same_face(one: Face, other: Face) -> bool:
    size = max(other.size, abs(float(other.centre[2])))
    return (
        _same(one.centre, other.centre, size)
        and _same(np.sort(one.points(), axis=0), np.sort(other.points(), axis=0), size)
        and _same(one.radius, other.radius, size)
        and _same(one.bore, other.bore, size)
    )
