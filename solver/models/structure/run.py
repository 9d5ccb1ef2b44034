"""A whole run in space, from a structure and a base motion to a response."""

from __future__ import annotations

import math
import time as clock
import warnings
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from ...common.errors import InputError, InputWarning, shown
from ...ground.loads import ACROSS, COMPONENTS
from ...ground.motion import Motion
from ...kernels.structure import layout as at
from ..ports import Released
from ..protocol import NoRestError, RunPlan, output_times
from ..still_base import conclude
from .blocks.faces import FloatArray
from .blocks.parts import SpatialJoint
from .blocks.placement import RIM
from .blocks.shapes import rotated, rotation_matrix
from .equilibria import NO_ROOM_LEFT, rest_under
from .modal_data import ModalData, modal_data_of
from .model import Structure
from .outputs import DISPLACEMENTS
from .response import Moved, SpatialResponse, peaks_in_space
from .rest import fastest_decay, rest_of
from .stepper import SpatialStepper
from .verdict import RESTING, next_look, potential_well_of, reason_for_leaning

# of a joint that has lifted off: least opening in the middle, of the largest block, and largest overlap, of that
OPEN, TOUCHES = 1e-6, 1e-3
TWISTS = 6  # iterations for an initial twist: each reduces the error to its cube over 24
COUNTED = ("steps", "elastic_steps", "stabilized_steps", "rejected", "evaluations", "looks")


class SpatialGlance(NamedTuple):
    """The state of a run in progress, for a callback: displacements m and rotations rad of the blocks, (n, 3) each."""

    u: FloatArray
    rotation: FloatArray

    @property
    def ux(self) -> FloatArray:
        """The displacements along x, m (n,)."""
        return self.u[:, 0]

    @property
    def ry(self) -> FloatArray:
        """The rotations about y, rad (n,)."""
        return self.rotation[:, 1]


Callback = Callable[[float, SpatialGlance], object]


class SpatialState(NamedTuple):
    """The initial displacement m, rotation rad (axis times angle), velocity m/s and spin rad/s, (n, 3) each.

    They are those of the blocks relative to the structure as built and without weight, along the axes of the base. A
    joint with friction has slid to where it is displaced, as has one that has lifted off; one without friction that
    touches anywhere, or with a bond, is deformed elastically.
    """

    displacement: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    spin: FloatArray


def single_run(structure: Structure, plan: RunPlan) -> SpatialResponse:
    """Run a structure; return its response with the verdict. Raises InputError and SolverError.

    A run that goes on after a fall is repeated up to the end of that time if the plan ends before, its rows as far
    apart.
    """
    response = _run(structure, plan)
    beyond = response.overturn_time + structure.after_fall - plan.motion.start
    if structure.after_fall and response.overturned and beyond > plan.duration:
        step = float(plan.times[1] - plan.times[0]) if len(plan.times) > 1 else beyond
        response = _run(structure, plan._replace(duration=beyond, times=output_times(plan.motion, beyond, step)))
    return response


def _run(structure: Structure, plan: RunPlan) -> SpatialResponse:
    motion, callback = plan.motion, plan.callback
    stepper, why_no_modes = begun(structure, motion, plan.initial)
    stop = motion.start + plan.duration

    def after_chunk(t: float) -> None:
        if callback is not None:
            stepper.observe()
            u, rotation = stepper.row[: 6 * structure.n].reshape(2, 3, -1)
            callback(t, SpatialGlance(u.T.copy(), rotation.T.copy()))

    begin = clock.perf_counter()
    rows = stepper.run(motion, motion.start, stop, plan.times, after_chunk)
    stats: dict[str, float | str] = {name: int(getattr(stepper.counts, name)) for name in COUNTED}
    coupled = "" if stepper.model.settings.has_modes else "dampers couple the modes"
    stats["why_no_modes"] = why_no_modes or coupled
    stats["wall_time"] = clock.perf_counter() - begin
    stats["without_room"] = stepper.without_room
    if structure.after_fall:
        stats["released"] = float(stepper.state.control.released)
    if stepper.without_room:
        warnings.warn(f"{structure.name}: {stepper.without_room} times {NO_ROOM_LEFT}", InputWarning, stacklevel=2)
    # response, then the verdict on a still base
    seen = at.WORK.see(stepper.arrays.work, stepper.sizes)
    peaks = peaks_in_space(structure, stepper.state.peaks, seen.poses.farthest[: structure.n].copy())
    touched = np.array([*(getattr(seen.hits, name) for name in at.FIRST), peaks["gap"], peaks["hit"]])
    if "peaks" in structure.without:
        peaks = {name: peaks[name] for name in (*DISPLACEMENTS, "u")}
    again = partial(moved, structure, motion, stop, plan.times, plan.initial)
    response = SpatialResponse(
        structure, rows, again, touched, time=plan.times, peaks=peaks, stats=stats, motion=motion
    )
    conclude(response, SpatialSettling(stepper), stop, plan.settle)
    return response


