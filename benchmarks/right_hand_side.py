"""The equations of motion as a compiled first-order system dy/dt = f(t, y), for general integrators.

The accelerations are those of the solver's own kernel; the base acceleration is evaluated inside. The unknowns are
divided by their typical sizes, because some integrators have only one absolute tolerance.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from solver.kernels.column.formulations.exact import Motion, exact_accelerations
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python, kernel, native
from solver.kernels.numba_ext.views import Numbers, Record, Space, row_at, row_of
from solver.models.column.packing import arrays_of

from .scenes import Scene

Array = NDArray[np.float64]

TURN_SIZE, OPEN_SIZE = 1e-3, 0.45e-3  # rad, m: typical sizes of the unknowns
RATE_FACTOR = 10.0  # 1/s, typical rates over typical sizes

KNOWN = Record(
    "calls",  # evaluations so far
    "n",  # blocks
    "samples",  # of the motion, at a uniform step
    "start",  # s
    "sample_step",  # s
    "amplitude",  # m/s2, of the harmonic part of the motion
    "omega",  # rad/s
)
# all data of the right-hand side, in one flat array
DATA = Space(
    known=KNOWN,
    sizes=Numbers(per_n=4),  # typical, of the unknowns
    phase=at.PHASE,
    joints=at.JOINTS,
    hold=at.HOLD,
    room=at.ROOM,
    model=at.MODEL,
    ax=Numbers(),  # samples, m/s2
)
_known, _data = KNOWN.over, DATA.over


@kernel
def base_acceleration(known, samples, t):
    """Return the horizontal base acceleration, m/s2, at time t, s; zero after the motion. samples: a row."""
    past = (t - known.start) / known.sample_step
    last = int(known.samples) - 1
    if past > last:
        return 0.0
    k = min(max(int(past), 0), last - 1)
    ax = samples[k] + (past - k) * (samples[k + 1] - samples[k])
    if known.amplitude != 0.0:
        ax += known.amplitude * math.sin(known.omega * (t - known.start))
    return ax


@kernel
def evaluate(t, y, dydt, data):
    """Compute dydt (4n,) of the unknowns y (4n,): coordinates, then their rates, each divided by its typical size.

    All rows.
    """
    known = _known(data, 0)
    known.calls += 1.0
    n = int(known.n)
    here = _data(data, n)
    sizes, phase = here.sizes, here.phase
    for i in range(4 * n):
        phase.row[i] = y[i] * sizes[i]
    motion = Motion(base_acceleration(known, here.ax, t), 0.0, 0.0, 0.0, 0.0)
    exact_accelerations(here.model, phase, motion, None, None, here.joints, here.hold, here.room)
    for i in range(4 * n):
        dydt[i] = phase.row[2 * n + i] / sizes[i]


@from_python
def rates(t, y, dydt, data):
    """Return the right-hand side as called from Python, over arrays."""
    evaluate(t, row_of(y), row_of(dydt), row_of(data))


@cache
def rates_in_c() -> Any:
    """Compile the right-hand side as called from C: void f(double t, double *y, double *dydt, double *data)."""
    pointer = types.CPointer(types.double)

    @native(types.void(types.double, pointer, pointer, pointer))
    def rates_at(t, y, dydt, data):
        evaluate(t, row_at(y), row_at(dydt), row_at(data))

    return rates_at


class Problem:
    """A scene as an initial value problem in scaled unknowns, with the instants at which its solution is wanted."""

    def __init__(self, scene: Scene, times: Array) -> None:
        column, motion = scene.column.with_settings(formulation="exact"), scene.motion
        n = column.n
        step = np.diff(motion.time)
        if motion.hold or np.any(motion.az) or np.ptp(step) > 1e-9 * step[0]:
            raise ValueError(f"{scene.name}: the motion must be horizontal, linear between uniform samples")
        self.times = times
        self.n = n
        self.heights = np.array([block.height for block in column.blocks])
        coordinates = np.repeat([TURN_SIZE, OPEN_SIZE], n)
        self.sizes = np.concatenate([coordinates, RATE_FACTOR * coordinates])
        arrays = arrays_of(column)
        self.start = arrays.state[at.CONTROL.beside :][: 4 * n] / self.sizes
        self.data = np.zeros(DATA.size(n) + motion.time.size)
        here = DATA.see(self.data, n)
        self.known = here.known
        self.known.n = n
        self.known.samples = motion.time.size
        self.known.start = motion.start
        self.known.sample_step = float(np.mean(step))
        self.known.amplitude = motion.amplitude
        self.known.omega = 2.0 * math.pi * motion.frequency
        here.sizes[:] = self.sizes
        model, samples = DATA.size(n) - at.MODEL.size(n), DATA.size(n)  # first elements of the last two parts
        self.data[model:samples] = arrays.model[: samples - model]
        self.data[samples:] = motion.ax

    @property
    def calls(self) -> int:
        """Evaluations of the right-hand side since `reset`."""
        return int(self.known.calls)

    def reset(self) -> None:
        """Count evaluations from zero."""
        self.known.calls = 0.0

    def rates(self, t: float, y: Array) -> Array:
        """Return the right-hand side as scipy calls it."""
        dydt = np.empty(y.size)
        rates(t, np.ascontiguousarray(y), dydt, self.data)  # finite differences of a Jacobian pass columns of arrays
        return dydt

    def ux(self, states: Array) -> Array:
        """Return the displacements of the top faces, m (nt, n), of scaled unknowns (nt, 4n)."""
        turn, opening = (
            (states[:, : 2 * self.n] * self.sizes[: 2 * self.n]).reshape(len(states), 2, self.n).swapaxes(0, 1)
        )
        below = np.hstack([turn[:, 1:], np.zeros((len(turn), 1))])
        steps = opening * np.sin(0.5 * (turn + below)) + self.heights * np.sin(turn)
        summed: Array = np.cumsum(steps[:, ::-1], axis=1)[:, ::-1]
        return summed


def address() -> Any:
    """Return the address of the right-hand side for integrators written in C or Fortran."""
    return rates_in_c().address
