"""Columns with brittle joints for callers that have pointers: the entries of api/pointers.py.

What `assemble` is given and what stands behind an output row are those of entries.py.
"""

from ..api import engine, pointers
from ..formulations.base_motion import Samples
from ..numba_ext.jit import leaf
from ..numba_ext.views import row_at
from .entries import column_over


@leaf
def _column_at(n, model, state, counts, base, work, samples):
    """The column of n blocks at these pointers."""
    return column_over(n, row_at(model), row_at(state), row_at(counts), row_at(base), samples, row_at(work))


@leaf
def _samples(n, model, count, times, ax, az, scale):
    return Samples(count, row_at(times), row_at(ax), row_at(az), scale, False)


def assemble(n, given, from_rest, model, state, counts, base, work, scratch, detail):
    """`engine.assemble`."""
    column = _column_at(n, model, state, counts, base, work, _samples(n, model, 0, given, given, given, 1.0))
    return engine.assemble(column, row_at(given), from_rest, row_at(scratch), row_at(detail))


ENTRIES = pointers.entries_of(assemble, _samples, _column_at)
