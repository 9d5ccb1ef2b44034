"""Columns with brittle joints in motion: energy, fibres, pull-off, cohesion, what is left after a crack ran through."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.lagrange import Reference
from support.probe import G

import multiblock
from multiblock import InputError, Motion
from solver.commands.outcome import cracks
from solver.kernels.layout import spaces as at
from solver.models.column.block import Block, Joint
from solver.models.column.file import parts_from
from solver.models.column.kinematics import chain_of
from solver.models.column.model import Column
from solver.models.column.packing import InitialState
from solver.models.column.run import phase_of
from solver.models.column.settings import Settings
from solver.models.column.stepper import Stepper

Array = NDArray[np.float64]
STIFFNESS, WIDTH, DEPTH, HEIGHT, MASS = 1e9, 0.5, 0.5, 2.0, 1200.0
AREA = WIDTH * DEPTH


def block(strength: float = 0.0, **joint: Any) -> Block:
    given = {"damping": 0.0, "tensile_strength": strength, **joint}
    return Block(HEIGHT, WIDTH, DEPTH, MASS, Joint(STIFFNESS, **given))


def column(*blocks: Block, **settings: Any) -> Column:
    return Column("mortar", blocks, Settings(**{"tolerance": 1e-9, **settings}))


def advanced(stepper: Stepper, t: float, stop: float, step: float) -> float:
    """Advance in steps of a caller; returns the time."""
    count = round((stop - t) / step)
    for k in range(count):
        stepper.advance(t + k * step, step)
    return t + count * step


# --- energy


@pytest.mark.parametrize("speed", [0.3, 0.6, 0.9])
def test_what_a_motion_loses_is_what_its_cracks_take(speed: float) -> None:
    """Check that without dampers it is strength^2 / (2 stiffness) times the broken area, at every instant."""
    strength = 5e4
    stepper = Stepper(column(block(strength), block(strength)), InitialState(rotation_rate=[speed, speed]))
    chain = chain_of(stepper.column)
    begun, before, broken = chain.energy(phase_of(stepper)), 0.0, stepper.state.phase.bond_lost
    for k in range(40):
        stepper.advance(0.005 * k, 0.005)
        lost = begun - chain.energy(phase_of(stepper))
        expected = strength**2 / (2.0 * STIFFNESS) * AREA * float(broken.sum())
        assert lost == pytest.approx(expected, abs=1e-11 * begun)  # measured 1.2e-12 of it
        assert lost >= before - 1e-11 * begun
        before = lost
    assert broken.max() > 0.9
    assert broken.min() > 0.5


# --- fibres


@dataclass(frozen=True)
class Fibres(Reference):
    """A block on fibres that break one by one, for good: `whole` says which have not."""

    strength: float = 0.0
    count: int = 20_001

    def __post_init__(self) -> None:
        object.__setattr__(self, "places", ((np.arange(self.count) + 0.5) / self.count - 0.5) * self.width[0])
        object.__setattr__(self, "whole", np.ones(self.count, dtype=bool))

    def stretch(self, q: Array) -> Array:
        return -self.places * self.slopes(q)[0] + q[1]  # type: ignore[attr-defined]

    def resultants(self, q: Array, rate: Array) -> tuple[Array, Array]:
        pen = -self.stretch(q)
        whole = self.whole & (self.stiffness[0] * pen >= -self.strength)  # type: ignore[attr-defined]
        felt = self.stiffness[0] * (
            pen + self.damping[0] * (self.places * math.cos(0.5 * q[0]) * rate[0] - rate[1])  # type: ignore[attr-defined]
        )
        pressure = np.where(whole, felt, np.where(pen > 0.0, np.maximum(felt, 0.0), 0.0))
        area = self.width[0] * self.depth[0] / self.count
        return np.array([pressure.sum() * area]), np.array([(pressure * self.places).sum() * area])  # type: ignore[attr-defined]

    def remember(self, q: Array) -> None:
        self.whole[self.stiffness[0] * self.stretch(q) > self.strength] = False  # type: ignore[attr-defined]


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("damping", [0.0, 2e-4])
def test_a_block_moves_as_on_fibres_that_break_one_by_one(damping: float) -> None:
    strength, speed, step = 1e5, 0.5, 2.5e-5
    single = column(block(strength, damping=damping))
    truth = replace(Fibres(**vars(Reference.of(single))), strength=strength)
    stepper = Stepper(single, InitialState(rotation_rate=[speed]))
    q = np.array([stepper.state.phase.theta[0], stepper.state.phase.opening[0]])
    rate = np.array([speed, 0.0])
    turned, bonded = [], []
    for k in range(1600):  # Runge and Kutta's method of order 4
        slopes: list[tuple[Array, Array]] = []
        for part in (0.0, 0.5, 0.5, 1.0):
            more = (0.0, 0.0) if not slopes else slopes[-1]
            here, there = q + part * step * np.asarray(more[0]), rate + part * step * np.asarray(more[1])
            slopes.append((there, truth.accelerations(here, there)))
        weights = np.array([1.0, 2.0, 2.0, 1.0]) / 6.0
        q = q + step * sum(w * a for w, (a, _) in zip(weights, slopes, strict=True))
        rate = rate + step * sum(w * b for w, (_, b) in zip(weights, slopes, strict=True))
        truth.remember(q)
        stepper.advance(step * k, step)
        turned.append((q[0], stepper.state.phase.theta[0]))
        bonded.append((truth.whole.mean(), 1.0 - stepper.state.phase.bond_lost[0]))  # type: ignore[attr-defined]
    one, other = np.array(turned).T
    assert np.max(np.abs(one - other)) < 2e-4 * np.max(np.abs(one))
    one, other = np.array(bonded).T
    assert np.max(np.abs(one - other)) < 1e-3
    assert 0.0 < other[-1] < 0.6


# --- the whole joint at once


@pytest.mark.parametrize("turn", [0.0, 1e-16, 1e-13, 1e-10, 1e-8, 1e-6])
def test_a_uniform_pull_breaks_a_joint_at_once(turn: float) -> None:
    """Check that lifted by a base that falls, however little it is turned, a block flies off as its momentum has it."""
    strength, falls = 2e4, 80.0
    stepper = Stepper(column(block(strength)), InitialState(rotation=[turn]))
    stepper.drive(0.0, az=-falls)
    stepper.advance(0.0, 0.05)
    # a spring under a constant force, until its pull is the strength; then free
    omega = math.sqrt(STIFFNESS * AREA / MASS)
    begin, middle = -MASS * G / (STIFFNESS * AREA), MASS * (falls - G) / (STIFFNESS * AREA)
    reach = strength / STIFFNESS
    angle = math.acos((middle - reach) / (middle - begin))
    left = 0.05 - angle / omega
    speed = omega * (middle - begin) * math.sin(angle) + (falls - G) * left
    assert stepper.peaks["bond"] == [0.0]
    assert stepper.state.phase.opening_rate[0] == pytest.approx(speed, rel=1e-6)  # measured 8e-9
    assert stepper.counts.steps < 100  # measured 61 at most


def test_a_crack_that_has_run_through_leaves_a_dry_joint() -> None:
    """Check that from there on it moves to the last bit as a column without mortar in the same state."""
    bonded = column(block(5e4), without=("elastic", "implicit"))
    stepper = Stepper(bonded, InitialState(rotation_rate=[1.0]))
    t = advanced(stepper, 0.0, 0.1, 0.01)
    assert stepper.peaks["bond"] == [0.0]
    dry = Stepper(replace(bonded, blocks=(block(),)))
    dry.arrays.counts[:] = stepper.arrays.counts
    begins = at.CONTROL.beside + at.RIGID_FIELDS
    dry.arrays.state[:begins] = stepper.arrays.state[:begins]
    for each in (stepper, dry):
        advanced(each, t, 0.5, 0.01)
    for name in ("theta", "opening", "theta_rate", "opening_rate"):
        assert getattr(stepper.state.phase, name) == getattr(dry.state.phase, name)
    assert stepper.counts.steps == dry.counts.steps


def test_a_strong_joint_swings_as_its_linear_mode() -> None:
    """Check rotations beyond that at which it would open without mortar."""
    single = column(block(1e9), tolerance=1e-10)
    omega = 2.0 * math.pi * multiblock.natural_frequencies(single)[0]
    opens = 2.0 * MASS * G / (STIFFNESS * AREA * WIDTH)
    most = 3.0 * opens
    stepper = Stepper(single, InitialState(rotation_rate=[most * omega]))
    times = np.linspace(0.0, 0.999 * 10.0 / 9.0, 1001)
    snapshots = stepper.run(Motion.harmonic(1e-9, 1.0, 10.0 / 9.0), 10.0 / 9.0, times)
    theta = at.phases_in(snapshots)[:, 0]
    assert np.max(np.abs(theta)) == pytest.approx(most, rel=1e-4)
    assert theta == pytest.approx(most * np.sin(omega * times), abs=1e-5 * most)  # measured 1.4e-6
    assert stepper.peaks["bond"] == [1.0]
    assert stepper.peaks["contact"] == [1.0]


def test_results_converge_as_the_tolerance_does() -> None:
    def left(tolerance: float) -> tuple[Array, Array]:
        blocks = [block(1.5e5, damping=1e-4), block(1.5e5, damping=1e-4)]
        found = Stepper(column(*blocks, tolerance=tolerance), InitialState(rotation_rate=[0.4, 0.3]))
        advanced(found, 0.0, 0.2, 0.2)
        return np.array(found.state.phase.theta), 1.0 - np.array(found.state.phase.bond_lost)

    theta, bond = left(1e-12)
    assert np.all((bond > 0.0) & (bond < 1.0))
    size = np.max(np.abs(theta))
    for tolerance in (1e-5, 1e-7, 1e-9):
        turned, bonded = left(tolerance)
        assert turned == pytest.approx(theta, abs=0.01 * tolerance * size)  # measured 0.05 of it
        assert bonded == pytest.approx(bond, abs=0.05 * tolerance)  # measured 0.06 of it


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_a_fibre_breaks_however_little_it_is_pulled_beyond_its_strength(tolerance: float) -> None:
    """Check between the phases that a step is made of: a spring's largest stretch is known."""
    rate, omega = 0.05, math.sqrt(STIFFNESS * AREA / MASS)
    most = rate / omega - MASS * G / (STIFFNESS * AREA)
    for beyond in (1e-3, 1e-5, 1e-7, -1e-7, -1e-5):
        single = column(block(most * (1.0 - beyond) * STIFFNESS), tolerance=tolerance)
        stepper = Stepper(single, InitialState(opening_rate=[rate]))
        stepper.advance(0.0, 1.2 * math.pi / omega)
        assert (stepper.peaks["bond"] == 0.0) == (beyond > 0.0)  # so it is down to 1e-8, measured


