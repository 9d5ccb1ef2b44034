"""PEER AT2: four header lines, then samples in g."""

from __future__ import annotations

import re

from ...common.errors import InputError
from ...common.text import number, rows_of_numbers
from .record import Record, equally_spaced
from .units import STANDARD_GRAVITY

NAME = "PEER AT2"

# the two forms of the fourth line
_FLAGS = re.IGNORECASE | re.ASCII
_SIZE = (
    re.compile(r"\s*NPTS\s*=\s*(?P<count>\d+)\s*,\s*DT\s*=\s*(?P<dt>[\d.+\-E]+)(?=\s*,?\s*(SEC.*)?$)(?!.*DT)", _FLAGS),
    re.compile(r"\s*(?P<count>\d+)[\s,]+(?P<dt>[\d.+\-E]+)[\s,]+NPTS\s*,\s*DT", _FLAGS),
)
_UNITS = re.compile(r"\bunits\s+(of|are)\s+(g|\(g\))(?![\w/*])", re.IGNORECASE)

_OTHER = re.compile(r"\b(veloc|displ)", re.IGNORECASE)  # quantities


def recognised(lines: list[str]) -> bool:
    """Return True if the fourth line has NPTS and DT, as in AT2."""
    return len(lines) > 3 and re.search(r"\bNPTS\b.*\bDT\b", lines[3], _FLAGS) is not None


def read(lines: list[str]) -> Record:
    """Read the record. Raises InputError on another quantity, wrong units, number of samples, step or value."""
    if len(lines) < 4:
        count = len(lines) - (lines[-1] == "")
        raise InputError(f"{count} lines, must be 4 header lines and the samples")
    if _OTHER.search(lines[2]):
        raise InputError(f"line 3: {lines[2].strip()[:80]!r}: must be accelerations")
    if not _UNITS.search(lines[2]):
        raise InputError(f"line 3: {lines[2].strip()[:80]!r}: must say that the units are g, e.g. 'IN UNITS OF G'")
    size = _SIZE[0].match(lines[3]) or _SIZE[1].match(lines[3])
    if size is None:
        raise InputError(
            f"line 4: {lines[3].strip()[:80]!r}: must be like 'NPTS= 1559, DT= .02000 SEC' or '1559 .02 NPTS, DT'"
        )
    samples = rows_of_numbers(lines, 4)
    if len(samples) != int(size["count"]):
        raise InputError(f"{len(samples)} samples found, must be {size['count']} as NPTS says in line 4")
    return equally_spaced(NAME, number(4, size["dt"]), [STANDARD_GRAVITY * a for a in samples], lines[1])
