"""The numba types of rows, records and spaces (views.py), and the functions of kernels over them."""

import hashlib
import operator
from collections.abc import Callable
from functools import partial
from typing import Any

from numba import types
from numba.extending import intrinsic, models, register_model

from ..machine.bounds import BOUNDS
from .bounds import (
    ENDLESS,
    BoundedModel,
    Lowered,
    bounded,
    check_element,
    check_lane,
    check_part,
    closed,
    greater,
    lesser,
    opened,
    packed,
    scaled,
)
from .compiling import by_width
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
    """The kind of the elements of one lane: every eighth number of a buffer of lanes."""

    def __init__(self) -> None:
        super().__init__(name="OneLane")


ONE_LANE = OneLaneType()


def distance(kind: Any) -> int:
    """Return the distance, in numbers of the buffer, from one element to the next."""
    return WIDTH if kind in (LANES, ONE_LANE) else 1


def value_of(kind: Any) -> Any:
    """Return the type of an element when read."""
    return types.float64 if kind is ONE_LANE else kind


def _pointee(kind: Any) -> Any:
    return _INT64 if kind is types.int64 else _DOUBLE


def _digest(parts: tuple[Any, ...]) -> str:
    """Return a short hash: the names of types become parts of those of machine code."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:8]


class RowType(types.Type):
    """The type of a row: the address of numbers (float64, int64) or of lanes."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        super().__init__(name=f"Row({kind})")


class SizedType(types.Type):
    """The type of a row with a size: the address of numbers (float64) and their count: `row[i]`, `row.size`."""

    def __init__(self) -> None:
        super().__init__(name="Sized")


class RecordType(types.Type):
    """The type of a record: the address of single numbers with names."""

    def __init__(self, kind: Any, fields: tuple[str, ...]) -> None:
        self.kind = kind
        self.fields = fields
        super().__init__(name=f"Record({kind}: {_digest(fields)})")


Sum = tuple[int, ...]  # a linear function of sizes: a factor for each, and a constant


class SpaceType(types.Type):
    """The type of a space: the address of parts whose lengths follow from sizes, and the sizes.

    `space.row` is all of it, `space.buffer` extends to the end of the buffer; `space.n` is the size n, `space.total`
    the length of the space.

    Attributes
    ----------
    kind : numba type
        The kind of the elements.
    sizes : tuple of str
        Names of the sizes.
    parts : tuple
        For each part: name, type, first place, the n of the part, and length, or None: to the end of the buffer.
    end : tuple of int
        The length, as a factor for each size and a constant.
    names : dict
        The parts by name.
    """

    def __init__(
        self, kind: Any, sizes: tuple[str, ...], parts: tuple[tuple[str, Any, Sum, Sum, Sum | None], ...], end: Sum
    ) -> None:
        # the name contains a digest: numba compares types by their names
        self.kind = kind
        self.sizes = sizes
        self.parts = parts
        self.end = end
        self.names = {name: rest for name, *rest in parts}
        super().__init__(name=f"Space({kind}: {_digest((sizes, parts))})")


class _AddressModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, _pointee(fe_type.kind).as_pointer())


for _type in (RowType, RecordType):
    register_model(_type)(BoundedModel if BOUNDS else _AddressModel)


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


def address_in(builder: Any, kind: Any, start: Any, index: Any) -> Any:
    # lanes are eight numbers apart
    if distance(kind) > 1:
        index = builder.mul(index, ir.Constant(index.type, distance(kind)))
    return builder.gep(start, [index])


def load_element(builder: Any, kind: Any, address: Any) -> Any:
    # lanes are a vector that is aligned as a single number
    if kind is LANES:
        address = builder.bitcast(address, ir.VectorType(_DOUBLE, WIDTH).as_pointer())
    value = builder.load(address)
    value.align = 8
    return value


def store_element(builder: Any, kind: Any, address: Any, value: Any) -> None:
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
        return signature(value_of(row.kind), row, types.intp)


