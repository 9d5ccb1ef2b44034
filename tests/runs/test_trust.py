"""The estimate of a run's error, and the time up to which a run can be trusted."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from support.probe import G, phocas

from solver import Block, Column, InputError, Joint, Motion, Response, SolverError, simulate
from solver.ground import wavelets
from solver.models.protocol import OVERTURNED, STANDING, UNDECIDED
from solver.runs.trust import AGREE, judge, with_fine_settings

MOTION = Motion.harmonic(0.05 * G, 2.0, 6.0)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-5])
def test_estimate_is_about_the_error(tolerance: float) -> None:
    column = phocas(1e-3)
    run = simulate(column, MOTION, tolerance=tolerance, check=True)
    exact = simulate(column, MOTION, tolerance=1e-11)
    error = np.max(np.abs(run.ux - exact.ux)) / np.max(exact.peak_top_ux)
    assert run.estimated_error is not None
    assert 0.5 < run.estimated_error.ux / error < 2.0  # an estimate
    assert run.estimated_error.ux < AGREE * tolerance
    peaks = np.abs(run.peak_top_ux - exact.peak_top_ux) / exact.peak_top_ux
    estimate, tiny = run.estimated_error.peaks["ux"], 5e-6 * tolerance  # at 1e-5 errors of peaks are rounding
    assert np.all(estimate >= 0.5 * peaks - tiny)  # measured 1.0 of the error at 1e-1, 0.86 to 1.15 at 1e-3
    assert np.all(estimate <= 2.0 * peaks + tiny)
    assert np.isnan(run.estimated_error.overturn_time)
    assert run.horizon == run.time[-1]
    assert run.verdict == STANDING


@pytest.mark.parametrize("pga", [0.5, 0.54, 0.56, 0.58])
def test_a_fall_after_a_tenth_of_a_second_leaves_an_estimate(pga: float) -> None:
    """Check blocks of millimetres, that fall at 0.1 s, against the same comparison up to 0.9 of the fall."""
    law = Joint(2e8, 2.5e-4)
    column = Column("model", (Block(0.03, 0.008, 0.008, 0.0048, law), Block(0.015, 0.008, 0.008, 0.0024, law)))
    run = simulate(column, wavelets.one_sine(pga * G, 5.0), check=True)
    finer = simulate(column, wavelets.one_sine(pga * G, 5.0), tolerance=0.1 * column.settings.tolerance)
    before = run.time < 0.9 * run.overturn_time
    size = np.max(np.abs(finer.ux[before]))
    error = np.max(np.abs(run.ux - finer.ux)[before]) / size
    assert run.estimated_error is not None
    assert run.estimated_error.ux == pytest.approx(error, rel=1e-6)  # measured before: 0 at 0.54 and 0.56 g
    assert error > 1e-9
    assert run.horizon is not None
    assert run.horizon >= 0.9 * run.overturn_time  # before: 0.095 s of 0.109 s at 0.5 g


def test_estimate_at_fixed_steps_is_about_the_error() -> None:
    column = phocas(1e-3, formulation="paper", step=2e-4)
    run = simulate(column, MOTION, duration=2.0, check=True)
    exact = simulate(column, MOTION, duration=2.0, step=1e-5)
    error = np.max(np.abs(run.ux - exact.ux)) / np.max(exact.peak_top_ux)
    assert run.estimated_error is not None
    assert 0.4 < run.estimated_error.ux / error < 2.5


def test_a_check_changes_nothing_else() -> None:
    column = phocas(1e-3)
    plain, checked = simulate(column, MOTION), simulate(column, MOTION, check=True)
    assert (plain.estimated_error, plain.horizon) == (None, None)
    assert np.array_equal(plain.ux, checked.ux)
    assert np.array_equal(plain.peak_top_ux, checked.peak_top_ux)
    assert plain.stats["evaluations"] == checked.stats["evaluations"]


def test_an_undamped_column_is_predictable_for_some_seconds() -> None:
    """Check theory.md section 6: perturbations grow by e in 15 to 30 ms."""
    run = simulate(phocas(), Motion.harmonic(0.1 * G, 1.0, 10.0), check=True)
    assert run.horizon is not None
    assert 0.2 < run.horizon < 6.0
    assert run.estimated_error is not None
    assert run.estimated_error.ux > 0.01
    tighter = simulate(phocas(), Motion.harmonic(0.1 * G, 1.0, 10.0), tolerance=1e-9, check=True)
    assert tighter.horizon is not None
    assert tighter.horizon < 6.0


def test_a_tolerance_that_cannot_be_tightened_is_not_checked() -> None:
    """Check columns and structures: at 1e-12 both runs of a column had the same steps, and an error of 0."""
    motion = Motion.harmonic(0.1 * G, 1.0, 0.1)
    with pytest.raises(
        InputError, match=r"^tolerance = 1e-12: must be at least 1e-11 for a run that is checked: steps"
    ):
        simulate(phocas(1e-3), motion, tolerance=1e-12, check=True)
    assert simulate(phocas(1e-3), motion, tolerance=1e-12).estimated_error is None
    run = simulate(phocas(1e-3), motion, tolerance=1e-11, check=True)
    assert run.estimated_error is not None
    assert run.estimated_error.ux > 0.0
    for damping, least in ((1e-3, "1e-11"), (0.0, "1e-08")):
        with pytest.raises(InputError, match=f"^tolerance = 1e-12: must be at least {least} for a run"):
            simulate(phocas(damping).in_space(), motion, tolerance=1e-12, check=True)


def test_no_column_is_predictable_beyond_where_the_two_runs_part() -> None:
    column = phocas()
    motion = Motion.harmonic(0.1 * G, 1.0, 6.0)
    run, closer = simulate(column, motion, check=True), simulate(with_fine_settings(column), motion)
    assert run.horizon is not None
    apart = np.max(np.abs(run.ux - closer.ux), axis=1) > AGREE * 1e-5 * np.max(np.abs(closer.ux))
    assert not np.any(apart[run.time <= run.horizon])
    assert apart[np.searchsorted(run.time, run.horizon) + 1]


# --- verdicts that differ


def judged(own: Response, other: Response | SolverError) -> Response:
    own = copy.copy(own)
    judge(own, other, own.ux, None if isinstance(other, SolverError) else other.ux)
    return own


def test_a_verdict_that_differs_is_undecided() -> None:
    column = phocas(1e-3)
    stands = simulate(column, Motion.harmonic(0.05 * G, 0.25, 12.0))
    falls = simulate(column, Motion.harmonic(0.1 * G, 0.25, 12.0))
    assert (stands.verdict, falls.verdict) == (STANDING, OVERTURNED)
    for own, other in ((stands, falls), (falls, stands)):
        found = judged(own, other)
        assert found.verdict == UNDECIDED
        assert found.overturned == own.overturned
        assert own.verdict in found.reason
        assert other.verdict in found.reason
        assert "tolerance of 1e-05" in found.reason
    assert judged(falls, falls).verdict == OVERTURNED
    assert judged(stands, stands).verdict == STANDING


def test_a_check_that_cannot_go_on_leaves_the_verdict_undecided() -> None:
    stands = simulate(phocas(1e-3), MOTION, duration=1.0)
    found = judged(stands, SolverError("after 0.5 s: the step is too small"))
    assert found.verdict == UNDECIDED
    assert "after 0.5 s" in found.reason
    assert found.estimated_error is None


def test_both_fall_a_little_apart() -> None:
    run = simulate(phocas(1e-3), Motion.harmonic(0.1 * G, 0.25, 20.0), check=True)
    assert run.verdict == OVERTURNED
    assert run.estimated_error is not None
    assert 0.0 <= run.estimated_error.overturn_time < 0.01
    assert run.estimated_error.ux < 1e-2
