"""The path of equilibria of a structure under a push that grows: a steady acceleration of its base, or loads on ports.

Equilibrium is 6 n equations for 6 n coordinates and the push. The path is followed by its arc length, in displacements
and push together: a step extrapolates along the last one, and Newton's method returns to the path in the hyperplane
normal to it. So a joint that slides under a constant push, and the largest push, are regular points. Sliding joints
and yielding ties remember each point that the path reaches.
"""

from __future__ import annotations

import math
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.errors import InputError
from ...ground.loads import push_unit
from ...ground.motion import STANDARD_GRAVITY
from ...kernels.structure.layout import JOINED_GAP, KEEP, LOAD, PRESUME
from ..outputs import places_of
from .blocks.faces import FloatArray
from .model import Structure
from .outputs import OUTPUTS
from .rest import (
    change_between,
    closed,
    deltas_of,
    full_stiffness,
    largest_of,
    move,
    residual_of,
    rest_in_steps,
    rest_of,
    settle,
)
from .stepper import SpatialStepper

FIRST = 0.1  # of g: unit of pushes along the path; unit of displacements: those it causes at rest
STEP, SHORTEST = 0.1, 1e-10  # first and least step in these units
GROWTH = 0.2  # of the length of the path so far: longest step
LARGEST = 10.0  # of g: push at which the path ends
MOST_PLACES = 2000
ITERATIONS = 8  # of Newton's method for a point of the path
BREAKS = 30  # times that bonds may break, and pairs meet, at a point before the rest of them balances it
CLOSE, ROUGH = 1e-10, 1e-7  # of the weight: residual; at most, where rounding limits it
# differences for the tangent, of a step, and at least of the displacement. In larger ones joints that bear hardly any
# load stick on one side and slide on the other, and Newton's method is slow; smaller ones are lost in rounding
DIFFERENCE, ROUNDED = 1e-5, 1e-9
NARROWED = 1e-4  # of a step: width to which the onset of opening, sliding or a falling push is bracketed
LEAST_GROWTH = 1e-9  # of the push: least increase in a step that counts as growth
GROWN = 1e-6  # of the push: growth that counts where short steps have none
SUNK = 1e-7  # of the push: fall in many short steps, each of which hides in rounding, after which the path ends
SHORT = 1e-6  # step that is short there; longer ones while a joint slides may fall by rounding
NOISE = 1e-8  # unit of pushes: rounding of a push, some times the residual
MOST_DOUBLED = 60  # times, from the shortest step on
# of the push: increases, one after the other, over a place where something breaks or slips at once; of the displacement
# within which joints stay closed: differences for the tangent there
NUDGED, FINE = (1e-4, 4e-4, 1.6e-3, 6.4e-3), (0.01, 1.0)
NO_ROOM_LEFT = "a contact had no room for all its corners and bore nothing: its faces are not convex, or have too many"
FAR = 0.01  # of the largest block: displacement within which it is sought
REFINED = 4  # secants to the push at which a path ends, of a step that its bracket has made short
MOST_SOUGHT = 40  # steps of a bracket: more than halving takes, unless rounding made its event
PACE = 2.0  # a gap may close so many times faster later on, as its bodies turn
MOST_FALLEN, OF_BLOCKS = 200, 2400  # places beyond a largest push, on the way to what may bear there; times blocks
STEEP = 1e-3  # part of the push in a step, in these units, above which it counts as growing however short the step
FALLS = "beyond it the push falls, or does not grow"
FELL = "beyond it the push falls, as far as it was followed"
LOST = "no balance is found beyond it"
FURTHER, FOLLOWED = "it was not pushed further than", "the path was not followed further than"
TURN, RESOLVED = 0.9, 1e-7  # least cosine of the angle between consecutive steps; steps whose direction is no rounding
OPEN, SLID = 1e-9, 1e-9  # of the contact, of the largest displacement: above it a joint is open, or has slid
BORNE = 1e-6  # of the weight: a joint with a smaller normal force at rest bears nothing
# a bond breaks suddenly if that leaves a larger residual, of the weight; loss of its share that counts between places
SUDDEN, LOSES = 1e-3, 1e-3


def has_opened(contact: FloatArray, at_rest: FloatArray) -> NDArray[np.bool_]:
    """Return the mask of joints, closed at rest, that are partly open."""
    return (at_rest >= 1.0 - OPEN) & (contact < 1.0 - OPEN)


def has_slid(slip: FloatArray, contact: FloatArray, moved: FloatArray) -> NDArray[np.bool_]:
    """Return the mask of joints in contact that have slid, by their slip and the largest displacement (m)."""
    return (np.abs(slip) > SLID * moved) & (contact > OPEN)


