"""The verdicts of the runs of a check, as given and with varied data: which fall, and which are undecided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..models.protocol import OVERTURNED, STANDING, UNDECIDED
from ..models.uncertainty import share_bounds
from ..runs.table import Table

UNFINISHED = "unfinished"  # the solver failed: counts as fallen


def verdicts_of(table: Table) -> NDArray[np.str_]:
    """Return the verdict of each run of a table: standing, overturned, undecided or unfinished."""
    found = np.array(table["verdict"], dtype=f"<U{max(map(len, (STANDING, OVERTURNED, UNDECIDED, UNFINISHED)))}")
    failed = [k for k in table.stats["failures"] if found[k] != OVERTURNED]  # without a rest it has fallen
    found[failed] = UNFINISHED
    return found


def falls(verdicts: ArrayLike) -> NDArray[np.bool_]:
    """Return True for each verdict of a run that has fallen, or counts as fallen."""
    return np.isin(np.asarray(verdicts), (OVERTURNED, UNFINISHED))


def bounds_of(fewest: NDArray[np.bool_], most: NDArray[np.bool_], motions: int) -> tuple[float, float]:
    """Return the bounds at 95 % confidence of a share of runs.

    Runs under one motion are alike: with several motions each motion is one trial, whose success is the share of its
    runs that count; with one motion each run is a trial. Between whole numbers of successes the bounds of Clopper and
    Pearson are interpolated. `fewest` and `most`, (runs,) bool, count for the lower and the upper bound.
    """
    trials = motions if motions > 1 else len(fewest)
    each = np.array([share_bounds(count, trials) for count in range(trials + 1)])
    low, high = (
        float(np.interp(trials * np.mean(counted), np.arange(trials + 1), each[:, side]))
        for side, counted in enumerate((fewest, most))
    )
    return low, high


@dataclass(frozen=True, eq=False)
class Verdicts:
    """The verdicts under each motion: of the subject as given, and of varied ones, in groups of equal length."""

    names: Sequence[str]  # names of the motions
    own: NDArray[np.str_]  # (motions,)
    varied: NDArray[np.str_]  # (runs,), grouped by motion

    @property
    def fallen(self) -> int:
        """The number of varied runs that have fallen."""
        return int(np.sum(falls(self.varied)))

    @property
    def undecided(self) -> int:
        """The number of varied runs that are undecided."""
        return int(np.sum(self.varied == UNDECIDED))

    @property
    def falls_by_motion(self) -> NDArray[np.bool_]:
        """True for each motion under which any run, as given or varied, has fallen, (motions,)."""
        found: NDArray[np.bool_] = np.any(falls(self.varied).reshape(len(self.names), -1), axis=1)
        return falls(self.own) | found

    @property
    def own_falls(self) -> list[str]:
        """The names of the motions under which the model as given falls."""
        return [name for name, fell in zip(self.names, falls(self.own), strict=True) if fell]

    @property
    def own_undecided(self) -> list[str]:
        """The names of the motions under which the model as given is undecided."""
        return [name for name, verdict in zip(self.names, self.own, strict=True) if verdict == UNDECIDED]

    @property
    def bounds(self) -> tuple[float, float]:
        """The bounds of the share that falls; undecided runs stand for the lower bound, fall for the upper one."""
        fell = falls(self.varied)
        return bounds_of(fell, fell | (self.varied == UNDECIDED), len(self.names))
