"""The margin: the factor on the motions at which the column begins to fall, by bisection on the runs of a check.

A larger motion does not always overturn more columns. So the factor goes up step by step from 1 to the first run that
falls, and only between the last two steps it is bisected; a fall between two smaller steps may be passed over.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..runs.many import Callback
from .runs import run_all
from .scaling import applied
from .subject import Pair, Subject
from .verdicts import falls, verdicts_of

STEP = 1.4  # factor between two steps
MOST, LEAST = 4.0, 0.05  # factors looked at
NARROW = 1.04  # ratio of the two bounds at which the bisection ends


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
    subject: Subject,
    ensembles: Sequence[Sequence[Pair]],
    at_one: NDArray[np.bool_],
    callback: Callback | None = None,
) -> Margin:
    """The margin from models and motions, an ensemble for each motion, and which of them have falls at 1.

    The same models are used at every factor. Runs that cannot be finished count as falls, undecided ones do not. Only
    motions under which runs fell are looked at further. Raises as `simulate_many` does.
    """
    made = 0

    def falling(places: NDArray[np.int64], factor: float) -> NDArray[np.int64]:
        nonlocal made
        pairs = [(held, applied("", motion, factor).motion) for k in places for held, motion in ensembles[k]]
        made += len(pairs)
        fallen = falls(verdicts_of(run_all(subject, pairs, False, callback)))
        return places[np.any(fallen.reshape(len(places), -1), axis=1)]

    everything = np.arange(len(ensembles))
    fell = everything[at_one]
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
