"""The detection of an unstable coupling: an acceleration of the base that alternates in sign at every step and grows.

A body under the column or structure that extrapolates its acceleration over too long a step makes an error that the
next step answers with the opposite one, and a larger one: by 1.2 to 20 times a step in the cases of docs/coupling.md.
Ground motion does not do this for long. native/core.c counts alike, with the same constants.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

MANY = 12  # consecutive steps in which an input reverses by most of its largest value
BACK = 0.5  # of the largest value: least change that counts as a reversal
GROWTH = 2.0  # of the largest value within these steps


class Alternation:
    """A monitor of the accelerations of the base, called once per step; a step repeated from one time counts once."""

    def __init__(self, count: int) -> None:
        self._time = -math.inf
        self._last, self._change, self._largest = [0.0] * count, [0.0] * count, [0.0] * count
        self._in_a_row, self._before = [0] * count, [0.0] * count

    def found(self, time: float, values: Sequence[float]) -> int:
        """Return the index of the value, held from `time` on, s, that alternates and grows; -1 if none does."""
        if not time > self._time:
            return -1
        self._time = time
        found = -1
        for k, value in enumerate(values):
            if value == 0.0 == self._largest[k]:  # unused input
                continue
            change, largest = value - self._last[k], self._largest[k]
            now = max(largest, abs(value))
            if change * self._change[k] < 0.0 and abs(change) >= BACK * largest:
                self._in_a_row[k] += 1
                if found < 0 and self._in_a_row[k] >= MANY and now > GROWTH * self._before[k]:
                    found = k
            else:
                self._in_a_row[k], self._before[k] = 1, now
            self._last[k], self._change[k], self._largest[k] = value, change, now
        return found
