"""One column in motion: owns the flat arrays and drives the engine over them."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ...common import effort
from ...common.aliases import Alias
from ...common.errors import SolverError, TooMuchWorkError
from ...ground.motion import Motion
from ...kernels.column.api import entries
from ...kernels.column.api.engine import BASE_INPUTS
from ...kernels.column.formulations.coupled_base import BODY
from ...kernels.engine.control import most_work
from ...kernels.layout import spaces as at
from ...kernels.machine.entry import Call, offset
from ...kernels.machine.library import load
from ..outputs import BOND, peaks_by_name, visible_peaks
from ..samples import NO_SAMPLES, Samples, plain, samples_of
from .model import Column
from .outputs import OUTPUTS
from .packing import Arrays, FloatArray, InitialState, arrays_of, pack_model, set_initial

REASONS = {
    at.STEP_TOO_SMALL: "the tolerance requires a step that is too small to continue; a larger tolerance may help",
    at.NOT_CONVERGED: "the Gauss-Seidel sweeps do not converge: the displacements are beyond the first-order model, "
    'or the step is beyond its stability limit; formulation = "exact" or a smaller step may help',
    at.NOT_FINITE: "the motion has become infinite: the step is beyond the stability limit of the integrator, "
    "or the input is not a physical one",
    at.TOO_MUCH_WORK: "the motion is too fast to be followed: a thousand times the evaluations of the worst benchmark "
    "do not suffice; the input or the state is not a physical one, or a fixed step is far too short",
    at.CALL_TOO_LONG: "the step takes more evaluations than one call may; several shorter ones can be made",
    at.INPUT_TOO_LARGE: "an input of the base is, or becomes, larger than 1e6 (m/s2, rad, rad/s, rad/s2)",
    at.BODY_LACKING: "what drives the base has no mass: body.Mxx must be positive, and Mzz and Mtt where base.drive is "
    "body",
    at.RECORD_BESIDE: "base.record must be empty where a body drives the base: the ground moves that body",
    at.UNKNOWN_METHOD: "the method of the step has no line in solver/kernels/column/integrators/traits.py",
    at.ROTATES: 'the base rotates: formulation = "paper" has no such motion, "exact" has',
}

# A run is made in chunks, after each of which an interrupt is handled: evaluations times blocks in each, about 0.03 s.
# They are counted, not timed, so that chunks end at equal instants on every machine: the steps end on them.
CHUNK = 4e5
EVALUATIONS_PER_FIRST_STEP = 4.0  # estimate for the first chunk; a rocking column needs fewer
LEAST_CHANGE, MOST_CHANGE = 0.125, 2.0  # range of the ratio of the lengths of successive chunks
ROWS_AT_ONCE = 10_000

_NONE = np.empty(0)
_TURN = 8 * at.BASE.fields.index("theta")  # bytes
_MOVED, _TURNED = struct.Struct("5d"), struct.Struct("3d")  # numpy takes thrice as long for a few numbers
_T, _T_H = struct.Struct("=d"), struct.Struct("=2d")  # in the buffers of calls, t and h are adjacent
_T_OF_RUN, _T_OF_LOOK = offset(entries.run, "t"), offset(entries.observe_state, "t")  # equal for all kinds of columns


class Stepper:
    """A column between two calls; the caller owns the time and passes it in.

    The whole state of a run is in `arrays.state`, `arrays.counts` and `arrays.base`: copying them saves it. `model`,
    `state`, `counts` and `base` are views of the same numbers (layout/spaces.py); writing to them takes effect.
    `record` is followed in addition to `base`. Raises InputError for a fixed step that is not stable.
    """

    def __init__(self, column: Column, initial: InitialState | None = None) -> None:
        self.column = column
        self.n = column.n
        self._entries = column.kind.entries
        load(self._entries.run.group)  # before `assemble`, so that both groups are made at the same time
        self.arrays: Arrays = arrays_of(column)
        if initial is not None:
            set_initial(column, self.arrays.state, initial)
        self.model = at.MODEL.see(self.arrays.model, self.n)
        self.state = at.STATE.see(self.arrays.state, self.n)
        self.counts = at.COUNTS.see(self.arrays.counts)
        self.base = at.BASE.see(self.arrays.base)
        self.followed = NO_SAMPLES  # by the last run
        self._is_driven = False  # whether bodies drive the base
        self.lacks_mass = False  # whether these have forces but no mass
        self._base = self.arrays.base.data
        row = at.ROW.size(self.n) + at.SPOTS.size(len(column.ports)) + column.sizes[BOND]
        self._whole = np.zeros(row + at.SPLIT.beside + at.DRIVEN.beside)
        self._row, self._split = self._whole[:row], self._whole[row:]
        self.seen = self._whole[: row + at.SPLIT.beside]
        """The output row last observed and its split; then the motion of the base where bodies may drive it."""
        self.record = NO_SAMPLES

    @property
    def record(self) -> Samples:
        """The samples that are followed in addition to `base`."""
        return self._record

    @record.setter
    def record(self, record: Samples) -> None:
        self._record = record
        given = self.n, *self.arrays, *record
        self._advance = Call(self._entries.run, (*given, 0.0, 0.0, _NONE, _NONE, True))
        self._observe = Call(self._entries.observe_state, (*given, 0.0, self._row, self._split))

    def drive(
        self,
        t: float,
        ax: float = 0.0,
        az: float = 0.0,
        jx: float = 0.0,
        jz: float = 0.0,
        theta: float = 0.0,
        omega: float = 0.0,
        alpha: float = 0.0,
        *behind: float,
        since: float | None = None,
    ) -> None:
        """Set the motion of the base from time t on.

        Parameters
        ----------
        t : float
            The time (s).
        ax, az : float
            The accelerations (m/s2).
        jx, jz : float
            Their slopes (m/s3).
        theta, omega, alpha : float
            The rotation (rad), its rate (rad/s) and acceleration (rad/s2).
        *behind : float
            The loads on the ports, if there are any: Fx of each (N), Fz, My (N m), then their slopes; none means no
            load. Then, if the base is `driven_by` bodies, for each body its F0x to Mtt at time t
            (kernels/column/formulations/coupled_base.py, BODY); the column adds R0 and m.
        since : float, optional
            The time for which all of these are given (s), by default t.

        Raises
        ------
        SolverError
            If a record is followed where bodies drive the base.
        """
        elapsed = 0.0 if since is None else t - since
        if self.column.ports:
            size = self._inputs.size
            values, slopes = np.reshape(behind[:size] or np.zeros(size), (2, -1))
            self._inputs[:], behind = np.concatenate([values + slopes * elapsed, slopes]), behind[size:]
        if self._is_driven:
            self._join(t, [ax, az, jx, jz, theta, omega, alpha, *behind])
            return
        _MOVED.pack_into(self._base, 0, t, ax + jx * elapsed, jx, az + jz * elapsed, jz)
        turn = theta + elapsed * (omega + 0.5 * elapsed * alpha)
        _TURNED.pack_into(self._base, _TURN, turn, omega + elapsed * alpha, alpha)

    def driven_by(self, drive: str, slope: str, bodies: int) -> None:
        """Let up to `bodies` bodies at the base drive it, by words of DRIVES and SLOPES (layout/spaces.py).

        If there may be any, `seen` ends with the motion of the base.
        """
        settings = self.model.settings
        settings.drive, settings.slope, settings.bodies = at.DRIVES[drive], at.SLOPES[slope], bodies
        self._is_driven = settings.drive != at.ACCELERATION
        self.seen = self._whole if bodies else self._whole[: len(self._whole) - at.DRIVEN.beside]

    def _join(self, t: float, given: list[float]) -> None:
        if self.record is not NO_SAMPLES:
            raise SolverError(f"at t = {t:.6g} s: {REASONS[at.RECORD_BESIDE]}")
        model, base = self.arrays.model, self.arrays.base
        inputs = np.zeros(BASE_INPUTS.beside + BODY.beside * int(self.model.settings.bodies))
        inputs[: len(given)] = given
        if not self.counts.started:  # outputs may have been read under another rotation
            self.base.coupled = 0.0
        self._entries.arrive_base(self.n, model, base, inputs, float(t))
        self.observe(t)
        self.lacks_mass = self._entries.couple_base(self.n, model, base, inputs, self._split) < at.OK

    def advance(self, t: float, h: float) -> None:
        """Advance from t to t + h (s) under `base` and `record`; all peaks are tracked. Raises SolverError."""
        if self.lacks_mass:
            self._check(at.BODY_LACKING, t)
        if self._is_driven:
            self._entries.examine_base(self.n, self.arrays.model, self.arrays.base, float(h))
        _T_H.pack_into(self._advance.buffer, _T_OF_RUN, t, h)
        code = self._advance()
        if code < at.OK:
            self._check(code, t)

    def observe(self, t: float) -> FloatArray:
        """Return the output row at time t (layout/spaces.py, ROW); the next call overwrites it. Raises SolverError."""
        _T.pack_into(self._observe.buffer, _T_OF_LOOK, t)
        code = self._observe()
        if code < at.OK:
            self._check(code, t)
        return self._row

    @property
    def split(self) -> FloatArray:
        """The base reaction of the last row as R0 - M a: R0 and the effective mass M (layout/spaces.py, SPLIT)."""
        return self._split[: at.SPLIT.beside]

    @property
    def _inputs(self) -> FloatArray:
        """The loads on the ports that were set, and their slopes."""
        return self.arrays.base[at.BASE.beside :]

    def stand_on_base(self) -> None:
        """Start upright on the base at its present rotation and rate, instead of upright in space."""
        self.state.control.base_theta = self.base.theta
        self.state.control.base_omega = self.base.omega

    def run(
        self,
        motion: Motion,
        stop: float,
        times: FloatArray,
        after_chunk: Callable[[float], None] | None = None,
    ) -> FloatArray:
        """Follow a motion from its start to the time `stop` (s), and return a snapshot at each of `times` (s).

        `after_chunk` is called with the time reached, several times per second of the clock; an exception that it
        raises ends the run. Raises SolverError if the motion cannot be followed.
        """
        snapshots = np.zeros((times.size, self.column.kind.snapshot_size(self.column)))
        self.base.wave_amplitude = motion.amplitude
        self.base.wave_omega = 2.0 * math.pi * motion.frequency
        self.base.wave_phase = -2.0 * math.pi * motion.frequency * motion.start
        record = self.followed = samples_of(motion, [port.name for port in self.column.ports], in_plane=True)
        self._follow(float(motion.time[0]), stop, record, plain(times), snapshots.reshape(-1), True, after_chunk)
        return snapshots

    def rest_until(self, t: float, stop: float) -> None:
        """Advance from t to `stop` (s) on a base that does not accelerate. Raises SolverError."""
        self.drive(t)
        self.base.wave_amplitude = 0.0
        self._follow(t, stop, NO_SAMPLES, _NONE, _NONE, False, None)

    def _follow(
        self,
        t: float,
        stop: float,
        record: Samples,
        times: FloatArray,
        snapshots: FloatArray,
        peaks: bool,
        after_chunk: Callable[[float], None] | None,
    ) -> None:
        settings = self.model.settings
        step = settings.step if self.column.kind.fixed else settings.first_step
        if self.base.wave_amplitude:  # an upper bound of steps (kernels/column/stepping/control.py)
            step = min(step, 1.0 / self.base.wave_omega)
        chunk = CHUNK * float(step) / (EVALUATIONS_PER_FIRST_STEP * self.n)
        done = begun = self._work_done
        whole = stop - t
        most, lost = most_work(settings, whole), 0  # of all chunks: each has its own limit in the kernel
        changing = self.arrays.state, self.arrays.counts, self.arrays.base
        while t < stop:
            left = stop - t
            pieces = math.ceil(left / chunk)
            end = stop if pieces <= 1 else t + (left / pieces if pieces <= 4 else chunk)  # avoids a tiny last step
            before, kept = done, [array.copy() for array in changing]
            code = self._entries.run(self.n, *self.arrays, *record, t, end - t, times, snapshots, peaks)
            if code == at.CALL_TOO_LONG:  # the chunk has grown while little happened: go back and try a shorter one
                lost += self._work_done - before
                if lost > most:
                    raise self._work_error(self._work_done, 1.0 - (stop - t) / whole)
                for array, values in zip(changing, kept, strict=True):
                    array[:] = values
                chunk = LEAST_CHANGE * (end - t)
                continue
            if code == at.TOO_MUCH_WORK:  # the limit of a chunk
                raise self._work_error(self._work_done, 1.0 - (stop - t) / whole)
            self._check(code, None)
            t = end
            if after_chunk is not None:
                after_chunk(t)
            done = self._work_done
            part = 1.0 - (stop - t) / whole
            if done - begun > most or effort.is_too_much(done, part, effort.MOST):
                raise self._work_error(done, part)
            chunk *= min(MOST_CHANGE, max(LEAST_CHANGE, CHUNK / max(1.0, self.n * (done - before))))

    def _work_error(self, done: float, part: float) -> TooMuchWorkError:
        return TooMuchWorkError(f"after {self.time_spent:.6g} s: {effort.slowness(done, part, self._causes())}")

    def _causes(self) -> Iterator[effort.Cause]:
        """Yield the possible causes of short steps."""
        column = self.column
        for i, (block, contact) in enumerate(zip(column.blocks, column.contacts, strict=True), start=1):
            law = block.joint
            below = column.blocks[i].mass if i < column.n else math.inf
            yield effort.of_joint(f"block[{i}].joint", law.stiffness, contact.area, min(block.mass, below), law.damping)
        if self.base.wave_amplitude:
            yield effort.of_harmonic(float(self.base.wave_omega) / (2.0 * math.pi))
        if column.kind.fixed:
            step = column.settings.step
            yield effort.Cause(1.0 / step, f"solver.step = {step:g} s")

    @property
    def _work_done(self) -> int:
        return int(self.counts.evaluations + self.counts.sweeps)

    def rows_of(self, snapshots: FloatArray, times: FloatArray = _NONE) -> FloatArray:
        """Return the output row of each snapshot; their times are needed if there are ports.

        Raises SolverError if one cannot be computed.
        """
        rows, done = np.zeros((len(snapshots), len(self._row))), np.zeros(1, dtype=np.int64)
        arrays = self.arrays._replace(counts=self.arrays.counts.copy(), base=self.arrays.base.copy())
        given, times = (self.n, *arrays, *self.followed), plain(times)
        for first in range(0, len(snapshots), ROWS_AT_ONCE):
            at_once = slice(first, first + ROWS_AT_ONCE)
            part, filled = snapshots[at_once].reshape(-1), rows[at_once].reshape(-1)
            size = len(rows[at_once])
            code = self._entries.observe_snapshots(*given, times[at_once], part, filled, size, done)
            if code != at.OK:
                raise SolverError(f"output row {first + int(done[0])}: {REASONS[code]}")
        return rows

    def retune(self, column: Column) -> None:
        """Replace the parameters of the blocks, and continue from the present coordinates and rates.

        Raises InputError if the column is invalid.
        """
        before = self.model.settings
        self.arrays = self.arrays._replace(model=pack_model(column).copy())
        self.column, self.record = column, self.record  # over the new model
        self.model = at.MODEL.see(self.arrays.model, self.n)
        settings = self.model.settings
        settings.drive, settings.slope, settings.bodies = before.drive, before.slope, before.bodies
        self.arrays.work[:] = 0.0  # the responses of the modes belong to the previous model
        if not self.fallen:
            self.state.control.base_ax = math.nan  # differs from any input, so that the accelerations are evaluated

    @property
    def time_spent(self) -> float:
        """The time for which the column has been advanced while it stood (s)."""
        control = self.state.control
        return float(control.time_full + control.time_rocking + control.time_flight)

    @property
    def fallen(self) -> int:
        """The number of the block that has fallen over its joint; 0 while the column stands."""
        return int(self.counts.overturned)

    @property
    def fall_time(self) -> float:
        """The time of the fall (s); NaN while the column stands."""
        return float(self.state.control.overturn_time) if self.fallen else math.nan

    overturned_joint, overturn_time, peak_ux = Alias("fallen"), Alias("fall_time"), Alias("peak_top_ux")

    @property
    def peak_top_ux(self) -> NDArray[np.float64]:
        """The largest |ux| of each top face so far, m (n,)."""
        return self.state.peaks[: self.n]

    @property
    def peaks(self) -> dict[str, FloatArray]:
        """The largest absolute values so far by name, copies: (n,) of blocks and joints, (1,) of the base.

        `contact` has the least; `friction` is |T| / N while N counts (layout/spaces.py, PEAKS). Only those of ux with
        `without = ["peaks"]`.
        """
        if "peaks" in self.column.settings.without:
            return {"ux": self.peak_top_ux.copy()}
        return peaks_by_name(OUTPUTS, self.column.sizes, self._peaks)

    @property
    def visible_peaks(self) -> FloatArray:
        """The `peaks` as an array, in the order of kernels/layout/spaces.py, PEAKS."""
        return visible_peaks(OUTPUTS, self.column.sizes, self._peaks)

    @property
    def _peaks(self) -> FloatArray:
        """The peaks of the kernels, with those of ports and bonds at their positions among the outputs."""
        column, peaks = self.column, self.state.peaks
        if not (column.ports or column.is_brittle):
            return peaks
        ports, bonds = self.arrays.state[at.STATE.size(self.n) :], self.state.phase.bond_lost[: column.sizes[BOND]]
        of_row = at.ROW.size(self.n)
        return np.concatenate([peaks[:of_row], ports, bonds, peaks[of_row:]])

    def _check(self, code: int, t: float | None) -> None:
        if code < at.OK:
            when = f"after {self.time_spent:.6g} s" if t is None else f"at t = {t:.6g} s"
            kind = TooMuchWorkError if code == at.TOO_MUCH_WORK else SolverError
            raise kind(f"{when}: {REASONS[code]}")
