"""The largest displacement of a run, as figures and pages report it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..models.column.packing import FloatArray

GONE = 1.0  # of the largest width: a column that falls and has moved by more does not come back


def largest_displacement(response: Any) -> tuple[float, int]:
    """Return the largest displacement of a block, m, and the index of that block.

    In the plane it is that of the top face along x, in space that of the centroid in any horizontal direction. Of a
    model that falls within its histories only the rows count up to which it can still come back.
    """
    model, in_space = response.model, response.model.kind.largest == "u"
    if not response.overturn_time <= response.time[-1]:
        largest = response.peaks[model.kind.largest]
    else:
        moved = np.hypot(response.ux, response.uy) if in_space else np.abs(response.ux)
        widest = math.inf if in_space else max(block.width for block in model.blocks)
        largest = np.max(moved[: rows_before_fall(response.time, moved, response.overturn_time, widest)], axis=0)
    block = int(np.argmax(largest))
    return float(largest[block]), block


def rows_before_fall(time: FloatArray, moved: FloatArray, overturn_time: float, widest: float) -> int:
    """Return the number of rows before a block that falls has moved by `GONE` widths or has fallen, at least 2.

    Parameters
    ----------
    time : array (rows,)
        Times, s.
    moved : array (rows, n)
        Absolute displacements of the blocks, m.
    overturn_time : float
        Time of the fall, s.
    widest : float
        Largest width of a block, m.
    """
    beyond = np.flatnonzero(np.max(moved, axis=1) > GONE * widest)
    fallen = int(np.searchsorted(time, overturn_time))
    return min(max(2, min([fallen, *beyond[:1].tolist()])), len(time))


def length(metres: float) -> str:
    """Format a length in m, or in mm below 1 m."""
    return f"{metres:.3g} m" if abs(metres) >= 1.0 else f"{1e3 * metres:.3g} mm"
