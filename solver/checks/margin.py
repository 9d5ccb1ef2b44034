"""The margin: the factor on the motions at which overturning begins, by bisection on the runs of a check.

A larger motion does not always overturn more columns. The factor is therefore raised stepwise from 1 to the first run
that falls, and bisected only between the last two steps; a fall between two smaller steps may be missed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.digits import three_digits
from ..runs.many import Callback, begin_phase
from .runs import run_all
from .scaling import applied
from .subject import Pair, Subject
from .verdicts import falls, verdicts_of

STEP = 1.4  # factor between two steps
MOST, LEAST = 4.0, 0.05  # largest and least factor tried
NARROW = 1.04  # ratio of the two bounds at which the bisection ends
# largest number of factors tried: down to the least one, or of the bisection of the last step
MOST_TRIALS = math.ceil(-math.log(LEAST, STEP)) + math.ceil(math.log2(math.log(STEP, NARROW)))


class Trial(NamedTuple):
    """The runs of one factor: the indices of the motions, and the verdict of each of their models."""

    factor: float
    places: NDArray[np.int64]  # (motions,)
    verdicts: NDArray[np.str_]  # (motions, models)


@dataclass(frozen=True)
class Margin:
    """The factors on all motions: no run falls at `stands`, some run falls at `falls`; 0 or inf where there is none."""

    stands: float
    falls: float
    place: int  # index of the motion under which a run falls first, -1 if none falls
    trials: tuple[Trial, ...] = ()  # without that at factor 1

    @property
    def is_open(self) -> bool:
        """True if no run falls at the largest factor tried."""
        return math.isinf(self.falls)


def margin_of(
    subject: Subject,
    ensembles: Sequence[Sequence[Pair]],
    at_one: NDArray[np.bool_],
    callback: Callback | None = None,
    threads: int | None = None,
) -> Margin:
    """Compute the margin by simulating the same models at every factor on their motions.

    Runs that cannot be finished count as falls, undecided ones do not. Once runs fell, only the motions under which
    they fell are bisected. There is one ensemble for each motion, under some of which a run falls at factor 1
    (`at_one`, (motions,)). `callback` and `threads` are those of `simulate_many`, for each set of runs.
    """
    trials: list[Trial] = []

    def falling(places: NDArray[np.int64], factor: float) -> NDArray[np.int64]:
        pairs = [(held, applied("", motion, factor).motion) for k in places for held, motion in ensembles[k]]
        begin_phase(callback, f"margin, {three_digits(factor)} times the motions")
        verdicts = verdicts_of(run_all(subject, pairs, False, callback, threads)).reshape(len(places), -1)
        trials.append(Trial(factor, places, verdicts))
        return places[np.any(falls(verdicts), axis=1)]

    def found(stands: float, fails: float, place: int) -> Margin:
        return Margin(stands, fails, place, tuple(trials))

    # bracket: step down while runs fall, or up until one falls
    everything = np.arange(len(ensembles))
    fell = everything[at_one]
    if fell.size:
        low, high = 1.0 / STEP, 1.0
        while (still := falling(fell, low)).size:
            fell, low, high = still, low / STEP, low
            if low < LEAST:
                return found(0.0, high, int(fell[0]))
    else:
        low, high = 1.0, STEP
        while not (fell := falling(everything, high)).size:
            low, high = high, high * STEP
            if high > MOST:
                return found(low, math.inf, -1)
    # bisect in the logarithm of the factor
    while high > NARROW * low:
        middle = math.sqrt(low * high)
        if (still := falling(fell, middle)).size:
            fell, high = still, middle
        else:
            low = middle
    return found(low, high, int(fell[0]))
