"""The part of a report on the model: tables and pictures of a column, or of a structure in space."""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from ...common.digits import four_digits, three_digits
from ...common.errors import InputError
from ...models.column.block import Block
from ...models.column.contact import Contact
from ...models.column.model import Column
from ...models.column.push import WITHOUT_BONDS
from ...models.column.response import Response
from ...models.structure.blocks.parts import Solid, SpatialJoint, Tie
from ...models.structure.model import Structure
from ...models.structure.response import SpatialResponse
from ...plotting.plots import HISTORIES, plot_response
from ...plotting.structures import structure_picture
from ..check import Check
from .pictures import column_picture


class Sheet(NamedTuple):
    """A table of texts: headings and rows; columns from index `numbers` on are aligned right."""

    headings: tuple[str, ...]
    rows: list[tuple[str, ...]]
    numbers: int = 2


class ModelSection(NamedTuple):
    """The part of a report on the model: a sentence, tables and pictures."""

    sentence: str
    sheets: list[Sheet]
    picture: Figure
    histories: Figure


@singledispatch
def shown_of(model: Any, check: Check, run: Any) -> ModelSection:
    """Return the tables and pictures of a model and of its governing run, as registered for its class.

    Raises InputError if none is.
    """
    raise InputError(f"report: a {model.kind.word} has none, shown_of.register (checks/report/model.py) adds it")


@shown_of.register
def _column(model: Column, check: Check, run: Response) -> ModelSection:
    push = ""
    if check.by_hand:
        dry = f" ({WITHOUT_BONDS})" if model.is_brittle else ""
        push = f"It balances a steady push of {check.by_hand.mechanism.alpha0:.3g} g at most{dry}. "
    title = f"{check.name} under {check.action.motions[check.governing].name}"
    return ModelSection(
        f"{push}Blocks count from the top; each has the joint under it.",
        _of_column(model),
        column_picture(model),
        plot_response(run, None, title, HISTORIES),
    )


def _of_column(column: Column) -> list[Sheet]:
    blocks = ("section", "height (m)", "width (m)", "depth (m)", "centroid (m)", "mass (kg)")
    pairs = enumerate(zip(column.blocks, column.contacts, strict=True), start=1)
    rows = merged([(str(number), *_block(block), *_contact(block, contact)) for number, (block, contact) in pairs])
    width = 1 + len(blocks)
    strengths = [
        (str(number), *_strengths(block.joint))
        for number, block in enumerate(column.blocks, start=1)
        if block.joint.is_brittle
    ]
    return [
        Sheet(("block", *blocks), [row[:width] for row in rows]),
        Sheet(("joint", *_CONTACT, *_LAW), [(row[0], *row[width:]) for row in rows]),
        *([Sheet(_MORTAR, merged(strengths), 1)] if strengths else []),
    ]


_MORTAR = ("joint", "tensile strength (MPa)", "cohesion (MPa)")


def _strengths(law: Any) -> tuple[str, str]:
    """Return the tensile strength and the cohesion of a mortar joint as texts (MPa)."""
    return three_digits(1e-6 * law.tensile_strength), three_digits(1e-6 * law.cohesion)


_CONTACT = ("contact", "width (m)", "depth (m)")
_LAW = ("modulus (GN/m³)", "damping η (s)", "friction", "strength (MPa)")


def _law(stiffness: float, damping: float, friction: float | None, strength: float | None) -> tuple[str, ...]:
    return three_digits(1e-9 * stiffness), three_digits(damping), _or_none(friction), _or_none(strength, 1e-6)


def _or_none(value: float | None, factor: float = 1.0) -> str:
    return "none" if value is None else three_digits(factor * value)


def _block(block: Block) -> tuple[str, ...]:
    """Return the texts of a block; its centroid is above its bottom face."""

    def size(bottom: float, top: float | None) -> str:
        return f"{bottom:.4g}" if top is None or top == bottom else f"{bottom:.4g}, top {top:.4g}"

    sizes = size(block.width, block.top_width), size(block.depth, block.top_depth)
    return block.section, f"{block.height:.4g}", *sizes, f"{block.resolved_centroid:.4g}", four_digits(block.mass)


def _contact(block: Block, contact: Contact) -> tuple[str, ...]:
    """Return the texts of the joint under a block."""
    joint = block.joint
    rim = f", rim {joint.rim:.4g} m" if joint.rim else ""
    section = joint.section or block.section
    if joint.strips:
        section = f"{len(joint.strips)} {section}, depth {min(joint.strips):.4g} to {max(joint.strips):.4g} m"
    sizes = f"{section}{rim}", f"{contact.width:.4g}", f"{contact.depth:.4g}"
    return *sizes, *_law(joint.stiffness, joint.damping, joint.friction, joint.strength)


