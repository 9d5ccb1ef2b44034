"""The shear of the pressure on tilted joints: the derivative of the elastic energy of a joint by its slip."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.structures import with_law

from solver.kernels.structure import layout as at
from solver.models.structure.blocks.faces import FloatArray
from solver.models.structure.model import Structure
from solver.models.structure.stepper import SpatialStepper

FIVE = ((-0.5, -0.4), (0.45, -0.35), (0.5, 0.3), (0.0, 0.5), (-0.45, 0.3))  # m, corners
BOX = {"width": 1.0, "depth": 0.8}
SHAPES: dict[str, dict[str, Any]] = {
    "box": BOX,
    "small box": {"width": 0.7, "depth": 0.75},
    "crossed box": {"width": 0.6, "depth": 1.1},
    "drum": {"shape": "drum", "diameter": 0.9},
    "small drum": {"shape": "drum", "diameter": 0.6},
    "ring": {"shape": "drum", "diameter": 0.9, "bore": 0.4},
    "small ring": {"shape": "drum", "diameter": 0.7, "bore": 0.3},
    "wide ring": {"shape": "drum", "diameter": 1.0, "bore": 0.5},
    "hull": {"shape": "hull", "points": [[x, y, z] for x, y in FIVE for z in (-0.25, 0.25)]},
}
PAIRS = (
    ("box", "base"),
    ("box", "box"),
    ("small box", "box"),
    ("box", "small box"),
    ("box", "crossed box"),
    ("hull", "box"),
    ("box", "hull"),
    ("hull", "hull"),
    ("drum", "base"),
    ("drum", "drum"),
    ("small drum", "drum"),
    ("drum", "small drum"),
    ("drum", "box"),
    ("box", "drum"),
    ("ring", "ring"),
    ("ring", "drum"),
    ("drum", "ring"),
    ("small drum", "wide ring"),
    ("small ring", "box"),
)


def two_faces(above: str, below: str, friction: float) -> SpatialStepper:
    """Return a block on another one, or on the base, hardly held along its face."""
    law = {"stiffness": 1e8, "damping": 0.0}
    low, high = ({"name": name, "density": 2400.0, **SHAPES.get(name, BOX)} for name in (below, above))
    for block in (low, high):
        block |= {} if block.get("shape") == "hull" else {"height": 0.5}
    low, high = {**low, "name": "low", "on": "base"}, {**high, "name": "high", "on": "low"}
    blocks = [{**high, "on": "base"}] if below == "base" else [low, high]
    structure = Structure.from_dict({"name": "two", "joints": {**law, "friction": 1.0}, "block": blocks})
    return SpatialStepper(with_law(structure, friction=friction, shear_ratio=1e-12))


def place(stepper: SpatialStepper, pose: FloatArray, slip: FloatArray) -> None:
    """Put the upper block, and the slip of the joint below it, m, m, rad."""
    see, i = stepper.see, stepper.structure.n - 1
    see.ux[i], see.uy[i], see.uz[i] = pose[:3]
    vector = np.sin(0.5 * np.linalg.norm(pose[3:])) * pose[3:] / np.linalg.norm(pose[3:])
    see.q0[i] = math.sqrt(1.0 - vector @ vector)
    see.q1[i], see.q2[i], see.q3[i] = vector
    stepper.slips.p1[i], stepper.slips.p2[i], stepper.slips.p3[i] = slip


def energies(stepper: SpatialStepper, pose: FloatArray, slip: FloatArray, step: float) -> FloatArray:
    """Return the negative differences of the energy over each component of the slip."""
    found = np.zeros(3)
    for k, to in enumerate(step * np.eye(3)):
        place(stepper, pose, slip + to)
        above = stepper.observe()
        place(stepper, pose, slip - to)
        found[k] = (stepper.observe() - above) / (2.0 * step)
    return found


def shear(stepper: SpatialStepper, pose: FloatArray, slip: FloatArray) -> tuple[FloatArray, float]:
    """Return the force along the joint on the upper block, N, N, and N m, and across it, N."""
    place(stepper, pose, slip)
    stepper.observe()
    m = stepper.sizes.m
    of_joint = stepper.row[6 * stepper.sizes.n :].reshape(-1)[: 9 * m].reshape(9, m)[:, m - 1]
    return np.array([-of_joint[3], -of_joint[4], -of_joint[5]]), float(of_joint[0])


def random_pose(rng: np.random.Generator, slipped: float) -> tuple[FloatArray, FloatArray]:
    """Return a tilted, sunken and twisted block, and what its slider has given way by."""
    slip = slipped * rng.normal(size=3) * (0.1, 0.1, 0.3)
    tilt = rng.normal(size=2) * 10.0 ** rng.uniform(-4.0, -0.8)
    sunk = -0.5 * abs(tilt[0]) - 10.0 ** rng.uniform(-5.0, -2.5) * rng.uniform(0.2, 1.0)
    return np.array([slip[0], slip[1], sunk, *tilt, slip[2] + 1e-12]), slip


@pytest.mark.parametrize(("above", "below"), PAIRS)
def test_a_joint_without_friction_bears_the_derivative_of_its_energy(above: str, below: str) -> None:
    smooth, rough = two_faces(above, below, 1e-12), two_faces(above, below, 1e9)
    worst, seen, rng = 0.0, 0, np.random.default_rng(5)
    for _ in range(60):
        pose, slip = random_pose(rng, 1.0)
        force, normal = shear(smooth, pose, slip)
        if normal <= 0.0:
            continue
        seen += 1
        by_energy = energies(rough, pose, slip, 1e-6)
        # about the place half-way: the joint's own slip is small, so that the middle of the contact adds nothing
        worst = max(worst, float(np.max(np.abs(force - by_energy))) / normal)
    assert seen >= 30
    assert worst <= 2e-6  # measured 4e-7, of differences


@pytest.mark.parametrize("shape", ["box", "hull", "drum", "ring"])
def test_equal_faces_have_a_derivative_for_each_way_of_slipping(shape: str) -> None:
    """Check that without a slip yet, each edge belongs to the face that the other one leaves there."""
    smooth, rough = two_faces(shape, shape, 1e-12), two_faces(shape, shape, 1e9)
    worst, seen, rng, step = 0.0, 0, np.random.default_rng(6), 1e-7
    for _ in range(60):
        pose, _ = random_pose(rng, 0.0)
        pose[:2] = 0.1 * rng.normal(size=2)
        place(rough, pose, np.zeros(3))
        before = rough.observe()
        found = at.WORK.see(rough.arrays.work, rough.sizes).resultants  # the way is that of the elastic slip
        way = np.array([found.s1[1], found.s2[1], 0.0])
        way /= np.linalg.norm(way)
        place(rough, pose, step * way)
        by_energy = (before - rough.observe()) / step
        force, normal = shear(smooth, pose, np.zeros(3))
        if normal > 0.0:
            seen += 1
            worst = max(worst, abs(float(force @ way) - by_energy) / normal)
    assert seen >= 30
    assert worst <= 1e-4, worst
