"""The rest of a column under loads on its ports, from which it can be released."""

from __future__ import annotations

import numpy as np

from ...common.errors import InputError
from ...ground.loads import COMPONENTS, IN_PLANE
from ...kernels.layout import spaces as at
from .linearization import StillColumn, stuck
from .model import Column
from .packing import FloatArray, InitialState
from .rest import check_stable

FIRST, LEAST = 0.25, 1e-3  # of the loads: first and least step, halved where no equilibrium is found
ITERATIONS = 50  # of Newton's method in each step
PART = 1e-3  # of the coordinates at which a joint opens: size of finite differences
CONVERGED = 1e-11  # last correction, relative to these
ROUNDED = 1e-8  # the same if rounding stops the convergence
SHORTENED = 12  # halvings of a correction until it reduces the residual


def rest_under(column: Column, loads: FloatArray) -> InitialState:
    """Return the rest under loads on the ports, (6, ports) N and N m, applied in steps.

    Raises InputError if there is no stable rest, or a joint slides.
    """
    whole = in_plane("release", loads)
    check_stable(column)
    still, n = StillColumn(stuck(column)), column.n
    q = still.rest
    done, step = 0.0, FIRST
    # increase the loads, in smaller steps where no equilibrium is found
    while done < 1.0:
        ahead = min(1.0, done + step)
        still.loads = ahead * whole
        found = _balanced(still, q)
        if found is not None:
            q, done = found, ahead
            continue
        step *= 0.5
        if step < LEAST:
            raise InputError(f"release: {column.name} has no rest under this load, it must balance it")
    # the stiffness has to be positive at the end
    if np.min(np.linalg.eigvals(still.stiffness(q, PART)).real) <= 0.0:
        raise InputError(f"release: {column.name} has no stable rest under this load, it must balance it")
    # no joint may exceed its shear capacity
    if column.slides:
        own = StillColumn(column)
        own.loads = whole
        own.row(q)
        sliding = np.flatnonzero(at.WORK.see(own.arrays.work, n).between.sliding)
        if sliding.size:
            raise InputError(f"release: joint {int(sliding[0]) + 1} slides under this load, it must bear it")
    return InitialState(rotation=q[:n], opening=q[n:])


def in_plane(key: str, loads: FloatArray) -> FloatArray:
    """Return loads (6, ports) as the kernels of columns read them: Fx of each port, Fz, My.

    Raises InputError if other components are not zero.
    """
    for name, row in zip(COMPONENTS, loads, strict=True):
        if np.any(row) and name not in IN_PLANE:
            raise InputError(f"{key}: {name}: a column in its plane has {', '.join(IN_PLANE)} only (--space has all)")
    return loads[[name in IN_PLANE for name in COMPONENTS]].ravel()


def _balanced(still: StillColumn, q: FloatArray) -> FloatArray | None:
    """Return the equilibrium near q by Newton's method, or None if none is found."""
    unbalanced = still.accelerations(q)
    for _ in range(ITERATIONS):
        try:
            change = np.linalg.solve(still.stiffness(q, PART), unbalanced)
        except np.linalg.LinAlgError:
            return None
        size = float(np.max(np.abs(change) / still.sizes))
        if not np.isfinite(size):
            return None
        # halve the correction until the residual decreases
        for _ in range(SHORTENED):
            left = still.accelerations(q + change)
            if np.linalg.norm(left * still.sizes) < np.linalg.norm(unbalanced * still.sizes) or size < ROUNDED:
                break
            change = 0.5 * change
        else:
            return None
        q, unbalanced = q + change, left
        if size < CONVERGED:
            return q
    return q if size < ROUNDED else None
