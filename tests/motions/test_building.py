"""The motion of a floor against closed forms, and the file of a building with its mistakes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from multiblock import Building, InputError, Motion, floor_motion, wavelets
from solver.ground.building import LONGEST_TAIL, RIGID

BEAM = Building.beam(storeys=4, period=0.5, alpha=3.0)
ONE = {"building": {"mode": [{"period": 0.5, "damping": 0.05, "x": [1.3]}]}}
FILE = """[building]
name = "Town hall"
height = 16.0
storeys = 4
period = 0.5
period_y = 0.4
alpha = 3.0
"""


def absolute(t: np.ndarray, amplitude: float, drive: float, period: float, damping: float) -> np.ndarray:
    """Return the absolute acceleration of an oscillator from rest whose base has amplitude sin(drive t)."""
    w = 2.0 * np.pi / period
    damped = w * np.sqrt(1.0 - damping**2)
    # steady state: u = s sin + c cos
    real, imaginary = w**2 - drive**2, 2.0 * damping * w * drive
    s, c = (-amplitude * part / (real**2 + imaginary**2) for part in (real, -imaginary))
    a, b = -c, (-s * drive - damping * w * c) / damped
    fade, cos, sin = np.exp(-damping * w * t), np.cos(damped * t), np.sin(damped * t)
    u = s * np.sin(drive * t) + c * np.cos(drive * t) + fade * (a * cos + b * sin)
    v = drive * (s * np.cos(drive * t) - c * np.sin(drive * t))
    v += fade * ((damped * b - damping * w * a) * cos - (damped * a + damping * w * b) * sin)
    return -(w**2) * u - 2.0 * damping * w * v


@pytest.mark.parametrize("drive", [2.0, 4.0 * np.pi, 30.0])
def test_one_mode_under_a_harmonic(drive: float) -> None:
    """Extrapolate the straight lines between samples, whose error falls by the square of the interval."""
    building, count, length = Building.from_dict(ONE), 4000, 4.0
    found = []
    for n in (count, 2 * count):
        t = np.linspace(0.0, length, n + 1)
        moved = floor_motion(Motion.from_samples(length / n, 2.0 * np.sin(drive * t)), building, 1)
        found.append(moved.ax[: n + 1 : n // count])
    t = np.linspace(0.0, length, count + 1)
    wanted = -0.3 * 2.0 * np.sin(drive * t) + 1.3 * absolute(t, 2.0, drive, 0.5, 0.05)
    np.testing.assert_allclose((4.0 * found[1] - found[0]) / 3.0, wanted, atol=1e-9 * np.max(np.abs(wanted)), rtol=0.0)


def test_a_ramp_is_exact_and_its_interval_is_divided() -> None:
    moved = floor_motion(Motion.from_samples(3.0, [0.0, 6.0]), Building.from_dict(ONE), 1)
    during = moved.time <= 3.0
    assert np.max(np.diff(moved.time)) <= 0.5 / 20 * (1.0 + 1e-9)
    w, zeta, t = 4.0 * np.pi, 0.05, moved.time[during]
    damped = w * np.sqrt(1.0 - zeta**2)
    # u + 2 t / w^2 decays from the velocity and displacement that the ramp has not
    p, q = 4.0 * zeta / w**3, -2.0 / w**2
    b = (-q - zeta * w * p) / damped
    fade, cos, sin = np.exp(-zeta * w * t), np.cos(damped * t), np.sin(damped * t)
    u = p + q * t + fade * (-p * cos + b * sin)
    v = q + fade * ((damped * b + zeta * w * p) * cos + (damped * p - zeta * w * b) * sin)
    wanted = -0.3 * 2.0 * t + 1.3 * (-(w**2) * u - 2.0 * zeta * w * v)
    np.testing.assert_allclose(moved.ax[during], wanted, atol=1e-12)


def test_free_vibration_after_the_end() -> None:
    moved = floor_motion(Motion.from_samples(0.01, np.ones(51)), Building.from_dict(ONE), 1)
    tail = np.log(100.0) / (0.05 * 4.0 * np.pi)
    assert moved.end == pytest.approx(0.5 + tail, rel=1e-12)
    # the ground stops at once; a whole period of the damped oscillator later the motion has faded by its decrement
    after = moved.time > 0.5
    assert moved.ax[after][0] == pytest.approx(moved.ax[~after][-1] + 0.3, abs=1e-3)
    later = 0.5 / np.sqrt(1.0 - 0.05**2)
    t = np.linspace(0.51, 0.99, 40)
    first, second = (np.interp(t + part, moved.time, moved.ax) for part in (0.0, later))
    np.testing.assert_allclose(second, np.exp(-0.05 * 4.0 * np.pi * later) * first, atol=0.02 * np.max(np.abs(first)))
    undamped = Building.beam(1, 0.5, 3.0, damping=0.0)
    assert floor_motion(wavelets.ricker(1.0, 1.0), undamped, 1).end == pytest.approx(4.0 + LONGEST_TAIL)


def test_a_shear_beam() -> None:
    alpha = 500.0
    modes = Building.beam(10, 1.0, alpha).along_x
    k = np.arange(1, 11)
    np.testing.assert_allclose([mode.period for mode in modes], 1.0 / (2 * k - 1), rtol=2e-3)
    top = [mode.factors[-1] for mode in modes]
    np.testing.assert_allclose(top, 4.0 / np.pi * -((-1.0) ** k) / (2 * k - 1), rtol=4.0 / alpha)
    np.testing.assert_allclose(modes[0].factors, 4.0 / np.pi * np.sin(np.pi / 2.0 * k / 10), atol=5.0 / alpha)


def test_a_flexural_cantilever() -> None:
    modes = Building.beam(3, 1.0, 0.0).along_x
    roots = np.array([1.8751040687119611, 4.694091132974174, 7.854757438237612])
    np.testing.assert_allclose([mode.period for mode in modes], (roots[0] / roots) ** 2, rtol=1e-12)
    sigma = (np.sinh(roots) - np.sin(roots)) / (np.cosh(roots) + np.cos(roots))
    np.testing.assert_allclose([mode.factors[-1] for mode in modes], 4.0 * sigma / roots * [1.0, -1.0, 1.0], rtol=1e-11)


@pytest.mark.parametrize("alpha", [0.7, 3.0, 12.0])
def test_a_shear_flexural_beam_against_rayleigh_and_ritz(alpha: float) -> None:
    """Take polynomials that are clamped at the base, and the stiffness of both beams."""
    i = np.arange(2.0, 14.0)
    s, j = np.add.outer(i, i), np.multiply.outer(i, i)
    stiffness = np.multiply.outer(i * (i - 1.0), i * (i - 1.0)) / (s - 3.0) + alpha**2 * j / (s - 1.0)
    mass = 1.0 / (s + 1.0)
    squares, shapes = eigh(stiffness, mass)
    modes = Building.beam(5, 1.0, alpha).along_x
    heights = np.arange(1, 6) / 5
    for k in range(2):
        assert modes[k].period == pytest.approx(np.sqrt(squares[0] / squares[k]), rel=1e-5)
        shape = shapes[:, k]
        factors = (shape @ (1.0 / (i + 1.0))) * (heights[:, None] ** i @ shape)  # of unit modal mass
        np.testing.assert_allclose(modes[k].factors, factors, atol=2e-4)


def test_all_modes_together_move_a_floor_with_the_ground() -> None:
    """Check that the sum of participation times shape tends to 1, in the upper half with ten modes."""
    modes = Building.beam(40, 1.0, 5.0).along_x
    sums = np.sum([mode.factors for mode in modes], axis=0)
    assert np.max(np.abs(sums[20:] - 1.0)) < 0.1
    assert [len(Building.beam(n, 1.0, 5.0).along_x) for n in (1, 3, 40)] == [1, 3, 10]


def test_a_rigid_building_and_the_ground_floor_give_the_ground() -> None:
    ground = wavelets.ricker(3.0, 1.5)
    assert floor_motion(ground, Building.beam(3, 0.9 * RIGID, 2.0), 3) is ground
    assert floor_motion(ground, BEAM, 0) is ground


def test_a_floor_is_in_the_name_of_its_motion() -> None:
    """Check the words that titles of pictures show beside the largest acceleration of the floor."""
    hall, pulse = Building.beam(storeys=4, period=0.5, alpha=3.0, name="Hall"), wavelets.ricker(2.0, 1.0)
    assert floor_motion(pulse.named("RECORD"), hall, 2).name == "RECORD on floor 2 of Hall"
    assert floor_motion(pulse.named(""), hall, 2).name == "the motion on floor 2 of Hall"
    assert floor_motion(pulse.named("RECORD"), hall, 0).name == "RECORD"


def test_a_slow_pulse_passes_unchanged() -> None:
    t = np.linspace(0.0, 200.0, 20001)
    ground = Motion.from_samples(0.01, 1.0 - np.cos(2.0 * np.pi * t / 200.0))
    fast = Building.from_dict({"building": {"mode": [{"period": 0.1, "x": [1.3]}]}})
    for building in (Building.beam(6, 0.1, 4.0), fast):
        moved = floor_motion(ground, building, 1)
        np.testing.assert_allclose(np.interp(t, moved.time, moved.ax), ground.ax, atol=1e-6)


def test_components() -> None:
    ground = wavelets.filtered_noise(1.0, 2.5, 5.0, 1)
    time, ax = ground.time, ground.ax
    motion = Motion(time, ax, 0.3 * ax, ground.duration, ay=2.0 * ax, name="three")
    building = Building.beam(4, 0.5, 3.0, period_y=0.3)
    moved = floor_motion(motion, building, 3)
    across = floor_motion(motion.turned(-np.pi / 2.0), building.across(), 3)  # its x is the former y
    np.testing.assert_allclose(moved.ay, across.ax, atol=1e-12)
    np.testing.assert_allclose(np.interp(time, moved.time, moved.az), motion.az, atol=1e-12)
    assert not np.any(moved.az[moved.time > motion.end + 1e-3])
    assert moved.name == "three on floor 3 of the building"
    alike = floor_motion(motion, Building.beam(4, 0.5, 3.0), 3)
    np.testing.assert_allclose(alike.ay, 2.0 * alike.ax, atol=1e-12)


def test_a_harmonic_is_sampled() -> None:
    harmonic = Motion.harmonic(2.0, 1.5, 4.0, direction=0.3)
    moved = floor_motion(harmonic, Building.from_dict(ONE), 1)
    assert not moved.amplitude
    during = moved.time <= 4.0
    t = moved.time[during]
    drive = 3.0 * np.pi
    wanted = -0.3 * 2.0 * np.sin(drive * t) + 1.3 * absolute(t, 2.0, drive, 0.5, 0.05)
    np.testing.assert_allclose(moved.ax[during], np.cos(0.3) * wanted, atol=1e-3)
    np.testing.assert_allclose(moved.ay[during], np.sin(0.3) * wanted, atol=1e-3)


def test_motions_that_are_refused() -> None:
    with pytest.raises(InputError, match=r"motion: must be of straight lines between samples for a floor, they"):
        floor_motion(Motion.from_samples(0.1, [1.0], hold=True), BEAM, 1)
    with pytest.raises(InputError, match=r"samples on the floor, must be at most 1e\+06"):
        floor_motion(Motion.from_samples(1e6, [0.0, 1.0]), BEAM, 1)
    for floor in (-1, 5, 1.0, True):
        with pytest.raises(InputError, match=r"floor = .*: must be a whole number from 0, the ground, to 4"):
            floor_motion(wavelets.ricker(1.0, 1.0), BEAM, floor)  # type: ignore[arg-type]


def test_a_file(tmp_path: Path) -> None:
    path = tmp_path / "hall.toml"
    path.write_text(FILE, encoding="utf-8")
    building = Building.from_toml(path)
    assert building == Building.beam(4, 0.5, 3.0, period_y=0.4, height=16.0, name="Town hall")
    assert building.words(2) == (
        "floor 2 of 4 of Town hall, 8 m above the ground, first period 0.5 s along x, 0.4 s along y"
    )
    path.write_text("[building]\n[[building.mode]]\nperiod = 0.5\ny = [1, 2]\nx = [1, 2]\n", encoding="utf-8")
    assert Building.from_toml(path).words(1) == "floor 1 of 2 of hall, first period 0.5 s"
    assert Building.from_toml(path).along_y[0].damping == 0.05


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "building: missing, must be a table [building]"),
        ("building = 3", "building: missing, must be a table [building]"),
        ("[building]\n[column]", "column: unknown key, must be one of building"),
        (FILE + "floors = 3", "building.floors: unknown key, must be one of name, height, storeys"),
        (FILE.replace("period = 0.5", ""), "building.period: missing, must be given, or a table [[building.mode]]"),
        (FILE.replace("alpha = 3.0", "alpha = -1"), "building.alpha = -1: must be a number from 0, bending alone, to"),
        (FILE + "alpha_y = 501", "building.alpha_y = 501: must be"),
        (FILE.replace("storeys = 4", "storeys = 4.0"), "building.storeys = 4.0: must be a whole number from 1 to 500"),
        (FILE.replace("0.4", "0"), "building.period_y = 0: must be a period in s, from 0.001 to 100"),
        (FILE + "damping = 5", "building.damping = 5: must be a part of critical, from 0 to 0.99"),
        (FILE.replace("16.0", "nan"), "building.height = nan: must be a positive length"),
        (FILE.replace('"Town hall"', "3"), "building.name = 3: must be a text"),
        (FILE + "[[building.mode]]\nperiod = 1\nx = [1]", "unknown key of a building by modes, must be"),
        ("[building]\nmode = 3", "building.mode: must be one table [[building.mode]] for each"),
        ("[[building.mode]]\nx = [1]", "building.mode[1].period = None: must be a period"),
        ("[[building.mode]]\nperiod = 1", "building.mode[1].x: missing, must be participation times shape"),
        ("[[building.mode]]\nperiod = 1\ny = [1]", "building.mode[1].x: missing, must be given for one mode at least"),
        ("[[building.mode]]\nperiod = 1\nx = 1", "building.mode[1].x = 1: must be a list of numbers, participation"),
        ("[[building.mode]]\nperiod = 1\nx = []", "building.mode[1].x = []: must be a list of numbers"),
        ("[[building.mode]]\nperiod = 1\nx = ['a']", "building.mode[1].x[0] = 'a': must be a number"),
        ("[[building.mode]]\nperiod = 1\nx = [1]\ny = [1, 2]", "building.mode[1].y = [1, 2]: must be a list"),
        ("[[building.mode]]\nperiod = 1\nx = [1]\nz = [1]", "building.mode[1].z: unknown key, must be one of period"),
    ],
)
def test_mistakes_in_a_file(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "hall.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        Building.from_toml(path)
    assert str(error.value).startswith(f"{path}: ")
    assert message in str(error.value)
    assert "\n" not in str(error.value)
