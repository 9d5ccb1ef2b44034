"""Columns as a kind of model (models/protocol.py): their runs alone and in lanes, and what can be kept of them."""

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
from ...kernels.api import entries
from ...kernels.bonds import entries as with_bonds
from ...kernels.bonds import layout as of_bonds
from ...kernels.layout import spaces
from ...kernels.machine.library import load
from ...kernels.ports import entries as with_ports
from ..protocol import LANES, LOADED, OVERTURNED, Kind, Lanes, Plan, Run, Work, code_of
from ..uncertainty import Varied
from .kept import KEPT, WATCHED
from .kinematics import Chain, chain_of
from .lane_policy import HELD, first_step_of, kind_of, why_not_in_lanes
from .lanes import BatchResult, LaneKernels, follow_in_lanes, lanes_of, load_kernels
from .model import Column
from .numbers import column_with, is_of_column, single_names
from .outputs import OUTPUTS
from .packing import FloatArray, IntArray
from .response import Response
from .rest import check_stable, known_warnings, warnings_of
from .run import outcome, single_run
from .settling import outcomes_of

LEFT = ("residual_ux", "residual_theta", "residual_slip", "energy")  # results from the phase at the end
MOST_DAMPED = 0.5  # of the steps implicit: beyond it lanes, which step explicitly, gain nothing
ALONE = 10.0  # work of a run alone, over that in lanes


class Columns(Kind):
    """Columns in their plane, with finite rotations; models/paper/kind.py has other equations.

    entries: module of the kernels; spaces: that of their spaces; chain: what a phase means; own_lanes: all that it has,
    None: those of lanes.py; fixed: whether the steps are those of the settings.
    """

    entries: ModuleType = entries
    spaces: ModuleType = spaces
    chain: type[Chain] = Chain
    own_lanes: LaneKernels | None = None
    fixed = False
    takes_loads = True
    why_not = staticmethod(why_not_in_lanes)

    word = "column"
    settings = ("formulation", "integrator", "step", "tolerance", "without")
    outputs = OUTPUTS
    largest = "ux"
    kept = KEPT

    def snapshot_size(self, model: Column) -> int:
        """Numbers of a snapshot."""
        return spaces.snapshot_size(model.n, model.has_slips)

    def warnings(self, model: Column, at_rest: bool = True) -> Sequence[str]:
        """As of rest.py; at_rest: kept for a column that is asked about again."""
        return known_warnings(model) if at_rest else warnings_of(model)

    def check(self, model: Column, from_rest: bool) -> None:
        """Its rest is stable."""
        if from_rest:
            check_stable(model)

    def check_motion(self, motion: Motion) -> None:
        """It stays in the plane, and so do loads."""
        super().check_motion(motion)
        check_loads_in_plane(motion.loads)

    def single_run(self, model: Column, plan: Plan) -> tuple[Response, FloatArray]:
        """A response, and ux of the tops."""
        load(self.entries.run.group)  # before the clock starts
        response, phases = single_run(model, plan)
        return response, chain_of(model).top_displacements(phases)

    # --- many

    def check_kept(self, model: Column, keep: Collection[str]) -> None:
        """It computes the peaks that are asked for."""
        asked = [name for name in keep if name in WATCHED]
        if asked and "peaks" in model.settings.without:
            raise InputError(f'solver.without has "peaks", must not where {asked[0]} is kept')

    def lanes(self, model: Column, keep: Collection[str]) -> Lanes:
        """Lanes watch the peaks of ux alone."""
        return Lanes(self.why_alone(model, keep), (model.n, kind_of(model)), first_step_of(model))

    def why_alone(self, model: Column, keep: Collection[str]) -> str:
        """Why runs of a column are not made in lanes; empty where they are, unless the motion has HELD samples."""
        return self.why_not(model) or ("" if WATCHED.isdisjoint(keep) else "peaks of more than ux")

    def under(self, model: Column, motion: Motion) -> tuple[str, Hashable]:
        """Lanes know no held samples and no loads."""
        return LOADED if motion.loads else HELD if motion.hold else "", None

    def load(self, model: Column, keep: Collection[str]) -> None:
        """The kernels of its kind of lanes."""
        load_kernels(kind_of(model))

    def follow(
        self, runs: Sequence[Run], keep: Collection[str], settle: float, flag: FloatArray
    ) -> tuple[dict[str, NDArray[Any]], NDArray[np.bool_]]:
        """Runs of columns of equal numbers of blocks, in lanes of one kind."""
        columns, motions, durations = zip(*runs, strict=True)
        batch = follow_in_lanes(columns, motions, durations, flag=flag)
        if flag[0]:
            return {}, batch.finished
        if lanes_of(columns).slips:
            chain = None
            chains = [chain_of(column) for column in columns]
            left = {name: np.array([*map(partial(_at_the_end, name), chains, batch.ends)]) for name in _left(keep)}
        else:
            chain = self.chain.of_many(batch.models, columns[0].n)
            left = {name: np.array(_at_the_end(name, chain, batch.ends)) for name in _left(keep)}
        for values in left.values():
            values[batch.overturned_joint > 0] = math.nan
        words, times, joints = _verdicts(runs, batch, chain, settle, flag)
        made: dict[str, NDArray[Any]] = {
            **left,
            "peak_ux": batch.peak_ux,
            "verdict": words,
            "overturn_time": times,
            "overturned_joint": joints,
            "steps": batch.steps,
            "evaluations": batch.evaluations,
            "path": np.full(len(runs), code_of("path", LANES)),
        }
        return made, batch.finished

    def alone(self, run: Run, keep: Collection[str], settle: float, look: Callable[..., object]) -> dict[str, Any]:
        """Without peaks that are not kept."""
        end = np.array([run.motion.start + run.duration])
        column = run.model
        if WATCHED.isdisjoint(keep):
            column = column.with_settings(without=(*column.settings.without, "peaks"))  # but those of ux
        response, phases = single_run(column, Plan(run.motion, run.duration, end, None, settle, look))
        stands = not response.overturn_time <= end[0]
        left = {name: _at_the_end(name, chain_of(run.model), phases[0]) if stands else math.nan for name in _left(keep)}
        return {name: left[name] if name in left else response.kept(name) for name in keep}

    def work(self, model: Column, keep: Collection[str]) -> Work:
        """By whether it is in lanes."""
        return Work(0.0, model.n * (ALONE if self.why_alone(model, keep) else 1.0))

    # --- numbers by name

    def has_number(self, model: Column, name: str) -> bool:
        return is_of_column(name)

    def numbers_of(self, model: Column, name: str) -> list[str]:
        return single_names(name, model.n)

    def with_numbers(self, model: Column, values: Mapping[str, tuple[float, bool]]) -> Column:
        return column_with(model, values)

    # --- an ensemble

    def in_lanes(self, response: Response, plan: Plan) -> bool:
        """Those of the linear law whose steps are mostly explicit, from rest."""
        column = response.column
        fits = not (column.other_law or column.is_brittle or column.has_bands) and set(column.settings.without) <= {
            "peaks"
        }
        explicit = response.stats["implicit_steps"] <= MOST_DAMPED * response.stats["steps"]
        return fits and explicit and not self.under(column, plan.motion)[0] and plan.initial is None

    def varied_in_lanes(self, pairs: Sequence[tuple[Column, Motion]], plan: Plan) -> list[Varied | None]:
        """With the histories of ux at the rows of the plan."""
        columns, motions = zip(*pairs, strict=True)
        start, duration = plan.motion.start, plan.duration
        times = np.append(plan.times - start, duration)
        batch = follow_in_lanes(columns, motions, [duration] * len(columns), times)
        made: list[Varied | None] = []
        for k, column in enumerate(columns):
            if not batch.finished[k]:
                made.append(None)
                continue
            verdict, fall = OVERTURNED, float(batch.overturn_time[k])
            if not batch.overturned_joint[k]:
                verdict, fall, _ = outcome(column, batch.phases[k, -1], start + duration, plan.settle)
            ux = chain_of(column).top_displacements(batch.phases[k, :-1])
            made.append(Varied(verdict, fall, batch.peak_ux[k], ux))
        return made


