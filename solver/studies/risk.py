"""Risk: how often a model fails, from its fragility and the seismic hazard of its site."""

from __future__ import annotations

import csv
import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..common.digits import percent
from ..common.errors import POSITIVE, InputError, check_number, check_type, needing, reading
from ..common.files import MOST_RECORD, content_of, write_table
from ..common.notebook import NotebookRepr
from ..common.tables import numbers_of
from ..models.pictures import draw
from ..models.protocol import FloatArray
from .motions import Measure
from .statistics import Fragility, percentages_of_bounds

if TYPE_CHECKING:
    from matplotlib.figure import Figure

YEARS = 50.0
# intensities between which shares of the rate are given: those with more than LEAST_SHARE on either side
EDGES = tuple(float(f"{part}e{power}") for power in range(-4, 4) for part in (1, 1.5, 2, 3, 4, 5, 7))
LEAST_SHARE = 0.01
OFTEN = 1e-3  # 1/year
RISK_NOTE = "bounds: 95 % confidence of the fragility; the hazard is taken as given"
PER_ONE = re.compile(r"1\s*/|\^?-1\b")  # as in 1/year, year^-1
# of a heading that is not 1/year or years
OTHER_UNITS = re.compile(
    r"%|percent|\d|\b(log|ln|hour|dai|day|week|month|quarter|decad|centur|millenn|k(a|yr?|years?)\b)"
)
COLUMNS = ("failure", "from", "to", "share", "rate", "rate_low", "rate_high", "years", "probability", "low", "high")


