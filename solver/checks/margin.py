"""The margin: the factor on the motions at which the column begins to fall, by bisection on ensembles.

A larger motion does not always overturn more columns. So the factor goes up step by step from 1 to the first run that
falls, and only between the last two steps it is bisected; a fall between two smaller steps may be passed over.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..column.column import Column
from ..dynamics.uncertainty import Spread
from ..ground.motion import Motion
from ..runs.ensemble import vary
from ..runs.many import Callback, simulate_many
from ..runs.table import Table
from .scaling import ScaledMotion, applied

STEP = 1.4  # factor between two steps
MOST, LEAST = 4.0, 0.05  # factors looked at
NARROW = 1.04  # ratio of the two bounds at which the bisection ends
# of varied runs: peaks of eight drums under El Centro differ in the fourth digit from those at 1e-4, and the spread of
# the data moves them by a fifth
TOLERANCE = 1e-3

Pair = tuple[Column, Motion]


@dataclass(frozen=True)
class Margin:
    """Factors on all motions: no run falls at `stands`, some run falls at `falls`; 0 or inf where none was found."""

    stands: float
    falls: float
    place: int  # of the motion under which it falls first, -1 if it does not
    runs: int  # made to find them

    @property
    def is_open(self) -> bool:
        """Whether no run falls at the largest factor looked at."""
        return math.isinf(self.falls)


def margin_of(
    ensembles: Sequence[Sequence[Pair]], falls: NDArray[np.bool_], callback: Callback | None = None
) -> Margin:
    """The margin from varied columns and motions, an ensemble for each motion, and which of them have falls at 1.

    The same columns are used at every factor. Runs without a verdict count as falls. Only motions under which runs
    fell are looked at further. Raises as `simulate_many` does.
    """
    made = 0

    def falling(places: NDArray[np.int64], factor: float) -> NDArray[np.int64]:
        nonlocal made
        pairs = [(held, applied("", motion, factor).motion) for k in places for held, motion in ensembles[k]]
        made += len(pairs)
        stands = run_all(pairs, ("verdict",), callback)["verdict"] == "standing"
        found: NDArray[np.int64] = places[~np.all(stands.reshape(len(places), -1), axis=1)]
        return found

    everything = np.arange(len(ensembles))
    fell = everything[falls]
    if fell.size:
        low, high = 1.0 / STEP, 1.0
        while (still := falling(fell, low)).size:
            fell, low, high = still, low / STEP, low
            if low < LEAST:
                return Margin(0.0, high, int(fell[0]), made)
    else:
        low, high = 1.0, STEP
        while not (fell := falling(everything, high)).size:
            low, high = high, high * STEP
            if high > MOST:
                return Margin(low, math.inf, -1, made)
    while high > NARROW * low:
        middle = math.sqrt(low * high)
        if (still := falling(fell, middle)).size:
            fell, high = still, middle
        else:
            low = middle
    return Margin(low, high, int(fell[0]), made)


def varied(column: Column, scaled: ScaledMotion, runs: int, spread: Spread, place: int) -> list[Pair]:
    """`runs` columns and motions around the given ones; the same for the same seed and place.

    The sign of a record is by chance: if the column is not symmetric, every second motion is mirrored.
    """
    rng = np.random.default_rng([spread.seed, place])
    made = [vary(column, scaled.motion, spread, rng) for _ in range(runs)]
    if column.off_axis:
        made[1::2] = [(held, motion.mirrored()) for held, motion in made[1::2]]
    return made


def run_all(pairs: Sequence[Pair], keep: Sequence[str], callback: Callback | None) -> Table:
    """The runs of varied columns, a row for each."""
    return simulate_many(
        [column for column, _ in pairs],
        [motion for _, motion in pairs],
        tolerance=TOLERANCE,
        keep=keep,
        callback=callback,
    )
