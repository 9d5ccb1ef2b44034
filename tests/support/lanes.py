"""Accelerations of eight columns at once, and of each alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from solver.kernels.column.formulations.exact import Motion, exact_accelerations
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import Space, lanes_of, row_of
from support.probe import Array

_model, _phase, _work = at.MODEL.over, at.PHASE.over, at.WORK.over


def in_lanes(rows: Array) -> Array:
    """Return eight rows interleaved: eight neighbouring numbers an element."""
    return np.ascontiguousarray(rows.T).reshape(-1)


@from_python
def accelerate(n: int, model: Array, phase: Array, work: Array, base: Array) -> None:
    """Return `exact_accelerations` of one column; base: ax, az, theta, omega, alpha."""
    b, space = row_of(base), _work(row_of(work), n)
    motion = Motion(b[0], b[1], b[2], b[3], b[4])
    exact_accelerations(
        _model(row_of(model), n), _phase(row_of(phase), n), motion, None, None, space.joints, space.hold, space.room
    )


def accelerating(space: Space) -> Callable[[int, Array, Array], None]:
    """Return `exact_accelerations` for eight columns, whose buffer holds the space; the phase is its work.start."""
    over = space.over

    @from_python
    def accelerate_lanes(n: int, buffer: Array, base: Array) -> None:
        b, space = lanes_of(base), over(lanes_of(buffer), n)
        motion, work = Motion(b[0], b[1], b[2], b[3], b[4]), space.work
        exact_accelerations(space.model, work.start, motion, None, None, work.joints, work.hold, work.room)

    return accelerate_lanes
