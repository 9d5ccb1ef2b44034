"""A record of the base acceleration inside the FMU, sampled independently of the communication steps."""

from __future__ import annotations

import hashlib
import math

import numpy as np

from solver.ground.motion import Motion

from .description_parts import Experiment

OF_DROPS = 0.01  # of the median interval: more than where a motion drops to zero


class Record:
    """A sampled motion as the solver follows it: linear from sample to sample, zero before and after."""

    def __init__(self, motion: Motion) -> None:
        self.motion = motion
        intervals = np.diff(motion.time)
        # s, the shortest sampling interval, without those in which a motion drops to zero (solver/ground/building.py)
        self.dt = float(np.min(intervals[intervals > OF_DROPS * np.median(intervals)]))
        self.pga = motion.pga  # m/s2
        moves = np.flatnonzero((motion.ax != 0.0) | (motion.ay != 0.0) | (motion.az != 0.0))
        self.begins = float(motion.time[max(0, moves[0] - 1)]) if len(moves) else math.inf  # s, start of motion
        self.ends = float(motion.time[min(moves[-1] + 1, len(motion.time) - 1)]) if len(moves) else -math.inf
        parts = (motion.time, motion.ax, motion.az, *([motion.ay] if motion.has_ay else []))
        self.digest = hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


def usual_experiment(tolerance: float | None, motion: Motion | None) -> Experiment:
    """Return the default experiment: over the record inside the FMU, if any, at its shortest sampling interval.

    Its numbers are rounded to the fewest digits: times in steps of 0.01 s, and their differences, have rounding errors.
    """
    if motion is None:
        return Experiment(tolerance=tolerance)
    rounding = 4.0 * math.ulp(max(abs(motion.start), abs(motion.end)))
    start, end, step = (_shortest(value, rounding) for value in (motion.start, motion.end, Record(motion).dt))
    return Experiment(start, end, step, tolerance)


def _shortest(value: float, error: float) -> float:
    """Return the number with the fewest digits that is within `error` of `value`."""
    candidates = (float(f"{value:.{digits}g}") for digits in range(1, 17))
    return next((short for short in candidates if abs(short - value) <= error), value)
