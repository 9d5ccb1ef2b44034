"""Rates of failure: against closed forms and independent integrals."""

from __future__ import annotations

import csv
import math
import warnings
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from solver import InputError, InputWarning
from solver.commands.command_line import main
from solver.studies import Hazard, Measure, Study, fit_fragility, risk, run_study
from solver.studies.risk import rates_between, risk_text
from solver.studies.statistics import Fragility, binned

TABLE = ([0.05, 0.1, 0.2, 0.4, 0.8], [0.02, 0.008, 0.002, 3e-4, 2e-5])


def curve(median: float, deviation: float, curves: Any = None, ends: Any = None, measure: str = "pga") -> Fragility:
    """Return a fragility that is known, with given samples of the bootstrap and ends of the likelihood region."""
    every = np.array([[median, deviation]] if curves is None else curves, dtype=np.float64)
    data = binned(np.array([0.1, 0.2, 0.4]), np.array([False, True, True]))
    return Fragility(
        name=measure,
        median=median,
        deviation=deviation,
        median_bounds=(median, median),
        deviation_bounds=(deviation, deviation),
        curves=every,
        ends=np.empty((0, 2)) if ends is None else np.array(ends, dtype=np.float64),
        bins=data,
        runs=3,
        failed=2,
        undecided=0,
        how="overturned",
        measure=Measure(measure),
    )


def rate_of_power_law(k: float, median: float, deviation: float) -> float:
    """Return the rate under a power law through 0.15 at 475 years."""
    return 0.15**k / 475.0 * median**-k * math.exp(0.5 * (k * deviation) ** 2)


@pytest.mark.parametrize("k", [0.5, 2.5, 7.0])
@pytest.mark.parametrize("deviation", [0.01, 0.4, 1.5])
@pytest.mark.parametrize("median", [0.02, 0.5, 30.0])
def test_power_law_has_its_closed_form(k: float, deviation: float, median: float) -> None:
    found = risk(curve(median, deviation), Hazard.power_law("pga", k, 0.15, 475.0))
    wanted = rate_of_power_law(k, median, deviation)
    assert found.rate == pytest.approx(wanted, rel=1e-9)
    assert found.rate_bounds == pytest.approx((wanted, wanted), rel=1e-9)
    assert found.probability == pytest.approx(-math.expm1(-50.0 * wanted), rel=1e-9)
    # points of the same law change nothing
    s = np.geomspace(0.01, 10.0, 400)
    table = Hazard.from_table("pga", s, (0.15 / s) ** k / 475.0)
    assert risk(curve(median, deviation), table).rate == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("threshold", [0.03, 0.1, 0.15, 0.33, 1.2])
def test_step_has_the_hazard_of_its_threshold(threshold: float) -> None:
    hazard = Hazard.from_table("pga", *TABLE)
    wanted = float(hazard.exceeded(threshold))
    assert risk(curve(threshold, 1e-9), hazard).rate == pytest.approx(wanted, rel=1e-7)  # one-sided slopes at points
    x, h = np.log(TABLE)
    if 0.05 <= threshold <= 0.8:
        assert wanted == pytest.approx(math.exp(np.interp(math.log(threshold), x, h)), rel=1e-12)


def test_whole_and_shares_are_the_integral() -> None:
    """Compare with the adaptive quadrature of -dH/ds P, range by range."""
    hazard, fragility = Hazard.from_table("pga", *TABLE), curve(0.45, 0.5)
    found = risk(fragility, hazard)

    def part(low: float, high: float) -> float:
        points = [math.log(s) for s in TABLE[0] if low < s < high]
        ends = [max(math.log(low), -14.0) if low else -14.0, *points, min(math.log(high), 12.0)]
        return sum(
            quad(lambda x: found.density(np.array([math.exp(x)]))[0], a, b, epsabs=0.0, epsrel=1e-11, limit=500)[0]
            for a, b in pairwise(ends)
        )

    # the density is -dH/dx P
    s = np.array([0.07, 0.3, 2.0])
    slope = (hazard.exceeded(s * math.exp(-1e-6)) - hazard.exceeded(s * math.exp(1e-6))) / 2e-6
    assert found.density(s) == pytest.approx(slope * norm.cdf(np.log(s / 0.45) / 0.5), rel=1e-8)
    assert found.rate == pytest.approx(part(0.0, math.inf), rel=1e-9)
    assert len(found.shares) > 4
    assert np.sum(found.shares) == pytest.approx(1.0, rel=1e-12)
    for low, high, share in zip(found.edges[:-1], found.edges[1:], found.shares, strict=True):
        assert share == pytest.approx(part(low, high) / found.rate, rel=1e-8)
    below, above = found.beyond
    assert below == pytest.approx(part(0.0, 0.05) / found.rate, rel=1e-7)
    assert above == pytest.approx(part(0.8, math.inf) / found.rate, rel=1e-8)


