"""Curves and probabilities from runs: found again where they are known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats

from solver import InputError
from solver.studies import Results, fit_fragility, ida_curves, influences
from solver.studies.statistics import binned, bounds_of, made, percentiles, undecided_text


def made_up(
    largest: Any, intensity: Any, kind: str = "fragility", samples: int = 0, grid: Any = None, beside: Any = None
) -> Results:
    """Return the results as if they had been run: infinite displacements are columns that fell."""
    beside = beside or {}
    study = {
        "name": "made up",
        "kind": kind,
        "seed": 1,
        "samples": samples or len(largest),
        "sampling": "random",
        "intensity": {"measure": "pga"},
        "keep": ["peak_ux", "verdict"],
        "limits": [],
        "grid": grid or {},
        "random": {name: {"distribution": "uniform", "each": False} for name in beside},
        "columns": [{"name": "block", "block": [{"height": 3.0, "width": 1.0}]}],
        "motions": [{"name": "pulse"}],
    }
    head = {
        "study": study,
        "varied": ["column", "motion", "intensity", *beside],
        "measured": ["pga", "pgv"],
        "blocks": 1,
        "runs": len(largest),
        "fingerprint": "",
        "versions": {},
    }
    rows = []
    for k, (u, im) in enumerate(zip(largest, intensity, strict=True)):
        fell = math.isinf(u)
        outputs = {"peak_ux": [2.0 if fell else u], "verdict": "overturned" if fell else "standing"}
        rows.append([k, [0.0, 0.0, im, *(values[k] for values in beside.values())], [im, im], outputs, ""])
    return Results(head, rows)


@pytest.fixture(scope="module")
def known() -> Results:
    """Return 20,000 runs of a column of capacity 0.5 g, deviation 0.4: what moves by more than 1 m falls."""
    rng = np.random.default_rng(5)
    im = rng.uniform(0.05, 2.0, 20000)
    demand = (im / 0.5) ** 1.25 * np.exp(0.5 * rng.standard_normal(len(im)))
    return made_up(np.where(demand > 1.0, math.inf, demand), im)


def test_a_known_fragility_is_found(known: Results) -> None:
    found = fit_fragility(known)
    assert found.median == pytest.approx(0.5, rel=0.02)  # measured 0.2 %; the bounds are 1.3 % away
    assert found.deviation == pytest.approx(0.4, rel=0.05)  # 0.5 / 1.25
    assert found.median_bounds[0] < 0.5 < found.median_bounds[1]
    assert found.deviation_bounds[0] < 0.4 < found.deviation_bounds[1]
    assert (found.runs, found.name) == (20000, "pga")
    # scipy's own search for the same likelihood, run by run
    fell, x = known.overturned, np.log(known["pga"])

    def loss(p: Any) -> float:
        z = (x - p[0]) / math.exp(p[1])
        return -float(np.sum(np.where(fell, stats.norm.logcdf(z), stats.norm.logsf(z))))

    from scipy.optimize import minimize

    best = minimize(loss, [-0.6, -1.0], method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-8}).x
    # the grouping into 1000 neighbours: measured 2e-6
    assert (math.log(found.median), math.log(found.deviation)) == pytest.approx(best, abs=1e-4)


def test_fallen_columns_are_censored(known: Results) -> None:
    """Fit the displacements of those that stand, at a limit that few of them reach; simple regression would be
    wrong.
    """
    found = fit_fragility(known, limit=0.8, method="demand", resampled=10)
    wanted = 0.5 * 0.8 ** (1.0 / 1.25)
    assert found.median == pytest.approx(wanted, rel=0.02)
    assert found.deviation == pytest.approx(0.4, rel=0.05)
    by_failures = fit_fragility(known, limit=0.8, resampled=10)
    assert by_failures.median == pytest.approx(found.median, rel=0.02)
    # the bootstrap knows that demands tell more than mere failures
    assert np.ptp(found.median_bounds) < np.ptp(by_failures.median_bounds)


@pytest.mark.long
def test_bounds_hold_as_often_as_they_say() -> None:
    """Check that of 60 small studies the truth lies within the bounds of some 57."""
    rng = np.random.default_rng(11)
    hits = 0
    for _ in range(60):
        im = rng.uniform(0.1, 1.5, 150)
        fell = rng.random(150) < stats.norm.cdf(np.log(im / 0.5) / 0.4)
        found = fit_fragility(made_up(np.where(fell, math.inf, 0.1), im), resampled=100)
        hits += found.median_bounds[0] < 0.5 < found.median_bounds[1]
    assert hits >= 50  # fewer by chance: 1 in 1000; measured 56


def test_the_seed_gives_the_same_bounds(known: Results) -> None:
    one, other = (fit_fragility(known, resampled=10) for _ in range(2))
    assert np.array_equal(one.curves, other.curves)


def test_runs_that_do_not_tell_are_refused() -> None:
    with pytest.raises(InputError, match="0 of 10 runs failed"):
        fit_fragility(made_up(np.full(10, 0.1), np.linspace(0.1, 1.0, 10)))


@pytest.mark.parametrize(
    ("levels", "fell", "where"),
    [
        ([0.2, 0.2, 0.65, 1.0], [0, 0, 1, 1], "between 0.2 and 0.65"),
        ([0.4, 0.3, 0.41], [0, 0, 1], "between 0.4 and 0.41"),
    ],
)
def test_outcomes_that_are_separated_are_refused_with_the_range_of_the_median(
    levels: list[float], fell: list[int], where: str
) -> None:
    """Check that any small deviation fits them, so that bounds would have no width."""
    results = made_up(np.where(np.array(fell) > 0, math.inf, 0.1), np.array(levels))
    with pytest.raises(InputError, match=f"the median lies {where}"):
        fit_fragility(results)


@pytest.mark.parametrize(("levels", "fell"), [((0.2, 0.6), (0, 10)), ((0.3, 0.5, 0.7), (1, 5, 12))])
def test_bounds_have_the_width_of_the_likelihood(levels: tuple[float, ...], fell: tuple[int, ...]) -> None:
    """Compare with all pairs of a fine grid: those whose likelihood is at least exp(-1.92) of the largest."""
    im = np.repeat(levels, 12)
    failed = np.concatenate([np.arange(12) < count for count in fell])
    found = fit_fragility(made_up(np.where(failed, math.inf, 0.1), im, samples=1))  # one motion: nothing to resample
    assert np.ptp(found.curves[:, 0]) == 0.0
    median = np.exp(np.arange(math.log(0.1), math.log(1.2), 0.002))[:, None, None]
    deviation = np.exp(np.arange(math.log(0.01), math.log(5.0), 0.01))[:, None]
    share = stats.norm.logcdf(np.log(np.array(levels) / median) / deviation)
    rest = stats.norm.logsf(np.log(np.array(levels) / median) / deviation)
    likelihood = np.sum(np.array(fell) * share + (12 - np.array(fell)) * rest, axis=2)
    region = likelihood >= np.max(likelihood) - 0.5 * stats.chi2.ppf(0.95, 1)
    medians, deviations = median.ravel()[region.any(axis=1)], deviation.ravel()[region.any(axis=0)]
    assert found.median_bounds == pytest.approx((medians[0], medians[-1]), rel=5e-3)
    assert found.deviation_bounds == pytest.approx((deviations[0], deviations[-1]), rel=2e-2)
    low, high = found.band(np.array([0.4]))
    assert low[0] < found.probability(np.array([0.4]))[0] < high[0]


@pytest.mark.long
def test_bounds_of_few_levels_hold_as_often_as_they_say() -> None:
    """Check that of 100 studies of 12 samples at four levels the truth lies within the bounds of some 95: measured 94
    to 100.
    """
    rng = np.random.default_rng(7)
    for median, deviation in ((0.45, 0.3), (0.6, 0.15)):
        hits, made = 0, 0
        for _ in range(100):
            im = np.repeat([0.2, 0.4, 0.6, 0.8], 12)
            fell = rng.random(48) < stats.norm.cdf(np.log(im / median) / deviation)
            try:
                found = fit_fragility(made_up(np.where(fell, math.inf, 0.1), im), resampled=20)
            except InputError:  # separated
                continue
            made += 1
            hits += found.median_bounds[0] <= median <= found.median_bounds[1]
        assert made > 80
        assert hits >= 0.88 * made


def test_one_motion_has_no_bounds_by_demand() -> None:
    results = made_up([0.1, 0.2, 0.4, math.inf], [0.1, 0.2, 0.3, 0.4], samples=1)
    with pytest.raises(InputError, match="needs several motions or samples"):
        fit_fragility(results, limit=0.3, method="demand")


def test_bins_hold_all_runs(known: Results) -> None:
    found = binned(known["pga"], known.overturned)
    assert np.sum(found.runs) == 20000
    assert np.sum(found.failed) == np.sum(known.overturned)
    inside = stats.norm.cdf(np.log(found.middle / 0.5) / 0.4)
    # a bin's share is that of its middle but for the curve's bend: 12 bounds of 95 %, one or two may fail
    assert np.sum((found.low <= inside) & (inside <= found.high)) >= 10
    levels = binned(np.repeat([0.1, 0.2, 0.4], 5), np.tile([True, False, True, False, False], 3))
    assert levels.middle == pytest.approx([0.1, 0.2, 0.4])
    assert (levels.runs.tolist(), levels.failed.tolist()) == ([5, 5, 5], [2, 2, 2])
    # intensities that differ by rounding are one level, also the largest
    scaled = np.repeat([0.2, 0.5, 0.9], 4) * np.tile([1.0, 1.0 + 2e-16, 1.0 - 2e-16, 1.0], 3)
    rounded = binned(scaled, np.arange(12) > 6)
    assert (rounded.runs.tolist(), rounded.failed.tolist()) == ([4, 4, 4], [0, 1, 4])


def test_binomial_bounds_are_quantiles_of_the_beta_distribution() -> None:
    count, size = np.array([0, 3, 20, 20, 30000]), np.array([20, 20, 20, 40, 100000])
    low, high = bounds_of(count, size)
    assert low[1:] == pytest.approx(stats.beta.ppf(0.025, count, size - count + 1)[1:], abs=1e-9)
    assert high[[0, 1, 3, 4]] == pytest.approx(stats.beta.ppf(0.975, count + 1, size - count)[[0, 1, 3, 4]], abs=1e-9)
    assert (low[0], high[2]) == (0.0, 1.0)


def test_curves_of_an_incremental_dynamic_analysis() -> None:
    """Sample k moves by (k + 1) im and falls where that comes to more than 1.5."""
    levels, samples = [0.1, 0.2, 0.4], 5
    im = np.repeat(levels, samples)
    u = im * np.tile(np.arange(1, samples + 1), 3)
    results = made_up(np.where(u > 1.5, math.inf, u), im, "ida", samples, {"intensity": levels})
    curves = ida_curves(results)
    np.testing.assert_allclose(curves.percentiles[1], [0.3, 0.6, 1.2])
    np.testing.assert_allclose(curves.percentiles[2], [0.4, 0.8, math.inf])
    assert curves.overturned.tolist() == [0.0, 0.0, 0.4]
    assert curves.each.shape == (5, 3)


def test_runs_that_are_not_made_yet_are_in_no_share() -> None:
    im = np.repeat([0.1, 0.2], 4)
    u = np.array([0.1, 0.2, math.nan, math.nan, 0.3, math.inf, math.inf, math.nan])
    results = made_up(u, im, "ida", 4, {"intensity": [0.1, 0.2]})
    assert ida_curves(results).overturned == pytest.approx([0.0, 2.0 / 3.0])


def test_percentiles_leave_out_what_was_not_made() -> None:
    values = np.array([[1.0, math.nan], [math.inf, math.nan], [2.0, 3.0], [math.nan, 4.0]])
    np.testing.assert_array_equal(percentiles(values), [[1.0, 3.0], [2.0, 4.0], [math.inf, 4.0]])


def test_the_parameter_that_matters_comes_first() -> None:
    rng = np.random.default_rng(2)
    beside = {name: rng.random(2000) for name in ("joint.damping", "joint.stiffness", "block.width")}
    u = np.exp(-3.0 * beside["joint.stiffness"] + 1.0 * beside["block.width"] + 0.1 * rng.standard_normal(2000))
    found = influences(made_up(u, np.full(2000, 0.3), "montecarlo", 2000, None, beside))
    assert [item.name for item in found] == ["joint.stiffness", "block.width", "joint.damping"]
    assert found[0].rank < -0.8
    low, high = found[0].displacement
    # medians where the stiffness is 0.08 and 0.92 in the middle of its tails; measured 12.1
    assert low / high == pytest.approx(math.exp(3.0 * 0.84), rel=0.15)


def test_what_the_grid_does_is_in_no_rank() -> None:
    """Check a stiffness that orders the runs at every level, though the level moves them far more."""
    levels, samples = [0.1, 0.2, 0.4], 50
    stiffness = np.tile(np.random.default_rng(3).random(samples), 3)
    u = np.repeat([1e-3, 1e-1, 1e1], samples) * (1.0 + stiffness)
    results = made_up(u, np.repeat(levels, samples), "ida", samples, {"intensity": levels}, {"stiffness": stiffness})
    assert [item.rank for item in influences(results)] == [pytest.approx(1.0)]


def test_a_seed_has_no_rank() -> None:
    """Check that a seed labels a motion: a displacement that happens to grow with it says nothing."""
    seed, stiffness = np.arange(60.0), np.linspace(1.0, 2.0, 60)[::-1]
    results = made_up(
        0.1 + 0.01 * seed, np.full(60, 0.3), "montecarlo", beside={"motion.seed": seed, "joint.stiffness": stiffness}
    )
    assert [item.name for item in influences(results)] == ["joint.stiffness"]


def test_undecided_runs_are_said_in_plain_words() -> None:
    assert undecided_text(0) == ""
    assert undecided_text(1) == "1 undecided run neither fell nor came to rest while it was followed"
    assert undecided_text(3).startswith("3 undecided runs neither fell nor came to rest")


def test_runs_without_gaps_are_in_no_share_of_hits() -> None:
    """Check runs that fell under their weight alone: whether their neighbours hit is not known."""
    results = made_up([0.1, 0.2, math.inf, 0.3], np.full(4, 0.3))
    results.columns["least_gap"] = np.array([[0.1, -0.1], [0.2, 0.3], [math.nan, math.nan], [0.1, math.nan]])
    assert made(results).tolist() == [True] * 4
    assert made(results, "hit").tolist() == [True, True, False, True]
