"""A whole run: from a column and a base motion to a response."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, overload

from ..column.column import Column
from ..column.packing import InitialState
from ..column.rest import check_rest
from ..common.errors import POSITIVE, InputError, SolverError, check_number, check_whole, shown
from ..common.ranges import check_choice
from ..dynamics.first_run import make_kernels
from ..dynamics.kinematics import chain_of
from ..dynamics.response import Response
from ..dynamics.uncertainty import Spread
from ..ground.motion import Motion, check_in_plane
from ..space.ensemble import ensemble_in_space
from ..space.in_plane import column_of
from ..space.response import SpatialResponse
from ..space.run import Callback as SpatialCallback
from ..space.run import SpatialState, simulate_structure
from ..space.structure import Structure
from .ensemble import ensemble_of
from .single_run import OUTPUT_STEP, SETTLE, Callback, Plan, output_times, single_run
from .trust import finer, judge

MOST_RUNS = 10**5


@overload
def simulate(
    column: Column,
    motion: Motion | str | os.PathLike[str],
    duration: float | None = None,
    formulation: str | None = None,
    integrator: str | None = None,
    step: float | None = None,
    tolerance: float | None = None,
    without: Sequence[str] | None = None,
    output_step: float | None = None,
    initial: InitialState | None = None,
    settle: float = SETTLE,
    check: bool = False,
    ensemble: int = 0,
    spread: Spread | None = None,
    callback: Callback | None = None,
) -> Response: ...
@overload
def simulate(
    column: Structure,
    motion: Motion | str | os.PathLike[str],
    duration: float | None = None,
    *,
    tolerance: float | None = None,
    without: Sequence[str] | None = None,
    output_step: float | None = None,
    initial: SpatialState | None = None,
    settle: float = SETTLE,
    check: bool = False,
    ensemble: int = 0,
    spread: Spread | None = None,
    callback: SpatialCallback | None = None,
    plane: None = None,
) -> SpatialResponse: ...
@overload
def simulate(
    column: Structure,
    motion: Motion | str | os.PathLike[str],
    duration: float | None = None,
    *,
    tolerance: float | None = None,
    without: Sequence[str] | None = None,
    output_step: float | None = None,
    initial: SpatialState | None = None,
    settle: float = SETTLE,
    check: bool = False,
    ensemble: int = 0,
    spread: Spread | None = None,
    callback: Any = None,
    plane: Literal["auto"],
) -> Response | SpatialResponse: ...
def simulate(
    column: Column | Structure,
    motion: Motion | str | os.PathLike[str],
    duration: float | None = None,
    formulation: str | None = None,
    integrator: str | None = None,
    step: float | None = None,
    tolerance: float | None = None,
    without: Sequence[str] | None = None,
    output_step: float | None = None,
    initial: Any = None,
    settle: float = SETTLE,
    check: bool = False,
    ensemble: int = 0,
    spread: Spread | None = None,
    callback: Any = None,
    plane: str | None = None,
) -> Response | SpatialResponse:
    """Response of a column, or of a structure in space, to a base motion or a record in a file, from its start.

    duration: s; None: that of the motion. Beyond the motion the base does not accelerate. initial: None is rest in
    static equilibrium. The other options are in four groups.

    Accuracy; None keeps the setting of the column. tolerance: relative to the peak. formulation, integrator, step (s):
    structures have none of these. without: names of settings.SKIPS, short cuts that are not to be taken; "peaks": those
    of ux only are kept. plane: "auto" gives the Response of a column, with joints rigid along themselves, for a
    structure that is one, begins at rest and is shaken in the plane x, z alone (space/in_plane.py).

    Output. output_step: s between the rows of the response; None: 0.005. It has no influence on the steps, and the
    peaks are those of the motion between the rows as well. callback: called as callback(t, single_run.Glance) with the
    time s reached, some times a second of the clock and at the end of each run; what it raises ends `simulate`.

    Verdict. settle: after `duration` the column is followed further, on a base that no longer accelerates, until it has
    fallen or cannot fall, for at most this time, s; the histories and the peaks end at `duration`.

    Trust. check: run once more at a tenth of the tolerance (half of a fixed step): `estimated_error` and `horizon` of
    the response, and a verdict that is "undecided" where the two differ. ensemble: number of further runs, varied by
    `spread` (uncertainty.py; None: the defaults); their results are the `ensemble` of the response.

    Warns (InputWarning) of values that are probably not intended (column/rest.py, `warnings_of`). Raises InputError for
    a wrong value or a rest that is not stable if the run starts from it, SolverError if the solver cannot go on.
    """
    if isinstance(motion, (str, os.PathLike)):
        motion = Motion.from_file(motion)
    duration = motion.duration if duration is None else _positive("duration", duration)
    output_step = OUTPUT_STEP if output_step is None else _positive("output_step", output_step)
    times = output_times(motion, duration, output_step)
    settle = 0.0 if settle == 0 else _positive("settle", settle)
    ensemble = check_whole("ensemble", ensemble, 0, MOST_RUNS, f"a number of runs, at most {MOST_RUNS}")
    plan, spread = Plan(motion, duration, times, initial, settle, callback), Spread() if spread is None else spread
    of_columns = {"formulation": formulation, "integrator": integrator, "step": step}
    if plane is not None:
        check_choice("plane", plane, ("auto",))
        if isinstance(column, Structure) and initial is None and not motion.has_ay:
            column = column_of(column) or column
    if isinstance(column, Structure):
        for name, value in of_columns.items():
            if value is not None:
                raise InputError(f"{name} = {shown(value)}: must be left out, structures in space have none")
        return _in_space(column.with_settings(tolerance=tolerance, without=without), plan, check, ensemble, spread)
    check_in_plane(motion)
    column = column.with_settings(tolerance=tolerance, without=without, **of_columns)  # type: ignore[arg-type]
    return _in_plane(column, plan, check, ensemble, spread)


def _in_space(structure: Structure, plan: Plan, check: bool, ensemble: int, spread: Spread) -> SpatialResponse:
    motion, duration, times, initial, settle, callback = plan
    found = simulate_structure(structure, motion, duration, times, initial, settle, check, callback)  # type: ignore
    if ensemble:
        found.ensemble = ensemble_in_space(found, motion, duration, settle, ensemble, spread)
    return found


def _in_plane(column: Column, plan: Plan, check: bool, ensemble: int, spread: Spread) -> Response:
    make_kernels()
    check_rest(column, from_rest=plan.initial is None)
    response, phases = single_run(column, plan)
    if check:
        top_displacements = chain_of(column).top_displacements
        ux = top_displacements(phases)
        try:
            closer, phases = single_run(finer(column), plan)
            judge(response, closer, ux, top_displacements(phases))
        except SolverError as failure:
            judge(response, failure, ux, None)
    if ensemble:
        response.ensemble = ensemble_of(response, plan, ensemble, spread)
    return response


def _positive(key: str, value: float) -> float:
    return check_number(key, value, POSITIVE, "a positive time in s")
