"""Statistics of the runs of a study: curves over intensity, probabilities with bounds, influence of parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.errors import InputError, check_type, needing
from ..common.notebook import NotebookRepr, counted
from ..models.protocol import FloatArray
from ..models.structure.numbers import unit_in_space
from ..models.uncertainty import CONFIDENCE, PERCENTILES, share_bounds
from .confidence import likelihood_ends
from .motions import OF_MOTION, WHOLE, Measure
from .results import Results

# function of the weights of the runs and a first guess that returns median and deviation
Fit = Callable[[FloatArray, tuple[float, float] | None], tuple[float, float]]

Limit = float | Literal["hit"] | None  # m, largest displacement beyond which a run failed; None: overturning
LEAST_GAP = "least_gap"  # least gap of neighbours (m), if a study keeps it: below 0 they have hit

RESAMPLED = 200  # number of samples of the bootstrap
GROUPS = 1000  # largest number of levels; beyond it neighbouring intensities are replaced by their means
BINS = 12
SAME = 1e-9  # relative difference up to which intensities are one level: scaling rounds
LEAST_DEVIATION, MOST_DEVIATION = 0.01, 5.0
SEEDS = tuple(f"{OF_MOTION}{key}" for key in WHOLE)  # names that label motions
TAIL = 0.16  # part of the runs at either end of a parameter


@dataclass(frozen=True, repr=False)
class Bins(NotebookRepr):
    """The shares of failures in bins of the intensity.

    Attributes
    ----------
    edges
        Edges of the bins, (b + 1,).
    middle
        Geometric mean intensity of the runs, (b,).
    runs
        Number of runs, (b,).
    failed
        Number of failed runs, (b,).
    undecided
        Number of runs that have not failed and may yet overturn, (b,).
    low
        Lower bound of Clopper and Pearson at 95 % confidence, (b,).
    high
        Upper bound, likewise.
    """

    edges: FloatArray
    middle: FloatArray
    runs: NDArray[np.int64]
    failed: NDArray[np.int64]
    undecided: NDArray[np.int64]
    low: FloatArray
    high: FloatArray

    def _facts(self) -> tuple[str, ...]:
        return f"of {len(self.runs)}", f"{self.failed.sum()} of {self.runs.sum()} runs failed"

    @property
    def share(self) -> FloatArray:
        """The share of failed runs, (b,)."""
        return np.asarray(self.failed / self.runs)


@dataclass(frozen=True, repr=False)
class Fragility(NotebookRepr):
    """A lognormal probability of failure over an intensity: median, and deviation of the logarithm.

    Attributes
    ----------
    name
        Name of the intensity.
    median
        Median, in the unit of the intensity.
    deviation
        Standard deviation of the logarithm.
    median_bounds
        Bounds of the median at 95 % confidence: the wider of those by the bootstrap and, for failures, by the
        likelihood.
    deviation_bounds
        Bounds of the deviation, likewise.
    curves
        Medians and deviations of the samples of the bootstrap, (resampled, 2).
    ends
        Medians and deviations of the curves at the ends of the likelihood region, (k, 2).
    bins
        The data themselves.
    runs
        Number of runs.
    failed
        Number of failed runs.
    undecided
        Number of runs that have not failed and may yet overturn; the curve takes them as standing.
    how
        What was fitted, in words.
    measure
        The measure of the intensity; None for other columns of the results.
    """

    name: str
    median: float
    deviation: float
    median_bounds: tuple[float, float]
    deviation_bounds: tuple[float, float]
    curves: FloatArray
    ends: FloatArray
    bins: Bins
    runs: int
    failed: int
    undecided: int
    how: str
    measure: Measure | None = None

    def _facts(self) -> tuple[str, ...]:
        parts = ("median", self.median, self.median_bounds), ("deviation", self.deviation, self.deviation_bounds)
        of_the_curve = (f"{name} {value:.3g} ({low:.3g} to {high:.3g})" for name, value, (low, high) in parts)
        return (
            f"over {self.name}",
            *of_the_curve,
            f"{self.failed} of {self.runs} runs failed, {self.undecided} undecided",
        )

    def probability(self, intensity: FloatArray) -> FloatArray:
        """Return the probability of failure at intensities of any shape."""
        return lognormal(np.asarray(intensity, dtype=np.float64), self.median, self.deviation)

    def band(self, intensity: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bounds of the curve at each intensity, two of (k,), at 95 % confidence."""
        curves = np.array([lognormal(intensity, median, deviation) for median, deviation in self.curves])
        low, high = np.percentile(curves, percentages_of_bounds(), axis=0)
        outer = np.array([low, high, *(lognormal(intensity, median, deviation) for median, deviation in self.ends)])
        return np.min(outer, axis=0), np.max(outer, axis=0)


