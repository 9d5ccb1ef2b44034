"""What a run starts from, for the terminal: said before the run, where a slip of units still costs nothing."""

from __future__ import annotations

import math

import numpy as np

from .column import Column
from .errors import SolverError
from .modes import natural_frequencies
from .motion import STANDARD_GRAVITY, Motion
from .packing import settlements

MOST_BLOCKS = 100  # whose natural frequencies take no time worth mentioning


def report(column: Column, motion: Motion) -> str:
    """Return two lines: size, settlement and first natural frequency of the column; peak of the motion."""
    settled, lowest = settlements(column), math.nan
    if column.g > 0.0 and column.n <= MOST_BLOCKS:
        try:
            lowest = float(natural_frequencies(column)[0])
        except SolverError:  # not stable; the run says so
            lowest = math.nan
    height = sum(block.height for block in column.blocks)
    told = [f"{column.n} block{'s' if column.n > 1 else ''}, {height:.4g} m", f"settles by {_length(settled.sum())}"]
    if math.isfinite(lowest):
        told.append(f"first natural frequency {lowest:.4g} Hz")
    undamped = sum(block.joint.damping == 0.0 for block in column.blocks)
    if undamped:
        told.append(f"{'no' if undamped == column.n else 'not all'} joints damped")
    return f"{column.name}: {', '.join(told)}\n{_motion(motion)}"


def _motion(motion: Motion) -> str:
    told = [f"base: {motion.duration:.4g} s", f"PGA {motion.pga / STANDARD_GRAVITY:.4g} g"]
    if np.any(motion.az):
        told.append(f"vertical {np.max(np.abs(motion.az)) / STANDARD_GRAVITY:.4g} g")
    return ", ".join(told)


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if metres >= 0.1 else f"{1e3 * metres:.3g} mm"
