"""Runs that vary uncertain data of a column and its motion: verdict, shares and percentiles of all."""

from __future__ import annotations

import math
from collections.abc import Callable
from threading import Thread
from typing import Any

import numpy as np

from ..column.column import Column
from ..column.packing import FloatArray
from ..common.errors import SolverError
from ..dynamics.kinematics import chain_of
from ..dynamics.response import Response
from ..dynamics.uncertainty import PERCENTILES, Ensemble, Spread
from ..dynamics.verdict import OVERTURNED, UNDECIDED
from ..ground.motion import Motion
from .batch import run_batch
from .single_run import Plan, outcome, single_run

MOST_DAMPED = 0.5  # of the steps implicit: beyond it lanes, which step explicitly, gain nothing
LISTEN = 0.05  # s between two checks for an interruption
LEAST_CHANGE, MOST_CHANGE = 1e-3, 1e3  # of a value by its factor: a column may hold a wider range


def ensemble_of(response: Response, plan: Plan, size: int, spread: Spread) -> Ensemble:
    """`size` runs around the one by a plan that gave a response."""
    rng = np.random.default_rng(spread.seed)
    varied = [vary(response.column, plan.motion, spread, rng) for _ in range(size)]
    lanes = runs_in_lanes(response, plan)
    made = (
        _in_lanes(varied, plan)
        if lanes
        else [_alone(column, plan._replace(motion=shaken)) for column, shaken in varied]
    )
    verdicts, times, peaks, histories = zip(*made, strict=True)
    peak_ux, overturn_time = np.array(peaks), np.array(times)
    stands = np.array([verdict != OVERTURNED for verdict in verdicts])
    ux = np.array(histories)
    ux[overturn_time[:, None] <= response.time] = math.nan
    bands = _percentiles(np.where(stands[:, None], peak_ux, math.nan))
    highest = _percentiles(np.where(stands, np.max(peak_ux, axis=1), math.nan))
    size_of_change = max(spread.size, math.ulp(1.0))
    return Ensemble(
        spread=spread,
        verdicts=verdicts,
        peak_ux=peak_ux,
        overturn_time=overturn_time,
        peaks=bands,
        ux=_percentiles(ux),
        amplification=float(0.5 * (highest[2] - highest[0]) / highest[1] / size_of_change),
        in_lanes=lanes,
    )


def vary(column: Column, motion: Motion, spread: Spread, rng: np.random.Generator) -> tuple[Column, Motion]:
    """A column and a motion with varied data, all as likely as the given ones."""

    def factors(size: float, count: int) -> list[float]:
        drawn: list[float] = np.clip(np.exp(size * rng.standard_normal(count)), LEAST_CHANGE, MOST_CHANGE).tolist()
        return drawn

    joints = [block.joint for block in column.blocks]
    stiffness = [
        joint.stiffness * factor for joint, factor in zip(joints, factors(spread.stiffness, column.n), strict=True)
    ]
    damping = [joint.damping * factor for joint, factor in zip(joints, factors(spread.damping, column.n), strict=True)]
    return column.with_joints(stiffness, damping), motion.scaled(factors(spread.motion, 1)[0])


def runs_in_lanes(response: Response, plan: Plan) -> bool:
    """Whether eight runs can go at once, and that is faster."""
    settings = response.column.settings
    fits = (
        not response.column.other_law
        and not response.column.has_bands
        and settings.formulation == "exact"
        and settings.integrator == "auto"
        and set(settings.without) <= {"peaks"}
    )
    explicit = response.stats["implicit_steps"] <= MOST_DAMPED * response.stats["steps"]
    return fits and explicit and not plan.motion.hold and plan.initial is None


Made = tuple[str, float, FloatArray, FloatArray]  # verdict, time of overturning s, peaks (n,), ux (nt, n)


def _alone(column: Column, plan: Plan) -> Made:
    try:
        column = column.with_settings(without=(*column.settings.without, "peaks"))
        response, phases = single_run(column, plan)
    except SolverError:
        nothing = np.full((len(plan.times), column.n), math.nan)
        return UNDECIDED, math.nan, nothing[0], nothing
    return response.verdict, response.overturn_time, response.peak_ux, chain_of(column).top_displacements(phases)


def _in_lanes(varied: list[tuple[Column, Motion]], plan: Plan) -> list[Made]:
    columns, motions = zip(*varied, strict=True)
    start, duration = plan.motion.start, plan.duration
    times = np.append(plan.times - start, duration)
    batch = interruptible(lambda: run_batch(columns, motions, [duration] * len(columns), times=times))
    made: list[Made] = []
    for k, (column, motion) in enumerate(varied):
        if not batch.finished[k]:
            made.append(_alone(column, plan._replace(motion=motion, callback=None)))
            continue
        verdict, fall = OVERTURNED, float(batch.overturn_time[k])
        if not batch.overturned_joint[k]:
            verdict, fall, _ = outcome(column, batch.phases[k, -1], start + duration, plan.settle)
        made.append((verdict, fall, batch.peak_ux[k], chain_of(column).top_displacements(batch.phases[k, :-1])))
    return made


def _percentiles(values: FloatArray) -> FloatArray:
    """The points of `PERCENTILES` over the first axis, without NaN, as numpy.nanpercentile but faster."""
    ordered = np.sort(values, axis=0)  # NaN comes last
    last = np.maximum(np.sum(~np.isnan(ordered), axis=0) - 1, 0)
    found = []
    for percent in PERCENTILES:
        place = 0.01 * percent * last
        below = np.floor(place).astype(np.int64)
        low, high = (np.take_along_axis(ordered, k[None], axis=0)[0] for k in (below, np.minimum(below + 1, last)))
        found.append(low + (place - below) * (high - low))
    return np.array(found)


def interruptible(work: Callable[[], Any]) -> Any:
    """The result of `work`, which runs in a thread, so that an interruption is noticed during a long call."""
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
