"""The lowered form of rows: bare addresses, or in a checked build (machine/bounds.py) addresses with their bounds.

In a checked build a row is its address, the count of its elements, and its room: the number of elements up to the end
of the buffer. An access beyond the count, or below zero, prints one line that names the kernel, and ends the process.
Without checks only the address is computed.
"""

import sys
from collections.abc import Callable
from typing import Any, NamedTuple

from numba import types
from numba.extending import models

from ..machine.bounds import BOUNDS
from .numba_parts import cgutils, ir

INT64 = ir.IntType(64)
ENDLESS = INT64(2**63 - 1)  # count of a row whose end is not known
_BYTES = ir.IntType(8).as_pointer()
_FAULT = "multiblock_out_of_bounds"
_LINE = b"out of bounds: %s %lld of %lld\n\0"


class Lowered(NamedTuple):
    """A row: its address, and in a checked build its count and room, else None."""

    address: Any
    count: Any = None
    room: Any = None


class BoundedModel(models.StructModel):  # type: ignore[misc]
    """The data model of a row in a checked build."""

    def __init__(self, manager: Any, fe_type: Any) -> None:
        number = types.int64 if fe_type.kind is types.int64 else types.float64
        members = [("address", types.CPointer(number)), ("count", types.int64), ("room", types.int64)]
        super().__init__(manager, fe_type, members)


def opened(context: Any, builder: Any, kind: Any, value: Any) -> Lowered:
    """Return the parts of a row of type `kind`."""
    if not BOUNDS:
        return Lowered(value)
    row = context.make_helper(builder, kind, value)
    return Lowered(row.address, row.count, row.room)


def closed(context: Any, builder: Any, kind: Any, row: Lowered) -> Any:
    """Return the row of type `kind` that consists of these parts."""
    # without checks a row is its address
    if not BOUNDS:
        return row.address
    # with checks it has two counts more
    made = context.make_helper(builder, kind)
    made.address, made.count, made.room = row
    return made._getvalue()


def bounded(address: Any, count: Callable[[], Any], room: Callable[[], Any] | None = None) -> Lowered:
    """Return the row with its bounds, which are computed in a checked build only; room: equal to count if None."""
    if not BOUNDS:
        return Lowered(address)
    elements = count()
    return Lowered(address, elements, elements if room is None else room())


def scaled(builder: Any, row: Lowered, several: int, per: int) -> Lowered:
    """Return the row with its numbers taken as elements of another size: `several` for each `per` of them."""

    def changed(count: Any) -> Any:
        count = builder.mul(count, INT64(several)) if several > 1 else count
        return builder.sdiv(count, INT64(per)) if per > 1 else count

    return bounded(row.address, lambda: changed(row.count), lambda: changed(row.room))


def packed(builder: Any, row: Lowered, width: int) -> Lowered:
    """Return the row with `width` of its numbers per element; the last one may reach beyond it within the buffer."""

    # begun packs, at most those that the buffer holds
    def packs() -> Any:
        begun = builder.sdiv(builder.add(row.count, INT64(width - 1)), INT64(width))
        return lesser(builder, begun, room())

    def room() -> Any:
        return builder.sdiv(row.room, INT64(width))

    return bounded(row.address, packs, room)


def lesser(builder: Any, a: Any, b: Any) -> Any:
    """Return the lesser of two integers."""
    return builder.select(builder.icmp_signed("<", a, b), a, b)


def greater(builder: Any, a: Any, b: Any) -> Any:
    """Return the greater of two integers."""
    return builder.select(builder.icmp_signed(">", a, b), a, b)


def check_element(context: Any, builder: Any, row: Lowered, index: Any) -> None:
    """Emit, in a checked build, the end of the process if a row has no element of this index."""
    if BOUNDS:
        _end_unless(context, builder, builder.icmp_unsigned("<", index, row.count), "element", index, row.count)


def check_part(context: Any, builder: Any, what: str, reached: Callable[[], Any], row: Lowered) -> None:
    """Emit, in a checked build, the end of the process if a part of a row ends beyond it."""
    if BOUNDS:
        end = reached()
        _end_unless(context, builder, builder.icmp_unsigned("<=", end, row.count), what, end, row.count)


def check_lane(context: Any, builder: Any, k: Any, width: int) -> None:
    """Emit, in a checked build, the end of the process if there is no lane k."""
    if BOUNDS:
        _end_unless(context, builder, builder.icmp_unsigned("<", k, INT64(width)), "lane", k, INT64(width))


def _end_unless(context: Any, builder: Any, holds: Any, what: str, reached: Any, count: Any) -> None:
    with cgutils.if_unlikely(builder, builder.not_(holds)):
        # the line names the kernel
        text = context.insert_const_string(builder.module, f"{_kernel(builder)}: {what}")
        builder.call(_fault(builder.module), [text, reached, count])
        builder.unreachable()


def _kernel(builder: Any) -> str:
    """Return the name of the kernel that numba lowers now, with the line; its name in machine code if unknown.

    Numba does not pass on the line that it lowers: it is read from the frame of the lowering method.
    """
    frame = sys._getframe()
    # search the stack for it
    while frame is not None:
        lower = frame.f_locals.get("self") if frame.f_code.co_name == "lower_block" else None
        if lower is not None and hasattr(lower, "loc"):
            name = f"{lower.fndesc.modname}.{lower.fndesc.qualname.replace('.<locals>', '')}"
            return f"{name}, line {lower.loc.line}"
        frame = frame.f_back  # type: ignore[assignment]
    return str(builder.function.name)


def _fault(module: Any) -> Any:
    """Return the function of a module that prints the line and ends the process."""
    # once per module
    if _FAULT in module.globals:
        return module.globals[_FAULT]
    # declare it, shared between modules and kept out of the hot path
    kind = ir.FunctionType(ir.VoidType(), [_BYTES, INT64, INT64])
    function = ir.Function(module, kind, name=_FAULT)
    function.linkage = "linkonce_odr"
    for attribute in ("cold", "noinline", "noreturn", "nounwind"):
        function.attributes.add(attribute)
    # the line as a constant, and what is called
    line = ir.GlobalVariable(module, ir.ArrayType(ir.IntType(8), len(_LINE)), name=f"{_FAULT}.line")
    line.initializer, line.linkage = ir.Constant(line.value_type, bytearray(_LINE)), "internal"
    line.global_constant = True
    number = ir.IntType(32)
    prints = ir.Function(module, ir.FunctionType(number, [number, _BYTES], var_arg=True), name="dprintf")
    aborts = ir.Function(module, ir.FunctionType(ir.VoidType(), []), name="abort")
    # print to stderr and abort
    builder = ir.IRBuilder(function.append_basic_block())
    builder.call(prints, [number(2), builder.bitcast(line, _BYTES), *function.args])
    builder.call(aborts, [])
    builder.unreachable()
    return function
