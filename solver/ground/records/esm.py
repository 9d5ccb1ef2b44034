"""ESM ASCII (Engineering Strong Motion database, ORFEUS; also ITACA): lines `KEY: value`, then one sample a line."""

from __future__ import annotations

import re

from ...common.errors import InputError
from ...common.text import number, rows_of_numbers
from .record import Record, equally_spaced
from .units import factor_of

NAME = "ESM ASCII"
_STEP, _COUNT, _UNITS, _TYPE = "SAMPLING_INTERVAL_S", "NDATA", "UNITS", "DATA_TYPE"
_NEEDED = (_STEP, _COUNT, _UNITS, _TYPE)
_PAIR = re.compile(r"\s*([A-Z][A-Z0-9_/^()\-]*)\s*:(.*)")  # a sample does not begin with a letter


def recognised(lines: list[str]) -> bool:
    """Return True if one of the first 100 lines gives the sampling interval under ESM's name."""
    return any(line.lstrip().startswith(f"{_STEP}:") for line in lines[:100])


def read(lines: list[str]) -> Record:
    """Read the record. Raises InputError if a key is missing or a value is wrong."""
    header: dict[str, tuple[int, str]] = {}  # key -> line, value
    first = 0
    for first, text in enumerate(lines):
        pair = _PAIR.match(text)
        if pair is None:
            break
        value = pair[2].strip()
        line, before = header.setdefault(pair[1], (first + 1, value))
        if pair[1] in _NEEDED and value != before:
            raise InputError(f"line {first + 1}: {pair[1]} = {value[:80]!r}: must be {before[:80]!r} as in line {line}")
    for key in _NEEDED:
        if key not in header:
            raise InputError(f"{key}: is missing in the header, which ends before line {first + 1}")
    line, kind = header[_TYPE]
    if kind.upper() != "ACCELERATION":
        raise InputError(f"line {line}: {_TYPE} = {kind[:80]!r}: must be ACCELERATION")
    line, units = header[_UNITS]
    factor = factor_of(units, line)
    line, count = header[_COUNT]
    samples = rows_of_numbers(lines, first)
    if len(samples) != number(line, count):
        raise InputError(f"{len(samples)} samples found, must be {count} as {_COUNT} says in line {line}")
    line, dt = header[_STEP]
    title = (header.get(key, (0, ""))[1] for key in ("EVENT_NAME", "EVENT_ID", "NETWORK", "STATION_CODE", "STREAM"))
    return equally_spaced(NAME, number(line, dt), [factor * a for a in samples], " ".join(title))
