"""The results kept of a run: peaks, and snapshots at requested times.

Requests never change the steps. They cost evaluations of their own (`counts.looks`).
"""

from typing import NamedTuple

from ...engine.interpolation import turning_point, value_of
from ...layout.spaces import EXTREMES, SLACK, SNAPSHOT
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import copy
from ..formulations.base_motion import base_motion, base_rotates, base_spin, base_turn
from ..formulations.bonds import keep_bonds, take_bonds
from ..formulations.dispatch import reach_of, top_motion
from ..formulations.slips import note_directions, phase_size, size_of_snapshot, take_directions
from ..integrators.interpolation import interpolate_acceleration, interpolate_phase, quintic_of, refine, slips_of
from ..joint.sliding import can_slide
from .peaks import begin_extremes, clear_peaks, track_extremes

_snapshot = SNAPSHOT.over_begin


class Watch(NamedTuple):
    """The requested results: `size` times (s) with a row for a snapshot each, and whether peaks are kept."""

    size: int
    times: object
    snapshots: object
    peaks: int  # 1: they are kept


@leaf
def _keeps_all(column, watch):
    return watch.peaks and not int(column.model.settings.without) & EXTREMES


@kernel
def begin_watching(column, watch, motion, evaluated):
    """Start the peaks at the start of a run with this motion of the base; `evaluated`: `work.joints` belongs to it."""
    if not watch.peaks:
        return
    # peaks of u_x at the start
    work, peaks = column.work, column.state.peaks
    tops = work.tops
    # displacements and velocities of the tops
    top_motion(column, work.start, tops.start_ux, tops.start_rate, motion.theta, motion.omega)
    for i in range(column.model.n):
        peaks[i] = max(peaks[i], abs(tops.start_ux[i]))
    if _keeps_all(column, watch):
        # all other outputs
        evaluations, sweeps = column.counts.evaluations, column.counts.sweeps
        begin_extremes(column, motion, evaluated)
        take_directions(work, work.start)
        take_bonds(work, work.start)
        _count_looks(column.counts, evaluations, sweeps)


@kernel
def watch_start(column, motion):
    """Set the peaks to those of the start, in `work.start`, while no step has been made."""
    clear_peaks(column)
    begin_watching(column, Watch(0, column.samples, column.samples, 1), motion, False)


@kernel
def watch_step(column, watch, t, h):
    """Keep the requested results of the step just made from t to t + h (s)."""
    # nothing is requested
    if not watch.peaks and watch.size == 0:
        return
    evaluations, sweeps = column.counts.evaluations, column.counts.sweeps
    if _keeps_all(column, watch):  # first: it needs the resultants of the end of the step
        track_extremes(column, t, h)
        take_directions(column.work, column.work.end)
        take_bonds(column.work, column.work.start)
    if watch.peaks:
        track_peaks(column, t, h)
    take_snapshots(column, watch, t, h)
    _count_looks(column.counts, evaluations, sweeps)


@leaf
def _count_looks(counts, evaluations, sweeps):
    """Count evaluations beyond `evaluations` as looks, and reset evaluations and sweeps to the given numbers."""
    counts.looks += counts.evaluations - evaluations
    counts.evaluations = evaluations
    counts.sweeps = sweeps