def lognormal(intensity: FloatArray, median: float, deviation: float) -> FloatArray:
    """Return the lognormal distribution function at intensities of any shape. `deviation` is that of the logarithm."""
    with needing("studies", "scipy"):
        from scipy.special import ndtr
    with np.errstate(divide="ignore"):
        return np.asarray(ndtr((np.log(intensity) - math.log(median)) / deviation))


def failed_of(results: Results, limit: Limit = None) -> NDArray[np.bool_]:
    """Return True for each run that failed, (runs,).

    `limit` is the largest displacement (m) beyond which a run failed, None for overturning alone, "hit" for a hit of
    any neighbours. A column that fell exceeds every displacement.
    """
    if limit == "hit":
        return np.asarray(np.any(results[LEAST_GAP] < 0.0, axis=1))
    return results.overturned if limit is None else np.asarray(results.largest > limit)


class Failure(NamedTuple):
    """A failure of a study that has a probability.

    `limit` is that of `fit_fragility`; `chosen` is the mask of the runs used, (runs,), None for all runs.
    """

    name: str
    limit: Limit
    chosen: NDArray[np.bool_] | None = None


def failures_of(results: Results) -> Iterator[Failure]:
    """Yield the failures of a study: by displacement, by overturning, and by a hit if there are neighbours.

    Hits have one failure for each value of the number that the grid varies.
    """
    for limit in results.study["limits"]:
        yield Failure(failure_text(limit), limit)
    yield Failure(failure_text(None), None)
    if LEAST_GAP in results:
        name = other_varied_name(results)
        if name is None:
            yield Failure("hit", "hit")
        else:
            key, unit = name.rpartition(".")[2], unit_in_space(name)
            for value in results.study["grid"][name]:
                yield Failure(f"hit, {key} {value:g}{unit and f' {unit}'}", "hit", results[name] == value)


def other_varied_name(results: Results) -> str | None:
    """Return the name that the grid varies besides the intensity, or None unless there is exactly one."""
    names = [name for name in results.study["grid"] if name != "intensity"]
    return names[0] if len(names) == 1 else None


def made(results: Results, limit: Limit = None) -> NDArray[np.bool_]:
    """Return True for each run that the solver finished, (runs,).

    For the `limit` "hit" it has gaps as well: those of a structure that falls under its weight alone are not known.
    """
    found = np.asarray(~np.isnan(results.largest))
    return found & ~np.isnan(results[LEAST_GAP]).all(axis=1) if limit == "hit" else found


def check_made(results: Results) -> None:
    """Raise InputError if no run is finished, or if the solver could make none."""
    name, failures = results.study["name"], results["failure"]
    if not len(results):
        raise InputError(f"{name}: no run is finished yet")
    if not np.any(made(results)):
        raise InputError(f"{name}: none of {len(results)} runs could be made, run {results['run'][0]}: {failures[0]}")


