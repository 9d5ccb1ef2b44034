"""The risk of a checked model: a fragility from all runs of the check, and the hazard of its site."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from ..common.errors import InputError
from ..models.protocol import UNDECIDED
from ..studies.risk import YEARS, Hazard, Risk, not_bounded, risk
from ..studies.statistics import failure_text, fragility_of_runs
from .check import Check
from .margin import Trial
from .scaling import horizontal
from .verdicts import falls


def risk_of(check: Check, hazard: Hazard, years: float = YEARS) -> Risk:
    """Compute the risk of overturning in `years` from the runs of a check: at factor 1, and of the margin.

    The intensity of a run is that of its motion, on a floor of the ground's, and of two horizontal components their
    geometric mean, as in `scaling`; all runs under one motion are resampled together for the bounds. Raises InputError
    if the runs do not determine a fragility over the measure of the hazard, or bound the rate too loosely.
    """
    motions = check.action.ground or check.action.motions
    sizes = np.array([horizontal(one.motion, partial(hazard.measure.of, one.motion)) for one in motions])
    if not np.all(sizes > 0.0):
        raise InputError(f"hazard: {hazard.measure.label} of a motion is 0, must be positive for a fragility")
    own = np.array([[run.verdict for run in signs] for signs in check.by_sign])
    varied = check.verdicts.varied.reshape(len(sizes), -1)
    trials = [Trial(1.0, np.arange(len(sizes)), np.hstack([own, varied]))]
    trials += check.margin.trials if check.margin else ()

    def of_runs(values: Any) -> Any:
        return np.concatenate([np.repeat(each, t.verdicts.shape[1]) for t, each in zip(trials, values, strict=True)])

    verdicts = np.concatenate([trial.verdicts.ravel() for trial in trials])
    intensity = of_runs([trial.factor * sizes[trial.places] for trial in trials])
    groups = of_runs([trial.places for trial in trials])
    try:
        fitted = fragility_of_runs(
            hazard.measure, intensity, falls(verdicts), groups, failure_text(None), verdicts == UNDECIDED
        )
    except InputError as error:
        raise InputError(f"hazard: the runs of the check have no fragility, make a study: {error}") from None
    found = risk(fitted, hazard, years)
    if math.isinf(found.rate_bounds[1]):
        raise InputError(f"hazard: {not_bounded(hazard)}: too few motions overturn it, make a study")
    return found
