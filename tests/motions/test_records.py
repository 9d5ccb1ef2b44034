"""One record reads to the same samples from every format, and a wrong file ends in one line that says what is right."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.record_files import (
    CASES,
    DT,
    ENCODINGS,
    SAMPLES,
    Case,
    at2,
    cosmos_v1c,
    cosmos_v2,
    csmip_v1,
    csmip_v2,
    csv,
    esm,
    geonet,
    knet,
    plain,
    smc,
)

from solver import InputError, Motion
from solver.ground.records import NAMES, format_of, read_record
from stress.fuzz_files import mutated

MORE = ("cosmos v2", "plain in g", "plain in cm/s2")  # to be spoiled besides the last file of each format


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_every_format_gives_the_same_samples(tmp_path: Path, case: Case, encoding: str) -> None:
    path = tmp_path / "record"
    path.write_bytes(ENCODINGS[encoding](case.text))
    record = read_record(path, **case.given)
    assert record.format == case.format == format_of(path)
    assert len(record.time) == len(SAMPLES)
    np.testing.assert_allclose(record.time, DT * np.arange(len(SAMPLES)), rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(record.ax, SAMPLES, rtol=0.0, atol=case.off)
    np.testing.assert_array_equal(record.az, 0.0)
    motion = Motion.from_file(path, **case.given)
    np.testing.assert_array_equal(motion.ax, record.ax)
    assert motion.duration == pytest.approx(1.99, rel=1e-12)


def test_the_synthetic_record_uses_the_digits_of_its_formats() -> None:
    """Check that a tolerance is worth nothing if the samples are smaller than it; and columns do touch."""
    assert np.max(np.abs(SAMPLES)) > 1.0
    assert max(case.off for case in CASES.values()) < 1e-5
    assert len(re.findall(r"E[-+]\d\d-\.", CASES["at2 touching"].text)) > 50
    assert len(re.findall(r"\d-\d", csmip_v2())) > 5


def test_a_record_says_what_it_is_and_what_was_done(tmp_path: Path) -> None:
    path = tmp_path / "record"
    path.write_text(knet())
    record = read_record(path)
    assert record.title == "2006/01/18 23:25:00 TST002 N-S"
    (note,) = record.notes
    assert float(note.split()[2]) == pytest.approx(8003.0, abs=0.1)  # rounding of 200 counts: 0.01 measured
    assert note.endswith("taken away")
    assert abs(np.mean(record.ax)) < 1e-15  # 1e-17 measured
    path.write_text(esm())
    assert read_record(path).title == "TESTVILLE XX-2000-0001 XX TST HNE"
    path.write_text(at2())
    assert read_record(path).title == "TESTVILLE 01/01/00, D\u00fczce, 090"
    assert read_record(path).notes == ()


def test_a_third_plain_column_is_vertical(tmp_path: Path) -> None:
    path = tmp_path / "record.txt"
    path.write_text("% t ax az\n5.0 0.1 0.2\n5.5, 0.3, 0.4\n6.5;-.5;6D-1\n")
    motion = Motion.from_file(path, units="m/s2")
    np.testing.assert_array_equal(motion.time, [5.0, 5.5, 6.5])
    np.testing.assert_array_equal(motion.ax, [0.1, 0.3, -0.5])
    np.testing.assert_array_equal(motion.az, [0.2, 0.4, 0.6])


@pytest.mark.parametrize("count", [57, 29, 200])
def test_a_duration_of_knet_that_is_not_whole_in_float64_gives_its_samples(tmp_path: Path, count: int) -> None:
    """Check 57 samples of 0.57 s at 100 Hz: the product is 56.99999999999999 in float64."""
    head, counts = knet().split("Memo.\n")
    rows = "\n".join(counts.split()[:count])
    path = tmp_path / "record"
    path.write_text(f"{head.replace('Time(s)  2', f'Time(s)  {count / 100}')}Memo.\n{rows}\n")
    assert len(read_record(path).ax) == count


def test_a_key_of_esm_may_be_repeated_with_its_value(tmp_path: Path) -> None:
    path = tmp_path / "record"
    path.write_text(esm().replace("UNITS: cm/s^2", "UNITS: cm/s^2\nUNITS:  cm/s^2"))
    np.testing.assert_allclose(read_record(path).ax, SAMPLES, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(
    ("text", "given", "said"),
    [
        # nothing is guessed
        (plain(), {}, f"no known header ({', '.join(NAMES)}): units must be given (--units)"),
        (plain(), {"dt": 0.01}, f"no known header ({', '.join(NAMES)}): units must be given (--units)"),
        (plain(), {"units": "g"}, "line 2: 1 values, must be time, ax and perhaps az, or dt must be given"),
        (plain(), {"dt": 0.01, "units": "mm/s2"}, "units = 'mm/s2': must be g, m/s2 or cm/s2"),
        (plain(), {"dt": 0.01, "units": "G-force"}, "units = 'G-force': must be g, m/s2 or cm/s2"),
        (plain(), {"dt": -0.01, "units": "g"}, "dt = -0.01: must be a positive time in s"),
        (plain(), {"dt": 0.01, "units": "g", "channel": 1}, "channel = 1: must be left out"),
        (
            "0 1\n.01 2\n.02 3\n",
            {"dt": 0.01, "units": "g"},
            "dt: must be left out, the first column increases as times",
        ),
        ("0 1\n.01 2\n.01 3\n", {"units": "g"}, "line 3: time = 0.01: must be later than the row before, 0.01 s"),
        ("0 1\n.01 2\n.02\n", {"units": "g"}, "line 3: 1 values, must be time, ax and perhaps az"),
        (
            "a title\n1\n2\n",
            {"dt": 0.01, "units": "g"},
            "line 1: 'a title': must be numbers; put # before",
        ),
        ("1.,2.\n3., ,4.\n", {"dt": 0.01, "units": "g"}, "line 2: '3., ,4.': has no number between two separators"),
        ("1\n2.0.1\n", {"dt": 0.01, "units": "g"}, "line 2: '2.0.1': must be a finite number"),
        ("1\n", {"dt": 0.01, "units": "g"}, "1 samples, must be at least 2"),
        ("", {"dt": 0.01, "units": "g"}, "0 samples, must be at least 2"),
        ("", {}, "no known header"),
        ("0 1\n", {"units": "g"}, "1 rows of samples, must be at least 2"),
        ("1\0\n2\n", {"dt": 0.01, "units": "g"}, "is not text"),
        # what says all itself
        (at2(), {"units": "g"}, "units = 'g': must be left out, the file is PEER AT2 and says all itself"),
        (at2(), {"dt": 0.01}, "dt = 0.01: must be left out, the file is PEER AT2 and says all itself"),
        (csv(), {"channel": 2}, "channel = 2: must be left out, the file is CSV and says all itself"),
        # PEER: other quantities
        (
            at2(units="VELOCITY TIME HISTORY IN UNITS OF CM/S"),
            {},
            "line 3: 'VELOCITY TIME HISTORY IN UNITS OF CM/S': must be accelerations",
        ),
        (
            at2(units="Velocity time series in units of G"),
            {},
            "line 3: 'Velocity time series in units of G': must be accelerations",
        ),
        (at2(units="DISPLACEMENT IN UNITS OF G"), {}, "line 3: 'DISPLACEMENT IN UNITS OF G': must be accelerations"),
        (at2().replace("\n", "\n\n", 1), {}, "no known header"),
        # ESM
        (esm().replace("UNITS: cm/s^2", "UNITS: mm/s^2"), {}, "line 13: units = 'mm/s^2': must be g, m/s2 or cm/s2"),
        (esm().replace("UNITS: cm/s^2", "UNITS: "), {}, "line 13: units = '': must be g, m/s2 or cm/s2"),
        (esm().replace("UNITS", "UNIT"), {}, "UNITS: is missing in the header, which ends before line 19"),
        (esm().replace("DATA_TYPE", "TYPE"), {}, "DATA_TYPE: is missing in the header, which ends before line 19"),
        (
            esm().replace("UNITS: cm/s^2", "UNITS: cm/s^2\nUNITS: g"),
            {},
            "line 14: UNITS = 'g': must be 'cm/s^2' as in line 13",
        ),
        (
            esm().replace("NDATA", "SAMPLING_INTERVAL_S: 0.005\nNDATA"),
            {},
            "line 11: SAMPLING_INTERVAL_S = '0.005': must be '0.010000' as in line 10",
        ),
        (esm().replace(": ACCELERATION", ": VELOCITY"), {}, "line 17: DATA_TYPE = 'VELOCITY': must be ACCELERATION"),
        (esm().replace("NDATA: 200", "NDATA: 201"), {}, "200 samples found, must be 201 as NDATA says in line 11"),
        (esm().replace("S: 0.010000", "S: "), {}, "line 10: '': must be a finite number"),
        (esm() + "end\n", {}, "line 219: 'end': must be a finite number"),
        # K-NET
        (
            knet().replace("100Hz", "100"),
            {},
            "line 11: 'Sampling Freq(Hz) 100': must be like 'Sampling Freq(Hz) 100Hz'",
        ),
        (knet().replace("100Hz", "0Hz"), {}, "line 11: 'Sampling Freq(Hz) 0Hz': must be like"),
        (knet().replace("(gal)/6", "(V)/6"), {}, "line 14: units = 'V': must be g, m/s2 or cm/s2"),
        (knet().replace("/6182761", "/0"), {}, "line 14: 'Scale Factor      3920(gal)/0': must be like"),
        (knet().replace("Time(s)  2", "Time(s)  3"), {}, "200 samples found, must be 300 as lines 11 and 12 say"),
        (knet().replace("Time(s)  2", "Time(s)  2.004"), {}, "200 samples found, must be 200.4 as lines 11 and 12 say"),
        (knet().replace("Memo.\n", ""), {}, "line 17: must begin with 'Memo', the last of 17 header lines"),
        (knet().replace("     8003", "     8oo3", 1), {}, "line 39: '8oo3': must be a finite number"),
        # COSMOS
        (cosmos_v2(2), {}, "2 channels: channel must be given, one of 1 90 deg, 2 180 deg"),
        (cosmos_v2(2), {"channel": 3}, "channel = 3: must be 1 to 2"),
        (cosmos_v2(2), {"channel": 0}, "channel = 0: must be 1 to 2"),
        (
            cosmos_v2().replace("cm/s^2 (4)", "counts (50)"),
            {},
            "line 45: units = 'counts': must be g, m/s2 or cm/s2 (counts",
        ),
        (
            cosmos_v2().replace("     0.010000", "  -999.000000"),
            {},
            "line 45: no sampling interval: value 34 of the real header",
        ),
        (cosmos_v2().replace("     200 acc", "     208 acc"), {}, "200 samples found, must be 208 as line 45 says"),
        (cosmos_v2().replace("acceleration pts", "velocity pts"), {}, "no block of accelerations, must have one"),
        (
            cosmos_v1c()
            .replace("acceleration pts", "raw accel. pts")
            .replace("units=g.     (02)", "units= counts(50),"),
            {},
            "line 45: units = 'counts': must be g, m/s2 or cm/s2 (counts are raw: take the V1 or V2 file)",
        ),
        (smc().replace("       200", "       201"), {}, "200 samples found, must be 201 as line 14 says"),
        (smc().replace("0.1000000E+03", "0.1700000E+39"), {}, "line 18: no samples a second"),
        (geonet(), {}, "2 channels: channel must be given, one of 1 N10E, 2 Up"),
        (geonet(), {"channel": 3}, "channel = 3: must be 1 to 2"),
        (csmip_v1(), {}, "2 channels: channel must be given, one of 1 90 Deg, 2 180 Deg"),
        (csmip_v1("in/s2"), {"channel": 1}, "line 28: units = 'in/s2': must be g, m/s2 or cm/s2"),
        (
            csmip_v2().replace("  200 points of accel", "  201 points of accel"),
            {},
            "200 samples found, must be 201 as line 3",
        ),
        (csmip_v2().replace("in cm/sec2.", "in in/sec2."), {}, "line 3: units = 'in/sec2': must be g, m/s2 or cm/s2"),
    ],
)
def test_a_wrong_record_ends_in_one_line(tmp_path: Path, text: str, given: dict[str, Any], said: str) -> None:
    path = tmp_path / "record"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        Motion.from_file(path, **given)
    assert str(caught.value).startswith(f"{path}: {said}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "units"),
    [(name, units) for name, units in (("g", 9.80665), ("m/s2", 1.0), ("cm/s2", 0.01), ("Gal", 0.01))],
)
@pytest.mark.parametrize("spelling", ["{}", " {} ", "{}^"])
def test_units_go_by_their_usual_spellings(tmp_path: Path, name: str, units: float, spelling: str) -> None:
    spelt = spelling.format(name).replace("/s2^", "/s^2").rstrip("^")
    path = tmp_path / "record"
    path.write_text("0 1\n1 2\n")
    for word in {spelt, spelt.upper(), spelt.replace("/s2", "/sec/sec"), spelt.replace("/s2", "/s**2")}:
        np.testing.assert_array_equal(read_record(path, units=word).ax, [units, 2.0 * units])


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
@pytest.mark.parametrize("name", [*{case.format: name for name, case in CASES.items()}.values(), *MORE])
def test_a_spoiled_record_is_read_or_refused_in_one_line(tmp_path: Path, name: str, data: st.DataObject) -> None:
    """Cut, double, move or overwrite its first lines: no other error, no number that is none."""
    case = CASES[name]
    lines = case.text.splitlines(keepends=True)
    first = 52 if "cosmos" in name else 22
    path = tmp_path / "record"
    path.write_bytes(data.draw(mutated("".join(lines[:first]))) + "".join(lines[first:]).encode())
    said = f"{path}: "
    try:
        assert np.all(np.isfinite(Motion.from_file(path, **case.given).ax))
    except InputError as error:
        said = str(error)
    assert said.startswith(f"{path}: ")
    assert "\n" not in said


@pytest.mark.parametrize(
    ("head", "name"),
    [
        ("FILE     0 OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I:", "USC and Caltech Volume I and II"),
        ("* VOL1DS FILE:  1/01", "BHRC V1"),
        ("UNCORRECTED ACCELEROGRAM DATA    PROCESSED: 01/01/00", "RENADIC V1 and CSMIP V1 before 1999"),
        ("Response and Fourier amplitude spectra (86 periods)", "CSMIP V3 (spectra)"),
        ("STRONG GROUND MOTION RECORDS OF TURKIYE", "NSMN (Turkey)"),
        ("****\n      INSTITUTO DE INGENIERIA, UNAM", "UNAM"),
        ("#Earthquake Information", "CWB (Taiwan)"),
    ],
)
def test_formats_that_are_not_read_are_refused_by_name(tmp_path: Path, head: str, name: str) -> None:
    path = tmp_path / "record"
    path.write_text(f"{head}\n0.00 0.1\n0.01 0.2\n")
    said = re.escape(f"{path}: {name} files are not read: convert with gmprocess (USGS)")
    with pytest.raises(InputError, match=said):
        Motion.from_file(path)
    if head.startswith("#"):
        assert Motion.from_file(path, units="m/s2").ax.tolist() == [0.1, 0.2]
