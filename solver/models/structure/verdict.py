"""Criteria by which a structure on a still base can no longer fall (theory.md section 14).

A rest is sought with the present slips, from the first rest and from the present state. The structure is in the well
of that rest if none of its joints is rotated or displaced beyond its edge, or if the straight path to the rest needs no
more energy than the structure has: on a still base its energy does not grow. It stands for good if its energy above
that rest is less than a fraction of the barrier of the well, the least energy that brings a joint to its edge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...kernels.structure import layout as at
from ..outputs import places_of
from .blocks.contacts import is_endless
from .blocks.faces import Face, FloatArray, outward_normals
from .blocks.parts import LEVEL, SpatialJoint, trees_of
from .blocks.shapes import rotated
from .model import Structure
from .outputs import OUTPUTS
from .packing import centroid_of
from .rest import PERTURBED, balance, deltas_of, full_stiffness, move, rest_of, sticking, weights
from .stepper import SpatialStepper

IN_A_WELL = "its energy does not suffice to fall"
RESTING = "it has come to rest"
SAFE = 0.75  # of the barrier: largest energy of a structure that counts as standing
FIRST_LOOK, LATER = 0.25, 0.25  # s after the motion; fraction of the time since then until the next look
CLOSE = 1e-9  # of the weight: residual at a rest
WAY = 8  # parts of the path to the rest
UPRIGHT = 0.95  # least vertical part of the normal of a joint over whose edge its load is lifted
HARDLY, OF_BLOCK = 1e-3, 0.1  # of the weight, and of the lighter block's: a joint with a smaller force is neglected
LEAST_STIFFNESS = 1e-200  # N m, of one bearing against rotation, which has none
STILL = 1e-6  # of gravity, and of sqrt(g size): largest acceleration and velocity of a block that is still
DIRECTIONS = 8  # directions in which the resultant of a round joint may reach its rim


def next_look(since: float, settle: float) -> float:
    """Return when to check next whether a structure may still fall, s after the motion; at most `settle`.

    since: time of the present check, s after the motion.
    """
    return min(settle, FIRST_LOOK + (1.0 + LATER) * since)


def reason_for_leaning(stepper: SpatialStepper) -> str:
    """Return the reason why a still structure that leans on neighbours stays as it is; "" if it moves or leans on none.

    A block that leans on another one is beyond its edge, so no energy bounds its fall. It stays because forces balance
    and damping has taken all motion.
    """
    structure, see = stepper.structure, stepper.see
    if not structure.neighbours:
        return ""
    stepper.observe()
    pressed = np.flatnonzero(_field(stepper, "hit") > 0.0).tolist()
    # velocities and accelerations, rotations times the size of the block
    rates, size = at.PHASE.see(stepper.rates, structure.n), np.array([block.size for block in structure.blocks])
    moved = np.hypot(_size_of(see.vx, see.vy, see.vz), size * _size_of(see.wx, see.wy, see.wz))
    begins = np.hypot(_size_of(rates.vx, rates.vy, rates.vz), size * _size_of(rates.wx, rates.wy, rates.wz))
    still = np.all(moved <= STILL * np.sqrt(structure.g * size)) and np.all(begins <= STILL * structure.g)
    if not pressed or not still:
        return ""
    # of each pair the more tilted block leans
    tilt, found = np.append(np.hypot(see.q1, see.q2), -1.0), []
    for pair in (structure.neighbours[p] for p in pressed):
        leaning, other = sorted((pair.one, pair.other), key=lambda i: -tilt[i])
        against = f"wall {pair.wall}" if pair.wall else structure.names[other]
        found.append(f"{structure.names[leaning]} rests against {against}")
    return f"{RESTING}: {', '.join(dict.fromkeys(found))}"


def _size_of(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Return the lengths of vectors, (n,)."""
    return np.sqrt(x * x + y * y + z * z)


@lru_cache(maxsize=64)
def potential_well_of(structure: Structure) -> Well:
    """Return the well of a structure, cached."""
    return Well(structure)


