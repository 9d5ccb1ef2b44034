"""Outputs of a model: the observable quantities at an instant, and the extremes of a motion.

Each kind of model has one table of them, in the order of its kernels: `Histories` of its outputs.py. Attributes of
responses, names in files, units, peaks, results of many runs, variables of FMUs and their pages are derived from it.
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

BLOCK, JOINT, TIE, BASE = "block", "joint", "tie", "base"  # owners of an output
BEARING, BOND, CONTACT, PORT = "bearing", "bond", "contact", "port"
DIGITS = 9  # significant digits of histories as text: far more than the accuracy of a run
MOST_DIGITS = 17  # digits with which every float64 is restored to the bit


@dataclass(eq=False)
class Output:
    """A row of a table of outputs: one quantity of every block, joint or tie, or of the base.

    As an attribute of `Histories` it is the history.
    """

    owner: str  # BLOCK, JOINT, TIE, BASE, ...
    unit: str  # "": a pure number
    text: str = ""  # what it is, with {i} for the number of the owner, or {it} for its name
    least: float | None = None  # of the range of values
    most: float | None = None
    by_least: bool = False  # the extreme is the least value, in kernels the largest of 1 - value; else the largest size
    only_peak: bool = False  # there is no history
    whole: bool = False  # of the whole model, as its energy, not of its base: owner BASE, named without it
    parts: tuple[Output, ...] = ()  # components of the base under one name, each an output
    name: str = ""  # in files and FMUs; by default that of the attribute
    key: str = ""  # in frames, and in the keys of studies after peak_ or least_; by default that of the attribute
    field: str = ""  # the name of the attribute, and in `peaks`

    def __set_name__(self, owner: type, name: str) -> None:
        self.field, self.name, self.key = name, self.name or name, self.key or name

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
        """True if it is a single number."""
        return self.owner == BASE and not self.parts

    @property
    def each(self) -> tuple[Output, ...]:
        """The parts, or the output itself if it has none."""
        return self.parts or (self,)

    @property
    def kept(self) -> str:
        """The key of its extreme among the results of many runs."""
        return f"least_{self.key}" if self.by_least else f"peak_{self.key}"

    @property
    def extreme(self) -> str:
        """The name of its extreme in Python."""
        return f"least_{self.field}" if self.by_least else f"peak_{self.field}"

    def name_of(self, label: object) -> str:
        """Return the name of the number with this label, such as block[2].ux or base.Fx."""
        if self.whole:
            return self.name
        return f"base.{self.name}" if self.owner == BASE else f"{self.owner}[{label}].{self.name}"

    def peak_of(self, label: object) -> str:
        """Return the name of its extreme, such as block[2].ux_peak."""
        return f"{self.name_of(label)}_{'least' if self.by_least else 'peak'}"


class Histories:
    """The output rows (rows, numbers) of a model; the outputs that a subclass declares are attributes."""

    outputs: ClassVar[tuple[Output, ...]] = ()
    line_end = "\r\n"  # line terminator of a CSV
    rows: FloatArray  # outputs that have histories, in the order of the table
    model: Any

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if rows := tuple(value for value in vars(cls).values() if isinstance(value, Output)):
            cls.outputs = rows

    @property
    def labels(self) -> dict[str, Sequence[object]]:
        """The labels of blocks, joints and ties, by owner: their numbers, from 1."""
        return {owner: range(1, count + 1) for owner, count in self.model.sizes.items()}

    @property
    def row_names(self) -> list[str]:
        """The names of the numbers of a row, as in a CSV."""
        labels = {**self.labels, BASE: ("",)}
        seen = (output for output in self.outputs if not output.only_peak)
        return [one.name_of(label) for output in seen for one in output.each for label in labels[output.owner]]

    def _write(self, path: str | os.PathLike[str], digits: int, before: Columns, behind: Columns | None = None) -> None:
        """Write the rows as a CSV, between other columns (rows,) by name; those before with at least `DIGITS` digits.

        Raises InputError for invalid `digits`, OSError.
        """
        check_digits("digits", digits)
        behind = behind or {}
        table = np.column_stack([*before.values(), self.rows, *behind.values()])
        # with few digits times would be equal
        formats = [f"%.{max(digits, DIGITS)}g"] * len(before) + [f"%.{digits}g"] * (table.shape[1] - len(before))
        names = (f'"{name}"' if "," in name else name for name in (*before, *self.row_names, *behind))
        with whole_file(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
            file.write(",".join(names) + self.line_end)
            np.savetxt(file, table, fmt=formats, delimiter=",", newline=self.line_end)


def component(field: str, k: int, text: str = "") -> property:
    """Return the property that is component k of an array, the last axis of a field."""
    return property(lambda owner: getattr(owner, field)[..., k], doc=text)


def check_digits(key: str, digits: int) -> int:
    """Return `digits` if it is a number of significant digits from 1 to 17.

    Raises InputError otherwise.
    """
    return check_whole(key, digits, 1, MOST_DIGITS, f"a whole number from 1 to {MOST_DIGITS}")


def places_of(outputs: Sequence[Output], sizes: Mapping[str, int]) -> Mapping[str, slice]:
    """Return the slice of each field in an output row, or in the peaks; `sizes` are those of `Model.sizes`."""
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
    """Convert the peaks that kernels store, 1 - value for outputs `by_least`, to those shown to users; a copy.

    They are in the order of the outputs; `sizes` are those of `Model.sizes`.
    """
    visible, places = peaks.copy(), places_of(outputs, sizes)
    for field in (output.field for output in outputs if output.by_least):
        visible[places[field]] = 1.0 - visible[places[field]]
    return visible


def peaks_by_name(outputs: Sequence[Output], sizes: Mapping[str, int], peaks: FloatArray) -> dict[str, FloatArray]:
    """Return the `visible_peaks` by field."""
    visible = visible_peaks(outputs, sizes, peaks)
    return {field: visible[place] for field, place in places_of(outputs, sizes).items()}


def units_of(outputs: Iterable[Output]) -> dict[str, str]:
    """Return the units of time and of the outputs that have one, by key."""
    return {"time": "s"} | {output.key: output.unit for output in outputs if output.unit}
