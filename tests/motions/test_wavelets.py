"""Wavelets are their formulas; noise has the spectrum of its filter, its seed and no velocity at the end."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson
from support.child import call
from support.inside import noise

from solver import InputError, Motion
from solver.ground.intensity import intensity
from solver.ground.wavelets import (
    filtered_noise,
    mavroeidis_papageorgiou,
    one_cosine,
    one_sine,
    ricker,
)

A, F = 3.0, 0.8  # m/s2, Hz
W = 2.0 * np.pi * F


def integrated(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocity and displacement of smooth samples by Simpson's rule."""
    velocity = cumulative_simpson(motion.ax, x=motion.time, initial=0.0)
    return velocity, cumulative_simpson(velocity, x=motion.time, initial=0.0)


def test_ricker() -> None:
    """Check that it is minus the second derivative of a bell: the displacement is one, and velocity and displacement
    end at 0.
    """
    motion = ricker(A, F)
    assert motion.pga == A
    assert motion.time[np.argmax(motion.ax)] == pytest.approx(2.0 / F, rel=1e-12)
    x = (np.pi * F * (motion.time - 2.0 / F)) ** 2
    velocity, displacement = integrated(motion)
    bell = -A / (2.0 * (np.pi * F) ** 2) * np.exp(-x)
    np.testing.assert_allclose(displacement, bell, atol=1e-8 * np.max(np.abs(bell)))  # 3e-9 measured
    found = intensity(motion)
    assert abs(found.final_velocity) < 1e-12 * found.pgv  # 1e-15 measured
    assert abs(found.final_displacement) < 1e-12 * found.pgd
    frequency = np.fft.rfftfreq(1 << 16, motion.time[1])
    assert frequency[np.argmax(np.abs(np.fft.rfft(motion.ax, 1 << 16)))] == pytest.approx(F, rel=5e-3)
    assert np.max(np.abs(motion.ax[[0, -1]])) < 1e-14 * A
    assert abs(velocity[-1]) < 1e-10


def test_one_sine() -> None:
    motion = one_sine(A, F)
    np.testing.assert_allclose(motion.ax, A * np.sin(W * motion.time), atol=1e-14)
    velocity, _ = integrated(motion)
    np.testing.assert_allclose(velocity, A / W * (1.0 - np.cos(W * motion.time)), atol=1e-8)  # 1.5e-9 measured
    found = intensity(motion)
    assert motion.duration == pytest.approx(1.0 / F, rel=1e-12)
    assert motion.pga == pytest.approx(A, rel=1e-15)
    assert abs(found.final_velocity) < 1e-14
    assert found.final_displacement == pytest.approx(A / W / F, rel=4e-5)  # 2e-5 measured: straight lines


def test_one_cosine() -> None:
    motion = one_cosine(A, F)
    np.testing.assert_allclose(motion.ax, A * np.cos(W * motion.time), atol=1e-14)
    velocity, _ = integrated(motion)
    np.testing.assert_allclose(velocity, A / W * np.sin(W * motion.time), atol=1e-8)
    found = intensity(motion)
    assert abs(found.final_velocity) < 1e-14
    assert abs(found.final_displacement) < 1e-14


@pytest.mark.parametrize("cycles", [1.5, 2.0, 3.7])
@pytest.mark.parametrize("phase", [0.0, 0.5 * np.pi, 2.4])
def test_mavroeidis_papageorgiou(cycles: float, phase: float) -> None:
    """Check that integrated by Simpson's rule, the acceleration gives the published velocity, 0 at both ends."""
    motion = mavroeidis_papageorgiou(0.7, F, cycles, phase)
    s = motion.time - 0.5 * cycles / F
    wanted = 0.35 * (1.0 + np.cos(W * s / cycles)) * np.cos(W * s + phase)
    velocity, _ = integrated(motion)
    np.testing.assert_allclose(velocity, wanted, atol=1e-8)  # 4e-9 measured
    assert motion.duration == pytest.approx(cycles / F, rel=1e-12)
    found = intensity(motion)
    assert abs(found.final_velocity) < 2e-5 * found.pgv  # 1.2e-5 measured: straight lines
    if phase == 0.0:
        assert found.pgv == pytest.approx(0.7, rel=5e-5)  # 2.6e-5 measured: straight lines