class Well:
    """The rests that one structure may come to, and the energy barriers around them."""

    def __init__(self, structure: Structure) -> None:
        self._structure = structure
        if not structure.weight > 0.0:
            return
        self._linear = full_stiffness(structure)
        settlement = float(np.max(np.abs(np.linalg.solve(self._linear, weights(structure)))))
        self._delta = PERTURBED * deltas_of(structure, settlement)
        self._small = 0.5 * PERTURBED**2 * structure.weight * settlement  # J, of displacements of this size
        self._heights = _heights(structure)
        masses = np.array([*(block.mass for block in structure.blocks), math.inf])  # the base is the last body
        lighter = np.array([min(masses[joint.upper], masses[joint.lower]) for joint in structure.joints])
        self._hardly = np.minimum(HARDLY * structure.weight, OF_BLOCK * structure.g * lighter)
        self._groups = _groups(structure)
        self._alone = ~_bypassed(structure, ties=True)
        self._framed = _bypassed(structure)  # other joints bypass it, not only ties
        self._hangs = _hangs(structure)
        self._upright = np.array([abs(joint.face.normal[2]) >= UPRIGHT for joint in structure.joints])
        self._between, self._against_turns = _against_turns(structure)
        self._uppers = np.array([joint.carried(structure.n) for joint in structure.joints], dtype=np.int64)
        self._lowers = np.array([joint.carrier(structure.n) for joint in structure.joints], dtype=np.int64)
        upright = [j for j in np.flatnonzero(self._upright).tolist() if self._uppers[j] < structure.n]
        upright.sort(key=lambda j: float(structure.joints[j].face.centre[2]))
        self._rising = [(j, int(self._uppers[j]), int(self._lowers[j])) for j in upright]
        stepper = SpatialStepper(structure)
        stepper.phase[:] = rest_of(structure).phase
        stepper.observe()
        self._highest = self._lifting(stepper, 0.0)  # estimate of the barrier of any rest, without slips

    def why_it_stands(self, stepper: SpatialStepper) -> str:
        """Return the reason why a structure can no longer fall from the phase of its stepper; "" if it may."""
        structure = self._structure
        if not structure.weight > 0.0:
            return ""
        energy = stepper.observe()
        still = _stopped(stepper)
        if not self._holds(energy - still.observe(), self._highest):  # the kinetic energy alone is too large
            return ""
        return next((IN_A_WELL for rest in self._rests(still) if self._keeps(rest, still, energy)), "")

    def _rests(self, stepper: SpatialStepper) -> Iterator[SpatialStepper]:
        """Yield the rests that a structure without velocities may come to."""
        found = _stopped(stepper)
        coordinates = at.PHASE.size(self._structure.n)
        found.phase[:coordinates] = rest_of(self._structure).phase[:coordinates]
        for begin in (found, _stopped(stepper)):
            if self.comes_to_rest(begin):
                self._give_way(begin)
                yield begin

    def _give_way(self, rest: SpatialStepper) -> None:
        """Move the sliders of bearings as far as their force allows: the energy would count the whole elastic slip.

        A pendulum or rubber that returns to the middle leaves its slider behind.
        """
        structure, m = self._structure, len(self._structure.joints) - len(self._structure.bearings)
        rest.observe()
        normal, dx, dy = (_field(rest, name) for name in ("N", "dx", "dy"))
        for b, joint in enumerate(structure.bearings):
            bears, along = _slider(joint, float(normal[m + b]))
            elastic = np.array([dx[b], dy[b]]) - _slip(rest, m + b)
            force = along * float(np.hypot(*elastic))
            if force > bears:
                slip = _slip(rest, m + b) + (1.0 - bears / force) * elastic
                rest.slips.p1[m + b], rest.slips.p2[m + b] = slip

    def _keeps(self, rest: SpatialStepper, place: SpatialStepper, energy: float) -> bool:
        """Return True if a structure in the state `place` with this energy (J) cannot leave the well of a rest."""
        left = energy - rest.observe()
        tangent = sticking(rest).stiffness(self._delta)
        # a rest far above the state is not that of its well
        if not _is_stable(tangent) or not self._holds(abs(left), self.barrier(rest, tangent, max(0.0, left))):
            return False
        return self._is_within(place, rest) or self._leads_to(rest, place.phase, energy)

    def comes_to_rest(self, stepper: SpatialStepper) -> bool:
        """Move a stepper without velocities to a rest with its present slips; return True if there is one.

        First all joints stick, because then Newton's method has a potential; sliding joints have no useful tangent.
        """
        begin, arguments = stepper.phase.copy(), (self._linear, self._delta, CLOSE * self._structure.weight)
        if not balance(sticking(stepper), *arguments):
            stepper.phase[:] = begin
        return balance(stepper, *arguments)

    def barrier(self, rest: SpatialStepper, stiffness: FloatArray, left: float = 0.0) -> float:
        """Return the least energy above a rest (J) with which the structure may begin to fall.

        `stiffness` is the tangent at that rest, (6 n, 6 n); friction may still dissipate the energy `left` by slips, J.
        """
        least = min(self._lifting(rest, left), self._bending(rest, stiffness), self._coming_off(rest))
        return least if math.isfinite(least) else 0.0  # no bound is known if only ties hold it

    def _holds(self, left: float, barrier: float) -> bool:
        """Return True if an energy above a rest (J) is below the fraction SAFE of a barrier.

        The energy of displacements as small as the differences for tangents is disregarded.
        """
        return left <= SAFE * barrier + self._small

    def _leads_to(self, rest: SpatialStepper, begin: FloatArray, energy: float) -> bool:
        """Return True if no sampled state on the straight path from a phase to a rest has more than this energy (J)."""
        n, way = self._structure.n, rest.over(state=rest.arrays.state.copy())
        for part in np.arange(1, WAY) / WAY:
            way.phase[:] = (1.0 - part) * begin + part * rest.phase
            turns = way.phase[_place("q0", n) : _place("vx", n)].reshape(4, n)
            turns /= np.linalg.norm(turns, axis=0)
            if way.observe() > energy + self._small:
                return False
        return True

    def _is_within(self, place: SpatialStepper, rest: SpatialStepper) -> bool:
        """Return True if no joint is tilted or displaced as far as needed to fall over its edge.

        False for an arch: its mechanism falls before that.
        """
        structure, n = self._structure, self._structure.n
        moments, normal = self._moments(rest, 0.0), self._carried(rest)
        if self._leans(normal):
            return False
        # displacements and quaternions of all bodies, the base last
        moved = np.zeros((n + 1, 3))
        moved[:n] = np.array([place.see.ux, place.see.uy, place.see.uz]).T
        turn = np.zeros((n + 1, 4))
        turn[n, 0] = 1.0
        turn[:n] = np.array([place.see.q0, place.see.q1, place.see.q2, place.see.q3]).T
        centroids = [centroid_of(structure.blocks, i) for i in range(n + 1)]
        for j in np.flatnonzero(~np.isnan(moments) & (normal > 0.0)).tolist():
            # displacement of the contact on both bodies, tilt between them, slip since rest
            joint, lever = structure.joints[j], float(moments[j] / normal[j])
            ends = [
                (moved[i] + rotated(turn[i], joint.face.centre - centroids[i]) - (joint.face.centre - centroids[i]))
                for i in (joint.upper, joint.lower)
            ]
            axes = joint.face.axes
            ways = [rotated(turn[i], axes[:, 2]) for i in (joint.upper, joint.lower)]
            tilt = math.acos(max(-1.0, min(1.0, float(ways[0] @ ways[1]))))
            slip = (ends[0] - ends[1]) @ axes[:, :2] - _slip(place, j)
            if not (lever > 0.0 and tilt < math.atan2(lever, self._height(j)) and np.hypot(*slip) < 0.5 * lever):
                return False
        return True

    def _leans(self, normal: FloatArray) -> bool:
        """Return True if some block is held by joints that lean against each other, as in an arch."""
        return bool(np.any(~self._alone & ~self._upright & self._is_loaded(normal)))

    def _is_loaded(self, normal: FloatArray) -> NDArray[np.bool_]:
        """Return the mask of the joints that bear more than hardly anything, (joints,)."""
        return normal > self._hardly

    def _lifting(self, rest: SpatialStepper, left: float) -> float:
        """Return the least energy (J) that lifts what some joint carries over the nearest edge of its contact.

        A joint that others bypass opens together with at least one of them, turned by the same angle: moments and loads
        add up. Of all such sets some pair needs the least, as the joint with the largest ratio of moment to load adds
        to what two others need. Joints that bear nothing do not count there, nor do ties: a block may turn away from
        them.
        """
        normal, moments = self._carried(rest), self._moments(rest, left)
        if self._hangs or np.any(moments <= 0.0):
            return 0.0
        counts = ~np.isnan(moments)
        lifted = np.array([self._height(j) for j in range(len(normal))]) * normal
        part = self._left_by_beds(lifted)
        shares = counts & _bypassed(self._structure, self._is_loaded(normal))
        if np.count_nonzero(shares) < 2:
            shares[:] = False
        least = float(np.min((part * _work(moments, lifted))[counts & ~shares], initial=math.inf))
        moments, lifted, part = moments[shares], lifted[shares], part[shares]
        for k in range(1, len(moments)):
            work = _work(moments[k] + moments[:k], lifted[k] + lifted[:k])
            least = min(least, float(np.min(np.minimum(part[k], part[:k]) * work)))
        return least

    def _left_by_beds(self, lifted: FloatArray) -> FloatArray:
        """Return the fraction of the barrier of each joint that elastic beds leave, (joints,).

        A tilted body tilts further as the beds under and over it give way. Those between two bodies take the moment of
        their load at a tilt of 1, `lifted` (N m), over their stiffness against rotation; this adds up along a path from
        the base to the top. At 1 the structure buckles. Measured: barriers of stacks are at most 1.22 times the exact
        ones.
        """
        gives = (np.bincount(self._between, np.maximum(0.0, lifted)) / self._against_turns)[self._between]
        below, above = np.zeros((2, self._structure.n + 1))
        for j, upper, lower in self._rising:
            below[upper] = max(below[upper], below[lower] + gives[j])
        for j, upper, lower in reversed(self._rising):
            above[lower] = max(above[lower], above[upper] + gives[j])
        return np.maximum(0.0, 1.0 - gives - below[self._lowers] - above[self._uppers])

    def _height(self, j: int) -> float:
        """Return the height of the carried centroid above joint j (m), at least the size of the block above."""
        structure = self._structure
        return max(float(self._heights[j]), structure.blocks[structure.joints[j].carried(structure.n)].size)

    def _moments(self, rest: SpatialStepper, left: float) -> FloatArray:
        """Return the force of each joint times its lever about the nearest edge of its contact, N m (joints,).

        NaN for the joints of an arch, and for those of frames that bear hardly anything. Slips have moved that edge,
        and may go on until friction has dissipated the energy `left`, J. On an elastic bed the force stays inside the
        edge by a third of the length that is still in contact halfway to the fall.
        """
        structure = self._structure
        normal, (mx, my) = self._carried(rest), (_field(rest, name) for name in ("Mx", "My"))
        loaded = self._is_loaded(normal)
        together = self._upright & loaded & (not self._leans(normal))
        # of joints that only ties bypass those that lean are left to `_bending`
        single = self._alone | ~self._framed & (self._upright | ~loaded)
        moments = np.full(len(normal), math.nan)
        for j in np.flatnonzero(single | together).tolist():
            joint, carried, moments[j] = structure.joints[j], float(normal[j]), 0.0
            if not carried > 0.0:
                continue
            if joint.bearing is not None:
                moments[j] = carried * _lever_of_group(structure, self._groups[j], _field(rest, "N"))
                continue
            # lever of the resultant about the nearest edge
            place = np.array([my[j], -mx[j]]) / carried
            lever = min(reach - float(out @ place) for out, reach in _edges(joint, _slip(rest, j), place))
            if joint.bed.friction is not None:
                further = left / max((joint.bed.friction - _downhill(joint)) * carried, math.ulp(0.0))
                lever -= 0.0 if is_endless(joint.below or joint.face) else further
                down = -1.0 if joint.is_listed_downwards(structure.n) else 1.0
                if _sunk(joint, down * _slip(rest, j), further) >= structure.blocks[joint.carried(structure.n)].drop:
                    continue
            settled = carried / (joint.bed.stiffness * joint.moments[0])
            moments[j] = carried * (lever - math.sqrt(8.0 * settled * self._height(j)) / 3.0)
        return moments

    def _carried(self, rest: SpatialStepper) -> FloatArray:
        """Return the normal forces of the joints, N (joints,).

        The first bearing between two bodies gets the sum over all bearings between them, the others 0.
        """
        normal = _field(rest, "N").copy()
        for first, group in self._groups.items():
            normal[group] = np.where(np.array(group) == first, np.sum(normal[group]), 0.0)
        return normal

    def _coming_off(self, rest: SpatialStepper) -> float:
        """Return the least energy (J) that displaces some bearing to its capacity."""
        structure, normal, d = self._structure, _field(rest, "N"), _field(rest, "d")
        m, least = len(structure.joints) - len(structure.bearings), math.inf
        for j, joint in enumerate(structure.bearings):
            bearing, carried = joint.bearing, max(0.0, float(normal[m + j]))
            assert bearing is not None
            left = max(0.0, bearing.capacity - float(d[j]))
            slides, along = _slider(joint, carried)
            takes = slides * max(0.0, left - slides / along) if slides else 0.0
            least = min(least, 0.5 * (carried * bearing.pendulum + bearing.spring) * left**2 + takes)
        return least

    def _bending(self, rest: SpatialStepper, stiffness: FloatArray) -> float:
        """Return the least energy (J) that brings the resultant of some joint of an arch to the edge of its contact.

        The stiffness is that at rest. One hinge needs less energy than a mechanism, which has several.
        """
        structure, m = self._structure, len(self._structure.joints)
        normal, mx, my = (_field(rest, name) for name in ("N", "Mx", "My"))
        if not self._leans(normal):
            return math.inf
        change = self._change_of_resultants(rest)
        given, margins = [], []
        for j in np.flatnonzero(~self._alone & self._is_loaded(normal)).tolist():
            for (x, y), reach in _edges(structure.joints[j], _slip(rest, j)):
                margins.append(reach * normal[j] - x * my[j] + y * mx[j])
                given.append(reach * change[j] - x * change[2 * m + j] + y * change[m + j])
        slopes, margin = np.array(given), np.maximum(0.0, margins)
        gives = np.sum(slopes * np.linalg.solve(stiffness + stiffness.T, slopes.T).T, axis=1)  # half of it
        return float(np.min(0.25 * margin**2 / np.maximum(gives, math.ulp(0.0))))

    def _change_of_resultants(self, rest: SpatialStepper) -> FloatArray:
        """Return the derivatives of N, Mx and My of the joints by the coordinates, (3 joints, 6 n), per m and rad.

        Joints stick meanwhile.
        """
        structure, stuck = self._structure, sticking(rest.over(state=rest.arrays.state.copy()))
        size = 6 * structure.n
        places = places_of(OUTPUTS, structure.sizes)
        first, last = places["N"].start, places["My"].stop
        columns = []
        for k, delta in enumerate(self._delta):
            ends = []
            for step in (delta, -delta):
                stuck.phase[:] = rest.phase
                move(stuck, step * (np.arange(size) == k))
                stuck.observe()
                ends.append(stuck.row[first:last].copy())
            columns.append((ends[0] - ends[1]) / (2.0 * delta))
        return np.column_stack(columns)


