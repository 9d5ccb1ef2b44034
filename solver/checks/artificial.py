"""Motions made to fit a spectrum, where there are no records: noise in an envelope, corrected step by step.

As EN 1998-1, 3.2.3.1.2 describes artificial accelerograms. Each iteration multiplies the Fourier coefficients of the
motion by target over response at the same period, without a change of phase (Gasparini and Vanmarcke 1976 do so with
the amplitudes before the envelope), then keeps what is inside the envelope and takes the drift of the base away.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.errors import check_number, check_whole
from ..ground.motion import Motion
from .spectra import DAMPING, FloatArray, Spectral

DT = 0.01  # s
LENGTH = 25.0  # s; with LEVEL below the strong part lasts more than the 10 s of EN 1998-1, 3.2.3.1.2(3)
RISE, LEVEL = 0.1, 0.6  # parts of the length: the envelope rises until the first and falls from the second on
LEFT_AT_END = 0.02
ITERATIONS = 20
FINER = 2  # times as many instants, at which peaks of oscillators are looked for
LOWEST = 0.1  # Hz: slower parts move no column and are not asked for
SHORTEST = 0.04  # s: four samples
PERIODS = np.geomspace(SHORTEST, 5.0, 80)  # s, at which the spectrum is corrected


def artificial_motions(target: Spectral, count: int, seed: int = 0, length: float = LENGTH) -> dict[str, Motion]:
    """`count` motions of `length` s whose spectra of 5 % damping follow a target; seeds `seed`, `seed` + 1 and so on.

    Between 0.05 and 4 s a spectrum stays within about 10 % of the target (tests/checks). Raises InputError.
    """
    count = check_whole("artificial", count, 1, 1000, "a number of motions from 1 to 1000")
    seed = check_whole("seed", seed, 0, 2**32 - count, "a whole number, zero or positive, below 2**32")
    length = check_number("length", length, (10.0, 600.0), "a time in s, from 10 to 600")
    return {f"artificial {seed + k}": fitted_motion(target, seed + k, length) for k in range(count)}


def with_vertical(motions: dict[str, Motion], target: Spectral, seed: int) -> dict[str, Motion]:
    """The motions with vertical components that follow a target of their own, and are independent of the horizontal."""
    beside = _beside(motions, target, seed + 2**31)
    return {name: motion.with_vertical(beside[name]) for name, motion in motions.items()}


def with_across(motions: dict[str, Motion], target: Spectral, seed: int) -> dict[str, Motion]:
    """The motions with second horizontal components that follow the target, and are independent of the first.

    EN 1998-1, 3.2.3.1.1(2): not the same accelerogram along both directions.
    """
    beside = _beside(motions, target, seed + 2**30)
    return {name: motion.with_across(beside[name]) for name, motion in motions.items()}


def _beside(motions: dict[str, Motion], target: Spectral, seed: int) -> dict[str, Motion]:
    """Another motion for each, as long."""
    return {
        name: fitted_motion(target, (seed + k) % 2**32, motion.duration)
        for k, (name, motion) in enumerate(motions.items())
    }


def fitted_motion(target: Spectral, seed: int, length: float = LENGTH) -> Motion:
    """One motion whose spectrum follows the target, the best of the iterations."""
    count = round(length / DT)
    envelope = _envelope(count)
    # RandomState: equal numbers in all versions of numpy
    samples = envelope * np.random.RandomState(seed).standard_normal(count + 1)
    wanted, padded = np.log(target.psa(PERIODS)), 2 * (count + 1)
    frequency = np.fft.rfftfreq(padded, DT)
    passed = np.clip(frequency / LOWEST - 0.5, 0.0, 1.0)
    places = np.log(np.maximum(frequency, 1e-6))
    best, least = samples, np.inf
    for _ in range(ITERATIONS):
        coefficients = np.fft.rfft(samples, padded)
        apart = wanted - np.log(_psa(coefficients, frequency, padded))
        worst = float(np.max(np.abs(apart)))
        if worst < least:
            best, least = samples, worst
        change = np.exp(np.interp(places, -np.log(PERIODS[::-1]), apart[::-1])) * passed
        samples = _without_drift(np.fft.irfft(coefficients * change)[: count + 1], envelope)
    return Motion.from_samples(DT, best)


def _psa(coefficients: NDArray[np.complex128], frequency: NDArray[Any], padded: int) -> FloatArray:
    """Pseudo-acceleration at PERIODS from the Fourier coefficients: faster than step by step, and near enough here."""
    omega, found = 2.0 * np.pi * frequency, np.empty(len(PERIODS))
    for k, own in enumerate(2.0 * np.pi / PERIODS):
        answer = coefficients * own**2 / (own**2 - omega**2 + 2j * DAMPING * own * omega)
        found[k] = np.max(np.abs(np.fft.irfft(answer, FINER * padded))) * FINER
    return found


def _envelope(count: int) -> FloatArray:
    part = np.arange(count + 1) / count
    fall = LEFT_AT_END ** np.maximum(0.0, (part - LEVEL) / (1.0 - LEVEL))
    return np.minimum(1.0, part / RISE) ** 2 * fall


def _without_drift(samples: FloatArray, envelope: FloatArray) -> FloatArray:
    """Samples that leave neither velocity nor displacement at the end: parts of the envelope are subtracted."""
    samples = samples * np.where(envelope > LEFT_AT_END, 1.0, envelope / LEFT_AT_END)
    part = np.linspace(0.0, 1.0, len(samples))
    shapes = np.stack([envelope, envelope * part])
    moments = np.stack([np.ones(len(part)), 1.0 - part])  # of the velocity and the displacement at the end
    weights: FloatArray = np.linalg.solve(moments @ shapes.T, moments @ samples)
    return samples - weights @ shapes
