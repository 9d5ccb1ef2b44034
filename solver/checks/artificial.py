"""Artificial motions that fit a spectrum: noise in an envelope, corrected iteratively.

They are the artificial accelerograms of EN 1998-1, 3.2.3.1.2. Each iteration multiplies the Fourier coefficients of the
motion by target over response at the same period and keeps their phase (Gasparini and Vanmarcke 1976 correct the
amplitudes before the envelope is applied), then truncates the motion to the envelope and removes the drift of the base.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.errors import InputError, check_number, check_whole, shown
from ..ground.motion import Motion
from .spectra import DAMPING, FloatArray, Spectral

DT = 0.01  # s
LENGTH = 25.0  # s; with LEVEL below the strong part lasts more than the 10 s of EN 1998-1, 3.2.3.1.2(3)
RISE, LEVEL = 0.1, 0.6  # over the length: end of the rise of the envelope, begin of its fall
LEFT_AT_END = 0.02  # envelope at the end
ITERATIONS = 20
FINER = 2  # oversampling for the peaks of the oscillators
LOWEST = 0.1  # Hz: lower frequencies do not move a column and are filtered
SHORTEST = 0.04  # s: four samples
PERIODS = np.geomspace(SHORTEST, 5.0, 80)  # s, at which the spectrum is compared
FURTHER = {"across": (Motion.with_across, 2**30), "vertical": (Motion.with_vertical, 2**31)}  # offsets of their seeds


def artificial_motions(target: Spectral, count: int, seed: int = 0, length: float = LENGTH) -> dict[str, Motion]:
    """Return artificial motions whose spectra of 5 % damping follow a target.

    Between 0.05 and 4 s a spectrum stays within about 20 % of the target.

    Parameters
    ----------
    target : Spectral
        The target spectrum.
    count : int
        Number of motions, 1 to 1000.
    seed : int
        Seed of the first motion; the next ones have `seed` + 1 and so on.
    length : float
        Duration of each motion (s), 10 to 600.

    Returns
    -------
    dict
        The motions by name, "artificial SEED".

    Raises
    ------
    InputError
        If an argument is out of range.
    """
    if not callable(getattr(target, "psa", None)):
        raise InputError(f"target = {shown(target)}: must be a spectrum of a code or a table (checks/spectra.py)")
    count = check_whole("artificial", count, 1, 1000, "a number of motions from 1 to 1000")
    seed = check_whole("seed", seed, 0, 2**32 - count, "a whole number, zero or positive, below 2**32")
    length = check_number("length", length, (10.0, 600.0), "a time in s, from 10 to 600")
    return {f"artificial {seed + k}": fitted_motion(target, seed + k, length) for k in range(count)}


def with_component(name: str, motions: dict[str, Motion], target: Spectral, seed: int) -> dict[str, Motion]:
    """Return the motions with further components that follow the target: vertical ones, or second horizontal ones.

    `name` is a key of `FURTHER`. The components are independent of those before (other seeds, from `seed`). EN 1998-1,
    3.2.3.1.1(2): not the same accelerogram along both directions.
    """
    merged, offset = FURTHER[name]
    further = (
        fitted_motion(target, (seed + offset + k) % 2**32, motion.duration) for k, motion in enumerate(motions.values())
    )
    return {key: merged(motion, other) for (key, motion), other in zip(motions.items(), further, strict=True)}


def fitted_motion(target: Spectral, seed: int, length: float = LENGTH) -> Motion:
    """Return one motion whose spectrum follows the target: the best iterate of `ITERATIONS`.

    `length` is its duration (s).
    """
    count = round(length / DT)
    envelope = _envelope(count)
    # noise in the envelope as first iterate
    # RandomState: equal numbers in all versions of numpy
    samples = envelope * np.random.RandomState(seed).standard_normal(count + 1)
    wanted, padded = np.log(target.psa(PERIODS)), 2 * (count + 1)
    frequency = np.fft.rfftfreq(padded, DT)
    passed = np.clip(frequency / LOWEST - 0.5, 0.0, 1.0)
    places = np.log(np.maximum(frequency, 1e-6))
    best, least = samples, np.inf
    for _ in range(ITERATIONS):
        # keep the iterate with the least error of the spectrum (logarithm)
        coefficients = np.fft.rfft(samples, padded)
        apart = wanted - np.log(_psa(coefficients, frequency, padded))
        worst = float(np.max(np.abs(apart)))
        if worst < least:
            best, least = samples, worst
        # correct the amplitudes, then restore the envelope and the rest at the end
        change = np.exp(np.interp(places, -np.log(PERIODS[::-1]), apart[::-1])) * passed
        samples = _without_drift(np.fft.irfft(coefficients * change)[: count + 1], envelope)
    return Motion.from_samples(DT, best)


def _psa(coefficients: NDArray[np.complex128], frequency: NDArray[Any], padded: int) -> FloatArray:
    """Return the pseudo-acceleration (m/s2) at PERIODS from the Fourier coefficients.

    This is faster than integration in time, and accurate enough here.
    """
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
    """Return the samples with neither velocity nor displacement at the end.

    Subtracts two shapes, the envelope and the envelope times time, weighted to cancel both.
    """
    samples = samples * np.where(envelope > LEFT_AT_END, 1.0, envelope / LEFT_AT_END)
    part = np.linspace(0.0, 1.0, len(samples))
    shapes = np.stack([envelope, envelope * part])
    moments = np.stack([np.ones(len(part)), 1.0 - part])  # velocity and displacement at the end
    weights: FloatArray = np.linalg.solve(moments @ shapes.T, moments @ samples)
    return samples - weights @ shapes
