"""Names over flat buffers for kernels, of one column or of eight.

Everything that is saved, restored or handed to compiled callers is in flat arrays of float64 or int64. A kernel sees
them through

- a *row*: `row[i]` is number i; `row[k:]` the row that begins there, `row[k:end]` where it is known to end;
- a *record* of single numbers: `control.next_step` is read and written, `control.row` is all of it;
- a *table* of fields of n numbers each: `blocks.mass` is a row;
- a *space* of such parts, one after the other, by one size or by several: `state.control.next_step`,
  `state.phase.theta[i]`. `state.row` is all of it, `state.buffer` goes on to the end of the buffer.

All are bare addresses: not reference-counted, without cost. A build of its own checks the bounds of each (bounds.py).
Over eight columns at once (lanes.py) an element is eight neighbouring numbers, and the names give lanes; or, by
`one_lane`, the numbers of one of the columns.

`Record`, `FieldTable`, `Numbers` and `Space` below describe the layout. `over(row, n)` lays the names over a row inside
a kernel, `over_begin(row, n)` over one that ends before the last of them, `see(array, n)` over an array in Python:
equal names in all.
"""

from types import SimpleNamespace
from typing import Any

from .jit import COMPILES, for_kernels

if COMPILES:
    from . import rows
    from .copying import clear, copy
    from .rows import lanes_of, numbers_of, one_lane, packs, packs_of, row_at, row_of
else:
    clear = copy = lanes_of = numbers_of = one_lane = packs = packs_of = row_at = row_of = for_kernels

__all__ = [
    "FieldTable",
    "LayoutPart",
    "Numbers",
    "Record",
    "Space",
    "clear",
    "copy",
    "lanes_of",
    "numbers_of",
    "one_lane",
    "packs",
    "packs_of",
    "row_at",
    "row_of",
]

Sum = tuple[int, ...]  # a linear function of sizes: a factor for each, and a constant


# --- the layout


class LayoutPart:
    """A part of a layout: `per_n` neighbouring elements for each of n, and `beside` more."""

    per_n = 0
    beside = 0
    whole = False  # whether the numbers are integers

    def type(self, kind: Any) -> Any:
        """Return the numba type over elements of a kind: float64, lanes, int64."""
        raise NotImplementedError

    def length(self, count: Sum) -> Sum:
        """Return the length in elements as a sum over the sizes of the enclosing space; count: the n of the part."""
        return (*(self.per_n * factor for factor in count[:-1]), self.per_n * count[-1] + self.beside)

    def reached(self, count: Sum) -> Sum | None:
        """Return the length that kernels may access; None: to the end of the buffer."""
        return self.length(count)

    def size(self, n: int) -> int:
        """Return the length in elements."""
        return self.per_n * n + self.beside

    def see(self, array: Any, n: int) -> Any:
        """Return the names over the beginning of an array, in Python."""
        raise NotImplementedError


class Numbers(LayoutPart):
    """A row without names; without a length it extends to the end of the buffer."""

    def __init__(self, per_n: int = 0, beside: int = 0) -> None:
        self.per_n, self.beside = per_n, beside

    def reached(self, count: Sum) -> Sum | None:
        """Return the length in elements, or None."""
        return self.length(count) if self.per_n or self.beside else None

    def type(self, kind: Any) -> Any:
        """Return the type of a row."""
        return rows.RowType(kind)

    def see(self, array: Any, n: int) -> Any:
        """Return the numbers of the array, without names."""
        return array[: self.size(n)]


class Record(LayoutPart):
    """A record: single numbers with names."""

    def __init__(self, *fields: str) -> None:
        self.fields = fields
        self.places = {name: k for k, name in enumerate(fields)}
        self.beside = len(fields)
        self.over = _over(self)

    def type(self, kind: Any) -> Any:
        """Return the type of a record."""
        return rows.RecordType(kind, self.fields)

    def see(self, array: Any, n: int = 0) -> Any:
        """Return an object with the names as attributes that can be read and written."""
        return _RecordView(self.places, array)