def test_noise_ends_without_velocity() -> None:
    for seed in range(5):
        motion = filtered_noise(A, 2.5, 20.0, seed)
        found = intensity(motion)
        assert motion.pga == pytest.approx(A, rel=1e-15)
        assert motion.duration == pytest.approx(20.0, rel=1e-12)
        assert abs(found.final_velocity) < 1e-12 * found.pgv  # 2e-14 measured
        assert motion.ax[0] == 0.0
        # 0.21 m and 0.05 m measured; metres without the second oscillator
        assert found.pgd < 0.25
        assert abs(found.final_displacement) < 0.06
        # 90 % of the intensity within the strong part of the envelope
        assert 0.05 * 20.0 < found.start < 0.25 * 20.0
        assert 0.5 * 20.0 < found.end < 0.75 * 20.0


def test_noise_has_the_spectrum_of_its_filter() -> None:
    """Compare the mean of many with Kanai and Tajimi's with Clough and Penzien's, within the scatter of the mean."""
    ground, damping, dt = 2.5, 0.3, 0.005
    count = 60
    runs = [filtered_noise(1.0, ground, 40.0, seed, damping, dt) for seed in range(count)]
    frequency = np.fft.rfftfreq(len(runs[0].ax), dt)
    power = np.mean([np.abs(np.fft.rfft(run.ax / np.std(run.ax))) ** 2 for run in runs], axis=0)
    bands = [(0.15, 0.3), (0.5, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 5.0), (5.0, 10.0)]
    found = np.array([np.mean(power[(low <= frequency) & (frequency < high)]) for low, high in bands])
    r = (frequency / ground) ** 2
    filtered = (1.0 + 4.0 * damping**2 * r) / ((1.0 - r) ** 2 + 4.0 * damping**2 * r)
    slow = (frequency / (0.1 * ground)) ** 2
    filtered *= slow**2 / ((1.0 - slow) ** 2 + 4.0 * damping**2 * slow)
    wanted = np.array([np.mean(filtered[(low <= frequency) & (frequency < high)]) for low, high in bands])
    # the peak is 40 times the highest band: 5 % measured, by chance of 60 runs
    np.testing.assert_allclose(found / found[3], wanted / wanted[3], rtol=0.15)


def test_noise_is_the_same_for_the_same_seed() -> None:
    assert call(noise.samples, 7) == filtered_noise(1.0, 2.5, 5.0, 7).ax.tobytes().hex()
    assert not np.array_equal(filtered_noise(1.0, 2.5, 5.0, 8).ax, filtered_noise(1.0, 2.5, 5.0, 7).ax)
    # numpy promises the stream of this generator for good
    assert np.random.RandomState(7).standard_normal(2) == pytest.approx([1.690525703800356, -0.4659373705408328])


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ricker(np.nan, 1.0), "amplitude = nan: must be a finite acceleration in m/s2"),
        (lambda: one_sine(1.0, 0.0), "frequency = 0.0: must be a positive frequency in Hz"),
        (lambda: one_cosine(1.0, "1"), "frequency = '1': must be a positive frequency in Hz"),  # type: ignore[arg-type]
        (lambda: mavroeidis_papageorgiou(1.0, 1.0, 1.0), "cycles = 1.0: must be a number of cycles, more than 1"),
        (lambda: mavroeidis_papageorgiou(1.0, 1.0, 2.0, np.inf), "phase = inf: must be a finite angle in rad"),
        (lambda: filtered_noise(1.0, 1.0, 0.01, 1), "duration = 0.01: must be 10 to 10000000 steps of 0.005 s"),
        (lambda: filtered_noise(1.0, 1.0, 10.0, 1.5), "seed = 1.5: must be a whole number from 0 to"),  # type: ignore[arg-type]
        (lambda: filtered_noise(1.0, 1.0, 10.0, 2**32), "seed = 4294967296: must be a whole number"),
        (lambda: filtered_noise(1.0, 1.0, 10.0, 1, 1.0), "damping = 1.0: must be a part of critical"),
        (lambda: filtered_noise(1.0, 1.0, 10.0, 1, 0.5, 0.0), "dt = 0.0: must be a positive time in s"),
    ],
)
def test_mistakes(make: Callable[[], object], said: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert str(caught.value).startswith(said)
