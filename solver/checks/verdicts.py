"""The verdicts of the runs of a check: which falls, and which is undecided, as given and with varied data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..models.protocol import OVERTURNED, STANDING, UNDECIDED
from ..models.uncertainty import share_bounds
from ..runs.table import Table

UNFINISHED = "unfinished"  # the solver could not go on: counts as fallen


def verdicts_of(table: Table) -> NDArray[np.str_]:
    """Of each run of a table: standing, overturned, undecided or unfinished."""
    found = np.array(table["verdict"], dtype=f"<U{max(map(len, (STANDING, OVERTURNED, UNDECIDED, UNFINISHED)))}")
    failed = [k for k in table.stats["failures"] if found[k] != OVERTURNED]  # without a rest it has fallen
    found[failed] = UNFINISHED
    return found


def falls(verdicts: ArrayLike) -> NDArray[np.bool_]:
    """Which runs have fallen, or count as fallen."""
    return np.isin(np.asarray(verdicts), (OVERTURNED, UNFINISHED))


def bounds_of(fewest: NDArray[np.bool_], most: NDArray[np.bool_], motions: int) -> tuple[float, float]:
    """Bounds at 95 % confidence of a share of runs: which count for the lower bound, and for the upper one (runs,).

    Runs under one motion are alike, so that of several motions each is one trial, whose success is the share of its
    runs that count; of one motion each run is a trial. Between whole numbers of successes the bounds of Clopper and
    Pearson are taken in proportion.
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
    """Verdicts under each motion: of the subject as given, and of varied ones, in groups of equal length."""

    names: Sequence[str]  # of the motions
    own: NDArray[np.str_]  # (motions,)
    varied: NDArray[np.str_]  # (runs,), a group for each motion

    @property
    def fallen(self) -> int:
        """Varied runs that have fallen."""
        return int(np.sum(falls(self.varied)))

    @property
    def undecided(self) -> int:
        """Varied runs of which it is not known whether they fall."""
        return int(np.sum(self.varied == UNDECIDED))

    @property
    def any_falls(self) -> bool:
        """Whether some run has fallen, as given or varied."""
        return bool(self.under_which_it_falls.any())

    @property
    def under_which_it_falls(self) -> NDArray[np.bool_]:
        """Whether some run has fallen, as given or varied, of each motion."""
        found: NDArray[np.bool_] = np.any(falls(self.varied).reshape(len(self.names), -1), axis=1)
        return falls(self.own) | found

    @property
    def own_falls(self) -> list[str]:
        """Names of the motions under which it falls as given."""
        return [name for name, fell in zip(self.names, falls(self.own), strict=True) if fell]

    @property
    def own_undecided(self) -> list[str]:
        """Names of the motions under which it is undecided as given."""
        return [name for name, verdict in zip(self.names, self.own, strict=True) if verdict == UNDECIDED]

    @property
    def bounds(self) -> tuple[float, float]:
        """`bounds_of` the share that falls. Undecided runs stand for the lower bound and fall for the upper one."""
        fell = falls(self.varied)
        return bounds_of(fell, fell | (self.varied == UNDECIDED), len(self.names))
