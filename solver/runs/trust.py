"""Accuracy of a run: it is repeated with smaller errors, and the two are compared."""

from __future__ import annotations

import math

import numpy as np

from ..column.column import Column
from ..column.packing import FloatArray
from ..common.errors import SolverError
from ..dynamics.response import Response
from ..dynamics.uncertainty import ErrorEstimate
from ..dynamics.verdict import UNDECIDED

FINER = 0.1  # of the tolerance
LEAST_TOLERANCE = 1e-13  # that a column may have
HALF = 0.5  # of a fixed step; the error of central differences is proportional to its square, so that
RICHARDSON = 4.0 / 3.0  # times the difference is the error
AGREE = 10.0  # tolerances
AGREE_AT_FIXED_STEPS = 1e-2  # of the peak: they have no tolerance
BEFORE_FALL = 0.1  # s: columns that fall differ shortly before, however close the runs are


def finer(column: Column) -> Column:
    """The column with settings for much smaller errors."""
    settings = column.settings
    if settings.integrator == "central-difference":
        return column.with_settings(step=HALF * settings.step)
    return column.with_settings(tolerance=max(LEAST_TOLERANCE, FINER * settings.tolerance))


def judge(response: Response, closer: Response | SolverError, ux: FloatArray, closer_ux: FloatArray | None) -> None:
    """Set estimated_error, horizon and, if the verdicts differ, the verdict of a response from the closer run."""
    if isinstance(closer, SolverError) or closer_ux is None:
        response.verdict, response.reason = UNDECIDED, f"the run that checks it failed: {closer}"
        return
    fixed = response.column.settings.integrator == "central-difference"
    factor = RICHARDSON if fixed else 1.0
    allowed = AGREE_AT_FIXED_STEPS if fixed else AGREE * response.column.settings.tolerance
    time = response.time
    fall = min((run.overturn_time for run in (response, closer) if run.overturned), default=math.inf)
    rows = int(np.searchsorted(time, fall - BEFORE_FALL)) or int(np.searchsorted(time, fall))
    difference = factor * np.max(np.abs(ux - closer_ux), axis=1)
    size = float(np.max(np.abs(closer_ux[:rows]), initial=0.0)) or 1.0
    peaks = {
        name: factor
        * np.abs(response.peaks[name] - other)
        / (1.0 if name == "contact" else np.where(other, other, 1.0))
        for name, other in closer.peaks.items()
    }
    response.estimated_error = ErrorEstimate(
        ux=float(np.max(difference[:rows], initial=0.0)) / size,
        peaks=peaks,
        overturn_time=abs(response.overturn_time - closer.overturn_time),
    )
    apart = np.flatnonzero(difference > allowed * size)
    response.horizon = float(time[max(int(apart[0]) - 1, 0)] if apart.size else time[-1])
    if response.verdict != closer.verdict:
        response.reason = (
            f"it is {response.verdict} at {_setting(response)}, and {closer.verdict} at {_setting(closer)}"
        )
        response.verdict = UNDECIDED


def _setting(response: Response) -> str:
    settings = response.column.settings
    if settings.integrator == "central-difference":
        return f"a step of {settings.step:g} s"
    return f"a tolerance of {settings.tolerance:g}"
