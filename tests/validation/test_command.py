"""`python -m validation`: lists, skips for want of data, reads made tests, and answers wrong files in one line."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.fmus import ROOT

sys.path.insert(0, str(ROOT))  # the cases are not installed

from solver import InputError
from validation import command_line, rocks
from validation.cases import CASES, codes, drums, failure_amplitudes, shaken_rocks, size
from validation.cases.shaken_rocks import Model

STILL = np.zeros(200)
G = 9.80665
COLUMN = """
name = "two"
[[block]]
repeat = 2
height = 1.0
width = 0.4
depth = 0.4
density = 2500.0
joint = { stiffness = 1e9, damping = 3e-3 }
"""


def write_test(folder: Path, number: int, ax: np.ndarray) -> None:
    """Return a file as the shaking table writes it; ax in g over an offset of 0.02 g."""
    time = rocks.SAMPLE * np.arange(len(ax))
    rows = np.column_stack([time, ax + 0.02, time, ax, time, ax, time, ax])
    header = "\t".join(["Time [s]", "Amplitude"] * 4)
    np.savetxt(folder / f"Test{number:03d}.txt", rows, delimiter="\t", header=header, comments="", fmt="%.9g")


@pytest.fixture
def made(tmp_path: Path) -> Path:
    """Return 24 tests of a rock that falls from a certain velocity on; a 25th has an empty file."""
    openpyxl = pytest.importorskip("openpyxl", reason="reads the table of outcomes; pip install openpyxl")
    folder = tmp_path / rocks.REPOSITORY / rocks.FOLDER
    folder.mkdir(parents=True)
    book = openpyxl.Workbook()
    book.active.append(["Test Number", *(f"column {k}" for k in range(15))])
    for k in range(25):
        amplitude = 0.05 + 0.03 * k
        pulse = amplitude * np.sin(2.0 * np.pi * np.arange(400) / 400.0)
        write_test(folder, 11 + k, np.concatenate([STILL, pulse, STILL]))
        book.active.append([11 + k, int(k > 11), int(k > 15), *[int(k > 12)] * 13])
    (folder / "Test035.txt").write_text("")
    book.save(folder / "Results_Granite.xlsx")
    return tmp_path


def test_every_case_says_what_is_fitted(capsys: pytest.CaptureFixture[str]) -> None:
    assert command_line.main(["--list"]) == 0
    text = capsys.readouterr().out
    assert all(case.name in text and case.fitted in text and case.predicted in text for case in CASES)
    assert len({case.name for case in CASES}) == len(CASES)
    assert all(case.source and case.model for case in CASES)


@pytest.mark.long  # takes seconds
def test_the_command_starts_in_a_process_of_its_own() -> None:
    run = [sys.executable, "-m", "validation", "--list"]
    said = subprocess.run(run, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (said.returncode, said.stderr) == (0, "")
    assert "free-rocking" in said.stdout


def test_without_its_data_a_case_is_skipped_and_says_where_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command_line.main(["--only", "rocks", "--output-folder", str(tmp_path)]) == 0
    assert f"skipped: needs --data FOLDER to hold {rocks.REPOSITORY}: git clone https://" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []
    assert command_line.main(["--data", str(tmp_path / "none"), "--output-folder", str(tmp_path)]) == 2


def test_tests_are_read_with_their_units(made: Path) -> None:
    tests = rocks.read(made)
    assert tests.numbers.tolist() == list(range(11, 35))  # the empty file is left out
    pulse, length = 0.05 * G, 400 * rocks.SAMPLE
    assert tests.motions[0].pga == pytest.approx(pulse, rel=1e-6)  # the offset is taken off
    assert tests.pgv[1] / tests.pgv[0] == pytest.approx(0.08 / 0.05, rel=1e-4)
    assert 0.5 * pulse * length / np.pi < tests.pgv[0] <= pulse * length / np.pi  # the drift of the pulse is taken off
    assert tests.fallen["specimen 2"].sum() == 8
    assert tests.elements["specimen 1"].shape == (5, 24)


def test_wrong_files_are_named(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = made / rocks.REPOSITORY / rocks.FOLDER
    (folder / "Test012.txt").write_text("Time\tAmplitude\n0\tx\n")
    with pytest.raises(InputError, match=r"Test012\.txt: must have a header"):
        rocks.read(made)
    write_test(folder, 12, STILL)
    (folder / "Test012.txt").write_text("a\tb\n0\t0\n0.01\t0\n")
    assert command_line.main(["--only", "rocks", "--data", str(made), "--output-folder", str(made / "out")]) == 2
    assert "samples are 0.01 s apart, must be 0.00125" in capsys.readouterr().err


@pytest.mark.long  # takes seconds
def test_the_case_finds_a_rock_that_was_made_of_its_own_model(
    made: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(shaken_rocks, "MODELS", {"upright": Model(), "low": Model(height=0.6)})
    monkeypatch.setattr(shaken_rocks, "SPLITS", 4)
    tests = rocks.read(made)
    known = shaken_rocks.bank({"upright": Model()}, tests.motions)["upright"][6] == 1.0
    assert 0 < known.sum() < len(known)
    monkeypatch.setattr(shaken_rocks, "read", lambda data: replace(tests, fallen={"specimen 1": known}))
    case = next(case for case in CASES if case.name == "rocks")
    command_line.run(case, made, tmp_path)
    said = json.loads((tmp_path / "rocks.json").read_text())["numbers"]["specimen 1"]
    assert said["one block, one ratio"][0] > 0.85  # 0.896: 12 tests to fit on, a grid of 14 ratios
    assert said["one block, one ratio"][0] > said["stands, always"][0]
    assert (tmp_path / "validation-rocks.png").stat().st_size > 10_000


def test_what_is_not_finite_is_null_in_json() -> None:
    assert command_line.plain({"a": [np.float64(np.nan), 1.0], "b": np.array([True])}) == {
        "a": [None, 1.0],
        "b": [True],
    }


def test_measured_columns_are_placed_in_an_ensemble(tmp_path: Path) -> None:
    folder = tmp_path / drums.FOLDER
    folder.mkdir()
    (folder / "column.toml").write_text(COLUMN)
    time = 0.01 * np.arange(101)
    rows = np.column_stack([time, 3.0 * np.sin(2.0 * np.pi * time)])
    np.savetxt(folder / "pulse.csv", rows, delimiter=",", header="time,base.ax", comments="")
    (folder / "tests.csv").write_text(
        "column,motion,scale,fell,peak,residual\ncolumn.toml,pulse.csv,0.2,0,100.0,\ncolumn.toml,pulse.csv,9,1,,\n"
    )
    small, on_rims, large, _ = drums.compute(tmp_path, (0.1,)).numbers.values()
    assert (on_rims["share"], on_rims["peak"]) == (0.0, 1.0)
    assert small["share"] == 0.0
    assert small["peak"] == 1.0  # all of the ensemble move by less than 100 m
    assert np.isnan(small["residual"])  # not measured
    assert large["share"] == 1.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("column,motion\n", "line 1: must be column,motion,scale,fell,peak,residual"),
        ("column,motion,scale,fell,peak,residual\na,b,1,yes,,\n", "line 2: fell = 'yes': must be 1, or 0 if it stood"),
        ("column,motion,scale,fell,peak,residual\na,b,x,1,,\n", "line 2: scale = 'x': must be a number"),
    ],
)
def test_a_wrong_table_of_tests_is_answered_in_one_line(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "tests.csv").write_text(text)
    with pytest.raises(InputError) as wrong:
        drums.read(tmp_path)
    assert str(tmp_path / "tests.csv") in str(wrong.value)
    assert said in str(wrong.value)


def test_blocks_of_one_shape_are_compared_far_from_overturning() -> None:
    heights = np.array(size.HEIGHTS)
    peak = np.outer(np.ones(len(heights)), [0.05, 0.08])  # m: the same for all sizes
    fallen = np.zeros(peak.shape, dtype=bool)
    fallen[0, 0] = True
    rows = size.compared(peak, fallen, heights)
    assert [row["far"] for row in rows] == [1, 2, 2, 2, 2]  # of 2 m: one fell, the other is within 0.3 of 0.30 m
    assert all(row["ratio"][1] == pytest.approx(1.0) for row in rows)


def test_seven_drums_are_those_of_the_example() -> None:
    column = codes.column(4e9, 0.0)
    assert sum(block.height for block in column.blocks) == pytest.approx(5.95)
    assert (column.blocks[-1].width, column.blocks[0].top_width) == pytest.approx((1.11, 0.90))
    assert sum(block.mass for block in column.blocks) == pytest.approx(2620.0 * 5.95 * 0.5 * (1.11 + 0.90))
    motion = codes.pulse()
    for t in (0.4, 1.2, 2.0):  # s
        assert motion.acceleration(t)[0] == pytest.approx(codes.acceleration(t))


def test_strongest_pulse_overturns_the_seven_drums_and_the_weakest_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(failure_amplitudes, "amplitudes", lambda length: np.array([0.15, 0.3]))
    whole = codes.column(5e10, 1e-3)
    assert failure_amplitudes.limits(whole, 0.8) == (0.3, 0.15)  # g; limit analysis has 0.19 as the least that uplifts


def test_amplitudes_reach_the_stated_impulse() -> None:
    for length in failure_amplitudes.LENGTHS:
        tried = failure_amplitudes.amplitudes(length)
        assert tried[0] == pytest.approx(failure_amplitudes.LEAST)
        assert tried[-1] * length <= failure_amplitudes.IMPULSE < tried[-1] * length * failure_amplitudes.RATIO
