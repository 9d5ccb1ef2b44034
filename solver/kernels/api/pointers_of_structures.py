"""A structure in space for callers that have pointers: the entries of pointers.py, the record with ay."""

from ..numba_ext.views import row_at
from ..structure import driven
from . import pointers


def assemble(n, given, from_rest, model, state, counts, base, work, scratch, detail):
    """`driven.assemble`."""
    arrays = row_at(model), row_at(state), row_at(counts), row_at(base), row_at(work)
    return driven.assemble(*arrays, row_at(given), from_rest)


def follow(n, model, state, counts, base, work, inputs, start, h, count, times, ax, ay, az, scale, row, split):
    """`driven.follow`."""
    arrays = row_at(model), row_at(state), row_at(counts), row_at(base), row_at(work)
    record = count, row_at(times), row_at(ax), row_at(ay), row_at(az), scale
    return driven.follow(*arrays, row_at(inputs), start, h, *record, row_at(row))


def look(
    n,
    model,
    state,
    counts,
    base,
    work,
    inputs,
    new_inputs,
    upright,
    elapsed,
    t,
    count,
    times,
    ax,
    ay,
    az,
    scale,
    row,
    split,
):
    """`driven.look`."""
    arrays = row_at(model), row_at(state), row_at(counts), row_at(base), row_at(work)
    record = count, row_at(times), row_at(ax), row_at(ay), row_at(az), scale
    return driven.look(*arrays, row_at(inputs), new_inputs, elapsed, t, *record, row_at(row), row_at(split))


def rates(n, model, state, counts, base, work, t, count, times, ax, ay, az, scale, row, split, other, other_split):
    """`driven.rates`."""
    arrays = row_at(model), row_at(state), row_at(counts), row_at(base), row_at(work)
    record = count, row_at(times), row_at(ax), row_at(ay), row_at(az), scale
    return driven.rates(*arrays, t, *record, row_at(row), row_at(split))


# fmt: off
def feedthrough(n, model, state, counts, base, work, inputs, seeds, elapsed, t, count, times, ax, ay, az, scale, row,
                split, other, other_split):
    # fmt: on
    """`driven.feedthrough`."""
    arrays = row_at(model), row_at(state), row_at(counts), row_at(base), row_at(work)
    return driven.feedthrough(*arrays, row_at(seeds), elapsed, t, row_at(row), row_at(split))


def _with_ay(of_column):
    """Return the kinds of the arguments of a column's entry, with ay between ax and az."""
    names = of_column.__code__.co_varnames[: of_column.__code__.co_argcount]
    kinds = list(pointers.ENTRIES[of_column])
    if "az" in names:
        kinds.insert(names.index("az"), kinds[names.index("az")])
    return tuple(kinds)


_of_column = {function.__name__: function for function in pointers.ENTRIES}
# entry -> kinds of its arguments; all return a code
ENTRIES = {
    function: _with_ay(_of_column[function.__name__]) for function in (assemble, follow, look, rates, feedthrough)
}
