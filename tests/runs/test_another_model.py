"""A model beside the solver's own (examples/models/rigid_block): runs, a study, a check and an FMU, by its folder."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import fmpy.validation
import numpy as np
import pytest
from support.fmus import ROOT, run
from support.housner import half_sine_amplitude, rectangle_amplitude

from build_fmu import build_fmu
from multiblock import InputError, Motion, check, simulate, simulate_many
from solver.checks.report.html import write_report
from solver.models.driven import pieces
from solver.models.protocol import Kind
from solver.studies.standard import ida

sys.path.insert(0, str(ROOT / "examples" / "models"))

import rigid_block.fmu
import rigid_block.subject
from rigid_block.block import BLOCKS, Block

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
    """Check that amplitudes fall by 1 - (1 - x / alpha)^2 -> r^2 of it (Housner's equation 15)."""
    response = simulate(BLOCK, Motion.from_samples(0.1, np.full(4, 1.5 * ONE), hold=True), 8.0, output_step=1e-3)
    turns = np.abs(response.ry)
    peaks = turns[1:-1][(turns[1:-1] > turns[:-2]) & (turns[1:-1] >= turns[2:])] / BLOCK.alpha
    left = 1.0 - (1.0 - peaks) ** 2
    assert len(left) >= 4
    # peaks are read from rows 1 ms apart: measured 2e-5
    assert left[1:4] / left[:3] == pytest.approx(np.full(3, BLOCK.rebound**2), rel=1e-3)


@pytest.mark.parametrize(
    "motion", [Motion.harmonic(1.0, 0.8, 1.0), Motion.from_samples(0.25, [1.0, -2.0, 3.0], hold=True)]
)
def test_the_base_is_still_beyond_its_motion(motion: Motion) -> None:
    """Compare the shaking with the acceleration of the motion, from before its start to beyond its end."""
    begin = -0.1
    for end, shaking in pieces(motion, begin, motion.end + 1.0):
        for t in np.linspace(begin, end, 7)[1:-1].tolist():
            assert shaking.at(t) == pytest.approx(motion.acceleration(t)[0], abs=1e-14)
        begin = end


def test_many_runs_and_a_study_take_it(tmp_path: Path) -> None:
    motions = [Motion.harmonic(k * 0.5 * ONE, 1.0, 3.0) for k in range(1, 7)]
    table = simulate_many(BLOCK, motions, keep=("peak_ux", "verdict", "path"))
    for k, motion in enumerate(motions):
        alone = simulate(BLOCK, motion, check=True, ensemble=2)
        assert table["verdict"][k] == alone.verdict
        assert table["peak_ux"][k] == pytest.approx(alone.peaks["ux"], rel=1e-9)  # rows cut its steps: measured 1e-12
        assert alone.ensemble is not None
    assert table.stats["why_scalar"] == {"a model without lanes": 6}
    width = {"block.width": {"distribution": "uniform", "low": 0.5, "high": 0.7}}
    found = ida(BLOCK, {"wave": motions[1]}, [0.1, 0.3], random=width, samples=3)
    assert len(found) == 6
    assert set(found["verdict"]) == {"standing", "overturned"}
    with pytest.raises(InputError, match="folder: must be left out, a journal cannot be read without its models"):
        ida(BLOCK, {"wave": motions[1]}, [0.1], folder=tmp_path)
    assert not [*tmp_path.iterdir()]
    with pytest.raises(InputError, match="plot: no pictures of a BlockResponse: drawing_of"):
        alone.plot()
    with pytest.raises(InputError, match=r"scene: a block has none, parts_of\.register"):
        alone.to_gltf(tmp_path / "block.glb")
    with pytest.raises(InputError, match="formulation = 'paper': must be left out, a block has none"):
        simulate(BLOCK, motions[0], formulation="paper")


def test_a_check_has_the_rows_that_it_can_have() -> None:
    motions = {"weak": Motion.harmonic(0.5 * ONE, 1.0, 3.0), "strong": Motion.harmonic(1.2 * ONE, 1.0, 3.0)}
    made = check(BLOCK, motions)
    names = ["overturning, as given", "overturning", "overturning, margin", "displacement of the top"]
    assert [row.name for row in made.rows] == names
    largest = simulate(BLOCK, motions["strong"]).peaks["ux"][0]
    assert made.rows[3].values[0] == 0.0
    assert made.rows[3].values[1] == pytest.approx(largest, rel=1e-9)  # measured: equal
    assert made.rows[3].ratio == pytest.approx(largest / (0.4 * BLOCK.height * BLOCK.alpha), rel=1e-9)
    assert made.remarks[0].startswith("One horizontal component acts")
    with pytest.raises(InputError, match=r"report: a block has none, shown_of.register"):
        write_report([made], "report.html")


def test_it_runs_inside_an_fmu(tmp_path: Path) -> None:
    """Drive it by a record inside and by held inputs beside it, as one run of the sum of both."""
    step, count = 0.01, 400
    held = 0.9 * ONE * (np.arange(count + 1) < 30)
    time = step * np.arange(101)
    record = tmp_path / "wave.csv"
    rows = [f"{t:.2f},{a:.17g}" for t, a in zip(time, 0.8 * ONE * np.sin(7.0 * time), strict=True)]
    record.write_text("\n".join(["time,base.ax", *rows]), encoding="utf-8")
    fmu = build_fmu(BLOCK, tmp_path / "block.fmu", record)
    assert fmpy.validation.validate_fmu(str(fmu)) == []
    run(sys.executable, "-c", FOLLOW, fmu, count, step, tmp_path / "rows.npy", repr(held.tolist()))
    found = np.load(tmp_path / "rows.npy")
    # the sum of both, with the jumps of the held input as steep lines between samples
    sampled = Motion.from_file(record)
    times = np.unique(np.concatenate([sampled.time, [0.3 - 1e-9, 1.0 + 1e-9, step * count]]))
    both = np.interp(times, sampled.time, sampled.ax, right=0.0) + 0.9 * ONE * (times < 0.3 - 5e-10)
    motion = Motion(times, both, np.zeros_like(both), duration=float(times[-1] - times[0]))
    alone = simulate(BLOCK, motion, step * count, output_step=step)
    assert np.max(np.abs(alone.ux)) > 0.05
    assert found[:, 0] == pytest.approx(alone.ux[1:, 0], abs=1e-6)
    assert set(found[:, 1]) == {3.0}


FOLLOW = """
import json
import sys
import numpy as np
from support.instance import Instance
fmu, count, step, path, held = sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), sys.argv[4], json.loads(sys.argv[5])
block, rows = Instance(fmu), []
for k in range(count):
    block.set({"base.ax": held[k]})
    block.fmi.doStep(k * step, step)
    if k == count // 2:  # its state is all that it is
        state = block.fmi.getFMUstate()
        block.fmi.doStep((k + 1) * step, 0.5)
        block.fmi.setFMUstate(state)
    rows.append(block.get("block[1].ux", "verdict"))
np.save(path, rows)
block.fmi.terminate()
block.fmi.freeInstance()
"""


def test_its_kind_answers_all_questions() -> None:
    assert not [name for name in (*Kind.__annotations__, *vars(Kind)) if name[0] != "_" and not hasattr(BLOCKS, name)]


def test_it_is_a_folder_of_at_most_250_lines() -> None:
    files = [*Path(rigid_block.__path__[0]).glob("*.py")]
    assert sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files) <= 250
