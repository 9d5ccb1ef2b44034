"""Names over flat buffers for kernels, of one column or of eight.

Everything that is saved, restored or handed to compiled callers is in flat arrays of float64 or int64. A kernel sees
them through

- a *row*: `row[i]` is number i; `row[k:]` the row that begins there;
- a *record* of single numbers: `control.next_step` is read and written, `control.row` is all of it;
- a *table* of fields of n numbers each: `blocks.mass` is a row;
- a *space* of such parts, one after the other, by one size or by several: `state.control.next_step`,
  `state.phase.theta[i]`.

All are bare addresses: not reference-counted, not bounds-checked, without cost. Over eight columns at once (lanes.py)
an element is eight neighbouring numbers, and the names give lanes; or, by `one_lane`, the numbers of one of the
columns.

`Record`, `Table`, `Numbers` and `Space` below describe the layout. `over(row, n)` lays the names over a row inside a
kernel, `see(array, n)` over an array in Python: equal names in both.
"""

import hashlib
import operator
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from numba import types
from numba.extending import intrinsic, models, register_model

from .jit import by_width, leaf
from .lanes import LANES, WIDTH
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
    """The row of lanes over a whole one-dimensional array of float64, eight numbers an element."""
    return _first_of(array, LANES)


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


# --- the layout


class Part:
    """Neighbouring elements: `per_n` for each of n, and `beside` more."""

    per_n = 0
    beside = 0
    whole = False  # whether the numbers are whole ones

    def type(self, kind: Any) -> Any:
        """The numba type over elements of a kind: float64, lanes, int64."""
        raise NotImplementedError

    def length(self, count: Sum) -> Sum:
        """Length in elements by the sizes of a space around it; count: what the part has as its n."""
        return (*(self.per_n * factor for factor in count[:-1]), self.per_n * count[-1] + self.beside)

    def size(self, n: int) -> int:
        """Length in elements."""
        return self.per_n * n + self.beside

    def see(self, array: Any, n: int) -> Any:
        """The names over the beginning of an array, in Python."""
        raise NotImplementedError


class Numbers(Part):
    """A row without names."""

    def __init__(self, per_n: int = 0, beside: int = 0) -> None:
        self.per_n, self.beside = per_n, beside

    def type(self, kind: Any) -> Any:
        """A row."""
        return RowType(kind)

    def see(self, array: Any, n: int) -> Any:
        """The numbers of the array, without names."""
        return array[: self.size(n)]


class Record(Part):
    """Single numbers with names."""

    def __init__(self, *fields: str) -> None:
        self.fields = fields
        self.places = {name: k for k, name in enumerate(fields)}
        self.beside = len(fields)
        self.over = _over(self)

    def type(self, kind: Any) -> Any:
        """A record."""
        return RecordType(kind, self.fields)

    def see(self, array: Any, n: int = 0) -> Any:
        """The names as attributes that can be read and written."""
        return _Seen(self.places, array)


class Table(Part):
    """Fields of n numbers each; after them fields of several times n numbers: `several`.

    together: names of neighbouring fields as one row: name, fields in their order.
    """

    def __init__(
        self, *fields: str, whole: bool = False, together: dict[str, tuple[str, ...]] | None = None, **several: int
    ) -> None:
        self.fields = fields
        self.places = {name: (k, 1) for k, name in enumerate(fields)}  # first place and length, in multiples of n
        for name, times in several.items():
            self.places[name] = sum(length for _, length in self.places.values()), times
        self.per_n = sum(length for _, length in self.places.values())
        for name, parts in (together or {}).items():
            first = fields.index(parts[0])
            assert fields[first : first + len(parts)] == parts, f"{name}: {parts} are not neighbours"
            self.places[name] = first, len(parts)
        self.whole = whole
        self.over = _over(self)

    def type(self, kind: Any) -> Any:
        """A space of rows."""
        kind = types.int64 if self.whole else kind
        parts = ((name, RowType(kind), (begin, 0), (1, 0)) for name, (begin, _) in self.places.items())
        return SpaceType(kind, ("n",), tuple(parts), (self.per_n, 0))

    def see(self, array: Any, n: int) -> Any:
        """The fields as attributes, arrays of n numbers, or of several times n."""
        places = self.places.items()
        return SimpleNamespace(**{name: array[begin * n : (begin + times) * n] for name, (begin, times) in places})


class Space(Part):
    """Parts one after the other, of n numbers each; of several sizes, each with the size that it has as its n.

    sizes: their names. parts: a part, or (part, size), or (part, size, how many more).
    """

    def __init__(self, *sizes: str, **parts: Part | tuple[Any, ...]) -> None:
        self.sizes = sizes or ("n",)
        self.parts: dict[str, Part] = {}
        self.sums: dict[str, tuple[Sum, Sum]] = {}  # first place of each part, and its n
        end: Sum = (0,) * (len(self.sizes) + 1)
        for name, given in parts.items():
            part, size, more = (*given, 0)[:3] if isinstance(given, tuple) else (given, self.sizes[0], 0)
            count = (*(int(size == each) for each in self.sizes), more)
            self.parts[name], self.sums[name] = part, (end, count)
            end = tuple(a + b for a, b in zip(end, part.length(count), strict=True))
        self.end, self.per_n, self.beside = end, end[0], end[-1]
        self.over = _over(self)

    def length(self, count: Sum) -> Sum:
        """Length in elements by the sizes of a space around it."""
        return super().length(count) if len(self.sizes) == 1 else self.end

    def size(self, n: Any) -> int:
        """Length in elements; n: the sizes, where there are several."""
        return _worth(self.end, n)

    def type(self, kind: Any) -> Any:
        """A space of the parts' types."""
        parts = ((name, part.type(kind), *self.sums[name]) for name, part in self.parts.items())
        return SpaceType(kind, self.sizes, tuple(parts), self.end)

    def see(self, array: Any, n: Any) -> Any:
        """The parts as attributes."""
        return _Parts(self, array, n)


def _worth(factors: Sum, sizes: Any) -> int:
    sizes = sizes if isinstance(sizes, tuple) else (sizes,)
    return sum(factor * int(size) for factor, size in zip(factors, (*sizes, 1), strict=True))


class _Seen:
    """Names over the first numbers of an array."""

    def __init__(self, places: dict[str, int], array: Any) -> None:
        object.__setattr__(self, "_places", places)
        object.__setattr__(self, "_array", array)

    def __getattr__(self, name: str) -> Any:
        try:
            return self._array[self._places[name]]
        except KeyError:
            raise AttributeError(name) from None

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self._places:
            raise AttributeError(name)
        self._array[self._places[name]] = value


class _Parts:
    """Names over the parts of an array, each made on first use."""

    def __init__(self, space: Space, array: Any, n: Any) -> None:
        self._space, self._array, self._n = space, array, n

    def __getattr__(self, name: str) -> Any:
        if name not in self._space.parts:
            raise AttributeError(name)
        part, (first, count) = self._space.parts[name], self._space.sums[name]
        several = isinstance(part, Space) and len(part.sizes) > 1
        n = self._n if several else _worth(count, self._n)
        self.__dict__[name] = part.see(self._array[_worth(first, self._n) :], n)
        return self.__dict__[name]


def _over(part: Part) -> Any:
    """The function of kernels that lays the names of a part over the beginning of a row."""

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
