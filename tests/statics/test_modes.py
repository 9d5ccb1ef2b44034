"""Natural frequencies and the stability limit of central differences, beyond the reference numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.probe import phocas

from solver import Column, InputError, SolverError, natural_frequencies
from solver.models.column.stepper import Stepper
from solver.models.paper.kind import longest_stable_step


def elastic_growth(column: Column, step: float) -> float:
    """Factor by which a small elastic motion has grown after 2000 central-difference steps, unchecked."""
    stepper = Stepper(column)
    stepper.model.settings.step = step
    openings = stepper.state.phase.opening
    rest = openings.copy()
    openings *= 1.0 + 1e-6 * (-1.0) ** np.arange(column.n)
    start = np.max(np.abs(openings - rest))
    for k in range(2000):
        stepper.advance(k * step, step)
    return float(np.max(np.abs(openings - rest)) / start)


def paper(eta: float = 0.0) -> Column:
    return phocas(eta, formulation="paper", step=1e-6)


@pytest.mark.parametrize("eta", [0.0, 1e-4, 1e-3, 1e-2])
def test_central_differences_blow_up_beyond_the_stability_limit_only(eta: float) -> None:
    column = paper(eta)
    limit = longest_stable_step(column)
    assert elastic_growth(column, 0.99 * limit) < 3.0  # measured 0.94 undamped, 5e-6 and less damped
    assert elastic_growth(column, 1.02 * limit) > 100.0  # measured 1e4 and more


def test_the_limit_without_dampers_is_two_over_the_highest_circular_frequency() -> None:
    column = paper()
    highest = 2.0 * np.pi * natural_frequencies(column)[-1]
    assert longest_stable_step(column) == pytest.approx(2.0 / highest, rel=1e-9)  # measured 1e-12


def test_the_limit_does_not_need_gravity() -> None:
    column = paper()
    weightless = replace(column, g=0.0)
    assert longest_stable_step(weightless) == pytest.approx(longest_stable_step(column), rel=1e-3)  # measured 1e-6


def test_a_step_beyond_the_limit_is_refused_with_the_limit() -> None:
    column = phocas(formulation="paper", step=0.05)
    with pytest.raises(InputError, match=r"^solver\.step = 0\.05: must be at most 0\.001617 s") as caught:
        Stepper(column)
    assert "\n" not in str(caught.value)


def test_frequencies_of_a_column_that_cannot_stand_are_refused() -> None:
    column = phocas()
    soft = tuple(replace(block, joint=replace(block.joint, stiffness=1e6)) for block in column.blocks)
    with pytest.raises(SolverError, match="not stable"):
        natural_frequencies(replace(column, blocks=soft))
    with pytest.raises(InputError, match=r"^g = 0\.0"):
        natural_frequencies(replace(column, g=0.0))
