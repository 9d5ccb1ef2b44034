"""A whole run: a column, a base motion, and what comes out."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence

import numpy as np

from .column import Column
from .errors import InputError
from .motion import Motion
from .packing import InitialState
from .response import Response
from .stepper import Stepper

OUTPUT_STEP = 0.005  # s, where none is asked for
MOST_ROWS = 10**8


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
) -> Response:
    """Response of a column to a base motion, from the start of the motion.

    duration: s; None: that of the motion. Beyond the motion the base does not accelerate.
    formulation, integrator, step (s), tolerance (relative to the peak), without (names of column.SKIPS, short cuts that
    are not to be taken): None keeps the column's.
    output_step: s between the rows of the response; None: 0.005. It has no influence on the steps, and the peaks are
    those of the motion between the rows as well.
    initial: None is rest in static equilibrium.

    Raises InputError for a wrong value, SolverError where the solver cannot go on.
    """
    column = column.with_settings(
        formulation=formulation, integrator=integrator, step=step, tolerance=tolerance, without=without
    )
    duration = motion.duration if duration is None else _positive("duration", duration)
    output_step = OUTPUT_STEP if output_step is None else _positive("output_step", output_step)
    if duration / output_step > MOST_ROWS:
        raise InputError(f"output_step = {output_step}: must be larger, for at most {MOST_ROWS} rows in {duration} s")
    stepper = Stepper(column, initial)
    times = motion.start + output_step * np.arange(math.floor(duration / output_step + 1e-9) + 1, dtype=np.float64)
    begin = clock.perf_counter()
    snapshots = stepper.run(motion, motion.start + duration, times)
    wall_time = clock.perf_counter() - begin
    control, counts = stepper.state.control, stepper.counts
    per_spent = 1.0 / max(stepper.time_spent, math.ulp(0.0))
    response = Response(
        column,
        times,
        lambda: stepper.rows_of(snapshots),
        peak_ux=stepper.peaks.copy(),
        overturned_joint=stepper.overturned_joint,
        overturn_time=stepper.overturn_time,
        stats={
            "steps": int(counts.steps),
            "implicit_steps": int(counts.implicit_steps),
            "elastic_steps": int(counts.elastic_steps),
            "rejected": int(counts.rejected),
            "events": int(counts.events),
            "evaluations": int(counts.evaluations),
            "sweeps": int(counts.sweeps),
            "full_contact": float(control.time_full * per_spent),
            "rocking": float(control.time_rocking * per_spent),
            "flight": float(control.time_flight * per_spent),
            "at_rest": float(control.time_at_rest * per_spent),
            "undamped_joints": sum(block.joint.damping == 0.0 for block in column.blocks),
            "observed_rows": 0,
            "wall_time": wall_time,
        },
    )
    if "resultants" in column.settings.without:
        response.observe()
    return response


def _positive(key: str, value: float) -> float:
    if not (isinstance(value, (int, float)) and math.isfinite(value) and value > 0.0):
        raise InputError(f"{key} = {value!r}: must be a positive time in s")
    return float(value)