def test_tables_of_a_smooth_hazard_converge() -> None:
    """Check the second order, with ln H = -8 - 3 ln s - 0.4 (ln s)^2, whose rate is a Gaussian integral."""
    median, b, k1, k2 = 0.5, 0.4, 3.0, 0.4
    m, p = math.log(median), 1.0 / (1.0 + 2.0 * k2 * b * b)
    # the mean of H over the lognormal capacity
    wanted = math.exp(-8.0 + 0.5 * p * (m / b - k1 * b) ** 2 - 0.5 * (m / b) ** 2) * math.sqrt(p)
    errors = []
    for points in (11, 21, 41, 81):
        s = np.geomspace(0.03, 30.0, points)
        hazard = Hazard.from_table("pga", s, np.exp(-8.0 - k1 * np.log(s) - k2 * np.log(s) ** 2))
        errors.append(abs(risk(curve(median, b), hazard).rate / wanted - 1.0))
    assert errors[-1] < 1e-3
    falls = [before / after for before, after in pairwise(errors)]
    assert falls == pytest.approx([4.0] * 3, rel=0.3)


def test_bounds_are_those_of_the_fragility() -> None:
    medians = np.linspace(0.4, 0.6, 1001)
    curves = np.column_stack([medians, np.full(1001, 0.3)])
    hazard = Hazard.power_law("pga", 2.0, 0.15, 475.0)
    low, high = risk(curve(0.5, 0.3, curves), hazard).rate_bounds
    # 2.5 % of the medians are below 0.405, and above 0.595
    assert (low, high) == pytest.approx([rate_of_power_law(2.0, median, 0.3) for median in (0.595, 0.405)], rel=2e-3)
    wider = risk(curve(0.5, 0.3, curves, [[0.2, 0.3], [0.5, 0.3]]), hazard)
    assert wider.rate_bounds == pytest.approx((low, rate_of_power_law(2.0, 0.2, 0.3)), rel=1e-9)
    assert wider.probability_bounds[0] < wider.probability < wider.probability_bounds[1]


