"""Friction of structures in space: its direction, its energy, and the tolerance where joints slide."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.fmus import ROOT
from support.probe import G
from support.structures import with_law

from solver import simulate
from solver.ground import wavelets
from solver.ground.motion import Motion
from solver.models.column.model import Column
from solver.models.structure.blocks.faces import FloatArray
from solver.models.structure.model import Structure
from solver.models.structure.response import SpatialResponse
from solver.models.structure.rest import rest_of
from solver.models.structure.run import SpatialState
from solver.models.structure.stepper import SpatialStepper

TRILITH = ROOT / "examples" / "structures" / "trilith.toml"


def history(response: SpatialResponse) -> FloatArray:
    """Return the displacements of all blocks, m."""
    return np.stack([response.ux, response.uy, response.uz])


def test_a_slab_on_a_base_that_circles_slides_as_newmarks_does() -> None:
    """Check that the direction of friction turns all the time; the rigid-plastic block is integrated apart."""
    block = {"name": "b", "width": 4.0, "depth": 4.0, "height": 0.2, "mass": 1000.0, "on": "base"}
    law = {"stiffness": 1e10, "damping": 1e-3, "friction": 0.3}
    structure = Structure.from_dict({"name": "slab", "joints": law, "block": [block], "solver": {"tolerance": 1e-6}})
    omega, step = 2.0 * math.pi, 1e-3
    time = np.arange(0.0, 1.0 + 0.5 * step, step)
    ax, ay = 0.5 * G * np.cos(omega * time), 0.5 * G * np.sin(omega * time)
    response = simulate(structure, Motion.from_samples(step, ax, ay=ay), duration=1.0, output_step=0.1, settle=0)

    def rate(t: float, y: FloatArray) -> FloatArray:
        """Return the rate of place and velocity over the base."""
        a = np.array([np.interp(t, time, ax), np.interp(t, time, ay)])
        return np.concatenate([y[2:], -a - 0.3 * G * y[2:] / np.hypot(*y[2:])])

    begin = [0.0, 0.0, -1e-9, 0.0]
    rigid = solve_ivp(rate, (0.0, 1.0), begin, t_eval=response.time, rtol=1e-9, atol=1e-12, max_step=step).y
    apart = np.hypot(response.ux[:, 0] - rigid[0], response.uy[:, 0] - rigid[1])
    assert np.max(apart) <= 1e-3 * np.max(np.hypot(rigid[0], rigid[1]))


# each marked one takes a second or more
@pytest.mark.parametrize("shear_damping", [1e-3, pytest.param(1e-4, marks=pytest.mark.long)])
def test_the_tolerance_is_kept_where_joints_slide(shear_damping: float) -> None:
    structure = with_law(Structure.from_toml(TRILITH), friction=0.25, shear_damping=shear_damping)
    motion = Motion.harmonic(0.35 * G, 1.4, 2.0, direction=0.4)
    finest = history(simulate(structure, motion, settle=0, tolerance=1e-9))
    size = np.max(np.abs(finest))
    for tolerance in (1e-3, 1e-5, 1e-7):
        response = simulate(structure, motion, settle=0, tolerance=tolerance)
        assert np.max(response.slip) > 0.1  # m
        # measured 0.07 to 0.3 tolerances, 0.2 to 0.6 with little damping; small differences grow to twice
        assert np.max(np.abs(history(response) - finest)) <= 10.0 * tolerance * size


@pytest.mark.parametrize("shape", [{"width": 0.5, "depth": 0.5}, {"shape": "drum", "diameter": 0.5}])
@pytest.mark.parametrize("speed", [-2.0, 2.0, 4.0])
def test_damping_does_not_feel_a_slide_on_a_smooth_floor(speed: float, shape: dict[str, float]) -> None:
    """Let a rocking block slide almost without friction: it rocks as if it did not, and its energy never grows."""
    block = {"name": "b", "on": "base", "height": 1.0, "density": 2400.0, **shape}
    law = {"stiffness": 1e9, "damping": 0.02, "friction": 1e-4}
    structure = Structure.from_dict({"name": "floor", "joints": law, "block": [block]})
    none, still = np.zeros((1, 3)), Motion.from_samples(0.2, np.zeros(3))
    runs = []
    for vx in (0.0, speed):
        begins = SpatialState(none, none, np.array([[vx, 0.0, 0.0]]), np.array([[0.0, 2.0, 0.0]]))
        runs.append(simulate(structure, still, initial=begins, tolerance=1e-6, settle=0.0, output_step=0.01))
    at_rest, slides = runs
    tilt = at_rest.rotation[:, 0, 1]
    assert np.max(np.abs(tilt)) > 0.05  # rad
    # measured 4e-3, of the friction that is left
    assert np.max(np.abs(slides.rotation[:, 0, 1] - tilt)) <= 0.01 * np.max(np.abs(tilt))
    energy = slides.energy
    assert np.max(energy - np.minimum.accumulate(energy)) <= 1e-12 * energy[0]  # measured 0


def test_friction_takes_energy() -> None:
    """Push the blocks of a trilith at random: joints slide, twist and stick, and its energy never rises."""
    structure = with_law(Structure.from_toml(TRILITH), friction=0.2).with_settings(tolerance=1e-7)
    stepper, rng = SpatialStepper(structure), np.random.default_rng(3)
    stepper.phase[:] = rest_of(structure).phase
    at_rest = stepper.observe()
    see, n = stepper.see, structure.n
    for name, size in {"vx": 0.5, "vy": 0.5, "vz": 0.1, "wx": 0.1, "wy": 0.1, "wz": 0.4}.items():
        getattr(see, name)[:] = size * rng.normal(size=n)
    energies = [stepper.observe() - at_rest]
    for k in range(200):
        stepper.run(None, 0.005 * k, 0.005 * (k + 1), np.zeros(0))
        energies.append(stepper.observe() - at_rest)
    assert np.max(np.hypot(stepper.slips.p1, stepper.slips.p2)) > 1e-3  # m
    assert np.max(np.abs(stepper.slips.p3)) > 1e-3  # rad
    assert energies[-1] < 0.1 * energies[0]
    assert np.max(np.diff(energies)) <= 1e-7 * energies[0]


def test_a_tie_that_yields_keeps_to_the_tolerance() -> None:
    """Hold a slab that slides by a rod that yields in both directions; small differences grow to five times."""
    block = {"name": "b", "width": 4.0, "depth": 4.0, "height": 0.2, "mass": 1000.0, "on": "base"}
    rod = {"between": ["b", "base"], "from": [0.0, 0.0, 0.0], "to": [6.0, 0.0, 0.1], "stiffness": 1e5, "yield": 2e3}
    data = {"name": "held", "joints": {"stiffness": 1e8, "damping": 1e-3, "friction": 0.1}, "block": [block]}
    structure = Structure.from_dict({**data, "tie": [rod]})
    motion = Motion.harmonic(0.5 * G, 1.0, 2.0)
    finest = simulate(structure, motion, settle=0, tolerance=1e-9)
    assert np.max(np.abs(finest.tie)) == pytest.approx(2e3, rel=1e-12)
    size = np.max(np.abs(finest.ux))
    for tolerance in (1e-3, 1e-5, 1e-7):
        found = simulate(structure, motion, settle=0, tolerance=tolerance)
        # measured 0.004, 0.3, 1.4 tolerances; 0.03, 2, 17 where a step can miss the kink of a tie that goes slack
        assert np.max(np.abs(found.ux - finest.ux)) <= 10.0 * tolerance * size


def test_steps_while_a_tie_yields_are_stable() -> None:
    """Hold a slab by a tie alone: steps that are bounded by their errors only let its force fall short."""
    block = {"name": "b", "width": 4.0, "depth": 4.0, "height": 0.2, "mass": 1000.0, "on": "base"}
    tie = {"between": ["b", "base"], "from": [2.0, 0.0, 0.0], "to": [6.0, 0.0, 0.1], "stiffness": 1e5, "yield": 2e3}
    law = {"stiffness": 1e8, "damping": 1e-3, "friction": 1e-4}
    data = {"name": "slab", "joints": law, "block": [block], "tie": [tie | {"tension_only": False}]}
    structure = Structure.from_dict(data)
    motion = Motion.harmonic(0.3 * G, 1.0, 2.0, direction=0.2)
    finest = history(simulate(structure, motion, settle=0, tolerance=1e-10))
    for tolerance in (1e-3, 1e-4, 1e-5):
        far = np.max(np.abs(history(simulate(structure, motion, settle=0, tolerance=tolerance)) - finest))
        # measured 6, 0.02, 0.005 tolerances; 45, 25, 40 without the bound on steps; small differences do not grow
        assert far <= 10.0 * tolerance * np.max(np.abs(finest))


def test_blocks_that_slide_along_their_sides_need_few_steps() -> None:
    """Check that rounding errors across the slip, along edges of both faces, have no force that changes its sign."""
    block = {"repeat": 3, "width": 0.5, "depth": 0.4, "height": 0.8, "density": 2000.0}
    law = {"stiffness": 4e9, "damping": 1e-5, "friction": 0.6}
    structure = Column.from_dict({"name": "stiff", "block": [block], "joint": law}).in_space()
    found = simulate(structure, wavelets.ricker(0.5 * G, 2.0), duration=1.0, settle=0.0)
    assert np.max(found.slip) > 1e-4
    assert found.stats["steps"] < 8000  # measured 5126; with a jump there 261,807
    assert np.max(np.abs(found.uy)) < 1e-12  # m: it stays in its plane


def coulomb_path(radius: float, speed: float, spin: float, friction: float) -> float:
    """Return how far a disc under uniform pressure slides by Coulomb's law at each of 9600 points, m."""
    distance, angle = np.sqrt((np.arange(80) + 0.5) / 80) * radius, 2.0 * math.pi * (np.arange(120) + 0.5) / 120
    x, y = (np.outer(distance, part(angle)).ravel() for part in (np.cos, np.sin))
    path, step = 0.0, 5e-4
    while speed > 1e-3:
        along, across = speed - spin * y, spin * x
        size = np.hypot(along, across)
        slowed = friction * G * float(np.mean(along / size))
        turned = friction * G * float(np.mean((x * across - y * along) / size)) / (0.5 * radius**2)
        path += step * (speed - 0.5 * slowed * step)
        speed, spin = speed - slowed * step, max(0.0, spin - turned * step)
    return path


