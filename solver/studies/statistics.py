"""Statistics of the runs of a study: curves over intensity, probabilities with bounds, influence of parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.errors import InputError, needing
from ..common.notebook import Shown, counted
from ..models.protocol import FloatArray
from ..models.structure.numbers import unit_in_space
from ..models.uncertainty import CONFIDENCE, PERCENTILES, share_bounds
from .confidence import likelihood_ends
from .motions import OF_MOTION, WHOLE
from .results import Results

# of weights of the runs and a first guess: median and deviation
Fit = Callable[[FloatArray, tuple[float, float] | None], tuple[float, float]]

Limit = float | Literal["hit"] | None  # m, largest displacement beyond which a run failed; None: that overturned
LEAST_GAP = "least_gap"  # of neighbours, where a study keeps it: below 0 m they have hit

RESAMPLED = 200  # times, for confidence
GROUPS = 1000  # of neighbouring intensities, if there are more different ones: the likelihood uses their middles
BINS = 12
LEAST_DEVIATION, MOST_DEVIATION = 0.01, 5.0
SEEDS = tuple(f"{OF_MOTION}{key}" for key in WHOLE)  # labels, not quantities
TAIL = 0.16  # of the runs, at either end of a parameter


@dataclass(frozen=True, repr=False)
class Bins(Shown):
    """Shares of failures between intensities: `edges` (b + 1,), `runs` (b,), `failed` (b,), `middle` (b,) of the runs.

    undecided (b,): runs that have not failed and may yet overturn. low, high (b,): bounds of Clopper and Pearson
    at 95 % confidence.
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
        """(b,)"""
        return np.asarray(self.failed / self.runs)


@dataclass(frozen=True, repr=False)
class Fragility(Shown):
    """A lognormal probability of failure over an intensity: median, and deviation of the logarithm.

    median_bounds, deviation_bounds: at 95 % confidence, the wider of those by the bootstrap and, of failures, by the
    likelihood. curves (resampled, 2): the two of each sample of the bootstrap. ends (k, 2): the two of the curves at
    the ends of the likelihood region. bins: the data themselves. name: of the intensity. how: what was fitted.
    undecided: of the runs, those that have not failed and may yet overturn; the curve takes them as standing.
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

    def _facts(self) -> tuple[str, ...]:
        parts = ("median", self.median, self.median_bounds), ("deviation", self.deviation, self.deviation_bounds)
        of_the_curve = (f"{name} {value:.3g} ({low:.3g} to {high:.3g})" for name, value, (low, high) in parts)
        return (
            f"over {self.name}",
            *of_the_curve,
            f"{self.failed} of {self.runs} runs failed, {self.undecided} undecided",
        )

    def probability(self, intensity: FloatArray) -> FloatArray:
        """Of failure at intensities of any shape."""
        return lognormal(np.asarray(intensity, dtype=np.float64), self.median, self.deviation)

    def band(self, intensity: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Within which the curve lies at each intensity (k,), at 95 % confidence."""
        curves = np.array([lognormal(intensity, median, deviation) for median, deviation in self.curves])
        low, high = np.percentile(curves, _ends(), axis=0)
        outer = np.array([low, high, *(lognormal(intensity, median, deviation) for median, deviation in self.ends)])
        return np.min(outer, axis=0), np.max(outer, axis=0)


def lognormal(intensity: FloatArray, median: float, deviation: float) -> FloatArray:
    """The lognormal distribution function."""
    with needing("studies", "scipy"):
        from scipy.special import ndtr
    with np.errstate(divide="ignore"):
        return np.asarray(ndtr((np.log(intensity) - math.log(median)) / deviation))


def failed_of(results: Results, limit: Limit = None) -> NDArray[np.bool_]:
    """(runs,) Whether the column fell or its largest displacement exceeded `limit`, m; "hit": some neighbours hit."""
    if limit == "hit":
        return np.asarray(np.any(results[LEAST_GAP] < 0.0, axis=1))
    return results.overturned if limit is None else np.asarray(results.largest > limit)


class Failure(NamedTuple):
    """A failure of a study that has a probability: limit as of `fit_fragility`; chosen (runs,): of these, None: all."""

    name: str
    limit: Limit
    chosen: NDArray[np.bool_] | None = None


def failures_of(results: Results) -> Iterator[Failure]:
    """By displacement, by overturning, and where neighbours meet by a hit, for each value of what the grid varies."""
    for limit in results.study["limits"]:
        yield Failure(f"{limit:g} m", limit)
    yield Failure("overturned", None)
    if LEAST_GAP in results:
        name = varied_beside(results)
        if name is None:
            yield Failure("hit", "hit")
        else:
            key, unit = name.rpartition(".")[2], unit_in_space(name)
            for value in results.study["grid"][name]:
                yield Failure(f"hit, {key} {value:g}{unit and f' {unit}'}", "hit", results[name] == value)


