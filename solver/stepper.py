"""One column in motion: owns the flat arrays and drives the kernels over them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .column import Column
from .errors import InputError, SolverError
from .kernels import layout as at
from .kernels.advance import observe_snapshots, observe_state, run
from .modes import longest_stable_step
from .motion import Motion
from .packing import FloatArray, InitialState, pack_model, pack_state

REASONS = {
    at.STEP_TOO_SMALL: "the step that the tolerance asks for is too small to go on; a larger tolerance may help",
    at.NOT_CONVERGED: "the Gauss-Seidel sweeps do not converge: the displacements are beyond the first-order model, "
    'or the step is beyond its stability limit; formulation = "exact" or a smaller step may help',
    at.NOT_FINITE: "the motion has become infinite: the step is beyond the stability limit of the integrator, "
    "or the input is not a physical one",
    at.ROTATES: 'the base rotates, which formulation = "paper" does not know: "exact" does',
}

STEP_SLACK = 1e-6  # the limit itself is known to so many digits

_NO_TIMES = np.empty(0)
_NO_SNAPSHOTS = np.empty((0, 0))
_NO_SAMPLES = np.empty((3, 0))


class Stepper:
    """A column between two calls. Time belongs to the caller, who passes it in.

    All that a run has behind it is in `state` (float64) and `counters` (int64): copying them saves it. Raises
    InputError for a fixed step that is not stable.
    """

    def __init__(self, column: Column, initial: InitialState | None = None) -> None:
        _check_step(column)
        self.n = column.n
        self.model = pack_model(column)
        self.state, self.counters = pack_state(column, initial)
        self.inputs = np.zeros(at.INPUTS)
        self._work = np.zeros(at.work_size(self.n))
        self._row = np.zeros((1, at.row_size(self.n)))
        self._split = np.zeros(at.SPLIT)

    def advance(self, t: float, h: float) -> None:
        """Go from t to t + h, s, under `inputs`. Raises SolverError."""
        self._check(self._run(t, h, _NO_SAMPLES, False, _NO_TIMES, _NO_SNAPSHOTS), t)

    def observe(self, t: float) -> FloatArray:
        """The output row at time t under the present `inputs`; overwritten by the next call. Raises SolverError."""
        code = observe_state(self.model, self.state, self.counters, self.inputs, self._work, t, self._row, self._split)
        self._check(code, t)
        row: FloatArray = self._row[0]
        return row

    @property
    def split(self) -> FloatArray:
        """Base reaction of the row last observed as R0 - M a: R0 and the effective mass M (layout.py, SPLIT)."""
        return self._split

    def stand_on_base(self) -> None:
        """Start upright on the base as the inputs have it, turned and turning, instead of upright in space."""
        self.state[at.BASE_THETA] = self.inputs[at.INPUT_BASE_THETA]
        self.state[at.BASE_OMEGA] = self.inputs[at.INPUT_BASE_OMEGA]

    def run(self, motion: Motion, stop: float, times: FloatArray) -> FloatArray:
        """Follow a motion from its start to time `stop`, s; a snapshot for each of `times`. Raises SolverError."""
        snapshots = np.zeros((times.size, at.snapshot_size(self.n)))
        samples = np.stack((motion.time, motion.ax, motion.az))
        if motion.end > motion.time[-1]:  # the last held sample ends where the motion does
            samples = np.column_stack((samples, (motion.end, 0.0, 0.0)))
        start = float(motion.time[0])
        self.inputs[at.INPUT_AMPLITUDE] = motion.amplitude
        self.inputs[at.INPUT_OMEGA] = 2.0 * math.pi * motion.frequency
        self.inputs[at.INPUT_PHASE] = -2.0 * math.pi * motion.frequency * motion.start
        self._check(self._run(start, stop - start, samples, motion.hold, times, snapshots), None)
        return snapshots

    def rows_of(self, snapshots: FloatArray) -> FloatArray:
        """The output row that belongs to each snapshot. Raises SolverError."""
        rows = np.zeros((len(snapshots), at.row_size(self.n)))
        code, count = observe_snapshots(self.model, self._work, self.counters.copy(), snapshots, rows)
        if code != at.OK:
            raise SolverError(f"output row {count}: {REASONS[code]}")
        return rows

    def retune(self, column: Column) -> None:
        """Go on from the present coordinates and rates with other parameters of the same blocks. Raises InputError."""
        _check_step(column)
        self.model = pack_model(column)
        self._work[:] = 0.0  # the responses of the modes are those of the model before
        if not self.overturned_joint:
            self.state[at.BASE_AX] = math.nan  # belongs to no input: the accelerations are to be computed anew

    @property
    def time_spent(self) -> float:
        """What the column has been advanced by so far while it stood, s."""
        return float(self.state[at.TIME_FULL] + self.state[at.TIME_ROCKING] + self.state[at.TIME_FLIGHT])

    @property
    def overturned_joint(self) -> int:
        """Number of the joint over which the column has fallen; 0 while it stands."""
        return int(self.counters[at.OVERTURNED])

    @property
    def overturn_time(self) -> float:
        """Time of overturning, s; NaN while the column stands."""
        return float(self.state[at.OVERTURN_TIME]) if self.overturned_joint else math.nan

    @property
    def peaks(self) -> NDArray[np.float64]:
        """Largest |u_x| of each top face so far, m (n,); kept by `run` only."""
        peaks: FloatArray = self.state[at.STATE_HEADER + 6 * self.n :]
        return peaks

    def _run(
        self, t: float, h: float, samples: FloatArray, hold: bool, times: FloatArray, snapshots: FloatArray
    ) -> int:
        """The kernel, compiled once: its numbers are float64 and its arrays contiguous, whatever the caller has."""
        arrays = self.model, self.state, self.counters, self.inputs, self._work
        code: int = run(*arrays, float(t), float(h), np.ascontiguousarray(samples), hold, times, snapshots)
        return code

    def _check(self, code: int, t: float | None) -> None:
        if code < at.OK:
            when = f"after {self.time_spent:.6g} s" if t is None else f"at t = {t:.6g} s"
            raise SolverError(f"{when}: {REASONS[code]}")


def _check_step(column: Column) -> None:
    """Raise InputError for a step beyond the stability limit: a joint that opens would bound, and hide, the blow-up."""
    step = column.settings.step
    if column.settings.integrator == "central-difference":
        limit = longest_stable_step(column)
        if step > limit * (1.0 + STEP_SLACK):
            raise InputError(
                f"solver.step = {step}: must be at most {limit:.4g} s, where central differences are stable"
            )