@kernel
def track_peaks(column, t, h):
    """Raise the peaks of |u_x| (m) by the step just made from t to t + h, including turning points inside."""
    model, work, peaks = column.model, column.work, column.state.peaks
    n, end = model.n, work.end
    # upper bound of the movement in the step: u_x is not evaluated unless that could reach a peak
    reach = 0.0
    passed = base_rotates(column.base)
    for i in range(n - 1, -1, -1):
        # movement of the top of block i by rotation and opening
        reach += reach_of(column, end.theta, end.opening, i)
        reach += h * reach_of(column, end.theta_rate, end.opening_rate, i)
        # by its slip, and by its offset as built as the faces rotate
        if can_slide(model):
            offset = model.blocks.offset[i]
            reach += abs(end.slip[i] - offset) + h * abs(end.slip_rate[i])
            for k in range(i, min(i + 2, n)):  # an offset shifts the faces as the joint rotates
                reach += abs(offset) * (abs(end.theta[k]) + h * abs(end.theta_rate[k]))
        passed = passed or reach > peaks[i]
    if not passed:
        return
    # displacements and velocities of the tops at both ends
    tops = work.tops
    base = column.base
    top_motion(column, work.start, tops.start_ux, tops.start_rate, base_turn(base, t), base_spin(base, t))
    top_motion(column, end, tops.end_ux, tops.end_rate, base_turn(base, t + h), base_spin(base, t + h))
    for i in range(n):
        d0, d1 = tops.start_ux[i], tops.end_ux[i]
        v0, v1 = tops.start_rate[i], tops.end_rate[i]
        peaks[i] = max(peaks[i], abs(d1))
        # inside, the step can only add a turning point, beyond its ends by a quarter of speed times step at most
        if v0 * v1 < 0.0 and max(abs(d0), abs(d1)) + h * min(abs(v0), abs(v1)) > peaks[i]:
            refine(column, t, h)
            s = turning_point(d0, v0, d1, v1, h)
            interpolate_phase(work, h, s)
            turn, spin = base_turn(base, t + s * h), base_spin(base, t + s * h)
            top_motion(column, work.between, tops.between_ux, tops.between_rate, turn, spin)
            peaks[i] = max(peaks[i], abs(tops.between_ux[i]))


@leaf
def row_due(counts, watch, t, h):
    """Return True if a snapshot is due in the step from t to t + h (s)."""
    return counts.next_row < watch.size and watch.times[counts.next_row] <= t + h * (1.0 + SLACK)


@leaf
def _within_step(watch, k, t, per_step):
    """Return time k as a fraction, from 0 to 1, of the step from t on, of 1 / per_step seconds."""
    return min(1.0, max(0.0, (watch.times[k] - t) * per_step))


@kernel
def take_snapshots(column, watch, t, h):
    """Store the state of the column at the requested times in the step from t to t + h (s)."""
    work, counts = column.work, column.counts
    n = column.model.n
    # snapshots that are due
    first_row = counts.next_row
    while row_due(counts, watch, t, h):
        counts.next_row += 1
    if counts.next_row == first_row:
        return
    refine(column, t, h)
    # coordinates and rates, one coordinate at a time
    per_step, size = 1.0 / h, size_of_snapshot(work)
    first, behind = slips_of(work)
    for i in range(2 * n + behind - first):
        place = i if i < 2 * n else first + i - 2 * n
        course = quintic_of(work, place, -1, h)
        for k in range(first_row, counts.next_row):
            stored = _snapshot(watch.snapshots[size * k : size * (k + 1)], n).phase
            stored.coordinates[place], stored.rates[place] = value_of(course, _within_step(watch, k, t, per_step))
    for k in range(first_row, counts.next_row):
        # what else belongs to a snapshot: directions of sliding, memory and the motion of the base
        snapshot, s = _snapshot(watch.snapshots[size * k : size * (k + 1)], n), _within_step(watch, k, t, per_step)
        for i in range(2 * n):  # a guess: they are computed with the row
            snapshot.phase.accelerations[i] = interpolate_acceleration(work, i, s)
        note_directions(work, snapshot.phase)
        keep_bonds(work, snapshot.phase)
        motion = base_motion(column, t + s * h)
        snapshot.base.ax = motion.ax
        snapshot.base.az = motion.az


@kernel
def take_held_snapshots(column, watch, t, h):
    """Store the state, which is constant from t to t + h (s), at the requested times in between."""
    state, counts, work = column.state, column.counts, column.work
    size = size_of_snapshot(work)
    while row_due(counts, watch, t, h):
        # the same state and base acceleration in each snapshot
        snapshot = _snapshot(watch.snapshots[size * counts.next_row : size * (counts.next_row + 1)], work.n)
        copy(snapshot.phase.buffer, state.phase.row, phase_size(work))
        snapshot.base.ax = state.control.base_ax
        snapshot.base.az = state.control.base_az
        counts.next_row += 1
