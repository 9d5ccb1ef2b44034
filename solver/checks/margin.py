"""The margin: the factor on a motion at which the column begins to fall, by bisection on ensembles.

A larger motion does not always overturn more columns. So the factor goes up step by step from 1 to the first run that
falls, and only between these two steps it is bisected; a fall between two smaller steps may be passed over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..column.column import Column
from ..ground.motion import Motion
from ..runs.ensemble import vary
from ..runs.many import Callback, simulate_many
from ..dynamics.uncertainty import Spread
from .scaling import ScaledMotion, applied

STEP = 1.25  # factor between two steps
MOST, LEAST = 5.0, 0.05  # factors looked at
NARROW = 1.04  # ratio of the two bounds at which the bisection ends
RUNS = 8  # of each motion and factor: as many as go at once in the lanes


class Bounds(NamedTuple):
    """Factors on a motion: no run falls at `stands`, some run falls at `falls`; inf or 0 where none was found."""

    stands: float
    falls: float


@dataclass(frozen=True)
class Margin:
    """The bounds of each motion."""

    motions: tuple[str, ...]
    bounds: tuple[Bounds, ...]
    runs: int  # made to find them

    @property
    def least(self) -> float:
        """Largest factor at which no run of any motion falls."""
        return min(bound.stands for bound in self.bounds)

    @property
    def mean(self) -> float:
        """Mean over the motions of the largest factors at which none falls."""
        return float(np.mean([bound.stands for bound in self.bounds]))

    @property
    def governing(self) -> int:
        """Place of the motion that has the least."""
        return int(np.argmin([bound.stands for bound in self.bounds]))

    @property
    def is_open(self) -> bool:
        """Whether it does not fall at the largest factor looked at, under any motion."""
        return all(not np.isfinite(bound.falls) for bound in self.bounds)


def margin_of(
    column: Column, motions: Sequence[ScaledMotion], spread: Spread, runs: int = RUNS, callback: Callback | None = None
) -> Margin:
    """The margin of a column under each motion, with `runs` varied columns each, the same ones at every factor.

    Runs without a verdict count as falls. Raises as `simulate_many` does.
    """
    ensembles = [varied(column, scaled.motion, runs, spread, k) for k, scaled in enumerate(motions)]
    low, high = np.zeros(len(motions)), np.full(len(motions), np.inf)
    made = 0

    def fall(places: NDArray[np.int64], factors: NDArray[np.float64]) -> NDArray[np.bool_]:
        nonlocal made
        pairs = [
            (held, applied("", motion, float(factor)).motion)
            for place, factor in zip(places, factors, strict=True)
            for held, motion in ensembles[place]
        ]
        made += len(pairs)
        columns, shaken = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
        table = simulate_many(columns, shaken, keep=("verdict",), callback=callback)
        return np.any((table["verdict"] != "standing").reshape(len(places), runs), axis=1)

    def note(places: NDArray[np.int64], factors: NDArray[np.float64]) -> None:
        fell = fall(places, factors)
        high[places[fell]] = factors[fell]
        low[places[~fell]] = factors[~fell]

    everything = np.arange(len(motions))
    note(everything, np.ones(len(motions)))
    upwards, factor = everything[low > 0.0], STEP
    while upwards.size and factor <= MOST * (1.0 + 1e-9):
        note(upwards, np.full(upwards.size, factor))
        upwards, factor = upwards[~np.isfinite(high[upwards])], factor * STEP
    downwards, factor = everything[low == 0.0], 1.0 / STEP
    while downwards.size and factor >= LEAST:
        note(downwards, np.full(downwards.size, factor))
        downwards, factor = downwards[low[downwards] == 0.0], factor / STEP
    while (wide := everything[(low > 0.0) & np.isfinite(high) & (high > NARROW * low)]).size:
        note(wide, np.sqrt(low[wide] * high[wide]))
    bounds = tuple(Bounds(float(a), float(b)) for a, b in zip(low, high, strict=True))
    return Margin(tuple(scaled.name for scaled in motions), bounds, made)


def varied(column: Column, motion: Motion, runs: int, spread: Spread, place: int) -> list[tuple[Column, Motion]]:
    """`runs` columns and motions around the given ones; the same for the same seed and place."""
    rng = np.random.default_rng([spread.seed, place])
    return [vary(column, motion, spread, rng) for _ in range(runs)]