@dataclass(frozen=True, eq=False)
class Hazard:
    """The annual rate at which an intensity is exceeded: a power law between any two points.

    Below the first and above the last point the power laws of the outermost intervals continue.

    Attributes
    ----------
    measure
        The measure of intensity.
    intensity
        Intensities of the points, increasing, (points,).
    rate
        Annual rates of exceedance, (points,).
    slopes
        -d log(rate) / d log(intensity) below the first point, between the points and above the last, (points + 1,).
    """

    measure: Measure
    intensity: FloatArray
    rate: FloatArray
    slopes: FloatArray

    def __post_init__(self) -> None:
        # probably in another unit: half the largest intensity on record more often than once in 1,000 years
        often = self.intensity[self.rate >= OFTEN]
        if len(often):
            self.measure.warn_of_largest("hazard: once in 1,000 years", float(often[-1]), 0.5)

    @classmethod
    def power_law(cls, measure: str, slope: float, intensity: float, return_period: float) -> Hazard:
        """Return the power law of a slope through an intensity of a return period (years). Raises InputError."""
        given = {"slope": slope, "intensity": intensity, "return_period": return_period}
        k, s, years = (check_number(key, value, POSITIVE, "a positive number") for key, value in given.items())
        return cls(Measure.from_text("measure", measure), np.array([s]), np.array([1.0 / years]), np.array([k, k]))

    @classmethod
    def from_table(cls, measure: str, intensity: ArrayLike, rate: ArrayLike) -> Hazard:
        """Return the hazard through at least two points.

        Parameters
        ----------
        measure : str
            The measure: pga (g), pgv (m/s) or sa(PERIOD) (g).
        intensity, rate : (points,) array-like
            Intensities, in any order, and their annual rates of exceedance.

        Raises
        ------
        InputError
            If there are fewer points, a number is not positive, or the rate does not fall as the intensity grows.
        """
        s, h = (numbers_of(key, values) for key, values in (("intensity", intensity), ("rate", rate)))
        if (
            s.ndim != 1
            or s.shape != h.shape
            or len(s) < 2
            or not all(np.all((a > 0.0) & np.isfinite(a)) for a in (s, h))
        ):
            raise InputError("hazard: must have at least two points, of positive intensities and rates")
        order = np.argsort(s, kind="stable")
        s, h = s[order], h[order]
        wrong = (np.diff(s) == 0.0) | (np.diff(h) > 0.0)
        wrong[-1] |= h[-1] == h[-2]
        if np.any(wrong):
            k = int(np.argmax(wrong))
            here, after = (f"{h[i]:g} at {s[i]:g}" for i in (k, k + 1))
            raise InputError(f"hazard: rate {here}, {after}: must fall as the intensity grows")
        between = np.diff(np.log(h[::-1]))[::-1] / np.diff(np.log(s))
        slopes = np.concatenate([between[:1], between, between[-1:]])
        return cls(Measure.from_text("measure", measure), s, h, slopes)

    @classmethod
    def from_csv(cls, path: str | os.PathLike[str], measure: str | None = None) -> Hazard:
        """Read two columns with a header, such as `pga,rate` or `sa(0.5),return_period`.

        `measure` is needed if the header is `intensity`. Raises InputError that begins with `path`.
        """
        with reading(path):
            lines = content_of(path, MOST_RECORD).decode("utf-8-sig").splitlines()
            try:
                rows = [[cell.strip() for cell in row] for row in csv.reader(lines) if row]
            except csv.Error as error:
                raise InputError(str(error)) from None
            if not rows or any(len(row) != 2 for row in rows):
                raise InputError("must have two columns with a header: an intensity, and rate or return_period")
            (first, second), *rest = rows
            # what the columns are
            named = None if first.lower() == "intensity" else Measure.from_text("column 1", first)
            if named is None and measure is None:
                raise InputError("column 1: the measure must be named: pga, pgv or sa(PERIOD)")
            if named is not None and measure is not None and named != Measure.from_text("measure", measure):
                raise InputError(f"column 1 = {first!r}: must be {measure}, or intensity")
            words = re.sub("[^a-z]+", " ", second.lower()).split()
            other = OTHER_UNITS.search(PER_ONE.sub("", second.lower().replace("_", " ")))
            if other or (words[:2] != ["return", "period"] and "rate" not in words):
                raise InputError(f"column 2 = {second!r}: must be rate (1/year) or return_period (years)")
            intensity, values = np.array(rest, dtype=np.float64).reshape(-1, 2).T
            with np.errstate(divide="ignore"):
                return cls.from_table(measure or first, intensity, values if "rate" in words else 1.0 / values)

    def exceeded(self, intensity: ArrayLike) -> FloatArray:
        """Return the annual rate at which intensities of any shape are exceeded."""
        s = np.asarray(intensity, dtype=np.float64)
        place = np.searchsorted(self.intensity, s, side="right")
        point = np.maximum(place - 1, 0)
        return np.asarray(self.rate[point] * (s / self.intensity[point]) ** -self.slopes[place])

    def __str__(self) -> str:
        """Return the measure, the points and the slopes beyond them."""
        (low, high), unit = self.intensity[[0, -1]], self.measure.unit
        if low == high:
            return f"{self.measure.label} {low:g} {unit} in {1.0 / self.rate[0]:.4g} years, slope {self.slopes[0]:g}"
        return (
            f"{self.measure.label} from {low:g} {unit} ({self.rate[0]:.3g} per year) to {high:g} {unit} "
            f"({self.rate[-1]:.3g} per year), slopes {self.slopes[0]:.3g} below and {self.slopes[-1]:.3g} above"
        )


