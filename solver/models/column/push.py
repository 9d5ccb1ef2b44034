"""The curve of equilibria of a column under a steady horizontal push, followed by its arc length.

Equilibrium is 2 n equations (zero accelerations) for 2 n coordinates and the push. A step goes along the tangent and
then back onto the curve normal to it (Newton's method), so that neither the largest push nor a displacement that turns
back ends the curve. Coordinates are scaled; only the rotations and the push measure the length, since openings follow
them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.errors import SolverError
from ...common.plausible import UNITS_OF_STIFFNESS
from ...ground.loads import push_unit
from .linearization import StillColumn
from .model import Column
from .packing import FloatArray
from .rest import warnings_of
from .under_loads import in_plane

LONGEST = 0.02  # longest step along the curve, relative to the rigid column's largest push and its rotation on the edge
SHORTEST = 1e-9
MOST_POINTS = 5000
ITERATIONS = 30  # maximum for one point
SLOW = 0.3  # reduction of the correction above which the derivatives are renewed
FEW = 2  # renewals of the derivatives up to which the step may grow
NEAR = 1e-4  # of the length of the curve: a smaller correction cannot reach another branch
CONVERGED = 1e-9  # last correction, relative to the coordinates that open a joint
ROUNDED = 1e-5  # last correction with new derivatives if rounding stops the convergence
PART = 1e-3  # of the coordinates at which a joint opens: size of finite differences
CORNER = 1e-5  # first step behind a corner
BEYOND = (1e-4, 1e-3, 1e-2, 0.1)  # of what opens a joint: distances of derivatives behind a corner
TURN = 0.97  # least cosine between the tangents at two points
WITHOUT_BONDS = "computed without mortar, as once all bonds have broken"  # of a brittle column
NARROWED = 1e-9  # of a step: accuracy of a point at which a regime changes
FOLLOWED = "it was not followed further than"  # reason why a curve ends under loads that do not overturn

_NONE = np.empty((0, 0))


class Balanced(NamedTuple):
    """A point of equilibrium on the curve."""

    q: FloatArray  # (2 n,), coordinates of the exact formulation
    push: float  # m/s2, acceleration of the base towards -x (direction 1)
    along: FloatArray  # (2 n + 1,), unit tangent of the curve in the scaled coordinates and the push
    inverse: FloatArray  # of the derivatives by these, with the tangent as last row; empty when no longer needed


class _LostError(Exception):
    """A failure to find the next point; a shorter step may find it."""


class BalanceCurve:
    """The curve of a column without damping, pushed towards +x (direction 1) or -x (-1).

    With loads on its ports, (6, ports) N and N m, these push instead of the base; then the push is a factor on them,
    and direction -1 reverses them. Raises InputError without gravity.

    Attributes
    ----------
    ends
        Reason why a curve under loads ends before the push is zero again; empty if it does not.
    """

    def __init__(self, column: Column, direction: int = 1, loads: FloatArray | None = None) -> None:
        self.still = StillColumn(column)
        self.direction = direction
        self.loads = None if loads is None else in_plane("pattern", loads)
        self.n = self.still.n
        blocks, slenderness = self.still.blocks, _slenderness(self.still)
        self._scale = np.concatenate(
            [np.full(self.n, math.atan(slenderness)), math.atan(slenderness) * blocks.open_size, [0.0]]
        )
        self._scale[-1] = column.g * slenderness if self.loads is None else _least_factor(self.still, self.loads)
        self._opens = np.append(self.still.sizes, 1e-3 * self._scale[-1])
        self._converged = CONVERGED
        self._weight = np.concatenate([np.full(self.n, 1.0 / self.n), np.zeros(self.n), [1.0]])
        self.ends = ""

    def follow(self) -> list[Balanced]:
        """Return the points from rest to the next one with zero push.

        Among them are the first with each joint open, and that of the largest push. Loads may lift the column, or press
        it down without end; then the curve ends where it is lost, and `ends` is the reason. Raises SolverError, with
        the values of the column that are probably unintended, if the curve cannot be followed.
        """
        places: list[Balanced] = []
        try:
            self._follow(places)
        except SolverError as failure:
            if self.loads is not None and len(places) > 1:
                self.ends = str(failure)
                return places
            meant = warnings_of(self.still.column)
            raise SolverError(
                f"no curve of balance is found: {meant[0] if meant else f'{failure}; {UNITS_OF_STIFFNESS}'}"
            ) from None
        return places

    def _follow(self, places: list[Balanced]) -> None:
        """Append the points to `places`; raise SolverError where the curve cannot be followed."""
        upwards = np.append(np.zeros(2 * self.n), 1.0)
        # the first point, at rest
        q = self.still.rest
        try:
            start = Balanced(q, 0.0, upwards, _inverse(self._matrix(q, 0.0, upwards)))
            places.append(self._pointed(*self._onto(q, 0.0, start, math.inf)[:2], upwards))
        except _LostError:
            raise SolverError("no balance was found at rest") from None
        opened, step = self._opened(places[0]), LONGEST
        while len(places) < MOST_POINTS:
            # a step, shorter if it fails, until the push vanishes
            last = places[-1]
            try:
                place, renewals = self._step(last, step)
            except _LostError:
                step *= 0.5
                if step < SHORTEST:
                    places[-1], step = self._round(last), CORNER
                continue
            places[-1] = last._replace(inverse=_NONE)
            # points between two steps: a joint opens, the largest push, zero push
            between = []
            for i in np.flatnonzero(self._opened(place) & ~opened):
                between.append(self._first(last, step, partial(self._joint_opened, int(i))))
                opened[i] = True
            if last.along[-1] > 0.0 >= place.along[-1]:
                between.append(self._first(last, step, lambda there: self._pointed(*there[:3]).along[-1] <= 0.0))
            if place.push <= 0.0:
                between.append(self._first(last, step, lambda there: there.push <= 0.0))
            for _, there in sorted(between, key=lambda found: found[0]):
                places.append(there._replace(inverse=_NONE))
                if there.push <= 0.0:
                    return
            places.append(place)
            if renewals <= FEW:
                step = min(LONGEST, 2.0 * step)
        raise SolverError(f"{FOLLOWED} {MOST_POINTS} points, up to {self._shown(places[-1])}")

    def _shown(self, place: Balanced) -> str:
        size, unit = push_unit(self.loads is not None)
        return f"{place.push / size:.5g} {unit}"

    def _round(self, last: Balanced) -> Balanced:
        """Return the point with the tangent of the curve behind a corner, where a narrow strip has just opened.

        The derivatives are taken a little further on, with the rotations and openings as they change before it. Raises
        SolverError if the curve continues nowhere.
        """
        moves = last.along * self._scale
        moves[-1] = 0.0
        moves /= np.max(np.abs(moves) / self._opens)
        for part in BEYOND:
            try:
                beyond = self._pointed(last.q + part * moves[:-1], last.push, last.along)
                ahead = beyond.along * math.copysign(1.0, float(np.sum((beyond.along * last.along)[:-1])))
                if float(np.sum(self._weight * ahead * last.along)) >= TURN:
                    continue
                rounded = last._replace(along=ahead, inverse=_inverse(self._matrix(beyond.q, beyond.push, ahead)))
                self._step(rounded, CORNER)
            except _LostError:
                continue
            return rounded
        raise SolverError(f"no balance is found beyond {self._shown(last)}")

    def _step(self, last: Balanced, step: float) -> tuple[Balanced, int]:
        """Return the point one step further along the curve, and the number of renewals of derivatives.

        Raises _LostError.
        """
        q, push, renewals = self._after_step(last, step)
        place = self._pointed(q, push, last.along)
        if float(np.sum(self._weight * place.along * last.along)) < TURN:
            raise _LostError
        return place, renewals

    def _after_step(self, last: Balanced, step: float) -> tuple[FloatArray, float, int]:
        change = step * last.along * self._scale
        return self._onto(last.q + change[:-1], last.push + float(change[-1]), last, step)

    def _first(self, last: Balanced, step: float, passed: Callable[[Balanced], bool]) -> tuple[float, Balanced]:
        """Return the distance from `last`, within the step, of the first point at which `passed` holds, and that point.

        Raises SolverError if the curve is lost on the way.
        """
        low, high = 0.0, step
        try:
            # bisection on the step length
            while high - low > NARROWED * step:
                middle = 0.5 * (low + high)
                q, push, _ = self._after_step(last, middle)
                if passed(Balanced(q, push, last.along, _NONE)):
                    high = middle
                else:
                    low = middle
            return high, self._step(last, high)[0]
        except _LostError:
            raise SolverError(f"no balance is found beyond {self._shown(last)}") from None

    def _onto(self, q: FloatArray, push: float, last: Balanced, most: float) -> tuple[FloatArray, float, int]:
        """Move onto the curve by Newton's method, normal to the tangent at `last`, by at most `most`.

        It begins with the derivatives at `last` and returns coordinates, push and the number of renewals of
        derivatives. Raises _LostError.
        """
        inverse, renewals, before, near = last.inverse, 0, math.inf, False
        for _ in range(ITERATIONS):
            moved = inverse[:, :-1] @ -self._unbalanced(q, push)
            if not self._length(moved) <= max(most, NEAR):
                raise _LostError
            change = moved * self._scale
            q, push = q + change[:-1], push + float(change[-1])
            size = float(np.max(np.abs(change) / self._opens))
            # converged
            if size < self._converged:
                return q, push, renewals
            # slow: renew the derivatives, or accept the rounding error
            if size > SLOW * before:
                if near and size < ROUNDED:
                    self._converged = min(ROUNDED, 3.0 * size)
                    return q, push, renewals
                near = size < ROUNDED
                inverse, renewals, size = _inverse(self._matrix(q, push, last.along)), renewals + 1, math.inf
            before = size
        raise _LostError

    def _pointed(self, q: FloatArray, push: float, along: FloatArray) -> Balanced:
        """Return the point with its tangent, in the sense of `along`, and its derivatives."""
        matrix = self._matrix(q, push, along)
        ahead = _inverse(matrix)[:, -1]
        ahead = ahead / self._length(ahead)
        matrix[-1] = self._weight * ahead
        return Balanced(q, push, ahead, _inverse(matrix))

    def _length(self, moved: FloatArray) -> float:
        return math.sqrt(float(np.sum(self._weight * moved * moved)))

    def row(self, place: Balanced) -> Any:
        """Return all outputs at a point, as `StillColumn.row`."""
        return self.still.row(place.q, self._pushed(place.push))

    def _pushed(self, push: float) -> float:
        """Apply a push to the ports and return 0, or return the acceleration of the base that it is (m/s2)."""
        if self.loads is None:
            return -self.direction * push
        self.still.loads = self.direction * push * self.loads
        return 0.0

    def _unbalanced(self, q: FloatArray, push: float) -> FloatArray:
        return self.still.accelerations(q, self._pushed(push))

    def _matrix(self, q: FloatArray, push: float, along: FloatArray) -> FloatArray:
        """Return the derivatives of the accelerations by the scaled unknowns; the last row is the tangent."""
        n = 2 * self.n
        matrix = np.empty((n + 1, n + 1))
        matrix[:n, :n] = -self.still.stiffness(q, PART, self._pushed(push)) * self._scale[:-1]
        matrix[:n, n] = self._unbalanced(q, self._scale[-1]) - self._unbalanced(q, 0.0)
        matrix[n] = self._weight * along
        return matrix

    def _opened(self, place: Balanced) -> NDArray[np.bool_]:
        """Return the mask of joints that are not in full contact, (n,)."""
        joints = self.row(place).joints
        return np.asarray(joints.contact < 1.0)

    def _joint_opened(self, i: int, place: Balanced) -> bool:
        return bool(self._opened(place)[i])


def _least_factor(still: StillColumn, loads: FloatArray) -> float:
    """Return the least factor at which loads turn a part of the column about an edge, or equal its weight."""
    blocks, column = still.blocks, still.column
    x, z, couples = loads.reshape(3, -1)
    foot, weight, least = 0.0, column.g * float(np.sum(blocks.mass)), math.inf
    # moment about the joint under block i
    for i in range(still.n - 1, -1, -1):
        turning, place = 0.0, foot
        for k in range(i, -1, -1):
            for p, port in enumerate(column.ports):
                if port.body == k:
                    up = place - foot + float(blocks.centroid[k]) + port.at[1]
                    turning += couples[p] + up * x[p] - port.at[0] * z[p]
            place += float(blocks.height[k])
        if turning:
            least = min(least, 0.5 * weight * float(blocks.width[i]) / abs(turning))
        weight -= column.g * float(blocks.mass[i])
        foot += float(blocks.height[i])
    return min(least, column.g * float(np.sum(blocks.mass)) / max(1e-300, float(np.sum(np.abs(z)))))


def _slenderness(still: StillColumn) -> float:
    """Return the least ratio, over the joints, of half the joint's width to the height of the centroid above it."""
    blocks, carried, height, least = still.blocks, 0.0, 0.0, math.inf
    for i in range(still.n):
        own = blocks.mass[i]
        height = (carried * (height + blocks.height[i]) + own * blocks.centroid[i]) / (carried + own)
        carried += own
        least = min(least, 0.5 * blocks.width[i] / height)
    return float(least)


def _inverse(matrix: FloatArray) -> FloatArray:
    """Return the inverse, used many times: no factorization is faster for matrices of this size.

    Raises _LostError if the matrix is singular.
    """
    try:
        found = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        raise _LostError from None
    return np.asarray(found, dtype=np.float64)