def _slider(joint: SpatialJoint, normal: float) -> tuple[float, float]:
    """Return the force that the slider of a bearing bears at most under a normal force, N, and its stiffness, N/m."""
    bed = joint.bed
    return bed.dowel + (bed.friction or 0.0) * max(0.0, normal), bed.shear_ratio * bed.stiffness * joint.moments[0]


def _work(moment: FloatArray, lifted: FloatArray) -> FloatArray:
    """Return the energy (J) that turns loads over an edge, from their moments and their product with heights, N m."""
    return moment * moment / (np.hypot(lifted, moment) + lifted)


def _is_stable(stiffness: FloatArray) -> bool:
    try:
        np.linalg.cholesky(stiffness + stiffness.T)
    except np.linalg.LinAlgError:
        return False
    return True


def _stopped(stepper: SpatialStepper) -> SpatialStepper:
    """Return a copy of the state without velocities."""
    n, other = stepper.structure.n, stepper.over(state=stepper.arrays.state.copy())
    other.row, other.rates = stepper.row.copy(), stepper.rates.copy()
    other.phase[_place("vx", n) : at.PHASE.size(n)] = 0.0
    return other


def _place(name: str, n: int) -> int:
    """Return the offset of a field in the phase of n blocks."""
    return at.PHASE.places[name][0] * n


