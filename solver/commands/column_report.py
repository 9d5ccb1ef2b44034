"""The state that a run starts from, for the terminal: printed before the run, so that wrong units are seen early."""

from __future__ import annotations

import math

import numpy as np

from ..column.column import Column
from ..column.packing import settlements
from ..common.errors import SolverError
from ..ground.motion import STANDARD_GRAVITY, Motion
from ..statics.modes import natural_frequencies

MOST_BLOCKS = 100  # with more, natural frequencies take too long for a report


def report(column: Column, motion: Motion) -> str:
    """Return two lines: size, settlement and first natural frequency of the column; peak of the motion."""
    settled, lowest = settlements(column), math.nan
    if column.g > 0.0 and column.n <= MOST_BLOCKS:
        try:
            lowest = float(natural_frequencies(column)[0])
        except SolverError:  # not stable; the run says so
            lowest = math.nan
    height = sum(block.height for block in column.blocks)
    parts = [f"{column.n} block{'s' if column.n > 1 else ''}, {height:.4g} m", f"settles by {_length(settled.sum())}"]
    if math.isfinite(lowest):
        parts.append(f"first natural frequency {lowest:.4g} Hz")
    undamped = sum(block.joint.damping == 0.0 for block in column.blocks)
    if undamped:
        parts.append(f"{'no' if undamped == column.n else 'not all'} joints damped")
    return f"{column.name}: {', '.join(parts)}\n{_motion(motion)}"


def _motion(motion: Motion) -> str:
    parts = [f"base: {motion.duration:.4g} s", f"PGA {motion.pga / STANDARD_GRAVITY:.4g} g"]
    if np.any(motion.az):
        parts.append(f"vertical {np.max(np.abs(motion.az)) / STANDARD_GRAVITY:.4g} g")
    return ", ".join(parts)


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if metres >= 0.1 else f"{1e3 * metres:.3g} mm"
