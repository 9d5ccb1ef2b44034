"""One run: a column under a motion, and then on the still base until its verdict is known."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...common.aliases import Alias
from ...kernels.layout import spaces as at
from ..ports import Released
from ..protocol import RunPlan, Verdict
from ..still_base import Settling, conclude, settled
from .kinematics import chain_of
from .model import Column
from .packing import FloatArray, InitialState, coordinates_of
from .response import Response
from .stepper import Stepper
from .under_loads import rest_under
from .verdict import cannot_fall

# fields of kernels/layout/spaces.py, COUNTS, that `Response.stats` contains
COUNTED = ("steps", "implicit_steps", "elastic_steps", "rejected", "events", "evaluations", "sweeps", "looks")


class _Glance(NamedTuple):
    ux: FloatArray
    ry: FloatArray
    peak_top_ux: FloatArray


class Glance(_Glance):
    """The state of a run in progress, for a callback: ux (m), ry (rad), the peaks of |ux| so far (m), (n,) each."""

    theta, peak_ux = Alias("ry"), Alias("peak_top_ux")


Callback = Callable[[float, Glance], object]


def single_run(column: Column, plan: RunPlan) -> tuple[Response, FloatArray]:
    """Run a column; return its response, and its phases (kinematics.py) at the times of the rows.

    Raises InputError for an invalid initial state, SolverError if the motion cannot be followed.
    """
    initial = rest_under(column, plan.initial.loads) if isinstance(plan.initial, Released) else plan.initial
    stepper = Stepper(column, initial)
    stop = plan.motion.start + plan.duration

    def after_chunk(t: float) -> None:
        if plan.callback is not None:
            phase, chain = phase_of(stepper), chain_of(column)
            places = chain.places(phase)
            plan.callback(t, Glance(chain.top_displacements(phase), places.theta.copy(), stepper.peak_top_ux.copy()))

    # the motion
    begin = clock.perf_counter()
    snapshots = stepper.run(plan.motion, stop, plan.times, after_chunk)
    stats = _stats(stepper, clock.perf_counter() - begin)
    phases = _coordinates(at.phases_in(snapshots), column)
    response = Response(
        column,
        lambda: stepper.rows_of(snapshots, plan.times),
        phases,
        time=plan.times,
        peaks=stepper.peaks,
        stats=stats,
        motion=plan.motion,
    )
    # the verdict, on a still base
    conclude(response, _Settling(stepper), stop, plan.settle)
    if "resultants" in column.settings.without:
        response.observe()
    return response, phases


def phase_of(stepper: Stepper) -> FloatArray:
    """Return a copy of the coordinates and rates of a stepper, as in models/column/kinematics.py."""
    return _coordinates(stepper.arrays.state[at.CONTROL.beside :], stepper.column).copy()


def _coordinates(phases: FloatArray, column: Column) -> FloatArray:
    """Return coordinates and rates from arrays that begin with a phase of the stepper."""
    n = column.n
    slips, behind = phases[..., at.RIGID_FIELDS * n :], phases[..., at.PHASE_FIELDS * n :]
    found = coordinates_of(phases, slips if column.has_slips else slips[..., :0], n)
    if not column.is_brittle:
        return found
    still = np.zeros((*found.shape[:-1], 6 * n - found.shape[-1]))  # without slips their places hold scratch data
    return np.concatenate([found, still, behind[..., : 2 * n]], axis=-1)


class _Settling(Settling):
    """A column on a still base (still_base.py)."""

    def __init__(self, stepper: Stepper) -> None:
        self._stepper, self._column = stepper, stepper.column

    @property
    def fallen(self) -> int:
        return self._stepper.fallen

    @property
    def what_fell(self) -> str:
        return f"block {self.fallen} over joint {self.fallen}" if self.fallen else ""

    @property
    def fall_time(self) -> float:
        return self._stepper.fall_time

    @property
    def unclear(self) -> str:
        other = self._law_without_barrier
        why = f"has not fallen, and with joint.{other} no energy tells whether it can"
        return why if other else "still has the energy to overturn"

    @property
    def _law_without_barrier(self) -> str:
        """The key of the law for which there is no energy barrier, or ""."""
        column = self._column
        brittle = column.is_brittle and column.off_axis
        return column.other_law or (column.brittle_key if brittle else "")

    def why_it_stands(self) -> str:
        if cannot_fall(self._column, phase_of(self._stepper)):
            return "its energy does not suffice to overturn it"
        rests = self._law_without_barrier and self._stepper.arrays.counts[at.COUNTS.places["resting"]]
        return "it has come to rest" if rests else ""

    def rest_until(self, t: float, end: float) -> None:
        self._stepper.rest_until(t, end)


def settled_verdict(stepper: Stepper, stop: float, settle: float) -> Verdict:
    """Determine the verdict on a run that ended at time `stop` (s), at most `settle` (s) later."""
    return settled(_Settling(stepper), stop, settle)


def outcome(column: Column, phase: FloatArray, stop: float, settle: float) -> tuple[str, float, int]:
    """Return the verdict on a column, the time of its fall (s), NaN if it stands, and the joint over which it falls.

    Its base is still from time `stop` (s) on, at which it has this phase (kinematics.py). It is followed for at most
    `settle` (s). The joint is 0 if it stands.
    """
    chain = chain_of(column)
    places = chain.places(phase)
    moved = (places.slip - chain.offset, places.slip_rate) if column.has_slips else (None, None)
    stepper = Stepper(column, InitialState(places.theta, places.spin, places.opening, places.opening_rate, *moved))
    verdict = settled_verdict(stepper, stop, settle)
    return verdict.word, stepper.fall_time, stepper.fallen


def why_no_modes(stepper: Stepper) -> str:
    """Return the reason why no step is made by modes under any motion, or "" if some are.

    They are used while nothing opens or slides.
    """
    settings = stepper.column.settings
    if stepper.column.kind.fixed:
        return f"formulation {settings.formulation}"
    if "elastic" in settings.without:
        return "left out"
    if stepper.column.n > at.MODAL_MOST:
        return f"more than {at.MODAL_MOST} blocks"
    if stepper.column.is_brittle:
        return "brittle joints"
    has_modes = stepper.model.settings.has_modes
    return "" if has_modes else "no stable rest in full contact, or dampers that couple the modes"


def _stats(stepper: Stepper, wall_time: float) -> dict[str, float | int | str]:
    control, counts = stepper.state.control, stepper.arrays.counts.tolist()
    spent = max(stepper.time_spent, math.ulp(0.0))
    return {
        **{name: counts[at.COUNTS.places[name]] for name in COUNTED},
        "why_no_modes": why_no_modes(stepper),
        "full_contact": float(control.time_full / spent),
        "rocking": float(control.time_rocking / spent),
        "flight": float(control.time_flight / spent),
        "at_rest": float(control.time_at_rest / spent),
        "friction_work": float(stepper.state.phase.friction_work.sum()) if stepper.column.slides else 0.0,
        "undamped_joints": sum(block.joint.damping == 0.0 for block in stepper.column.blocks),
        "observed_rows": 0,
        "wall_time": wall_time,
    }