def test_a_state_that_was_saved_within_a_crack_goes_on_to_the_last_bit() -> None:
    stepper = Stepper(column(block(5e4), block(5e4)), InitialState(rotation_rate=[0.6, 0.6]))
    stepper.advance(0.0, 0.01)
    saved = [array.copy() for array in stepper.arrays]
    assert 0.0 < stepper.state.phase.bond_lost[1] < 1.0
    ends = []
    for _ in range(2):
        for array, before in zip(stepper.arrays, saved, strict=True):
            array[:] = before
        stepper.advance(0.01, 0.05)
        ends.append(stepper.arrays.state.copy())
    assert np.array_equal(ends[0], ends[1])


# --- cohesion


def test_a_joint_slides_at_friction_and_cohesion_then_at_friction_alone() -> None:
    friction, cohesion, jerk = 0.5, 2e4, 40.0
    low = Block(
        0.5, 2.0, 1.0, 1000.0, Joint(STIFFNESS, 1e-3, friction=friction, cohesion=cohesion, tensile_strength=1e6)
    )
    stepper = Stepper(column(low, tolerance=1e-10))
    slides_at = (friction * 1000.0 * G + cohesion * 2.0) / 1000.0 / jerk  # s: mass times the acceleration of the base
    stepper.drive(0.0, jx=jerk)
    stepper.advance(0.0, slides_at - 1e-3)
    assert stepper.peaks["bond"] == [1.0]
    assert stepper.peaks["slip"] == [0.0]
    row = at.ROW.see(stepper.observe(slides_at - 1e-3), 1).joints
    assert abs(row.T[0]) == pytest.approx(1000.0 * jerk * (slides_at - 1e-3), rel=1e-4)  # measured 2e-6
    stepper.advance(slides_at - 1e-3, 2e-3)
    assert stepper.peaks["bond"] == [0.0]
    assert stepper.state.phase.slip_rate[0] < 0.0
    row = at.ROW.see(stepper.observe(slides_at + 1e-3), 1).joints
    # pressure acts along the normal of a face that is turned by half of the joint: a part of 1e-5
    assert abs(row.T[0]) == pytest.approx(friction * row.N[0], rel=1e-4)


