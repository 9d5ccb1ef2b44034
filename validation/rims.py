"""Faces that touch in a rim: as stiff in all as whole ones, and damped critically as their block lands on its edge."""

from __future__ import annotations

from dataclasses import replace

from multiblock import Column
from solver.statics.rocking import area_on_edge, damping_on_edge

WHOLE = 0.5  # of the width: a rim so wide leaves nothing open


def label_of(share: float) -> str:
    """Return what a rim of this part of the width is called in the answers."""
    return "whole face, critical" if share >= WHOLE else f"rim {100.0 * share:g} %"


def on_rims(column: Column, share: float, part: float = 1.0) -> Column:
    """Return the column with faces that touch in a rim along their edges alone.

    share: width of the rim over that of the face; from WHOLE on all of it touches. part: damping over the critical
    one. Each joint keeps its stiffness in N/m, so only where its faces touch and the damping change.
    """
    rims: list[float | None] = [None if share >= WHOLE else share * block.joint_width for block in column.blocks]
    rimmed = _with_joints(column, [{"rim": rim} for rim in rims])
    laws: list[dict[str, float | None]] = []
    for block, before, after in zip(column.blocks, column.contacts, rimmed.contacts, strict=True):
        stiffness = block.joint.stiffness * before.area / after.area
        solid = block.mass, block.resolved_inertia, 0.5 * block.joint_width
        damping = part * damping_on_edge(stiffness, area_on_edge(block, after), *solid)
        laws.append({"stiffness": stiffness, "damping": damping})
    return _with_joints(rimmed, laws)


def _with_joints(column: Column, changes: list[dict[str, float | None]]) -> Column:
    blocks = [
        replace(block, joint=replace(block.joint, **change))  # type: ignore[arg-type]
        for block, change in zip(column.blocks, changes, strict=True)
    ]
    return replace(column, blocks=tuple(blocks))
