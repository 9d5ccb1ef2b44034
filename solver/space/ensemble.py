"""Runs of a structure that vary uncertain data of it and of its motion."""

from __future__ import annotations

import math

import numpy as np

from ..common.errors import SolverError
from ..dynamics.uncertainty import PERCENTILES, Ensemble, Spread
from ..dynamics.verdict import OVERTURNED, UNDECIDED
from ..ground.motion import Motion
from .blocks.faces import FloatArray
from .response import SpatialResponse
from .rest import NoRestError
from .run import single_run
from .structure import Structure


def ensemble_in_space(
    response: SpatialResponse, motion: Motion, duration: float, settle: float, size: int, spread: Spread
) -> Ensemble:
    """`size` runs around the one that gave a response, with rows at the same times; all begin at rest.

    ux and peak_ux of it are horizontal displacements of the centroids, whichever way.
    """
    rng = np.random.default_rng(spread.seed)
    n = response.structure.n
    verdicts, falls, peaks, histories = [], [], [], []
    for _ in range(size):
        structure, shaken = vary(response.structure, motion, spread, rng)
        try:
            run = single_run(
                structure.with_settings(without=("peaks",)), shaken, duration, response.time, settle=settle
            )
        except (SolverError, NoRestError) as failure:
            falls_at_rest = isinstance(failure, NoRestError)
            verdicts.append(OVERTURNED if falls_at_rest else UNDECIDED)
            falls.append(float(response.time[0]) if falls_at_rest else math.nan)
            peaks.append(np.full(n, math.nan))
            histories.append(np.full((len(response.time), n), math.nan))
            continue
        verdicts.append(run.verdict)
        falls.append(run.overturn_time)
        peaks.append(run.peaks["u"])
        histories.append(np.hypot(run.ux, run.uy))
    stands = np.array([verdict != OVERTURNED for verdict in verdicts])
    peak, fall, history = np.array(peaks), np.array(falls), np.array(histories)
    history[fall[:, None] <= response.time] = math.nan
    highest = _percentiles(np.where(stands, np.max(peak, axis=1), math.nan))
    return Ensemble(
        spread=spread,
        verdicts=tuple(verdicts),
        peak_ux=peak,
        overturn_time=fall,
        peaks=_percentiles(np.where(stands[:, None], peak, math.nan)),
        ux=_percentiles(history),
        amplification=float(0.5 * (highest[2] - highest[0]) / highest[1] / max(spread.size, math.ulp(1.0))),
        in_lanes=False,
    )


def vary(structure: Structure, motion: Motion, spread: Spread, rng: np.random.Generator) -> tuple[Structure, Motion]:
    """A structure and a motion with varied data, all as likely as the given ones."""
    count = len(structure.joints)
    stiffness, damping = (np.exp(size * rng.standard_normal(count)) for size in (spread.stiffness, spread.damping))
    beds = [joint.bed for joint in structure.joints]
    moduli = [bed.stiffness * factor for bed, factor in zip(beds, stiffness, strict=True)]
    dampings = [bed.damping * factor for bed, factor in zip(beds, damping, strict=True)]
    varied = structure.with_joints(moduli, dampings)
    return varied, motion.scaled(float(np.exp(spread.motion * rng.standard_normal())))


def _percentiles(values: FloatArray) -> FloatArray:
    """The points of `PERCENTILES` over the first axis, without NaN; NaN where there is nothing else."""
    flat = values.reshape(len(values), -1)
    found = np.full((len(PERCENTILES), flat.shape[1]), math.nan)
    some = ~np.all(np.isnan(flat), axis=0)
    found[:, some] = np.nanpercentile(flat[:, some], PERCENTILES, axis=0)
    return found.reshape(len(PERCENTILES), *values.shape[1:])