def _slip(stepper: SpatialStepper, j: int) -> FloatArray:
    return np.array([stepper.slips.p1[j], stepper.slips.p2[j]])


def _field(stepper: SpatialStepper, name: str) -> FloatArray:
    """Return a field of the output row of a stepper."""
    return stepper.row[places_of(OUTPUTS, stepper.structure.sizes)[name]]


def _edges(joint: SpatialJoint, slip: FloatArray, towards: FloatArray | None = None) -> list[tuple[FloatArray, float]]:
    """Return the outward normals of the edges of a contact, along the axes of the joint, and their distances (m).

    Distances are measured from the midpoint between the centres of both faces, which a slip has separated. A round face
    has the edge next to the point `towards`, or edges in DIRECTIONS directions.
    """
    if joint.bed.friction is None:  # its contact does not move
        return _edges_of(joint.face, joint.face, np.zeros(2), towards)
    above, below = joint.above or joint.face, joint.below or joint.face
    return [
        *_edges_of(above, joint.face, 0.5 * slip, towards),
        *_edges_of(below, joint.face, -0.5 * slip, towards),
    ]


def _edges_of(
    face: Face, seen_from: Face, moved: FloatArray, towards: FloatArray | None
) -> list[tuple[FloatArray, float]]:
    axes = seen_from.axes[:, :2]
    centre = (face.centre - seen_from.centre) @ axes + moved
    if face.radius and towards is not None:
        off = towards - centre
        out = off / max(float(np.hypot(*off)), math.ulp(0.0))
        return [(out, face.radius + float(out @ centre))]
    if face.radius:
        angles = np.linspace(0.0, 2.0 * math.pi, DIRECTIONS, endpoint=False)
        return [(out, face.radius + float(out @ centre)) for out in np.column_stack([np.cos(angles), np.sin(angles)])]
    corners = face.seen_from(seen_from) + moved
    outwards = outward_normals(corners)
    return list(zip(outwards, np.sum(outwards * corners, axis=1).tolist(), strict=True))


