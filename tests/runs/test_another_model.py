"""A model beside the solver's own (examples/models/rigid_block.py): runs, many runs, a study, through the protocol."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from support.fmus import ROOT
from support.housner import half_sine_amplitude, rectangle_amplitude

from multiblock import InputError, Motion, simulate, simulate_many
from solver.models.protocol import Kind
from solver.studies.standard import ida

sys.path.insert(0, str(ROOT / "examples" / "models"))

from rigid_block import BLOCKS, Block

BLOCK = Block(0.6, 4.0)
ONE = BLOCK.g * BLOCK.alpha  # m/s2: what it lifts at


@pytest.mark.parametrize("length", [0.3, 1.0, 2.5])
def test_least_rectangle_that_overturns_it(length: float) -> None:
    least, duration = ONE * rectangle_amplitude(length), length / BLOCK.p
    for part, word in ((0.9999, "standing"), (1.0001, "overturned")):
        motion = Motion.from_samples(duration, np.full(2, part * least))
        assert simulate(BLOCK, motion, duration).verdict == word


@pytest.mark.parametrize("speed", [1.0, 2.0, 4.0])
def test_least_half_sine_that_overturns_it(speed: float) -> None:
    frequency = speed * BLOCK.p / (2.0 * math.pi)
    for part, word in ((0.9999, "standing"), (1.0001, "overturned")):
        motion = Motion.harmonic(part * ONE * half_sine_amplitude(speed), frequency, 0.5 / frequency)
        assert simulate(BLOCK, motion).verdict == word


def test_each_impact_leaves_the_part_of_the_rate() -> None:
    """Amplitudes fall by 1 - (1 - x / alpha)^2 -> r^2 of it (Housner's equation 15)."""
    response = simulate(BLOCK, Motion.from_samples(0.1, np.full(4, 1.5 * ONE), hold=True), 8.0, output_step=1e-3)
    turns = np.abs(response.theta)
    peaks = turns[1:-1][(turns[1:-1] > turns[:-2]) & (turns[1:-1] >= turns[2:])] / BLOCK.alpha
    left = 1.0 - (1.0 - peaks) ** 2
    assert len(left) >= 4
    # peaks are read from rows 1 ms apart: measured 2e-5
    assert left[1:4] / left[:3] == pytest.approx(np.full(3, BLOCK.rebound**2), rel=1e-3)


def test_many_runs_and_a_study_take_it(tmp_path: Path) -> None:
    motions = [Motion.harmonic(k * 0.5 * ONE, 1.0, 3.0) for k in range(1, 7)]
    table = simulate_many(BLOCK, motions, keep=("peak_ux", "verdict", "path"))
    for k, motion in enumerate(motions):
        alone = simulate(BLOCK, motion, check=True, ensemble=2)
        assert table["verdict"][k] == alone.verdict
        assert table["peak_ux"][k] == pytest.approx(alone.peaks["ux"], rel=1e-9)  # rows cut its steps: measured 1e-12
        assert alone.ensemble is not None
    assert table.stats["why_scalar"] == {"closed form": 6}
    width = {"block.width": {"distribution": "uniform", "low": 0.5, "high": 0.7}}
    found = ida(BLOCK, {"wave": motions[1]}, [0.1, 0.3], random=width, samples=3)
    assert len(found) == 6
    assert set(found["verdict"]) == {"standing", "overturned"}
    with pytest.raises(InputError, match="folder: must be left out, a journal cannot be read without its models"):
        ida(BLOCK, {"wave": motions[1]}, [0.1], folder=tmp_path)
    assert not [*tmp_path.iterdir()]
    with pytest.raises(InputError, match="formulation = 'paper': must be left out, a block has none"):
        simulate(BLOCK, motions[0], formulation="paper")


def test_its_kind_answers_all_questions_but_those_of_lanes() -> None:
    asked = [name for name in (*Kind.__annotations__, *vars(Kind)) if name[0] != "_"]
    assert {name for name in asked if not hasattr(BLOCKS, name)} == {"follow", "varied_in_lanes"}
