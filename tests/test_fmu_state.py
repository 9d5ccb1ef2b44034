"""The state of an FMU: got and set, serialized, restored elsewhere; exact to the last bit."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from fmus import ROOT, Fmus, environment, run

# A damped column shaken hard enough to rock, by steps and slopes that differ from one to the next.
DRIVE = """
import json, sys
from math import sin
from pathlib import Path
from instance import Instance

def drive(column, first, last):
    t = sum(1e-3 * (1 + k % 7) for k in range(first))
    for k in range(first, last):
        h = 1e-3 * (1 + k % 7)
        column.set({"base.ax": 1.5 * sin(12.6 * t), "base.az": 0.2 * sin(40.0 * t), "base.jx": 5.0 * sin(3.0 * t)})
        column.step(t, h)
        t += h
    return column.get()

def hex_of(values):
    return [float(value).hex() for value in values]
"""


def test_a_run_goes_on_from_a_state_with_the_same_bits(fmus: Fmus) -> None:
    script = DRIVE + (
        "column = Instance(sys.argv[1])\n"
        "drive(column, 0, 150)\n"
        "at_save = column.get()\n"
        "saved = column.fmi.getFMUState()\n"
        "first = drive(column, 150, 300)\n"
        "column.set({'joint[2].damping': 4e-3})\n"
        "further = drive(column, 300, 400)\n"
        "column.fmi.setFMUState(saved)\n"
        "print(hex_of(column.get()) == hex_of(at_save))\n"
        "print(hex_of(drive(column, 150, 300)) == hex_of(first))\n"
        "column.set({'joint[2].damping': 4e-3})\n"
        "tuned = column.fmi.getFMUState()\n"
        "print(hex_of(drive(column, 300, 400)) == hex_of(further))\n"
        "column.fmi.setFMUState(saved)\n"
        "column.fmi.setFMUState(tuned)\n"
        "print(hex_of(drive(column, 300, 400)) == hex_of(further), hex_of(first) != hex_of(further))\n"
        "column.fmi.freeFMUState(saved)\ncolumn.fmi.freeFMUState(tuned)\ncolumn.close()"
    )
    assert run(sys.executable, "-c", script, fmus.damped).split() == ["True"] * 5


def test_a_state_with_a_wrong_tunable_parameter_that_has_not_acted(fmus: Fmus) -> None:
    script = DRIVE + (
        "column = Instance(sys.argv[1])\n"
        "drive(column, 0, 50)\n"
        "column.set({'g': float('nan')})\n"
        "saved = column.fmi.getFMUState()\n"
        "column.fmi.setFMUState(saved)\n"
        "column.set({'g': 9.80665})\n"
        "first = drive(column, 50, 100)\n"
        "read = column.fmi.deSerializeFMUstate(column.fmi.serializeFMUState(saved))\n"
        "column.fmi.setFMUState(read)\n"
        "column.set({'g': 9.80665})\n"
        "print(hex_of(drive(column, 50, 100)) == hex_of(first))\n"
        "column.fmi.freeFMUState(saved)\ncolumn.fmi.freeFMUState(read)\ncolumn.close()"
    )
    assert run(sys.executable, "-c", script, fmus.damped).split() == ["True"]


def test_the_state_of_a_fallen_column_and_of_one_that_stands_again(fmus: Fmus) -> None:
    script = DRIVE + (
        "column = Instance(sys.argv[1], {'base.ax': 4.0})\n"
        "saved = column.fmi.getFMUState()\n"
        "column.step(0.0, 8.0)\n"
        "fallen = column.get('overturned', 'overturn_time', 'overturn_joint', 'block[1].ux')\n"
        "after = column.fmi.getFMUState()\n"
        "column.fmi.setFMUState(saved)\n"
        "print(column.get('overturned', 'overturn_time', 'overturn_joint') == [False, -1.0, 0])\n"
        "column.fmi.setFMUState(after)\n"
        "print(column.get('overturned', 'overturn_time', 'overturn_joint', 'block[1].ux') == fallen, bool(fallen[0]))\n"
        "column.fmi.setFMUState(saved)\n"
        "column.step(0.0, 8.0)\n"
        "print(column.get('overturned', 'overturn_time', 'overturn_joint', 'block[1].ux') == fallen)"
    )
    assert run(sys.executable, "-c", script, fmus.damped).split() == ["True"] * 4


# Half a run, its state to a file, the rest; then, as another process, the rest from the file.
HALF = DRIVE + (
    "column = Instance(sys.argv[1], json.loads(sys.argv[3]))\n"
    "drive(column, 0, 150)\n"
    "saved = column.fmi.getFMUState()\n"
    "Path(sys.argv[2]).write_bytes(column.fmi.serializeFMUstate(saved))\n"
    "print(hex_of(drive(column, 150, 300)))"
)
OTHER_HALF = DRIVE + (
    "column = Instance(sys.argv[1], initialize=False)\n"
    "saved = column.fmi.deSerializeFMUstate(Path(sys.argv[2]).read_bytes())\n"
    "column.fmi.setFMUState(saved)\n"
    "print(hex_of(drive(column, 150, 300)))"
)


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"solver.formulation": "paper", "solver.integrator": "central-difference", "joint[1].damping": 2e-3},
        {"block[2].mass": 2e4, "g": 9.0},
    ],
)
def test_a_serialized_state_goes_on_in_another_process_with_the_same_bits(
    fmus: Fmus, tmp_path: Path, values: dict[str, float | str]
) -> None:
    there = run(sys.executable, "-c", HALF, fmus.damped, tmp_path / "state", json.dumps(values))
    here = run(sys.executable, "-c", OTHER_HALF, fmus.damped, tmp_path / "state")
    assert here == there


def test_a_state_with_a_record_needs_the_same_record(fmus: Fmus, tmp_path: Path) -> None:
    record = tmp_path / "pulse.csv"
    record.write_text("time,base.ax\n0,0\n0.3,1.5\n0.7,-1.2\n1.5,0\n")
    with_record = {"base.record": str(record)}
    there = run(sys.executable, "-c", HALF, fmus.damped, tmp_path / "state", json.dumps(with_record))
    assert run(sys.executable, "-c", OTHER_HALF, fmus.damped, tmp_path / "state") == there
    script = DRIVE + (
        "column = Instance(sys.argv[1], json.loads(sys.argv[2]))\n"
        "before = drive(column, 0, 150)\n"
        "saved = column.fmi.getFMUState()\n"
        "drive(column, 150, 160)\n"
        "column.fmi.setFMUState(saved)\n"
        "print(hex_of(column.get()) == hex_of(before))"
    )
    assert run(sys.executable, "-c", script, fmus.damped, json.dumps(with_record)).strip() == "True"
    assert run(sys.executable, "-c", HALF, fmus.damped, tmp_path / "other", "{}") != there
    record.write_text("time,base.ax\n0,0\n0.3,1.5\n0.7,-1.3\n1.5,0\n")
    assert "its samples are not those" in refused(fmus.damped, tmp_path / "state")


def refused(fmu: Path, state: Path) -> str:
    """What an instance says to a state that is not its own; fails unless it is as good as before afterwards."""
    script = DRIVE + (
        "column = Instance(sys.argv[1], {'base.ax': 1.0})\n"
        "column.step(0.0, 0.1)\n"
        "before = column.get()\n"
        "state = column.fmi.deSerializeFMUstate(Path(sys.argv[2]).read_bytes())\n"
        "heard = column.attempt('setFMUState', state)\n"
        "assert 'status' in heard, heard\n"
        "assert column.get() == before\n"
        "column.step(0.1, 0.1)\n"
        "column.fmi.reset()\ncolumn.initialize()\ncolumn.set({'base.ax': 1.0})\ncolumn.step(0.0, 0.1)\n"
        "assert column.get() == before\n"
        "column.close()"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(fmu), str(state)],
        capture_output=True,
        text=True,
        env=environment(),
        check=False,
    )
    assert done.returncode == 0, done.stderr
    (line,) = done.stderr.strip().splitlines()
    return line


def test_foreign_and_damaged_states_are_refused_with_a_reason(fmus: Fmus, tmp_path: Path) -> None:
    state = tmp_path / "state"
    run(sys.executable, "-c", HALF, fmus.damped, state, "{}")
    assert "that of another column" in refused(fmus.phocas, state)
    changed = tmp_path / "project"
    changed.mkdir()
    for name in ("solver", "fmu_src", "build_fmu.py"):
        (changed / name).symlink_to(ROOT / name)
    (changed / "fmu_src").unlink()
    (changed / "fmu_src").mkdir()
    for file in (ROOT / "fmu_src").glob("*.py"):
        text = file.read_text()
        (changed / "fmu_src" / file.name).write_text(text + "# changed\n" if file.name == "state.py" else text)
    column = ROOT / "examples/columns/phocas-damped.toml"
    script = "import sys; sys.path.insert(0, sys.argv.pop(1)); import build_fmu; build_fmu.main(sys.argv[1:])"
    run(sys.executable, "-c", script, changed, column, "-o", tmp_path / "changed.fmu")
    assert "made by another version" in refused(tmp_path / "changed.fmu", state)
    data = state.read_bytes()
    for damaged in (data[:-1], data[:2000] + bytes([data[2000] ^ 1]) + data[2001:], b"", b"nonsense"):
        state.write_bytes(damaged)
        assert "not those of a serialized state" in refused(fmus.damped, state)
