"""Measures of a motion against closed forms: harmonic, rectangular pulse, and oscillators solved independently."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from solver import InputError, Motion
from solver.commands.reports import motion_report
from solver.ground import oscillator
from solver.ground.intensity import components, histories, intensity, pgv, rotd, spectrum
from solver.ground.motion import STANDARD_GRAVITY as G
from solver.plotting.record_plots import plot_records

A, F = 2.0, 1.5  # m/s2, Hz
W = 2.0 * np.pi * F
CYCLES = 6
HARMONIC = Motion.harmonic(A, F, CYCLES / F)
LENGTH = 0.5  # s
PULSE = Motion.from_samples(LENGTH, [A], hold=True)


def sampled(dt: float) -> Motion:
    time = dt * np.arange(round(CYCLES / F / dt) + 1)
    return Motion.from_samples(dt, A * np.sin(W * time))


def test_harmonic() -> None:
    found = intensity(HARMONIC)
    assert found.pga == pytest.approx(A, rel=1e-12)
    # straight lines, 400 to a cycle: 2.1e-5 measured in velocity and displacement, 4.1e-5 in Arias
    assert found.pgv == pytest.approx(2.0 * A / W, rel=4e-5)
    assert found.pgd == pytest.approx(A / W * CYCLES / F, rel=4e-5)
    assert found.final_velocity == pytest.approx(0.0, abs=1e-12)
    assert found.arias == pytest.approx(np.pi / (2.0 * G) * A**2 / 2.0 * CYCLES / F, rel=8e-5)
    for part, at in ((0.05, found.start), (0.95, found.end)):
        wanted = brentq(lambda t, part=part: t - np.sin(2.0 * W * t) / (2.0 * W) - part * CYCLES / F, 0.0, CYCLES / F)
        assert at == pytest.approx(wanted, abs=1e-6)  # 3e-7 measured


def test_significant_duration_is_exact_within_long_segments() -> None:
    """Check a triangle, whose Arias intensity is a cubic: 5 % was reached at 0.10 s, by a straight line in between."""
    wanted = 0.1 ** (1.0 / 3.0)
    for size in (3.0, -1e-100, 1e5):
        found = intensity(Motion.from_samples(1.0, [0.0, size, 0.0]))
        assert (found.start, found.end) == pytest.approx((wanted, 2.0 - wanted), rel=1e-14)
    # a line through zero, and one that hardly rises
    crossing = intensity(Motion.from_samples(1.0, [-1.0, 1.0]))
    assert (crossing.start, crossing.end) == pytest.approx((0.5 - 0.5 * 0.9 ** (1 / 3), 0.5 + 0.5 * 0.9 ** (1 / 3)))
    assert intensity(Motion.from_samples(1.0, [1.0, 1.0 + 1e-12])).start == pytest.approx(0.05, rel=1e-11)


def test_errors_of_sampling_fall_by_its_square() -> None:
    errors = [abs(intensity(sampled(dt)).pgv - 2.0 * A / W) for dt in (1.0 / 60.0, 1.0 / 120.0, 1.0 / 240.0)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=2e-3)  # 4.0012 and 4.0003 measured
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=2e-3)


def test_rectangular_pulse_is_exact() -> None:
    found = intensity(PULSE)
    assert found.pga == A
    assert found.pgv == pytest.approx(A * LENGTH, rel=1e-15)
    assert found.pgd == pytest.approx(A * LENGTH**2 / 2.0, rel=1e-15)
    assert found.final_velocity == pytest.approx(A * LENGTH, rel=1e-15)
    assert found.arias == pytest.approx(np.pi / (2.0 * G) * A**2 * LENGTH, rel=1e-15)
    assert found.significant_duration == pytest.approx(0.9 * LENGTH, rel=1e-12)


def test_spectrum_of_the_rectangular_pulse() -> None:
    """Compare undamped oscillators: 2 while the pulse outlasts half a period, 2 sin(pi length / T) in the free
    vibration after it.
    """
    period = np.geomspace(0.05, 20.0, 200)
    wanted = np.where(period < 2.0 * LENGTH, 2.0, 2.0 * np.sin(np.pi * LENGTH / period)) * A
    found = spectrum(PULSE, period, damping=0.0)
    # the cubic between ten samples to a period: 1.4e-4 measured
    np.testing.assert_allclose(found.psa, wanted, rtol=3e-4)
    zeta = 0.05
    short = spectrum(PULSE, [0.1, 0.3, 0.6], zeta)
    first = A * (1.0 + np.exp(-zeta * np.pi / np.sqrt(1.0 - zeta**2)))
    np.testing.assert_allclose(short.psa, first, rtol=2e-4)  # 6e-5 measured


@pytest.mark.parametrize("period", [0.1, 1.0 / F, 0.9, 3.0])
def test_spectrum_of_a_harmonic_against_an_integrator(period: float) -> None:
    omega, zeta = 2.0 * np.pi / period, 0.05

    def rates(t: float, y: np.ndarray) -> list[float]:
        push = A * np.sin(W * t) if t <= CYCLES / F else 0.0
        return [y[1], -push - 2.0 * zeta * omega * y[1] - omega**2 * y[0]]

    inside = solve_ivp(rates, (0.0, CYCLES / F), [0.0, 0.0], "DOP853", rtol=1e-11, atol=1e-13, dense_output=True)
    after = solve_ivp(
        rates,
        (CYCLES / F + 1e-12, CYCLES / F + 2.0 * period),
        inside.y[:, -1],
        "DOP853",
        rtol=1e-11,
        atol=1e-13,
        dense_output=True,
    )
    largest = max(np.max(np.abs(part.sol(np.linspace(part.t[0], part.t[-1], 20001))[0])) for part in (inside, after))
    assert spectrum(HARMONIC, [period]).sd[0] == pytest.approx(largest, rel=4e-5)  # 2.1e-5 measured: straight lines


def test_spectrum_does_not_depend_on_how_a_straight_line_is_cut() -> None:
    coarse = Motion.from_samples(0.1, [0.0, 1.0, -3.0, 0.5, 0.0])
    time = np.array([0.0, 0.03, 0.1, 0.13, 0.2, 0.21, 0.26, 0.3, 0.35, 0.4])
    cut = Motion(time, coarse.acceleration(time)[0], np.zeros(len(time)), 0.4)
    period = np.geomspace(0.05, 5.0, 30)
    # exact but for the peak between two instants: 1.5e-4 measured
    np.testing.assert_allclose(spectrum(cut, period).sd, spectrum(coarse, period).sd, rtol=3e-4)
    for name in ("pgv", "pgd", "arias", "final_velocity", "final_displacement"):
        assert getattr(intensity(cut), name) == pytest.approx(getattr(intensity(coarse), name), rel=1e-12)


def test_limits_of_the_spectrum() -> None:
    """Check that a stiff oscillator follows the base, a soft one stands still."""
    motion = sampled(0.01)
    found = spectrum(motion, [0.02, 2000.0])
    assert found.psa[0] == pytest.approx(motion.pga, rel=2e-3)  # 3e-4 measured
    assert found.sd[1] == pytest.approx(intensity(motion).pgd, rel=2e-3)  # 7e-4 measured
    assert found.psv[0] == pytest.approx(found.psa[0] * 0.02 / (2.0 * np.pi), rel=1e-12)


def test_components() -> None:
    pair = Motion.from_samples(0.1, [0.0, 1.0, -1.0, 0.0], [0.0, 2.0, -2.0, 0.0])
    assert components(pair) == ["ax", "az"]
    assert components(HARMONIC) == ["ax"]
    one, other = intensity(pair), intensity(pair, "az")
    assert (other.pga, other.pgv, other.arias) == pytest.approx((2.0 * one.pga, 2.0 * one.pgv, 4.0 * one.arias))
    np.testing.assert_allclose(spectrum(pair, component="az").sd, 2.0 * spectrum(pair).sd, rtol=1e-14)
    assert "horizontal PGA" in motion_report(pair)
    assert "vertical PGA" in motion_report(pair)
    assert histories(pair).husid[-1] == one.arias
    # two lines in every panel, one of them dashed
    figure = plot_records({"pair": pair})
    drawn = [axes.get_lines() for part in figure.subfigs for axes in part.axes]
    assert [len(lines) for lines in drawn] == [2] * 5
    assert all(lines[1].get_linestyle() == "--" for lines in drawn)


def test_the_picture_shows_what_is_measured() -> None:
    figure = plot_records({"pulse": PULSE, "harmonic": HARMONIC})
    acceleration, velocity, displacement, spectra, arias = (axes for part in figure.subfigs for axes in part.axes)
    assert np.max(acceleration.get_lines()[0].get_ydata()) == pytest.approx(A / G)
    assert np.max(velocity.get_lines()[1].get_ydata()) == pytest.approx(intensity(HARMONIC).pgv, rel=1e-6)
    assert np.max(displacement.get_lines()[0].get_ydata()) == pytest.approx(intensity(PULSE).pgd)
    assert np.max(spectra.get_lines()[1].get_ydata()) == pytest.approx(np.max(spectrum(HARMONIC).psa) / G)
    assert np.max(arias.get_lines()[0].get_ydata()) == pytest.approx(intensity(PULSE).arias)
    pga = f"PGA {A / G:.3g} g"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [f"pulse, {pga}", f"harmonic, {pga}"]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: intensity(Motion.from_samples(0.1, [0.0, 0.0])), "ax: is zero throughout"),
        (lambda: components(Motion.from_samples(0.1, [0.0, 0.0])), "the motion is zero throughout"),
        (lambda: intensity(PULSE, "az"), "az: is zero throughout"),
        (lambda: spectrum(PULSE, [1.0, 0.0]), "period = 0.0: must be a positive time in s"),
        (lambda: spectrum(PULSE, [1.0], 1.0), "damping = 1.0: must be a part of critical"),
        (lambda: plot_records({}), "no record to draw"),
        (lambda: spectrum(PULSE, []), "periods = []: must be a list of positive times in s, at least one"),
        (lambda: spectrum(PULSE, 1.0), "periods = 1.0: must be a list of positive times in s"),  # type: ignore[arg-type]
        (lambda: spectrum(PULSE, ["a"]), "periods = ['a']: must be a list of positive times"),  # type: ignore[list-item]
        (lambda: intensity(PULSE, "x"), "component = 'x': must be one of ax, ay, az"),  # type: ignore[arg-type]
    ],
)
def test_mistakes(make: Callable[[], object], said: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert str(caught.value).startswith(said)


def test_one_oscillator_alone_is_one_among_many_to_the_bit() -> None:
    samples = np.random.default_rng(1).standard_normal(400)
    steps = np.where(np.arange(399) % 3, 0.01, 0.02)
    alone = oscillator.response(steps, samples[:-1], samples[1:], np.array([30.0]), 0.05)
    among = oscillator.response(steps, samples[:-1], samples[1:], np.array([30.0, 5.0]), 0.05)
    for one, many in zip(alone, among, strict=True):
        np.testing.assert_array_equal(one[:, 0], many[:, 0])


def test_peak_of_one_history_is_that_of_several() -> None:
    rng = np.random.default_rng(1)
    for count in (1, 2, 40, 700):
        values, steps = rng.standard_normal((count + 1, 3)), rng.uniform(0.1, 1.0, count)
        before, after = rng.standard_normal((2, count, 3))
        alone = [oscillator.peak(steps, values[:, k], before[:, k], after[:, k]) for k in range(3)]
        assert alone == oscillator.peaks(steps, values, before, after).tolist()


@pytest.mark.parametrize("time", [[0.0, 1.0, 1e15], [0.0, 1e-15, 1.0], [0.0, 0.005, 1e7]])
def test_spans_that_no_spectrum_can_follow(time: list[float]) -> None:
    """Check that a spectrum of them takes 256 GiB, or does not end."""
    motion = Motion(np.array(time), np.array([0.0, 1.0, 0.5]), np.zeros(3), time[-1])
    with pytest.raises(InputError, match=r"time: samples .* s apart, must be closer and more even"):
        spectrum(motion)


def test_a_harmonic_of_cycles_without_number() -> None:
    with pytest.raises(InputError, match="cycles, must be at most"):
        pgv(Motion.harmonic(1.0, 1e9, 1e3))
    with pytest.raises(InputError, match="cycles, must be at most"):
        _ = Motion.harmonic(1.0, 1e9, 1e3).pga


def test_a_spectrum_in_parts_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    motion = Motion.from_samples(0.01, np.sin(0.3 * np.arange(200)))
    whole = spectrum(motion).sd
    monkeypatch.setattr("solver.ground.intensity.AT_ONCE", 1000)
    np.testing.assert_allclose(spectrum(motion).sd, whole, rtol=1e-13)


def test_rotd_of_equal_components_in_phase() -> None:
    """Check that along 45 degrees they are sqrt(2) as large, at the median angle as large as each."""
    time = np.arange(0.0, 4.0, 0.01)
    pulse = np.sin(3.0 * time) * np.exp(-time)
    both = Motion(time, pulse, np.zeros_like(time), 3.99, ay=pulse)
    period = [0.2, 0.7, 3.0]
    one = spectrum(Motion(time, pulse, np.zeros_like(time), 3.99), period).sd
    for percentile, factor in ((100, np.sqrt(2.0)), (50, 1.0), (0, 0.0)):
        found = rotd(both, percentile, period).sd  # measured: 1e-13; 0 to 1e-16 m
        np.testing.assert_allclose(found, factor * one, rtol=1e-12, atol=1e-14)


def test_rotd_of_circular_motion() -> None:
    """Check that all orientations have the steady amplitude, after a motion that grows slowly."""
    time = np.arange(0.0, 60.0, 0.01)
    omega, zeta = 2.0 * np.pi, 0.05
    grows = 0.5 * (1.0 - np.cos(np.pi * np.minimum(time / 40.0, 1.0)))
    # it fades as slowly as it grows: the free vibration at the end is smaller than the steady one
    grows = grows * np.clip((60.0 - time) / 10.0, 0.0, 1.0)
    ax, ay = grows * np.cos(omega * time), grows * np.sin(omega * time)
    circle = Motion(time, ax, np.zeros_like(time), float(time[-1]), ay=ay)
    period = np.array([0.4, 1.0, 2.5])
    ratio = period / 1.0
    steady = (period / (2.0 * np.pi)) ** 2 / np.hypot(1.0 - ratio**2, 2.0 * zeta * ratio)
    least, most = (rotd(circle, percentile, period).sd for percentile in (50, 100))
    np.testing.assert_allclose(most / steady, 1.0, atol=0.01)  # measured: 0.002; the ratio 0.005
    np.testing.assert_allclose(least / most, 1.0, atol=0.01)


def test_rotd_of_one_component_and_of_turned_motions() -> None:
    harmonic = Motion.harmonic(2.0, 1.0, 3.0)
    assert rotd(harmonic, 100, [0.7]).sd == pytest.approx(spectrum(harmonic, [0.7]).sd, rel=1e-12)
    turned = Motion.harmonic(2.0, 1.0, 3.0, direction=np.deg2rad(40.0))
    assert rotd(turned, 100, [0.7]).sd == pytest.approx(rotd(harmonic, 100, [0.7]).sd, rel=1e-12)
    with pytest.raises(InputError, match="percentile = 101: must be a percentile"):
        rotd(harmonic, 101)
