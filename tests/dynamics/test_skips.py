"""Short cuts: each can be left out, each is counted, and leaving it out changes nothing beyond the tolerance.

Short cuts in the elastic phase are in test_modal.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from support.probe import G, coordinates, phocas

from solver import Column, InitialState, Motion, Response, simulate
from solver.models.column.settings import SKIPS
from solver.models.column.stepper import Stepper

TOLERANCE = 1e-5


def burst(ax: float) -> Motion:
    """Return motion from 4 s to 6 s, silence before and after, 10 s in all."""
    time = 0.01 * np.arange(1001)
    return Motion.from_samples(0.01, np.where((time > 4.0) & (time < 6.0), ax * np.sin(4.0 * np.pi * time), 0.0))


def both(name: str, column: Column, motion: Motion, duration: float | None = None) -> tuple[Response, Response]:
    """Run with a short cut and without it."""
    return simulate(column, motion, duration), simulate(column, motion, duration, without=(name,))


@pytest.mark.parametrize("part", [0.02, 0.05])
def test_rest_is_not_stepped(part: float) -> None:
    skipped, stepped = both("rest", phocas(1e-3, tolerance=TOLERANCE), burst(part * G))
    assert skipped.stats["at_rest"] == pytest.approx(0.4, abs=0.01)
    assert stepped.stats["at_rest"] == 0.0
    assert np.max(np.abs(skipped.ux - stepped.ux)) < TOLERANCE * np.max(
        stepped.peak_top_ux
    )  # measured 0.08 and 0.3 of it
    assert skipped.stats["steps"] < stepped.stats["steps"]
    assert skipped.stats["full_contact"] + skipped.stats["rocking"] + skipped.stats["flight"] == pytest.approx(1.0)


def test_column_that_has_come_to_rest_is_left_there() -> None:
    column = phocas(2e-2, tolerance=TOLERANCE)
    skipped, stepped = both("rest", column, burst(0.02 * G), 60.0)
    assert skipped.stats["at_rest"] > 0.4
    assert np.max(np.abs(skipped.ux - stepped.ux)) < TOLERANCE * np.max(stepped.peak_top_ux)


def test_only_a_column_at_rest_under_its_weight_is_left_alone() -> None:
    column = phocas(1e-3)
    for key in ("rotation", "rotation_rate", "opening_rate"):
        stepper = Stepper(column, InitialState(**{key: [1e-5] * column.n}))
        stepper.advance(0.0, 0.1)
        assert stepper.state.control.time_at_rest == 0.0
    rest = Stepper(column)
    before = coordinates(rest).copy()
    rest.advance(0.0, 5.0)
    assert rest.state.control.time_at_rest == 5.0
    assert np.array_equal(coordinates(rest), before)
    for name in ("ax", "jx", "az", "jz"):
        pushed = Stepper(column)
        pushed.drive(0.0, **{name: 1e-3})
        pushed.advance(0.0, 0.1)
        assert pushed.state.control.time_at_rest == 0.0


def test_joints_without_dashpots_need_none() -> None:
    skipped, stepped = both("dashpots", phocas(0.0, tolerance=TOLERANCE), Motion.harmonic(0.05 * G, 2.0, 1.0))
    assert skipped.stats["undamped_joints"] == 3
    assert np.max(np.abs(skipped.ux - stepped.ux)) < TOLERANCE * np.max(stepped.peak_top_ux)  # measured 1e-8
    damped = simulate(phocas(1e-3), Motion.harmonic(0.05 * G, 2.0, 0.1))
    assert damped.stats["undamped_joints"] == 0


def test_resultants_are_computed_when_they_are_read() -> None:
    later, at_once = both("resultants", phocas(1e-3), Motion.harmonic(0.05 * G, 2.0, 1.0))
    assert later.stats["observed_rows"] == 0
    assert at_once.stats["observed_rows"] == len(at_once.time)
    assert np.array_equal(later.S, at_once.S)
    assert later.stats["observed_rows"] == len(later.time)
    assert later.stats["evaluations"] == at_once.stats["evaluations"]


def test_implicit_steps_spare_a_stiff_column_most_of_its_evaluations() -> None:
    skipped, stepped = both("implicit", phocas(5e-2, tolerance=TOLERANCE), Motion.harmonic(0.2 * G, 1.5, 3.0))
    assert stepped.stats["implicit_steps"] == 0
    assert skipped.stats["implicit_steps"] > 1000
    assert skipped.stats["evaluations"] < 0.3 * stepped.stats["evaluations"]
    assert np.max(np.abs(skipped.ux - stepped.ux)) < TOLERANCE * np.max(stepped.peak_top_ux)  # measured 0.03 of it


def test_all_short_cuts_can_be_left_out_at_once() -> None:
    motion = burst(0.02 * G)
    plain = simulate(phocas(1e-3, tolerance=TOLERANCE), motion, without=SKIPS)
    usual = simulate(phocas(1e-3, tolerance=TOLERANCE), motion)
    assert plain.stats["elastic_steps"] == plain.stats["at_rest"] == 0
    assert np.max(np.abs(plain.ux - usual.ux)) < TOLERANCE * np.max(usual.peak_top_ux)
