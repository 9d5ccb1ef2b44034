"""Columns that several tests use: sliding, off their axis, round."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from hypothesis import reject

from solver import Block, Column, InputError, Joint, Motion, Settings
from solver.kernels.layout.spaces import MOST_STRIPS
from solver.models.column.packing import pack_model
from solver.models.column.rest import is_stable
from solver.models.column.stepper import Stepper
from support.probe import G, random_column

MU = 0.3
BLOCK = """name = "block"
[[block]]
height = 3.0
width = 1.0
depth = 1.0
mass = 7500.0
[block.joint]
stiffness = 1e9
damping = 1e-3
"""  # the file of a column
RECORDS = ("elcentro-1940-ns.AT2", "northridge-1994-arleta-360.AT2", "kobe-1995-nishi-akashi-090.AT2")


def flat_block(mu: float = MU, dowel: float | None = None, tolerance: float = 1e-8) -> Column:
    """Return one block that is too flat to rock."""
    return Column(
        "flat",
        (Block(0.5, 2.0, 1.0, 2000.0, Joint(5e8, 1e-3, friction=mu, dowel=dowel)),),
        Settings(tolerance=tolerance),
    )


def sliding_column(rng: np.random.Generator, n: int, damped: bool = True) -> Column:
    """Return a random column all of whose joints may slide, some of them with a dowel, some as wide as their blocks."""
    column = random_column(rng, n, damped=damped)
    weight = column.g * sum(block.mass for block in column.blocks)
    blocks = []
    for block in column.blocks:
        dowel = float(rng.uniform(0.0, 0.3)) * weight if rng.random() < 0.5 else None
        joint = replace(block.joint, friction=float(rng.uniform(0.1, 1.0)), dowel=dowel)
        blocks.append(replace(block, joint=replace(joint, width=None, depth=None) if rng.random() < 0.5 else joint))
    return replace(column, blocks=tuple(blocks))


def off_axis_column(rng: np.random.Generator, n: int) -> Column:
    """Return `sliding_column` with some joints without friction, blocks offset and inclined, as far as the column
    stands.
    """
    column = sliding_column(rng, n)
    values = rng.uniform(-1.0, 1.0, (n, 3)) * [0.3, 0.2, 0.2]
    sticks = rng.random(n) < 0.3
    for part in (0.5**k for k in range(40)):
        blocks = []
        for block, (offset, inclination, tilt), stuck in zip(column.blocks, part * values, sticks, strict=True):
            joint = replace(block.joint, offset=offset * block.joint_width, inclination=inclination)
            joint = replace(joint, friction=None, dowel=None) if stuck else joint
            joint = replace(joint, stiffness=1e11 + joint.stiffness)  # upright, all of them stand
            blocks.append(replace(block, joint=joint, tilt=tilt))
        made = replace(column, blocks=tuple(blocks))
        try:
            Stepper(made)
        except InputError:
            continue
        return made
    return reject()  # not even upright: hypothesis draws another one


SECTIONS = ("circle", "annulus", "rectangle")


def random_drums(rng: np.random.Generator, n: int, softest: float = 1e6) -> Column:
    """Return a random column of which every joint is a circle, an annulus or a rectangle."""
    blocks = []
    for block in random_column(rng, n, softest=softest).blocks:
        section = str(rng.choice(SECTIONS))
        width = block.joint_width if section == "rectangle" else min(block.joint_width, block.joint_depth)
        bore = rng.uniform(0.1, 0.9) * width if section == "annulus" else None
        blocks.append(replace(block, joint=replace(block.joint, width=width, section=section, bore=bore)))
    return Column("drums", tuple(blocks), g=rng.uniform(1.0, 15.0))


def rough(column: Column, rng: np.random.Generator) -> Column:
    """Return the same with friction in every joint, its blocks as round as the joints at them, or straight."""
    blocks: list[Block] = []
    for block in column.blocks:
        joint, above = replace(block.joint, friction=float(rng.uniform(0.1, 0.6))), blocks[-1].joint if blocks else None
        section, bore = "rectangle", None
        if joint.section != "rectangle" and (above is None or above.section != "rectangle") and rng.random() < 0.7:
            section = "circle"
            most = math.inf if above is None else above.bore or above.width or math.inf  # which is to touch it
            if joint.bore is not None and joint.bore < most:
                section, bore = "annulus", joint.bore
        blocks.append(replace(block, joint=joint, section=section, bore=bore))
    return replace(column, blocks=tuple(blocks))


def in_strips(column: Column, rng: np.random.Generator, part: float = 0.7) -> Column:
    """Return the column with about `part` of its joints made of strips, whose depths differ by half; some edges have
    none.
    """
    blocks: list[Block] = []
    for block in column.blocks:
        count = int(rng.integers(1, MOST_STRIPS + 1))
        depths = rng.uniform(0.5, 1.0, count) * block.joint_depth
        if count > 8:
            depths[: rng.integers(0, 2)] = depths[count - rng.integers(0, 2) :] = 0.0
        strips = replace(block.joint, section="strips", strips=tuple(depths.tolist()), depth=None, bore=None)
        if blocks and blocks[-1].joint.section == "strips":  # on straight faces: on round ones lanes do not take them
            block = replace(block, section="rectangle", bore=None)
        made = replace(block, joint=strips, section="rectangle", bore=None) if rng.random() < part else block
        blocks.append(made)
    return replace(column, blocks=tuple(blocks))


def shaken(seed: int, n: int, count: int, off_axis: bool, records: Path) -> tuple[list[Column], list[Motion]]:
    """Return damped columns of n blocks under records that make them rock or slide."""
    rng = np.random.default_rng([seed, n])
    files = [Motion.from_at2(records / name) for name in RECORDS]
    columns: list[Column] = []
    motions: list[Motion] = []
    while len(columns) < count:
        width, blocks = rng.uniform(0.8, 1.6), []
        for _ in range(n):
            height, rigid = width * rng.uniform(0.8, 3.0), off_axis and rng.random() < 0.5
            joint = Joint(
                10.0 ** rng.uniform(8.5, 9.5), 10.0 ** rng.uniform(-3.0, -2.3),
                friction=None if rigid else float(rng.uniform(0.1, 0.45)),
                offset=float(rng.uniform(-0.1, 0.1)) * width if off_axis else None,
            )  # fmt: skip
            blocks.append(Block(height, width, width, 2400.0 * height * width**2, joint))
        column = Column("random", tuple(blocks))
        try:
            pack_model(column)
        except InputError:
            continue
        if is_stable(column):
            columns.append(column)
            least = min(width / sum(b.height for b in blocks), *(b.joint.friction or 1.0 for b in blocks), 1.0)
            motions.append(files[len(columns) % 3].scaled_to(least * rng.uniform(1.0, 2.5) * G))
    return columns, motions
