"""The contact under each block: its contact face as far as the face below reaches, middle over middle as built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.errors import InputError, shown
from ...kernels.api.entries import lay_joint
from ...kernels.layout import spaces as at
from ...kernels.sections.faces import ENDLESS, FITS, LENS, RECTANGLE, STRIPS, Face, after_a_slip, common, misfit
from ...kernels.sections.section import face
from .block import MISFITS, Block

BASE = Face(float(RECTANGLE), ENDLESS, ENDLESS, 0.0)


@dataclass(frozen=True)
class Contact:
    """The contact under a block without slip, and what of it counts; numbers about the middle of the block."""

    section: int  # code of SECTIONS, or FRAME, ON_RING or ON_BAND (kernels/sections/faces.py)
    slipped: int  # the same once there is a slip
    left: float  # m, ends along the motion
    right: float  # m
    depth: float  # m, across the motion at most; the diameter of a round one
    bore: float  # m
    rim: float  # m, in which the faces touch; 0: all over
    area: float  # m2
    first: float  # m3
    second: float  # m4

    @property
    def width(self) -> float:
        """From end to end, m."""
        return self.right - self.left

    @property
    def moments(self) -> tuple[float, float, float]:
        """Area m2 and first and second moment (m3, m4)."""
        return self.area, self.first, self.second

    def stiffness(self, modulus: float) -> float:
        """In full contact, N/m, of a joint of this Winkler modulus, N/m3."""
        return modulus * self.width * self.depth if self.section == RECTANGLE else modulus * self.area


def contacts_of(blocks: Sequence[Block]) -> tuple[Contact, ...]:
    """The contact under each block, from the top down; the last one stands on an endless base."""
    return tuple(_contact(block, below) for block, below in zip(blocks, _faces_below(blocks), strict=True))


def check_contacts(blocks: Sequence[Block]) -> None:
    """Raise InputError where a contact face is larger than the faces that meet, or nothing touches."""
    for number, (block, below) in enumerate(zip(blocks, _faces_below(blocks), strict=True), start=1):
        strips, joint = block.joint.strips or (), block.joint
        is_wide, is_deep = joint.width is not None, joint.depth is not None
        fault = misfit(block.contact_face, block.bottom_face, below, is_wide, is_deep, len(strips), strips)
        if fault.kind != FITS:
            name, relation = MISFITS[fault.kind]
            key = f"block[{number}].joint.{name}" + (f"[{fault.strip}]" if fault.strip >= 0 else "")
            raise InputError(f"{key} = {shown(fault.value)}: {relation} = {shown(fault.bound)} m")


def _faces_below(blocks: Sequence[Block]) -> list[Face]:
    return [*(block.top_face for block in blocks[1:]), BASE]


def _contact(block: Block, below: Face) -> Contact:
    """From the kernels, but for what is a whole face in closed form."""
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
