"""Stabilized steps: their stages against the polynomial of the method, their answers against steps of order 5."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.polynomial.legendre import Legendre
from support.scenes import seen
from support.structures import law_on_edge

from multiblock import Motion, Structure, simulate
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import copy
from solver.kernels.structure.attempt import evaluate_at, rate
from solver.kernels.structure.evaluate import moving
from solver.kernels.structure.layout import PHASE
from solver.kernels.structure.stabilized import LONGEST_REACH, MOST_STAGES, attempt_stabilized, stages_of
from solver.kernels.structure.watch import END, START, row
from solver.models.structure.rest import rest_of
from solver.models.structure.stepper import SpatialStepper

G = 9.80665
_phase = PHASE.over


def boxes(count: int, stiffness: float, rim: float | None, tolerance: float, **law: Any) -> Structure:
    """Return boxes of 1 x 1 x 2 m on each other, critically damped as they stand on an edge."""
    density, width, height = 2500.0, 1.0, 2.0
    size = {"width": width, "depth": width, "height": height, "density": density}
    names = ["base", *(f"b{i}" for i in range(count))]
    return Structure.from_dict(
        {
            "name": "boxes",
            "joints": {**law_on_edge(stiffness, (width, width, height), density, rim), **law},
            "block": [{"name": name, "on": on, **size} for on, name in pairwise(names)],
            "solver": {"tolerance": tolerance},
        }
    )


@from_python
def stages_over(reach):
    return stages_of(reach)


def test_steps_are_stable_over_their_reach_for_every_number_of_stages() -> None:
    """Check that the amplification a + b P(1 + w z) of real rates is at most 1, and at most 0.95 away from z = 0."""
    for reach in np.geomspace(1.0, LONGEST_REACH, 200):
        s = stages_over(float(reach))
        assert s % 2 == 1
        assert s <= MOST_STAGES
        b, w = 0.5 * (s * s + s - 2.0) / (s * (s + 1.0)), 4.0 / (s * s + s - 2.0)
        z = -np.linspace(0.0, reach, 2000)
        amplified = (1.0 - b) + b * Legendre.basis(s)(1.0 + w * z)
        assert np.max(np.abs(amplified)) <= 1.0 + 1e-12
        assert np.max(np.abs(amplified[z < -3.0]), initial=0.0) <= 0.95
        assert 0.5 * ((s - 2) ** 2 + (s - 2) - 2) < 1.1 * reach or s == 3  # no fewer stages would do


@from_python
def one_step(arrays, h, stages, found):
    """Make one stabilized step on a still base from the state of the arrays; find uz and vz of the first block."""
    scene, state = seen(arrays)
    copy(row(scene, START), state, moving(scene))
    evaluate_at(scene, -1, row(scene, START), rate(scene, 0), 0.0)
    error = attempt_stabilized(scene, -1, 0.0, h, stages)
    end = _phase(row(scene, END), scene.n)
    found[0], found[1] = end.uz[0], end.vz[0]
    return error


@pytest.mark.long  # takes 10 s and more
def test_one_step_is_the_polynomial_of_the_method_times_the_state() -> None:
    """Move a block, pressed all over, up and down: m z'' = -k A (z + eta z'), which is linear."""
    structure = boxes(1, 1e9, None, 1e-3)
    stepper = SpatialStepper(structure)
    stepper.phase[:] = rest_of(structure).phase
    bed, (block,) = structure.joints[0].bed, structure.blocks
    stiff = bed.stiffness / block.mass  # of 1 m2, 1/s2
    matrix = np.array([[0.0, 1.0], [-stiff, -stiff * bed.damping]])
    rest = float(stepper.see.uz[0])
    for stages, h in ((3, 1e-3), (5, 2e-3), (9, 5e-3)):
        stepper.phase[:] = rest_of(structure).phase
        moved = np.array([-0.3 * abs(rest), 1e-3])
        stepper.see.uz[0] += moved[0]
        stepper.see.vz[0] += moved[1]
        found = np.zeros(2)
        one_step(stepper.arrays, h, stages, found)
        b, w = 0.5 * (stages**2 + stages - 2.0) / (stages * (stages + 1.0)), 4.0 / (stages**2 + stages - 2.0)
        values, ways = np.linalg.eig(matrix * h)
        amplified = (1.0 - b) + b * Legendre.basis(stages)(1.0 + w * values)
        expected = (ways @ np.diag(amplified) @ np.linalg.inv(ways) @ moved).real
        assert found - [rest, 0.0] == pytest.approx(expected, rel=1e-9, abs=1e-9 * float(np.max(np.abs(expected))))


STIFF = {
    "a rim": (3, 1e13, 1e-3, {}),
    "a rim that slides": (3, 1e12, 1e-3, {"friction": 0.3}),
    "flat faces": (2, 5e11, None, {"friction": 0.6}),
}


@pytest.mark.parametrize("name", STIFF)
def test_answers_are_those_of_steps_of_order_5_at_a_part_of_the_work(name: str) -> None:
    """Compare over one second of a sine, in which all of them rock; errors against a run at a tolerance of 1e-7
    without.
    """
    count, stiffness, rim, law = STIFF[name]
    motion = Motion.harmonic(0.3 * G, 1.5, 1.0)
    exact = simulate(boxes(count, stiffness, rim, 1e-7, **law), motion, settle=0.0, without=["stabilized"])
    assert exact.stats["stabilized_steps"] == 0
    size, errors, work = np.max(np.abs(exact.ux)), [], []
    for tolerance in (1e-2, 1e-3, 1e-4):
        found = simulate(boxes(count, stiffness, rim, tolerance, **law), motion, settle=0.0)
        plain = simulate(boxes(count, stiffness, rim, tolerance, **law), motion, settle=0.0, without=["stabilized"])
        assert found.stats["stabilized_steps"] > 0
        errors.append(float(np.max(np.abs(found.ux - exact.ux)) / size))
        work.append(found.stats["evaluations"] / plain.stats["evaluations"])
    print("STABILIZED", name, errors, work)
    assert errors <= [1e-2, 1e-3, 1e-4]
    assert work[0] <= 0.5
    assert work[1] <= 0.8


def test_soft_structures_are_stepped_as_before() -> None:
    """Check that their steps are bounded by accuracy, so that no stabilized one is tried: equal bits."""
    structure = boxes(3, 1e9, None, 1e-5).with_settings(tolerance=1e-5)
    soft = Structure.from_dict({**structure.to_dict(), "joints": {"stiffness": 1e9, "damping": 1e-3, "friction": 0.6}})
    motion = Motion.harmonic(0.3 * G, 1.5, 2.0)
    found = [simulate(soft, motion, settle=0.0, without=without) for without in ([], ["stabilized"])]
    assert found[0].stats["stabilized_steps"] == 0
    assert np.array_equal(found[0].rows, found[1].rows)


def test_equal_bits_twice_and_less_energy_after_each_impact() -> None:
    """Let go leaning, without friction that could lose any: dashpots alone do, and never give."""
    structure = boxes(2, 1e12, 1e-3, 1e-4)
    motion = Motion.from_samples(0.01, np.concatenate([0.4 * G * np.sin(np.linspace(0.0, math.pi, 51)), np.zeros(150)]))
    one, other = (simulate(structure, motion, settle=0.0) for _ in range(2))
    assert one.stats["stabilized_steps"] > 0
    assert np.array_equal(one.rows, other.rows)
    still = one.time > 0.51
    energy = one.energy[still]
    assert np.max(energy - np.minimum.accumulate(energy)) <= 1e-4 * float(np.max(energy) - np.min(energy))


def test_a_gap_that_closes_in_a_stabilized_step_is_met_by_one() -> None:
    """Shake two boxes on stiff rims against a wall 20 mm away; made again by a step of order 5, far beyond its
    stability, such a step gave 4.04 times the largest N and 7.7 times the pressure.
    """
    motion = Motion.harmonic(0.3 * G, 1.5, 1.0)
    data = boxes(2, 1e13, 1e-3, 1e-2).to_dict()
    wall = {"at": [0.52, 0.0, 0.0], "normal": [-1.0, 0.0], "width": 4.0, "height": 10.0}
    data["neighbours"] = {"stiffness": 1e8, "damping": 1e-3, "friction": 0.3, "wall": [wall]}
    structure = Structure.from_dict(data)
    right = simulate(structure, motion, settle=0.0, tolerance=1e-6, without=["stabilized"]).peaks
    found = simulate(structure, motion, settle=0.0)
    assert found.stats["stabilized_steps"] > 100
    assert np.min(found.peaks["gap"]) < 0.0
    for name in ("N", "sigma_max", "u"):  # measured 1.5 % at most
        assert np.max(found.peaks[name]) == pytest.approx(np.max(right[name]), rel=0.03), name