def bears_at_rest(normal: FloatArray, weight: float) -> NDArray[np.bool_]:
    """Return the mask of joints with a normal force at rest (N); head joints of a wall open or slide at any push."""
    return np.abs(normal) > BORNE * weight


class Place(NamedTuple):
    push: float  # m/s2
    row: FloatArray
    phase: FloatArray  # including the values that joints, ties and pairs remember
    ahead: FloatArray  # (6 n + 1,), direction of the path in the measure
    step: float  # from the place before, along the path
    secant: FloatArray  # direction from the place before: not changed by the tangents of pairs that hardly touch
    jumped: bool = False  # whether a bond has broken suddenly since the place before


class _EventFlags(NamedTuple):
    """The events sought along the path."""

    grows: bool  # the push
    opened: bool  # some joint
    slid: bool
    beyond: bool  # the capacity of a bearing
    reached: bool  # the push at which the path ends
    jumped: bool  # over a bond that breaks suddenly


def rest_under(structure: Structure, loads: FloatArray) -> FloatArray:
    """Return the phase at rest under loads on the ports, (6, ports) N and N m. Raises InputError if they overturn it.

    The loads are applied in a few steps, or along the path of equilibria where Newton's method needs it.
    """
    found = rest_in_steps(structure, loads)
    if found is None and structure.weight > 0.0:
        path = EquilibriumPath(structure, np.zeros(3), loads, 1.0)
        if path.follow().startswith(FURTHER):
            found = path.last().phase
    if found is None:
        raise InputError(f"release: {structure.name} has no rest under this load, it must balance it")
    return found


