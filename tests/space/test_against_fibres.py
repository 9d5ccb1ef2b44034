"""Blocks that rock and slide, in space and in the plane, against a block on vertical fibres (support/fibres.py)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from support.fibres import GRAVITY, Block, follow

from multiblock import Column, Motion, Structure, simulate

REST = 2.5  # s after the sine


class Scene(NamedTuple):
    """A block, and one sine of the ground, m/s2 and Hz."""

    block: Block
    amplitude: float
    frequency: float


class Seen(NamedTuple):
    """Largest rotation, rad, displacement of the centroid at the end, m, and whether the block has fallen."""

    largest: float
    moved: float
    fallen: bool


def scene(seed: int) -> Scene:
    """A block whose friction is near its slenderness, under a sine of 1 to 2.5 times that, so that it does both."""
    rng = np.random.default_rng(seed)
    width, slenderness = rng.uniform(0.3, 1.2), rng.uniform(0.25, 0.7)
    stiffness, damping = 10.0 ** rng.uniform(8.5, 9.5), 10.0 ** rng.uniform(-3.5, -2.7)
    friction = slenderness * rng.uniform(0.8, 1.5)
    block = Block(width, width, width / slenderness, 2500.0, stiffness, damping, friction)
    return Scene(block, slenderness * GRAVITY * rng.uniform(1.0, 2.5), rng.uniform(0.6, 2.5))


def _law(block: Block) -> dict[str, float]:
    return {"stiffness": block.stiffness, "damping": block.damping, "friction": block.friction}


def in_space(given: Scene) -> Seen:
    block, motion = given.block, Motion.harmonic(given.amplitude, given.frequency, 1.0 / given.frequency)
    size = {"width": block.width, "depth": block.depth, "height": block.height, "density": block.density}
    structure = Structure.from_dict(
        {"name": "block", "joints": _law(block), "block": [{"name": "a", "on": "base", **size}]}
    )
    found = simulate(structure, motion, motion.duration + REST, tolerance=1e-6, output_step=0.005)
    return Seen(float(np.max(np.abs(found.ry))), float(found.ux[-1, 0]), found.verdict == "overturned")


def in_plane(given: Scene) -> Seen:
    block, motion = given.block, Motion.harmonic(given.amplitude, given.frequency, 1.0 / given.frequency)
    size = {"width": block.width, "depth": block.depth, "height": block.height, "mass": block.mass}
    column = Column.from_dict({"name": "block", "joint": _law(block), "block": [size]}).with_settings(tolerance=1e-6)
    found = simulate(column, motion, motion.duration + REST, output_step=0.005)
    centroid = found.ux[-1, 0] - 0.5 * block.height * math.sin(found.theta[-1, 0])
    return Seen(float(np.max(np.abs(found.theta))), float(centroid), found.verdict == "overturned")


def on_fibres(given: Scene) -> Seen:
    found = follow(given.block, given.amplitude, given.frequency, 1.0 / given.frequency + REST)
    return Seen(found.largest, found.x, found.fallen)