def fit_fragility(
    results: Results,
    intensity: str | None = None,
    limit: Limit = None,
    *,
    method: str = "failures",
    bins: int = BINS,
    resampled: int = RESAMPLED,
    chosen: NDArray[np.bool_] | None = None,
) -> Fragility:
    """Fit a lognormal fragility of maximum likelihood over an intensity.

    A run fails by overturning, or by a largest displacement above `limit`.

    With the method "failures" each run is a success or a failure. With "demand" the logarithm of the largest
    displacement is linear in that of the intensity, with normal scatter; overturned runs are censored at the limit. It
    needs a limit, and fewer failures.

    The bounds come from resampling, 200 times, the groups of runs that share a motion and a sample of the random
    parameters, each group with all its intensities. For failures they also come from the likelihood with all runs as
    trials (confidence.py), which has a width even if few levels have both outcomes or there is a single motion; the
    wider bounds are returned.

    Parameters
    ----------
    results : Results
        The results.
    intensity : str, optional
        Column of the results, by default the measure of the study.
    limit : float, "hit" or None
        Largest displacement (m); "hit" for hits of neighbours, None for overturning alone.
    method : str
        "failures" or "demand".
    bins : int
        Number of bins of the data.
    resampled : int
        Number of samples of the bootstrap.
    chosen : (runs,) bool, optional
        The runs used.

    Returns
    -------
    Fragility
        The curve, its bounds, and the data.

    Raises
    ------
    InputError
        If the runs do not determine the curve: none or all failed, or all stand below one intensity and all fail above
        it, so that any deviation fits.
    """
    check_type("results", results, Results)
    check_made(results)
    name = intensity or intensity_name(results)
    valid = made(results, limit) & (results[name] > 0.0)
    if chosen is not None:
        valid &= chosen
    # runs, failures, and groups that are resampled together
    im, failed = results[name][valid], failed_of(results, limit)[valid]
    undecided = results.undecided[valid] & ~failed
    clusters = np.unique(_clusters(results)[valid], return_inverse=True)[1]
    _refuse_one_sided(name, failed)
    levels = None
    if method == "failures":
        _refuse_separated(name, im, failed, measure_in(results, name))
        fit, levels = _of_failures(im, failed)
        how = failure_text(limit)
    elif method == "demand":
        if limit is None or limit == "hit":
            raise InputError("limit: must be given for the method demand, in m")
        if clusters.max() == 0:
            raise InputError("method = 'demand': needs several motions or samples, whose resampling gives its bounds")
        fit = _of_demand(im, results.largest[valid], limit)
        how = f"moved by more than {limit:g} m, by the demand of those that stand"
    else:
        raise InputError(f"method = {method!r}: must be failures or demand")
    seed, measure = results.study["seed"], measure_in(results, name)
    return _with_bounds(name, im, failed, undecided, clusters, fit, levels, seed, resampled, bins, how, measure)


def fragility_of_runs(
    measure: Measure,
    intensity: FloatArray,
    failed: NDArray[np.bool_],
    groups: NDArray[np.int64],
    how: str,
    undecided: NDArray[np.bool_],
) -> Fragility:
    """Fit a lognormal fragility to runs that are no results of a study, as `fit_fragility` by failures.

    For each run, (runs,): the intensity in the unit of the measure, failure, group that is resampled with it (from 0),
    and whether it is undecided, which counts as standing. `how` is the failure in words. Raises InputError.
    """
    _refuse_one_sided(measure.label, failed)
    _refuse_separated(measure.label, intensity, failed, measure)
    fit, levels = _of_failures(intensity, failed)
    return _with_bounds(
        measure.name, intensity, failed, undecided, groups, fit, levels, 0, RESAMPLED, BINS, how, measure
    )


