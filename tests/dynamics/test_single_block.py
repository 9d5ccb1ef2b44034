"""One block on its joint against closed-form solutions: thrown off, vibrating, and rocking as Housner's."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.probe import PHOCAS_STIFFNESS, G, monolith, settled

from solver import InitialState, Motion, natural_frequencies, simulate

FORMULATIONS = ["exact", "paper"]


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_block_on_a_falling_base_is_pushed_off_and_flies(formulation: str) -> None:
    column = monolith(formulation=formulation, tolerance=1e-10, step=1e-6)
    settlement = float(settled(column)[0])
    omega = math.sqrt(column.g / settlement)
    leaves = 0.5 * math.pi / omega  # the joint's spring unloads in a quarter of a period
    fall = Motion.from_samples(0.1, [0.0], [-column.g], hold=True)
    run = simulate(column, fall, output_step=1e-4)
    flies = run.time > leaves
    assert np.all(run.N[~flies] > 0.0)
    assert np.all(run.N[flies] == 0.0)
    rise = np.where(flies, settlement * omega * (run.time - leaves), -settlement * np.cos(omega * run.time))
    bound = 1e-10 if formulation == "exact" else 1e-6  # measured 1e-12; of central differences
    assert run.uz[:, 0] == pytest.approx(rise, abs=bound * settlement)
    assert run.stats["flight"] == pytest.approx(1.0 - leaves / 0.1, abs=1e-3)  # of the step that leaves; measured 8e-9


def linear_block(formulation: str) -> tuple[float, float]:
    """Return the circular frequencies (rocking, bouncing) of the monolith about its rest state, in closed form."""
    height, width, mass = 14.07, 1.56, 81000.0
    h, inertia = 0.5 * height, mass * (height**2 + width**2) / 12.0
    rest = -mass * G / (PHOCAS_STIFFNESS * width**2)  # opening
    bed = PHOCAS_STIFFNESS * width**4 / 12.0
    bouncing = math.sqrt(PHOCAS_STIFFNESS * width**2 / mass)
    if formulation == "exact":  # x = (h + rest / 2) theta, z = rest (1 - theta^2 / 8) + h (1 - theta^2 / 2)
        return math.sqrt((bed - mass * G * (h + 0.25 * rest)) / (inertia + mass * (h + 0.5 * rest) ** 2)), bouncing
    return math.sqrt((bed - mass * G * h) / (inertia + mass * h * (h + 0.5 * rest))), bouncing


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_single_block_vibrates_as_its_linearization_does(formulation: str) -> None:
    column = monolith(formulation=formulation, tolerance=1e-12, step=1e-6)
    rocking, bouncing = linear_block(formulation)
    frequencies = np.array([rocking, bouncing]) / (2.0 * math.pi)
    assert natural_frequencies(column) == pytest.approx(frequencies, rel=1e-11)  # measured 1e-13
    turn, lift, rest = 1e-7, 1e-3 * settled(column)[0], -settled(column)
    start = InitialState(rotation=[turn], opening=rest + lift)
    run = simulate(column, Motion.harmonic(1e-12, 1.0, 1.0), initial=start)
    assert run.ry[:, 0] == pytest.approx(turn * np.cos(rocking * run.time), abs=1e-6 * turn)  # measured 2e-8
    assert run.uz[:, 0] - rest == pytest.approx(lift * np.cos(bouncing * run.time), abs=1e-5 * lift)  # measured 6e-7
    assert run.stats["full_contact"] == 1.0


def quarter_period(stiffness: float, start: float) -> float:
    """Time from rest at a rotation of `start` rad on the edge of an elastic bed to upright, s."""
    column = monolith(stiffness, tolerance=1e-7)
    width, slope = 1.56, 2.0 * math.sin(0.5 * start)
    deepest = math.sqrt(2.0 * 81000.0 * G * slope / (stiffness * width))
    release = InitialState(rotation=[start], opening=[0.5 * width * slope - deepest])
    run = simulate(column, Motion.harmonic(1e-12, 1.0, 3.2), output_step=2e-4, initial=release)
    k = int(np.argmax(run.ry[:, 0] < 0.0))
    (t0, t1), (a, b) = run.time[k - 1 : k + 1], run.ry[k - 1 : k + 1, 0]
    return float(t0 + (t1 - t0) * a / (a - b))


@pytest.mark.parametrize(
    ("share", "rigid", "bound"),
    [  # of the rotation of no return; period of theory.md section 5, exact angles; bound of the error at 10 k
        (0.1, 0.45866, 0.012),  # measured 0.0110
        (0.25, 0.78075, 0.01),  # measured 0.0080
        (0.5, 1.29239, 0.01),  # measured 0.0077
        (0.75, 2.02456, 0.012),  # measured 0.0106
        (0.9, 2.93661, 0.021),  # measured 0.0193
    ],
)
def test_stiffer_block_rocks_more_like_housners(share: float, rigid: float, bound: float) -> None:
    errors = [quarter_period(times * PHOCAS_STIFFNESS, share * 0.110423) / rigid - 1.0 for times in (1, 10, 100)]
    # an elastic bed is late: its pressure has a width, which goes as the root of 1 / k
    assert errors[0] > errors[1] > errors[2] > 0.0
    assert errors[1] < bound
    assert errors[1] / errors[2] == pytest.approx(math.sqrt(10.0), rel=0.05)  # measured 3.17 to 3.24
