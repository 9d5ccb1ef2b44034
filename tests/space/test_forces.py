"""Forces of joints in rows and peaks: their errors at loose tolerances, against runs at a close one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.fmus import ROOT
from support.probe import G
from support.structures import run, stack

from solver import simulate
from solver.ground.motion import Motion
from solver.models.structure.builders import colonnade
from solver.models.structure.model import Structure
from solver.models.structure.response import SpatialResponse
from solver.models.structure.rest import fastest_decay, rest_of
from solver.models.structure.run import SpatialState
from solver.models.structure.stepper import SpatialStepper

LAW = {"stiffness": 2e9, "damping": 1e-3}
KINDS = {"N": ("N",), "T": ("Tx", "Ty"), "M": ("Mx", "My"), "sigma_max": ("sigma_max",)}
SCENES = {
    "boxes": (stack(3, damping=1e-3), Motion.harmonic(0.1 * G, 1.0, 1.5, direction=0.3)),
    "drums": (stack(3, "circle", damping=1e-3), Motion.harmonic(0.08 * G, 1.5, 1.5, direction=0.3)),
    "trilith": (
        colonnade(2, 2, 3.0, 0.9, 4.0, LAW, architrave=(0.7, 0.9)),
        Motion.harmonic(0.2 * G, 1.4, 1.2, direction=0.4),
    ),
    "arch": (
        Structure.from_toml(ROOT / "examples" / "structures" / "arch.toml"),
        Motion.harmonic(0.25 * G, 1.5, 1.0, direction=0.4),
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_forces_are_as_good_as_displacements(name: str) -> None:
    """Check that rows and peaks are within ten tolerances of the largest of their kind."""
    structure, motion = SCENES[name]
    closest = simulate(structure, motion, settle=0.0, tolerance=1e-7)
    for tolerance in (1e-3, 1e-4):
        found = simulate(structure, motion, settle=0.0, tolerance=tolerance)
        for kind, names in KINDS.items():
            size = max(float(np.max(closest.peaks[one])) for one in names)
            for one in names:
                rows = float(np.max(np.abs(getattr(found, one) - getattr(closest, one))))
                peaks = float(np.max(np.abs(found.peaks[one] - closest.peaks[one])))
                assert max(rows, peaks) < 10.0 * tolerance * size, (tolerance, kind)  # measured 6, T of drums


def test_rate_at_which_the_joints_die_out() -> None:
    """Compare powers of the dampers with all eigenvalues of the matrix that they are."""
    for structure, _ in SCENES.values():
        stepper = SpatialStepper(structure)
        stepper.phase[:] = rest_of(structure).phase
        n, pace = structure.n, 1e-6
        first = 7 * n  # rates behind places and quaternions
        stepper.observe()
        still, damping = stepper.rates.copy(), np.zeros((6 * n, 6 * n))
        for k in range(6 * n):
            stepper.phase[first + k] += pace
            stepper.observe()
            damping[:, k] = (still - stepper.rates)[first : 13 * n] / pace
            stepper.phase[first + k] -= pace
        stepper.run(SCENES["boxes"][1], 0.0, 1e-6, np.zeros(0))
        fastest = float(np.max(np.linalg.eigvals(damping).real))
        assert stepper.control.decay == pytest.approx(fastest, rel=0.1)  # measured 0.035
        # with all joints in full contact, where lanes take no run that is too long: the arch is not
        assert 0.999 * fastest < fastest_decay(structure) < 3.0 * fastest


def _dropped(tilt: float, height: float, tolerance: float, g: float = G, fall: float = 0.0) -> SpatialResponse:
    """Return a run of 0.6 s of a block let go above its base, m, turned about its centroid, rad, with a speed, m/s."""
    block = {"name": "a", "on": "base", "width": 1.0, "depth": 1.0, "height": 2.0, "mass": 5000.0}
    joints = {"stiffness": 1e9, "damping": 1e-3}
    data = {"name": "dropped", "g": g, "joints": joints, "block": [block], "solver": {"tolerance": tolerance}}
    initial = SpatialState(*(np.zeros((1, 3)) for _ in range(4)))
    initial.rotation[0, 1], initial.velocity[0, 2] = tilt, -fall
    lowest = 0.5 * math.sin(abs(tilt)) + math.cos(tilt) - 1.0
    initial.displacement[0, 2] = lowest + height
    return run(Structure.from_dict(data), Motion.harmonic(0.0, 1.0, 0.6), initial=initial)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize(("g", "fall"), [(G, 0.0), (0.0, 1.4)])
def test_a_run_begins_without_forces(tolerance: float, g: float, fall: float) -> None:
    """Check that a block falls flat, but for 1e-6 rad, on a spring and a dashpot: p'' + 2 zeta omega p' + omega^2 p =
    g.
    """
    height, omega, eta = 0.1, math.sqrt(1e9 / 5000.0), 1e-3
    speed, zeta = math.sqrt(fall**2 + 2.0 * g * height), 0.5 * eta * omega
    t = np.linspace(0.0, math.pi / omega, 20001)
    fast, settled = omega * math.sqrt(1.0 - zeta**2), g / omega**2
    wave = (speed - zeta * omega * settled) / fast * np.sin(fast * t) - settled * np.cos(fast * t)
    p = settled + np.exp(-zeta * omega * t) * wave
    expected = float(np.max(1e9 * (p + eta * np.gradient(p, t))))
    response = _dropped(1e-6, height, tolerance, g, fall)
    assert response.peaks["N"][0] == pytest.approx(expected, rel=max(1e-5, tolerance))


@pytest.mark.parametrize("tilt", [0.3, 0.05])
@pytest.mark.parametrize("height", [0.1, 1e-3, 0.0])
def test_a_tilted_block_is_let_go_above_its_base(tilt: float, height: float) -> None:
    closest = _dropped(tilt, height, 1e-7)
    for tolerance in (1e-2, 1e-3, 1e-4):
        found = _dropped(tilt, height, tolerance)
        for name in ("uz", "rotation"):
            known = getattr(closest, name)
            error = float(np.max(np.abs(getattr(found, name) - known)))
            assert error <= 10.0 * tolerance * float(np.max(np.abs(known))), (name, tolerance)


@pytest.mark.long  # takes seconds
def test_peaks_with_a_kink_are_found() -> None:
    """Compare forces of an arch that rocks with rows of the same steps every 20 us."""
    rng, t = np.random.default_rng(501), np.arange(0.0, 2.0, 0.01)
    wave = np.sin(math.pi * t / 2.0) * 1.8
    ax, ay, az = (
        sum(rng.normal() * np.sin(2.0 * math.pi * f * t + rng.uniform(0.0, 6.3)) for f in (1.0, 2.0, 3.5)) * wave
        for _ in range(3)
    )
    motion = Motion.from_samples(0.01, ax, ay=0.5 * ay, az=0.2 * az)
    tolerance = 1e-4
    found = simulate(SCENES["arch"][0], motion, settle=0.0, tolerance=tolerance, output_step=2e-5)
    for kind, names in KINDS.items():
        size = max(float(np.max(found.peaks[one])) for one in names)
        for one in names:
            missed = np.max(np.abs(getattr(found, one)), axis=0) - found.peaks[one]
            assert np.max(missed) < 3.0 * tolerance * size, kind  # measured 0.2; a narrower margin missed 17