class FieldTable(LayoutPart):
    """A table: fields of n numbers each, then fields of several times n numbers.

    Parameters
    ----------
    *fields : str
        Names of the fields of n numbers.
    whole : bool
        True if the numbers are integers.
    together : dict
        Rows over neighbouring fields: name -> fields in their order.
    reach : dict
        Name -> length in multiples of n, from its first number on, that kernels may access beyond the field.
    **several : int
        Fields of several times n numbers: name -> multiple.
    """

    def __init__(
        self,
        *fields: str,
        whole: bool = False,
        together: dict[str, tuple[str, ...]] | None = None,
        reach: dict[str, int] | None = None,
        **several: int,
    ) -> None:
        self.fields = fields
        self.places = {name: (k, 1) for k, name in enumerate(fields)}  # first place and length, in multiples of n
        # fields of several times n follow
        for name, times in several.items():
            self.places[name] = sum(length for _, length in self.places.values()), times
        self.per_n = sum(length for _, length in self.places.values())
        # rows over neighbouring fields
        for name, parts in (together or {}).items():
            first = fields.index(parts[0])
            assert fields[first : first + len(parts)] == parts, f"{name}: {parts} are not neighbours"
            self.places[name] = first, len(parts)
        self.whole = whole
        self.reach = reach or {}
        self.over = _over(self)
        self.over_begin = _over(self, whole=False)

    def type(self, kind: Any) -> Any:
        """Return the type of a space of rows."""
        kind = rows.INT64 if self.whole else kind
        row, places = rows.RowType(kind), self.places.items()
        parts = ((name, row, (k, 0), (1, 0), (self.reach.get(name, times), 0)) for name, (k, times) in places)
        return rows.SpaceType(kind, ("n",), tuple(parts), (self.per_n, 0))

    def see(self, array: Any, n: int) -> Any:
        """Return an object with the fields as attributes: arrays of n numbers, or of several times n."""
        places = self.places.items()
        return SimpleNamespace(**{name: array[begin * n : (begin + times) * n] for name, (begin, times) in places})


class Space(LayoutPart):
    """A space: parts one after the other, by one size n or by several sizes.

    Parameters
    ----------
    *sizes : str
        Names of the sizes; none: "n".
    **parts : LayoutPart or tuple
        A part, (part, size) or (part, size, more): the n of the part is its size plus `more`.
    """

    def __init__(self, *sizes: str, **parts: LayoutPart | tuple[Any, ...]) -> None:
        self.sizes = sizes or ("n",)
        self.parts: dict[str, LayoutPart] = {}
        self.sums: dict[str, tuple[Sum, Sum]] = {}  # first place of each part, and its n
        end: Sum = (0,) * (len(self.sizes) + 1)
        # first place and n of each part, as sums over the sizes
        for name, given in parts.items():
            part, size, more = (*given, 0)[:3] if isinstance(given, tuple) else (given, self.sizes[0], 0)
            count = (*(int(size == each) for each in self.sizes), more)
            self.parts[name], self.sums[name] = part, (end, count)
            end = tuple(a + b for a, b in zip(end, part.length(count), strict=True))
        self.end, self.per_n, self.beside = end, end[0], end[-1]
        self.over = _over(self)
        self.over_begin = _over(self, whole=False)

    def length(self, count: Sum) -> Sum:
        """Return the length in elements as a sum over the sizes of the enclosing space."""
        return super().length(count) if len(self.sizes) == 1 else self.end

    def size(self, n: Any) -> int:
        """Return the length in elements; n: the sizes, as a tuple if there are several."""
        return _worth(self.end, n)

    def type(self, kind: Any) -> Any:
        """Return the type of a space of the parts' types."""
        sums = self.sums
        parts = ((name, part.type(kind), *sums[name], part.reached(sums[name][1])) for name, part in self.parts.items())
        return rows.SpaceType(kind, self.sizes, tuple(parts), self.end)

    def see(self, array: Any, n: Any) -> Any:
        """Return an object with the parts as attributes."""
        return _Parts(self, array, n)


def _worth(factors: Sum, sizes: Any) -> int:
    sizes = sizes if isinstance(sizes, tuple) else (sizes,)
    return sum(factor * int(size) for factor, size in zip(factors, (*sizes, 1), strict=True))


class _RecordView:
    """An object with names over the first numbers of an array."""

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
    """An object with names over the parts of an array, each made on first use."""

    def __init__(self, space: Space, array: Any, n: Any) -> None:
        self._space, self._array, self._n = space, array, n

    def __getattr__(self, name: str) -> Any:
        if name not in self._space.parts:
            raise AttributeError(name)
        # the part at its place, with its own sizes
        part, (first, count) = self._space.parts[name], self._space.sums[name]
        several = isinstance(part, Space) and len(part.sizes) > 1
        n = self._n if several else _worth(count, self._n)
        self.__dict__[name] = part.see(self._array[_worth(first, self._n) :], n)
        return self.__dict__[name]


def _over(part: LayoutPart, whole: bool = True) -> Any:
    """Return the function of kernels that lays the names of a part over the beginning of a row.

    whole: True if the row holds all of it; else it may end before the last rows.
    """
    return rows.over_part(part, whole) if COMPILES else for_kernels
