"""Text files written by instruments, Fortran programs and spreadsheets."""

from __future__ import annotations

import codecs
import math
import os
import re

from .errors import InputError, shown
from .files import MOST_RECORD, content_of, with_point

_EXPONENT = r"(?:[EeDd][+-]?\d+)?"
_NUMBER = re.compile(rf"[+-]?(?:\d+\.?\d*|\.\d+){_EXPONENT}", re.ASCII)
# columns of Fortran without a gap: separated at the sign of the next number, if each has its decimal point
_WITH_POINT = rf"(?:\d+\.\d*|\.\d+){_EXPONENT}"
_TOUCHING = re.compile(rf"[+-]?{_WITH_POINT}(?:[+-]{_WITH_POINT})+", re.ASCII)
_ONE_OF_THEM = re.compile(rf"[+-]?{_WITH_POINT}", re.ASCII)


def lines_of(path: str | os.PathLike[str], most: int = MOST_RECORD) -> list[str]:
    """Return the lines of a text file of at most `most` bytes, without their ends (LF, CRLF or CR).

    UTF-8 and UTF-16 are recognized by their byte order marks, UTF-8 also without; other files are read as Latin-1, for
    station names in old files.

    Raises InputError if the file is not text, OSError.
    """
    raw = content_of(path, most)
    try:
        if raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            text = raw.decode("utf-16")
        else:
            text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    if "\0" in text:
        raise InputError(
            "is not text: it holds bytes of zero (miniSEED, SAC and zip files are not read: convert or unpack them)"
        )
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def number(line: int, text: str) -> float:
    """Return the finite number in a field on line `line`; Fortran's D is an exponent. Raises InputError."""
    stripped = text.strip(" \t")
    value = math.nan
    if _NUMBER.fullmatch(stripped):
        value = float(stripped.upper().replace("D", "E"))
    if not math.isfinite(value):
        raise InputError(f"line {line}: {with_point(stripped) or f'{shown(text)}: must be a finite number'}")
    return value


def numbers(line: int, row: str) -> list[float]:
    """Return the numbers of a row, separated by blanks or only by signs and decimal points.

    Raises InputError, with the number of the line, if a field is not a finite number.
    """
    words: list[str] = []
    for word in row.split():
        words += _ONE_OF_THEM.findall(word) if _TOUCHING.fullmatch(word) else [word]
    return [number(line, word) for word in words]


def rows_of_numbers(lines: list[str], first: int) -> list[float]:
    """Return the numbers of all lines from index `first` on. Raises InputError if a field is not a finite number."""
    return [value for k, row in enumerate(lines[first:], start=first + 1) for value in numbers(k, row)]


def rows_of_columns(lines: list[str], first: int, last: int, width: int) -> list[float]:
    """Return the numbers of `fixed_columns` in the lines from index `first` up to `last`, which is left out."""
    return [value for k, row in enumerate(lines[first:last], start=first + 1) for value in fixed_columns(k, row, width)]


def fixed_columns(line: int, row: str, width: int) -> list[float]:
    """Return the numbers of a row of columns of `width` characters; columns at its end may be missing.

    Raises InputError if a field is not a finite number.
    """
    row = row.rstrip()
    return [number(line, row[k : k + width]) for k in range(0, len(row), width)]
