"""The engine for callers that have pointers instead of arrays: programs without Python link with it.

Everything between the parameters of a column and its outputs is here, so that the caller needs to calculate nothing.
A record is `count` samples of the base acceleration at `times`, s, with straight lines in between; `count` is 0
without one.
"""

from collections.abc import Callable
from typing import Any

from ..formulations.base_motion import Samples
from ..layout.spaces import ROW, SPLIT
from ..machine.kinds import Int, Ints, Real, Reals
from ..numba_ext.jit import leaf
from ..numba_ext.views import row_at
from ..output.watch import Watch
from . import engine, slopes

_row, _split = ROW.over, SPLIT.over


@leaf
def _samples(n, model, count, times, ax, az, scale):
    return Samples(count, row_at(times), row_at(ax), row_at(az), scale, False)


def entries_of(
    column_over: Any = engine.column_over, samples_of: Any = _samples, assembled: Any = engine.assemble
) -> dict[Callable[..., Any], tuple[Any, ...]]:
    """Return entry -> kinds of its arguments; all return a code.

    column_over: a leaf, the column over its rows (engine.py, `column_in`). samples_of: a leaf, what is followed beside
    the base: of the record, and of what lies behind the model. assembled: as `engine.assemble`.
    """

    @leaf
    def column_at(n, model, state, counts, base, work, samples):
        return column_over(n, row_at(model), row_at(state), row_at(counts), row_at(base), samples, row_at(work))

    def assemble(n, given, from_rest, model, state, counts, base, work, scratch, detail):
        """`engine.assemble`."""
        column = column_at(n, model, state, counts, base, work, samples_of(n, model, 0, given, given, given, 1.0))
        return assembled(column, row_at(given), from_rest, row_at(scratch), row_at(detail))

    def follow(n, model, state, counts, base, work, inputs, start, h, count, times, ax, az, scale, row, split):
        """`engine.follow`."""
        samples = samples_of(n, model, count, times, ax, az, scale)
        column = column_at(n, model, state, counts, base, work, samples)
        watch, here, parts = Watch(0, row_at(work), row_at(work), True), _row(row_at(row), n), _split(row_at(split), 0)
        return engine.follow(column, row_at(inputs), start, h, watch, here, parts)

    # fmt: off
    def look(n, model, state, counts, base, work, inputs, new_inputs, upright, elapsed, t, count, times, ax, az, scale,
             row, split):
        # fmt: on
        """`engine.look`."""
        samples = samples_of(n, model, count, times, ax, az, scale)
        column = column_at(n, model, state, counts, base, work, samples)
        here, parts = _row(row_at(row), n), _split(row_at(split), 0)
        return engine.look(column, row_at(inputs), new_inputs, upright, elapsed, t, here, parts)

    # fmt: off
    def rates(n, model, state, counts, base, work, t, count, times, ax, az, scale, row, split, other, other_split):
        # fmt: on
        """`slopes.rates`."""
        samples = samples_of(n, model, count, times, ax, az, scale)
        column = column_at(n, model, state, counts, base, work, samples)
        here, there = _row(row_at(row), n), _row(row_at(other), n)
        return slopes.rates(column, t, here, _split(row_at(split), 0), there, _split(row_at(other_split), 0))

    # fmt: off
    def feedthrough(n, model, state, counts, base, work, inputs, seeds, elapsed, t, count, times, ax, az, scale, row,
                    split, other, other_split):
        # fmt: on
        """`slopes.feedthrough`."""
        samples = samples_of(n, model, count, times, ax, az, scale)
        column = column_at(n, model, state, counts, base, work, samples)
        here, there = _row(row_at(row), n), _row(row_at(other), n)
        parts, other_parts = _split(row_at(split), 0), _split(row_at(other_split), 0)
        return slopes.feedthrough(column, row_at(inputs), row_at(seeds), elapsed, t, here, parts, there, other_parts)

    return {
        assemble: (_whole, _numbers, _whole, _numbers, _numbers, _counters, _numbers, _numbers, _numbers, _numbers),
        follow: (*_arguments, _numbers, _number, _number, *_record, *_outputs),
        look: (*_arguments, _numbers, _whole, _whole, _number, _number, *_record, *_outputs),
        rates: (*_arguments, _number, *_record, *_outputs, *_outputs),
        feedthrough: (*_arguments, _numbers, _numbers, _number, _number, *_record, *_outputs, *_outputs),
    }


_numbers, _counters, _number, _whole = Reals, Ints, Real, Int
_arguments = (_whole, _numbers, _numbers, _counters, _numbers, _numbers)  # n, model, state, counts, base, work
_record = (_whole, _numbers, _numbers, _numbers, _number)  # count, times, ax, az, scale
_outputs = (_numbers, _numbers)  # row, split
ENTRIES = entries_of()
