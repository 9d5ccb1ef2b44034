"""Whether what drives the base diverges with a coupling that is unstable: it changes its sign at every step and grows.

A body under the column or structure that extrapolates its acceleration over too long a step makes an error that the
next step answers with the opposite one, and a larger one: by 1.2 to 20 times a step in the cases of docs/coupling.md.
Ground motion does not do this for long. native/core.c counts alike, with these numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

MANY = 12  # steps in a row in which every input goes back by most of its largest value
BACK = 0.5  # of the largest value: such a change
GROWTH = 2.0  # within these steps


class Alternation:
    """Watches the accelerations of the base, one call a step. A step made again, from the same time, counts once."""

    def __init__(self, count: int) -> None:
        self._time = -math.inf
        self._last, self._change, self._largest = [0.0] * count, [0.0] * count, [0.0] * count
        self._in_a_row, self._before = [0] * count, [0.0] * count

    def found(self, time: float, values: Sequence[float]) -> int:
        """Which of the values, held from `time` on, s, alternates and grows; -1 if none does."""
        if not time > self._time:
            return -1
        self._time = time
        found = -1
        for k, value in enumerate(values):
            change = value - self._last[k]
            if not change * self._change[k] < 0.0 or abs(change) < BACK * self._largest[k]:
                self._in_a_row[k], self._before[k] = 0, max(self._largest[k], abs(value))
            self._in_a_row[k] += 1
            self._last[k], self._change[k] = value, change
            self._largest[k] = max(self._largest[k], abs(value))
            if self._in_a_row[k] >= MANY and self._largest[k] > GROWTH * self._before[k]:
                found = k
        return found