@infer_global(operator.setitem)
class _RowSet(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        row, _, _ = args
        return signature(types.none, row, types.intp, value_of(row.kind)) if isinstance(row, RowType) else None


@lower_builtin(operator.getitem, RowType, types.intp)
def _row_get(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind = sig.args[0].kind
    row = opened(context, builder, sig.args[0], args[0])
    check_element(context, builder, row, args[1])
    return load_element(builder, kind, address_in(builder, kind, row.address, args[1]))


@lower_builtin(operator.getitem, RowType, types.slice2_type)
def _row_part(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Lower `row[k:]`, or `row[k:end]`, whose end only a checked build examines."""
    # address of the first element
    slice_ = context.make_helper(builder, types.slice2_type, args[1])
    begin, end = slice_.start, slice_.stop
    row = opened(context, builder, sig.args[0], args[0])
    address = address_in(builder, sig.args[0].kind, row.address, begin)

    # the end of the slice, or that of the row
    def last(of_row: Any) -> Any:
        return builder.select(builder.icmp_signed("==", end, ENDLESS), of_row, end)

    # bounds
    check_part(context, builder, "end of a part", lambda: last(row.count), row)
    check_part(
        context, builder, "beginning of a part", lambda: begin, row._replace(count=last(row.count)) if BOUNDS else row
    )
    part = bounded(address, lambda: builder.sub(last(row.count), begin), lambda: builder.sub(last(row.room), begin))
    return closed(context, builder, sig.args[0], part)


@lower_builtin(operator.setitem, RowType, types.intp, types.Any)
def _row_set(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind = sig.args[0].kind
    # address of the element
    row = opened(context, builder, sig.args[0], args[0])
    check_element(context, builder, row, args[1])
    store_element(builder, kind, address_in(builder, kind, row.address, args[1]), args[2])
    return context.get_dummy_value()


# --- names


_WHOLE = ("row", "buffer")  # of a record or a space


@infer_getattr
class _RecordNames(AttributeTemplate):  # type: ignore[misc]
    key = RecordType

    def generic_resolve(self, record: Any, name: str) -> Any:
        return value_of(record.kind) if name in record.fields else RowType(record.kind) if name in _WHOLE else None


@lower_getattr_generic(RecordType)
def _record_get(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    # all of the record, alone or with what follows
    if name not in kind.fields:
        return value if name == "row" else _to_the_end(context, builder, RowType(kind.kind), value)
    # a field, by its place
    place = ir.Constant(_INT64, kind.fields.index(name))
    start = opened(context, builder, kind, value).address  # was checked as the names were laid over the row
    return load_element(builder, kind.kind, address_in(builder, kind.kind, start, place))


def _to_the_end(context: Any, builder: Any, kind: RowType, value: Any) -> Any:
    """Return the row that begins with `value` and extends to the end of the buffer."""
    row = opened(context, builder, kind, value)
    return closed(context, builder, kind, bounded(row.address, lambda: row.room))


@lower_setattr_generic(RecordType)
def _record_set(context: Any, builder: Any, sig: Any, args: Any, name: str) -> None:
    kind = sig.args[0]
    # a name stands for a constant offset
    place = ir.Constant(_INT64, kind.fields.index(name))
    value = context.cast(builder, args[1], sig.args[1], value_of(kind.kind))
    start = opened(context, builder, kind, args[0]).address
    store_element(builder, kind.kind, address_in(builder, kind.kind, start, place), value)


@infer_getattr
class _SpaceNames(AttributeTemplate):  # type: ignore[misc]
    key = SpaceType

    def generic_resolve(self, space: Any, name: str) -> Any:
        # a part, all of it, or a size
        if name in space.names:
            return space.names[name][0]
        return RowType(space.kind) if name in _WHOLE else types.intp if name in (*space.sizes, "total") else None


@lower_getattr_generic(SpaceType)
def _space_get(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    space = context.make_helper(builder, kind, value)
    sizes = [getattr(space, size) for size in kind.sizes]
    whole = RowType(kind.kind)
    # the row, the buffer, a size or the total
    if name not in kind.names:
        if name == "buffer":
            return _to_the_end(context, builder, whole, space.row)
        return _summed(builder, kind.end, sizes) if name == "total" else getattr(space, name)
    # address of a part, and its bounds
    part, first, count, length = kind.names[name]
    begin, row = _summed(builder, first, sizes), opened(context, builder, whole, space.row)
    address = address_in(builder, kind.kind, row.address, begin)
    if part.kind is not kind.kind:  # integers among floats
        address = builder.bitcast(address, _pointee(part.kind).as_pointer())

    def room() -> Any:
        return builder.sub(row.room, begin)

    def reached() -> Any:
        if length is None:
            return room()
        left = greater(builder, builder.sub(row.count, begin), _INT64(0))  # where the row ends before the last parts
        return lesser(builder, _summed(builder, length, sizes), left)

    # the part as a row or a space
    found = bounded(address, reached, room)
    made = closed(context, builder, RowType(part.kind), found)
    if not isinstance(part, SpaceType):
        return made
    return _space(context, builder, part, made, sizes if part.sizes == kind.sizes else [_summed(builder, count, sizes)])


def _summed(builder: Any, factors: Sum, sizes: list[Any]) -> Any:
    found = ir.Constant(_INT64, factors[-1])
    # factors that are zero add no instructions
    for factor, size in zip(factors, sizes, strict=False):
        if factor:
            found = builder.add(found, builder.mul(size, ir.Constant(_INT64, factor)))
    return found


def _space(context: Any, builder: Any, kind: SpaceType, row: Any, sizes: list[Any]) -> Any:
    """Return a space over a row."""
    made = context.make_helper(builder, kind)
    made.row = row
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
    """Return the signature and the code of a row of this kind over an array. Raises TypingError."""
    if array.ndim != 1 or array.layout != "C":
        raise TypingError(f"{array}: must be a contiguous array of one dimension")

    def generate(context: Any, builder: Any, _: Any, given: Any) -> Any:
        whole = context.make_array(array)(context, builder, given[0])
        row = bounded(whole.data, lambda: whole.nitems)
        return closed(context, builder, RowType(kind), scaled(builder, row, 1, distance(kind)))

    return RowType(kind)(array), generate


def _taken_as(kind: RowType, row: RowType, change: Callable[..., Lowered]) -> Any:
    """Return the signature and the code of a row as one of another kind; change: its bounds, from (builder, row)."""

    def generate(context: Any, builder: Any, _: Any, given: Any) -> Any:
        return closed(context, builder, kind, change(builder, opened(context, builder, row, given[0])))

    return kind(row), generate


@_intrinsic
def row_of(typing, array):
    """Return the row over a one-dimensional contiguous array."""
    return _first_of(array, array.dtype)


@_intrinsic
def lanes_of(typing, array):
    """Return the row of lanes over a row, or a contiguous array, of float64: eight numbers per element."""
    if isinstance(array, RowType):
        return _taken_as(RowType(LANES), array, lambda builder, row: scaled(builder, row, 1, WIDTH))
    return _first_of(array, LANES)


@_intrinsic
def one_lane(typing, row, k):
    """Return the row of the numbers of lane k in a row of lanes."""
    own = RowType(ONE_LANE)

    def generate(context, builder, _, given):
        lanes = opened(context, builder, row, given[0])
        check_lane(context, builder, given[1], WIDTH)
        return closed(context, builder, own, lanes._replace(address=builder.gep(lanes.address, [given[1]])))

    return own(row, types.intp), generate


@_intrinsic
def row_at(typing, pointer):
    """Return the row that begins at a pointer."""
    row = RowType(pointer.dtype)
    return row(pointer), lambda context, builder, _, given: closed(
        context, builder, row, bounded(given[0], lambda: ENDLESS)
    )


@_intrinsic
def packs_of(typing, row):
    """Return the row with eight neighbouring numbers per element, for elementwise operations; lanes are unchanged."""
    if row.kind is LANES:
        return _taken_as(row, row, lambda builder, lanes: lanes)
    return _taken_as(RowType(LANES), row, lambda builder, numbers: packed(builder, numbers, WIDTH))


@_intrinsic
def numbers_of(typing, row):
    """Return the row with one number per element; lanes become eight neighbouring ones."""
    return _taken_as(RowType(types.float64), row, lambda builder, lanes: scaled(builder, lanes, distance(row.kind), 1))


@by_width
def packs(row, count):
    """Return the number of elements of `packs_of(row)` that hold `count` numbers; the last may extend beyond them."""
    if row.kind is LANES:
        return lambda row, count: count
    return lambda row, count: (count + WIDTH - 1) // WIDTH


def over_part(part: Any, whole: bool) -> Any:
    """Return the function of kernels that lays the names of a part (views.py) over the beginning of a row.

    whole: True if the row holds all of it, else the records at least.
    """

    @_intrinsic
    def names(typing, row, n):
        kind = part.type(row.kind)
        several, is_space = isinstance(n, types.BaseTuple), isinstance(kind, SpaceType)

        def generate(context, builder, signature, arguments):
            # the row and the sizes
            given, sizes = opened(context, builder, row, arguments[0]), arguments[1]
            each = [builder.extract_value(sizes, k) for k in range(len(n))] if several else [sizes]

            def total() -> Any:
                return _summed(builder, kind.end, each) if is_space else _INT64(len(kind.fields))

            def needed(last: tuple[Any, ...]) -> Any:
                _, record, first, *_ = last
                return builder.add(_summed(builder, first, each), _INT64(len(record.fields)))

            # bounds: all of it, or each record
            ends = (
                [total] if whole else [partial(needed, part) for part in kind.parts if isinstance(part[1], RecordType)]
            )
            for end in ends:
                check_part(context, builder, "names over", end, given)
            # the names over the row
            begun = closed(
                context,
                builder,
                row,
                bounded(given.address, lambda: lesser(builder, total(), given.count), lambda: given.room),
            )
            return _space(context, builder, kind, begun, each) if is_space else begun

        return kind(row, n if several else types.intp), generate

    return names
