"""Many runs of columns in lanes, in threads, with all that lanes find of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from solver import Column, Motion
from solver.kernels.numba_ext.lanes import WIDTH
from solver.models.column.lanes import BatchResult, follow_in_lanes
from support.probe import Array


def run_batch(
    columns: Sequence[Column],
    motions: Sequence[Motion],
    durations: Sequence[float] | None = None,
    *,
    tolerance: float | None = None,
    times: Array | None = None,
    threads: int = 1,
) -> BatchResult:
    """Return `follow_in_lanes` of runs, which are as long as their motions where no durations are given, s."""
    lengths = [motion.duration for motion in motions] if durations is None else list(durations)
    if tolerance is not None:
        columns = [column.with_settings(tolerance=tolerance) for column in columns]
    parts = np.array_split(np.arange(len(columns)), max(1, min(threads, math.ceil(len(columns) / WIDTH))))

    def follow(part: Array) -> BatchResult:
        return follow_in_lanes(
            [columns[k] for k in part], [motions[k] for k in part], [lengths[k] for k in part], times
        )

    with ThreadPoolExecutor(len(parts)) as pool:
        made = list(pool.map(follow, parts))
    return BatchResult(*(np.concatenate([getattr(part, name) for part in made]) for name in vars(made[0])))
