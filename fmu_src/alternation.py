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
            if value == 0.0 == self._largest[k]:  # it has not been used
                continue
            change, largest = value - self._last[k], self._largest[k]
            now = max(largest, abs(value))
            if change * self._change[k] < 0.0 and abs(change) >= BACK * largest:
                self._in_a_row[k] += 1
                if self._in_a_row[k] >= MANY and now > GROWTH * self._before[k]:
                    found = k
            else:
                self._in_a_row[k], self._before[k] = 1, now
            self._last[k], self._change[k], self._largest[k] = value, change, now
        return found
