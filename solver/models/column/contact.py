"""The contact under each block: its contact face within the face below, centred as built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.errors import InputError, shown
from ...kernels.column.api.entries import lay_joint
from ...kernels.column.sections.faces import (
    ENDLESS,
    FITS,
    LENS,
    RECTANGLE,
    SECTIONS,
    STRIPS,
    UNKNOWN,
    FaceShape,
    after_a_slip,
    common,
    misfit,
)
from ...kernels.column.sections.section import face
from ...kernels.layout import spaces as at
from .block import MISFITS, Block

BASE = FaceShape(float(RECTANGLE), ENDLESS, ENDLESS, 0.0)


@dataclass(frozen=True)
class Contact:
    """The contact under a block without slip; coordinates and moments are about the middle of the block."""

    section: int  # code of SECTIONS, or FRAME, ON_RING or ON_BAND (kernels/column/sections/faces.py)
    slipped: int  # the code of the section after a slip
    left: float  # m, ends along the motion
    right: float  # m
    depth: float  # m, across the motion, its maximum; the diameter of a round one
    bore: float  # m
    rim: float  # m, width of the band in which the faces touch; 0: all over
    area: float  # m2
    first: float  # m3, first moment
    second: float  # m4, second moment

    @property
    def width(self) -> float:
        """The length from end to end (m)."""
        return self.right - self.left

    @property
    def moments(self) -> tuple[float, float, float]:
        """The area (m2) and the first and second moments (m3, m4)."""
        return self.area, self.first, self.second

    def stiffness(self, modulus: float) -> float:
        """Return the stiffness in full contact (N/m) for a Winkler modulus (N/m3)."""
        return modulus * self.width * self.depth if self.section == RECTANGLE else modulus * self.area


def contacts_of(blocks: Sequence[Block]) -> tuple[Contact, ...]:
    """Return the contact under each block, from the top down; the base of the last one is unbounded."""
    return tuple(_contact(block, below) for block, below in zip(blocks, _faces_below(blocks), strict=True))


def check_contacts(blocks: Sequence[Block]) -> None:
    """Raise InputError if a contact face is larger than one of the two faces, or nothing touches."""
    for number, (block, below) in enumerate(zip(blocks, _faces_below(blocks), strict=True), start=1):
        strips, joint = block.joint.strips or (), block.joint
        is_wide, is_deep = joint.width is not None, joint.depth is not None
        if common(block.contact_face, below).section == UNKNOWN:
            section = SECTIONS[block.joint_section]
            raise InputError(
                f'block[{number}].joint.section = "{section}": its contact with the face below is unknown to `common` '
                "(solver/kernels/column/sections/faces.py)"
            )
        fault = misfit(block.contact_face, block.bottom_face, below, is_wide, is_deep, len(strips), strips)
        if fault.kind != FITS:
            name, relation = MISFITS[fault.kind]
            key = f"block[{number}].joint.{name}" + (f"[{fault.strip}]" if fault.strip >= 0 else "")
            raise InputError(f"{key} = {shown(fault.value)}: {relation} = {shown(fault.bound)} m")


def _faces_below(blocks: Sequence[Block]) -> list[FaceShape]:
    return [*(block.top_face for block in blocks[1:]), BASE]


def _contact(block: Block, below: FaceShape) -> Contact:
    """Return the contact from the kernels, or in closed form if it is a whole face."""
    own, strips = block.contact_face, block.joint.strips or ()
    shared = common(own, below)
    rim = block.joint.rim or 0.0
    if own.section != STRIPS and shared.section < LENS and not rim:
        area, second = face(*shared)
        half, slipped = 0.5 * shared.width, after_a_slip(own, below, shared.section)
        sizes = -half, half, shared.depth, shared.bore
        return Contact(int(shared.section), int(slipped), *sizes, rim, area, 0.0, second)
    model, found = np.zeros(at.MODEL.size(1)), np.zeros(3)
    lay_joint(np.array(own), np.array([*strips, 0.0]), float(len(strips)), np.array(below), rim, model, found)
    laid = at.MODEL.see(model, 1).blocks
    names = ("left", "right", "depth", "bore", "rim")
    section, slipped = int(laid.section[0]), int(laid.slipped[0])
    return Contact(section, slipped, *(float(getattr(laid, name)[0]) for name in names), *found.tolist())