def test_without_strength_a_bond_breaks_where_the_joint_opens() -> None:
    """Check that a crack as wide as the joint has opened; until then it bears along itself."""
    single = column(block(0.0, cohesion=1e6, friction=0.5, damping=1e-3))
    stepper = Stepper(single, InitialState(rotation_rate=[0.3]))
    least = 1.0
    for k in range(400):
        stepper.advance(2.5e-4 * k, 2.5e-4)
        theta, opening = stepper.state.phase.theta[0], stepper.state.phase.opening[0]
        slope = 2.0 * math.sin(0.5 * abs(theta))
        pressed = min(1.0, 0.5 - opening / slope / WIDTH) if slope > 0.0 else 1.0
        least = min(least, pressed)
        bonded = 1.0 - stepper.state.phase.bond_lost[0]
        assert bonded <= pressed + 1e-9
    assert least < 0.5
    assert 1.0 - stepper.state.phase.bond_lost[0] < least + 1e-9


# --- a rest that has cracked


@pytest.mark.parametrize("strength", [0.0, 5e4, 1e5])
def test_under_an_eccentric_weight_a_column_rests_on_what_its_crack_has_left(strength: float) -> None:
    load, own, offset = 1e4, 1e3, 0.15
    over = Block(0.4, 0.1, DEPTH, load, Joint(1e13, 1e-3, offset=offset))
    under = Block(0.4, WIDTH, DEPTH, own, Joint(1e13, 1e-3, tensile_strength=strength, cohesion=1e6, friction=0.7))
    stepper = Stepper(column(over, under))
    normal, moment = (load + own) * G, load * G * offset
    # normal (width / 2 - a / 3) + strength depth a^2 / 6 = moment: the longer crack is not stable
    c, d, e = strength * DEPTH / 6.0, normal / 3.0, normal * 0.5 * WIDTH - moment
    a = 2.0 * e / (d + math.sqrt(d * d - 4.0 * c * e))
    phase = stepper.state.phase
    assert 1.0 - phase.bond_lost[1] == pytest.approx(a / WIDTH, rel=1e-4)  # measured 2e-6
    assert phase.bond_lost[0] == 0.0  # it has no mortar
    assert (phase.bond_left[1], phase.bond_right[1]) == pytest.approx((0.5 * WIDTH - a, 0.5 * WIDTH), rel=1e-4)
    stepper.advance(0.0, 0.1)
    assert stepper.peaks["slip"] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert stepper.peaks["ry"] == pytest.approx(np.abs(phase.theta), rel=1e-3)
    # a weight that the tension cannot balance
    if strength:
        with pytest.raises(InputError, match="cannot stand"):
            Stepper(column(replace(over, joint=replace(over.joint, offset=0.28)), replace(under, top_width=1.0)))


