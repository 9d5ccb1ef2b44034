"""The accuracy of a run, estimated by comparison with a repetition of smaller errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..common.aliases import Renamed, aliases_of
from ..common.errors import InputError, SolverError
from ..models.column.packing import FloatArray
from ..models.protocol import UNDECIDED
from ..models.uncertainty import ErrorEstimate

FINER = 0.1  # of the tolerance
HALF = 0.5  # of a fixed step; the error of central differences is proportional to its square, so that
RICHARDSON = 4.0 / 3.0  # times the difference is the error
AGREE = 10.0  # tolerances
AGREE_AT_FIXED_STEPS = 1e-2  # of the peak: fixed steps have no tolerance
LEAST = "contact", "bond", "gap"  # peaks of which the least values are kept
# s, and part of the time to the fall: the runs of a column that falls differ shortly before, even for small errors
BEFORE_FALL, OF_FALL = 0.1, 0.1


def with_fine_settings(model: Any) -> Any:
    """Return the model with settings for much smaller errors.

    Raises InputError if its tolerance is so small that a smaller one changes little or nothing.
    """
    if _is_fixed(model):
        return model.with_settings(step=HALF * model.settings.step)
    given, least = model.settings.tolerance, model.kind.least_checked(model)
    if given < least:
        why = "steps cannot be ten times more accurate, which would check them"
        raise InputError(f"solver.tolerance = {given:g}: must be at least {least:g} for a run that is checked: {why}")
    return model.with_settings(tolerance=FINER * given)


def judge(response: Any, closer: Any, places: FloatArray, closer_places: FloatArray | None) -> None:
    """Set estimated error, horizon and, if the verdicts differ, the verdict of a response.

    Parameters
    ----------
    response : Response or SpatialResponse
        Modified in place.
    closer : Response, SpatialResponse or SolverError
        The run with smaller errors, or the error that ended it.
    places, closer_places : array (nt, any number)
        Displacements of both runs at the rows, m; None for a run that ended with an error.
    """
    if isinstance(closer, SolverError) or closer_places is None:
        response.verdict, response.reason = UNDECIDED, f"the run that checks it failed: {closer}"
        return
    fixed = _is_fixed(response.model)
    factor = RICHARDSON if fixed else 1.0
    allowed = AGREE_AT_FIXED_STEPS if fixed else AGREE * response.model.settings.tolerance
    # compare up to shortly before a fall of either
    count = min(len(places), len(closer_places))  # after a fall both may go on, not equally long
    time, places, closer_places = response.time[:count], places[:count], closer_places[:count]
    fall = min((run.overturn_time for run in (response, closer) if run.overturned), default=math.inf)
    shortly = min(BEFORE_FALL, OF_FALL * (fall - float(time[0])))
    rows = int(np.searchsorted(time, fall - shortly)) or int(np.searchsorted(time, fall))
    difference = factor * np.max(np.abs(places - closer_places), axis=1)
    sizes = (float(np.max(np.abs(part), initial=0.0)) for part in (closer_places[:rows], closer_places))
    size = next(filter(None, sizes), 1.0)
    # relative error of the peaks, absolute of those that may be zero or negative
    peaks: dict[str, FloatArray] = {
        name: factor * np.abs(response.peaks[name] - other) / (1.0 if name in LEAST else np.where(other, other, 1.0))
        for name, other in closer.peaks.items()
    }
    response.estimated_error = ErrorEstimate(
        ux=float(np.max(difference[:rows], initial=0.0)) / size,
        peaks=Renamed(peaks, aliases_of(type(response)), "peaks"),
        overturn_time=abs(response.overturn_time - closer.overturn_time),
    )
    # horizon of prediction, and verdict
    apart = np.flatnonzero(difference > allowed * size)
    response.horizon = float(time[max(int(apart[0]) - 1, 0)] if apart.size else time[-1])
    if response.verdict != closer.verdict:
        here, there = _setting(response.model), _setting(closer.model)
        response.reason = f"it is {response.verdict} at {here}, and {closer.verdict} at {there}"
        response.verdict = UNDECIDED


def _is_fixed(model: Any) -> bool:
    """Return True if a model is integrated with fixed steps."""
    return bool(model.settings.integrator == "central-difference")


def _setting(model: Any) -> str:
    settings = model.settings
    return f"a step of {settings.step:g} s" if _is_fixed(model) else f"a tolerance of {settings.tolerance:g}"
