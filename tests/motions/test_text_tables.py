"""Tables in text files: what looks like samples and is something else is refused by name, in every command."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.record_files import DT, SAMPLES

from solver import InputError, InputWarning, Motion
from solver.ground.loads import load_from_file
from solver.ground.records import read_record
from solver.statics.calibrate import read_history

IN_G = SAMPLES / 9.80665
TIME = DT * np.arange(len(SAMPLES))
COMMA = "has a decimal comma, must be"


def rows_of(*columns: Any, mark: str = " ", digits: int = 5) -> str:
    return "".join(mark.join(f"{value:.{digits}f}" for value in row) + "\n" for row in zip(*columns, strict=True))


def read(tmp_path: Path, text: str, **given: Any) -> Motion:
    path = tmp_path / "record.txt"
    path.write_text(text, encoding="utf-8")
    return Motion.from_file(path, **given)


@pytest.mark.parametrize(
    ("text", "given"),
    [
        (rows_of(IN_G).replace(".", ","), {"dt": DT}),
        (rows_of(TIME, IN_G, mark=";").replace(".", ","), {}),
        (rows_of(TIME, IN_G, mark="\t").replace(".", ","), {}),
        (rows_of(TIME, IN_G).replace(".", ","), {"dt": DT}),
        (rows_of(TIME, IN_G, mark=",").replace(".", ","), {"dt": DT}),
        ("0;0,1\n0,01;0\n0,02;-1,5E-02\n", {}),
        ("0 ,1\n1 ,5\n", {}),
    ],
)
def test_decimal_commas_are_refused_where_they_are(tmp_path: Path, text: str, given: dict[str, float]) -> None:
    """Refuse to take them for two samples each: twice as many, 20 times as strong."""
    with pytest.raises(InputError, match=rf"record\.txt: line 1: [-\d,]+ {COMMA} [-\d.]+ with a decimal point"):
        read(tmp_path, text, units="g", **given)


@pytest.mark.parametrize("text", ["0, 1\n1, -2\n", "0.0,1\n1.0,2\n", "0,+1\n1,-2\n", "0 , 12\n1 , 15\n", "0,1.\n1,2\n"])
def test_commas_between_columns_stay(tmp_path: Path, text: str) -> None:
    motion = read(tmp_path, text, units="m/s2")
    np.testing.assert_array_equal(motion.time, [0.0, 1.0])
    assert motion.ax[1] in (-2.0, 2.0, 15.0)


@pytest.mark.parametrize("mark", [" ", ";", "\t"])
@pytest.mark.parametrize("value", ["12,5", "-14,9", "1,2e-1", "1,100.5", "-1,250", "1,234,567.5", "1.100,5"])
def test_commas_of_numbers_are_refused_beside_points(tmp_path: Path, mark: str, value: str) -> None:
    """Refuse 12,5 whatever has a point in the row: it was read as ax = 12 and az = 5."""
    text = f"0.00{mark}1.5\n0.01{mark}{value}\n0.02{mark}2.5\n"
    for given in ({}, {"dt": DT}):
        with pytest.raises(InputError, match=r"line 2: .*(decimal comma|must have no comma within a number)"):
            read(tmp_path, text, units="cm/s2", **given)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("900.5\n1,100.5\n-1,250.0\n800.0\n", 2),
        ("0.5\n1,5\n-2,5\n", 2),
        ("0,5\n1\n-2,5\n", 1),
        ("0,5\n-1,5\n2\n", 1),
        ("0.5\n1.5\n2,5\n", 3),
    ],
)
def test_commas_of_single_numbers_are_refused(tmp_path: Path, text: str, line: int) -> None:
    """Refuse four rows of one value each that were read as five or six samples."""
    with pytest.raises(InputError, match=rf"line {line}: .*(decimal comma|must have no comma within a number)"):
        read(tmp_path, text, units="cm/s2", dt=DT)


@pytest.mark.parametrize(
    "text",
    [
        "0.00,0.1,0.2\n0.01,0.3,0.4\n",
        "0.00, 0.1, 0.2\n0.01, 0.3, 0.4\n",
        "0.00, 0.1, 0.2, \n0.01, 0.3, 0.4,\n",
        "0.00 , 0.1 , 0.2\n0.01 ,0.3 ,0.4\n",
        "  0.00,   0.1,0.2   \n  0.01,0.3,   0.4   \n",
        "0.00,\t0.1,\t0.2\n0.01\t0.3 \t 0.4\n",
        "0;0.1;0.2;\n0.01;.3;4E-1\n",
    ],
)
def test_three_columns_are_read_with_every_separator(tmp_path: Path, text: str) -> None:
    motion = read(tmp_path, text, units="m/s2")
    assert [motion.time.tolist(), motion.ax.tolist(), motion.az.tolist()] == [[0.0, 0.01], [0.1, 0.3], [0.2, 0.4]]


def test_rows_of_samples_between_commas_may_end_early(tmp_path: Path) -> None:
    assert len(read(tmp_path, "0.1,1.2\n-0.3,0.4\n0.5\n", units="m/s2", dt=DT).ax) == 5


@pytest.mark.parametrize("empty", ["\t\t", "\t \t", ",,", "; ;"])
def test_a_field_without_a_number_is_refused(tmp_path: Path, empty: str) -> None:
    with pytest.raises(InputError, match=r"line 2: '0\.01.*': has no number between two separators, must have one"):
        read(tmp_path, f"0.00{empty[0]}0.1\n0.01{empty}0.1\n", units="m/s2")


def test_every_command_reads_tables_alike(tmp_path: Path) -> None:
    """Read them between semicolons; decimal commas are named with their line."""
    path = tmp_path / "table.csv"
    good, bad = "time;value\n0;0.5\n1;1.5\n2;0.25\n", "time;value\n0;0,5\n1;1,5\n2;0,25\n"
    for reads in (load_from_file, read_history):
        path.write_text(good, encoding="utf-8")
        time, values = reads(path)
        assert (time.tolist(), values.tolist()) == ([0.0, 1.0, 2.0], [0.5, 1.5, 0.25])
        path.write_text(bad, encoding="utf-8")
        with pytest.raises(InputError, match=rf"table\.csv: line 2: 0,5 {COMMA} 0\.5"):
            reads(path)
        path.write_text("time,value\n0,01,0,5\n0,02,1,5\n", encoding="utf-8")
        with pytest.raises(InputError, match="line 2: 4 values, must be 2 as in the header; are these decimal commas"):
            reads(path)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 7])
def test_tables_of_times_are_not_rows_of_samples(tmp_path: Path, count: int) -> None:
    """Check that with dt every number is a sample; the first column of these is none."""
    text = rows_of(TIME, *[k * IN_G for k in range(1, count)])
    for lines in (text, text + "1.0\n", rows_of(1.7e9 + TIME, *[IN_G] * (count - 1))):
        with pytest.raises(InputError, match="dt: must be left out, the first column increases as times do") as caught:
            read(tmp_path, lines, units="g", dt=DT)
        assert ("keep the columns of time and acceleration" in str(caught.value)) == (count > 3)
    if count > 3:
        with pytest.raises(
            InputError, match=r"line 1: \d values, must be .*; keep the columns of time and acceleration"
        ):
            read(tmp_path, text, units="g")


def test_samples_in_many_columns_stay_samples(tmp_path: Path) -> None:
    for each in (4, 5, 8):
        text = "\n".join(" ".join(f"{value:.5f}" for value in IN_G[k : k + each]) for k in range(0, 200, each))
        np.testing.assert_allclose(read(tmp_path, text, units="g", dt=DT).ax, SAMPLES, atol=1e-4)


def test_times_of_too_few_digits_are_refused_with_dt_too(tmp_path: Path) -> None:
    text = rows_of(0.5 * TIME, IN_G, digits=2)
    with pytest.raises(InputError, match=r"line \d: time = 0\.\d+: must be later than the row before"):
        read(tmp_path, text, units="g")
    with pytest.raises(InputError, match="some are equal: write more digits, or keep the accelerations alone"):
        read(tmp_path, text, units="g", dt=0.5 * DT)


@pytest.mark.parametrize("begin", [1_700_000_000, 1_700_000_000_000, -2_000_000_000])
@pytest.mark.parametrize("header", ["", "time,base.ax\n"])
def test_times_since_1970_begin_at_0_and_it_is_said(tmp_path: Path, begin: int, header: str) -> None:
    """Check that the motion is that of times from 0, to the bit."""
    mark = "," if header else " "
    text = header + "".join(f"{begin + k // 100}.{k % 100:02d}{mark}{a:.6f}\n" for k, a in enumerate(SAMPLES))
    if begin < 0:
        text = header + "".join(f"{begin + k}.0{mark}{a:.6f}\n" for k, a in enumerate(SAMPLES))
    given = {} if header else {"units": "m/s2"}
    with pytest.warns(InputWarning, match=rf"record\.txt: times begin at 0 instead of {begin}\.0"):
        motion = read(tmp_path, text, **given)
    step = 1.0 if begin < 0 else 0.01
    np.testing.assert_array_equal(motion.time, [float(f"{step * k:.2f}") for k in range(200)])


def test_times_that_keep_their_digits_stay(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read(tmp_path, rows_of(5000.0 + TIME, IN_G), units="g").start == 5000.0
        # nothing to shift, however close two times are
        assert read(tmp_path, "time,base.ax\n0,0\n1e-11,1\n100,0\n").start == 0.0


@pytest.mark.parametrize("header", ["", "time,base.ax\n"])
def test_a_gap_between_samples_is_said(tmp_path: Path, header: str) -> None:
    mark, given = (",", {}) if header else (" ", {"units": "m/s2"})

    def file(last: float, before: float, after: float) -> str:
        rows = [*((0.01 * k, 1.0) for k in range(10)), (0.1, before), (last, after), (last + 0.01, 0.0)]
        return header + "".join(f"{t:.6g}{mark}{a}\n" for t, a in rows)

    said = (
        r"record\.txt: no samples between 0\.1 and 5\.09 s, others are 0\.01 s apart: .* should be filled or the record"
    )
    for before, after in ((1.0, 2.0), (0.0, 2.0), (1.0, 0.0)):
        with pytest.warns(InputWarning, match=said):
            read(tmp_path, file(5.09, before, after), **given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(tmp_path, file(5.09, 0.0, 0.0), **given)  # a pause between zeros, in which nothing is interpolated
        read(tmp_path, file(0.295, 1.0, 2.0), **given)  # 19.5 steps
    with pytest.warns(InputWarning, match="no samples between"):
        read(tmp_path, file(0.305, 1.0, 2.0), **given)  # 20.5 steps


@pytest.mark.parametrize(
    "head", ["1\n0.01\n", "9.81 0.01\n", "200 0.01\n", "0.01 200\n", "200\n", "200\n0.02\n", "0.01\n981\n"]
)
def test_numbers_of_a_header_are_no_samples(tmp_path: Path, head: str) -> None:
    """Check a count or a factor, and the step, above the samples."""
    with pytest.raises(InputError, match="look like a header; must begin with # to be left out"):
        read(tmp_path, head + rows_of(IN_G), units="g", dt=DT)
    marked = "".join(f"# {line}\n" for line in head.splitlines())
    assert len(read(tmp_path, marked + rows_of(IN_G), units="g", dt=DT).ax) == 200


def test_a_sample_may_equal_the_step(tmp_path: Path) -> None:
    samples = [0.0, 0.01, 0.02, 0.01, 0.0, -0.01]
    assert read(tmp_path, rows_of(samples), units="m/s2", dt=0.01).ax.tolist() == samples


@pytest.mark.parametrize("head", ["time,acc", "Time;Acceleration", "time (s)\tacc (g)", '"Time","Acc"'])
def test_a_heading_of_others_is_refused_with_what_to_change(tmp_path: Path, head: str) -> None:
    path = tmp_path / "record.txt"
    path.write_text(head + "\n0.0 0.1\n0.5 0.2\n", encoding="utf-8")
    for units in ("g", None):
        with pytest.raises(InputError, match=r"line 1: .*put # before (this|a) line"):
            read_record(path, units=units)
    path.write_text(f"# {head}\n0.0 0.1\n0.5 0.2\n", encoding="utf-8")
    assert read_record(path, units="m/s2").ax.tolist() == [0.1, 0.2]
