"""The curve of places in which a column balances under a steady horizontal push: continuation by its length.

Balance is 2 n equations (nothing accelerates) for 2 n coordinates and the push. A step goes along the curve and then
back onto it across its direction (Newton's method), so that neither the largest push nor a displacement that turns back
ends the curve. Coordinates are scaled; only the rotations and the push measure the length, since openings follow them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .column import Column
from .errors import SolverError
from .packing import FloatArray
from .still import StillColumn

LONGEST = 0.02  # step along the curve, in parts of the rigid column's largest push and of its rotation on the edge
SHORTEST = 1e-9
MOST_POINTS = 5000
ITERATIONS = 12  # of Newton's method to a point
FEW = 4  # iterations at which the step may grow
CONVERGED = 1e-9  # last correction, in parts of what opens a joint
PART = 1e-3  # of what opens a joint: how far accelerations are differenced
TURN = 0.97  # least cosine between the directions of the curve at two points
NARROWED = 1e-9  # of a step: how exactly a point is found at which something changes


class Balanced(NamedTuple):
    """A place of balance."""

    q: FloatArray  # (2 n,), coordinates of the exact formulation
    push: float  # m/s2, acceleration of the base towards -x (direction 1)
    along: FloatArray  # (2 n + 1,), unit direction of the curve in the scaled coordinates and the push


class _LostError(Exception):
    """The next point was not found: a shorter step may."""


class BalanceCurve:
    """The curve of a column without damping, pushed towards +x (direction 1) or -x (-1).

    Raises InputError without gravity.
    """

    def __init__(self, column: Column, direction: int = 1) -> None:
        self.still = StillColumn(column)
        self.direction = direction
        self.n = self.still.n
        blocks, slenderness = self.still.blocks, _slenderness(self.still)
        self._scale = np.concatenate(
            [math.atan(slenderness) * blocks.turn_size, math.atan(slenderness) * blocks.open_size, [0.0]]
        )
        self._scale[-1] = column.g * slenderness
        self._opens = np.append(self.still.sizes, 1e-3 * self._scale[-1])
        self._weight = np.concatenate([np.full(self.n, 1.0 / self.n), np.zeros(self.n), [1.0]])

    def follow(self) -> tuple[list[Balanced], FloatArray]:
        """Places from rest to where the push is zero again, and the push at which each joint opens, (n,).

        NaN for a joint that never does. Among the places are those of the openings and of the largest push. Raises
        SolverError if the curve cannot be followed.
        """
        upwards = np.append(np.zeros(2 * self.n), 1.0)
        try:
            places, step = [self._onto(self.still.rest, 0.0, upwards, math.inf)[0]], LONGEST
        except _LostError:
            raise SolverError("no balance was found at rest") from None
        uplift = np.where(self._opened(places[0]), 0.0, math.nan)
        while len(places) < MOST_POINTS:
            last = places[-1]
            try:
                place, iterations = self._step(last, step)
            except _LostError:
                step *= 0.5
                if step < SHORTEST:
                    raise SolverError(f"the balance is lost beyond a push of {last.push:.6g} m/s2") from None
                continue
            between = []
            for i in np.flatnonzero(self._opened(place) & np.isnan(uplift)):
                between.append(self._first(last, step, partial(self._joint_opened, int(i))))
                uplift[i] = between[-1][1].push
            if last.along[-1] > 0.0 >= place.along[-1]:
                between.append(self._first(last, step, lambda there: there.along[-1] <= 0.0))
            if place.push <= 0.0:
                between.append(self._first(last, step, lambda there: there.push <= 0.0))
            places += [there for _, there in sorted(between, key=lambda found: found[0])]
            if place.push <= 0.0:
                return places, uplift
            places.append(place)
            if iterations <= FEW:
                step = min(LONGEST, 2.0 * step)
        raise SolverError(f"the curve of balance does not come to an end within {MOST_POINTS} points")

    def _step(self, last: Balanced, step: float) -> tuple[Balanced, int]:
        """The place further along the curve by a step, and the iterations that it took. Raises _LostError."""
        change = step * last.along * self._scale
        place, iterations = self._onto(last.q + change[:-1], last.push + float(change[-1]), last.along, step)
        if float(np.sum(self._weight * place.along * last.along)) < TURN:
            raise _LostError
        return place, iterations

    def _first(self, last: Balanced, step: float, passed: Callable[[Balanced], bool]) -> tuple[float, Balanced]:
        """How far beyond `last`, within the step, and the first place at which something has passed."""
        low, high = 0.0, step
        there = self._step(last, step)[0]
        while high - low > NARROWED * step:
            middle = 0.5 * (low + high)
            place, _ = self._step(last, middle)
            if passed(place):
                high, there = middle, place
            else:
                low = middle
        return high, there

    def _onto(self, q: FloatArray, push: float, along: FloatArray, most: float) -> tuple[Balanced, int]:
        """Newton's method onto the curve, across `along`, by at most so much; and its iterations. Raises _LostError."""
        for iteration in range(1, ITERATIONS + 1):
            right = np.append(-self._unbalanced(q, push), 0.0)
            moved = _solved(self._matrix(q, push, along), right)
            if not self._length(moved) <= most:
                raise _LostError
            change = moved * self._scale
            q, push = q + change[:-1], push + float(change[-1])
            if np.max(np.abs(change) / self._opens) < CONVERGED:
                right[:-1], right[-1] = 0.0, 1.0
                ahead = _solved(self._matrix(q, push, along), right)
                return Balanced(q, push, ahead / self._length(ahead)), iteration
        raise _LostError

    def _length(self, moved: FloatArray) -> float:
        return math.sqrt(float(np.sum(self._weight * moved * moved)))

    def _unbalanced(self, q: FloatArray, push: float) -> FloatArray:
        return self.still.accelerations(q, -self.direction * push)

    def _matrix(self, q: FloatArray, push: float, along: FloatArray) -> FloatArray:
        """Derivatives of the accelerations by the scaled unknowns; the last row is the direction of the curve."""
        n = 2 * self.n
        matrix = np.empty((n + 1, n + 1))
        matrix[:n, :n] = -self.still.stiffness(q, PART, -self.direction * push) * self._scale[:-1]
        matrix[:n, n] = self._unbalanced(q, self._scale[-1]) - self._unbalanced(q, 0.0)
        matrix[n] = self._weight * along
        return matrix

    def _opened(self, place: Balanced) -> NDArray[np.bool_]:
        """Which joints are not in full contact, (n,)."""
        joints = self.still.row(place.q, -self.direction * place.push).joints
        return np.asarray(joints.contact < 1.0)

    def _joint_opened(self, i: int, place: Balanced) -> bool:
        return bool(self._opened(place)[i])


def _slenderness(still: StillColumn) -> float:
    """Half the width of the joint over the height of what stands on it, of the joint at which that is least."""
    blocks, carried, height, least = still.blocks, 0.0, 0.0, math.inf
    for i in range(still.n):
        own = blocks.mass[i]
        height = (carried * (height + blocks.height[i]) + own * blocks.centroid[i]) / (carried + own)
        carried += own
        least = min(least, 0.5 * blocks.width[i] / height)
    return float(least)


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    try:
        found = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        raise _LostError from None
    return np.asarray(found, dtype=np.float64)
