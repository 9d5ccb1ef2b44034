"""Motions by formula: wavelets of near-fault ground motion, and filtered noise by seed; samples, linear in between."""

from __future__ import annotations

import math

import numpy as np

from ..common.errors import FINITE, POSITIVE, check_number, check_whole
from . import oscillator
from .motion import Motion
from .records.record import FloatArray

PER_CYCLE = 400  # samples per cycle: linear interpolation has an error of 3e-5 of the peak
RICKER_HALF = 2.0  # cycles from the start to the middle of a Ricker wavelet, where it is truncated at 1e-15 of its peak
GROUND_DAMPING = 0.6  # damping ratio of Kanai's firm ground
CORNER = 0.1  # of the ground's frequency: noise below it is filtered out
NOISE_STEP = 0.005  # s
MOST_SAMPLES = 10**7
SEEDS = 0, 2**32 - 1, f"a whole number from 0 to {2**32 - 1}"
# the envelope of Amin and Ang (1968), by fractions of the duration: quadratic rise, plateau, exponential decay
RISE, LEVEL, LEFT_AT_END = 0.15, 0.6, 0.01


def ricker(amplitude: float, frequency: float) -> Motion:
    """Return a Ricker wavelet, a = A (1 - 2 x) exp(-x) with x = (pi f (t - 2 / f))^2, over 0 <= t <= 4 / f.

    It ends without velocity and where it began. Ricker (1943), Geophysics 8 (4).

    Parameters
    ----------
    amplitude : float
        A, the peak (m/s2), at t = 2 / f.
    frequency : float
        f, the frequency of the peak of the Fourier spectrum (Hz).

    Raises
    ------
    InputError
        If a value is out of range.
    """
    amplitude, frequency = _amplitude(amplitude), _frequency(frequency)
    time = _instants(2.0 * RICKER_HALF, frequency)
    x = (np.pi * frequency * (time - RICKER_HALF / frequency)) ** 2
    return _motion(time, amplitude * (1.0 - 2.0 * x) * np.exp(-x), f"a Ricker wavelet of {frequency:g} Hz")


def one_sine(amplitude: float, frequency: float) -> Motion:
    """Return one cycle of a sine of acceleration (m/s2, Hz): a one-sided velocity pulse, which ends displaced.

    Makris and Roussos (2000), Geotechnique 50 (3), 243-262 (type A). Raises InputError if a value is out of range.
    """
    amplitude, frequency = _amplitude(amplitude), _frequency(frequency)
    time = _instants(1.0, frequency)
    return _motion(time, amplitude * np.sin(2.0 * np.pi * frequency * time), f"one sine of {frequency:g} Hz")


def one_cosine(amplitude: float, frequency: float) -> Motion:
    """Return one cycle of a cosine of acceleration (m/s2, Hz): a two-sided velocity pulse.

    It ends where it began, and begins and ends with a jump. Makris and Roussos (2000) (type B). Raises InputError if a
    value is out of range.
    """
    amplitude, frequency = _amplitude(amplitude), _frequency(frequency)
    time = _instants(1.0, frequency)
    return _motion(time, amplitude * np.cos(2.0 * np.pi * frequency * time), f"one cosine of {frequency:g} Hz")


def mavroeidis_papageorgiou(velocity: float, frequency: float, cycles: float, phase: float = 0.0) -> Motion:
    """Return the acceleration of the pulse of velocity v = A / 2 (1 + cos(2 pi f s / g)) cos(2 pi f s + nu).

    s is the time from its middle, |s| <= g / (2 f); the motion begins at t = 0 and ends without velocity. Mavroeidis
    and Papageorgiou (2003), Bull. Seism. Soc. Am. 93 (3), 1099-1131.

    Parameters
    ----------
    velocity : float
        A (m/s).
    frequency : float
        f (Hz).
    cycles : float
        g, the number of cycles within the envelope, more than 1.
    phase : float
        nu (rad).

    Raises
    ------
    InputError
        If a value is out of range.
    """
    velocity = check_number("velocity", velocity, FINITE, "a finite velocity in m/s")
    frequency = _frequency(frequency)
    above_one = (float(np.nextafter(1.0, 2.0)), 1e3)
    cycles = check_number("cycles", cycles, above_one, "a number of cycles, more than 1, at most 1000")
    phase = check_number("phase", phase, FINITE, "a finite angle in rad")
    time = _instants(cycles, frequency)
    angle = 2.0 * np.pi * frequency * (time - 0.5 * cycles / frequency)
    bell = angle / cycles
    shape = np.sin(bell) * np.cos(angle + phase) + cycles * np.sin(angle + phase) * (1.0 + np.cos(bell))
    name = f"a Mavroeidis-Papageorgiou pulse of {frequency:g} Hz"
    return _motion(time, -velocity * np.pi * frequency / cycles * shape, name)


