"""Structures in space as a kind of model (models/protocol.py): their runs alone and in lanes, and what can be kept."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.errors import InputError
from ...ground.motion import Motion
from ...kernels.machine.library import load
from ...kernels.structure.entries import run_structures_in_lanes
from ...kernels.structure.layout import RINGING_ORDER
from ..column.model import Column
from ..column.numbers import SIZE, SLENDERNESS, column_with, is_of_column, numbers_set, widen_ports
from ..protocol import LOADED, SETTLE, Kind, Lanes, NoRestError, Run, RunPlan, Work, table_entry
from ..uncertainty import Varied
from .blocks.faces import FloatArray
from .blocks.parts import OF_COLUMN
from .lanes import follow_in_lanes, is_flat_run, longest_step_of, share_of
from .model import Structure
from .numbers import (
    is_of_neighbours,
    is_of_structure,
    numbers_set_in_space,
    resize,
    single_names_in_space,
    structure_with,
)
from .outputs import ALWAYS_KEPT, DISPLACEMENTS, FROM_LANES, KEPT, KEYS, OUTPUTS
from .response import SpatialResponse
from .rest import SpatialRest, known_warnings_in_space, rest_of
from .run import single_run
from .stack import column_of

# fraction of steps by modes and stabilized ones above which lanes, whose steps are explicit, are no faster
MOST_OTHERS = 0.5
WORK = 50.0  # cost of a block for a second in a run alone, relative to a column in lanes


class Structures(Kind):
    """Structures in space as a kind of model."""

    word = "structure"
    across = True
    takes_loads = True
    outputs = OUTPUTS
    largest = "u"
    kept, keys = KEPT, KEYS
    usually_kept = ("peak_u", "peak_centroid_ux", "verdict")

    def warnings(self, model: Structure, at_rest: bool = True) -> Sequence[str]:
        return known_warnings_in_space(model, at_rest)

    def check(self, model: Structure, from_rest: bool) -> None:
        if from_rest:
            rest_of(model)

    def equivalent_model(self, model: Structure, motion: Motion) -> Structure | Column:
        """Return the equivalent column if the motion stays in its plane and loads no ports; else the structure."""
        return model if motion.has_ay or motion.loads else column_of(model) or model

    def single_run(self, model: Structure, plan: RunPlan) -> tuple[SpatialResponse, FloatArray]:
        """Return the response, and ux, uy, uz of the centroids, (rows, 3 n) m."""
        response = single_run(model, plan)
        return response, response.rows[:, : 3 * model.n]

    def largest_of(self, response: SpatialResponse, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the peaks and the histories of the horizontal displacement, in any direction (m)."""
        n = response.model.n
        return response.peaks["u"], np.hypot(places[:, :n], places[:, n : 2 * n])

    def least_checked(self, model: Structure) -> float:
        return 1e-8 if model.model.names.settings.order == RINGING_ORDER else 1e-11  # steps have the errors of rounding

    # --- many

    def lanes(self, model: Structure, keep: Collection[str]) -> Lanes:
        """Return how runs use lanes, which record displacements and gaps only, by steps of order 5."""
        why = _reason_against_lanes(model, keep)
        if not why:
            try:
                rest_of(model)
            except NoRestError:
                why = "no rest"
        return Lanes(why, share_of(model), longest_step_of(model))

    def under(self, model: Structure, motion: Motion) -> tuple[str, Hashable]:
        """Return the group of a motion: runs that stay in a plane share lanes; those with loads run alone."""
        return LOADED if motion.loads else "", is_flat_run(model, motion)

    def load(self, model: Structure, keep: Collection[str]) -> None:
        if not _reason_against_lanes(model, keep):
            load(run_structures_in_lanes.group)

    def follow(
        self, runs: Sequence[Run], keep: Collection[str], settle: float, flag: FloatArray
    ) -> tuple[dict[str, NDArray[Any]], NDArray[np.bool_]]:
        made = follow_in_lanes(runs, [rest_of(run.model) for run in runs], settle, flag)
        finished = np.array([bool(one) for one in made])
        some = next((one for one in made if one), None)
        if some is None:
            return {}, finished
        return {name: np.array([table_entry(name, (one or some)[name]) for one in made]) for name in keep}, finished

    def check_kept(self, model: Structure, keep: Collection[str]) -> None:
        known = {*ALWAYS_KEPT, "peak_u", *(f"peak_{name}" for name in DISPLACEMENTS)}
        asked = [name for name in keep if name not in known]
        if asked and "peaks" in model.without:
            raise InputError(f'solver.without has "peaks", must not where {asked[0]} is kept')

    def alone(self, run: Run, keep: Collection[str], settle: float, look: Callable[..., object]) -> dict[str, Any]:
        """Run one structure alone, without the peaks that are not stored; see `Kind.alone`."""
        watches = any(name not in (*ALWAYS_KEPT, "peak_u") for name in keep)
        structure = run.model if watches else run.model.with_settings(without=(*run.model.without, "peaks"))
        return super().alone(run._replace(model=structure), keep, settle, look)

    def work(self, model: Structure, keep: Collection[str]) -> Work:
        second = WORK * model.n
        return Work(second * SETTLE, second)

    # --- an ensemble

    def in_lanes(self, response: SpatialResponse, plan: RunPlan) -> bool:
        """Return True if most steps are explicit and the run starts from rest."""
        model, stats = response.model, response.stats
        fits = not _reason_against_lanes(model, ("peak_u",)) and set(model.settings.without) <= {"peaks"}
        others = stats["elastic_steps"] + stats["stabilized_steps"]
        fits = fits and others <= MOST_OTHERS * stats["steps"] and not plan.motion.loads
        return fits and plan.initial is None

    def varied_in_lanes(self, pairs: Sequence[tuple[Structure, Motion]], plan: RunPlan) -> list[Varied | None]:
        """Run varied structures in lanes, with histories of the horizontal displacement at the rows of the plan."""
        made: list[Varied | None] = [None] * len(pairs)
        rests: dict[int, SpatialRest] = {}
        for k, (model, _) in enumerate(pairs):
            with suppress(NoRestError):
                rests[k] = rest_of(model)
        if not rests:
            return made
        runs = [Run(*pairs[k], plan.duration) for k in rests]
        times = plan.times - plan.motion.start
        for k, found in zip(rests, follow_in_lanes(runs, list(rests.values()), plan.settle, times=times), strict=True):
            if found:
                made[k] = Varied(found["verdict"], found["overturn_time"], found["peak_u"], found["places"])
        return made

    # --- numbers by name: a stack has the numbers of its column, and the laws of joints and neighbours in space

    def has_number(self, model: Structure, name: str) -> bool:
        return is_of_structure(name) if not model.is_stack else is_of_column(name) or _is_of_space(name)

    def numbers_of(self, model: Structure, name: str) -> list[str]:
        return single_names_in_space(name, model)

    def numbers_set(self, model: Structure, name: str) -> list[str]:
        if model.is_stack and not _is_of_space(name):
            return numbers_set(Column.from_dict(model.to_dict()[OF_COLUMN]), name)
        return numbers_set_in_space(name, model)

    def with_numbers(self, model: Structure, values: Mapping[str, tuple[float, bool]]) -> Structure:
        if model.is_stack:
            of_column = {name: value for name, value in values.items() if not _is_of_space(name)}
            if of_column:
                data = model.to_dict()
                column = Column.from_dict(data.pop(OF_COLUMN))
                changed = column_with(column, of_column).to_dict()
                if SIZE in of_column:
                    resize(data, of_column[SIZE][0])
                if SLENDERNESS in of_column:
                    widened = column_with(column, {SLENDERNESS: of_column[SLENDERNESS]})
                    widen_ports(data, widened.blocks[-1].width / column.blocks[-1].width)
                model = Structure.from_dict({**data, OF_COLUMN: changed})
            values = {name: value for name, value in values.items() if _is_of_space(name)}
        return structure_with(model, values)


STRUCTURES = Structures()


def _reason_against_lanes(structure: Structure, keep: Collection[str]) -> str:
    """Return the reason why runs of a structure at rest cannot use lanes, or ""."""
    if not FROM_LANES.issuperset(keep):
        return "peaks of more than displacements and gaps"
    if structure.after_fall:
        return "the run goes on after a fall"
    return "" if structure.model.names.settings.order == 5.0 else "steps of order 8"


def _is_of_space(name: str) -> bool:
    """Return True if a name of a stack belongs to the law of a joint in space or to neighbours, not to its column."""
    return is_of_neighbours(name) or (name.startswith("joint") and is_of_structure(name))
