"""Convex bodies meet at any orientation: closed forms, energy and momentum of throws (theory.md section 17)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.throws import STILL, Throw, momenta, moved_to, pair_of, row_of, thrown_at_random, two_at

from multiblock import Motion, SpatialResponse, Structure, simulate
from solver.kernels.structure import layout as at

STIFFNESS = 1e9


def _energy_of_box(a: float, b: float, c: float) -> float:
    """Integrate the distance to the nearest face over a box, m4: that of the boxes left t below its faces, over t."""
    t = np.polynomial.polynomial.Polynomial([0.0, 1.0])
    volume = (a - 2.0 * t) * (b - 2.0 * t) * (c - 2.0 * t)
    return float(volume.integ()(0.5 * min(a, b, c)))


@pytest.mark.parametrize("depth", [1e-6, 1e-3, 0.1, 0.3])
def test_a_box_pressed_into_a_larger_one_stores_the_distance_to_the_nearest_face(depth: float) -> None:
    """Compare energy and force with those of the common volume, a box: at small depth they are those of a bed."""
    small, large = {"width": 0.4, "depth": 0.7, "height": 0.9}, {"width": 2.0, "depth": 2.0, "height": 2.0}
    stepper = two_at(small, large, [0.0, 0.0, 2.0 + 0.45 - depth])
    energy = stepper.observe() - two_at(small, large, [0.0, 0.0, 4.0]).observe()
    # each body has twice the modulus of the bed of both
    expected = 2.0 * STIFFNESS * _energy_of_box(0.4, 0.7, depth)
    assert energy == pytest.approx(expected, rel=1e-9)
    step = 1e-4 * depth
    slope = (_energy_of_box(0.4, 0.7, depth + step) - _energy_of_box(0.4, 0.7, depth - step)) / (2.0 * step)
    force = row_of(stepper, "hit")[0]
    assert force == pytest.approx(2.0 * STIFFNESS * slope, rel=1e-6)
    # as a bed where the depth is small
    if depth <= 1e-3:
        assert force == pytest.approx(STIFFNESS * 0.4 * 0.7 * depth, rel=2.0 * depth / 0.4 + 1e-9)
        assert row_of(stepper, "gap")[0] == pytest.approx(-depth, rel=1e-9)


def _foot(x: float, y: float) -> list[list[float]]:
    return [[x - 0.1, y - 0.1], [x + 0.1, y - 0.1], [x + 0.1, y + 0.1], [x - 0.1, y + 0.1]]


@pytest.mark.parametrize("foot", [None, _foot(0.0, 0.0), [_foot(-0.8, 0.8), _foot(0.8, -0.8)]], ids=["all", "1", "2"])
def test_neighbours_meet_the_underside_beside_feet(foot: Any) -> None:
    """Press a box into a hull from below: beside its feet nothing was solid."""
    points = [[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (0.0, 1.0)]
    large, small = (
        {"shape": "hull", "points": points, **({"foot": foot} if foot else {})},
        {"width": 0.4, "depth": 0.4, "height": 0.5},
    )
    stepper = two_at(small, large, [0.6, 0.6, -0.249])
    stepper.observe()
    assert row_of(stepper, "hit")[0] == pytest.approx(STIFFNESS * 0.16 * 1e-3, rel=0.01)  # N
    assert row_of(stepper, "gap")[0] == pytest.approx(-1e-3, rel=1e-9)


@pytest.mark.parametrize("tilt", [0.1, 0.3, 0.7])
def test_an_edge_on_a_face_is_pushed_along_the_normal_of_the_face(tilt: float) -> None:
    box = {"width": 0.6, "depth": 0.8, "height": 1.0}
    large = {"width": 4.0, "depth": 4.0, "height": 2.0}
    height = 0.5 * (0.6 * math.sin(tilt) + 1.0 * math.cos(tilt))
    stepper = two_at(box, large, [0.0, 0.0, 2.0 + height - 0.01], [0.0, tilt, 0.0])
    stepper.observe()
    begins = at.PHASE.see(stepper.rates, 2)
    assert begins.vz[0] > 1.0  # m/s2
    # measured 1e-12
    assert max(abs(begins.vx[0]), abs(begins.vy[0])) <= 1e-10 * begins.vz[0]


@pytest.mark.parametrize("velocity", [[2.0, 0.0, -0.5], [2.0, 0.0, 0.5], [-3.0, 1.0, -0.1]])
@pytest.mark.parametrize("tilt", [0.1, 0.4, 0.8])
def test_a_damped_edge_is_not_dragged_along_a_face(tilt: float, velocity: list[float]) -> None:
    """Slide the edge of a prism, which has the fewer faces, without friction."""
    prism = {"shape": "prism", "outline": [[-0.5, 0.0], [0.5, 0.0], [0.1, 0.8]], "depth": 0.6}
    large = {"width": 4.0, "depth": 4.0, "height": 2.0}
    height = 0.8 / 3.0 * math.cos(tilt) + (0.5 + 0.1 / 3.0 - 0.2 / 3.0) * math.sin(tilt)
    stepper = two_at(prism, large, [0.0, 0.0, 2.0 + height - 0.02], [0.0, tilt, 0.0], velocity, damping=0.01)
    stepper.observe()
    begins = at.PHASE.see(stepper.rates, 2)
    assert begins.vz[0] > 1.0  # m/s2
    assert max(abs(begins.vx[0]), abs(begins.vy[0])) <= 1e-10 * begins.vz[0]


@pytest.mark.parametrize("seed", range(18))
def test_damped_throws_never_gain_energy(seed: int) -> None:
    stepper = thrown_at_random(seed, 1e-7, damping=0.01).stepper
    energies = [stepper.observe()]
    for k in range(500):
        stepper.run(STILL, 0.005 * k, 0.005 * (k + 1), np.zeros(0))
        energies.append(stepper.observe())
    assert energies[-1] < 0.9 * energies[0]
    # measured 9e-16
    assert np.max(np.diff(energies)) <= 1e-14 * energies[0]


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_flat_damped_hits_have_the_restitution_asked_for(tolerance: float) -> None:
    """Let all of a face meet at one instant, at which its damped force begins."""
    rng, sizes = np.random.default_rng(5), [{"width": w, "depth": 0.8, "height": 1.0} for w in (1.0, 1.2)]
    for wanted in (0.05, 0.2, 0.5):
        made = pair_of(*sizes, tolerance=tolerance, stiffness=1e9, damping=None, restitution=wanted)
        for _ in range(8):
            gap, speed = rng.uniform(0.01, 0.3), rng.uniform(0.05, 1.0)
            places = np.array([[0.0, 0.0, 10.0], [1.1 + gap, 0.0, 10.0]])
            velocity = np.array([[speed, 0.0, 0.0], [-speed, 0.0, 0.0]])
            stepper = moved_to(made, places, np.zeros((2, 3)), velocity, np.zeros((2, 3)))
            stepper.run(STILL, 0.0, 0.5 * gap / speed + 0.1, np.zeros(0))
            left = (stepper.see.vx[1] - stepper.see.vx[0]) / (2.0 * speed)
            assert left == pytest.approx(wanted, abs=1e-3)  # measured 2e-4


@pytest.mark.parametrize("seed", range(8))
def test_the_order_of_two_damped_boxes_hardly_counts(seed: int) -> None:
    """Throw equal boxes, of which a rounding makes the first or the second one the larger, at each other."""
    rng = np.random.default_rng(seed)
    rotation, spin = rng.uniform(-2.0, 2.0, (2, 3)), rng.normal(size=(2, 3))
    places, velocity = np.array([[0.0, 0.0, 10.0], [1.6, 0.1, 10.0]]), np.array([[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]])
    after = []
    for larger in (0, 1):
        boxes = [{"width": 0.4 * (1.0 + 1e-9 * (k == larger)), "depth": 0.5, "height": 0.6} for k in range(2)]
        stepper = moved_to(pair_of(*boxes, damping=0.01), places, rotation, velocity, spin)
        stepper.run(STILL, 0.0, 0.7, np.zeros(0))
        after.append([*stepper.see.vx, *stepper.see.vy, *stepper.see.vz])
    # they meet at 4 m/s
    assert np.max(np.abs(np.array(after[0]) - [2.0, -2.0, 0.0, 0.0, 0.0, 0.0])) > 0.5
    # measured at most 4e-4
    assert np.max(np.abs(np.array(after[0]) - after[1])) <= 2e-3 * 4.0


@pytest.mark.parametrize("seed", range(10))
def test_throws_at_any_orientation_keep_energy_and_momentum(seed: int) -> None:
    assert _keeps(thrown_at_random(seed, 1e-6))


@pytest.mark.campaign
@pytest.mark.long
@pytest.mark.parametrize("first", range(0, 300, 25))
def test_three_hundred_throws_keep_energy_and_momentum(first: int) -> None:
    # of all 300 one misses and one grazes
    assert sum(_keeps(thrown_at_random(seed, 1e-6)) for seed in range(first, first + 25)) >= 24


def _keeps(throw: Throw) -> bool:
    """Check conservation between the start of a throw and 2.5 s later; return True if both bodies have hit."""
    stepper, tolerance = throw.stepper, 1e-6
    before, energy = momenta(stepper), stepper.observe()
    assert row_of(stepper, "gap")[0] > 0.0
    stepper.run(STILL, 0.0, 2.5, np.zeros(0))
    after = momenta(stepper)
    # of 0.8 m/s and about 3 t: measured 1e-14 and 2e-13 of the mass at most in 300 throws
    assert np.max(np.abs(after[0] - before[0])) <= 1e-13 * throw.mass
    assert np.max(np.abs(after[1] - before[1])) <= 1e-12 * throw.mass
    # measured at most 5e-3 of the tolerance in 300 throws
    assert abs(stepper.observe() / energy - 1.0) <= 0.1 * tolerance
    return throw.peak_hit() > 1e4  # N


def struck_across(clearance: float, gap: float | None = None) -> SpatialResponse:
    """Return the run of a box that hits a lower one, with a clearance as built (m) and perhaps a declared gap (m)."""
    sizes = {"a": (0.5, 0.6, 2.0), "b": (0.6, 0.5, 1.4)}
    blocks = [
        {"name": name, "on": "base", "at": [0.0 if name == "a" else 0.55 + clearance, 0.0], "density": 2500.0}
        | dict(zip(("width", "depth", "height"), size, strict=True))
        for name, size in sizes.items()
    ]
    pair = {"between": ["a", "b"]} | ({} if gap is None else {"gap": gap})
    law: dict[str, Any] = {"stiffness": 1e9, "damping": 0.0, "friction": 0.0, "pair": [pair]}
    joints = {"stiffness": 1e9, "damping": 2e-3}
    made = Structure.from_dict({"name": "pair", "joints": joints, "block": blocks, "neighbours": law})
    time = np.arange(0.0, 1.2, 0.01)
    ax = np.where(time < 0.755, 4.5 * np.sin(2.4 * math.pi * time) * np.minimum(1.0, time), 0.0)
    return simulate(made, Motion.from_samples(0.01, ax), settle=0.0, tolerance=1e-7)


@pytest.mark.parametrize("clearance", [0.04, 0.12, 0.005])
def test_a_declared_gap_gives_the_hit_of_a_clearance_as_built(clearance: float) -> None:
    built, declared = struck_across(0.02), struck_across(clearance, 0.02)
    assert built.peaks["hit"][0] > 5e3
    # the arm of the force differs a little: measured 3e-3 at 0.12 m
    assert declared.peaks["hit"] == pytest.approx(built.peaks["hit"], rel=5e-3)
    assert declared.impacts[0].energy == pytest.approx(built.impacts[0].energy, rel=5e-3)
    # on a still base the energy never grows
    after = declared.energy[declared.time > 0.765]
    assert np.all(np.diff(after) < 1e-6 * after[0])