def varied_beside(results: Results) -> str | None:
    """What the grid varies beside the intensity, if that is one number."""
    names = [name for name in results.study["grid"] if name != "intensity"]
    return names[0] if len(names) == 1 else None


def made(results: Results) -> NDArray[np.bool_]:
    """(runs,) Whether the solver made the run to its end."""
    return np.asarray(~np.isnan(results.largest))


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
    """The lognormal fragility of largest likelihood over an intensity, a column of the results (None: the study's).

    Failure is overturning, or a largest displacement above `limit`, m. method "failures": each run tells whether it
    failed. "demand": the logarithm of the largest displacement is linear in that of the intensity, with a normal
    scatter; what overturned is censored, known only to be beyond the limit. It needs a limit and fewer failures.
    Confidence: by resampling, 200 times, the samples of the random parameters together with the motion, each with all
    its intensities; for failures also by the likelihood of all runs as trials (confidence.py), which has a width where
    few levels have both outcomes or there is one motion alone; the wider bounds are given. chosen: (runs,) mask of the
    runs used. Raises InputError if the runs do not determine the curve: none or all failed, or all stand below one
    intensity and all fail above it, so that any deviation fits.
    """
    name = intensity or intensity_name(results)
    valid = made(results) & (results[name] > 0.0)
    if chosen is not None:
        valid &= chosen
    im, failed = results[name][valid], failed_of(results, limit)[valid]
    undecided = results.undecided[valid] & ~failed
    clusters = np.unique(_clusters(results)[valid], return_inverse=True)[1]
    if not 0 < np.sum(failed) < len(failed):
        raise InputError(f"{name}: {np.sum(failed)} of {len(failed)} runs failed: a fragility needs some of both")
    if method == "failures":
        _refuse_separated(name, im, failed)
        fit, levels = _of_failures(im, failed)
        how = said_of(limit)
    elif method == "demand":
        if limit is None or limit == "hit":
            raise InputError("limit: must be given for the method demand, in m")
        if clusters.max() == 0:
            raise InputError("method = 'demand': needs several motions or samples, whose resampling gives its bounds")
        fit = _of_demand(im, results.largest[valid], limit)
        how = f"moved by more than {limit:g} m, by the demand of those that stand"
    else:
        raise InputError(f"method = {method!r}: must be failures or demand")
    best = fit(np.ones(len(im)), None)
    rng = np.random.default_rng(results.study["seed"])
    count = int(clusters.max()) + 1

    def again() -> tuple[float, float]:
        times = np.bincount(rng.integers(count, size=count), minlength=count)
        return fit(times[clusters].astype(np.float64), best)

    curves = np.array([again() for _ in range(resampled)])
    bounds = np.percentile(curves, _ends(), axis=0)
    ends = np.empty((0, 2))
    if method == "failures":
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
    )


def _refuse_separated(name: str, intensity: FloatArray, failed: NDArray[np.bool_]) -> None:
    """Raise InputError if all runs stand below one intensity and all fail above it, with where the median lies."""
    low, high = float(np.max(intensity[~failed])), float(np.min(intensity[failed]))
    if low < high:
        raise InputError(
            f"{name}: all runs up to {low:.4g} stand and all from {high:.4g} on fail: the median lies between "
            f"{low:.4g} and {high:.4g}, its bounds and the deviation need more levels there"
        )


def said_of(limit: Limit) -> str:
    """A failure in words."""
    words = {None: "overturned", "hit": "neighbours that hit"}
    return words[limit] if limit is None or limit == "hit" else f"overturned or moved by more than {limit:g} m"


def said_undecided(count: int) -> str:
    """Return what the undecided runs of a study are, "" without any."""
    if not count:
        return ""
    runs, they = ("run", "it was") if count == 1 else ("runs", "they were")
    return f"{count} undecided {runs} neither fell nor came to rest while {they} followed"


def intensity_name(results: Results) -> str:
    """The measure of the study, PGA if it has none."""
    measure = results.study["intensity"]
    return "pga" if measure is None else str(measure["measure"])