@dataclass(frozen=True, repr=False, eq=False)
class Risk(NotebookRepr):
    """The annual rate of failure, and the probability of failure in some years.

    Attributes
    ----------
    fragility
        The probability of failure over the intensity.
    hazard
        The rates of the intensities.
    years
        The time of the probability.
    rate
        Annual rate of failure.
    rate_bounds
        Bounds of the rate at 95 % confidence of the fragility; the hazard is taken as given. The upper one is infinite
        if it would exceed the largest rate of a table of the hazard: below its least intensity nothing is known.
    edges
        Intensities between which `shares` are given, (ranges + 1,), from 0 to infinity.
    shares
        Share of the rate from each range of the intensity, (ranges,).
    beyond
        Shares of the rate from below the first and from above the last point of the hazard.
    """

    fragility: Fragility
    hazard: Hazard
    years: float
    rate: float
    rate_bounds: tuple[float, float]
    edges: FloatArray
    shares: FloatArray
    beyond: tuple[float, float]

    @property
    def probability(self) -> float:
        """The probability of at least one failure in the years, of a Poisson process."""
        return -math.expm1(-self.rate * self.years)

    @property
    def probability_bounds(self) -> tuple[float, float]:
        """The bounds of the probability, as `rate_bounds`."""
        low, high = (-math.expm1(-rate * self.years) for rate in self.rate_bounds)
        return low, high

    def density(self, intensity: FloatArray) -> FloatArray:
        """Return the rate of failure per unit of the logarithm of the intensity, at intensities (k,)."""
        slopes = self.hazard.slopes[np.searchsorted(self.hazard.intensity, intensity, side="right")]
        return np.asarray(slopes * self.hazard.exceeded(intensity) * self.fragility.probability(intensity))

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw hazard, fragility and the density of the rate, and save it to `path` if given. Raises InputError."""
        return draw(self, "draw_risks", path)

    def _facts(self) -> tuple[str, ...]:
        return f"over {self.hazard.measure.label}", str(self)

    def __str__(self) -> str:
        """Return the rate and the probability with their bounds."""
        low, high = (percent(bound) for bound in self.probability_bounds)
        least, most = self.rate_bounds
        upper = f"to {most:.3g}" if math.isfinite(most) else "or more, not bounded above"
        return (
            f"{self.rate:.3g} per year ({least:.3g} {upper}), "
            f"{percent(self.probability)} in {self.years:g} years ({low} to {high})"
        )


def risk(fragility: Fragility, hazard: Hazard, years: float = YEARS) -> Risk:
    """Compute the annual rate of failure, and the probability of failure in some years.

    The bounds are the wider of those by the bootstrap curves and by the likelihood ends of the fragility.

    Raises InputError if hazard and fragility have different measures, or if the rate is zero or infinite.
    """
    check_type("fragility", fragility, Fragility)
    check_type("hazard", hazard, Hazard)
    check_number("years", years, POSITIVE, "a positive time in years")
    if fragility.measure != hazard.measure:
        label = fragility.name if fragility.measure is None else fragility.measure.label
        raise InputError(f"hazard: is over {hazard.measure.label}, must be over {label} as the fragility")
    # shares of the rate below each of many intensities
    low, high = hazard.intensity[[0, -1]].tolist()
    edges = np.unique([0.0, *EDGES, low, high, math.inf])
    parts = rates_between(hazard, edges, np.array([[fragility.median, fragility.deviation]]))[0]
    rate = float(np.sum(parts))
    if not 0.0 < rate < math.inf:
        raise InputError(f"hazard: gives a rate of {rate:g} per year, too steep or too weak for this fragility")
    below = dict(zip(edges.tolist(), [0.0, *(np.cumsum(parts) / rate).tolist()], strict=True))
    kept = [0.0, *(edge for edge in EDGES if LEAST_SHARE < below[edge] < 1.0 - LEAST_SHARE), math.inf]
    # bounds
    curves = np.vstack([fragility.curves, fragility.ends])
    rates = np.sum(rates_between(hazard, np.array([0.0, math.inf]), curves), axis=1)
    resampled, of_ends = np.split(rates, [len(fragility.curves)])
    bounds = [*np.percentile(resampled, percentages_of_bounds(), method="inverted_cdf"), *of_ends]
    least, most = float(min(bounds)), float(max(bounds))
    is_table = len(hazard.intensity) > 1
    return Risk(
        fragility=fragility,
        hazard=hazard,
        years=years,
        rate=rate,
        rate_bounds=(least, math.inf if is_table and most > hazard.rate[0] else most),
        edges=np.array(kept),
        shares=np.diff([below[edge] for edge in kept]),
        beyond=(below[low], max(0.0, 1.0 - below[high])),
    )


def rates_between(hazard: Hazard, edges: FloatArray, curves: FloatArray) -> FloatArray:
    """Integrate the rate of failure, -P dH, between intensities, in closed form.

    With x = log s, H = H1 exp(-k (x - x1)) and P = ndtr(z), z = (x - log median) / b, the integral from x to infinity
    is H P + H1 exp(k (x1 - log median) + (k b)**2 / 2) ndtr(-z - k b).

    Parameters
    ----------
    hazard : Hazard
        The hazard H.
    edges : (ranges + 1,) float
        Increasing intensities, from 0 to infinity.
    curves : (curves, 2) float
        Medians and deviations of lognormal fragilities P.

    Returns
    -------
    (curves, ranges) float
        Annual rates of failure by motions of each range.
    """
    with needing("studies", "scipy"):
        from scipy.special import log_ndtr, ndtr
    # intervals without a point of the hazard inside: the slope of each, and a point of its power law
    s = np.unique(np.concatenate([edges, hazard.intensity]))
    place = np.searchsorted(hazard.intensity, s[:-1], side="right")
    point, k = np.maximum(place - 1, 0), hazard.slopes[place]
    middle, b = np.log(curves[:, :1]), curves[:, 1:]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # infinite at s = 0
        H, z = hazard.exceeded(s), (np.log(s) - middle) / b
        P = ndtr(z)
        product, step = np.where(s > 0.0, H * P, 0.0), H[:-1] - H[1:]
        # difference of two ndtr, mirrored to the tail where both are small, in logarithms
        low, high = z[:, :-1] + k * b, z[:, 1:] + k * b
        low, high = np.where(low > 0.0, -high, low), np.where(low > 0.0, -low, high)
        factor = np.log(hazard.rate[point]) + k * (np.log(hazard.intensity[point]) - middle) + 0.5 * (k * b) ** 2
        found = product[:, :-1] - product[:, 1:] + np.exp(factor + log_ndtr(high)) - np.exp(factor + log_ndtr(low))
        # bounds by the least and largest P of the interval, which remove what rounding leaves of steep ones
        found = np.fmax(np.fmin(found, step * P[:, 1:]), step * P[:, :-1])
    found = np.where(np.isnan(found), math.inf, found)  # H is infinite at s > 0
    return np.asarray(np.add.reduceat(found, np.searchsorted(s, edges[:-1]), axis=1))


def risk_text(failure: str, found: Risk) -> str:
    """Return a risk as lines of text."""
    fragility, label, unit = found.fragility, found.hazard.measure.label, found.hazard.measure.unit
    below, above = (percent(share, ".1f") for share in found.beyond)
    low, high = found.hazard.intensity[[0, -1]]
    ranges = [f"{first:g} to {last:g}" for first, last in zip(found.edges[:-1], found.edges[1:], strict=True)]
    shares = ", ".join(f"{text}: {percent(share)}" for text, share in zip(ranges, found.shares, strict=True))
    why = f"\n  not bounded above: {not_bounded(found.hazard)}; more runs bound it"
    unbounded = "" if math.isfinite(found.rate_bounds[1]) else why
    return (
        f"{failure}: {found}\n"
        f"  fragility: median {label} {fragility.median:.4g} {unit}, deviation of the logarithm "
        f"{fragility.deviation:.3g}; {fragility.failed} of {fragility.runs} runs failed\n"
        f"  shares of the rate by {label} ({unit}): {shares}\n"
        f"  {below} of the rate is from below {low:g} {unit} and {above} from above {high:g} {unit}, where the hazard "
        f"is extrapolated{unbounded}"
    )


def not_bounded(hazard: Hazard) -> str:
    """Return the reason of an infinite upper bound of the rate."""
    return f"the runs allow a rate above that of the hazard's least intensity, {hazard.rate[0]:.3g} per year"


def write_risks(path: str | os.PathLike[str], risks: Mapping[str, Risk]) -> None:
    """Write risks by the name of the failure as CSV: a line for the whole, then one for each range. Raises OSError."""
    rows: list[tuple[object, ...]] = []
    for name, one in risks.items():
        whole = (one.rate, *one.rate_bounds, one.years, one.probability, *one.probability_bounds)
        rows.append((name, 0.0, math.inf, 1.0, *whole))
        ranges = zip(one.edges[:-1].tolist(), one.edges[1:].tolist(), one.shares.tolist(), strict=True)
        rows += [(name, low, high, share, share * one.rate, *[""] * 6) for low, high, share in ranges]
    write_table(path, COLUMNS, rows)