class EquilibriumPath:
    """The path of equilibria of one structure pushed along the vector `way`, (3,), or by loads on its ports.

    It ends at the push `largest` (m/s2, or times the loads), at 10 g without one. It also goes on where the push falls,
    if the structure comes to bear there on what a crack has left or, without `largest`, on a slack tie, a neighbour or
    the ring of a bearing: the places from the largest push to the one at which the push exceeds it again are left out.
    """

    def __init__(
        self, structure: Structure, way: FloatArray, loads: FloatArray | None = None, largest: float = math.inf
    ) -> None:
        rest = rest_of(structure)
        self.stepper, self.way = SpatialStepper(structure), way
        self.stepper.phase[:] = rest.phase
        n = structure.n
        self.per = deltas_of(structure, 1.0)  # converts displacements to rotations by the size of the block
        self.weight, self.close = structure.weight, closed(structure)
        self.breaks = bool(structure.bonds or structure.neighbours)
        masses = np.array([block.mass for block in structure.blocks])
        self.load = np.concatenate([masses[:, None] * way, np.zeros((n, 3))], axis=1).ravel()  # of a push of 1 m/s2
        self.loads, first = loads, FIRST * STANDARD_GRAVITY
        if loads is not None:
            self.load, parts = np.zeros(6 * n), loads.T
            for port, part in zip(structure.ports, parts, strict=True):
                self.load[6 * port.body :][:6] += [*part[:3], *(part[3:] + np.cross(port.at, part[:3]))]
            # a factor that pushes as much as that acceleration
            first *= self.weight / structure.g / largest_of(self.load, self.per)
        self.may_jump = largest == math.inf
        self.largest = LARGEST / FIRST * first if self.may_jump else largest
        # units of displacements and of the push; initial direction
        linear = np.linalg.solve(rest.stiffness, first * self.load)
        self.noise = NOISE * first
        self.unit = float(np.linalg.norm(linear / self.per)) * self.per, first
        ahead = np.append(linear / self.unit[0], 1.0)
        ahead /= np.linalg.norm(ahead)
        places = places_of(OUTPUTS, structure.sizes)
        self.contact, self.slip, self.moved = places["contact"], places["slip"], places["d"]
        self.bears = bears_at_rest(rest.row[places["N"]], structure.weight)
        self.tie, self.gap, self.bond = places["tie"], places["gap"], places["bond"]
        bearings = [joint.bearing for joint in structure.bearings]
        self.capacity = np.array([math.inf if bearing is None else bearing.capacity for bearing in bearings])
        self.ring = np.array([math.inf if bearing is None else bearing.ring for bearing in bearings])
        self.places = [Place(0.0, rest.row.copy(), rest.phase.copy(), ahead, 0.0, ahead)]
        self.jumps: list[float] = []  # pushes beyond which places are left out, or a bond breaks suddenly

    def follow(self) -> str:
        """Add the points up to the largest push; return the reason why the path ends."""
        seen = _EventFlags(True, False, False, False, False, False)
        step, gone, narrow, seeking, sought, lost = STEP, 0.0, 0.0, False, 0, 0
        while len(self.places) < MOST_PLACES:
            last = self.places[-1]
            place = self._next(last, step)
            if place is None:
                step *= 0.5
                if step >= SHORTEST:
                    continue
                place = self._beside(last, lost)
                if place is None:
                    return LOST
                self._add(place)
                step, narrow, seeking, lost = STEP, 0.0, False, lost + 1
                continue
            now = self._seen(place, last, seen)
            turns = step > RESOLVED and float(place.secant @ last.secant) < TURN
            if (now != seen or turns) and step > narrow:  # bracket the onset by halving the step
                narrow, seeking = narrow or NARROWED * step, seeking or now != seen
                step *= 0.5
                continue
            if now.beyond:
                return self._beyond(place)
            falls = self._falls(place, last)
            if not falls and self._has_sunk(place):
                place = self._beside_largest(lost)
                if place is None:
                    return FALLS
                self._add(place)
                step, narrow, seeking, lost = STEP, 0.0, False, lost + 1
                continue
            if now.reached:
                self._add(place)
                size, unit = push_unit(self.loads is not None)
                return f"{FURTHER} {self.largest / size:.5g} {unit}"
            # growth that is lost in the rounding of short steps
            sought = sought + 1 if seeking else 0
            is_lost = not now.grows or sought > MOST_SOUGHT
            longer = 0.0 if falls else self._growing_step(place, step) if is_lost else step
            if not falls:
                self._add(place)
            if not longer:
                beyond = self._regained(last, place, gone)
                if isinstance(beyond, str):
                    return beyond
                self._add(beyond._replace(jumped=True))
                step, narrow, seeking, lost = beyond.step or STEP, 0.0, False, 0
                continue
            lost = 0
            if is_lost:
                step, seeking, now = longer, False, now._replace(grows=True)
            if now != seen or not seeking:
                narrow, seeking = 0.0, False
            seen = now._replace(jumped=False)
            gone += step
            if not seeking:
                step = min(2.0 * step, max(STEP, GROWTH * gone))
        return f"{FOLLOWED} {MOST_PLACES} places"

    def _add(self, place: Place) -> None:
        """Add a place, and the push before it if the path jumps to it."""
        if place.jumped:
            self.jumps.append(self.places[-1].push)
        self.places.append(place)

    def _regained(self, last: Place, place: Place, gone: float) -> Place | str:
        """Return a place beyond one whose push does not grow, at which it exceeds the largest push so far.

        If there is none, return the reason: nothing is left that may come to bear, or before it does the structure
        balances without push, has moved by its size or leaves a bearing. last: the place before that one; gone: the
        length of the path so far.
        """
        largest, step, lost = self.places[-1].push, place.step, 0
        for _ in range(min(MOST_FALLEN, OF_BLOCKS // self.stepper.structure.n)):
            if self._exceeds(place, largest):
                return place
            ended = place.push <= 0.0 or bool(np.any(place.row[self.moved] > self.capacity))
            if ended or self._distance(place.row, last.row) > 1.0 or not self._may_bear(place, last):
                return FALLS
            beyond, bends = self._beyond_bend(place, step, GROWTH * max(largest, self.unit[1]))
            if beyond is None:
                beyond, lost, step = self._beside(place, lost), lost + 1, STEP
                if beyond is None:
                    return FELL
            else:
                gone, lost = 0.0 if bends else gone + beyond.step, 0
                step = min(2.0 * beyond.step, max(STEP, GROWTH * gone))
            place = beyond
        return FELL

    def _beyond_bend(self, place: Place, step: float, most: float) -> tuple[Place | None, bool]:
        """Return a point of the path beyond a place, and True if a sharp bend is between, where something bears.

        The step to it is halved until the push grows by at most `most`, and a bend is bracketed.
        """
        narrow = 0.0
        while step >= SHORTEST:
            found = self._next(place, step)
            if found is not None and found.push <= place.push + most:
                bends = step > RESOLVED and float(found.secant @ place.secant) < TURN
                if not bends or step <= narrow:
                    return found, narrow > 0.0
                narrow = narrow or NARROWED * step
            step *= 0.5
        return None, False

    def _exceeds(self, place: Place, push: float) -> bool:
        """Return True if the push of a place is more than another one by more than rounding."""
        return place.push > push * (1.0 + GROWN) + 10.0 * self.noise

    def _may_bear(self, place: Place, last: Place) -> bool:
        """Return True if a tie slack at the last place, a gap or a ring that closes, or a bond that breaks, may bear.

        A gap counts if at this pace it closes before the structure has moved by some times its size; a bond if it has
        broken further: what is left of it, and the edge it leans on, may bear more.
        """
        row, before, gap, moved = place.row, last.row, self.gap, self.moved
        apart = (before[gap] > 0.0) & (before[gap] < JOINED_GAP) & (row[gap] < before[gap])
        apart &= row[gap] * self._distance(row, before) <= PACE * (before[gap] - row[gap])
        inside = (before[moved] < self.ring) & (self.ring < math.inf) & (row[moved] > before[moved])
        bears = np.any(before[self.tie] == 0.0) or np.any(apart) or np.any(inside)
        return (self.may_jump and bool(bears)) or bool(np.any(row[self.bond] < before[self.bond]))

    def _beside(self, last: Place, lost: int) -> Place | None:
        """Return a balance near a place, under a push that is hardly larger, after what breaks or slips there.

        lost: the number of such balances in a row; each is sought under a larger increase of the push. None if there is
        none within a small part of the largest block. The path goes on along the secant.
        """
        stepper, linear = self.stepper, full_stiffness(self.stepper.structure)
        for nudged, fine in product(NUDGED[lost:], FINE):
            push = last.push + nudged * max(last.push, self.unit[1])
            stepper.phase[:] = last.phase
            delta, base = fine * self.close * self.per, self._push(push)
            found = settle(stepper, linear, delta, CLOSE * self.weight, base)
            if found and self._distance(stepper.row, last.row) <= FAR:
                secant, breaks = self._secant(last, push), self._breaks(last)
                return Place(push, stepper.row.copy(), stepper.phase.copy(), secant, 0.0, secant, breaks)
        return None

    def _breaks(self, last: Place) -> bool:
        """Return True if a bond has lost a share of its area since a place."""
        return bool(np.any(self.stepper.row[self.bond] < last.row[self.bond] - LOSES))

    def _secant(self, last: Place, push: float) -> FloatArray:
        """Return the direction from a place to the present phase, under a push."""
        moved = change_between(last.phase, self.stepper.phase, self.stepper.structure.n)
        secant = np.append(moved / self.unit[0], (push - last.push) / self.unit[1])
        return (secant / np.linalg.norm(secant)).astype(np.float64)

    def last(self) -> Place:
        """Return the place whose push is the largest one that is looked for, beside the last but one."""
        before, place = self.places[-2:]
        for _ in range(REFINED):
            step = place.step * (self.largest - before.push) / (place.push - before.push)
            place = self._next(before, step) or place
        return place

    def _growing_step(self, place: Place, step: float) -> float:
        """Return the step beyond a place in which the push grows by more than rounding; 0 if it does not.

        A slender tie that holds sliding blocks of stiff joints lets it grow, but not in short steps.
        """
        begin = place
        for _ in range(MOST_DOUBLED):
            beyond = self._next(place, step)
            if beyond is not None:
                if self._falls(beyond, begin):
                    break
                if self._exceeds(beyond, begin.push):
                    return step
                if self._distance(beyond.row, begin.row) > FAR:
                    break
                place = beyond
            step *= 2.0
        return 0.0

    def _distance(self, row: FloatArray, other: FloatArray) -> float:
        """Return the largest displacement of a block between two output rows, over the size of the largest block."""
        blocks = self.stepper.structure.blocks
        moved = np.abs(row[: 3 * len(blocks)] - other[: 3 * len(blocks)])
        return float(np.max(moved)) / max(block.size for block in blocks)

    def _falls(self, place: Place, last: Place) -> bool:
        """Return True if the push is less than that of the last place by more than rounding."""
        return place.push < last.push * (1.0 - LEAST_GROWTH) - self.noise

    def _has_sunk(self, place: Place) -> bool:
        """Return True if the push is less than the largest one so far by more than rounding, after short steps."""
        if place.step >= SHORT:
            return False
        return place.push < max(one.push for one in self.places) * (1.0 - SUNK) - 10.0 * self.noise

    def _beside_largest(self, lost: int) -> Place | None:
        """Leave out the places after that of the largest push, and return a balance beside that one, as `_beside`."""
        pushes = [one.push for one in self.places]
        del self.places[int(np.argmax(pushes)) + 1 :]
        return self._beside(self.places[-1], lost)

    def _seen(self, place: Place, last: Place, before: _EventFlags) -> _EventFlags:
        rest, row = self.places[0].row, place.row
        contact, slip, moved = self.contact, self.slip, slice(0, 3 * self.stepper.structure.n)
        largest, bears = np.max(np.abs(row[moved] - rest[moved])), self.bears
        # the tangent alone is steep again where something has just broken
        least = 0.0 if place.push > last.push * (1.0 + LEAST_GROWTH) else STEEP
        return _EventFlags(
            place.ahead[-1] > least and not self._falls(place, last),
            before.opened or bool(np.any(bears & has_opened(row[contact], rest[contact]))),
            before.slid or bool(np.any(bears & has_slid(row[slip] - rest[slip], row[contact], largest))),
            bool(np.any(row[self.moved] > self.capacity)),
            place.push >= self.largest,
            place.jumped,
        )

    def _beyond(self, place: Place) -> str:
        """Return the reason why the path ends before a place where a bearing has moved further than it allows."""
        b = int(np.argmax(place.row[self.moved] / self.capacity))
        size, unit = push_unit(self.loads is not None)
        name, capacity, push = self.stepper.structure.bearing_names[b], self.capacity[b], self.places[-1].push
        return f"{name} has moved by the {1e3 * capacity:.4g} mm that it allows at {push / size:.5g} {unit}"

    def _push(self, push: float) -> FloatArray:
        """Apply a push to the ports, or return the equivalent acceleration of the base, m/s2."""
        if self.loads is None:
            return -push * self.way
        for name, row in zip(LOAD, self.loads, strict=True):
            getattr(self.stepper.pushes, name)[:] = push * row
        return np.zeros(3)

    def _remember(self, push: float) -> None:
        """Let joints, ties and bonds remember the present state, and fill the output row."""
        ax, ay, az = self._push(push)
        self.stepper.observe(ax, ay, az, keep=KEEP)

    def _residual(self, push: float) -> FloatArray:
        residual, _ = residual_of(self.stepper, self._push(push))
        return residual

    def _size(self, residual: FloatArray) -> float:
        """Return the largest component of a residual, as a force over the weight."""
        return largest_of(residual, self.per) / self.weight

    def _next(self, last: Place, step: float) -> Place | None:
        """Return the point one step further along the path; None if Newton's method does not converge."""
        stepper, (lengths, first), size = self.stepper, self.unit, len(self.load)
        # tangent bordered by the direction of the last step; predictor
        matrix = np.empty((size + 1, size + 1))
        matrix[size, :size], matrix[size, size] = last.ahead[:-1] / lengths, last.ahead[-1] / first
        matrix[:size, size] = -self.load
        stepper.phase[:] = last.phase
        push = last.push + step * float(last.ahead[-1]) * first
        if stepper.structure.neighbours:
            stepper.observe(keep=PRESUME)
        move(stepper, step * lengths * last.ahead[:-1])
        most = float(np.max(np.abs(last.phase[: size // 2])))
        delta = max(min(DIFFERENCE * abs(step) * float(lengths[0]), self.close), ROUNDED * most) * self.per
        # Newton's method, then the direction of the path at the new point
        iterations, rounds, left, right, jumped = 0, 0, math.inf, np.zeros(size + 1), False
        while True:
            right[:size], before = self._residual(push), left
            left = self._size(right[:size])
            arrived = left <= CLOSE or (left <= ROUGH and left > 0.3 * before)
            # before they remember it: the tangent is that of joints that slide and of cracks that spread
            matrix[:size, :size] = stepper.stiffness(delta)
            if arrived and self.breaks:  # bonds that break and pairs that meet here leave it without balance
                self._remember(push)
                if (after := self._size(self._residual(push))) > ROUGH:
                    left, iterations, rounds = math.inf, 0, rounds + 1
                    jumped = jumped or (after > SUDDEN and self._breaks(last))
                    if rounds > BREAKS:
                        return None
                    continue
            if arrived:
                right[:size], right[size] = 0.0, 1.0
            try:
                change = np.linalg.solve(matrix, right)
            except np.linalg.LinAlgError:
                return None
            scaled = change / np.append(lengths, first)
            if arrived:
                break
            iterations += 1
            if iterations > ITERATIONS or not np.linalg.norm(scaled) <= abs(step):
                return None
            push += float(change[-1])
            move(stepper, np.asarray(change[:-1], dtype=np.float64))
        self._remember(push)
        ahead, secant = scaled / np.linalg.norm(scaled), self._secant(last, push)
        return Place(push, stepper.row.copy(), stepper.phase.copy(), ahead, step, secant, jumped)
