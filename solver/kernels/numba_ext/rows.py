"""Types of numba for rows, records and spaces (views.py), and the functions of kernels over them."""

import hashlib
import operator
from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import intrinsic, models, register_model

from .compiling import by_width, leaf
from .lane_types import LANES, WIDTH
from .numba_parts import (
    AbstractTemplate,
    AttributeTemplate,
    TypingError,
    infer_getattr,
    infer_global,
    ir,
    lower_builtin,
    lower_getattr_generic,
    lower_setattr_generic,
    signature,
)

INT64 = types.int64
_INT64 = ir.IntType(64)
_DOUBLE = ir.DoubleType()
_intrinsic: Callable[..., Any] = intrinsic  # called with one argument less than it is written with


class OneLaneType(types.Type):
    """Kind of the elements of one lane: every eighth number of a buffer of lanes."""

    def __init__(self) -> None:
        super().__init__(name="OneLane")


ONE_LANE = OneLaneType()


def _numbers(kind: Any) -> int:
    """Distance, in numbers of the buffer, from one element to the next."""
    return WIDTH if kind in (LANES, ONE_LANE) else 1


def _value(kind: Any) -> Any:
    """Type of an element when read."""
    return types.float64 if kind is ONE_LANE else kind


def _pointee(kind: Any) -> Any:
    return _INT64 if kind is types.int64 else _DOUBLE


def _digest(parts: tuple[Any, ...]) -> str:
    """Short hash, since the names of types become parts of those of machine code."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:8]


class RowType(types.Type):
    """Address of numbers (float64, int64) or of lanes."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        super().__init__(name=f"Row({kind})")


class SizedType(types.Type):
    """Address of numbers (float64) and their count: `row[i]`, `row.size`."""

    def __init__(self) -> None:
        super().__init__(name="Sized")


class RecordType(types.Type):
    """Address of single numbers with names."""

    def __init__(self, kind: Any, fields: tuple[str, ...]) -> None:
        self.kind = kind
        self.fields = fields
        super().__init__(name=f"Record({kind}: {_digest(fields)})")


Sum = tuple[int, ...]  # of sizes: a factor for each, and a number beside


class SpaceType(types.Type):
    """Address of parts whose lengths follow from sizes, and the sizes.

    `space.row` is all of it, `space.n` the size n, `space.total` its length. parts: (name, type, first place, what the
    part has as its n); end: the length.
    """

    def __init__(
        self, kind: Any, sizes: tuple[str, ...], parts: tuple[tuple[str, Any, Sum, Sum], ...], end: Sum
    ) -> None:
        self.kind = kind
        self.sizes = sizes
        self.parts = parts
        self.end = end
        self.names = {name: (part, first, count) for name, part, first, count in parts}
        super().__init__(name=f"Space({kind}: {_digest((sizes, parts))})")


@register_model(RowType)
@register_model(RecordType)
class _AddressModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, _pointee(fe_type.kind).as_pointer())


@register_model(SizedType)
class _SizedModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, [("row", RowType(types.float64)), ("size", types.intp)])


@register_model(SpaceType)
class _SpaceModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, fe_type: Any) -> None:
        sizes = [(size, types.intp) for size in fe_type.sizes]
        super().__init__(manager, fe_type, [("row", RowType(fe_type.kind)), *sizes])


# --- elements


def _address(builder: Any, kind: Any, start: Any, index: Any) -> Any:
    if _numbers(kind) > 1:
        index = builder.mul(index, ir.Constant(index.type, _numbers(kind)))
    return builder.gep(start, [index])


def _load(builder: Any, kind: Any, address: Any) -> Any:
    if kind is LANES:
        address = builder.bitcast(address, ir.VectorType(_DOUBLE, WIDTH).as_pointer())
    value = builder.load(address)
    value.align = 8
    return value


def _store(builder: Any, kind: Any, address: Any, value: Any) -> None:
    if kind is LANES:
        address = builder.bitcast(address, ir.VectorType(_DOUBLE, WIDTH).as_pointer())
    builder.store(value, address).align = 8


