"""Entries of a column under inputs that a caller sets from call to call: with `assemble`, all that native FMUs call.

They contain everything between the parameters of a column and its outputs, so that the caller calculates nothing. A
record is samples of the base acceleration at `times` (s), multiplied by `scale`, with straight lines in between; there
may be none.
"""

from ...engine.samples import unloaded
from ...layout.spaces import ROW, SPLIT
from ...machine.entry import entry
from ...machine.kinds import Int, Ints, Real, Reals, SizedReals
from ...numba_ext.jit import leaf
from ..output.watch import Watch
from . import engine, slopes

_row, _split = ROW.over, SPLIT.over
of_columns = entry("column_driven", f"{__package__}.entries")  # the module of the group, which imports this one


@leaf
def _driven(n, model, state, counts, base, work, times, ax, az, scale):
    """Return the column over its rows, with a record without loads."""
    samples = unloaded(times.row, times.size, ax, ax, az, scale, 0)
    return engine.column_over(n, model, state, counts, base, samples, work)


@of_columns
def follow(
    n: Int, model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, inputs: Reals, start: Real, h: Real,
    times: SizedReals, ax: Reals, az: Reals, scale: Real, row: Reals, split: Reals,
) -> Int:  # fmt: skip
    """Run `engine.follow`."""
    column = _driven(n, model, state, counts, base, work, times, ax, az, scale)
    return engine.follow(column, inputs, start, h, Watch(0, work, work, 1), _row(row, n), _split(split, 0))


@of_columns
def look(
    n: Int, model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, inputs: Reals, new_inputs: Int,
    upright: Int, elapsed: Real, t: Real, times: SizedReals, ax: Reals, az: Reals, scale: Real, row: Reals,
    split: Reals,
) -> Int:  # fmt: skip
    """Run `engine.look`."""
    column = _driven(n, model, state, counts, base, work, times, ax, az, scale)
    return engine.look(column, inputs, new_inputs, upright, elapsed, t, _row(row, n), _split(split, 0))


@of_columns
def rates(
    n: Int, model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, t: Real, times: SizedReals,
    ax: Reals, az: Reals, scale: Real, row: Reals, split: Reals, other: Reals, other_split: Reals,
) -> Int:  # fmt: skip
    """Run `slopes.rates`."""
    column = _driven(n, model, state, counts, base, work, times, ax, az, scale)
    here, there = _row(row, n), _row(other, n)
    return slopes.rates(column, t, here, _split(split, 0), there, _split(other_split, 0))


@of_columns
def feedthrough(
    n: Int, model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, inputs: Reals, seeds: Reals,
    elapsed: Real, t: Real, times: SizedReals, ax: Reals, az: Reals, scale: Real, row: Reals, split: Reals,
    other: Reals, other_split: Reals,
) -> Int:  # fmt: skip
    """Run `slopes.feedthrough`."""
    column = _driven(n, model, state, counts, base, work, times, ax, az, scale)
    here, there = _row(row, n), _row(other, n)
    parts, other_parts = _split(split, 0), _split(other_split, 0)
    return slopes.feedthrough(column, inputs, seeds, elapsed, t, here, parts, there, other_parts)
