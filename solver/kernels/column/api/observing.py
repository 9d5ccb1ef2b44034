"""Observation of a column: output rows and the split reaction, of its state or of snapshots."""

from ...engine.samples import segment_until
from ...layout.spaces import LOAD, OK, ROW, SNAPSHOT, SPOTS
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import clear, copy
from ..formulations.base_motion import moved_and_loaded
from ..formulations.exact import Motion
from ..formulations.feedthrough import split_reaction
from ..formulations.loads import ports_of, push_ports, pushes_of
from ..formulations.outputs import observe
from ..formulations.slips import phase_size, size_of_snapshot
from ..output.watch import watch_start
from ..stepping.advance import take_phase

_row, _snapshot = ROW.over, SNAPSHOT.over_begin
_ROW_FIELDS, _ROW_BESIDE, _SEEN, _COMPONENTS = ROW.per_n, ROW.beside, len(SPOTS.fields), len(LOAD)


@leaf
def _motion_held(column, control):
    """Return the motion of the base that the state belongs to; no load acts on an overturned column."""
    turned = control.base_theta, control.base_omega, control.base_alpha
    clear(pushes_of(column), _COMPONENTS * ports_of(column))
    return Motion(control.base_ax, control.base_az, *turned)


@leaf
def _motion_of_snapshot(column, snapshot, t):
    """Return the motion of the base, without rotation, and of the loads at the time t of a snapshot; before a jump."""
    ax, az = snapshot.base.ax, snapshot.base.az
    # loads on the ports, those of the instant of overturning afterwards
    if ports_of(column) > 0:
        if column.counts.overturned > 0:
            t = min(t, column.state.control.overturn_time)
        column.base.segment = segment_until(column.samples, t)
        push_ports(column, t)
    return Motion(ax, az, 0.0, 0.0, 0.0)


@leaf
def row_length(column):
    """Return the length of an output row, including the outputs of ports and bonds."""
    beside = _ROW_BESIDE + _SEEN * ports_of(column) + int(column.work.slips.bonds)
    return _ROW_FIELDS * column.model.n + beside


@kernel
def base_of(column, t):
    """Return the motion of the base at time t (s); once the column has overturned, the motion at that instant."""
    control = column.state.control
    # an overturned column keeps the motion of that instant
    if column.counts.overturned > 0:
        return _motion_held(column, control)
    return moved_and_loaded(column, t)


@kernel
def see(column, motion, row, split):
    """Fill an output row and the split reaction with the outputs of the state on a base. Returns a code.

    The phase is left in `work.between`.
    """
    between = column.work.between
    # the state relative to this base
    take_phase(column, motion, between)
    # outputs, then the split reaction
    code = observe(column, between, motion, row)
    return split_reaction(column, between, motion, row, split) if code == OK else code


@kernel
def see_at(column, t, row, split):
    """Run `see` at time t (s) on the base as it moves then. Before the first step the peaks become those of t."""
    motion = base_of(column, t)
    code = see(column, motion, row, split)
    if column.counts.started == 0 and code == OK:
        take_phase(column, motion, column.work.start)
        watch_start(column, motion)
    return code


@kernel
def observe_all(column, times, snapshots, rows, count):
    """Fill `count` rows with the outputs of as many snapshots. Returns (code, number of rows filled).

    times: times of the snapshots (s); read only where the column has ports.
    """
    n, between, size, length = column.model.n, column.work.between, size_of_snapshot(column.work), row_length(column)
    for k in range(count):
        # phase of the snapshot, and the motion that belongs to it
        snapshot = _snapshot(snapshots[size * k : size * (k + 1)], n)
        copy(between.row, snapshot.phase.buffer, phase_size(column.work))
        motion = _motion_of_snapshot(column, snapshot, times[k] if ports_of(column) > 0 else 0.0)
        code = observe(column, between, motion, _row(rows[k * length :], n))
        if code != OK:
            return code, k
    return OK, count
