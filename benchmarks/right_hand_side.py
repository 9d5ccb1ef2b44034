"""The equations of motion as a compiled first-order system dy/dt = f(t, y), for integrators that are not ours.

The accelerations are those of the solver's own kernel, the base acceleration is evaluated inside. The unknowns are
divided by their typical sizes, because some integrators know only one absolute tolerance.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import carray, cfunc, njit, types
from numpy.typing import NDArray

from solver.kernels import layout as at
from solver.kernels.exact import exact_accelerations
from solver.kernels.jit import OPTIONS, kernel
from solver.packing import pack_model, pack_state

from .scenes import Scene

Array = NDArray[np.float64]

TURN_SIZE, OPEN_SIZE = 1e-3, 0.45e-3  # rad, m: typical sizes of the unknowns
RATE_FACTOR = 10.0  # 1/s, typical rates over typical sizes

# --- one flat array holds all that the right-hand side knows: this header, then the parts in the order of `_offsets`
CALLS = 0  # evaluations so far
BLOCKS = 1
SIZE = 2  # of the whole array
SAMPLES = 3  # of the motion, at a uniform step
START = 4  # s
SAMPLE_STEP = 5  # s
AMPLITUDE = 6  # m/s2, of the harmonic part of the motion
OMEGA = 7  # rad/s
HEADER = 8


@kernel
def _offsets(n, samples):
    """Where typical sizes (4n), phase (6n), scratch, motion (samples) and model begin."""
    sizes = HEADER
    phase = sizes + 4 * n
    scratch = phase + 6 * n
    motion = scratch + at.SCRATCH_FIELDS * n
    return sizes, phase, scratch, motion, motion + samples


@kernel
def base_acceleration(data, motion, t):
    """Horizontal base acceleration, m/s2, at time t, s; zero after the motion."""
    past = (t - data[START]) / data[SAMPLE_STEP]
    last = int(data[SAMPLES]) - 1
    if past > last:
        return 0.0
    k = min(max(int(past), 0), last - 1)
    before, after = data[motion + k], data[motion + k + 1]
    ax = before + (past - k) * (after - before)
    if data[AMPLITUDE] != 0.0:
        ax += data[AMPLITUDE] * math.sin(data[OMEGA] * (t - data[START]))
    return ax


@kernel
def evaluate(t, y, dydt, data):
    """dydt (4n,) of the unknowns y (4n,): coordinates, then their rates, each divided by its typical size."""
    data[CALLS] += 1.0
    n = int(data[BLOCKS])
    sizes, phase, scratch, motion, model = _offsets(n, int(data[SAMPLES]))
    for i in range(4 * n):
        data[phase + i] = y[i] * data[sizes + i]
    ax = base_acceleration(data, motion, t)
    exact_accelerations(data[model:], data, phase, (ax, 0.0, 0.0, 0.0, 0.0), data, scratch)
    for i in range(4 * n):
        dydt[i] = data[phase + 2 * n + i] / data[sizes + i]


@njit(**OPTIONS)
def rates(t, y, dydt, data):
    """The right-hand side as called from Python."""
    evaluate(t, y, dydt, data)


_POINTER = types.CPointer(types.double)


# arrays over pointers are made by numba's runtime, which the kernels themselves do without
@cfunc(types.void(types.double, _POINTER, _POINTER, _POINTER), **(OPTIONS | {"_nrt": True}))
def rates_in_c(t, y, dydt, data):
    """The right-hand side as called from C: void f(double t, double *y, double *dydt, double *data)."""
    head = carray(data, (HEADER,))
    size = 4 * int(head[BLOCKS])
    evaluate(t, carray(y, (size,)), carray(dydt, (size,)), carray(data, (int(head[SIZE]),)))


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
        model = pack_model(column)
        state, _ = pack_state(column)
        self.start = state[at.STATE_HEADER : at.STATE_HEADER + 4 * n] / self.sizes
        sizes, _, _, samples, packed = _offsets.py_func(n, motion.time.size)
        self.data = np.zeros(packed + model.size)
        self.data[:HEADER] = (
            0.0,
            n,
            self.data.size,
            motion.time.size,
            motion.start,
            float(np.mean(step)),
            motion.amplitude,
            2.0 * math.pi * motion.frequency,
        )
        self.data[sizes : sizes + 4 * n] = self.sizes
        self.data[samples:packed] = motion.ax
        self.data[packed:] = model

    @property
    def calls(self) -> int:
        """Evaluations of the right-hand side since `reset`."""
        return int(self.data[CALLS])

    def reset(self) -> None:
        """Count evaluations from zero."""
        self.data[CALLS] = 0.0

    def rates(self, t: float, y: Array) -> Array:
        """The right-hand side as scipy calls it."""
        dydt = np.empty_like(y)
        rates(t, y, dydt, self.data)
        return dydt

    def ux(self, states: Array) -> Array:
        """Displacements of the top faces, m (nt, n), of scaled unknowns (nt, 4n)."""
        turn, opening = (
            (states[:, : 2 * self.n] * self.sizes[: 2 * self.n]).reshape(len(states), 2, self.n).swapaxes(0, 1)
        )
        below = np.hstack([turn[:, 1:], np.zeros((len(turn), 1))])
        steps = opening * np.sin(0.5 * (turn + below)) + self.heights * np.sin(turn)
        summed: Array = np.cumsum(steps[:, ::-1], axis=1)[:, ::-1]
        return summed


def address() -> Any:
    """Address of the right-hand side for integrators written in C or Fortran."""
    return rates_in_c.address
