"""Entries called from Python, with the arguments of those of the same names in api/entries.py and batch/entries.py."""

from ..api.engine import NO_REST, base_of, carries, describe, observe_all, reset, see
from ..api.entries import join_base as join_base
from ..batch.entries import queue_of
from ..batch.follow import batch_over
from ..formulations.base_motion import Samples, enter
from ..formulations.dispatch import Column
from ..layout.spaces import BASE, COUNTS, OK, ROW, SPLIT, STATE, WORK
from ..numba_ext.jit import entry, leaf
from ..numba_ext.views import lanes_of, row_of
from ..output.watch import Watch
from ..stepping.advance import advance
from . import outputs, stepping  # noqa: F401  versions of kernels
from .equations import MODEL, factorize_mass, settle
from .lanes import SPACE, follow_fixed_steps

_model, _state, _counts, _base, _work = MODEL.over, STATE.over, COUNTS.over, BASE.over, WORK.over
_row, _split, _space = ROW.over, SPLIT.over, SPACE.over


@leaf
def _column(n, model, state, counts, base, work, times, ax, az, scale, held):
    samples = Samples(times.size, row_of(times), row_of(ax), row_of(az), scale, held)
    parts = _model(row_of(model), n), _state(row_of(state), n), _counts(row_of(counts), 0), _base(row_of(base), 0)
    return Column(*parts, samples, _work(row_of(work), n))


@entry
def assemble_column(n, model, state, counts, base, work, given, from_rest, scratch, detail):
    """The column at rest; from_rest and scratch are not used."""
    column = _column(n, model, state, counts, base, work, given, given, given, 1.0, False)
    code = describe(column, row_of(given), row_of(detail))
    if code != OK:
        return code
    factorize_mass(column.model)
    reset(column)
    settle(column.model, column.state.phase)
    return OK if carries(column.model) else NO_REST


@entry
def run(n, model, state, counts, base, work, times, ax, az, scale, held, t, h, at, snapshots, peaks):
    """`advance`."""
    column = _column(n, model, state, counts, base, work, times, ax, az, scale, held)
    return advance(column, t, h, Watch(at.size, row_of(at), row_of(snapshots), peaks))


@entry
def observe_state(n, model, state, counts, base, work, times, ax, az, scale, held, t, row, split):
    """`engine.see`."""
    column = _column(n, model, state, counts, base, work, times, ax, az, scale, held)
    enter(column.base, column.samples, t)
    return see(column, base_of(column, t), _row(row_of(row), n), _split(row_of(split), 0))


@entry
def observe_snapshots(n, model, state, counts, base, work, snapshots, rows, count):
    """`observe` for each snapshot."""
    column = _column(n, model, state, counts, base, work, base, base, base, 1.0, False)
    return observe_all(column, row_of(snapshots), row_of(rows), count)


@entry
def run_fixed_steps(n, buffer, *queue):
    """All runs, eight at a time, without snapshots."""
    follow_fixed_steps(batch_over(_space(lanes_of(buffer), n), buffer, queue_of(*queue)))
