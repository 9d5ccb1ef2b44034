"""Observation of a column: output rows and the split reaction, of its state or of snapshots."""

from ..formulations.base_motion import base_motion
from ..formulations.exact import Motion
from ..formulations.feedthrough import split_reaction
from ..formulations.outputs import observe
from ..formulations.slips import phase_size, size_of_snapshot
from ..layout.spaces import OK, ROW, SNAPSHOT
from ..numba_ext.jit import kernel, leaf, varied_leaf
from ..numba_ext.views import copy
from ..stepping.advance import take_phase

_row, _snapshot = ROW.over, SNAPSHOT.over_begin
_ROW_FIELDS, _ROW_BESIDE = ROW.per_n, ROW.beside


@varied_leaf
def motion_held(samples, control):
    """Return the motion of the base that the state belongs to; no load acts on an overturned column."""
    return Motion(control.base_ax, control.base_az, control.base_theta, control.base_omega, control.base_alpha)


@varied_leaf
def motion_of_snapshot(column, snapshot, k):
    """Return the motion of the base that snapshot k belongs to, without rotation."""
    return Motion(snapshot.base.ax, snapshot.base.az, 0.0, 0.0, 0.0)


@varied_leaf
def beside_row(column):
    """Return the number of values behind an output row: 0."""
    return 0


@leaf
def row_length(column):
    """Return the length of an output row, including the outputs of ports."""
    return _ROW_FIELDS * column.model.n + _ROW_BESIDE + beside_row(column)


@kernel
def base_of(column, t):
    """Return the motion of the base at time t (s); once the column has overturned, the motion at that instant."""
    control = column.state.control
    # an overturned column keeps the motion of that instant
    if column.counts.overturned > 0:
        return motion_held(column.samples, control)
    return base_motion(column.base, column.samples, t)


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
def observe_all(column, snapshots, rows, count):
    """Fill `count` rows with the outputs of the snapshots of the same number. Returns (code, number of rows filled)."""
    n, between, size, length = column.model.n, column.work.between, size_of_snapshot(column.work), row_length(column)
    for k in range(count):
        # phase of the snapshot, and the motion that belongs to it
        snapshot = _snapshot(snapshots[size * k : size * (k + 1)], n)
        copy(between.row, snapshot.phase.buffer, phase_size(column.work))
        motion = motion_of_snapshot(column, snapshot, k)
        code = observe(column, between, motion, _row(rows[k * length :], n))
        if code != OK:
            return code, k
    return OK, count
