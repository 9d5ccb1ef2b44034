"""Copying and clearing of rows; in a checked build (bounds.py) inlined into the kernel, which an error then names."""

from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import intrinsic

from ..machine.bounds import BOUNDS
from .bounds import check_part, opened
from .compiling import leaf
from .numba_parts import cgutils, ir
from .rows import address_in, load_element, store_element, value_of

_intrinsic: Callable[..., Any] = intrinsic  # called with one argument less than it is written with


@leaf
def copy(to, row, count):
    """Copy the first `count` elements of `row` into `to`."""
    for i in range(count):
        to[i] = row[i]


@leaf
def clear(row, count):
    """Set the first `count` elements of a row to zero."""
    for i in range(count):
        row[i] = 0.0


def _fill(context: Any, builder: Any, to: Any, row: Any, count: Any, element: Callable[[Any], Any]) -> Any:
    """Emit code that stores `element(index)` in the first `count` elements of a row of type `to`."""
    lowered = opened(context, builder, to, row)
    # bounds
    with builder.if_then(builder.icmp_signed(">", count, ir.Constant(count.type, 0))):
        check_part(context, builder, "copy to", lambda: count, lowered)
    # loop over the elements
    with cgutils.for_range(builder, count) as loop:
        place = address_in(builder, to.kind, lowered.address, loop.index)
        store_element(builder, to.kind, place, element(loop.index))
    return context.get_dummy_value()


@_intrinsic
def _checked_copy(typing, to, row, count):
    def generate(context, builder, signature, arguments):
        source, number = opened(context, builder, row, arguments[1]), arguments[2]
        # bounds of the source
        with builder.if_then(builder.icmp_signed(">", number, ir.Constant(number.type, 0))):
            check_part(context, builder, "copy of", lambda: number, source)

        def element(index):
            found = load_element(builder, row.kind, address_in(builder, row.kind, source.address, index))
            return context.cast(builder, found, value_of(row.kind), value_of(to.kind))

        return _fill(context, builder, to, arguments[0], number, element)

    return types.none(to, row, types.intp), generate


@_intrinsic
def _checked_clear(typing, row, count):
    def generate(context, builder, signature, arguments):
        # zero of the type of the elements
        zero = context.cast(builder, ir.Constant(ir.DoubleType(), 0.0), types.float64, value_of(row.kind))
        return _fill(context, builder, row, arguments[0], arguments[1], lambda index: zero)

    return types.none(row, types.intp), generate


if BOUNDS:
    copy, clear = _checked_copy, _checked_clear
