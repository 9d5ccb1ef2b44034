"""A base motion is what its source says, or one line about what is wrong with the source."""

import math
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.record_files import AT2

from solver.common.errors import InputError
from solver.ground.motion import STANDARD_GRAVITY, Motion

accelerations = st.lists(st.floats(-100.0, 100.0), min_size=2, max_size=20)
examples = settings(max_examples=50)
steps = st.sampled_from([1e-3, 0.005, 0.01, 0.02, 0.1])


def written(folder: Path, text: str, name: str = "motion.txt") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def assert_same(one: Motion, other: Motion) -> None:
    for name in ("time", "ax", "az"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (one.hold, one.amplitude, one.frequency) == (other.hold, other.amplitude, other.frequency)
    assert one.duration == pytest.approx(other.duration, rel=1e-12)


# harmonic


def test_harmonic_is_the_sine() -> None:
    motion = Motion.harmonic(0.05 * 9.80665, 1.5, 4.0)
    t = np.linspace(0.0, 4.0, 101)
    ax, az = motion.acceleration(t)
    np.testing.assert_array_equal(ax, 0.05 * 9.80665 * np.sin(2.0 * np.pi * 1.5 * t))
    np.testing.assert_array_equal(az, 0.0)
    assert (motion.start, motion.end, motion.duration) == (0.0, 4.0, 4.0)


@pytest.mark.parametrize(
    ("frequency", "duration", "peak"), [(1.0, 10.0, 1.0), (1.0, 0.25, 1.0), (1.0, 1.0 / 12.0, 0.5), (3.0, 0.2, 1.0)]
)
def test_pga_of_harmonic(frequency: float, duration: float, peak: float) -> None:
    assert Motion.harmonic(-2.0, frequency, duration).pga == pytest.approx(2.0 * peak, rel=1e-12)


def test_harmonic_begins_with_the_samples() -> None:
    time = np.array([5.0, 7.0])
    motion = Motion(time, np.ones(2), np.zeros(2), 2.0, amplitude=3.0, frequency=0.25)
    np.testing.assert_allclose(motion.acceleration([5.0, 6.0, 7.0])[0], [1.0, 4.0, 1.0], rtol=1e-15)
    assert motion.pga == pytest.approx(4.0)


# samples


def test_linear_samples() -> None:
    motion = Motion.from_samples(0.1, [0.0, 1.0, -3.0], [2.0, 0.0, 0.0])
    ax, az = motion.acceleration([0.0, 0.05, 0.15, 0.2])
    np.testing.assert_allclose(ax, [0.0, 0.5, -1.0, -3.0], rtol=1e-14)
    np.testing.assert_allclose(az, [2.0, 1.0, 0.0, 0.0], rtol=1e-14)
    assert motion.duration == 0.2
    assert motion.pga == 3.0


def test_held_samples() -> None:
    motion = Motion.from_samples(0.1, [0.0, 1.0, -3.0], hold=True)
    np.testing.assert_array_equal(motion.acceleration([0.0, 0.099, 0.1, 0.19, 0.25])[0], [0.0, 0.0, 1.0, 1.0, -3.0])
    assert motion.duration == pytest.approx(0.3)


def test_one_held_sample_is_enough() -> None:
    assert Motion.from_samples(0.5, [1.0], hold=True).duration == 0.5


@pytest.mark.parametrize("hold", [False, True])
def test_base_is_at_rest_outside(hold: bool) -> None:
    motion = Motion.from_samples(0.1, [1.0, 1.0], [1.0, 1.0], hold)
    for component in motion.acceleration([-1e-9, 0.0, motion.end, motion.end + 1e-9]):
        np.testing.assert_array_equal(component, [0.0, 1.0, 1.0, 0.0])


def test_acceleration_has_the_shape_of_t() -> None:
    motion = Motion.harmonic(1.0, 1.0, 1.0)
    assert motion.acceleration(0.25)[0] == 1.0
    assert motion.acceleration(np.zeros((2, 3)))[1].shape == (2, 3)


@examples
@given(steps, accelerations, st.booleans(), st.floats(-10.0, 10.0))
def test_scaled(dt: float, ax: list[float], hold: bool, factor: float) -> None:
    motion = Motion.from_samples(dt, ax, ax[::-1], hold)
    scaled = motion.scaled(factor)
    np.testing.assert_array_equal(scaled.ax, factor * motion.ax)
    np.testing.assert_array_equal(scaled.az, factor * motion.az)
    assert scaled.pga == abs(factor) * motion.pga


@examples
@given(steps, accelerations, st.booleans())
def test_mirrored_twice_is_the_same(dt: float, ax: list[float], hold: bool) -> None:
    motion = Motion.from_samples(dt, ax, ax[::-1], hold)
    np.testing.assert_array_equal(motion.mirrored().ax, -motion.ax)
    np.testing.assert_array_equal(motion.mirrored().az, motion.az)
    assert_same(motion.mirrored().mirrored(), motion)


def test_harmonic_scales_and_mirrors() -> None:
    motion = Motion.harmonic(1.0, 2.0, 3.0)
    assert motion.scaled(3.0).amplitude == 3.0
    assert motion.mirrored().amplitude == -1.0
    for half_turns in range(-5, 6):
        turned = motion.turned(half_turns * math.pi)
        assert (turned.amplitude, turned.amplitude_y) == (1.0 if half_turns % 2 == 0 else -1.0, 0.0)
    assert motion.turned(0.5 * math.pi).amplitude == 0.0


def test_a_motion_keeps_its_name(tmp_path: Path) -> None:
    harmonic = Motion.harmonic(1.0, 2.0, 3.0)
    assert {m.name for m in (harmonic, harmonic.scaled(2.0), harmonic.mirrored())} == {"a harmonic of 2 Hz"}
    Motion.from_samples(0.1, [0.0, 1.0, 0.0]).to_csv(tmp_path / "quake.csv")
    read = Motion.from_csv(tmp_path / "quake.csv")
    for motion in (read, Motion.from_file(tmp_path / "quake.csv"), read.scaled_to(3.0), read.with_vertical(read)):
        assert motion.name == "quake.csv"
    assert Motion.from_samples(0.1, [0.0, 1.0]).name == ""


def test_samples_are_copied_and_read_only() -> None:
    ax = np.ones(3)
    motion = Motion.from_samples(0.1, ax)
    ax[0] = 7.0
    assert motion.ax[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        motion.ax[0] = 7.0


# CSV


@examples
@given(steps, accelerations, st.booleans())
def test_csv_round_trip(tmp_path_factory: pytest.TempPathFactory, dt: float, ax: list[float], hold: bool) -> None:
    path = tmp_path_factory.getbasetemp() / "round-trip.csv"
    motion = Motion.from_samples(dt, ax, ax[::-1], hold)
    motion.to_csv(path)
    assert_same(Motion.from_csv(path, hold), motion)


@examples
@given(steps, accelerations, st.booleans())
def test_csv_with_slopes_round_trip(
    tmp_path_factory: pytest.TempPathFactory, dt: float, ax: list[float], hold: bool
) -> None:
    path = tmp_path_factory.getbasetemp() / "slopes.csv"
    motion = Motion.from_samples(dt, ax, ax[::-1], hold)
    motion.to_csv(path, slopes=True)
    assert_same(Motion.from_csv(path, hold), motion)


def test_csv_with_slopes_is_the_motion_wherever_a_step_begins(tmp_path: Path) -> None:
    motion = Motion.from_samples(0.02, [0.0, 1.0, -0.5, 0.25], [0.1, 0.2, 0.4, 0.0])
    motion.to_csv(tmp_path / "slopes.csv", slopes=True)
    names = (tmp_path / "slopes.csv").read_text(encoding="utf-8").splitlines()[0]
    assert names == "time,base.ax,base.az,base.jx,base.jz"
    time, ax, az, jx, jz = np.loadtxt(tmp_path / "slopes.csv", delimiter=",", skiprows=1).T
    starts = 0.005 * np.arange(12)
    for a, j, wanted in ((ax, jx, 0), (az, jz, 1)):  # as a master sees it that draws lines between rows
        first, slope = np.interp(starts, time, a), np.interp(starts, time, j)
        for part in (0.0, 0.4, 1.0):
            exact = motion.acceleration(starts + 0.005 * part)[wanted]
            np.testing.assert_allclose(first + slope * 0.005 * part, exact, atol=1e-9)  # 1e-14 measured


@pytest.mark.parametrize("hold", [False, True])
@pytest.mark.parametrize("slopes", [False, True])
def test_csv_of_two_components_has_both_to_the_last_bit(tmp_path: Path, hold: bool, slopes: bool) -> None:
    time, samples = (
        0.02 * np.arange(4.0),
        np.array([[0.1, 1.0, -0.5, 0.25], [0.3, -0.2, 0.7, 0.0], [0.0, 0.2, 0.4, 0.1]]),
    )
    ax, ay, az = samples
    motion = Motion(time, ax, az, 0.06 + 0.02 * hold, hold=hold, ay=ay)
    motion.to_csv(tmp_path / "two.csv", slopes=slopes)
    found = Motion.from_csv(tmp_path / "two.csv", hold)
    assert_same(found, motion)
    assert np.array_equal(found.ay, ay)
    table = np.genfromtxt(tmp_path / "two.csv", delimiter=",", names=True, deletechars="")
    if slopes:  # of the interval in which a row begins
        wanted = np.zeros(3) if hold else np.diff(ay) / 0.02
        np.testing.assert_allclose(table["base.jy"][::2][:3], wanted, rtol=1e-12)


def test_csv_of_a_held_component_or_harmonic_across_is_sampled(tmp_path: Path) -> None:
    held = Motion(np.array([0.0, 0.2]), np.zeros(2), np.zeros(2), 0.4, hold=True, ay=np.array([1.0, 2.0]))
    for motion, wanted in ((held, [1.0, 1.0, 2.0, 2.0]), (Motion.harmonic(1.0, 1.0, 0.4, direction=0.5 * np.pi), None)):
        motion.to_csv(tmp_path / "sampled.csv", step=0.1)
        sampled = Motion.from_csv(tmp_path / "sampled.csv", motion.hold)
        found = np.sin(2.0 * np.pi * sampled.time) if wanted is None else wanted
        np.testing.assert_allclose(sampled.ay, found, atol=1e-12)


def test_csv_with_slopes_keeps_its_times(tmp_path: Path) -> None:  # extra rows are no steps that need more digits
    time = 100.0 + 0.01 * np.arange(4.0)
    motion = Motion(time, np.array([0.0, 1.0, -0.5, 0.25]), np.zeros(4), float(time[-1] - time[0]))
    motion.to_csv(tmp_path / "slopes.csv", slopes=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert_same(Motion.from_csv(tmp_path / "slopes.csv"), motion)


def test_csv_of_a_harmonic_is_sampled(tmp_path: Path) -> None:
    motion = Motion.harmonic(1.0, 1.0, 1.1)
    motion.to_csv(tmp_path / "harmonic.csv", step=0.1)
    sampled = Motion.from_csv(tmp_path / "harmonic.csv")
    assert len(sampled.time) == 12
    assert sampled.duration == 1.1
    np.testing.assert_array_equal(sampled.ax, motion.acceleration(sampled.time)[0])
    assert sampled.ax[-1] == pytest.approx(np.sin(2.2 * np.pi))


def test_csv_of_held_samples_on_a_grid_lasts_as_long(tmp_path: Path) -> None:
    motion = Motion.from_samples(0.2, [1.0, 2.0, 3.0], hold=True)
    motion.to_csv(tmp_path / "held.csv", step=0.1)
    sampled = Motion.from_csv(tmp_path / "held.csv", hold=True)
    np.testing.assert_array_equal(sampled.ax, [1.0, 1.0, 2.0, 2.0, 3.0, 3.0])
    assert sampled.duration == pytest.approx(motion.duration)


def test_csv_with_quotes_and_uneven_times(tmp_path: Path) -> None:
    path = written(tmp_path, '"time","base.ax"\n1.0,0.5\n1.5,1\n1.6,-2e-1\n')
    motion = Motion.from_csv(path)
    np.testing.assert_array_equal(motion.time, [1.0, 1.5, 1.6])
    np.testing.assert_array_equal(motion.ax, [0.5, 1.0, -0.2])
    np.testing.assert_array_equal(motion.az, 0.0)
    assert motion.duration == pytest.approx(0.6)
    assert Motion.from_csv(path, hold=True).duration == pytest.approx(0.7)


def test_csv_columns_go_by_name(tmp_path: Path) -> None:
    motion = Motion.from_csv(written(tmp_path, "time,base.az,base.ax\n0,1,2\n1,3,4\n"))
    np.testing.assert_array_equal(motion.ax, [2.0, 4.0])
    np.testing.assert_array_equal(motion.az, [1.0, 3.0])
    vertical = Motion.from_csv(written(tmp_path, "time,base.az\n0,1\n1,3\n"))
    np.testing.assert_array_equal(vertical.ax, 0.0)
    np.testing.assert_array_equal(vertical.az, [1.0, 3.0])


# AT2


def test_at2(tmp_path: Path) -> None:
    motion = Motion.from_at2(written(tmp_path, AT2))
    np.testing.assert_array_equal(motion.ax, STANDARD_GRAVITY * np.array([0.01, -0.2, 0.3, 0.4, -0.05]))
    np.testing.assert_array_equal(motion.time, 0.02 * np.arange(5))
    assert not motion.hold
    assert motion.pga == 0.4 * STANDARD_GRAVITY


@pytest.mark.parametrize("size", ["5    0.0200    NPTS, DT", "NPTS=5,DT=.02 SEC", "   5   2.0E-02 NPTS, DT  "])
@pytest.mark.parametrize("units", ["ACCELERATION TIME HISTORY IN UNITS OF G   ", "The units are (g)"])
def test_at2_headers(tmp_path: Path, size: str, units: str) -> None:
    lines = AT2.splitlines()
    lines[2:4] = [units, size]
    assert_same(Motion.from_at2(written(tmp_path, "\n".join(lines))), Motion.from_at2(written(tmp_path, AT2)))


@pytest.mark.parametrize(
    ("name", "count", "dt", "pga"),
    [
        ("elcentro-1940-ns", 1559, 0.02, 0.319),
        ("northridge-1994-arleta-360", 2000, 0.02, 0.308),
        ("kobe-1995-nishi-akashi-090", 4096, 0.01, 0.503),
        ("cape-mendocino-1992-cpm000", 1500, 0.02, 1.497),
        ("chi-chi-1999-tcu052-n", 18000, 0.005, 0.419),
    ],
)
def test_recorded_ground_motions(records: Path, tmp_path: Path, name: str, count: int, dt: float, pga: float) -> None:
    """Find them by their content too."""
    motion = Motion.from_at2(records / f"{name}.AT2")
    assert len(motion.time) == count
    assert motion.time[1] == dt
    assert motion.duration == (count - 1) * dt
    assert motion.pga / STANDARD_GRAVITY == pytest.approx(pga, abs=5e-4)
    (tmp_path / "no-suffix").write_bytes((records / f"{name}.AT2").read_bytes().replace(b"\n", b"\r\n"))
    assert_same(Motion.from_file(tmp_path / "no-suffix"), motion)


# a horizontal and a vertical record


def test_a_pair_of_equal_steps_is_taken_as_it_is() -> None:
    pair = Motion.from_samples(0.1, [0.0, 1.0, -3.0]).with_vertical(Motion.from_samples(0.1, [2.0, 0.5, 0.25]))
    assert_same(pair, Motion.from_samples(0.1, [0.0, 1.0, -3.0], [2.0, 0.5, 0.25]))


@pytest.mark.parametrize(("one", "other"), [(0.01, 0.005), (0.005, 0.01), (0.02, 0.03), (0.01, 0.01 * (1.0 + 1e-15))])
def test_a_pair_of_different_steps_keeps_every_sample(one: float, other: float) -> None:
    rng = np.random.default_rng(3)
    horizontal, vertical = (Motion.from_samples(dt, rng.normal(size=300)) for dt in (one, other))
    pair = horizontal.with_vertical(vertical)
    for motion, values in ((horizontal, pair.ax), (vertical, pair.az)):
        nearest = np.abs(pair.time[:, None] - motion.time).argmin(axis=0)
        assert len(set(nearest)) == len(motion.time)
        np.testing.assert_allclose(pair.time[nearest], motion.time, rtol=0.0, atol=1e-9)
        np.testing.assert_array_equal(values[nearest], motion.ax)
        # linear in between, zero beyond the end
        between = (pair.time[1:] + pair.time[:-1]) / 2.0
        between = between[between < motion.end]
        found = pair.acceleration(between)[0 if values is pair.ax else 1]
        np.testing.assert_allclose(found, motion.acceleration(between)[0], atol=1e-12)
        beyond = pair.time > motion.end + 1e-9
        np.testing.assert_array_equal(values[beyond], 0.0)
    steps = np.diff(pair.time)
    assert np.min(steps) > 0.3 * min(one, other)  # no two instants that differ by rounding
    assert len(pair.time) <= len(np.unique(np.round([*horizontal.time, *vertical.time], 9))) + 1  # at the end of one
    assert pair.end == pytest.approx(max(horizontal.end, vertical.end), rel=1e-14)


def test_a_component_is_zero_before_its_start_and_beyond_its_end() -> None:
    """Check records of 0 to 0.3 s and 5 to 5.5 s, with a shortest sampling interval of 0.05 s."""
    one = Motion(np.array([0.0, 0.1, 0.2, 0.3]), np.array([1.0, 2.0, 3.0, 4.0]), np.zeros(4), 0.3)
    other = Motion(np.array([5.0, 5.05, 5.15, 5.5]), np.array([1.0, 2.0, 3.0, 4.0]), np.zeros(4), 0.5)
    for pair, values in ((one.with_vertical(other), "az"), (one.with_across(other), "ay")):
        np.testing.assert_allclose(pair.time, [0, 0.1, 0.2, 0.3, 0.35, 4.95, 5, 5.05, 5.15, 5.5], rtol=1e-14)
        np.testing.assert_array_equal(pair.ax, [1, 2, 3, 4, 0, 0, 0, 0, 0, 0])
        np.testing.assert_array_equal(getattr(pair, values), [0, 0, 0, 0, 0, 0, 1, 2, 3, 4])
    long = Motion(np.array([0.0, 2.0]), np.array([1.0, 3.0]), np.zeros(2), 2.0)
    pair = one.with_vertical(long)
    np.testing.assert_allclose(pair.time, [0.0, 0.1, 0.2, 0.3, 0.4, 2.0])
    np.testing.assert_allclose(pair.ax, [1.0, 2.0, 3.0, 4.0, 0.0, 0.0])
    np.testing.assert_allclose(pair.az, [1.0, 1.1, 1.2, 1.3, 1.4, 3.0])


def test_a_shorter_record_of_the_same_step_needs_no_further_instant() -> None:
    pair = Motion.from_samples(0.1, [1.0, 2.0]).with_vertical(Motion.from_samples(0.1, [3.0, 4.0, 5.0, 6.0]))
    assert_same(pair, Motion.from_samples(0.1, [1.0, 2.0, 0.0, 0.0], [3.0, 4.0, 5.0, 6.0]))


def test_scaled_to() -> None:
    motion = Motion.from_samples(0.1, [0.0, 1.0, -4.0], [2.0, 0.0, 0.0])
    scaled = motion.scaled_to(1.0)
    np.testing.assert_array_equal(scaled.ax, [0.0, 0.25, -1.0])
    np.testing.assert_array_equal(scaled.az, [0.5, 0.0, 0.0])
    assert Motion.harmonic(2.0, 1.0, 3.0).scaled_to(0.5).amplitude == 0.5


# mistakes


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "line 1: '': must be 'time,base.ax,base.az'"),
        ("base.ax,time\n0,0\n1,0\n", "line 1: 'base.ax,time': must be 'time,base.ax"),
        ("time\n0\n1\n", "line 1: 'time': must be 'time,base.ax"),
        ("time,base.ax,base.ax\n0,0,0\n1,0,0\n", "line 1: 'time,base.ax,base.ax': must be 'time,base.ax"),
        ("0.0,0.1\n0.1,0.2\n", "line 1: '0.0,0.1': must be 'time,base.ax"),
        ("time,base.ax\n", "0 rows of samples, must be at least 2"),
        ("time,base.ax\n0,1\n", "1 rows of samples, must be at least 2"),
        ("time,base.ax\n0,1\n\n\n1,2\n", "line 3: 0 values, must be 2 as in the header"),
        ("time;base.ax\n0;1\n1;0,5\n", "line 3: 0,5 has a decimal comma, must be 0.5"),
        ("time,base.ax\n0,1\n1\n", "line 3: 1 values, must be 2 as in the header"),
        ("time,base.ax\n0,1\n1,1,1\n", "line 3: 3 values, must be 2 as in the header"),
        ("time,base.ax\n0,1\n\n1,1\n", "line 3: 0 values, must be 2 as in the header"),
        ("time,base.ax\n0,1\n1,one\n", "line 3: 'one': must be a finite number"),
        ("time,base.ax\n0,1\n1,\n", "line 3: '': must be a finite number"),
        ("time,base.ax\n0,1\n1,nan\n", "line 3: 'nan': must be a finite number"),
        ("time,base.ax\n0,1\n1,-inf\n", "line 3: '-inf': must be a finite number"),
        ("time,base.ax\n0,1\n1,1_0\n", "line 3: '1_0': must be a finite number"),
        ("time,base.ax\n0,1\n1,\u0663\n", "line 3: '\u0663': must be a finite number"),
        ("time,base.ax\n0,1\n1,1\n1,2\n", "line 4: time = 1.0: must be later than the row before, 1.0 s"),
        ('time,base.ax\n0,1\n1,"1"x\n', "is not CSV: "),
    ],
)
def test_bad_csv(tmp_path: Path, text: str, said: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        Motion.from_csv(path)
    assert str(caught.value).startswith(f"{path}: {said}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "instead", "said"),
    [
        (AT2, "one\ntwo\n", "2 lines, must be 4 header lines and the samples"),
        ("UNITS OF G", "UNITS OF CM/S2", "line 3: 'ACCELERATION TIME HISTORY IN UNITS OF CM/S2. FILTER POINTS: NONE'"),
        ("UNITS OF G", "UNITS OF GAL", "must say that the units are g"),
        ("UNITS OF G", "UNITS OF G/10", "must say that the units are g"),
        ("UNITS OF G", "G", "must say that the units are g"),
        ("NPTS=  5", "N=  5", "line 4: 'N=  5, DT= .02000 SEC': must be like 'NPTS= 1559, DT= .02000 SEC'"),
        ("NPTS=  5", "NPTS=  5.5", "line 4: "),
        ("NPTS=  5,", "NPTS=  5, DT= 5,", "line 4: "),
        ("DT= .02000", "DT= .02,000", "line 4: "),
        ("DT= .02000", "DT= .02O00", "line 4: 'NPTS=  5, DT= .02O00 SEC': must be like"),
        ("NPTS=  5", "NPTS=  \u0665", "line 4: "),
        (".02000", ".0.2", "line 4: '.0.2': must be a finite number"),
        (".02000", "0.0", "dt = 0.0: must be a positive time in s"),
        ("NPTS=  5", "NPTS=  6", "5 samples found, must be 6 as NPTS says in line 4"),
        ("NPTS=  5", "NPTS=  4", "5 samples found, must be 4 as NPTS says in line 4"),
        (" -0.05", "", "4 samples found, must be 5 as NPTS says in line 4"),
        ("0.4 -0.05", "0.4-5", "line 6: '0.4-5': must be a finite number"),
        ("0.4 -0.05", "0.4********", "line 6: '0.4********': must be a finite number"),
        (".3\n", "nan\n", "line 5: 'nan': must be a finite number"),
    ],
)
def test_bad_at2(tmp_path: Path, text: str, instead: str, said: str) -> None:
    assert text in AT2
    path = written(tmp_path, AT2.replace(text, instead, 1))
    with pytest.raises(InputError) as caught:
        Motion.from_at2(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def motion_of(**changes: Any) -> Motion:
    zero = np.zeros(3)
    return Motion(**{"time": [0.0, 1.0, 2.0], "ax": zero, "az": zero, "duration": 2.0, **changes})


GAPS: Any = np.ma.array([1.0, 2.0], mask=[False, True])


@pytest.mark.parametrize(("az", "warned"), [(3.5, 0), (4.5, 1)])
def test_a_vertical_record_is_compared_with_vertical_ones(tmp_path: Path, az: float, warned: int) -> None:
    (tmp_path / "up.csv").write_text(f"time,base.ax,base.az\n0,1,{az * STANDARD_GRAVITY}\n1,0,0\n")
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        Motion.from_csv(tmp_path / "up.csv")
    assert len(found) == warned
    assert all("largest acceleration 4.5 g, ground motions reach 4 g" in str(each.message) for each in found)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Motion.harmonic(np.nan, 1.0, 1.0), "amplitude = nan: must be a finite acceleration in m/s2"),
        (lambda: Motion.harmonic(1.0, 0.0, 1.0), "frequency = 0.0: must be a positive frequency in Hz"),
        (lambda: Motion.harmonic(1.0, 1.0, -1.0), "duration = -1.0: must be a positive time in s"),
        (lambda: Motion.harmonic(1.0, 1.0, "1"), "duration = '1': must be a positive time in s"),  # type: ignore[arg-type]
        (lambda: Motion.harmonic(1.0, 1.0, 1.0, np.inf), "direction = inf: must be an angle in rad"),
        (lambda: motion_of().turned("1"), "angle = '1': must be an angle in rad"),  # type: ignore[arg-type]
        (lambda: Motion.from_samples(0.0, [1.0, 2.0]), "dt = 0.0: must be a positive time in s"),
        (lambda: Motion.from_samples(0.1, [1.0]), "time: 1 sample, must be at least 2 unless samples are held"),
        (lambda: Motion.from_samples(0.1, []), "ax: must be a one-dimensional array of numbers in m/s2, at least one"),
        (lambda: Motion.from_samples(0.1, [[1.0], [2.0]]), "ax: must be a one-dimensional array"),
        (lambda: Motion.from_samples(0.1, [[1.0], [2.0, 3.0]]), "ax: must be a one-dimensional array"),
        (lambda: Motion.from_samples(0.1, ["1.0", "2.0"]), "ax: must be a one-dimensional array of numbers"),
        (lambda: Motion.from_samples(0.1, np.ma.array([1.0, 2.0], mask=[False, True])), "ax: has gaps (masked values)"),
        (lambda: Motion.from_samples(0.1, [1.0, 2.0], GAPS), "az: has gaps (masked values)"),
        (lambda: Motion.from_samples(0.1, [1.0, 2.0], ay=GAPS), "ay: has gaps (masked values)"),
        (lambda: Motion.from_samples(0.1, [1.0, np.inf]), "ax[1] = inf: must be a finite number in m/s2"),
        (lambda: Motion.from_samples(0.1, [1.0, 2.0], [1.0]), "az: 1 samples, must be 2, one for each time"),
        (lambda: Motion.from_samples(0.1, [1.0, 2.0], [1.0, np.nan]), "az[1] = nan: must be a finite number in m/s2"),
        (lambda: motion_of(time=[0.0, 1.0, 1.0]), "time[2] = 1.0: must be later than the sample before, 1.0 s"),
        (lambda: motion_of(amplitude=1.0), "frequency = 0.0: must be a positive frequency in Hz"),
        (lambda: motion_of(frequency=-1.0), "frequency = -1.0: must be a frequency in Hz, zero or positive"),
        (lambda: motion_of(duration=3.0), "duration = 3.0: must be the 2.0 s from first to last sample"),
        (lambda: motion_of(hold=True), "duration = 2.0: must be more than the 2.0 s from first to last sample"),
        (lambda: motion_of().scaled(np.inf), "factor = inf: must be a finite number"),
        (lambda: motion_of().scaled_to(0.0), "pga = 0.0: must be a positive acceleration in m/s2"),
        (lambda: motion_of().scaled_to(1.0), "pga = 1.0: ax is zero throughout and cannot be scaled to it"),
        (
            lambda: Motion.harmonic(1.0, 1.0, 1.0).with_vertical(motion_of()),
            "horizontal motion: must be linear samples, neither held nor harmonic",
        ),
        (
            lambda: motion_of().with_vertical(motion_of(hold=True, duration=3.0)),
            "vertical motion: must be linear samples, neither held nor harmonic",
        ),
        (
            lambda: motion_of().with_vertical(motion_of(ay=[0.0, 1.0, 0.0])),
            "vertical motion: has ay beside ax, must be one component",
        ),
        (
            lambda: motion_of(ay=[0.0, 1.0, 0.0]).with_across(motion_of()),
            "first motion: has ay already, must be without it",
        ),
        (
            lambda: motion_of().with_across(motion_of(ay=[0.0, 1.0, 0.0])),
            "across motion: has ay already, must be without it",
        ),
        (
            lambda: motion_of().with_across(motion_of(az=[0.0, 1.0, 0.0])),
            "across motion: has az beside ax, must be one component",
        ),
        (
            lambda: motion_of().with_vertical(motion_of(az=[0.0, 1.0, 0.0])),
            "vertical motion: has az beside ax, must be one component",
        ),
    ],
)
def test_bad_values(make: Callable[[], Motion], said: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert str(caught.value).startswith(said)


@pytest.mark.parametrize(
    ("step", "said"),
    [
        (None, "step: missing, must be the time in s at which a harmonic is sampled"),
        (0.0, "step = 0.0: must be a time in s that divides the duration, 1.0 s"),
        (0.3, "step = 0.3: must be a time in s that divides the duration, 1.0 s"),
        (2.0, "step = 2.0: must be a time in s that divides the duration, 1.0 s"),
        (1e-320, "must be a time in s that divides the duration, 1.0 s"),
    ],
)
def test_bad_csv_step(tmp_path: Path, step: float | None, said: str) -> None:
    with pytest.raises(InputError) as caught:
        Motion.harmonic(1.0, 1.0, 1.0).to_csv(tmp_path / "motion.csv", step)
    assert said in str(caught.value)
    assert not (tmp_path / "motion.csv").exists()


def test_files_that_cannot_be_reached(tmp_path: Path) -> None:
    for read in (Motion.from_csv, Motion.from_at2):
        with pytest.raises(InputError, match=r"absent: No such file or directory$"):
            read(tmp_path / "absent")
        (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
        with pytest.raises(InputError, match="binary: is not text"):
            read(tmp_path / "binary")
    with pytest.raises(InputError, match=r"No such file or directory$"):
        Motion.from_samples(0.1, [0.0, 1.0]).to_csv(tmp_path / "absent" / "motion.csv")


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: Motion.from_samples(0.1, [0.0, -2e6, 0.0]), "ax[1] = -2000000.0"),
        (lambda: Motion.from_samples(0.1, [0.0, 0.0], [0.0, 1e14]), "az[1] = 1"),
        (lambda: Motion.harmonic(2e6, 1.0, 1.0), "amplitude = 2000000.0"),
        (lambda: Motion.from_samples(0.1, [0.0, 1.0]).scaled(2e6), "ax[1] = 2000000.0"),
    ],
)
def test_accelerations_beyond_a_million_are_refused(make: Callable[[], Motion], key: str) -> None:
    with pytest.raises(InputError, match=re.escape(key) + r".*: must be a finite acceleration in m/s2, at most 1e6"):
        make()


def test_a_harmonic_along_y_has_no_vertical_record() -> None:
    record = Motion.from_samples(0.01, [0.0, 1.0, 0.0])
    across = Motion.harmonic(1.0, 2.0, 0.02).turned(0.5 * math.pi)
    assert across.amplitude == 0.0
    with pytest.raises(InputError, match="horizontal motion: must be linear samples, neither held nor harmonic"):
        across.with_vertical(record)
    with pytest.raises(InputError, match="vertical motion: must be linear samples, neither held nor harmonic"):
        record.with_vertical(across)
