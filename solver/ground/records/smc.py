"""SMC (United States Geological Survey): 27 header lines, comments, then accelerations in cm/s2 in 8 columns."""

from __future__ import annotations

import re

from ...common.errors import InputError
from ...common.text import rows_of_columns
from .record import Record, equally_spaced

NAME = "USGS SMC"
_FIRST = re.compile(r"[12] (UN)?CORRECTED ACCELEROGRAM\b")
_INTEGERS, _REALS, _COMMENTS = 11, 17, 27  # first lines of each part, from 0
_COUNT_OF_COMMENTS, _COUNT, _RATE = 15, 16, 1  # indices among integers, integers and reals, from 0


def recognised(lines: list[str]) -> bool:
    """Return True if the first line is that of accelerations in SMC."""
    return len(lines) > _COMMENTS and _FIRST.match(lines[0]) is not None


def read(lines: list[str]) -> Record:
    """Read the record. Raises InputError if count or rate is missing, or a value is wrong."""
    integers = rows_of_columns(lines, _INTEGERS, _REALS, 10)
    reals = rows_of_columns(lines, _REALS, _COMMENTS, 15)
    if len(integers) <= _COUNT or len(reals) <= _RATE or not reals[_RATE] > 0.0 or integers[_COUNT_OF_COMMENTS] < 0.0:
        raise InputError("no header of SMC: must have 48 integers in lines 12 to 17, 50 reals in lines 18 to 27")
    if reals[_RATE] >= 1e30:
        raise InputError("line 18: no samples a second, as of unequal times: take the corrected file")
    samples = rows_of_columns(lines, _COMMENTS + int(integers[_COUNT_OF_COMMENTS]), len(lines), 10)
    if len(samples) != integers[_COUNT]:
        raise InputError(f"{len(samples)} samples found, must be {integers[_COUNT]:g} as line 14 says")
    title = f"{lines[3]} {lines[5]}"
    return equally_spaced(NAME, 1.0 / reals[_RATE], [0.01 * a for a in samples], title)
