"""Columns as a kind of model (models/protocol.py): their runs alone and in lanes, and their results."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.errors import InputError
from ...ground.loads import check_loads_in_plane
from ...ground.motion import Motion
from ...kernels.column.api import entries
from ...kernels.layout import spaces
from ...kernels.machine.library import load
from ..protocol import LANES, LOADED, OVERTURNED, Kind, Lanes, NoRestError, Run, RunPlan, Work, code_of, output_times
from ..uncertainty import Varied
from .kinematics import Chain, chain_of
from .lane_policy import HELD, IN_LANES, first_step_of, kind_of, reason_against_lanes
from .lanes import KINDS, LaneKernels, follow_in_lanes, lanes_of
from .model import Column
from .numbers import column_with, is_of_column, numbers_set, single_names
from .outputs import KEPT, KEYS, OUTPUTS, WATCHED
from .packing import FloatArray
from .response import Response
from .rest import check_stable, known_warnings, warnings_of
from .run import outcome, single_run
from .settling import outcomes_of

LEFT = ("residual_ux", "residual_theta", "residual_slip", "energy")  # results that follow from the phase at the end
AT_ROWS = "peak_centroid_ux"  # the largest value of the rows of a run alone
MOST_DAMPED = 0.5  # fraction of implicit steps above which lanes, whose steps are explicit, are no faster
ALONE = 10.0  # cost of a run alone, relative to lanes


class Columns(Kind):
    """The kind of columns in their plane, with finite rotations; models/paper/kind.py has other equations."""

    entries: ModuleType = entries  # the kernels
    chain: type[Chain] = Chain  # what a phase means
    own_lanes: LaneKernels | None = None  # the only kind of lanes; None: those of lanes.py
    fixed = False  # whether the steps are those of the settings
    takes_loads = True
    why_not = staticmethod(reason_against_lanes)

    word = "column"
    settings = ("formulation", "integrator", "step", "tolerance", "without")
    outputs = OUTPUTS
    largest, displacements = "ux", "peak_top_ux"
    kept, keys = KEPT, KEYS

    def snapshot_size(self, model: Column) -> int:
        """Return the length of a snapshot."""
        return spaces.snapshot_size(model.n, model.has_slips, model.is_brittle)

    def warnings(self, model: Column, at_rest: bool = True) -> Sequence[str]:
        """Return the warnings of rest.py; those `at_rest` are cached for repeated calls."""
        return known_warnings(model) if at_rest else warnings_of(model)

    def check(self, model: Column, from_rest: bool) -> None:
        if from_rest:
            check_stable(model)

    def check_motion(self, motion: Motion) -> None:
        """Raise InputError for a motion or loads that leave the plane."""
        super().check_motion(motion)
        check_loads_in_plane(motion.loads)

    def load_for_single_runs(self) -> None:
        load(self.entries.run.group)

    def single_run(self, model: Column, plan: RunPlan) -> tuple[Response, FloatArray]:
        """Run a column; return the response and ux of the top faces at its rows, m (rows, n)."""
        self.load_for_single_runs()  # before the clock starts
        response, phases = single_run(model, plan)
        return response, chain_of(model).top_displacements(phases)

    def least_checked(self, model: Column) -> float:
        return 1e-11  # a step has a tenth of the tolerance, 1e-13 at least

    # --- many

    def check_kept(self, model: Column, keep: Collection[str]) -> None:
        asked = [name for name in keep if name in WATCHED]
        if asked and "peaks" in model.settings.without:
            raise InputError(f'solver.without has "peaks", must not where {asked[0]} is kept')

    def lanes(self, model: Column, keep: Collection[str]) -> Lanes:
        """Return how runs are made in lanes, which watch the peaks of ux only."""
        return Lanes(self.reason_for_single_run(model, keep), (model.n, kind_of(model)), first_step_of(model))

    def reason_for_single_run(self, model: Column, keep: Collection[str]) -> str:
        """Return the reason against lanes; "" if they are used, unless the motion has HELD samples."""
        watched = WATCHED.isdisjoint(keep) and AT_ROWS not in keep
        return self.why_not(model) or ("" if watched else "peaks of more than ux")

    def under(self, model: Column, motion: Motion) -> tuple[str, Hashable]:
        """Return the reason against lanes under a motion: loads or held samples."""
        return LOADED if motion.loads else HELD if motion.hold else "", None

    def load(self, model: Column, keep: Collection[str]) -> None:
        load(KINDS[kind_of(model)].follow.group)

    def follow(
        self, runs: Sequence[Run], keep: Collection[str], settle: float, flag: FloatArray
    ) -> tuple[dict[str, NDArray[Any]], NDArray[np.bool_]]:
        """Run columns of equal numbers of blocks in lanes of one kind; see `Kind.follow`."""
        columns, motions, durations = zip(*runs, strict=True)
        batch = follow_in_lanes(columns, motions, durations, flag=flag)
        if flag[0]:
            return {}, batch.finished
        # results from the phases at the end
        if lanes_of(columns).slips:
            chain = None
            chains = [chain_of(column) for column in columns]
            left = {name: np.array([*map(partial(_at_the_end, name), chains, batch.ends)]) for name in _left(keep)}
        else:
            chain = self.chain.of_many(batch.models, columns[0].n)
            left = {name: np.array(_at_the_end(name, chain, batch.ends)) for name in _left(keep)}
        for values in left.values():
            values[batch.fallen > 0] = math.nan
        # verdicts; unfinished runs are repeated alone later
        words, times, joints = np.full(len(runs), code_of("verdict", OVERTURNED)), batch.overturn_time, batch.fallen
        ended = np.flatnonzero(batch.finished & (joints == 0))
        if ended.size:
            some, phases = None if chain is None else chain.some(ended), batch.ends[ended]
            stops = np.array([runs[k].motion.start + runs[k].duration for k in ended.tolist()])
            found = outcomes_of([columns[k] for k in ended.tolist()], some, phases, stops, settle, flag)
            words[ended], times[ended], joints[ended] = found
        made: dict[str, NDArray[Any]] = {
            **left,
            "peak_ux": batch.peak_top_ux,
            "verdict": words,
            "overturn_time": times,
            "overturned_joint": joints,
            "steps": batch.steps,
            "evaluations": batch.evaluations,
            "path": np.full(len(runs), code_of("path", LANES)),
        }
        return made, batch.finished

    def alone(self, run: Run, keep: Collection[str], settle: float, look: Callable[..., object]) -> dict[str, Any]:
        """Run one column alone, without the peaks that are not stored; see `Kind.alone`."""
        stop = run.motion.start + run.duration
        rows = output_times(run.motion, run.duration) if AT_ROWS in keep else np.array([])
        times = np.append(rows[rows < stop], stop)
        column = run.model
        if WATCHED.isdisjoint(keep):
            column = column.with_settings(without=(*column.settings.without, "peaks"))  # except those of ux
        response, phases = single_run(column, RunPlan(run.motion, run.duration, times, None, settle, look))
        stands = not response.overturn_time <= stop
        left = {
            name: _at_the_end(name, chain_of(run.model), phases[-1]) if stands else math.nan for name in _left(keep)
        }
        return {name: left[name] if name in left else response.kept(name) for name in keep}

    def work(self, model: Column, keep: Collection[str]) -> Work:
        return Work(0.0, model.n * (ALONE if self.reason_for_single_run(model, keep) else 1.0))

    # --- numbers by name

    def has_number(self, model: Column, name: str) -> bool:
        return is_of_column(name)

    def numbers_of(self, model: Column, name: str) -> list[str]:
        return single_names(name, model.n)

    def numbers_set(self, model: Column, name: str) -> list[str]:
        return numbers_set(model, name)

    def with_numbers(self, model: Column, values: Mapping[str, tuple[float, bool]]) -> Column:
        return column_with(model, values)

    # --- an ensemble

    def in_lanes(self, response: Response, plan: RunPlan) -> bool:
        """Return True for the linear law if most steps are explicit and the run starts from rest."""
        column = response.model
        known = column.sections <= IN_LANES and not (column.other_law or column.is_brittle)
        fits = known and set(column.settings.without) <= {"peaks"}
        explicit = response.stats["implicit_steps"] <= MOST_DAMPED * response.stats["steps"]
        return fits and explicit and not self.under(column, plan.motion)[0] and plan.initial is None

    def varied_in_lanes(self, pairs: Sequence[tuple[Column, Motion]], plan: RunPlan) -> list[Varied | None]:
        """Run varied columns in lanes, with the histories of ux at the rows of the plan."""
        made: list[Varied | None] = [None] * len(pairs)
        places = [k for k, (column, _) in enumerate(pairs) if _stands(column)]
        if not places:
            return made
        columns, motions = zip(*(pairs[k] for k in places), strict=True)
        start, duration = plan.motion.start, plan.duration
        times = np.append(plan.times - start, duration)
        batch = follow_in_lanes(columns, motions, [duration] * len(columns), times)
        for k, (place, column) in enumerate(zip(places, columns, strict=True)):
            if not batch.finished[k]:
                continue
            verdict, fall = OVERTURNED, float(batch.overturn_time[k])
            if not batch.fallen[k]:
                verdict, fall, _ = outcome(column, batch.phases[k, -1], start + duration, plan.settle)
            ux = chain_of(column).top_displacements(batch.phases[k, :-1])
            made[place] = Varied(verdict, fall, batch.peak_top_ux[k], ux)
        return made


KIND = Columns()


def _stands(column: Column) -> bool:
    """Return True if the rest under gravity is stable."""
    try:
        check_stable(column)
    except NoRestError:
        return False
    return True


def _left(keep: Collection[str]) -> list[str]:
    return [name for name in LEFT if name in keep]


def _at_the_end(name: str, chain: Chain, phase: FloatArray) -> Any:
    """Return a result of LEFT from the phase of a column, or from the phases of many."""
    if name == "energy":
        return chain.energies(phase)
    if name == "residual_ux":
        return chain.top_displacements(phase)
    places = chain.places(phase)
    return places.theta if name == "residual_theta" else np.broadcast_to(places.slip - chain.offset, places.theta.shape)