def _downhill(joint: SpatialJoint) -> float:
    """Return the force with which the load on a joint pushes down its slope, over the normal force."""
    upwards = abs(float(joint.face.normal[2]))
    return math.sqrt(max(0.0, 1.0 - upwards * upwards)) / max(upwards, math.ulp(0.0))


def _sunk(joint: SpatialJoint, slip: FloatArray, further: float) -> float:
    """Return how far the block above has sunk down the slope of its joint by a slip, and by a `further` one, m."""
    axes = joint.face.axes[2, :2]
    slope = float(np.hypot(*axes))
    return further * slope - float(axes @ slip) if slope > LEVEL else -math.inf


def _against_turns(structure: Structure) -> tuple[NDArray[np.int64], FloatArray]:
    """Return the number of each joint's two bodies, and the stiffness of all their beds against rotation, N m (pairs,).

    The least about any axis, in full contact.
    """
    found: dict[tuple[int, int], list[int]] = {}
    for j, joint in enumerate(structure.joints):
        found.setdefault((joint.carried(structure.n), joint.carrier(structure.n)), []).append(j)
    between, least = np.zeros(len(structure.joints), dtype=np.int64), []
    for number, some in enumerate(found.values()):
        between[some] = number
        joints = [structure.joints[j] for j in some]
        axes = joints[0].face.axes[:, :2]
        rigid = np.array([joint.bed.stiffness * joint.moments[0] for joint in joints])
        places = np.array([joint.face.centre for joint in joints]) @ axes
        places -= rigid @ places / np.sum(rigid)
        total = (rigid * places.T) @ places
        for joint in joints:
            _, xx, yy, xy = joint.moments
            turned = joint.face.axes[:, :2].T @ axes
            if joint.bearing is None:  # which acts at a point
                total += joint.bed.stiffness * turned.T @ np.array([[xx, xy], [xy, yy]]) @ turned
        weak, strong = np.linalg.eigvalsh(total).tolist()
        least.append(max(weak, 1e-12 * strong, LEAST_STIFFNESS))  # rounding leaves nothing of that of a line
    return between, np.array(least)