def _with_bounds(
    name: str,
    im: FloatArray,
    failed: NDArray[np.bool_],
    undecided: NDArray[np.bool_],
    clusters: NDArray[np.int64],
    fit: Fit,
    levels: tuple[FloatArray, FloatArray, FloatArray] | None,
    seed: int,
    resampled: int,
    bins: int,
    how: str,
    measure: Measure | None,
) -> Fragility:
    """Return the best fit with its bounds; `levels` are those of the failures, if these were fitted."""
    # best fit, and fits to resampled groups
    best = fit(np.ones(len(im)), None)
    rng = np.random.default_rng(seed)
    count = int(clusters.max()) + 1

    def again() -> tuple[float, float]:
        times = np.bincount(rng.integers(count, size=count), minlength=count)
        return fit(times[clusters].astype(np.float64), best)

    curves = np.array([again() for _ in range(resampled)])
    bounds = np.percentile(curves, percentages_of_bounds(), axis=0)
    # the wider of the bounds by bootstrap and likelihood
    ends = np.empty((0, 2))
    if levels is not None:
        ends = likelihood_ends(*levels, best, (LEAST_DEVIATION, MOST_DEVIATION))
        bounds = np.array(
            [by(np.vstack([bound, ends]), axis=0) for by, bound in zip((np.min, np.max), bounds, strict=True)]
        )
    return Fragility(
        name=name,
        median=best[0],
        deviation=best[1],
        median_bounds=(float(bounds[0, 0]), float(bounds[1, 0])),
        deviation_bounds=(float(bounds[0, 1]), float(bounds[1, 1])),
        curves=curves,
        ends=ends,
        bins=binned(im, failed, bins, undecided),
        runs=len(im),
        failed=int(np.sum(failed)),
        undecided=int(np.sum(undecided)),
        how=how,
        measure=measure,
    )


def _refuse_one_sided(name: str, failed: NDArray[np.bool_]) -> None:
    """Raise InputError if none or all of the runs failed."""
    if not 0 < np.sum(failed) < len(failed):
        raise InputError(f"{name}: {np.sum(failed)} of {len(failed)} runs failed: a fragility needs some of both")


def _refuse_separated(
    name: str, intensity: FloatArray, failed: NDArray[np.bool_], measure: Measure | None = None
) -> None:
    """Raise InputError, with bounds of the median, if all runs stand below one intensity and all fail above it."""
    low, high = float(np.max(intensity[~failed])), float(np.min(intensity[failed]))
    if low < high:
        unit = f" {measure.unit}" if measure else ""
        raise InputError(
            f"{name}: all runs up to {low:.4g}{unit} stand and all from {high:.4g}{unit} on fail: the median lies "
            f"between {low:.4g} and {high:.4g}{unit}, its bounds and the deviation need more levels there"
        )


def failure_text(limit: Limit) -> str:
    """Return a failure as text."""
    words = {None: "overturned", "hit": "neighbours that hit"}
    return words[limit] if limit is None or limit == "hit" else f"overturned or moved by more than {limit:g} m"


def undecided_text(count: int) -> str:
    """Return the text on the undecided runs of a study, "" if there are none."""
    if not count:
        return ""
    runs, they = ("run", "it was") if count == 1 else ("runs", "they were")
    return f"{count} undecided {runs} neither fell nor came to rest while {they} followed"


def intensity_name(results: Results) -> str:
    """Return the name of the measure of the study, pga if it has none."""
    measure = results.study["intensity"]
    return "pga" if measure is None else str(measure["measure"])


def measure_in(results: Results, name: str) -> Measure | None:
    """Return the measure of intensity in a column of the results, None if it is none."""
    table = results.study["intensity"]
    if table is not None and table["measure"] == name:
        return Measure.from_table(table)
    return Measure(name) if name in ("pga", "pgv") else None


