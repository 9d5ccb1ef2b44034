"""The motion of the base: held inputs, slopes, a record inside the FMU; warnings where it looks like a mistake."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from support import child
from support.child import call, ended
from support.fmus import DAMPED, ROOT, Fmus, finish
from support.inside import inputs

from solver import Column, Motion, simulate

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time

AMPLITUDE, FREQUENCY, STOP = 0.6, 2.0, 1.6  # m/s2, Hz, s
TIGHT = {"solver.tolerance": 1e-9}


def errors(fmu: Path, way: str, steps: tuple[float, ...]) -> list[float]:
    """Return the largest error of ux at each communication step, in parts of the peak, against the harmonic itself."""
    column = Column.from_toml(DAMPED)
    response = simulate(column, Motion.harmonic(AMPLITUDE, FREQUENCY, STOP), STOP, tolerance=1e-9, output_step=0.1)
    found = []
    for h in steps:
        seen = call(inputs.history, fmu, TIGHT, way, h)
        found.append(float(np.max(np.abs(np.array(seen) - response.ux[1:, 0])) / response.peak_top_ux[0]))
    return found


def test_a_held_input_is_of_first_order_and_a_slope_of_second(fmus: Fmus) -> None:
    held = errors(fmus.damped, "held", (0.01, 0.005))
    linear = errors(fmus.damped, "linear", (0.01, 0.005))
    assert 1.7 < held[0] / held[1] < 2.4  # measured 2.0
    assert 3.3 < linear[0] / linear[1] < 5.0  # measured 4.0
    assert linear[0] < held[0] / 10.0


def test_a_record_inside_is_followed_whatever_the_communication_step(fmus: Fmus, tmp_path: Path) -> None:
    time = 0.01 * np.arange(161)
    motion = Motion.from_samples(0.01, AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * time), 0.1 * np.cos(time))
    record = tmp_path / "record.csv"
    motion.to_csv(record)
    fmu = Fmus.build(DAMPED, tmp_path / "with_record.fmu", "--record", record)
    record.rename(tmp_path / "elsewhere.csv")
    description = read_model_description(str(fmu))
    start = {variable.name: variable.start for variable in description.modelVariables}
    assert start["base.record"] == "record.csv"
    experiment = description.defaultExperiment
    assert float(experiment.stopTime) == pytest.approx(STOP)
    assert float(experiment.stepSize) == pytest.approx(0.01)
    response = simulate(Column.from_toml(DAMPED), motion, STOP, tolerance=1e-9, output_step=0.1)
    seen = call(inputs.record_inside, fmu, TIGHT, tmp_path / "elsewhere.csv")
    peak = response.peak_top_ux[0]
    assert np.max(np.abs(np.array(seen["inside"]) - response.ux[1:, 0])) < 1e-7 * peak  # measured 2e-9
    assert seen["by path"] == seen["inside"]
    assert seen["pga"] == motion.pga
    assert seen["half pga"] == 0.5 * motion.pga
    assert np.max(np.abs(np.array(seen["half"]) - seen["inside"])) > 0.1 * peak
    assert np.max(np.abs(seen["without"])) < 1e-3 * peak


def test_record_and_inputs_add_up(fmus: Fmus, tmp_path: Path) -> None:
    time = 0.01 * np.arange(161)
    motion = Motion.from_samples(0.01, AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * time))
    motion.to_csv(tmp_path / "whole.csv")
    whole = TIGHT | {"base.record": str(tmp_path / "whole.csv")}
    quarter = whole | {"base.record_scale": 0.25}
    alone = np.array(call(inputs.history, fmus.damped, whole, "none", 0.01))
    both = np.array(call(inputs.history, fmus.damped, quarter, "linear", 0.01, part=0.75))
    assert np.max(np.abs(both - alone)) < 1e-7 * np.max(np.abs(alone))  # measured 6e-10


def test_the_slope_holds_until_an_input_is_set_again(fmus: Fmus) -> None:
    start, slope, tuned, same, still, back = call(inputs.slopes, fmus.damped)
    assert start < -4e3  # N at 0.5 m/s2; the effective mass at rest measured 8211 kg
    assert slope == pytest.approx(same, rel=1e-12)  # 0.5 + 10 * 0.05 is 1.0
    assert tuned == slope  # a parameter leaves the slope as it runs
    assert still == same
    assert back - same == pytest.approx(0.5 * 8211.0, rel=0.05)


@pytest.mark.parametrize("logging", [False, True])
@pytest.mark.parametrize(
    ("values", "h", "said"),
    [
        ({}, 0.01, "zero for the whole run"),
        ({"base.ax": 0.1}, 0.01, ""),
        ({"base.jz": 0.1}, 0.01, ""),
        ({"base.record": "RECORD"}, 0.1, "communication step = 0.1 s, the record's is 0.02 s"),
        ({"base.record": "RECORD"}, 0.02, ""),
        ({"base.record": "RECORD", "base.record_scale": 0.0, "base.ax": 0.1}, 0.1, ""),
    ],
)
def test_what_looks_like_a_mistake_is_said_once(
    fmus: Fmus, tmp_path: Path, values: dict[str, object], h: float, said: str, logging: bool
) -> None:
    record = tmp_path / "record.csv"
    Motion.from_samples(0.02, np.sin(np.arange(51.0))).to_csv(record)
    given = {name: str(record) if value == "RECORD" else value for name, value in values.items()}
    done = ended(inputs.ten_steps, fmus.damped, given, h, logging)
    assert done.returncode == 0, done.stderr
    logged = [line for line in child.said(done.stdout) if "preferred communication step" not in line]
    for lines in (done.stderr.splitlines(), logged if logging else done.stderr.splitlines()):
        assert len(lines) == (1 if said else 0)
        assert said in "".join(lines)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("absent.csv", None, "No such file"),
        ("record.txt", "0 0", "no known header"),
        ("record.csv", "time,base.ax\n0,0\n0,1\n", "line 3: time = 0.0"),
        ("record.AT2", "nonsense", "no known header"),
    ],
)
def test_a_wrong_record_is_refused_by_the_fmu_and_by_its_builder(
    fmus: Fmus, tmp_path: Path, name: str, text: str | None, said: str
) -> None:
    record = tmp_path / name
    if text is not None:
        record.write_text(text)
    build = [sys.executable, ROOT / "build_fmu.py", DAMPED, "-o", tmp_path / "x.fmu", "--record", record]
    for done, code in ((ended(inputs.wrong_record, fmus.damped, record), 0), (finish(*build), 2)):
        assert done.returncode == code, done.stderr
        (line,) = done.stderr.strip().splitlines()
        assert str(record) in line
        assert said in line
    assert not (tmp_path / "x.fmu").exists()