def _groups(structure: Structure) -> dict[int, list[int]]:
    """Return the bearings between the same two bodies by the first of them: together they act like one joint."""
    found: dict[tuple[int, int], list[int]] = {}
    for j, joint in enumerate(structure.joints):
        if joint.bearing is not None:
            found.setdefault((joint.carried(structure.n), joint.carrier(structure.n)), []).append(j)
    return {group[0]: group for group in found.values()}


def _lever_of_group(structure: Structure, group: list[int], normal: FloatArray) -> float:
    """Return the distance of the resultant of bearings from the nearest line about which the carried body tips (m).

    A tipping line passes through two bearings with none beyond it. The distance is reduced by half of the capacity, by
    which the body has moved before it comes off. NaN if a bearing holds tension, which prevents tipping.
    """
    joints = [structure.joints[j] for j in group]
    bearings = [joint.bearing for joint in joints if joint.bearing is not None]
    if any(bearing.holds for bearing in bearings):
        return math.nan
    places = np.array([joint.face.centre for joint in joints]) @ joints[0].face.axes[:, :2]
    middle, least = normal[group] @ places / float(np.sum(normal[group])), math.inf
    for a in places:
        for b in places:
            across = np.array([b[1] - a[1], a[0] - b[0]])
            length = float(np.hypot(*across))
            if length and np.max((places - a) @ across) <= 1e-9 * length**2:
                least = min(least, float((a - middle) @ across) / length)
    return max(0.0, least - 0.5 * min(bearing.capacity for bearing in bearings)) if math.isfinite(least) else 0.0


