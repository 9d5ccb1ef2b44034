"""The uncertainty of a response: the estimate of its error, and the ensemble of runs around it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.aliases import Alias
from ..common.errors import NOT_NEGATIVE, InputError, check_number, check_whole
from ..ground.motion import Motion

FloatArray = NDArray[np.float64]

PERCENTILES = (16, 50, 84)
CONFIDENCE = 0.95
HALVINGS = 60


@dataclass(frozen=True)
class ErrorEstimate:
    """The difference of a run from a more accurate one: an estimate of its error.

    Attributes
    ----------
    ux : float
        The largest difference of any ux at the rows while both stand, up to 0.1 s before a fall, relative to the
        largest |ux| until then.
    peaks : dict of str to ndarray
        The difference of each of `Response.peaks`, relative to its value; of the least contact, bond and gap
        absolute.
    overturn_time : float
        The difference of the times of overturning (s); NaN unless both fall.
    """

    ux: float
    peaks: dict[str, FloatArray]
    overturn_time: float

    peak_ux = Alias('peaks["ux"]', lambda estimate: estimate.peaks["ux"])


@dataclass(frozen=True)
class Spread:
    """The spread of the runs of an ensemble: standard deviations of the logarithms of factors, and their seed.

    The stiffness and the damping of every joint have independent factors, the motion has one. The defaults are smaller
    than the uncertainty of any real column: results that they already spread cannot be predicted by one run.
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
        """The total spread: the root of the sum of the squares."""
        return math.hypot(self.stiffness, self.damping, self.motion)


@dataclass(frozen=True)
class Ensemble:
    """The results of runs with varied uncertain data.

    Attributes
    ----------
    spread : Spread
        The spread of the data.
    verdicts : tuple of str
        The verdict of each run.
    displacements : ndarray of shape (runs, n)
        The largest displacements of each run, as `Result.displacements` (m).
    overturn_time : ndarray of shape (runs,)
        The time of overturning of each run (s), NaN while it stands.
    peaks : ndarray of shape (3, n)
        The 16, 50 and 84 % points of the displacements over the runs that do not fall (m), NaN if there are none.
    ux : ndarray of shape (3, nt, n)
        The same points of ux, of a structure of the horizontal displacement in any direction, over the runs that have
        not yet fallen (m), NaN if there are none.
    amplification : float
        Half the distance between the 16 and 84 % points of the largest peak, relative to its 50 % point, divided by the
        size of the spread; NaN if all fall.
    in_lanes : bool
        Whether eight runs were made at once.
    debris : tuple of Debris
        The debris of each run that has fallen and gone on (`after_fall`).
    """

    spread: Spread
    verdicts: tuple[str, ...]
    displacements: FloatArray
    overturn_time: FloatArray
    peaks: FloatArray
    ux: FloatArray
    amplification: float
    in_lanes: bool  # whether eight ran at once
    debris: tuple[Debris, ...] = ()  # of the runs that have fallen and gone on
    peak_ux = Alias("displacements")

    @property
    def size(self) -> int:
        """The number of runs."""
        return len(self.verdicts)

    @property
    def overturned(self) -> int:
        """The number of runs that overturn."""
        return self.verdicts.count("overturned")

    @property
    def undecided(self) -> int:
        """The number of runs without a verdict."""
        return self.verdicts.count("undecided")

    @property
    def envelope(self) -> FloatArray:
        """The least and the largest coordinates of the centroids at the end of the fallen runs, m (2, n, 3).

        It has no blocks, (2, 0, 3), if no run has fallen and gone on.
        """
        if not self.debris:
            return np.empty((2, 0, 3))
        places = np.array([one.places for one in self.debris])
        return np.array([np.min(places, axis=0), np.max(places, axis=0)])

    @property
    def hit_shares(self) -> dict[str, float]:
        """The fraction of the fallen runs in which two neighbours hit each other, by their names."""
        every = sorted({name for one in self.debris for name in one.hits})
        return {name: sum(name in one.hits for one in self.debris) / len(self.debris) for name in every}

    @property
    def share(self) -> float:
        """The fraction of the runs that overturn."""
        return self.overturned / self.size

    @property
    def share_bounds(self) -> tuple[float, float]:
        """The bounds of the fraction among very many runs, at 95 % confidence (Clopper and Pearson).

        Undecided runs count as standing for the lower bound and as overturned for the upper one.
        """
        low, _ = share_bounds(self.overturned, self.size)
        _, high = share_bounds(self.overturned + self.undecided, self.size)
        return low, high


