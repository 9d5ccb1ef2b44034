"""Many runs at once: eight columns in the lanes of one core, and threads on top.

Each run enters a lane, with its own column, motion, time and step (kernels/column/batch/): at once, or after a first
part made alone by modes, up to the opening of a joint, if that is likely to be cheaper. The result of a run does not
depend on the other runs in the lanes, nor on their order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.turns import lock_released
from ...ground.motion import Motion
from ...kernels.column.api.entries import run
from ...kernels.column.batch.entries import (
    run_lanes,
    run_rimmed,
    run_round,
    run_round_slipping,
    run_slipping,
    run_stripped,
)
from ...kernels.column.batch.runs import OUTCOME, RUN, SLIP_FIELDS, SPACE
from ...kernels.layout import spaces as at
from ...kernels.machine.entry import Entry
from ...kernels.numba_ext.lanes import WIDTH
from ..samples import Samples
from .lane_policy import enters_at_once, kind_of
from .model import Column
from .packing import Arrays, FloatArray, arrays_at, coordinates_of, copied

# The error of steps across changes of regime exceeds the estimate: they get this fraction of the tolerance. Measured on
# columns of 1 and 3 blocks (eta 1e-3 and 5e-3 s; harmonics, three records at half scale; tolerances of 1e-3 to 1e-6;
# amplification below 100): errors of up to 11 tolerances without, 2.7 with it, for 1.3 times the steps.
TOLERANCE_PART = 0.3

MOST_ASSEMBLED = 64  # columns whose arrays are cached for their other runs
LINE = 64  # bytes in a cache line: lanes that cross its boundary cost a tenth more


class LaneKernels(NamedTuple):
    """A kind of lanes; each is compiled separately."""

    follow: Entry
    slips: bool = False  # whether the columns have slips
    section: str = "rectangle"  # section of some joint other than rectangles
    stages: int = 6  # evaluations per step


# in the order of the sections that they support; kinds with slips and without never share lanes
KINDS = {
    "plain": LaneKernels(run_lanes),
    "round": LaneKernels(run_round, section="circle"),
    "slipping": LaneKernels(run_slipping, True),
    "round, slipping": LaneKernels(run_round_slipping, True, "circle"),
    "strips, slipping": LaneKernels(run_stripped, True, "strips"),
    "rims, slipping": LaneKernels(run_rimmed, True, "rims"),
}
KNOW = tuple(KINDS)

_NONE = np.empty(0)


@dataclass(frozen=True)
class BatchResult:
    """The results of runs, in their order: peak_top_ux m (runs, n), fallen (0 if not), overturn_time s (NaN)."""

    peak_top_ux: FloatArray
    fallen: NDArray[np.int64]
    overturn_time: FloatArray
    finished: NDArray[np.bool_]  # False if the tolerance required too small a step
    steps: NDArray[np.int64]
    evaluations: NDArray[np.int64]
    ends: FloatArray  # (runs, 4 n or 6 n) coordinates and rates at the end, as in kinematics.py
    phases: FloatArray  # (runs, rows, 4 n or 6 n) coordinates and rates at the requested times
    models: FloatArray  # packed models, a row for each run


def follow_in_lanes(
    columns: Sequence[Column],
    motions: Sequence[Motion],
    durations: Sequence[float],
    times: FloatArray | None = None,
    flag: FloatArray | None = None,
) -> BatchResult:
    """Run column k under motion k, from rest, for duration k (s), in one thread; they are of one kind, unchecked.

    The columns have equal numbers of blocks. Phases are stored at `times` after the start of a run (s). Once flag[0] is
    set, the call returns soon, without usable results.
    """
    rows = _NONE if times is None else np.ascontiguousarray(times, dtype=np.float64)
    flag = np.zeros(1) if flag is None else flag
    batch = _Batch(columns[0].n, len(columns), _Records(motions, durations), rows, lanes_of(columns))
    for k, (column, motion, duration) in enumerate(zip(columns, motions, durations, strict=True)):
        if not flag[0]:
            batch.begin(k, column, motion, float(duration))
    batch.finish(flag)
    return batch.result()


def lanes_of(columns: Sequence[Column]) -> LaneKernels:
    """Return the kind of lanes with most sections; its results are bitwise those of simpler kinds."""
    own: LaneKernels | None = columns[0].kind.own_lanes
    return own or KINDS[max({kind_of(column) for column in columns}, key=KNOW.index)]


def rest_in_lanes(
    models: FloatArray,
    n: int,
    kind: LaneKernels,
    phases: FloatArray,
    begin: FloatArray,
    end: FloatArray,
    flag: FloatArray,
) -> BatchResult:
    """Follow columns of n blocks on a still base, each from `begin` to `end` (s), in one thread and unchecked.

    `models` are packed, a row for each column; `phases` (columns, 4 n) are those at `begin`. `flag` as in
    `follow_in_lanes`.
    """
    batch = _Batch(n, len(phases), _Records((), ()), _NONE, kind)
    batch.go_on(models, phases, begin, end)
    batch.finish(flag)
    return batch.result()


class _Records:
    """The samples of all motions, each motion once, concatenated."""

    def __init__(self, motions: Sequence[Motion], durations: Sequence[float]) -> None:
        self._places: dict[int, tuple[int, int]] = {}  # of a motion: first sample, number of samples
        self._silent: dict[int, bool] = {}
        samples, first = [], 0
        for motion, duration in zip(motions, durations, strict=True):
            key = id(motion)
            if key not in self._silent:
                self._silent[key] = not (motion.ax.any() or motion.az.any())
            if key not in self._places and not self._is_wave(motion, duration):
                self._places[key] = first, len(motion.time)
                samples.append((motion.time, motion.ax, motion.az))
                first += len(motion.time)
        self.rows = [np.concatenate(parts) for parts in zip(*samples, strict=True)] if samples else [np.zeros(1)] * 3

    def _is_wave(self, motion: Motion, duration: float) -> bool:
        """Return True if a run needs no samples, as there is only the harmonic part, to the end of the run."""
        return self._silent[id(motion)] and duration <= motion.duration

    def place(self, motion: Motion, duration: float) -> tuple[int, int]:
        """Return the first sample and the number of samples of a run, whichever others there are; 0 and 0 of a wave."""
        return (0, 0) if self._is_wave(motion, duration) else self._places[id(motion)]


class _Batch:
    """The runs as rows (kernels/column/batch/runs.py), and buffers for the first part of one run at a time."""

    def __init__(self, n: int, count: int, records: _Records, rows: FloatArray, kind: LaneKernels) -> None:
        self.n, self._kind = n, kind
        self._slips = np.zeros((count, SLIP_FIELDS * n if self._kind.slips else 0))
        self._records = records
        self._rows = rows
        self._models = np.zeros((count, at.MODEL.size(n)))
        self._phases = np.zeros((count, 4 * n))
        self._runs = np.zeros((count, RUN.beside))
        self._outcomes = np.zeros((count, OUTCOME.size(n)))  # of runs that wait for a lane
        self._outcomes[:, :2] = at.OK, math.nan
        self._snapshots = np.zeros((count, rows.size, at.PHASE.size(n)))
        self._evaluations = np.zeros(count, dtype=np.int64)
        self._waiting: list[int] = []
        self._assembled: dict[int, Arrays] = {}  # by the id of the column, of some columns

    def begin(self, k: int, column: Column, motion: Motion, duration: float) -> None:
        """Put run k in the queue for a lane, from rest or from the opening of a joint; or finish it here."""
        n, start, stop = self.n, motion.start, motion.start + duration
        fresh = self._at_rest(column)
        model, phase = fresh.model, fresh.state[at.CONTROL.beside :]
        self._models[k] = model[: self._models.shape[1]]
        omega = 2.0 * math.pi * motion.frequency
        wave = (motion.amplitude, omega, -omega * start)
        first, size = self._records.place(motion, duration)
        self._keep_slips(k, phase)
        if not model[_HAS_MODES] or enters_at_once(column, model[_ORDER], motion, size):
            self._outcomes[k, OUTCOME.beside + n :] = phase[: 4 * n]
            self._waits(k, phase[: 4 * n], (start, start, stop, 1.0, *wave, first, size, 0, 0.0, 0.0))
            return
        # first part alone, by modes, up to the opening of a joint
        arrays = copied(fresh)
        control, counts, base = at.CONTROL.see(arrays.state), at.COUNTS.see(arrays.counts), at.BASE.see(arrays.base)
        base.wave_amplitude, base.wave_omega, base.wave_phase = wave
        counts.until_opening = 1
        time, ax, az = (row[first : first + size] for row in self._records.rows)
        times = start + self._rows if self._rows.size else np.array([stop])
        stored = np.zeros((times.size, at.snapshot_size(n, column.has_slips)))
        with lock_released():
            code = run(n, *arrays, *Samples(time, ax, ax, az), start, duration, times, stored.reshape(-1), True)
        whole, peaks = arrays.state[at.CONTROL.beside :], at.STATE.see(arrays.state, n).peaks[:n]
        phase = whole[: 4 * n]
        self._keep_slips(k, whole)
        self._outcomes[k] = np.concatenate([[code, math.nan, 0.0, counts.steps, counts.rejected], peaks, phase])
        self._evaluations[k] = counts.evaluations
        if self._rows.size:
            phases = at.phases_in(stored)
            self._snapshots[k, :, : phases.shape[1]] = phases
        if code == at.OK and control.reached < stop:
            scales = (control.rotation_scale, control.rate_scale)
            entering = (start, control.reached, stop, 1.0, *wave, first, size, counts.next_row, *scales)
            self._waits(k, phase, entering)

    def _at_rest(self, column: Column) -> Arrays:
        """Return the arrays of a column at rest, cached, not to be modified."""
        found = self._assembled.get(id(column))
        if found is None:
            if len(self._assembled) == MOST_ASSEMBLED:
                self._assembled.clear()
            found = arrays_at(column, TOLERANCE_PART * column.settings.tolerance, at.EXTREMES)
            self._assembled[id(column)] = found
        return found

    def go_on(self, models: FloatArray, phases: FloatArray, begin: FloatArray, end: FloatArray) -> None:
        """Put all runs in the queue for a lane, with these phases, on a still base."""
        self._waiting = list(range(len(models)))
        self._models, self._phases = models, phases
        for name, values in (("origin", begin), ("start", begin), ("stop", end), ("scale", 1.0)):
            self._runs[:, RUN.fields.index(name)] = values
        self._outcomes[:, OUTCOME.beside + self.n :] = phases

    def _keep_slips(self, k: int, phase: FloatArray) -> None:
        """Store the second part of a phase as that of run k, if columns have slips."""
        if self._kind.slips:
            self._slips[k] = phase[at.RIGID_FIELDS * self.n : at.PHASE_FIELDS * self.n]

    def _waits(self, k: int, phase: FloatArray, entering: tuple[float, ...]) -> None:
        """Put run k in the queue for a lane."""
        self._waiting.append(k)
        self._phases[k], self._runs[k] = phase, entering

    def finish(self, flag: FloatArray) -> None:
        """Run all queued runs through the lanes."""
        some = np.array(self._waiting, dtype=np.int64)
        if not some.size:
            return
        left = self._runs[some, _STOP] - self._runs[some, _START]
        some = some[np.argsort(-left, kind="stable")]  # the longest first: lanes end together
        models, phases, runs = (array[some].reshape(-1) for array in (self._models, self._phases, self._runs))
        outcomes, snapshots, slips = self._outcomes[some], self._snapshots[some], self._slips[some]
        lanes = aligned(WIDTH * SPACE.size(self.n))
        found = outcomes.reshape(-1)
        with lock_released():
            self._kind.follow(
                self.n, lanes, some.size, models, phases, slips.reshape(-1), runs, found, *self._records.rows,
                self._rows, snapshots.reshape(-1), flag,
            )  # fmt: skip
        # the kernels count steps; evaluations follow from them
        tried = np.sum(outcomes[:, _TRIED] - self._outcomes[some][:, _TRIED], axis=1)
        self._evaluations[some] += (self._kind.stages * tried).astype(np.int64)
        self._outcomes[some], self._snapshots[some], self._slips[some] = outcomes, snapshots, slips

    def result(self) -> BatchResult:
        """Return the results of the runs."""
        n = self.n
        code, time, joint, steps, _ = self._outcomes[:, : OUTCOME.beside].T
        return BatchResult(
            peak_top_ux=self._outcomes[:, OUTCOME.beside :][:, :n],
            fallen=joint.astype(np.int64),
            overturn_time=np.where(joint > 0, time, np.nan),
            finished=code >= at.OK,
            steps=steps.astype(np.int64),
            evaluations=self._evaluations,
            ends=coordinates_of(self._outcomes[:, OUTCOME.beside + n :], self._slips, n),
            phases=coordinates_of(
                self._snapshots, self._snapshots[:, :, at.RIGID_FIELDS * n :][..., : self._slips.shape[1]], n
            ),
            models=self._models,
        )


_HAS_MODES = at.SETTINGS.fields.index("has_modes")
_ORDER = at.SETTINGS.fields.index("explicit_order")
_START, _STOP = RUN.fields.index("start"), RUN.fields.index("stop")
_TRIED = [OUTCOME.parts["record"].fields.index(name) for name in ("steps", "rejected")]  # type: ignore[attr-defined]


def aligned(size: int) -> FloatArray:
    """Return zeros that begin at a cache line."""
    room = np.zeros(size + LINE // 8)
    first = (-room.ctypes.data % LINE) // 8
    return room[first : first + size]
