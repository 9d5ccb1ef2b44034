"""Communication steps of any length: they sample the input and the output, and change nothing else."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from fmus import ROOT, Fmus, run

from solver import Column, Motion, simulate

STOP = 4.0

# argv: FMU, record, start values; each plan of communication steps gives the outputs at its end
STEPS = """
import json, random, sys
from instance import Instance

def plan(kind):
    some = random.Random(5)
    if kind == "whole":
        return [4.0]
    if kind == "uneven":  # from a microsecond to a third of a second
        steps = [10.0 ** some.uniform(-6.0, -0.5) for _ in range(45)]
        while sum(steps) >= 3.999:
            steps.pop()
        return [*steps, 4.0 - sum(steps)]
    if kind == "slivers":
        return [0.1 - 1e-6, 1e-6] * 40
    if kind == "microseconds":  # while the column rocks
        return [1.5, *[1e-6] * 20000, 4.0 - 1.52]
    return [float(kind)] * round(4.0 / float(kind))

def follow(column, steps, tries=False):
    some, t = random.Random(7), 0.0
    for h in steps:
        if tries:
            saved = column.fmi.getFMUState()
            column.step(t, h * some.uniform(0.01, 2.0))
            column.get()
            column.fmi.setFMUState(saved)
            column.fmi.freeFMUState(saved)
        column.step(t, h)
        t += h
    return column.get("block[1].ux", "joint[1].S")

values = json.loads(sys.argv[3]) | {"base.record": sys.argv[2]}
"""


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
    script = STEPS + (f"print(json.dumps([follow(Instance(sys.argv[1], values), plan(kind)) for kind in {kinds!r}]))")
    results = json.loads(run(sys.executable, "-c", script, fmus.damped, pulse, json.dumps(values)))
    column = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml")
    settings = {key.removeprefix("solver."): value for key, value in values.items()}
    response = simulate(column, Motion.from_csv(pulse), STOP, output_step=0.01, **settings)  # type: ignore[arg-type]
    assert response.contact.min() < 0.2
    for kind, (ux, shear) in zip(kinds, results, strict=True):
        assert abs(ux - response.ux[-1, 0]) < tolerance * response.peak_ux[0], kind
        assert abs(shear - response.S[-1, 0]) < tolerance * np.max(np.abs(response.S[:, 0])), kind


def test_steps_tried_and_taken_back_leave_no_trace(fmus: Fmus, pulse: Path) -> None:
    script = STEPS + (
        "for kind in ('1e-2', 'uneven', 'slivers'):\n"
        "    plain = follow(Instance(sys.argv[1], values), plan(kind))\n"
        "    print(follow(Instance(sys.argv[1], values), plan(kind), tries=True) == plain)\n"
    )
    assert run(sys.executable, "-c", script, fmus.damped, pulse, "{}").split() == ["True"] * 3


def test_a_held_input_does_not_mind_the_step_either(fmus: Fmus) -> None:
    script = STEPS.replace('| {"base.record": sys.argv[2]}', "") + (
        "kinds = ('whole', '1e-2', 'slivers', 'microseconds')\n"
        "print(json.dumps([follow(Instance(sys.argv[1], values), plan(kind))[0] for kind in kinds]))"
    )
    values = {"base.ax": 0.7, "solver.tolerance": 1e-8}
    whole, *others = json.loads(run(sys.executable, "-c", script, fmus.damped, "", json.dumps(values)))
    assert abs(whole) > 1e-3
    for other in others:
        assert abs(other - whole) < 1e-6 * abs(whole)
