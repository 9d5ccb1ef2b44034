"""A whole run: from a column and a base motion to a response."""

from __future__ import annotations

from collections.abc import Sequence

from ..column.column import Column
from ..column.packing import InitialState
from ..column.rest import check_rest
from ..common.errors import POSITIVE, InputError, SolverError, check_number, check_whole
from ..dynamics.first_run import make_kernels
from ..dynamics.kinematics import chain_of
from ..dynamics.response import Response
from ..dynamics.uncertainty import Spread
from ..ground.motion import Motion
from .ensemble import ensemble_of
from .single_run import OUTPUT_STEP, SETTLE, Callback, output_times, single_run
from .trust import finer, judge

MOST_ROWS = 10**8
MOST_RUNS = 10**5


def simulate(
    column: Column,
    motion: Motion,
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
) -> Response:
    """Response of a column to a base motion, from the start of the motion.

    duration: s; None: that of the motion. Beyond the motion the base does not accelerate.
    formulation, integrator, step (s), tolerance (relative to the peak), without (names of column.SKIPS: short cuts that
    are not to be taken; "peaks": those of ux only are kept): None keeps the column's.
    output_step: s between the rows of the response; None: 0.005. It has no influence on the steps, and the peaks are
    those of the motion between the rows as well.
    initial: None is rest in static equilibrium.
    settle: after `duration` the column is followed further, on a base that no longer accelerates, until it has fallen
    or cannot fall, for at most this time, s; the histories and the peaks end at `duration`.
    check: run once more at a tenth of the tolerance (half of a fixed step): `estimated_error` and `horizon` of the
    response, and a verdict that is "undecided" where the two differ.
    ensemble: number of further runs, varied by `spread` (uncertainty.py; None: the defaults); their results are the
    `ensemble` of the response.
    callback: called as callback(t, single_run.Glance) with the time s reached, some times a second of the clock and
    at the end of each run; what it raises ends `simulate`.

    Warns (InputWarning) of values that are probably not intended (rest.py, `warnings_of`). Raises InputError for a
    wrong value or a rest that is not stable if the run starts from it, SolverError if the solver cannot go on.
    """
    column = column.with_settings(
        formulation=formulation, integrator=integrator, step=step, tolerance=tolerance, without=without
    )
    duration = motion.duration if duration is None else _positive("duration", duration)
    output_step = OUTPUT_STEP if output_step is None else _positive("output_step", output_step)
    if duration / output_step > MOST_ROWS:
        raise InputError(f"output_step = {output_step}: must be larger, for at most {MOST_ROWS} rows in {duration} s")
    settle = 0.0 if settle == 0 else _positive("settle", settle)
    ensemble = check_whole("ensemble", ensemble, 0, MOST_RUNS, f"a number of runs, at most {MOST_RUNS}")
    make_kernels()
    check_rest(column, from_rest=initial is None)
    times = output_times(motion, duration, output_step)
    response, phases = single_run(column, motion, duration, times, initial, settle, callback)
    if check:
        top_displacements = chain_of(column).top_displacements
        ux = top_displacements(phases)
        try:
            closer, phases = single_run(finer(column), motion, duration, times, initial, settle, callback)
            judge(response, closer, ux, top_displacements(phases))
        except SolverError as failure:
            judge(response, failure, ux, None)
    if ensemble:
        varied = spread or Spread()
        response.ensemble = ensemble_of(response, motion, duration, initial, settle, ensemble, varied, callback)
    return response


def _positive(key: str, value: float) -> float:
    return check_number(key, value, POSITIVE, "a positive time in s")
