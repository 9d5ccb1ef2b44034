"""Runs that would take days end soon, with a line that says which number makes them so slow."""

from __future__ import annotations

from typing import Any

import pytest

from multiblock import Column, Motion, SolverError, Structure, simulate, simulate_many
from solver.common import effort
from solver.models.column.lane_policy import first_step_of
from solver.models.column.stepper import Stepper
from solver.runs.chunk import SLOW

SHAKE = Motion.harmonic(3.0, 1.0, 2.0)


def column(stiffness: float = 1e9, damping: float = 1e-3) -> Column:
    joint = {"stiffness": stiffness, "damping": damping}
    block = {"height": 4.0, "width": 0.9, "depth": 0.9, "mass": 5e3, "joint": joint}
    return Column.from_dict({"name": "one", "block": [block]})


def test_a_run_without_hope_is_given_up_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A billion cycles a second: 3e10 steps."""
    monkeypatch.setattr(effort, "EARLY", 1e5)
    fast = Motion.harmonic(3.0, 1e9, 5.0)
    subjects: list[Any] = [column(), Structure.stack(column())]
    for subject in subjects:
        with pytest.raises(
            SolverError, match=r"too slow to go on: the fastest is the base motion's frequency = 1e\+09"
        ):
            simulate(subject, fast, output_step=1.0)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (
            column(1e11),
            r"block\[1\].joint: stiffness = 1e\+11 N/m3, damping = 0.001 s, 906 Hz on 0.81 m2 with 5e\+03 kg",
        ),
        (column(1e9, 1.0), r"block\[1\].joint: stiffness = 1e\+09 N/m3, damping = 1 s, 90.6 Hz"),
    ],
)
def test_the_number_that_makes_it_slow_is_named(monkeypatch: pytest.MonkeyPatch, made: Column, said: str) -> None:
    monkeypatch.setattr(effort, "MOST", 10.0)
    monkeypatch.setattr(effort, "MOST_IN_SPACE", 10.0)
    monkeypatch.setattr("solver.models.structure.stepper.AT_ONCE", 700.0)
    subjects: list[Any] = [made, Structure.stack(made)]
    for subject, words in zip(
        subjects, (said, said.replace(r"block\[1\].joint", r"joint\[block1-base\]")), strict=True
    ):
        with pytest.raises(SolverError, match=words):
            simulate(subject, SHAKE, settle=0.0)
        table = simulate_many(subject, [SHAKE, SHAKE], keep=("verdict", "peak_N", "steps"), settle=0.0)
        assert table["verdict"].tolist() == ["undecided"] * 2
        assert len(table.stats["failures"]) == 2


def test_lanes_leave_runs_of_too_many_steps_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    one = column()
    assert simulate_many(one, SHAKE, settle=0.0).stats["why_scalar"] == {}
    monkeypatch.setattr(effort, "MOST_FIRST_STEPS", 1e3)
    assert simulate_many(one, SHAKE, settle=0.0).stats["why_scalar"] == {SLOW: 1}
    model_step = float(Stepper(one).model.settings.first_step)
    assert first_step_of(one) == pytest.approx(model_step, rel=1e-12)  # only order of operations differs
