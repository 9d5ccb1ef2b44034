"""Outputs of a model: what can be seen of it at an instant, and the extremes of a motion.

Each kind of model has one table of them, in the order of its kernels: `Histories` of its outputs.py. Attributes of
responses, names in files, units, peaks, what many runs can keep, variables of FMUs and their pages follow from it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Self, overload

import numpy as np
from numpy.typing import NDArray

from ..common.errors import check_whole
from ..common.files import whole_file

FloatArray = NDArray[np.float64]
Columns = Mapping[str, FloatArray]

BLOCK, JOINT, TIE, BASE = "block", "joint", "tie", "base"  # what an output is of
BEARING, BOND, CONTACT, PORT = "bearing", "bond", "contact", "port"
DIGITS = 9  # significant ones of histories as text: far more than a run is exact to
MOST_DIGITS = 17  # with which every float64 is read back to the bit


@dataclass(eq=False)
class Output:
    """A row of a table: an output of every block, joint or tie, or of the base. As an attribute it is the history.

    text: what it is, with {i}, the number of the block, joint or tie, or {it}, its name. least, most: range of values.
    Its peak is the largest absolute value, or the least value (by_least), for which kernels store the largest of 1 -
    value. only_peak: it has no history. parts: several numbers of the base under one name, each an output. name: in
    files and FMUs, if it is not that of the attribute.
    """

    owner: str
    unit: str  # "": a pure number
    text: str = ""
    least: float | None = None
    most: float | None = None
    by_least: bool = False
    only_peak: bool = False
    parts: tuple[Output, ...] = ()
    name: str = ""
    field: str = ""  # the attribute, and the name in `peaks`

    def __set_name__(self, owner: type, name: str) -> None:
        self.field, self.name = name, self.name or name

    @overload
    def __get__(self, owner: None, kind: Any = None) -> Self: ...
    @overload
    def __get__(self, owner: Histories, kind: Any = None) -> FloatArray: ...
    def __get__(self, owner: Histories | None, kind: Any = None) -> Self | FloatArray:
        if owner is None:
            return self
        if self.only_peak:
            raise AttributeError(f"{self.field}: has no history, only a peak")
        values = owner.rows[:, places_of(owner.outputs, owner.model.sizes)[self.field]]
        return values[:, 0] if self.is_single else values

    @property
    def is_single(self) -> bool:
        """Whether it is one number."""
        return self.owner == BASE and not self.parts

    @property
    def each(self) -> tuple[Output, ...]:
        """Its parts, or itself."""
        return self.parts or (self,)

    @property
    def kept(self) -> str:
        """Name of its extreme among the results of many runs."""
        return f"least_{self.field}" if self.by_least else f"peak_{self.field}"

    def name_of(self, label: object) -> str:
        """Name of one of its numbers, as block[2].ux or base.Fx."""
        return f"base.{self.name}" if self.owner == BASE else f"{self.owner}[{label}].{self.name}"

    def peak_of(self, label: object) -> str:
        """Name of its extreme, as block[2].ux_peak."""
        return f"{self.name_of(label)}_{'least' if self.by_least else 'peak'}"


class Histories:
    """Output rows (rows, numbers) of a model, by the names of its outputs, which a subclass has in its body."""

    outputs: ClassVar[tuple[Output, ...]] = ()
    line_end = "\r\n"  # of a CSV
    rows: FloatArray  # the outputs that have histories, in the order of the table

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if rows := tuple(value for value in vars(cls).values() if isinstance(value, Output)):
            cls.outputs = rows

    @property
    def model(self) -> Any:
        """The model."""
        raise NotImplementedError

    @property
    def labels(self) -> dict[str, Sequence[object]]:
        """What blocks, joints and ties are called: by their numbers, from 1."""
        return {owner: range(1, count + 1) for owner, count in self.model.sizes.items()}

    @property
    def row_names(self) -> list[str]:
        """Names of the numbers of a row, as in a CSV."""
        labels = {**self.labels, BASE: ("",)}
        seen = (output for output in self.outputs if not output.only_peak)
        return [one.name_of(label) for output in seen for one in output.each for label in labels[output.owner]]

    def _write(self, path: str | os.PathLike[str], digits: int, before: Columns, behind: Columns | None = None) -> None:
        """Write a CSV of the rows, between other columns (rows,) by name. Raises InputError, OSError."""
        check_digits("digits", digits)
        behind = behind or {}
        table = np.column_stack([*before.values(), self.rows, *behind.values()])
        names = (f'"{name}"' if "," in name else name for name in (*before, *self.row_names, *behind))
        with whole_file(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
            file.write(",".join(names) + self.line_end)
            np.savetxt(file, table, fmt=f"%.{digits}g", delimiter=",", newline=self.line_end)


def check_digits(key: str, digits: int) -> int:
    """Return a number of significant digits, 1 to 17. Raises InputError."""
    return check_whole(key, digits, 1, MOST_DIGITS, f"a whole number from 1 to {MOST_DIGITS}")


def places_of(outputs: Sequence[Output], sizes: Mapping[str, int]) -> Mapping[str, slice]:
    """Where each field lies in an output row, or in the peaks, of a model; sizes: as of Model."""
    return _places(tuple(outputs), tuple(sizes.items()))


@lru_cache(maxsize=256)
def _places(outputs: tuple[Output, ...], sizes: tuple[tuple[str, int], ...]) -> Mapping[str, slice]:
    found, first, counts = {}, 0, dict(sizes)
    for output in outputs:
        last = first + (len(output.each) if output.owner == BASE else counts[output.owner])
        found[output.field] = slice(first, last)
        first = last
    return found


def visible_peaks(outputs: Sequence[Output], sizes: Mapping[str, int], peaks: FloatArray) -> FloatArray:
    """Peaks as they are shown, a copy, from what the kernels store of them."""
    visible, places = peaks.copy(), places_of(outputs, sizes)
    for field in (output.field for output in outputs if output.by_least):
        visible[places[field]] = 1.0 - visible[places[field]]
    return visible


def peaks_by_name(outputs: Sequence[Output], sizes: Mapping[str, int], peaks: FloatArray) -> dict[str, FloatArray]:
    """Peaks as they are shown, by field."""
    visible = visible_peaks(outputs, sizes, peaks)
    return {field: visible[place] for field, place in places_of(outputs, sizes).items()}


def units_of(outputs: Iterable[Output]) -> dict[str, str]:
    """Units of the histories and peaks that have one, by field, and of time."""
    return {"time": "s"} | {output.field: output.unit for output in outputs if output.unit}