@pytest.mark.parametrize(("measure", "factor"), [("pga", 9.80665), ("sa(0.5)", 980.665), ("pgv", 100.0)])
def test_a_hazard_in_other_units_is_warned_of(measure: str, factor: float) -> None:
    intensity, rate = np.array([0.1, 0.25, 0.5]), [1e-2, 2.1e-3, 4e-4]
    with pytest.warns(InputWarning, match=rf"^hazard: .* should be .* at most; {measure[:2]}.* is in "):
        Hazard.from_table(measure, factor * intensity, rate)
    with pytest.warns(InputWarning, match="^hazard: once in 1,000 years: reaches"):
        Hazard.power_law(measure, 2.5, 0.25 * factor, 475.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Hazard.from_table(measure, intensity, rate)
        Hazard.power_law(measure, 2.5, 0.25, 475.0)


def test_a_bound_above_the_rates_of_a_table_is_none() -> None:
    """Check the bound by an end over the extrapolated hazard: 2.48 per year, 124 times the rate of its first point."""
    ends = [[0.4, 0.3], [0.5, 3.0]]
    bounded, wide = (risk(curve(0.5, 0.3, ends=some), Hazard.from_table("pga", *TABLE)) for some in (ends[:1], ends))
    assert bounded.rate_bounds[1] < TABLE[1][0]  # measured: 4.0e-4
    assert "not bounded" not in risk_text("overturned", bounded)
    assert wide.rate_bounds == (bounded.rate_bounds[0], math.inf)
    assert wide.probability_bounds[1] == 1.0
    assert f"({wide.rate_bounds[0]:.3g} or more, not bounded above), " in str(wide)
    said = (
        "not bounded above: the runs allow a rate above that of the hazard's least intensity, 0.02 per year; more runs"
    )
    assert said in risk_text("overturned", wide)
    # one point of a power law sets no limit
    law = risk(curve(0.01, 0.3), Hazard.power_law("pga", 2.0, 0.15, 475.0))
    assert 1.0 / 475.0 < law.rate_bounds[1] < math.inf


def test_wide_curves_and_close_points_give_numbers() -> None:
    s = np.array([0.1, 0.1 * (1.0 + 1e-9), 1.0])
    hazard = Hazard.from_table("pga", s, [0.02, 0.01, 1e-5])
    rates = rates_between(hazard, np.array([0.0, 0.1, math.inf]), np.array([[0.5, 0.01], [0.5, 5.0], [1e-3, 5.0]]))
    assert not np.any(np.isnan(rates))
    assert np.all(rates[:, 1] < 0.02)
    with pytest.raises(InputError, match="rate of inf per year"):
        risk(curve(0.5, 5.0), hazard)


def test_a_hazard_of_equal_rates_has_no_slope_there() -> None:
    hazard = Hazard.from_table("pga", [0.05, 0.1, 0.2], [0.05, 0.05, 0.01])
    assert str(hazard).endswith("slopes 0 below and 2.32 above")
    assert not np.any(np.signbit(hazard.slopes))


def test_tables_are_read(tmp_path: Path) -> None:
    rates, periods, unnamed = (tmp_path / f"{name}.csv" for name in ("rates", "periods", "unnamed"))
    rates.write_text("PGA (g),annual rate\n" + "".join(f"{s},{h}\n" for s, h in zip(*TABLE, strict=True)))
    rows = [f"{s}; {1.0 / h}\n".replace(";", ",") for s, h in zip(*TABLE, strict=True)]
    periods.write_text("\ufeffsa(0.5 s),return_period\n" + "".join(reversed(rows)), encoding="utf-8")
    unnamed.write_text("intensity,rate\n1,0.1\n2,0.01\n")
    one, other = Hazard.from_csv(rates), Hazard.from_csv(periods)
    for unit in ("(1/yr)", "[year^-1]", "per year"):
        rates.write_text(f"pga,rate {unit}\n0.1,0.01\n0.2,0.001\n")
        assert Hazard.from_csv(rates).rate.tolist() == [0.01, 0.001]
    assert (one.measure, other.measure) == (Measure("pga"), Measure("sa", 0.5))
    assert Hazard.from_csv(unnamed, "sa(1, 0.02)").measure == Measure("sa", 1.0, 0.02)
    assert np.array_equal(one.intensity, TABLE[0])
    assert other.rate == pytest.approx(TABLE[1], rel=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "must have two columns"),
        ("pga,rate,more\n1,2,3\n", "must have two columns"),
        ("1" * 200_000, "field larger than field limit"),
        ("pga,rate\n0.1\n", "must have two columns"),
        ("pga,poe\n0.1,0.1\n0.2,0.05\n", "column 2 = 'poe': must be rate"),
        ("pga,rate (%/year)\n0.1,10\n0.2,5\n", "column 2 = 'rate (%/year)': must be rate (1/year)"),
        ("pga,rate in 50 years\n0.1,0.1\n0.2,0.05\n", "column 2 = 'rate in 50 years': must be rate"),
        ("pga,return_period (days)\n0.1,100\n0.2,500\n", "column 2 = 'return_period (days)': must be rate"),
        *(
            (f"pga,{name}\n0.1,1\n0.2,0.5\n", f"column 2 = {name!r}: must be rate (1/year)")
            for name in (
                "rate per century",
                "daily rate",
                "weekly rate",
                "rate per decade",
                "rate_per_day",
                "rate 1/ka",
            )
        ),
        ("acceleration,rate\n0.1,0.1\n0.2,0.05\n", "column 1 = 'acceleration': must be pga, pgv, sa"),
        ("sa,rate\n0.1,0.1\n0.2,0.05\n", "column 1 = 'sa': must be pga"),
        ("sa(1.2.3),rate\n0.1,0.1\n0.2,0.05\n", "must have a period in s"),
        ("pga (m/s2),rate\n0.1,0.1\n0.2,0.05\n", "must be in g"),
        ("intensity,rate\n0.1,0.1\n0.2,0.05\n", "the measure must be named"),
        ("pga,rate\n0.1,a\n0.2,0.05\n", "could not convert string to float: 'a'"),
        ("pga,rate\n0.1,0.1\n", "at least two points"),
        ("pga,rate\n0.1,0.1\n0.2,-0.05\n", "positive intensities and rates"),
        ("pga,rate\n0.1,0.1\n0.2,nan\n", "positive intensities and rates"),
        ("pga,return_period\n0.1,0\n0.2,10\n", "positive intensities and rates"),
        ("pga,rate\n0.1,0.1\n0.2,0.2\n", "rate 0.1 at 0.1, 0.2 at 0.2: must fall"),
        ("pga,rate\n0.1,0.2\n0.1,0.1\n", "must fall"),
        ("pga,rate\n0.1,0.2\n0.2,0.2\n", "must fall"),
    ],
)
def test_invalid_tables_are_refused_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "hazard.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        Hazard.from_csv(path)
    said = str(caught.value)
    assert said.startswith(f"{path}: ")
    assert message in said
    assert "\n" not in said


