"""The column that a structure is equivalent to, if any: it can run the motion in the plane x, z."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...common.errors import InputError
from ..column import block as planar
from ..column.model import Column
from ..column.settings import Settings
from .blocks.faces import Face, FloatArray
from .blocks.parts import Joint, Solid
from .model import Structure
from .stack import stacked

CLOSE = 1e-9  # relative


def column_of(structure: Structure) -> Column | None:
    """Return the column whose stack (`Structure.stack`) is this structure; None if there is none.

    The structure must consist of boxes or drums, each centred on the one below, without ties, bearings, neighbours or
    bonds. A structure is elastic along its joints and a column is rigid: a run of the column neglects that.
    """
    # blocks from the top, each on one joint to the next block
    order = np.argsort([-float(block.centroid[2]) for block in structure.blocks], kind="stable")
    solids = [structure.blocks[i] for i in order]
    under = {joint.upper: joint for joint in structure.joints}
    if structure.ties or structure.bearings or structure.neighbours or structure.bonds:
        return None
    if not len(under) == len(structure.joints) == structure.n:
        return None
    joints = [under[i] for i in order]
    lowers = [*order[1:], structure.n]
    if any(joint.lower != lower for joint, lower in zip(joints, lowers, strict=True)):
        return None
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


def _block(solid: Solid, joint: Joint) -> planar.Block:
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