def binned(
    intensity: FloatArray, failed: NDArray[np.bool_], bins: int = BINS, undecided: NDArray[np.bool_] | None = None
) -> Bins:
    """Return the shares of failures in bins of the intensity.

    Up to 2 * `bins` different intensities get a bin each; if there are more, the bins have equal counts.

    Parameters
    ----------
    intensity : (runs,) float
        Intensity of each run.
    failed : (runs,) bool
        Whether it failed.
    bins : int
        Number of bins.
    undecided : (runs,) bool, optional
        Whether it is undecided.
    """
    # edges: between the levels, or quantiles
    levels = np.unique(intensity)
    levels = levels[np.append(True, np.diff(levels) > SAME * levels[1:])]
    if len(levels) <= 2 * bins:
        between = 0.5 * (levels[1:] + levels[:-1])
        edges = np.concatenate([levels[:1], between, levels[-1:]])
    else:
        edges = np.unique(np.quantile(intensity, np.linspace(0.0, 1.0, bins + 1)))
    # counts in each bin
    place = np.clip(np.searchsorted(edges, intensity, side="right") - 1, 0, len(edges) - 2)
    runs = np.bincount(place, minlength=len(edges) - 1)
    hits, open_ones = (
        np.bincount(place, weights=some, minlength=len(edges) - 1).astype(np.int64)
        for some in (failed, np.zeros(len(failed)) if undecided is None else undecided)
    )
    middle = np.exp(np.bincount(place, weights=np.log(intensity), minlength=len(edges) - 1) / np.maximum(runs, 1))
    occupied = runs > 0
    low, high = bounds_of(hits[occupied], runs[occupied])
    return Bins(edges, middle[occupied], runs[occupied], hits[occupied], open_ones[occupied], low, high)