def test_other_measures_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is over PGV, must be over PGA as the fragility"):
        risk(curve(0.5, 0.4), Hazard.power_law("pgv", 2.0, 0.15, 475.0))
    with pytest.raises(InputError, match="years = 0"):
        risk(curve(0.5, 0.4), Hazard.power_law("pga", 2.0, 0.15, 475.0), 0.0)
    with pytest.raises(InputError, match="at least two points"):
        Hazard.from_table("pga", [0.1, 0.2], [0.1])
    with pytest.raises(InputError, match="slope = -1"):
        Hazard.power_law("pga", -1.0, 0.15, 475.0)
    path = tmp_path / "hazard.csv"
    path.write_text("pga,rate\n0.1,0.1\n0.2,0.05\n")
    with pytest.raises(InputError, match="column 1 = 'pga': must be pgv, or intensity"):
        Hazard.from_csv(path, "pgv")


@pytest.mark.long  # takes seconds
def test_command_tells_draws_and_writes(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    results = run_study(Study.from_toml(folder / "study.toml"), folder)
    results.to_csv(folder / "small.csv")
    monkeypatch.chdir(folder)
    Path("hazard.csv").write_text("pga,return_period\n0.1,100\n0.3,1000\n0.6,5000\n")
    fragility = fit_fragility(results)
    wanted = risk(fragility, Hazard.from_csv("hazard.csv"), 100.0)
    words = ["--hazard", "hazard.csv", "--years", "100"]
    assert main(["risk", ".", *words, "-o", "risk.csv", "--plot", "risk.png"]) == 0
    said = capsys.readouterr().out
    assert f"overturned: {wanted}" in said
    assert "where the hazard is extrapolated" in said
    assert Path("risk.png").stat().st_size > 10_000
    with open("risk.csv", newline="", encoding="utf-8") as file:
        whole, *ranges = csv.DictReader(file)
    assert float(whole["rate"]) == wanted.rate
    assert (float(whole["low"]), float(whole["high"])) == wanted.probability_bounds
    assert sum(float(row["rate"]) for row in ranges) == pytest.approx(wanted.rate, rel=1e-12)
    assert (float(ranges[0]["from"]), float(ranges[-1]["to"])) == (0.0, math.inf)
    # the same results by their other names
    for study in ("small.journal", "small.csv", "study.toml"):
        assert main(["risk", study, *words]) == 0
        assert f"overturned: {wanted}" in capsys.readouterr().out
    law = ["--slope", "2", "--point", "0.3", "475"]
    for mistake, message in (
        ([], "exactly one must be given"),
        (["--slope", "2"], "exactly one must be given"),
        ([*words, *law], "exactly one must be given"),
        (law, "--measure: missing"),
        ([*law, "--measure", "pgv"], "overturned: pgv: all runs up to 0.8432 m/s stand"),
        ([*law, "--measure", "sa(1)"], "is over Sa(1 s, 5 %), must be over a measure of the results: PGA, PGV"),
    ):
        assert main(["risk", ".", *mistake]) == 2
        error = capsys.readouterr().err
        assert message in error
        assert error.count("\n") == 1
    Path("other.journal").write_text("")
    assert main(["risk", ".", *words]) == 2
    assert "has 2 files *.journal" in capsys.readouterr().err


def test_picture_has_hazard_fragility_and_density(tmp_path: Path) -> None:
    found = risk(curve(0.45, 0.5), Hazard.from_table("pga", *TABLE))
    figure = found.plot(tmp_path / "risk.png")
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "rate of exceedance (1/year)",
        "probability of failure",
        "1/year per unit of ln PGA",
    ]
    assert "in 50 years" in " ".join(figure.get_supxlabel().split())
    # the area of the density is the rate, but for the ends of the axis
    line = figure.axes[2].lines[0]
    x, y = (np.asarray(values, dtype=np.float64) for values in line.get_data())
    assert np.trapezoid(y, np.log(x)) == pytest.approx(found.rate, rel=0.05)