def test_a_disc_that_spins_slides_as_one_that_does_not() -> None:
    """Check the figures of the limits in structures.md: friction limits sliding and twisting separately."""
    speed, spin, friction, radius, height = 1.0, 3.0, 0.3, 0.5, 0.025
    disc = {"name": "d", "shape": "drum", "diameter": 2.0 * radius, "height": height, "density": 2500.0, "on": "base"}
    law = {"stiffness": 1e10, "damping": 1e-3, "friction": friction}
    structure = Structure.from_dict({"name": "disc", "joints": law, "block": [disc], "solver": {"tolerance": 1e-6}})
    none, pressed = np.zeros((1, 3)), -2500.0 * height * G / 1e10
    moving = np.array([[speed, 0.0, 0.0]]), np.array([[0.0, 0.0, spin]])
    start = SpatialState(np.array([[0.0, 0.0, pressed]]), none, *moving)
    response = simulate(structure, Motion.from_samples(1.0, [0.0, 0.0]), initial=start, settle=0.0)
    path = float(response.ux[-1, 0])
    assert path == pytest.approx(speed**2 / (2.0 * friction * G), rel=2e-4)  # measured 1.5e-5
    assert path == pytest.approx(0.170, abs=5e-4)
    # alone the spin stops after w^2 R^2 / 2 over 4/3 of the friction's moment, 2/3 mu g R of a unit mass
    assert float(response.rz[-1, 0]) == pytest.approx(
        0.25 * (spin * radius) ** 2 / (friction * G * radius / 1.5), rel=2e-3
    )
    assert coulomb_path(radius, speed, spin, friction) == pytest.approx(0.272, abs=1e-3)
