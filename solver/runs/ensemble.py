"""Ensembles: runs with varied uncertain data of model and motion, their verdicts, shares and percentiles."""

from __future__ import annotations

import math
from collections.abc import Callable
from threading import Thread
from typing import Any

import numpy as np

from ..common.errors import SolverError
from ..models.protocol import OVERTURNED, UNDECIDED, NoRestError, RunPlan
from ..models.response import Result
from ..models.uncertainty import Ensemble, Spread, Varied, ensemble_from, vary

LISTEN = 0.05  # s between two checks for an interruption


def ensemble_of(response: Result, plan: RunPlan, size: int, spread: Spread) -> Ensemble:
    """Return the ensemble of `size` varied runs around a response.

    `plan` is that of the response; `spread` has the standard deviations of the varied data and the seed.
    """
    rng, kind = np.random.default_rng(spread.seed), response.model.kind
    varied = [vary(response.model, plan.motion, spread, rng) for _ in range(size)]
    made: list[Varied | None] = [None] * size
    in_lanes = kind.in_lanes(response, plan)
    if in_lanes:
        made = interruptible(lambda: kind.varied_in_lanes(varied, plan))
        plan = plan._replace(callback=None)
    plans = [plan._replace(motion=motion) for _, motion in varied]
    runs = [found or _alone(model, own) for (model, _), found, own in zip(varied, made, plans, strict=True)]
    return ensemble_from(runs, spread, response.time, in_lanes)


def _alone(model: Any, plan: RunPlan) -> Varied:
    try:
        model.kind.check(model, from_rest=plan.initial is None)
        model = model.with_settings(without=(*model.settings.without, "peaks"))
        response, places = model.kind.single_run(model, plan)
    except (SolverError, NoRestError) as failure:
        nothing = np.full((len(plan.times), model.n), math.nan)
        falls = isinstance(failure, NoRestError)  # at once
        begin = float(plan.times[0]) if falls else math.nan
        return Varied(OVERTURNED if falls else UNDECIDED, begin, nothing[0], nothing)
    peaks, moved = model.kind.largest_of(response, places)
    return Varied(response.verdict, response.overturn_time, peaks, moved, response.debris)


def interruptible(work: Callable[[], Any]) -> Any:
    """Return the result of `work`, run in a thread so that an interrupt is noticed during a long call."""
    outcome: list[Any] = []
    failure: list[BaseException] = []

    def do() -> None:
        try:
            outcome.append(work())
        except BaseException as error:  # raised again in the caller's thread
            failure.append(error)

    thread = Thread(target=do, daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(LISTEN)
    if failure:
        raise failure[0]
    return outcome[0]