def moved(
    structure: Structure, motion: Motion, stop: float, times: FloatArray, initial: SpatialState | Released | None
) -> Moved:
    """Return velocities and energies at `times` by repeating a run, bit for bit. Raises SolverError."""
    try:
        stepper, _ = begun(structure, motion)
    except NoRestError:  # energies are those above the structure as built
        stepper = SpatialStepper(structure)
    at_rest = stepper.observe()
    if initial is not None:
        stepper, _ = begun(structure, motion, initial)
    states = stepper.run(motion, motion.start, stop, times, states=True)[:, stepper.sizes.visible :]
    if not stepper.model.settings.gives_way:  # the remembered slips are constant
        place, end = 13 * structure.n, 13 * structure.n + at.remembered(stepper.sizes)
        states[:, place:end] = stepper.phase[place:end]
    velocity, energy = np.empty((len(times), structure.n, 3)), np.empty(len(times))
    see = stepper.see
    for k, state in enumerate(states):
        stepper.phase[:] = state
        velocity[k] = np.column_stack([see.vx, see.vy, see.vz])
        energy[k] = stepper.observe() - at_rest
    return Moved(velocity, energy)


def begun(
    structure: Structure, motion: Motion, initial: SpatialState | Released | None = None
) -> tuple[SpatialStepper, str]:
    """Return a stepper before a motion, at rest or in the initial state, and the reason why it has no modes.

    Raises InputError, NoRestError if it begins at rest and has none.
    """
    try:
        rest, modes = rest_of(structure), modal_data_of(structure)
    except NoRestError:
        if initial is None or isinstance(initial, Released):
            raise
        stepper, modes = SpatialStepper(structure), ModalData(np.zeros(0), "no rest")
    else:
        stepper = SpatialStepper(structure, modes.numbers)
        stepper.phase[:] = rest.phase
    # initial state; a run in the plane if everything lies in it
    flat = structure.is_plane and not motion.has_ay and all(load.is_in_plane for load in motion.loads.values())
    if isinstance(initial, Released):
        stepper.phase[:] = rest_under(structure, initial.loads)
        flat = flat and not np.any(initial.loads[[COMPONENTS.index(name) for name in ACROSS]])
    elif initial is not None:
        set_initial(stepper, initial)
        stepper.control.decay = fastest_decay(structure)  # in full contact, which the blocks may have left
        across = initial.displacement[:, 1], initial.velocity[:, 1], initial.rotation[:, ::2], initial.spin[:, ::2]
        flat = flat and not any(np.any(part) for part in across)
    stepper.model.settings.in_plane = float(flat)
    settings = stepper.model.settings
    settings.after_fall = structure.after_fall
    settings.watches = float("peaks" not in structure.without)
    if "stabilized" in structure.without:
        settings.stabilizes = 0.0
    return stepper, modes.why_none


