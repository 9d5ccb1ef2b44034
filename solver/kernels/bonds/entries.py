"""Entries called from Python, as those of the same names in api/entries.py, of a column with brittle joints.

`given` ends with GIVEN_OF_BOND of all joints (layout.py). Behind an output row stands what is bonded of each joint.
"""

from ..api.engine import assemble, base_of, observe_all, see
from ..api.entries import join_base as join_base
from ..formulations.base_motion import Samples, enter
from ..formulations.dispatch import Column
from ..formulations.slips import begin_slips
from ..layout.spaces import BASE, COUNTS, ROW, SPLIT
from ..numba_ext.jit import entry, leaf
from ..numba_ext.views import row_of
from ..output.watch import Watch
from ..stepping.advance import advance
from . import memory  # noqa: F401  versions of kernels
from .layout import MODEL, STATE, WORK

_model, _state, _counts, _base, _work = MODEL.over, STATE.over, COUNTS.over, BASE.over, WORK.over
_row, _split = ROW.over, SPLIT.over


@leaf
def column_over(n, model, state, counts, base, samples, work):
    """The column of n blocks over its rows."""
    column = Column(_model(model, n), _state(state, n), _counts(counts, 0), _base(base, 0), samples, _work(work, n))
    begin_slips(column.model, column.work)
    return column


@leaf
def _column(n, model, state, counts, base, work, times, ax, az, scale, held):
    samples = Samples(times.size, row_of(times), row_of(ax), row_of(az), scale, held)
    return column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))


@entry
def assemble_column(n, model, state, counts, base, work, given, from_rest, scratch, detail):
    """`engine.assemble`."""
    column = _column(n, model, state, counts, base, work, scratch, scratch, scratch, 1.0, False)
    return assemble(column, row_of(given), from_rest, row_of(scratch), row_of(detail))


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
    """`engine.observe_all`."""
    column = _column(n, model, state, counts, base, work, base, base, base, 1.0, False)
    return observe_all(column, row_of(snapshots), row_of(rows), count)
