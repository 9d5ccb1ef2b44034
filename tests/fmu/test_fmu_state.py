"""The state of an FMU: got and set, serialized, restored elsewhere; exact to the last bit."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from support.child import call, ended
from support.fmus import ROOT, Fmus, run
from support.inside import states

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time


def test_a_run_goes_on_from_a_state_with_the_same_bits(fmus: Fmus) -> None:
    found = call(states.go_on, fmus.damped)
    assert all(found.values()), found


def test_a_state_with_a_wrong_tunable_parameter_that_has_not_acted(fmus: Fmus) -> None:
    assert call(states.with_a_wrong_parameter, fmus.damped)


def test_a_state_whose_parameter_has_not_been_stepped_with(fmus: Fmus, native: Path) -> None:
    for fmu in (fmus.damped, native):
        assert call(states.retuned, fmu)


def test_the_state_of_a_fallen_column_and_of_one_that_stands_again(fmus: Fmus) -> None:
    found = call(states.fall, fmus.damped)
    assert all(found.values()), found


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"solver.step": 2e-4, "joint[1].damping": 2e-3},  # of the paper
        {"block[2].mass": 2e4, "g": 9.0},
        {"joint[1].offset": 0.1, "joint[2].inclination": 0.01, "block[3].tilt": -5e-3, "joint[1].friction": 0.4},
    ],
)
def test_a_serialized_state_goes_on_in_another_process_with_the_same_bits(
    fmus: Fmus, tmp_path: Path, values: dict[str, float | str]
) -> None:
    fmu = fmus.phocas if "solver.step" in values else fmus.damped
    there = call(states.half, fmu, tmp_path / "state", values)
    assert call(states.other_half, fmu, tmp_path / "state") == there


def test_a_state_with_a_record_needs_the_same_record(fmus: Fmus, tmp_path: Path) -> None:
    record = tmp_path / "pulse.csv"
    record.write_text("time,base.ax\n0,0\n0.3,1.5\n0.7,-1.2\n1.5,0\n")
    with_record: dict[str, float | str] = {"base.record": str(record)}
    there = call(states.half, fmus.damped, tmp_path / "state", with_record)
    assert call(states.other_half, fmus.damped, tmp_path / "state") == there
    assert call(states.back, fmus.damped, with_record)
    assert call(states.half, fmus.damped, tmp_path / "other", {}) != there
    record.write_text("time,base.ax\n0,0\n0.3,1.5\n0.7,-1.3\n1.5,0\n")
    assert "its samples are not those" in refused(fmus.damped, tmp_path / "state")


def refused(fmu: Path, state: Path) -> str:
    """Return the line that an instance logs about a state that is not its own; fails unless it is then as good as
    before.
    """
    done = ended(states.refused, fmu, state)
    assert done.returncode == 0, done.stderr
    (line,) = done.stderr.strip().splitlines()
    return line


def test_foreign_and_damaged_states_are_refused_with_a_reason(fmus: Fmus, tmp_path: Path) -> None:
    state = tmp_path / "state"
    call(states.half, fmus.damped, state, {})
    assert "that of another column" in refused(fmus.phocas, state)
    changed = tmp_path / "project"
    changed.mkdir()
    (changed / "solver").symlink_to(ROOT / "solver")
    shutil.copy(ROOT / "build_fmu.py", changed)  # not a link, which Python would follow to the project
    (changed / "fmu_src").mkdir()
    (changed / "fmu_src" / "native").symlink_to(ROOT / "fmu_src" / "native")
    for file in (ROOT / "fmu_src").glob("*.py"):
        text = file.read_text()
        (changed / "fmu_src" / file.name).write_text(text + "# changed\n" if file.name == "state.py" else text)
    column = ROOT / "examples/columns/phocas-damped.toml"
    run(sys.executable, changed / "build_fmu.py", column, "-o", tmp_path / "changed.fmu", PYTHONPATH=str(changed))
    assert "made by another version" in refused(tmp_path / "changed.fmu", state)
    data = state.read_bytes()
    for damaged in (data[:-1], data[:2000] + bytes([data[2000] ^ 1]) + data[2001:], b"", b"nonsense"):
        state.write_bytes(damaged)
        assert "not those of a serialized state" in refused(fmus.damped, state)
