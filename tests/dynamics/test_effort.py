"""Runs that would take days end soon, with a line that says which number makes them so slow."""

from __future__ import annotations

from typing import Any

import pytest

from multiblock import Column, Motion, SolverError, Structure, simulate, simulate_many
from solver.common import effort
from solver.models.column.lane_policy import first_step_of
from solver.models.column.stepper import Stepper
from solver.models.structure.rest import fastest_decay
from solver.runs.chunk import SLOW

SHAKE = Motion.harmonic(3.0, 1.0, 2.0)


def column(stiffness: float = 1e9, damping: float = 1e-3) -> Column:
    joint = {"stiffness": stiffness, "damping": damping}
    block = {"height": 4.0, "width": 0.9, "depth": 0.9, "mass": 5e3, "joint": joint}
    return Column.from_dict({"name": "one", "block": [block]})


def test_a_run_without_hope_is_given_up_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Check a billion cycles a second: 3e10 steps."""
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


def _damped(**parts: Any) -> Structure:
    """Return one block of 5 t on a bed or on a bearing, with what damps it too much."""
    joints = {"stiffness": 1e9, "damping": 1e-3, **parts.get("joints", {})}
    block = {"name": "a", "width": 0.9, "depth": 0.9, "height": 4.0, "mass": 5e3}
    if "bearing" in parts:
        place = {"between": ["a", "base"], "at": [[x, y, 0.0] for x in (-0.4, 0.4) for y in (-0.4, 0.4)]}
        across = {"diameter": 0.2, "vertical_stiffness": 1e8, "vertical_damping": 1e-3, "capacity": 0.3}
        block = {**block, "position": [0.0, 0.0, 0.0]}
        return Structure.from_dict(
            {"name": "one", "joints": joints, "block": [block], "bearing": [{**place, **across, **parts["bearing"]}]}
        )
    tie = {
        "between": ["a", "base"],
        "from": [0.0, 0.0, 2.0],
        "to": [3.0, 0.0, 0.0],
        "stiffness": 1e6,
        "tension_only": False,
    }
    ties = {"tie": [{**tie, **parts["tie"]}]} if "tie" in parts else {}
    return Structure.from_dict({"name": "one", "joints": joints, "block": [{**block, "on": "base"}], **ties})


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"joints": {"damping": 1e4}}, r"joint\[a-base\]: stiffness = 1e\+09 N/m3, damping = 10000 s"),
        ({"joints": {"shear_damping": 3e4}}, r"joint\[a-base\].shear_damping = 30000 s"),
        ({"tie": {"damping": 1e14}}, r"tie\[1\].damping = 1e\+14 N s/m"),
        (
            {"bearing": {"kind": "elastomeric", "tension": True, "stiffness": 1e5, "damping": 1e12}},
            r"joint\[a-base.1\].damping = 1e\+12 N s/m",
        ),
    ],
    ids=["joint", "shear", "tie", "bearing"],
)
def test_a_run_that_dampers_make_too_long_is_refused_at_its_start(parts: dict[str, Any], said: str) -> None:
    """Check the refusal, alone and in lanes, by the fastest rate at which a motion dies out; the line names
    the number.
    """
    structure, steps = _damped(**parts), []
    with pytest.raises(SolverError, match=r"it needs .* evaluations, more than 5e\+07: the fastest is " + said):
        simulate(structure, SHAKE, settle=0.0, callback=lambda t, now: steps.append(t))
    assert len(steps) == 1  # parts of the run
    table = simulate_many(structure, [SHAKE, SHAKE], keep=("verdict",), settle=0.0)
    assert table["verdict"].tolist() == ["undecided"] * 2
    assert len(table.stats["failures"]) == 2


def test_stabilized_steps_follow_a_joint_that_dampers_make_slow() -> None:
    """Check a damping of 100 s: 2.6e7 evaluations a second by explicit steps, 1e6 by stabilized ones."""
    structure = _damped(joints={"damping": 100.0})
    assert fastest_decay(structure) > 1e7
    response = simulate(structure, SHAKE, settle=0.0, tolerance=1e-4)
    assert response.stats["evaluations"] < 0.1 * float(SHAKE.duration) * fastest_decay(structure)


def test_the_fastest_decay_is_that_of_the_dampers_alone() -> None:
    """Check a slab on dashpots at the height of its centroid: each coordinate alone."""
    law = {"kind": "elastomeric", "stiffness": 1e5, "damping": 3e4, "vertical_stiffness": 1e8, "vertical_damping": 2e-3}
    place = {"between": ["a", "base"], "at": [[x, y, 0.2] for x in (-1, 1) for y in (-1, 1)]}
    block = {"name": "a", "width": 2.4, "depth": 2.4, "height": 0.4, "mass": 5e3, "position": [0.0] * 3}
    data = {"name": "s", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": [block]}
    structure = Structure.from_dict({**data, "bearing": [{**place, **law, "diameter": 0.2, "capacity": 0.3}]})
    inertia = 5e3 / 12.0 * (2.4**2 + 0.4**2)
    rates = 4.0 * 3e4 / 5e3, 4.0 * 2e5 / 5e3, 4.0 * 2e5 / inertia, 8.0 * 3e4 / (5e3 / 6.0 * 2.4**2)
    assert fastest_decay(structure) == pytest.approx(max(rates), rel=1e-12)
