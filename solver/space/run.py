"""A whole run in space: from a structure and a base motion to a response."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..common.errors import InputError, SolverError
from ..dynamics.uncertainty import ErrorEstimate
from ..dynamics.verdict import OVERTURNED, STANDING, UNDECIDED
from ..ground.motion import Motion
from ..kernels.space import layout as at
from .blocks.faces import FloatArray, edge_distance
from .modal_data import modal_data_of
from .response import SpatialResponse
from .rest import Rest, rest_of, start_from
from .stepper import Stepper
from .structure import Structure

COUNTED = ("steps", "elastic_steps", "rejected", "evaluations", "looks")
BETWEEN_LOOKS = 0.25  # s, after the motion
SAFE = 0.5  # of the least energy that lifts what a joint carries over its edge
FINER, LEAST_TOLERANCE = 0.1, 1e-12  # of the run that checks another
AGREE = 10.0  # tolerances


class SpatialGlance(NamedTuple):
    """The state of a run under way, for a callback: places m and rotations rad of the blocks, (n, 3) each."""

    u: FloatArray
    rotation: FloatArray


Callback = Callable[[float, SpatialGlance], object]


class SpatialState(NamedTuple):
    """Initial displacement m, rotation rad (axis times angle), velocity m/s and spin rad/s of the blocks, (n, 3) each.

    They count from the structure as built and without weight, along the axes of the base.
    """

    displacement: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    spin: FloatArray


def simulate_structure(
    structure: Structure,
    motion: Motion,
    duration: float,
    times: FloatArray,
    initial: SpatialState | None = None,
    settle: float = 0.0,
    check: bool = False,
    callback: Callback | None = None,
) -> SpatialResponse:
    """A run of `duration` s with rows at `times`, s; see runs/simulate.py. Raises InputError and SolverError."""
    response = single_run(structure, motion, duration, times, initial, settle, callback)
    response.motion = motion
    if check:
        finer = structure.with_settings(tolerance=max(LEAST_TOLERANCE, FINER * structure.tolerance))
        try:
            _judge(response, single_run(finer, motion, duration, times, initial, settle, callback))
        except SolverError as failure:
            response.verdict, response.reason = UNDECIDED, f"the run that checks it failed: {failure}"
    return response


def single_run(
    structure: Structure,
    motion: Motion,
    duration: float,
    times: FloatArray,
    initial: SpatialState | None = None,
    settle: float = 0.0,
    callback: Callback | None = None,
) -> SpatialResponse:
    """A run and its verdict. Raises InputError and SolverError."""
    rest = rest_of(structure)
    stepper = Stepper(structure)
    start_from(stepper, rest)
    flat = structure.is_plane and not motion.has_ay
    if initial is not None:
        set_initial(stepper, initial)
        flat = flat and is_flat(initial)
    modes = modal_data_of(structure)
    stepper.model = stepper.model._replace(settings=stepper.model.settings.copy(), modal=modes.numbers.copy())
    settings = at.SETTINGS.see(stepper.model.settings)
    settings.has_modes = float(modes.numbers.size > 0)
    settings.in_plane = float(flat)
    settings.watches = float("peaks" not in structure.without)
    stop = motion.start + duration

    def after_chunk(t: float) -> None:
        if callback is not None:
            stepper.observe()
            u, rotation = stepper.row[: 6 * structure.n].reshape(2, 3, -1)
            callback(t, SpatialGlance(u.T.copy(), rotation.T.copy()))

    begin = clock.perf_counter()
    rows = stepper.run(motion, motion.start, stop, times, after_chunk)
    stats: dict[str, float | str] = {name: int(getattr(stepper.counts, name)) for name in COUNTED}
    coupled = "" if settings.has_modes else "dampers couple the modes"
    stats["why_no_modes"] = modes.why_none or coupled
    stats["wall_time"] = clock.perf_counter() - begin
    response = SpatialResponse(structure, times, rows, stepper.state.peaks.copy(), stats)
    stats["settled_for"] = _follow(response, stepper, rest, stop, settle) - stop
    return response


def is_flat(initial: SpatialState) -> bool:
    """Whether an initial state lies in the plane x, z."""
    across = initial.displacement[:, 1], initial.velocity[:, 1], initial.rotation[:, ::2], initial.spin[:, ::2]
    return not any(np.any(part) for part in across)


def set_initial(stepper: Stepper, initial: SpatialState) -> None:
    """Place and move the blocks of a stepper. Raises InputError."""
    see, n = stepper.see, stepper.structure.n
    for part in initial:
        if np.shape(part) != (n, 3) or not np.all(np.isfinite(part)):
            raise InputError(f"initial: must be four arrays of finite numbers, ({n}, 3) each")
    see.ux[:], see.uy[:], see.uz[:] = np.asarray(initial.displacement).T
    see.vx[:], see.vy[:], see.vz[:] = np.asarray(initial.velocity).T
    angle = np.linalg.norm(initial.rotation, axis=1)
    see.q0[:] = np.cos(0.5 * angle)
    q = 0.5 * np.sinc(0.5 * angle / np.pi)[:, None] * initial.rotation
    see.q1[:], see.q2[:], see.q3[:] = q.T
    spin = np.asarray(initial.spin)
    across = np.cross(q, spin)  # into the axes of the body
    see.wx[:], see.wy[:], see.wz[:] = (spin - 2.0 * (see.q0[:, None] * across - np.cross(q, across))).T
    stepper.observe(keep=False)
    found = resultants_of(stepper)
    for k in (1, 2, 3):  # joints begin without elastic slip
        getattr(stepper.slips, f"p{k}")[:] = getattr(found, f"s{k}")


def resultants_of(stepper: Stepper) -> object:
    """Names over the resultants of the last evaluation (layout.py, RESULTANTS)."""
    n, m, k = stepper.sizes
    first = at.rows_size(n, m, k) + at.POSES.size(n + 1)
    return at.RESULTANTS.see(stepper.state.work[first:], m)


def least_barrier(structure: Structure, rest: Rest) -> float:
    """The least energy, J, that lifts what some joint carries at rest over its edge, everything above being rigid.

    A block that stands on several joints does not fall over the edge of one. Without weight it is zero.
    """
    uppers = [joint.upper for joint in structure.joints]
    top = max(float(np.max(block.corners[:, 2])) for block in structure.blocks)
    first, least = 6 * structure.n, math.inf
    for j, joint in enumerate(structure.joints):
        if uppers.count(joint.upper) > 1:
            continue
        carried = float(rest.row[first + j])
        edge = joint.face.size if joint.face.radius else edge_distance(joint.face.outline)
        height = max(0.5 * (top - float(joint.face.centre[2])), structure.blocks[joint.upper].size)
        least = min(least, 0.5 * carried * edge * edge / height)
    return least if math.isfinite(least) else 0.0


def _follow(response: SpatialResponse, stepper: Stepper, rest: Rest, stop: float, settle: float) -> float:
    """Set the verdict, which may take `settle` s more on a still base. Returns the time reached, s."""
    structure, t = response.structure, stop
    still = Stepper(structure)
    start_from(still, rest)
    at_rest = still.observe()
    enough = SAFE * least_barrier(structure, rest)
    while not stepper.counts.fallen:
        energy = stepper.observe() - at_rest
        if energy <= enough * stepper.lever_left**2 or stepper.counts.resting:
            response.verdict = STANDING
            response.reason = "it has come to rest" if stepper.counts.resting else "its energy does not suffice to fall"
            return t
        if not t < stop + settle:
            response.verdict, response.reason = UNDECIDED, f"{settle:g} s after the end it has the energy to fall"
            return t
        end = min(t + BETWEEN_LOOKS, stop + settle)
        try:
            stepper.run(None, t, end, np.zeros(0))
        except SolverError as failure:
            response.verdict, response.reason = UNDECIDED, f"after the end, {failure}"
            return t
        t = end
    response.overturn_time = float(stepper.control.fall_time)
    response.overturned_block = structure.names[int(stepper.counts.fallen) - 1]
    later = response.overturn_time - stop
    when = f"{later:.4g} s after the end of the run" if later > 0.0 else "within the run"
    response.verdict, response.reason = OVERTURNED, f"block {response.overturned_block} has fallen, {when}"
    return max(t, stop)


def _judge(response: SpatialResponse, closer: SpatialResponse) -> None:
    """Set estimated_error, horizon and, if the verdicts differ, the verdict of a response from a closer run."""
    n, time = response.structure.n, response.time
    fall = min((run.overturn_time for run in (response, closer) if run.overturned), default=math.inf)
    rows = int(np.searchsorted(time, fall - 0.1)) or len(time)
    difference = np.max(np.abs(response.rows[:, : 3 * n] - closer.rows[:, : 3 * n]), axis=1)
    size = float(np.max(np.abs(closer.rows[:rows, : 3 * n]), initial=0.0)) or 1.0
    peaks = {
        name: np.abs(response.peaks[name] - other) / (1.0 if name == "contact" else np.where(other, other, 1.0))
        for name, other in closer.peaks.items()
    }
    response.estimated_error = ErrorEstimate(
        ux=float(np.max(difference[:rows], initial=0.0)) / size,
        peaks=peaks,
        overturn_time=abs(response.overturn_time - closer.overturn_time),
    )
    apart = np.flatnonzero(difference > AGREE * response.structure.tolerance * size)
    response.horizon = float(time[max(int(apart[0]) - 1, 0)] if apart.size else time[-1])
    if response.verdict != closer.verdict:
        response.reason = (
            f"it is {response.verdict} at a tolerance of {response.structure.tolerance:g}, "
            f"and {closer.verdict} at {closer.structure.tolerance:g}"
        )
        response.verdict = UNDECIDED
