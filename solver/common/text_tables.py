"""Tables in text files of instruments and spreadsheets: one reader for every command."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .errors import InputError, shortened, shown
from .files import with_point
from .text import number

FloatArray = NDArray[np.float64]
SEPARATORS = (";", "\t", ",")
COMMENTS = ("#", "%", "!", "//")
MOST_ROUNDED = 1e-9  # of the shortest step: times with a larger rounding error in float64 are shifted to begin at 0
FEWEST_OF_MANY = 4  # least number of rows to tell columns with times from samples row by row
_EMPTY = re.compile(r"(?:[,;]\s*[,;]|\t *\t)\s*[^\s,;]")  # marks at the end of a row separate nothing
_UNIT = re.compile(r"[(\[]([^)\]]*)[)\]]")
_WORD = re.compile(r"[\s,;]*([^\s,;]*)")
_COMMAS = re.compile(r"[+-]?\d*,\d+(?:[EeDd][+-]?\d+)?(?:,[+-]?\d*,\d+(?:[EeDd][+-]?\d+)?)*", re.ASCII)
_INSIDE = re.compile(r"[-+.,\dEeDd]*\d,\d[-+.,\dEeDd]*", re.ASCII)  # a comma between two digits
_LONE = re.compile(r"[^\s,;]+(?:,[^\s,;]+)*,?")  # numbers that only commas separate
_APART = re.compile(r";|[\d.]\s+[-+.\d]", re.ASCII)  # a separator other than a comma


@dataclass(frozen=True)
class TextTable:
    """The fields below a header, with the line number of each row, from 1."""

    title: str  # the header as written
    names: tuple[str, ...]  # stripped of blanks
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]

    def check_widths(self) -> None:
        """Raise InputError unless every row has as many fields as the header."""
        for line, row in zip(self.lines, self.rows, strict=True):
            if len(row) != len(self.names):
                twice = len(row) == 2 * len(self.names) and "." not in "".join(row)
                hint = "; are these decimal commas? They must be decimal points" if twice else ""
                raise InputError(f"line {line}: {len(row)} values, must be {len(self.names)} as in the header{hint}")

    def numbers(self, columns: Sequence[int] | None = None) -> FloatArray:
        """Return the fields of `columns` (indices; None for all) as numbers, (rows, columns).

        Raises InputError if a field is not a finite number or a row has another number of fields than the header.
        """
        self.check_widths()
        columns = range(len(self.names)) if columns is None else columns
        found = [[number(line, row[k]) for k in columns] for line, row in zip(self.lines, self.rows, strict=True)]
        return np.array(found, dtype=np.float64).reshape(len(found), len(columns))


def unit_in(heading: str) -> str | None:
    """Return the unit in the brackets of a heading, in lower case, or None without brackets."""
    found = _UNIT.search(heading.lower())
    return found and found[1].strip()


def table_of(lines: Sequence[str], names: Sequence[str] = ()) -> TextTable:
    """Split the lines of a file at `;`, tabs or commas, whichever its first line has; blank lines are skipped.

    `names` are the column names of a file without a header. Raises InputError if quotes are left open.
    """
    first = lines[0] if lines else ""
    separator = next((mark for mark in SEPARATORS if mark in first), ",")
    reader = csv.reader(lines, strict=True, delimiter=separator)
    try:
        rows = [(reader.line_num, tuple(row)) for row in reader if any(text.strip() for text in row)]
    except csv.Error as error:
        raise InputError(f"is not CSV: {shortened(error)}") from error
    if not names:
        names, rows = (rows[0][1] if rows else ()), rows[1:]
    return TextTable(
        first.strip(), tuple(name.strip() for name in names), tuple(row for _, row in rows), tuple(k for k, _ in rows)
    )


def check_no_decimal_commas(rows: Iterable[tuple[int, str]]) -> None:
    """Raise InputError if the commas of rows without a header, (line, text), belong to numbers.

    A comma between two digits is a decimal one, or one of thousands, if `;` or blanks without a comma separate numbers
    of the row too, or if rows of a single number have none. Without decimal points anywhere it also is where the row
    has blanks, or where every second number lacks a sign.
    """
    rows = [(line, row.strip(" \t;")) for line, row in rows]
    every = not any("." in row for _, row in rows) and all(_COMMAS.fullmatch(row) or "," not in row for _, row in rows)
    # of lone words all but the last row, which may be truncated, have commas or none has
    alone = all(_LONE.fullmatch(row) for _, row in rows)
    every = every or (alone and any("," not in row for _, row in rows[:-1]))
    for line, row in rows:
        words, apart = re.split(r"[;\s]+", row), _APART.search(row)
        for word in words:
            is_inside = _INSIDE.fullmatch(word)
            decimal = _COMMAS.fullmatch(word) and (is_inside or "." not in row)
            if (is_inside and (every or apart)) or (decimal and (every or (len(words) > 1 and word.count(",") == 1))):
                part = re.match(r"[^,]*,[^,]*", word)
                said = with_point(part[0] if part else word) or f"{shown(word)}: must have no comma within a number"
                raise InputError(f"line {line}: {said}; put a blank after commas that separate numbers")


def increases_as_times(rows: Sequence[Sequence[float]]) -> bool:
    """Return True if the first of several columns never decreases, as times do; the last row may be truncated."""
    widths = {len(row) for row in rows[:-1]}
    if len(rows) < 3 or len(widths) != 1 or widths == {1}:
        return False
    first = [row[0] for row in (rows if len(rows[-1]) in widths else rows[:-1])]
    if len(rows[-1]) in widths and widths <= {2, 3} and all(late > early for early, late in pairwise(first)):
        return True
    steady = all(late >= early for early, late in pairwise(first)) and first[-1] > first[0]
    return steady and len(first) >= FEWEST_OF_MANY


def check_times(lines: Sequence[int], time: Sequence[float]) -> None:
    """Raise InputError, with the number of the line, unless times increase from row to row."""
    for (early, late), line in zip(pairwise(time), lines[1:], strict=True):
        if not late > early:
            raise InputError(f"line {line}: time = {late}: must be later than the row before, {early} s")


def from_zero(texts: Sequence[str], time: FloatArray) -> tuple[FloatArray, str]:
    """Shift times (s) to begin at 0 if their rounding error in float64 is too large, as of seconds since 1970.

    Return them, and a line that reports the shift, or `time` unchanged and "". `texts` are the times as written, whose
    differences are exact.
    """
    if len(time) < 2 or time[0] == 0.0 or not np.spacing(np.max(np.abs(time))) > MOST_ROUNDED * np.min(np.diff(time)):
        return time, ""
    exact = [Decimal(text.strip().upper().replace("D", "E")) for text in texts]
    made = np.array([float(value - exact[0]) for value in exact])
    return made, f"times begin at 0 instead of {texts[0].strip()} s, which leaves too few digits for the steps"


def check_no_header_of_numbers(dt: float, samples: Sequence[float]) -> None:
    """Raise InputError if the first samples look like a header of numbers.

    Such a header holds the count or a factor, and the step `dt` (s).
    """
    if len(samples) < 5:
        return
    first, second = samples[0], samples[1]
    most = 10.0 * max(abs(value) for value in samples[2:5])
    found = ""
    for value, other in ((second, first), (first, second)):
        if np.isclose(value, dt, rtol=1e-9, atol=0.0) and other and (float(other).is_integer() or abs(other) > most):
            found = f"one of the first two numbers, {first:g} and {second:g}, equals dt"
    for k, value in ((1, first), (2, first), (2, second)):
        if value == len(samples) - k > most:
            found = found or f"{value:g} is the number of samples that follow"
    if found:
        raise InputError(f"{found}: these look like a header; must begin with # to be left out, or be removed")


def check_is_numbers(line: int, row: str) -> None:
    """Raise InputError if a row of a file without a header begins with a word, is blank, or lacks a value inside."""
    if _EMPTY.search(row):
        raise InputError(f"line {line}: {shown(row[:80])}: has no number between two separators, must have one")
    word = _WORD.match(row)[1].strip("\"'")  # type: ignore[index]  # matches any row
    if not word:
        raise InputError(f"line {line}: no number, must be numbers, or blank without marks")
    if word[:1].isalpha() and word.lower() not in ("nan", "inf", "infinity"):
        raise InputError(
            f"line {line}: {shown(row[:80])}: must be numbers; put # before a line that is a heading, or remove it"
        )
