"""Entries called from Python, as those of the same names in api/entries.py, of a column with ports.

A record is (times, ax, az, scale, held, ports, loads): instants of base and loads; accelerations of the base, which may
end before; PORTS; and loads on each segment (loads.py). Inputs at ports lie behind those of the base, peaks of ports
behind the state, outputs of ports behind an output row.
"""

from ..api.engine import base_of, column_over, observe_all, see
from ..api.entries import assemble_column as assemble_column
from ..api.entries import join_base as join_base
from ..formulations.base_motion import enter
from ..layout.spaces import PORTS, ROW, SPLIT
from ..numba_ext.jit import entry, leaf
from ..numba_ext.views import row_of
from ..output.watch import Watch
from ..stepping.advance import advance
from .loads import Loaded

_row, _split = ROW.over, SPLIT.over
_PORT = len(PORTS.fields)


@leaf
def _column(n, model, state, counts, base, work, times, ax, az, scale, held, ports, loads, rows):
    lasting = 1 if loads.size > 0 else 0
    begin = times.size, row_of(times), row_of(ax), row_of(az), scale, held, ax.size
    of_ports = ports.size // _PORT, row_of(ports), lasting, row_of(loads)
    samples = Loaded(*begin, *of_ports, row_of(rows))
    return column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))


@entry
def run(n, model, state, counts, base, work, times, ax, az, scale, held, ports, loads, t, h, at, snapshots, peaks):
    """`advance`."""
    column = _column(n, model, state, counts, base, work, times, ax, az, scale, held, ports, loads, at)
    return advance(column, t, h, Watch(at.size, row_of(at), row_of(snapshots), peaks))


@entry
def observe_state(n, model, state, counts, base, work, times, ax, az, scale, held, ports, loads, t, row, split):
    """`engine.see`."""
    column = _column(n, model, state, counts, base, work, times, ax, az, scale, held, ports, loads, row)
    enter(column.base, column.samples, t)
    return see(column, base_of(column, t), _row(row_of(row), n), _split(row_of(split), 0))


@entry
def observe_snapshots(
    n, model, state, counts, base, work, times, ax, az, scale, held, ports, loads, at, snapshots, rows, count
):
    """`engine.observe_all` of snapshots at the times `at`."""
    column = _column(n, model, state, counts, base, work, times, ax, az, scale, held, ports, loads, at)
    return observe_all(column, row_of(snapshots), row_of(rows), count)