def _heights(structure: Structure) -> FloatArray:
    """Return the height of the centroid of the carried mass above each joint, m (joints,).

    The mass of a block that stands on several joints is shared equally by them.
    """
    bears: list[list[int]] = [[] for _ in structure.blocks]  # numbers of the joints under each block
    for j, joint in enumerate(structure.joints):
        if joint.face.normal[2] > 0.0 or joint.is_listed_downwards(structure.n):
            bears[joint.carried(structure.n)].append(j)
    carried = np.array([block.mass for block in structure.blocks])
    moment = np.array([block.mass * block.centroid[2] for block in structure.blocks])
    for i in sorted(range(structure.n), key=lambda i: -structure.blocks[i].centroid[2]):
        for j in bears[i]:
            below = structure.joints[j].carrier(structure.n)
            if below < structure.n:
                carried[below] += carried[i] / len(bears[i])
                moment[below] += moment[i] / len(bears[i])
    uppers = [joint.carried(structure.n) for joint in structure.joints]
    places = np.array([joint.face.centre[2] for joint in structure.joints])
    return moment[uppers] / carried[uppers] - places


def _bypassed(
    structure: Structure, counted: NDArray[np.bool_] | None = None, *, ties: bool = False
) -> NDArray[np.bool_]:
    """Return the mask of the joints that other links bypass: without such a joint all bodies stay connected, (joints,).

    Links are the `counted` joints (None: all) and, if asked for, the ties. In a spanning tree, a link is bypassed if a
    link outside the tree closes a cycle with it. Each link outside the tree has a bit, which the bodies on the paths
    to both of its ends get by XOR: common parts of the paths keep none.
    """
    bodies, count = _bodies_linked(structure, ties), len(structure.joints)
    behind = [j for group in _groups(structure).values() for j in group[1:]]  # bearings of two bodies are one link
    left_out = {*behind, *(() if counted is None else np.flatnonzero(~counted).tolist())}
    numbers = [number for number in range(len(bodies)) if number not in left_out]
    links = [bodies[number] for number in numbers]
    trees = trees_of(structure.n, links)
    by = {body: number for tree in trees for body, number in tree.items()}
    # bits of the links outside the trees
    past, found = [0] * (structure.n + 1), np.zeros(len(bodies), dtype=np.bool_)
    found[behind] = True
    for number, (one, other) in enumerate(links):
        if number not in (by[one], by[other]):
            past[one] ^= 1 << number
            past[other] ^= 1 << number
            found[numbers[number]] = True
    # from the leaves to the roots: a link whose subtree has no bits is a bridge
    for body, number in reversed(by.items()):
        if number >= 0:
            one, other = links[number]
            past[other if one == body else one] ^= past[body]
            found[numbers[number]] = past[body] != 0
    return found[:count]


def _hangs(structure: Structure) -> bool:
    """Return True if ties alone connect some block with the base."""
    return len(trees_of(structure.n, _bodies_linked(structure))) > 1


def _bodies_linked(structure: Structure, ties: bool = False) -> list[tuple[int, int]]:
    """Return the numbers of the bodies that each joint connects, then those of each tie if asked for."""
    joints = [(joint.upper, joint.lower) for joint in structure.joints]
    return joints + [(tie.one, tie.other) for tie in structure.ties] * ties