def binned(
    intensity: FloatArray, failed: NDArray[np.bool_], bins: int = BINS, undecided: NDArray[np.bool_] | None = None
) -> Bins:
    """Shares of failures by intensity: a bin for each of few different intensities; of many, bins of equal counts."""
    levels = np.unique(intensity)
    if len(levels) <= 2 * bins:
        between = 0.5 * (levels[1:] + levels[:-1])
        edges = np.concatenate([levels[:1], between, levels[-1:]])
    else:
        edges = np.unique(np.quantile(intensity, np.linspace(0.0, 1.0, bins + 1)))
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
    """`share_bounds` of many shares."""
    found = [share_bounds(one, of) for one, of in zip(count.tolist(), size.tolist(), strict=True)]
    low, high = np.array(found).reshape(-1, 2).T
    return low, high


def _of_failures(
    intensity: FloatArray, failed: NDArray[np.bool_]
) -> tuple[Fit, tuple[FloatArray, FloatArray, FloatArray]]:
    """Return the fit of largest likelihood of the failures, and the levels: log im, runs and failures, (levels,) each.

    Probability of a failure: ndtr((log im - log median) / deviation).
    """
    with needing("studies", "scipy"):
        from scipy.special import log_ndtr
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
    """Maximum likelihood of log u = a + b log im + s e; displacements beyond the limit are censored there."""
    with needing("studies", "scipy"):
        from scipy.optimize import minimize
        from scipy.special import log_ndtr
    x, beyond = np.log(intensity), largest > limit
    y = np.log(np.where(beyond, limit, largest))

    def fit(weights: FloatArray, _: tuple[float, float] | None) -> tuple[float, float]:
        def loss(p: FloatArray) -> float:
            z = (y - p[0] - p[1] * x) / math.exp(p[2])
            seen = -0.5 * z * z - p[2]
            return -float(np.sum(weights * np.where(beyond, log_ndtr(-z), seen)))

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


def _ends() -> list[float]:
    return [50.0 * (1.0 - CONFIDENCE), 50.0 * (1.0 + CONFIDENCE)]


def _clusters(results: Results) -> NDArray[np.int64]:
    """(runs,) Number of the group of runs drawn together: a motion with one sample of the random parameters."""
    samples = results.study["samples"]
    return np.asarray(results["motion"] * samples + results["run"] % samples)


@dataclass(frozen=True, repr=False)
class Curves(Shown):
    """Percentiles of the largest displacement over intensity, m (3, levels): 16, 50, 84 %; infinite where they fell.

    overturned, undecided (levels,): shares of the runs at each level. each: one curve a motion and sample, (curves,
    levels).
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
    """The curves of an incremental dynamic analysis. Raises InputError unless the grid has intensities."""
    if "intensity" not in results.study["grid"]:
        raise InputError("grid.intensity: missing, the curves need levels of intensity")
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
    """16, 50 and 84 % points over the first axis, NaN left out, infinite values included; between two the lower one."""
    ordered = np.sort(values, axis=0)
    last = np.sum(~np.isnan(ordered), axis=0) - 1
    places = [np.maximum(np.floor(0.01 * point * last + 0.5).astype(np.int64), 0) for point in PERCENTILES]
    return np.array([np.take_along_axis(ordered, place[None], axis=0)[0] for place in places])


@dataclass(frozen=True)
class Influence:
    """Effect of a random parameter: median of the largest displacement, m, and shares of runs, where it is low, high.

    That is over the 16 % of the runs with its lowest and its highest values. rank: its rank correlation with the
    largest displacement, fallen columns on top, among runs of the same column, motion and point of the grid.
    """

    name: str
    values: tuple[float, float]
    displacement: tuple[float, float]
    overturned: tuple[float, float]
    undecided: tuple[float, float]
    rank: float


def influences(results: Results) -> list[Influence]:
    """Return the effect of each random parameter, the strongest first; none of a seed, which only labels motions."""
    with needing("studies", "scipy"):
        from scipy.stats import rankdata
    valid = made(results)
    largest, fell, unknown = results.largest[valid], results.overturned[valid], results.undecided[valid]
    fixed = {"column", "motion", *results.study["grid"]}
    found: list[Influence] = []
    alike = _runs_alike(results, valid)

    def ranks(values: FloatArray) -> FloatArray:
        """Ranks among comparable runs, from -1 to 1."""
        found = np.zeros(len(values))
        for runs in alike:
            found[runs] = (2.0 * rankdata(values[runs]) - 1.0) / len(runs) - 1.0
        return found

    by_size = ranks(largest)
    if np.ptp(by_size) == 0.0:  # all fell
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
    """Places among the valid runs of those that differ only in the random parameters."""
    keys = np.column_stack([results[name][valid] for name in ("column", "motion", *results.study["grid"])])
    _, group = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(group.ravel(), kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group.ravel()[order])) + 1)
