"""Many runs at once: eight columns in the lanes of one core, and threads on top.

For columns of the same number of blocks in the formulation `exact`. Each lane has its own column, motion, time and
step (kernels/batch/); what comes of a run does not depend on which others pass beside it, nor on their order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .column import Column
from .errors import InputError
from .kernels import layout as at
from .kernels.batch.entries import run_lanes
from .kernels.batch.runs import OUTCOME, RUN, SPACE
from .kernels.joint.section import SECTIONS
from .kernels.lanes import WIDTH
from .motion import Motion
from .packing import FloatArray, arrays_of, settlements

# Steps across changes of regime err by more than their estimate says: they are given so much less of the tolerance.
# Measured on columns of 1 and 3 blocks (eta 1e-3 and 5e-3 s; harmonics, three records at half scale; tolerances of 1e-3
# to 1e-6; amplification below 100): errors of up to 11 tolerances without, 2.7 with it, for 1.3 times the steps.
TOLERANCE_PART = 0.3


@dataclass(frozen=True)
class BatchResult:
    """What comes of runs, in their order: peak_ux m (runs, n), overturned_joint (0 if not), overturn_time s (NaN)."""

    peak_ux: FloatArray
    overturned_joint: NDArray[np.int64]
    overturn_time: FloatArray
    finished: NDArray[np.bool_]  # False where the step that the tolerance asks for was too small to go on
    steps: NDArray[np.int64]
    phases: FloatArray  # (runs, rows, 4 n) coordinates and rates at the times asked for


def run_batch(
    columns: Sequence[Column],
    motions: Sequence[Motion],
    durations: Sequence[float] | None = None,
    *,
    tolerance: float | None = None,
    times: FloatArray | None = None,
    threads: int = 1,
) -> BatchResult:
    """Run column k under motion k, from rest, for duration k, s (None: that of the motion).

    tolerance: relative to the peak; None: each column's. times: s after the start of a run, at which its phase is kept.
    Raises InputError for columns of another number of blocks or formulation, for sections that are no rectangles, and
    for held samples.
    """
    n = columns[0].n
    durations = [motion.duration for motion in motions] if durations is None else list(durations)
    if not len(columns) == len(motions) == len(durations):
        raise InputError(f"{len(columns)} columns, {len(motions)} motions, {len(durations)} durations: as many of each")
    for k, (column, motion) in enumerate(zip(columns, motions, strict=True)):
        if column.n != n or column.settings.formulation != "exact":
            raise InputError(f"columns[{k}]: must have {n} blocks and the formulation exact, as the others of a batch")
        if not column.has_rectangles_only:
            names = ", ".join(sorted({SECTIONS[block.joint_section] for block in column.blocks}))
            raise InputError(f"columns[{k}]: its joints are of the sections {names}, must be rectangles in a batch")
        if motion.hold:
            raise InputError(f"motions[{k}]: its samples are held, must be joined by straight lines")
    at_rows = np.empty(0) if times is None else np.ascontiguousarray(times, dtype=np.float64)
    parts = np.array_split(np.arange(len(columns)), max(1, min(threads, math.ceil(len(columns) / WIDTH))))
    with ThreadPoolExecutor(len(parts)) as pool:
        made = list(
            pool.map(
                lambda part: _run_part(
                    [columns[k] for k in part],
                    [motions[k] for k in part],
                    [durations[k] for k in part],
                    tolerance,
                    at_rows,
                ),
                parts,
            )
        )
    outcomes, phases = (np.concatenate(arrays) for arrays in zip(*made, strict=True))
    code, time, joint, steps, _ = outcomes[:, : OUTCOME.beside].T
    return BatchResult(
        peak_ux=outcomes[:, OUTCOME.beside :],
        overturned_joint=joint.astype(np.int64),
        overturn_time=np.where(joint > 0, time, np.nan),
        finished=code >= at.OK,
        steps=steps.astype(np.int64),
        phases=phases[:, :, : 4 * n],
    )


def _run_part(
    columns: Sequence[Column],
    motions: Sequence[Motion],
    durations: Sequence[float],
    tolerance: float | None,
    rows: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Outcomes (runs, fields and peaks) and phases (runs, rows, 6 n), in one thread."""
    n, count = columns[0].n, len(columns)
    models = np.empty((count, at.MODEL.size(n)))
    starts = np.zeros((count, 4 * n))
    runs = np.zeros((count, RUN.beside))
    samples: list[FloatArray] = []
    places: dict[int, tuple[int, int]] = {}  # of a motion among the samples: first, number
    first = 0
    for k, (column, motion, duration) in enumerate(zip(columns, motions, durations, strict=True)):
        asked = column.settings.tolerance if tolerance is None else tolerance
        tight = column.with_settings(tolerance=TOLERANCE_PART * asked, integrator="auto")
        models[k] = arrays_of(tight).model[: models.shape[1]]
        starts[k, n : 2 * n] = -settlements(column)
        silent = not np.any(motion.ax) and not np.any(motion.az) and duration <= motion.duration
        if not silent and id(motion) not in places:
            places[id(motion)] = first, len(motion.time)
            samples.append(np.stack((motion.time, motion.ax, motion.az)))
            first += len(motion.time)
        run = RUN.see(runs[k])
        run.start, run.stop, run.scale = motion.start, motion.start + duration, 1.0
        run.wave_amplitude = motion.amplitude
        run.wave_omega = 2.0 * math.pi * motion.frequency
        run.wave_phase = -run.wave_omega * motion.start
        run.first, run.count = (0, 0) if silent else places[id(motion)]
    time, ax, az = np.hstack(samples) if samples else np.zeros((3, 1))
    outcomes = np.zeros((count, OUTCOME.size(n)))
    snapshots = np.zeros((count, rows.size, 6 * n))
    buffer = np.zeros(WIDTH * SPACE.size(n))
    flat = (array.reshape(-1) for array in (models, starts, runs, outcomes))
    contiguous = (np.ascontiguousarray(row) for row in (time, ax, az))
    run_lanes(n, buffer, count, *flat, *contiguous, rows, snapshots.reshape(-1))
    return outcomes, snapshots