class ColumnsWithPorts(Columns):
    """Columns with points at which loads act, and kernels that know these."""

    entries = with_ports


class BrittleColumns(Columns):
    """Columns with joints that are bonded until they break, and kernels that know these."""

    entries = with_bonds
    spaces = of_bonds

    def snapshot_size(self, model: Column) -> int:
        """With what is bonded."""
        return of_bonds.snapshot_size(model.n)


KIND, WITH_PORTS, BRITTLE = Columns(), ColumnsWithPorts(), BrittleColumns()


def _left(keep: Collection[str]) -> list[str]:
    return [name for name in LEFT if name in keep]


def _verdicts(
    runs: Sequence[Run], batch: BatchResult, chain: Chain | None, settle: float, flag: FloatArray
) -> tuple[IntArray, FloatArray, IntArray]:
    """Numbers of the words, times of overturning (NaN: it stands) and joints; undecided runs are followed further.

    chain: None for columns that have slips, which are followed one by one.
    """
    joints, times = batch.overturned_joint.copy(), batch.overturn_time.copy()
    words = np.full(len(runs), code_of("verdict", OVERTURNED))  # or not finished: such runs are made again alone
    ended = np.flatnonzero(batch.finished & (joints == 0))
    stops = np.array([run.motion.start + run.duration for run in runs])
    if chain is not None and ended.size:
        columns = [runs[k].model for k in ended.tolist()]
        found = outcomes_of(columns, chain.some(ended), batch.ends[ended], stops[ended], settle, flag)
        words[ended], times[ended], joints[ended] = found
    elif chain is None:
        for k in ended.tolist():
            if flag[0]:
                break
            word, times[k], joints[k] = outcome(runs[k].model, batch.ends[k], float(stops[k]), settle)
            words[k] = code_of("verdict", word)
    return words, times, joints


def _at_the_end(name: str, chain: Chain, phase: FloatArray) -> Any:
    """One of LEFT, of a column with this phase, or of many with a phase each."""
    if name == "energy":
        return chain.energies(phase)
    if name == "residual_ux":
        return chain.top_displacements(phase)
    places = chain.places(phase)
    return places.theta if name == "residual_theta" else np.broadcast_to(places.slip - chain.offset, places.theta.shape)
