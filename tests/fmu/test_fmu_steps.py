"""Communication steps of any length: they sample the input and the output, and change nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.child import call
from support.fmus import ROOT, Fmus
from support.inside import steps

from solver import Column, Motion, simulate

STOP = 4.0


@pytest.fixture
def pulse(tmp_path: Path) -> Path:
    """A record that makes the column rock on a tenth of its base, and lets it come to rest."""
    time = 0.02 * np.arange(round(STOP / 0.02) + 1)
    ax = 2.0 * np.sin(4.0 * np.pi * time) * np.exp(-(((time - 1.5) / 0.8) ** 2))
    path = tmp_path / "pulse.csv"
    Motion.from_samples(0.02, ax).to_csv(path)
    return path


@pytest.mark.parametrize(
    ("values", "tolerance"),
    [
        ({"solver.tolerance": 1e-8}, 1e-7),  # measured 1.1e-8 at most
        ({}, 1e-4),  # at 1e-5; measured 1.2e-5 at most
        ({"solver.tolerance": 1e-8, "solver.formulation": "paper"}, 1e-6),  # measured 2e-8 at most
        # a fixed step of 1e-4 s is cut where the communication step is not a multiple; measured 3.6e-6 at most
        ({"solver.formulation": "paper", "solver.integrator": "central-difference"}, 2e-5),
    ],
)
def test_no_communication_step_changes_the_result(
    fmus: Fmus, pulse: Path, values: dict[str, float | str], tolerance: float
) -> None:
    kinds = ("1e-3", "1e-2", "0.1", "whole", "uneven", "slivers", "microseconds")
    results = call(steps.follow, fmus.damped, values | {"base.record": str(pulse)}, kinds)
    column = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml")
    settings = {key.removeprefix("solver."): value for key, value in values.items()}
    response = simulate(column, Motion.from_csv(pulse), STOP, output_step=0.01, **settings)  # type: ignore[call-overload]
    assert response.contact.min() < 0.2
    for kind, (ux, shear) in zip(kinds, results, strict=True):
        assert abs(ux - response.ux[-1, 0]) < tolerance * response.peak_ux[0], kind
        assert abs(shear - response.S[-1, 0]) < tolerance * np.max(np.abs(response.S[:, 0])), kind


def test_steps_tried_and_taken_back_leave_no_trace(fmus: Fmus, pulse: Path) -> None:
    kinds, record = ("1e-2", "uneven", "slivers"), {"base.record": str(pulse)}
    tried = call(steps.follow, fmus.damped, record, kinds, tries=True)
    assert tried == call(steps.follow, fmus.damped, record, kinds)


def test_a_held_input_does_not_mind_the_step_either(fmus: Fmus) -> None:
    values = {"base.ax": 0.7, "solver.tolerance": 1e-8}
    ends = call(steps.follow, fmus.damped, values, ("whole", "1e-2", "slivers", "microseconds"))
    whole, *others = (ux for ux, _ in ends)
    assert abs(whole) > 1e-3
    for other in others:
        assert abs(other - whole) < 1e-6 * abs(whole)
