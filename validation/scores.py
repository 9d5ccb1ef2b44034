"""Scores of a prediction of verdicts: agreement, logarithmic score, calibration; halves to fit and to judge on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import ndtr

from .rigid_block import Flags, FloatArray

LAPSE = 0.02  # part of the tests whose outcome no model can know: shares lie within 0.01 and 0.99
LAPSES = (0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4)  # of models that give a verdict, not a share
Z = 1.96  # of 95 % bounds


def halves(fallen: Flags, splits: int, seed: int) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Yield random halves with the same part of fallen tests in each: indices to fit on, indices to judge on."""
    rng = np.random.default_rng(seed)
    for _ in range(splits):
        order = np.concatenate([rng.permutation(np.flatnonzero(fallen)), rng.permutation(np.flatnonzero(~fallen))])
        yield np.sort(order[::2]), np.sort(order[1::2])


def with_lapse(share: FloatArray, lapse: float = LAPSE) -> FloatArray:
    """Return shares moved away from 0 and 1, so that one wrong certainty does not cost everything."""
    return 0.5 * lapse + (1.0 - lapse) * share


def with_lapses(verdicts: FloatArray) -> FloatArray:
    """Return deterministic verdicts (c, m) as shares with each of LAPSES, (c * lapses, m), so that it can be fitted."""
    return np.concatenate([with_lapse(row, lapse)[None] for row in verdicts for lapse in LAPSES])


def failed_as_standing(verdicts: dict[str, FloatArray]) -> tuple[dict[str, FloatArray], str]:
    """Return verdicts with those of runs that ended with an error, NaN, as standing; and a line that counts them."""
    failed = sum(int(np.sum(np.isnan(found))) for found in verdicts.values())
    line = f"{failed} of {sum(found.size for found in verdicts.values())} runs ended with an error, counted as standing"
    return {name: np.nan_to_num(found, nan=0.0) for name, found in verdicts.items()}, line


def agreement(share: FloatArray, fallen: Flags) -> float:
    """Return the part of the tests on whose side the share is."""
    return float(np.mean((share > 0.5) == fallen))


def log_score(share: FloatArray, fallen: Flags) -> FloatArray:
    """Return the mean logarithm of the share given to what happened, over the last axis: 0 is perfect, -0.693
    a coin.
    """
    return np.mean(np.log(np.where(fallen, share, 1.0 - share)), axis=-1)


def lognormal_fit(measure: FloatArray, fallen: Flags) -> tuple[float, float]:
    """Return the median and deviation of the lognormal fragility that is most likely, with the lapse."""

    def cost(x: FloatArray) -> float:
        return -float(log_score(lognormal(measure, float(np.exp(x[0])), float(np.exp(x[1]))), fallen))

    start = np.array([np.log(np.median(measure[fallen])), np.log(0.5)])
    median, deviation = np.exp(minimize(cost, start, method="Nelder-Mead").x)
    return float(median), float(deviation)


def lognormal(measure: FloatArray, median: float, deviation: float) -> FloatArray:
    """Return the share that falls at a measure of intensity."""
    return with_lapse(ndtr(np.log(measure / median) / deviation))


def bounds(count: FloatArray, total: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the 95 % bounds of a share, Wilson (1927)."""
    share = count / total
    middle = (share + Z**2 / (2.0 * total)) / (1.0 + Z**2 / total)
    half = Z / (1.0 + Z**2 / total) * np.sqrt(share * (1.0 - share) / total + Z**2 / (4.0 * total**2))
    return middle - half, middle + half


def binned(place: FloatArray, edges: FloatArray, share: FloatArray, fallen: Flags) -> FloatArray:
    """Return the number of tests, mean share predicted, number fallen, in each bin of `place` that has any:
    (bins, 3).
    """
    index = np.digitize(place, edges[1:-1])
    rows = [
        (np.sum(index == k), np.mean(share[index == k]), np.sum(fallen[index == k]))
        for k in range(len(edges) - 1)
        if np.any(index == k)
    ]
    return np.array(rows, dtype=np.float64)
