"""The outcome of many columns once their base is still: lanes follow them until each stands for good or falls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ..protocol import OVERTURNED, STANDING, UNDECIDED, code_of
from ..still_base import BETWEEN_LOOKS
from .kinematics import Chain
from .lanes import lanes_of, rest_in_lanes
from .model import Column
from .packing import FloatArray, IntArray
from .run import outcome
from .verdict import Barriers, surely_stand


class Outcomes(NamedTuple):
    """The outcomes of columns."""

    words: IntArray  # codes of the verdicts (protocol.WORDS)
    times: FloatArray  # s, of overturning; NaN if a column stands
    joints: IntArray  # over which columns fall, 0 if they stand


def outcomes_of(
    columns: Sequence[Column],
    chain: Chain | None,
    phases: FloatArray,
    stops: FloatArray,
    settle: float,
    flag: FloatArray,
) -> Outcomes:
    """Determine the outcomes of columns of n blocks, all of one kind of lanes, whose base is still from `stops` (s) on.

    They have the `phases` (columns, 4 n) then, and the data `chain` (Chain.of_many); None for columns with slips, which
    are followed one by one. A column is followed for at most `settle` (s), and its outcome does not depend on the
    others. Once flag[0] is set, the call returns soon, without usable results.
    """
    count, code = len(columns), partial(code_of, "verdict")
    found = Outcomes(np.full(count, code(UNDECIDED)), np.full(count, math.nan), np.zeros(count, dtype=np.int64))

    def alone(k: int, column: Column, phase: FloatArray, begin: float, longest: float) -> None:
        word, found.times[k], found.joints[k] = outcome(column, phase, begin, longest)
        found.words[k] = code(word)

    if chain is None:
        for k, column in enumerate(columns):
            if not flag[0]:
                alone(k, column, phases[k], float(stops[k]), settle)
        return found
    kind = lanes_of(columns)
    # a quick bound proves most of them to stand
    turned = np.abs(chain.places(phases).theta)
    left = np.flatnonzero(~surely_stand(chain, chain.energies(phases), turned))
    found.words[:] = code(STANDING)
    if not left.size:
        return found
    columns, chain, phases, stops = [columns[k] for k in left.tolist()], chain.some(left), phases[left], stops[left]
    first, same = _alike(columns)  # one column may occur for many motions
    barriers = Barriers(chain.some(first))
    numbers, some = left, np.arange(len(left))  # remaining indices among the arguments, and here
    looks = 0
    while some.size and not flag[0]:
        # drop those that the barrier holds
        part = chain.some(some)
        held = barriers.hold(same[some], part.energies(phases[some]), np.abs(part.places(phases[some]).theta))
        some = some[~held]
        begin, end = (min(settle, BETWEEN_LOOKS * k) for k in (looks, looks + 1))
        if begin == settle:
            found.words[numbers[some]] = code(UNDECIDED)
            break
        begins, ends = stops[some] + begin, stops[some] + end
        # follow the others to the next check
        made = rest_in_lanes(chain.model[some], chain.n, kind, phases[some], begins, ends, flag)
        fell = made.fallen > 0
        which = numbers[some[fell]]
        found.words[which] = code(OVERTURNED)
        found.times[which], found.joints[which] = made.overturn_time[fell], made.fallen[fell]
        for k in some[~made.finished].tolist():  # alone, from the previous state
            alone(numbers[k], columns[k], phases[k], float(stops[k] + begin), settle - begin)
        phases[some] = made.ends
        some = some[made.finished & ~fell]
        looks += 1
    return found


def _alike(columns: Sequence[Column]) -> tuple[IntArray, IntArray]:
    """Return the indices of distinct columns, and for each column the index among these."""
    known: dict[int, int] = {}
    same = np.array([known.setdefault(id(column), len(known)) for column in columns])
    return np.unique(same, return_index=True)[1], same
