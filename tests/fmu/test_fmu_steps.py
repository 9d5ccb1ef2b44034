"""Communication steps of any length: they sample the input and the output, and change nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.child import call, ended
from support.fmus import DAMPED, Fmus
from support.inside import steps

from solver import Column, Motion, simulate

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time

STOP = 4.0


@pytest.fixture
def pulse(tmp_path: Path) -> Path:
    """Return a record that makes the column rock on a tenth of its base, and lets it come to rest."""
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
        # paper: a fixed step of 1e-4 s is cut where the communication step is not a multiple; measured 3.6e-6 at most
        ({"solver.step": 1e-4}, 2e-5),
    ],
)
def test_no_communication_step_changes_the_result(
    fmus: Fmus, pulse: Path, values: dict[str, float | str], tolerance: float
) -> None:
    kinds = ("1e-3", "1e-2", "0.1", "whole", "uneven", "slivers", "microseconds")
    column, fmu = Column.from_toml(DAMPED), fmus.damped
    given: dict[str, float | str] = {"base.record": str(pulse)}
    if "solver.step" in values:
        column, fmu = column.with_settings(formulation="paper"), fmus.phocas
        given |= {f"joint[{i}].damping": block.joint.damping for i, block in enumerate(column.blocks, start=1)}
    results = call(steps.follow, fmu, values | given, kinds)
    settings = {key.removeprefix("solver."): value for key, value in values.items()}
    response = simulate(column, Motion.from_csv(pulse), STOP, output_step=0.01, **settings)
    assert response.contact.min() < 0.2
    for kind, (ux, shear) in zip(kinds, results, strict=True):
        assert abs(ux - response.ux[-1, 0]) < tolerance * response.peak_top_ux[0], kind
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


def test_a_step_that_would_take_too_long_is_discarded(fmus: Fmus) -> None:
    """Discard 1e4 s under a steady push, and one without end: 1 s of work and a tenth, where each took as long as it
    is.
    """
    undamped = {f"joint[{i}].damping": 0.0 for i in (1, 2, 3)}
    heard, same = call(steps.too_long, fmus.damped, {"base.ax": 0.5} | undamped, [1e4, 1e300])
    assert all("discard" in answer for answer in heard)
    assert same


@pytest.mark.parametrize("kind", ["trilith", "native_trilith", "native"])
def test_so_is_that_of_a_structure_and_of_a_native_fmu(request: pytest.FixtureRequest, kind: str) -> None:
    heard, same = call(steps.too_long, request.getfixturevalue(kind), {"base.ax": 0.3}, [1e300])
    assert all("discard" in answer for answer in heard)
    assert same


def warned(fmu: Path, name: str, grows: float, iterated: bool = False) -> int:
    """Count how often an FMU says that the coupling is unstable; fails unless the run ends well."""
    done = ended(steps.alternating, fmu, name, grows, iterated)
    assert done.returncode == 0, done.stderr
    line = "changes its sign at every step and grows"
    return done.stderr.count(line) or done.stdout.count(line)  # of a native FMU FMPy's logger alone tells


def test_an_unstable_coupling_is_warned_of_once(fmus: Fmus) -> None:
    assert warned(fmus.damped, "base.ax", 1.3) == warned(fmus.damped, "base.alpha", 1.3, True) == 1
    assert warned(fmus.damped, "base.ax", 0.9) == 0


@pytest.mark.parametrize("kind", ["trilith", "native_trilith", "native"])
def test_structures_and_native_fmus_warn_alike(request: pytest.FixtureRequest, kind: str) -> None:
    fmu = request.getfixturevalue(kind)
    assert warned(fmu, "base.ax", 1.3, True) == 1
    assert warned(fmu, "base.ax", 0.9) == 0
