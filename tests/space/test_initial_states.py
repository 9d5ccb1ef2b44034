"""Where a run in space begins: a displaced joint that never slides or is bonded, pretensions without weight."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from multiblock import Column, InitialState, InputError, Motion, SpatialState, Structure, simulate, simulate_many
from solver.models.protocol import NoRestError

MASS, STIFFNESS, RATIO, G = 2500.0, 1e9, 0.4, 9.80665
STILL = Motion.from_samples(0.05, np.zeros(21))
SIZE = {"width": 1.0, "depth": 1.0, "height": 0.5, "mass": MASS}


def slab(**joint: float) -> Structure:
    """Return a block of 1 m2 on the base."""
    block = {"name": "slab", "on": "base", **SIZE}
    return Structure.from_dict(
        {"name": "slab", "joints": {"stiffness": STIFFNESS, "damping": 1e-3, **joint}, "block": [block]}
    )


def moved_by(slip: float) -> SpatialState:
    """Return a block at its rest under weight but for a displacement along x, m."""
    none = np.zeros((1, 3))
    return SpatialState(np.array([[slip, 0.0, -MASS * G / STIFFNESS]]), none, none, none)


@pytest.mark.parametrize("slip", [1e-6, 1e-4])
def test_a_displaced_joint_that_never_slides_is_deformed_and_springs_back(slip: float) -> None:
    """Compare with a spring: its force and energy, and after the time that damping needs the place as built."""
    found = simulate(slab(), STILL, initial=moved_by(slip), settle=0.0)
    assert abs(found.Tx[0, 0]) == pytest.approx(RATIO * STIFFNESS * slip, rel=1e-9)
    assert found.energy[0] == pytest.approx(0.5 * RATIO * STIFFNESS * slip**2, rel=1e-6)
    assert abs(found.ux[-1, 0]) < 1e-3 * slip
    assert np.all(found.slip == 0.0)


def test_a_structure_without_rest_begins_from_a_state() -> None:
    """Follow a block whose foot ends 0.05 m before its centroid: it tips, as its column without rest may.

    Energies count from the place as built: measured -1.6 J at the end, lost to the damping of the joint.
    """
    foot = {"between": ["block", "base"], "at": [0.25, 0.0, 0.0], "width": 0.4, "depth": 1.0}
    block = {"name": "block", "position": [0.0, 0.0, 0.0], **SIZE}
    law = {"stiffness": STIFFNESS, "damping": 1e-3}
    made = Structure.from_dict({"name": "over", "joints": law, "block": [block], "joint": [foot]})
    # Newton's method finds an unstable balance, or one upside down, by the last digits of the linear algebra
    with pytest.raises(NoRestError, match=r"falls without any motion|does not stand under its weight"):
        simulate(made, STILL)
    none = np.zeros((1, 3))
    found = simulate(made, STILL, initial=SpatialState(none, none, none, none))
    assert found.verdict == "overturned"
    assert found.stats["why_no_modes"] == "no rest"
    assert found.energy[0] == 0.0
    assert np.max(found.energy) == 0.0
    assert np.min(found.energy) > -2.0  # J, lost to the damper; by weight and height 1e4 J change


@pytest.mark.parametrize("raised", [1e-6, 1e-4])
def test_a_displaced_bond_that_is_pulled_is_deformed(raised: float) -> None:
    strong = slab(friction=0.6, tensile_strength=5e6, cohesion=5e6)
    none, slip = np.zeros((1, 3)), 1e-4
    found = simulate(strong, STILL, initial=SpatialState(np.array([[slip, 0.0, raised]]), none, none, none), settle=0.0)
    assert found.N[0, 0] == pytest.approx(-STIFFNESS * raised)
    assert abs(found.Tx[0, 0]) == pytest.approx(RATIO * STIFFNESS * slip)


def test_a_displaced_joint_that_is_partly_open_is_deformed() -> None:
    """Let a block stand near its edge, beside its place as built."""
    none, slip, turn = np.zeros((1, 3)), 1e-4, 1e-4
    place = np.array([[slip + 0.25 * turn, 0.0, 0.4 * turn]])
    state = SpatialState(place, np.array([[0.0, turn, 0.0]]), none, none)
    found = simulate(slab(), STILL, initial=state, settle=0.0)
    assert found.N[0, 0] > 0.0
    assert 0.05 < found.contact[0, 0] < 0.5
    assert abs(found.Tx[0, 0]) == pytest.approx(RATIO * STIFFNESS * slip, rel=1e-3)


def test_a_displaced_bond_breaks_where_it_bears_less() -> None:
    """Move a bond within its shear strength, and beyond it: then friction holds what is left of it."""
    mortar = {"friction": 0.6, "tensile_strength": 1e6, "cohesion": 5e4}
    bears = 0.6 * MASS * G + 5e4  # N
    for part in (0.9, 1.1):
        slip = part * bears / (RATIO * STIFFNESS)
        found = simulate(slab(**mortar), STILL, initial=moved_by(slip), settle=0.0)
        assert found.bond[-1, 0] == (1.0 if part < 1.0 else 0.0)
        assert (found.slip[-1, 0] > 0.0) == (part > 1.0)
    # with friction alone it has slid there
    dry = simulate(slab(friction=0.6), STILL, initial=moved_by(0.01), settle=0.0)
    assert dry.slip[-1, 0] == pytest.approx(0.01, rel=1e-3)


def test_a_column_refuses_an_initial_slip_of_a_bond() -> None:
    joint = {"stiffness": STIFFNESS, "damping": 1e-4, "friction": 0.6, "tensile_strength": 5e4, "cohesion": 5e4}
    column = Column.from_dict({"name": "slab", "joint": joint, "block": [SIZE]})
    for state in (InitialState(slip=[0.01]), InitialState(slip_rate=[0.1])):
        with pytest.raises(InputError, match=r"\[0\] = 0\.\d+: must be zero where the joint is bonded"):
            simulate(column, STILL, initial=state)


@pytest.mark.parametrize("friction", [{}, {"friction": 0.6}], ids=["sticks", "may slide"])
@pytest.mark.parametrize("g", [0.0, 1e-3])
def test_a_block_clamped_by_a_tie_begins_at_rest_with_and_without_weight(g: float, friction: dict[str, float]) -> None:
    """Compare the settlement, (pretension + weight) / (k A + K)."""
    pull, tie = 1e5, 1e6
    ends = {"from": [0.0, 0.0, 0.25], "to": [0.0, 0.0, -1.0]}
    data: dict[str, Any] = slab(**friction).to_dict() | {"g": g}
    data["tie"] = [{"between": ["slab", "base"], "stiffness": tie, "damping": 1e3, "pretension": pull, **ends}]
    clamped = Structure.from_dict(data)
    settled = -(pull + MASS * g) / (STIFFNESS + tie)
    found = simulate(clamped, STILL, settle=0.0)
    assert found.uz == pytest.approx(settled, rel=1e-9)
    assert found.peaks["N"][0] == pytest.approx(-STIFFNESS * settled, rel=1e-9)
    assert abs(found.energy[-1]) < 1e-9 * pull * abs(settled)
    assert simulate_many(clamped, STILL, keep=["peak_uz"])["peak_uz"] == pytest.approx(-settled, rel=1e-6)


def test_blocks_that_hang_by_ties_alone_are_refused() -> None:
    around = [(math.cos(a), math.sin(a)) for a in np.linspace(0.0, 5.0, 6)]
    data: dict[str, Any] = {"name": "hung", "joints": {"stiffness": STIFFNESS, "damping": 1e-4}}
    data["block"] = [{"name": "slab", "position": [0.0, 0.0, 2.0], **SIZE}]
    data["tie"] = [
        {"between": ["slab", "base"], "from": [0.5 * x, 0.5 * y, 0.2], "to": [2.0 * y, x, 5.0], "stiffness": 1e6}
        for x, y in around
    ]
    with pytest.raises(InputError, match="at least one must stand on a joint or a bearing"):
        simulate(Structure.from_dict(data), STILL)


@pytest.mark.parametrize(("drop", "damping", "most"), [(5e-3, 2e-2, 0.01), (5e-3, 5e-2, 0.01)])
def test_steps_are_bounded_by_the_dampers_after_a_landing(drop: float, damping: float, most: float) -> None:
    """Drop a block, whose dampers do not act at the start: its shear was 9 to 11 % of the largest off, once landed."""
    box = {"name": "a", "on": "base", "width": 0.4, "depth": 0.5, "height": 1.6, "density": 2400.0}
    law = {"stiffness": 1e9, "damping": damping, "friction": 0.5}
    structure = Structure.from_dict({"name": "box", "joints": law, "block": [box]})
    t, zero = 0.01 * np.arange(201), np.zeros((1, 3))
    motion = Motion.from_samples(0.01, 0.15 * 9.80665 * np.sin(2.6 * np.pi * t))
    initial = SpatialState(np.array([[0.0, 0.0, drop]]), zero, zero, zero)
    found, right = (
        simulate(structure, motion, initial=initial, settle=0.0, output_step=5e-3, tolerance=tolerance)
        for tolerance in (1e-3, 1e-8)
    )
    assert np.max(np.abs(found.Tx - right.Tx)) < most * float(np.max(right.peaks["Tx"]))  # measured 6e-4


@pytest.mark.parametrize("shape", [{}, {"bore": 0.4}])
def test_faces_that_only_touch_press_nowhere(shape: dict[str, float]) -> None:
    """Start a drum on a rim as built, with a spin and a velocity away: N was -186 to -702 N, contact below 0."""
    drum = {"name": "b", "shape": "drum", "diameter": 0.9, "height": 0.5, "density": 2500.0, "on": "base", **shape}
    law = {"stiffness": 5.7e7, "damping": 2e-4, "rim": 0.1}
    structure = Structure.from_dict({"name": "drum", "joints": law, "block": [drum]})
    zero = np.zeros((1, 3))
    initial = SpatialState(zero, zero, np.array([[0.0, 0.0, -0.16]]), np.array([[0.2, 0.3, 0.0]]))
    found = simulate(structure, Motion.from_samples(1e-3, np.zeros(3)), settle=0.0, initial=initial)
    assert found.N[0, 0] == found.contact[0, 0] == found.peaks["contact"][0] == 0.0


@pytest.mark.parametrize("ratio", [1.0, 100.0, 1e4])
def test_a_rest_is_found_however_stiff_the_joint_is_along(ratio: float) -> None:
    """Place a cube on a plane inclined by 0.02 rad, with 2.5 times the friction that it needs."""
    block = {"name": "b", "width": 1.0, "depth": 1.0, "height": 1.0, "density": 2500.0, "position": [0.0, 0.0, 0.0]}
    law = {"stiffness": 1e9, "damping": 1e-3, "friction": 0.05, "shear_ratio": ratio}
    normal = [math.sin(0.02), 0.0, math.cos(0.02)]
    joint = {"between": ["b", "base"], "at": [0.0, 0.0, 0.0], "normal": normal}
    data = {"name": "slope", "joints": law, "block": [{**block, "rotation": [0.0, 0.02, 0.0]}], "joint": [joint]}
    found = simulate(Structure.from_dict(data), STILL, settle=0.0)
    # along the mean of both faces, one of which is turned by 2.9e-6 rad on its bed
    assert found.Tx[0, 0] / found.N[0, 0] == pytest.approx(math.tan(0.02 + 1.47e-6), rel=1e-7)