def set_initial(stepper: SpatialStepper, initial: SpatialState) -> None:
    """Set positions and velocities of the blocks of a stepper. Raises InputError."""
    if not isinstance(initial, SpatialState):
        raise InputError(f"initial = {shown(initial)}: must be a SpatialState, as a structure begins from it")
    see, n = stepper.see, stepper.structure.n
    for part in initial:
        if np.shape(part) != (n, 3) or not np.all(np.isfinite(part)):
            raise InputError(f"initial: must be four arrays of finite numbers, ({n}, 3) each")
    see.ux[:], see.uy[:], see.uz[:] = np.asarray(initial.displacement).T
    see.vx[:], see.vy[:], see.vz[:] = np.asarray(initial.velocity).T
    # rotation vectors to quaternions; spins to the axes of the bodies
    angle = np.linalg.norm(initial.rotation, axis=1)
    see.q0[:] = np.cos(0.5 * angle)
    q = 0.5 * np.sinc(0.5 * angle / np.pi)[:, None] * initial.rotation
    see.q1[:], see.q2[:], see.q3[:] = q.T
    to_body = np.array([see.q0, *-q.T])
    see.wx[:], see.wy[:], see.wz[:] = rotated(to_body, np.asarray(initial.spin).T)
    found = at.WORK.see(stepper.arrays.work, stepper.sizes).resultants
    structure = stepper.structure
    for _ in range(TWISTS):  # joints begin without elastic slip
        stepper.observe(keep=False)
        for k in (1, 2, 3):
            getattr(stepper.slips, f"p{k}")[:] = getattr(found, f"s{k}")
    # but for those that cannot have slid, unless they have lifted off
    for j, joint in enumerate(structure.joints):
        sticks = joint.bed.friction is None and not _is_lifted(structure, joint, initial)
        if joint.bearing is None and (joint.bed.is_bonded or sticks):
            for k in (1, 2, 3):
                getattr(stepper.slips, f"p{k}")[j] = 0.0


def _is_lifted(structure: Structure, joint: SpatialJoint, initial: SpatialState) -> bool:
    """Return True if the upper face of a joint is above the lower one, touches at most and is apart in the middle."""
    face, ends = joint.face, []
    for body in (joint.upper, joint.lower):
        turn, move, centroid = np.eye(3), np.zeros(3), np.zeros(3)
        if body < structure.n:
            turn, move = rotation_matrix(initial.rotation[body]), np.asarray(initial.displacement[body])
            centroid = structure.blocks[body].centroid
        ends.append((turn, centroid + move - turn @ centroid))
    (turn, move), (lower, moved) = ends
    points = np.concatenate([face.centre[None], face.points(RIM)]) @ turn.T + move
    gaps = (points - (lower @ face.centre + moved)) @ (lower @ face.normal)
    most = OPEN * max(block.size for block in structure.blocks)
    return bool(gaps[0] > most and np.min(gaps) > -TOUCHES * most)


class SpatialSettling:
    """A structure on a still base after its run (still_base.py)."""

    unclear = "may have the energy to fall"

    def __init__(self, stepper: SpatialStepper) -> None:
        self._stepper = stepper
        self._has_rest = True  # until it is known that there is none

    @property
    def fallen(self) -> int:
        return int(self._stepper.counts.fallen)

    @property
    def what_fell(self) -> str:
        """The block that has fallen, and the bearing it has come off, in words; "" if none has."""
        structure, left = self._stepper.structure, int(self._stepper.counts.left)
        if not self.fallen:
            return ""
        # a fall off a bearing, or a block that has tipped or dropped
        block = f"block {structure.names[self.fallen - 1]}"
        return f"{block} off the bearing {structure.bearing_names[left - 1]}" if left else block

    @property
    def fall_time(self) -> float:
        return float(self._stepper.control.fall_time) if self.fallen else math.nan

    def why_it_stands(self) -> str:
        stepper = self._stepper
        found = reason_for_leaning(stepper) or (RESTING if stepper.counts.resting else "")
        if found or not self._has_rest:
            return found
        try:
            return potential_well_of(stepper.structure).why_it_stands(stepper)
        except NoRestError:  # begun from a state; it may still lean on others or come to rest elsewhere
            self._has_rest = False
            return ""

    def next_look(self, t: float, stop: float, settle: float) -> float:
        return stop + next_look(t - stop, settle)

    def rest_until(self, t: float, end: float) -> None:
        self._stepper.run(None, t, end, np.zeros(0))
