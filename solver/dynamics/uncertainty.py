"""The uncertainty of a response: the estimate of its error, and the ensemble of runs around it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.errors import NOT_NEGATIVE, InputError, check_number, check_whole

FloatArray = NDArray[np.float64]

PERCENTILES = (16, 50, 84)
CONFIDENCE = 0.95
HALVINGS = 60


@dataclass(frozen=True)
class ErrorEstimate:
    """Difference of a run from a closer one: an estimate of its error.

    ux: largest difference of any ux at the rows while both stand, up to 0.1 s before a fall, in parts of the largest
    |ux| until then. peaks: of each of `Response.peaks`, in parts of itself; of the least contact as it is.
    overturn_time s: NaN unless both fall.
    """

    ux: float
    peaks: dict[str, FloatArray]
    overturn_time: float

    @property
    def peak_ux(self) -> FloatArray:
        """The estimate of the peaks of ux, (n,)."""
        return self.peaks["ux"]


@dataclass(frozen=True)
class Spread:
    """Spread of the runs of an ensemble: standard deviations of the logarithms of factors, and their seed.

    The stiffness and the damping of every joint have a factor of their own, the motion has one. The defaults are
    smaller than the uncertainty of any real column: results that they already spread cannot be predicted by one run.
    """

    stiffness: float = 0.01
    damping: float = 0.01
    motion: float = 0.001
    seed: int = 0

    def __post_init__(self) -> None:
        for key in ("stiffness", "damping", "motion"):
            check_number(f"spread.{key}", getattr(self, key), NOT_NEGATIVE, "a relative size, zero or positive")
            if getattr(self, key) > 1.0:
                raise InputError(f"spread.{key} = {getattr(self, key)}: must be at most 1, it is a relative size")
        check_whole("spread.seed", self.seed, 0, math.inf, "a whole number, zero or positive")

    @property
    def size(self) -> float:
        """The whole spread: the root of the sum of the squares."""
        return math.hypot(self.stiffness, self.damping, self.motion)


@dataclass(frozen=True)
class Ensemble:
    """Results of runs with varied uncertain data.

    verdicts, peak_ux (runs, n) m, overturn_time (runs,) s (NaN while it stands): run by run. peaks (3, n) and ux (3,
    nt, n), m: the 16, 50 and 84 % points, over the runs that do not fall for peaks, and that have not yet fallen for
    ux; NaN if there are none. amplification: half the distance between the 16 and 84 % points of the largest peak, in
    parts of its 50 % point, over the size of the spread; NaN if all fall.
    """

    spread: Spread
    verdicts: tuple[str, ...]
    peak_ux: FloatArray
    overturn_time: FloatArray
    peaks: FloatArray
    ux: FloatArray
    amplification: float
    in_lanes: bool  # whether eight ran at once

    @property
    def size(self) -> int:
        """Number of runs."""
        return len(self.verdicts)

    @property
    def overturned(self) -> int:
        """Number of runs that overturn."""
        return self.verdicts.count("overturned")

    @property
    def undecided(self) -> int:
        """Number of runs without a verdict."""
        return self.verdicts.count("undecided")

    @property
    def share(self) -> float:
        """Share of the runs that overturns."""
        return self.overturned / self.size

    @property
    def share_bounds(self) -> tuple[float, float]:
        """Bounds of the share among very many runs, at 95 % confidence (Clopper and Pearson).

        Runs that are undecided count as standing for the lower bound and as overturned for the upper one.
        """
        low, _ = share_bounds(self.overturned, self.size)
        _, high = share_bounds(self.overturned + self.undecided, self.size)
        return low, high


def share_bounds(count: int, size: int) -> tuple[float, float]:
    """The bounds of Clopper and Pearson on a probability, from `count` successes in `size` trials, at 95 %."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = 0.0 if count == 0 else _share_with(size, count - 1, 1.0 - tail)
    high = 1.0 if count == size else _share_with(size, count, tail)
    return low, high


def _share_with(size: int, count: int, probability: float) -> float:
    """The share of successes at which `size` trials have at most `count` of them with this probability."""
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _at_most(size, count, middle) > probability:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _at_most(size: int, count: int, share: float) -> float:
    """Probability of at most `count` successes in `size` trials."""
    ways = (math.lgamma(size + 1) - math.lgamma(k + 1) - math.lgamma(size - k + 1) for k in range(count + 1))
    success, failure = math.log(share), math.log1p(-share)
    return math.fsum(math.exp(way + k * success + (size - k) * failure) for k, way in enumerate(ways))
