"""A column as a structure in space."""

from __future__ import annotations

from collections.abc import Mapping
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
    is_round,
)
from ...kernels.column.sections.faces import Face as PlaneFace
from ..column.block import Block
from ..ports import Port
from .blocks.contacts import GROUND, with_rim
from .blocks.faces import Face, shared
from .blocks.parts import OF_COLUMN, Bed, Joint, Solid
from .blocks.shapes import box, drum, placed, rectangle

if TYPE_CHECKING:
    from ..column.model import Column

IN_SPACE = (RECTANGLE, CIRCLE, ANNULUS, STRIPS)  # sections with a form in space; of strips a message says more


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
    tolerance, without = column.settings.tolerance, tuple(set(column.settings.without) & {"peaks"})
    ports = tuple(Port(port.name, port.body, (port.at[0], 0.0, port.at[1])) for port in column.ports)
    found = {"name": column.name, "blocks": solids, "joints": joints, "g": column.g, "ports": ports}
    return found | {"tolerance": tolerance, "without": without, "described": {OF_COLUMN: column.to_dict()}}


def in_three(data: Mapping[str, Any]) -> dict[str, Any]:
    """Convert the ports of a column's file to those of a structure: points [x, z] of the plane become [x, 0, z]."""
    tables = data["port"]
    if not isinstance(tables, list):
        return {"port": tables}
    return {"port": [_in_three(table) if isinstance(table, Mapping) else table for table in tables]}


def _in_three(table: Mapping[str, Any]) -> Mapping[str, Any]:
    at = table.get("at")
    return {**table, "at": [at[0], 0.0, at[1]]} if isinstance(at, (list, tuple)) and len(at) == 2 else table


def _solid(name: str, block: Block, foot: float) -> Solid:
    top = block.top_width or block.width, block.top_depth or block.depth
    if is_round(block.shape[0]):
        made = drum(name, block.width, top[0], block.bore or 0.0, block.height, 1.0)
    else:
        made = box(name, (block.width, block.depth), top, block.height, 1.0)
    made = placed(made, np.array([0.0, 0.0, foot]), np.eye(3))
    inertia = made.inertia * (block.mass / made.mass)
    beyond = block.resolved_inertia - inertia[1, 1]  # of a load, or as given: the same about both horizontal axes
    inertia = inertia + np.diag([beyond, beyond, 0.0])
    centroid = np.array([0.0, 0.0, foot + block.resolved_centroid])
    return replace(made, mass=block.mass, centroid=centroid, inertia=inertia)


def _joint(column: Column, i: int, foot: float) -> Joint:
    block, key = column.blocks[i], f"block[{i + 1}]"
    if block.is_off_axis or block.joint_section == STRIPS:
        raise InputError(f"{key}: must stand on its axis, and not on strips, to be stacked in space")
    below = GROUND if i == column.n - 1 else _level(column.blocks[i + 1].top_face, foot, 1.0)
    above = _level(block.contact_face, foot, -1.0)
    face = shared(above, below)
    if face is None:
        raise InputError(f"{key}: its face and the one below do not meet")
    # law of the joint in space
    law = block.joint
    mortar = {"tensile_strength": law.tensile_strength, "cohesion": law.cohesion}
    bed = Bed(
        law.stiffness, law.damping, friction=law.friction, dowel=law.dowel or 0.0, strength=law.strength, **mortar
    )
    bed = replace(bed, rim=law.rim)
    return with_rim(Joint(i, i + 1, face, bed, f"{key}.joint", above, below))


def _level(face: PlaneFace, height: float, way: float) -> Face:
    axes, centre = np.diag([1.0, way, way]), np.array([0.0, 0.0, height])
    if is_round(face.section):
        return Face(centre, axes, np.empty((0, 2)), 0.5 * face.width, 0.5 * face.bore)
    return Face(centre, axes, rectangle(face.width, face.depth))