LEAST_CHANGE, MOST_CHANGE = 1e-3, 1e3  # of a value by its factor; the valid range of a model may be wider


def vary(model: Any, motion: Motion, spread: Spread, rng: np.random.Generator) -> tuple[Any, Motion]:
    """Return a model (protocol.py) and a motion with varied data, all as likely as the given ones.

    Factors have the standard deviations of `spread`; `rng` draws them.
    """

    def factors(size: float, count: int) -> list[float]:
        return np.clip(np.exp(size * rng.standard_normal(count)), LEAST_CHANGE, MOST_CHANGE).tolist()

    count = len(model.laws)
    stiffness, damping = factors(spread.stiffness, count), factors(spread.damping, count)
    return model.scaled_joints(stiffness, damping), motion.scaled(factors(spread.motion, 1)[0])


class Debris(NamedTuple):
    """The debris of one run: places of the centroids at its end, m (n, 3), and the neighbours that have hit."""

    places: FloatArray
    hits: tuple[str, ...]


class Varied(NamedTuple):
    """The result of one run of an ensemble: its verdict, time of overturning (s), peaks (n,) and history (nt, n), m."""

    verdict: str
    overturn_time: float
    peaks: FloatArray
    ux: FloatArray
    debris: Debris | None = None  # of a run that goes on after a fall


def ensemble_from(runs: Sequence[Varied], spread: Spread, time: FloatArray, in_lanes: bool) -> Ensemble:
    """Make the ensemble of varied runs.

    `spread` is that of their data, `time` has the times of their rows, (nt,) s; `in_lanes`: whether lanes made them.
    """
    moved, overturn_time = (np.array([getattr(run, name) for run in runs]) for name in ("peaks", "overturn_time"))
    stands = np.array([run.verdict != "overturned" for run in runs])
    # histories at these rows: a run after whose fall another one goes on may have fewer, or more
    ux = np.full((len(runs), len(time), runs[0].ux.shape[1]), math.nan)
    for k, run in enumerate(runs):
        ux[k, : len(run.ux)] = run.ux[: len(time)]
    ux[overturn_time[:, None] <= time] = math.nan
    low, middle, high = percentiles_of(np.where(stands, np.max(moved, axis=1), math.nan))
    relative = 0.5 * (high - low) / (middle or math.nan)  # NaN instead of a division by zero if the model rests
    return Ensemble(
        spread=spread,
        verdicts=tuple(run.verdict for run in runs),
        displacements=moved,
        overturn_time=overturn_time,
        peaks=percentiles_of(np.where(stands[:, None], moved, math.nan)),
        ux=percentiles_of(ux),
        amplification=float(relative / max(spread.size, math.ulp(1.0))),
        in_lanes=in_lanes,
        debris=tuple(run.debris for run in runs if run.debris is not None),
    )


def percentiles_of(values: FloatArray) -> FloatArray:
    """Return the `PERCENTILES` over the first axis, ignoring NaN, as numpy.nanpercentile does but faster."""
    ordered = np.sort(values, axis=0)  # NaN is sorted last
    last = np.maximum(np.sum(~np.isnan(ordered), axis=0) - 1, 0)
    found = []
    for percent in PERCENTILES:
        place = 0.01 * percent * last
        below = np.floor(place).astype(np.int64)
        low, high = (np.take_along_axis(ordered, k[None], axis=0)[0] for k in (below, np.minimum(below + 1, last)))
        found.append(low + (place - below) * (high - low))
    return np.array(found)


def share_bounds(count: int, size: int) -> tuple[float, float]:
    """Return the bounds of Clopper and Pearson on a probability, from `count` successes in `size` trials, at 95 %."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = 0.0 if count == 0 else _share_with(size, count - 1, 1.0 - tail)
    high = 1.0 if count == size else _share_with(size, count, tail)
    return low, high


def _share_with(size: int, count: int, probability: float) -> float:
    """Return the success probability at which `size` trials have at most `count` successes with this probability."""
    k = np.arange(1.0, count + 1.0)
    ways = np.concatenate([[0.0], np.cumsum(np.log((size + 1.0 - k) / k))])  # logs of binomial coefficients to `count`
    k = np.arange(count + 1.0)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        at_most = np.sum(np.exp(ways + k * math.log(middle) + (size - k) * math.log1p(-middle)))
        if at_most > probability:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
