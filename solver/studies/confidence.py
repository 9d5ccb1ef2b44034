"""Likelihood bounds of a lognormal fragility, which hold where the bootstrap has nothing to resample."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..common.errors import needing
from ..models.protocol import FloatArray
from ..models.uncertainty import CONFIDENCE

FARTHEST = 20.0  # largest distance of a bound, in the logarithm of the median
FIRST = 0.05  # first step outwards, in the logarithm
EXACT = 1e-4  # tolerance of each bound, in the logarithm

Profile = Callable[[float], tuple[float, float]]  # maximum likelihood at a value, and the other parameter there


def likelihood_ends(
    x: FloatArray, runs: FloatArray, failed: FloatArray, best: tuple[float, float], widths: tuple[float, float]
) -> FloatArray:
    """Return the curves at the ends of the likelihood region: least and largest median, least and largest deviation.

    A median lies in the region if the likelihood, maximized over the deviations, is at least exp(-q / 2) of the overall
    maximum; a deviation likewise. q is the quantile of chi-squared with one degree of freedom at `CONFIDENCE`. Each run
    is one trial. Return the medians and deviations of the curves, (4, 2).

    Parameters
    ----------
    x, runs, failed : (levels,) float
        Logarithm of each intensity, and the numbers of runs and of failed runs there.
    best, widths : tuple of float
        Median and deviation of maximum likelihood; least and largest deviation of a fit.
    """
    with needing("studies", "scipy"):
        from scipy.special import log_ndtr
        from scipy.stats import chi2
    stood = runs - failed

    def likelihood(median: float, deviation: float) -> float:
        z = (x - median) * math.exp(-deviation)
        return float(np.sum(failed * log_ndtr(z)) + np.sum(stood * log_ndtr(-z)))

    centre, width = math.log(best[0]), math.log(best[1])
    (inner, outer), (low, high) = (centre - FARTHEST, centre + FARTHEST), np.log(widths).tolist()

    def of_median(median: float) -> tuple[float, float]:
        return _largest(lambda deviation: likelihood(median, deviation), low, high)

    def of_deviation(deviation: float) -> tuple[float, float]:
        return _largest(lambda median: likelihood(median, deviation), inner, outer)

    # least log-likelihood in the region, and the ends of both profiles
    least = max(likelihood(centre, width), of_median(centre)[0]) - 0.5 * float(chi2.ppf(CONFIDENCE, 1))
    medians = [_end(of_median, least, centre, limit) for limit in (inner, outer)]
    deviations = [_end(of_deviation, least, width, limit) for limit in (low, high)]
    ends = [(at, of_median(at)[1]) for at in medians] + [(of_deviation(at)[1], at) for at in deviations]
    return np.exp(np.array(ends))


def _largest(function: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Return the maximum of a unimodal function between two ends, and its argument."""
    with needing("studies", "scipy"):
        from scipy.optimize import minimize_scalar
    found = minimize_scalar(lambda at: -function(at), bounds=(low, high), method="bounded", options={"xatol": EXACT})
    return max((function(at), at) for at in (float(found.x), low, high))


def _end(profile: Profile, least: float, start: float, limit: float) -> float:
    """Return the argument at which a profile falls below `least` between `start` and `limit`, or `limit`."""
    # step outwards with doubled steps until the profile falls below
    step, inside = math.copysign(FIRST, limit - start), start
    while abs(inside + step - start) < abs(limit - start) and profile(inside + step)[0] >= least:
        inside, step = inside + step, 2.0 * step
    outside = inside + step
    if abs(outside - start) >= abs(limit - start):
        outside = limit
        if profile(limit)[0] >= least:
            return limit
    # bisect
    while abs(outside - inside) > EXACT:
        middle = 0.5 * (inside + outside)
        if profile(middle)[0] >= least:
            inside = middle
        else:
            outside = middle
    return outside
