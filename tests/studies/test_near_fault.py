"""Motions by magnitude and distance: strength, period and duration follow their relations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from solver import InputError, Motion
from solver.ground.intensity import histories, intensity
from solver.ground.motion import STANDARD_GRAVITY
from solver.studies import Shaking
from solver.studies.near_fault import (
    motion,
    pga,
    pgv,
    pgv_of_all,
    pulse_period,
    significant_duration,
)


def test_relations() -> None:
    # log A = -1.02 + 0.249 M - log r - 0.00255 r, r^2 = d^2 + 7.3^2 (Joyner and Boore 1981), by hand at M 6.5, 10 km
    assert pga(6.5, 10.0) / STANDARD_GRAVITY == pytest.approx(0.2980, rel=3e-4)
    # log V = -0.67 + 0.489 M - log r - 0.00256 r, r^2 = d^2 + 4^2, cm/s
    assert pgv_of_all(6.5, 10.0) == pytest.approx(0.2810, rel=3e-4)
    assert pgv(6.5, 10.0) == pytest.approx(0.01 * math.exp(4.46 + 2.21 - 0.58 * math.log(149.0)), rel=1e-12)
    assert pulse_period(7.0) == pytest.approx(10.0**0.6)
    assert significant_duration(7.0) == pytest.approx(10.0**1.194)


@pytest.mark.parametrize("magnitude", [5.5, 6.5, 7.5])
def test_the_pulse_alone(magnitude: float) -> None:
    """Check that with hardly any noise the velocity is the pulse's: its peak, and it ends at rest."""
    made = motion(magnitude, 10.0, 3, phase=40.0, pga_factor=1e-6, pgv_factor=1.5)
    assert intensity(made).pgv == pytest.approx(1.5 * pgv(magnitude, 10.0), rel=2e-3)  # sampled every 5 ms
    assert abs(intensity(made).final_velocity) < 2e-3 * intensity(made).pgv
    velocity = np.abs(histories(made).velocity)
    # above a tenth of the peak for the length of the bell with its 1.8 periods, but for its ends
    strong = histories(made).time[velocity > 0.1 * np.max(velocity)]
    assert 1.0 < np.ptp(strong) / pulse_period(magnitude) < 1.8


def test_the_noise_alone() -> None:
    found = [intensity(motion(6.5, 10.0, seed, pgv_factor=1e-6)) for seed in range(12)]
    assert [one.pga for one in found] == pytest.approx([pga(6.5, 10.0)] * 12, rel=1e-4)
    # 5 to 95 % of the Arias intensity, in the mean as long as the relation gives; measured 0.98
    lengths = np.mean([one.significant_duration for one in found])
    assert lengths == pytest.approx(significant_duration(6.5), rel=0.1)


def test_the_same_seed_gives_the_same_bits() -> None:
    one, same, other = (motion(6.0, 5.0, seed) for seed in (1, 1, 2))
    assert np.array_equal(one.ax, same.ax)
    assert not np.array_equal(one.ax, other.ax)


def test_in_a_study() -> None:
    numbers = {"magnitude": 7.0, "distance": 5.0, "seed": 4.0}
    for formula, velocity in (("near-fault", pgv), ("near-fault-1981", pgv_of_all)):
        made = Shaking("near", formula, numbers).base({"pga_factor": 1e-6}, unit=False)
        assert isinstance(made, Motion)
        assert intensity(made).pgv == pytest.approx(velocity(7.0, 5.0), rel=2e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"magnitude": 8.0}, "motion.magnitude = 8.0: must be a magnitude from 5.0 to 7.7"),
        ({"distance": -1.0}, "motion.distance = -1.0"),
        ({"pgv_factor": 0.0}, "motion.pgv_factor = 0.0"),
    ],
)
def test_wrong_numbers(change: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        motion(**({"magnitude": 6.0, "distance": 10.0, "seed": 1} | change))  # type: ignore[arg-type]