def bounds_of(count: NDArray[np.int64], size: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Return `share_bounds` of many shares, `count` of `size`, (k,) each."""
    found = [share_bounds(one, of) for one, of in zip(count.tolist(), size.tolist(), strict=True)]
    low, high = np.array(found).reshape(-1, 2).T
    return low, high


def _of_failures(
    intensity: FloatArray, failed: NDArray[np.bool_]
) -> tuple[Fit, tuple[FloatArray, FloatArray, FloatArray]]:
    """Return the fit of maximum likelihood of the failures, and its levels.

    The probability of failure is ndtr((log im - log median) / deviation). Levels: log im, runs and failures, (levels,)
    each; neighbouring intensities are grouped beyond GROUPS levels.
    """
    with needing("studies", "scipy"):
        from scipy.special import log_ndtr
    # levels: different intensities, or groups of neighbouring ones
    every = np.log(intensity)
    x, group = np.unique(every, return_inverse=True)
    if len(x) > GROUPS:
        order = np.argsort(every, kind="stable")
        group = np.empty(len(every), dtype=np.int64)
        group[order] = np.arange(len(every)) * GROUPS // len(every)
        x = np.bincount(group, weights=every) / np.bincount(group)

    def fit(weights: FloatArray, start: tuple[float, float] | None) -> tuple[float, float]:
        runs, hits = (np.bincount(group, weights=each, minlength=len(x)) for each in (weights, weights * failed))

        def loss(p: FloatArray) -> tuple[float, FloatArray]:
            deviation = math.exp(p[1])
            # negative log-likelihood and its gradient by log median and log deviation
            z = (x - p[0]) / deviation
            yes, no = log_ndtr(z), log_ndtr(-z)
            density = -0.5 * z * z - 0.5 * math.log(2.0 * math.pi)
            slope = hits * np.exp(density - yes) - (runs - hits) * np.exp(density - no)
            value = -float(np.sum(hits * yes + (runs - hits) * no))
            return value, np.array([np.sum(slope) / deviation, np.sum(slope * z)])

        if start is None:
            start = math.exp(float(np.sum(runs * x) / np.sum(runs))), max(LEAST_DEVIATION, float(np.std(x)))
        median, deviation = _minimum(loss, start)
        return math.exp(median), math.exp(deviation)

    counts = np.bincount(group, minlength=len(x)), np.bincount(group, weights=failed)
    return fit, (x, counts[0].astype(np.float64), counts[1].astype(np.float64))


def _of_demand(intensity: FloatArray, largest: FloatArray, limit: float) -> Fit:
    """Return the maximum-likelihood fit of log u = a + b log im + s e, censored at the `limit` (m)."""
    with needing("studies", "scipy"):
        from scipy.optimize import minimize
        from scipy.special import log_ndtr
    # displacements beyond the limit are censored at it
    x, beyond = np.log(intensity), largest > limit
    y = np.log(np.where(beyond, limit, largest))

    def fit(weights: FloatArray, _: tuple[float, float] | None) -> tuple[float, float]:
        def loss(p: FloatArray) -> float:
            z = (y - p[0] - p[1] * x) / math.exp(p[2])
            seen = -0.5 * z * z - p[2]
            return -float(np.sum(weights * np.where(beyond, log_ndtr(-z), seen)))

        # start from a line through the uncensored displacements
        slope, base = np.polyfit(x[~beyond], y[~beyond], 1)
        found = minimize(loss, np.array([base, max(slope, 0.1), math.log(0.5)]), method="Nelder-Mead").x
        if not found[1] > 0.0:
            raise InputError("the displacements do not grow with the intensity: the method demand does not apply")
        return math.exp((math.log(limit) - found[0]) / found[1]), math.exp(found[2]) / found[1]

    return fit


def _minimum(loss: Any, start: tuple[float, float]) -> tuple[float, float]:
    with needing("studies", "scipy"):
        from scipy.optimize import minimize
    first = np.log(np.clip(start, (1e-12, LEAST_DEVIATION), (1e12, MOST_DEVIATION)))
    bounds = [(None, None), (math.log(LEAST_DEVIATION), math.log(MOST_DEVIATION))]
    found = minimize(loss, first, jac=True, bounds=bounds, method="L-BFGS-B")
    return float(found.x[0]), float(found.x[1])


def percentages_of_bounds() -> list[float]:
    """Return the percentiles of a sample between which the part CONFIDENCE of it lies."""
    return [50.0 * (1.0 - CONFIDENCE), 50.0 * (1.0 + CONFIDENCE)]


def _clusters(results: Results) -> NDArray[np.int64]:
    """Return the index of the group of each run, (runs,): a motion with one sample of the random parameters."""
    samples = results.study["samples"]
    return np.asarray(results["motion"] * samples + results["run"] % samples)


@dataclass(frozen=True, repr=False)
class Curves(NotebookRepr):
    """The curves of an incremental dynamic analysis.

    Attributes
    ----------
    name
        Name of the intensity.
    levels
        Levels of the intensity, (levels,).
    percentiles
        The 16, 50 and 84 % points of the largest displacement (m), (3, levels); infinite where they fell.
    overturned
        Share of the runs at each level that overturned, (levels,).
    undecided
        Share of the runs at each level that are undecided, (levels,).
    each
        One curve for each motion and sample (m), (curves, levels).
    """

    name: str
    levels: FloatArray
    percentiles: FloatArray
    overturned: FloatArray
    undecided: FloatArray
    each: FloatArray

    def _facts(self) -> tuple[str, ...]:
        return f"over {self.name}", counted(len(self.levels), "level"), counted(len(self.each), "curve")


def ida_curves(results: Results) -> Curves:
    """Return the curves of an incremental dynamic analysis. Raises InputError unless the grid has intensities."""
    check_type("results", results, Results)
    if "intensity" not in results.study["grid"]:
        raise InputError("grid.intensity: missing, the curves need levels of intensity")
    check_made(results)
    # one row of displacements for each column, motion, sample and other point of the grid
    levels = np.unique(results["intensity"])
    level = np.searchsorted(levels, results["intensity"])
    other = [results[name] for name in results.study["grid"] if name != "intensity"]
    keys = np.column_stack([results["column"], _clusters(results), *other])
    _, curve = np.unique(keys, axis=0, return_inverse=True)
    each = np.full((int(curve.max()) + 1, len(levels)), math.nan)
    each[curve.ravel(), level] = results.largest
    there = np.maximum(np.sum(~np.isnan(each), axis=0), 1)
    return Curves(
        name=intensity_name(results),
        levels=levels,
        percentiles=percentiles(each),
        overturned=np.sum(np.isinf(each), axis=0) / there,
        undecided=np.bincount(level, weights=results.undecided & made(results), minlength=len(levels)) / there,
        each=each,
    )


def percentiles(values: FloatArray) -> FloatArray:
    """Return the 16, 50 and 84 % points over the first axis.

    NaN is ignored, infinite values count; each point is the value of the nearest rank, without interpolation.
    """
    ordered = np.sort(values, axis=0)
    last = np.sum(~np.isnan(ordered), axis=0) - 1
    places = [np.maximum(np.floor(0.01 * point * last + 0.5).astype(np.int64), 0) for point in PERCENTILES]
    return np.array([np.take_along_axis(ordered, place[None], axis=0)[0] for place in places])


@dataclass(frozen=True)
class Influence:
    """The effect of a random parameter where it is low, and where it is high: in 16 % of the runs each.

    Attributes
    ----------
    name
        Name of the parameter.
    values
        Median of the parameter, low and high.
    displacement
        Median of the largest displacement (m), low and high.
    overturned
        Share of overturned runs, low and high.
    undecided
        Share of undecided runs, low and high.
    rank
        Rank correlation with the largest displacement, fallen columns on top, among runs of the same column, motion and
        point of the grid.
    """

    name: str
    values: tuple[float, float]
    displacement: tuple[float, float]
    overturned: tuple[float, float]
    undecided: tuple[float, float]
    rank: float


def influences(results: Results) -> list[Influence]:
    """Return the effect of each random parameter, the strongest first.

    A seed has none, for it only labels motions. The list is empty if all runs end alike.
    """
    check_type("results", results, Results)
    with needing("studies", "scipy"):
        from scipy.stats import rankdata
    valid = made(results)
    largest, fell, unknown = results.largest[valid], results.overturned[valid], results.undecided[valid]
    fixed = {"column", "motion", *results.study["grid"]}
    found: list[Influence] = []
    alike = _runs_alike(results, valid)

    def ranks(values: FloatArray) -> FloatArray:
        """Return the ranks among comparable runs, from -1 to 1."""
        found = np.zeros(len(values))
        for runs in alike:
            found[runs] = (2.0 * rankdata(values[runs]) - 1.0) / len(runs) - 1.0
        return found

    # medians and shares at both ends of each parameter
    by_size = ranks(largest)
    if not valid.any() or np.ptp(by_size) == 0.0:  # none was made, or all fell
        return found
    for name in results.head["varied"]:
        values = results[name][valid]
        if name in (*fixed, *SEEDS) or np.ptp(values) == 0.0:
            continue
        ends = np.quantile(values, [TAIL, 1.0 - TAIL])
        low, high = values <= ends[0], values >= ends[1]
        found.append(
            Influence(
                name,
                (float(np.median(values[low])), float(np.median(values[high]))),
                (float(np.median(largest[low])), float(np.median(largest[high]))),
                (float(np.mean(fell[low])), float(np.mean(fell[high]))),
                (float(np.mean(unknown[low])), float(np.mean(unknown[high]))),
                float(np.corrcoef(ranks(values), by_size)[0, 1]),
            )
        )
    return sorted(found, key=lambda item: -abs(item.rank))


def _runs_alike(results: Results, valid: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Return the indices, among the valid runs, of each group that differs only in the random parameters."""
    keys = np.column_stack([results[name][valid] for name in ("column", "motion", *results.study["grid"])])
    _, group = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(group.ravel(), kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group.ravel()[order])) + 1)