def filtered_noise(
    amplitude: float,
    frequency: float,
    duration: float,
    seed: int,
    damping: float = GROUND_DAMPING,
    dt: float = NOISE_STEP,
) -> Motion:
    """Return white noise filtered by the ground as an oscillator (Kanai and Tajimi), with the envelope of Amin and Ang.

    Long periods would displace the ground by metres; a second oscillator, at a tenth of the frequency, removes them
    (Clough and Penzien 1993). A multiple of the envelope is subtracted so that no velocity is left at the end.

    Parameters
    ----------
    amplitude : float
        The peak (m/s2).
    frequency : float
        The frequency of the ground (Hz), about 2.5 where it is firm.
    duration : float
        The duration (s); the envelope rises over 15 % of it, is constant until 60 %, and decays to 1 %.
    seed : int
        The seed; equal seeds give equal motions.
    damping : float
        The damping ratio of the ground.
    dt : float
        The sampling interval (s).

    Raises
    ------
    InputError
        If a value is out of range.
    """
    amplitude, frequency = _amplitude(amplitude), _frequency(frequency)
    dt = check_number("dt", dt, POSITIVE, "a positive time in s")
    steps = f"10 to {MOST_SAMPLES} steps of {dt} s"
    duration = check_number("duration", duration, (10.0 * dt, MOST_SAMPLES * dt), steps)
    damping = check_number("damping", damping, (0.01, 0.99), "a part of critical from 0.01 to 0.99")
    seed = check_whole("seed", seed, *SEEDS)
    count = round(duration / dt)
    # NumPy guarantees that RandomState's numbers are the same in all versions, those of default_rng are not
    white = np.random.RandomState(seed).standard_normal(count + 1)
    part = np.arange(count + 1) / count
    fall = np.exp(np.log(LEFT_AT_END) * (part - LEVEL) / (1.0 - LEVEL))
    envelope = np.where(part < RISE, (part / RISE) ** 2, np.minimum(fall, 1.0))
    ground = -envelope * _restoring(white, dt, frequency, damping)  # absolute acceleration of the first oscillator
    # acceleration of the second relative to it: its velocity and displacement decay after the shaking
    samples = -ground - _restoring(ground, dt, CORNER * frequency, damping)
    weight = np.full(count + 1, dt)  # of the trapezoidal rule, exact for straight lines
    weight[[0, -1]] *= 0.5
    samples -= envelope * (np.sum(weight * samples) / np.sum(weight * envelope))
    time = dt * np.arange(count + 1, dtype=np.float64)
    return _motion(time, amplitude / np.max(np.abs(samples)) * samples, f"noise of {frequency:g} Hz, seed {seed}")


def _restoring(base: FloatArray, dt: float, frequency: float, damping: float) -> FloatArray:
    """Return the force of spring and dashpot of an oscillator per unit mass (m/s2) under base accelerations."""
    omega = 2.0 * np.pi * frequency
    u, v = oscillator.response(np.full(len(base) - 1, dt), base[:-1], base[1:], np.array([omega]), damping)
    return 2.0 * damping * omega * v[:, 0] + omega**2 * u[:, 0]


def _amplitude(value: float) -> float:
    return check_number("amplitude", value, FINITE, "a finite acceleration in m/s2")


def _frequency(value: float) -> float:
    return check_number("frequency", value, POSITIVE, "a positive frequency in Hz")


def _instants(cycles: float, frequency: float) -> FloatArray:
    """Return equally spaced instants from 0 to `cycles` cycles, both included, at least 400 per cycle."""
    count = math.ceil(PER_CYCLE * cycles)
    return cycles / frequency / count * np.arange(count + 1, dtype=np.float64)


def _motion(time: FloatArray, ax: FloatArray, name: str) -> Motion:
    """Return the motion of samples at equal steps from 0."""
    duration, az = float(time[-1]), np.zeros(len(time))
    valid = np.isfinite(ax).all() and POSITIVE[0] <= duration <= POSITIVE[1] and time[1] > 0.0
    return (Motion.unchecked if valid else Motion)(time, ax, az, duration).named(name)  # Motion raises the error