def merged(rows: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Merge neighbouring rows that are equal but for the name, which becomes "1 to 5" or "left to right"."""
    found: list[tuple[str, ...]] = []
    for row in rows:
        if found and found[-1][1:] == row[1:]:
            found[-1] = (f"{found[-1][0].partition(' to ')[0]} to {row[0]}", *row[1:])
        else:
            found.append(row)
    return found


@shown_of.register
def _structure(structure: Structure, check: Check, run: SpatialResponse) -> ModelSection:
    # blocks and joints; then bearings, mortar and ties, if there are any
    sheets = [
        Sheet(
            ("block", "shape (m)", "centroid z (m)", "mass (kg)"),
            merged([_solid(block) for block in structure.blocks]),
        ),
        Sheet(
            ("joint", *_CONTACT, *_LAW),
            merged([_joint(*pair) for pair in zip(structure.joint_names, structure.joints, strict=True)]),
        ),
    ]
    if structure.bearings:
        known = ("bearing", "kind", "radius (m)", "rubber (MN/m)", "damping (kN s/m)", "lead (kN)", "allows (m)")
        pairs = zip(structure.bearing_names, structure.bearings, strict=True)
        sheets.append(Sheet(known, merged([_bearing(*pair) for pair in pairs])))
    if structure.bonds:
        laws = [(name, structure.joints[j].bed) for name, j in zip(structure.bond_names, structure.bonds, strict=True)]
        rows = [(name, *_strengths(law)) for name, law in laws]
        sheets.append(Sheet(_MORTAR, merged(rows), 1))
    if run.impacts:
        meets = "least gap (mm)", "largest force (kN)", "first contact (s)", "its energy (J)"
        sheets.append(Sheet(("neighbours, governing case", *meets), [one.texts for one in run.impacts], 1))
    if structure.ties:
        headings = ("tie", "between", "stiffness (MN/m)", "yield (kN)")
        names = (*structure.names, "base")
        ties = [_tie(number, tie, names) for number, tie in enumerate(structure.ties, start=1)]
        sheets.append(Sheet(headings, ties))
    return ModelSection(
        f"{len(structure.joints)} joints, {len(structure.ties)} ties.",
        sheets,
        structure_picture(structure),
        run.plot(),
    )


def _solid(block: Solid) -> tuple[str, ...]:
    extents: Any = np.ptp(block.corners @ block.axes, axis=0)
    round_ = [2.0 * face.radius for face in block.faces if face.radius]
    size = " x ".join(f"{length:.4g}" for length in extents)
    shape = f"diameter {max(round_):.4g}, height {extents[2]:.4g}" if round_ else size
    return block.name, shape, f"{block.centroid[2]:.4g}", four_digits(block.mass)


def _joint(name: str, joint: SpatialJoint) -> tuple[str, ...]:
    bed, face = joint.bed, joint.face
    rim = f", rim {bed.rim:.4g} m" if bed.rim else ""
    sizes = 2 * (2.0 * face.radius,) if face.radius else np.ptp(face.outline, axis=0).tolist()
    if abs(face.axes[1, 0]) > abs(face.axes[1, 1]):  # the depth is that along y
        sizes = sizes[::-1]
    contact = f"{'round' if face.radius else 'plane'}{rim}", *(f"{size:.4g}" for size in sizes)
    return name, *contact, *_law(bed.stiffness, bed.damping, bed.friction, bed.strength)


def _bearing(name: str, joint: SpatialJoint) -> tuple[str, ...]:
    bearing = joint.bearing
    assert bearing is not None
    radius = three_digits(1.0 / bearing.pendulum) if bearing.pendulum else "none"
    given = bearing.spring, bearing.dashpot, joint.bed.dowel
    shown = (_or_none(value or None, factor) for value, factor in zip(given, (1e-6, 1e-3, 1e-3), strict=True))
    return name, bearing.kind, radius, *shown, three_digits(bearing.capacity)


def _tie(number: int, tie: Tie, names: Sequence[str]) -> tuple[str, ...]:
    between = f"{names[tie.one]}, {names[tie.other]}"
    return str(number), between, three_digits(1e-6 * tie.stiffness), _or_none(tie.yield_, 1e-3)
