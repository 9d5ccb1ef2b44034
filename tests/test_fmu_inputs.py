"""What the base does: held inputs, slopes, a record inside the FMU; and what is said when it looks like a mistake."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmus import ROOT, Fmus, environment, finish, run

from solver import Column, Motion, simulate

COLUMN = ROOT / "examples/columns/phocas-damped.toml"
AMPLITUDE, FREQUENCY, STOP = 0.6, 2.0, 1.6  # m/s2, Hz, s
TIGHT = {"solver.tolerance": 1e-9}

# argv: FMU, start values, communication step; prints the histories of block[1].ux at every 0.1 s, one for each way
FOLLOW = """
import json, math, sys
from instance import Instance
fmu, values, h = sys.argv[1], json.loads(sys.argv[2]), float(sys.argv[3])
count = round(1.6 / h)
def a(k):
    return 0.6 * math.sin(4.0 * math.pi * k * h)

def history(column, way):
    seen = []
    for k in range(count):
        if way == "held":
            column.set({"base.ax": a(k)})
        elif way == "linear":
            column.set({"base.ax": a(k), "base.jx": (a(k + 1) - a(k)) / h})
        column.step(k * h, h)
        if (k + 1) % round(0.1 / h) == 0:
            seen += column.get("block[1].ux")
    return seen
"""


def errors(fmu: Path, way: str, steps: tuple[float, ...]) -> list[float]:
    """Largest error of ux at each communication step, in parts of the peak, against the harmonic itself."""
    column = Column.from_toml(COLUMN)
    response = simulate(column, Motion.harmonic(AMPLITUDE, FREQUENCY, STOP), STOP, tolerance=1e-9, output_step=0.1)
    found = []
    for h in steps:
        script = FOLLOW + f"print(json.dumps(history(Instance(fmu, values), {way!r})))"
        seen = json.loads(run(sys.executable, "-c", script, fmu, json.dumps(TIGHT), h))
        found.append(float(np.max(np.abs(np.array(seen) - response.ux[1:, 0])) / response.peak_ux[0]))
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
    fmu = Fmus.build(COLUMN, tmp_path / "with_record.fmu", "--record", record)
    record.rename(tmp_path / "elsewhere.csv")
    description = read_model_description(str(fmu))
    start = {variable.name: variable.start for variable in description.modelVariables}
    assert start["base.record"] == "record.csv"
    experiment = description.defaultExperiment
    assert float(experiment.stopTime) == pytest.approx(STOP)
    assert float(experiment.stepSize) == pytest.approx(0.01)
    response = simulate(Column.from_toml(COLUMN), motion, STOP, tolerance=1e-9, output_step=0.1)
    script = FOLLOW + (
        "inside = Instance(fmu, values)\n"
        "print(json.dumps([history(inside, 'none'), inside.get('base.record_pga')]))\n"
        "half = values | {'base.record_scale': 0.5}\n"
        "print(json.dumps([history(Instance(fmu, half), 'none'), Instance(fmu, half).get('base.record_pga')]))\n"
        "print(json.dumps(history(Instance(fmu, values | {'base.record': ''}), 'none')))\n"
        "path = values | {'base.record': sys.argv[4]}\n"
        "print(json.dumps([history(Instance(fmu, path), 'none'), history(Instance(fmu, path | half), 'linear')]))\n"
    )
    printed = run(sys.executable, "-c", script, fmu, json.dumps(TIGHT), 0.1, tmp_path / "elsewhere.csv")
    (inside, pga), (half, half_pga), without, (by_path, _) = (json.loads(line) for line in printed.splitlines())
    peak = response.peak_ux[0]
    assert np.max(np.abs(np.array(inside) - response.ux[1:, 0])) < 1e-7 * peak  # measured 2e-9
    assert by_path == inside
    assert pga == [motion.pga]
    assert half_pga == [0.5 * motion.pga]
    assert np.max(np.abs(np.array(half) - inside)) > 0.1 * peak
    assert np.max(np.abs(without)) < 1e-3 * peak


def test_record_and_inputs_add_up(fmus: Fmus, tmp_path: Path) -> None:
    time = 0.01 * np.arange(161)
    motion = Motion.from_samples(0.01, AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * time))
    motion.to_csv(tmp_path / "whole.csv")
    values = {"base.record": str(tmp_path / "whole.csv"), "base.record_scale": 1.0}
    script = FOLLOW + (
        "print(json.dumps(history(Instance(fmu, values), 'none')))\n"
        "values['base.record_scale'] = 0.25\n"
        "a = lambda k, whole=a: 0.75 * whole(k)\n"
        "print(json.dumps(history(Instance(fmu, values), 'linear')))\n"
    )
    printed = run(sys.executable, "-c", script, fmus.damped, json.dumps(values | TIGHT), 0.01)
    alone, both = (np.array(json.loads(line)) for line in printed.splitlines())
    assert np.max(np.abs(both - alone)) < 1e-7 * np.max(np.abs(alone))  # measured 6e-10


def test_the_slope_holds_until_an_input_is_set_again(fmus: Fmus) -> None:
    script = (
        "import json, sys\nfrom instance import Instance\n"
        "column = Instance(sys.argv[1], {'base.ax': 0.5, 'base.jx': 10.0})\n"
        "heard = [column.get('joint[3].S')[0]]\n"
        "column.step(0.0, 0.05)\n"
        "for change in ({}, {'base.ax': 1.0}, {'base.jx': 0.0}, {'base.ax': 0.5}):\n"
        "    column.set(change)\n"
        "    heard += column.get('joint[3].S')\n"
        "print(json.dumps(heard))"
    )
    start, slope, same, still, back = json.loads(run(sys.executable, "-c", script, fmus.damped))
    assert start < -4e3  # N at 0.5 m/s2; the effective mass at rest measured 8211 kg
    assert slope == pytest.approx(same, rel=1e-12)  # 0.5 + 10 * 0.05 is 1.0
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
    ],
)
def test_what_looks_like_a_mistake_is_said_once(
    fmus: Fmus, tmp_path: Path, values: dict[str, object], h: float, said: str, logging: bool
) -> None:
    record = tmp_path / "record.csv"
    Motion.from_samples(0.02, np.sin(np.arange(51.0))).to_csv(record)
    script = (
        "import json, sys\nfrom instance import Instance\n"
        f"column = Instance(sys.argv[1], json.loads(sys.argv[2]), loggingOn={logging})\n"
        f"for k in range(10):\n    column.step(k * {h}, {h})\ncolumn.close()"
    )
    given = json.dumps(values).replace("RECORD", str(record))
    done = finish(sys.executable, "-c", script, fmus.damped, given)
    assert done.returncode == 0, done.stderr
    for stream in (done.stderr, done.stdout if logging else done.stderr):
        assert stream.count("\n") == (1 if said else 0)
        assert said in stream


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
    script = (
        "import sys\nfrom instance import Instance\n"
        "column = Instance(sys.argv[1], {'base.record': sys.argv[2]}, initialize=False)\n"
        "print(column.attempt('initialize'))\ncolumn.fmi.reset()\ncolumn.initialize()"
    )
    build = [ROOT / "build_fmu.py", COLUMN, "-o", tmp_path / "x.fmu", "--record", record]
    for command, code in ((["-c", script, fmus.damped, record], 0), (build, 2)):
        done = subprocess.run(
            [sys.executable, *map(str, command)], capture_output=True, text=True, env=environment(), check=False
        )
        assert done.returncode == code, done.stderr
        (line,) = done.stderr.strip().splitlines()
        assert str(record) in line
        assert said in line
    assert not (tmp_path / "x.fmu").exists()