# --- what is asked of a column


@pytest.mark.parametrize(
    ("joint", "others", "message"),
    [
        ({"cohesion": 1e5}, {}, r"block\[1\].joint.cohesion = 100000.0: needs friction"),
        ({"tensile_strength": -1.0}, {}, r"block\[1\].joint.tensile_strength = -1.0: must be a tension in Pa"),
        ({"tensile_strength": 1e5}, {"formulation": "paper"}, "must be left out, or solver.formulation"),
        ({"tensile_strength": 1e5, "section": "strips", "strips": (0.5, 0.5)}, {}, "is no rectangle"),
    ],
)
def test_what_bonds_are_not_for_is_refused(joint: dict[str, Any], others: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        column(block(**joint), **others)


def test_a_file_has_mortar_and_a_run_says_what_has_cracked(tmp_path: Path) -> None:
    joint = {"stiffness": 1e9, "damping": 1e-3, "tensile_strength": 1e5}
    blocks = [{"height": HEIGHT, "width": WIDTH, "depth": DEPTH, "mass": MASS}] * 2
    read = Column(**parts_from({"name": "mortar", "joint": joint, "block": blocks}))
    assert [law.tensile_strength for law in read.laws] == [1e5, 1e5]
    assert Column.from_dict(read.to_dict()) == read
    response = multiblock.simulate(read, Motion.harmonic(2.0, 1.0, 0.25))
    (line,) = cracks(["joint 1", "joint 2"], response.peaks["bond"])
    assert re.fullmatch(r".*, and what is bonded of them: joint 2 0\.\d+", line)
    assert response.bond.shape == (len(response.time), 2)
    assert response.bond[0] == pytest.approx([1.0, 1.0], abs=0.0)
    assert np.all(np.diff(response.bond, axis=0) <= 0.0)
    assert response.bond[-1] == pytest.approx(response.peaks["bond"], abs=1e-12)
    assert response.verdict == "standing"
    response.to_csv(tmp_path / "mortar.csv")
    head = (tmp_path / "mortar.csv").read_text().splitlines()[0]
    assert "bond[2].share" in head
    table = multiblock.simulate_many([read], [Motion.harmonic(2.0, 1.0, 0.25)], keep=["least_bond", "path"])
    assert table["least_bond"][0] == pytest.approx(response.peaks["bond"], abs=0.0)


def test_mortar_goes_to_space() -> None:
    structure = column(block(2e5, cohesion=1e5, friction=0.6), block()).in_space()
    assert [(joint.bed.tensile_strength, joint.bed.cohesion) for joint in structure.joints] == [(2e5, 1e5), (0.0, 0.0)]
    assert len(structure.bonds) == 1


def test_a_dry_joint_beside_mortar_has_nothing_to_break() -> None:
    stepper = Stepper(column(block(2e4), block()), InitialState(rotation_rate=[0.3, 0.3]))
    advanced(stepper, 0.0, 0.1, 0.1)
    upper, lower = stepper.peaks["bond"]
    assert upper < 1.0 == lower
    assert stepper.peaks["contact"][1] < 1.0
