"""The comparison with programs for rigid blocks: truths, this solver's answers, other programs where installed."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from support.fmus import ROOT

sys.path.insert(0, str(ROOT))  # the benchmarks are not installed

from benchmarks import peer_programs, peers, report, rigid_blocks
from benchmarks.rigid_blocks import Shaking

pytestmark = pytest.mark.long  # runs the benchmarks

ROWS = 0.01 * np.arange(401, dtype=np.float64)
RATIO = 0.379  # mass of the beam over that of both columns


def rigid_frame(level: float) -> np.ndarray:
    rocker = rigid_blocks.frame(0.9, 4.0, 3.9 * 0.7 / (2.0 * 0.9 * 4.0))
    return rigid_blocks.displacement(rocker, rigid_blocks.follow(rocker, Shaking(level, 1.0, 4.0), ROWS))


def test_rigid_rocking_has_its_known_boundaries_and_peaks() -> None:
    """Compare with figures found by other integrations, at g = 9.81 m/s2."""
    block, frame = rigid_blocks.block(0.4, 1.6), rigid_blocks.frame(0.9, 4.0, RATIO)
    assert block.restitution == pytest.approx(0.9118, abs=5e-5)
    assert frame.restitution == pytest.approx(0.9149, abs=5e-5)
    block = block._replace(p=block.p * math.sqrt(9.81 / 9.80665))
    for bracket, known in zip(peers.BOUNDARIES, (0.35925, 1.1291, 1.4157), strict=True):
        found = peers.boundary(
            lambda level: rigid_blocks.falls(block, Shaking(level, 1.0, 1.0, 0.5 * math.pi), 5.0), *bracket
        )
        assert found == pytest.approx(known, abs=2e-4)
    for level, peak in ((0.3, 0.2716), (0.4, 0.4685)):
        assert np.max(np.abs(rigid_frame(level))) == pytest.approx(peak, rel=1e-3)


def test_a_rigid_block_let_go_returns_in_housners_quarter_period() -> None:
    """Check that it is struck by a pulse so short that it only sets it in motion: upright again after twice the
    quarter.
    """
    block = rigid_blocks.block(0.4, 1.6)
    strike = Shaking(40.0, 1e-6, 2e-3, 0.5 * math.pi)
    rows = 1e-3 * np.arange(1500, dtype=np.float64)
    theta = rigid_blocks.follow(block, strike, rows)
    largest = int(np.argmax(np.abs(theta)))
    back = largest + int(np.argmax(np.sign(theta[largest:]) != np.sign(theta[largest])))
    quarter = math.acosh(1.0 / (1.0 - abs(theta[largest]) / block.slenderness)) / block.p
    assert 1e-3 * (back - largest) == pytest.approx(quarter, abs=3e-3)  # slender blocks: sin x = x


def test_this_solver_with_rims_and_the_arch() -> None:
    course = peers.here(peers.frame_scene(0.4), 1e-3, "rim", peers.RIGID, deep=peers.DEEP)
    assert np.max(np.abs(course.x)) == pytest.approx(np.max(np.abs(rigid_frame(0.4))), rel=5e-3)  # measured 2.5e-4
    assert peers.arch_truth() == pytest.approx(0.37361, abs=5e-6)
    assert peers.arch_here(1e13, 1e-2) == pytest.approx(0.37361, rel=0.012)  # measured 0.0099


def test_a_hit_keeps_momentum_and_energy() -> None:
    width, depth, height = peers.HIT
    mass = 2500.0 * width * depth * height
    inertia = mass / 12.0 * np.array([depth**2 + height**2, width**2 + height**2, width**2 + depth**2])
    before, after, _ = peers.hit_here(1e-4)
    moved, turned, energy = peers._kept(mass, inertia, before, after)
    assert abs(after[1, 5]) < 1e-9 < abs(after[1, 8])  # m/s up, rad/s about z: it has been hit off its middle
    assert max(moved, turned) <= 1e-13
    assert abs(energy) <= 1e-8


@pytest.mark.parametrize("name", ["MuJoCo", "LMGC90"])
def test_other_programs_find_the_rigid_frame(name: str) -> None:
    if name in peer_programs.missing():
        pytest.skip(f"{name}: {peer_programs.missing()[name]}")
    run = {"MuJoCo": peer_programs.by_mujoco, "LMGC90": peer_programs.by_lmgc90}[name]
    course = run(peers.frame_scene(0.3), 1e-3)
    known = rigid_frame(0.3)
    assert np.max(np.abs(course.x - known)) <= 0.08 * np.max(np.abs(known))  # measured 0.052, 0.019


def test_programs_that_are_not_installed_are_said_in_a_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peer_programs, "find_spec", lambda package: None)
    names = [way.name for way in peers.programs(True, True, (1e9,), (1e9,))]
    assert all(name.startswith("here") for name in names)
    table = next(peers.measure(True, {}))
    assert "not installed (extra peers)" in report.table(table.head, table.rows)