@infer_global(operator.getitem)
class _RowGet(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        row, index = args
        if not isinstance(row, RowType):
            return None
        if isinstance(index, types.SliceType):
            return signature(row, row, types.slice2_type)
        return signature(_value(row.kind), row, types.intp)


@infer_global(operator.setitem)
class _RowSet(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        row, _, _ = args
        return signature(types.none, row, types.intp, _value(row.kind)) if isinstance(row, RowType) else None


@lower_builtin(operator.getitem, RowType, types.intp)
def _row_get(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind = sig.args[0].kind
    return _load(builder, kind, _address(builder, kind, args[0], args[1]))


@lower_builtin(operator.getitem, RowType, types.slice2_type)
def _row_part(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    begin = context.make_helper(builder, types.slice2_type, args[1]).start
    return _address(builder, sig.args[0].kind, args[0], begin)


@lower_builtin(operator.setitem, RowType, types.intp, types.Any)
def _row_set(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind = sig.args[0].kind
    _store(builder, kind, _address(builder, kind, args[0], args[1]), args[2])
    return context.get_dummy_value()


# --- names


@infer_getattr
class _RecordNames(AttributeTemplate):  # type: ignore[misc]
    key = RecordType

    def generic_resolve(self, record: Any, name: str) -> Any:
        return _value(record.kind) if name in record.fields else RowType(record.kind) if name == "row" else None


@lower_getattr_generic(RecordType)
def _record_get(context: Any, builder: Any, kind: Any, start: Any, name: str) -> Any:
    if name not in kind.fields:
        return start
    place = ir.Constant(_INT64, kind.fields.index(name))
    return _load(builder, kind.kind, _address(builder, kind.kind, start, place))


@lower_setattr_generic(RecordType)
def _record_set(context: Any, builder: Any, sig: Any, args: Any, name: str) -> None:
    kind = sig.args[0]
    place = ir.Constant(_INT64, kind.fields.index(name))
    value = context.cast(builder, args[1], sig.args[1], _value(kind.kind))
    _store(builder, kind.kind, _address(builder, kind.kind, args[0], place), value)


@infer_getattr
class _SpaceNames(AttributeTemplate):  # type: ignore[misc]
    key = SpaceType

    def generic_resolve(self, space: Any, name: str) -> Any:
        if name in space.names:
            return space.names[name][0]
        return RowType(space.kind) if name == "row" else types.intp if name in (*space.sizes, "total") else None


@lower_getattr_generic(SpaceType)
def _space_get(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    space = context.make_helper(builder, kind, value)
    sizes = [getattr(space, size) for size in kind.sizes]
    if name not in kind.names:
        return _summed(builder, kind.end, sizes) if name == "total" else getattr(space, name)
    part, first, count = kind.names[name]
    address = _address(builder, kind.kind, space.row, _summed(builder, first, sizes))
    if part.kind is not kind.kind:  # whole numbers among floats
        address = builder.bitcast(address, _pointee(part.kind).as_pointer())
    if not isinstance(part, SpaceType):
        return address
    return _space(
        context, builder, part, address, sizes if part.sizes == kind.sizes else [_summed(builder, count, sizes)]
    )


def _summed(builder: Any, factors: Sum, sizes: list[Any]) -> Any:
    found = ir.Constant(_INT64, factors[-1])
    for factor, size in zip(factors, sizes, strict=False):
        if factor:
            found = builder.add(found, builder.mul(size, ir.Constant(_INT64, factor)))
    return found


def _space(context: Any, builder: Any, kind: SpaceType, address: Any, sizes: list[Any]) -> Any:
    """A space that begins at an address."""
    made = context.make_helper(builder, kind)
    made.row = address
    for name, size in zip(kind.sizes, sizes, strict=True):
        setattr(made, name, size)
    return made._getvalue()


# --- rows with a size


@infer_getattr
class _SizedNames(AttributeTemplate):  # type: ignore[misc]
    key = SizedType

    def generic_resolve(self, sized: Any, name: str) -> Any:
        return {"row": RowType(types.float64), "size": types.intp}.get(name)


@lower_getattr_generic(SizedType)
def _sized_get(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    return getattr(context.make_helper(builder, kind, value), name)


# --- from buffers to rows


def _first_of(array: Any, kind: Any) -> Any:
    """The address of the first number of an array, as a row of this kind. Raises TypingError."""
    if array.ndim != 1 or array.layout != "C":
        raise TypingError(f"{array}: must be a contiguous array of one dimension")
    return RowType(kind)(
        array
    ), lambda context, builder, _, given: context.make_array(array)(context, builder, given[0]).data


def _unchanged(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """The address as it is, in another type."""
    return arguments[0]


@_intrinsic
def row_of(typing, array):
    """The row over a whole one-dimensional array without gaps."""
    return _first_of(array, array.dtype)


@_intrinsic
def lanes_of(typing, array):
    """Return the row of lanes over a row, or a contiguous array, of float64: eight numbers an element."""
    return (RowType(LANES)(array), _unchanged) if isinstance(array, RowType) else _first_of(array, LANES)


@_intrinsic
def one_lane(typing, row, k):
    """The numbers of lane k in a row of lanes."""
    return RowType(ONE_LANE)(row, types.intp), lambda context, builder, _, given: builder.gep(given[0], [given[1]])


@_intrinsic
def row_at(typing, pointer):
    """The row that begins at a pointer."""
    return RowType(pointer.dtype)(pointer), _unchanged


@_intrinsic
def packs_of(typing, row):
    """The row with eight neighbouring numbers an element, for operations common to all; lanes stay as they are."""
    return RowType(LANES)(row), _unchanged


@_intrinsic
def numbers_of(typing, row):
    """The row with one number an element; lanes become eight neighbouring ones."""
    return RowType(types.float64)(row), _unchanged


@by_width
def packs(row, count):
    """Number of elements of `packs_of(row)` that hold `count` of its numbers; the last may reach beyond them."""
    if row.kind is LANES:
        return lambda row, count: count
    return lambda row, count: (count + WIDTH - 1) // WIDTH


@leaf
def copy(to, row, count):
    """Copy the first `count` elements of a row into another one."""
    for i in range(count):
        to[i] = row[i]


@leaf
def clear(row, count):
    """Make the first `count` elements of a row zero."""
    for i in range(count):
        row[i] = 0.0


def over_part(part: Any) -> Any:
    """Return the function of kernels that lays the names of a part (views.py) over the beginning of a row."""

    @_intrinsic
    def names(typing, row, n):
        kind = part.type(row.kind)
        several = isinstance(n, types.BaseTuple)

        def generate(context, builder, signature, arguments):
            if not isinstance(kind, SpaceType):
                return arguments[0]
            address, sizes = arguments
            each = [builder.extract_value(sizes, k) for k in range(len(n))] if several else [sizes]
            return _space(context, builder, kind, address, each)

        return kind(row, n if several else types.intp), generate

    return names
