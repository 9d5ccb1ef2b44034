"""Columns of numbers: the CSV of this project with its header, and plain columns without any."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ...common.errors import InputError
from ...common.text import numbers
from ...common.text_tables import (
    COMMENTS,
    SEPARATORS,
    TextTable,
    check_is_numbers,
    check_no_decimal_commas,
    check_no_header_of_numbers,
    check_times,
    from_zero,
    increases_as_times,
    table_of,
)
from .record import Record, equally_spaced, gap_in
from .units import KNOWN, factor_of

CSV, PLAIN = "CSV", "plain columns"
_SAMPLES = ("base.ax", "base.ay", "base.az")
# their slopes, inputs for communication steps of an FMU; a record has them from its samples
SLOPES = {name: name.replace(".a", ".j") for name in _SAMPLES}
# of a sampling interval: time from the extra row, which holds the slopes of the interval, to the next sample, as
# masters interpolate between rows. Longer than what FMPy treats as the same instant, and than the rounding of times.
LEAD = 1e-5
_BLANKS = str.maketrans(dict.fromkeys(SEPARATORS, " "))


def recognised(lines: list[str]) -> bool:
    """Return True if the first line names an acceleration as the CSV of this project does."""
    return any(name in _SAMPLES for name in _names(table_of(lines[:1])))


def read_csv(lines: list[str]) -> Record:
    """Read `time,base.ax,base.ay,base.az` in s and m/s2; absent columns are zeros.

    `;` or tabs as separators, names in any case and blank lines at the end are accepted. Slopes base.jx to base.jz, as
    `convert` writes them, are ignored with their extra rows. Raises InputError if the table is invalid.
    """
    found = table_of(lines)
    header = _names(found)
    given, slopes = [name for name in header[1:] if name not in SLOPES.values()], set(header) & set(SLOPES.values())
    known = bool(given) and set(given) <= set(_SAMPLES) and len(set(header)) == len(header)
    if header[:1] != ["time"] or not known:
        raise InputError(
            f"line 1: {found.title[:80]!r}: must be 'time,base.ax,base.az' (or without one of base.ax, base.az)"
        )
    blank = next((k for k, line in enumerate(found.lines, start=2) if line != k), 0)
    if blank:
        raise InputError(f"line {blank}: 0 values, must be {len(header)} as in the header")
    table = found.numbers()
    check_times(found.lines, table[:, 0].tolist())
    if len(table) < 2:
        raise InputError(f"{len(table)} rows of samples, must be at least 2")
    kept = np.ones(len(table), dtype=bool)
    if slopes:
        between = np.diff(table[:, 0])
        kept[1:-1] = between[1:] >= 10.0 * LEAD * between[:-1]  # not the rows with another one right behind
    table = table[kept]
    texts = [row[0] for row, is_kept in zip(found.rows, kept, strict=True) if is_kept]
    table[:, 0], shifted = from_zero(texts, table[:, 0])
    columns = dict(zip(header, table.T, strict=True))
    zero = np.zeros(len(table))
    ax, ay, az = (columns.get(name, zero) for name in _SAMPLES)
    said = tuple(filter(None, (shifted, gap_in(columns["time"], ax, ay, az))))
    return Record(CSV, columns["time"], ax, az, ay=ay if np.any(ay) else None, warnings=said)


def read_plain(lines: list[str], dt: float | None, units: str | None, headers: Sequence[str]) -> Record:
    """Read a file of numbers without a header; nothing is guessed.

    Columns are separated by blanks, commas, `;` or tabs; a line that begins with # % ! or // is a comment.

    Parameters
    ----------
    lines : list of str
        The lines of the file.
    dt : float or None
        The sampling interval (s): every number is a sample, row by row. None: the first column is the time in s, the
        second ax and a third, if any, az.
    units : str or None
        The unit of acceleration.
    headers : sequence of str
        The names of the formats with a header, for the message where the units are missing.

    Raises
    ------
    InputError
        If the units are missing or the numbers do not fit `dt`.
    """
    if units is None:
        if any(name.startswith("time") for name in _names(table_of(lines[:1]))):
            raise InputError(
                f"line 1: {lines[0].strip()[:80]!r}: must be 'time,base.ax,base.az' with m/s2; or put # before "
                "this line and give the units (--units) of columns of time, ax and perhaps az"
            )
        raise InputError(
            f"no known header ({', '.join(headers)}): units must be given (--units) to read it as plain columns, "
            f"{KNOWN}"
        )
    factor = factor_of(units)
    stripped = ((k, line.strip()) for k, line in enumerate(lines, start=1))
    texts = [(k, line) for k, line in stripped if line and not line.startswith(COMMENTS)]
    check_no_decimal_commas(texts)
    at, plain = [line for line, _ in texts], [row.translate(_BLANKS) for _, row in texts]
    rows = []
    for (line, row), bare in zip(texts, plain, strict=True):
        check_is_numbers(line, row)
        rows.append(numbers(line, bare))
    # samples at equal steps
    if dt is not None:
        if increases_as_times(rows):
            raise InputError(f"dt: must be left out, the first column increases as times do{_kept(rows)}")
        samples = [a for row in rows for a in row]
        check_no_header_of_numbers(dt, samples)
        return equally_spaced(PLAIN, dt, [factor * a for a in samples])
    # columns of time, ax and perhaps az
    for k in range(len(rows)):
        if len(rows[k]) not in (2, 3) or len(rows[k]) != len(rows[0]):
            other = _kept(rows) if increases_as_times(rows) else ", or dt must be given (--dt)"
            raise InputError(f"line {at[k]}: {len(rows[k])} values, must be time, ax and perhaps az{other}")
    check_times(at, [row[0] for row in rows])
    if len(rows) < 2:
        raise InputError(f"{len(rows)} rows of samples, must be at least 2")
    table = np.array(rows).T
    time, shifted = from_zero([row.split()[0] for row in plain], table[0])
    az = factor * table[2] if len(table) == 3 else np.zeros(len(rows))
    ax = factor * table[1]
    return Record(PLAIN, time, ax, az, warnings=tuple(filter(None, (shifted, gap_in(time, ax, az)))))


def _names(table: TextTable) -> list[str]:
    return [name.lower() for name in table.names]


def _kept(rows: list[list[float]]) -> str:
    """Return the advice on a table of times: which columns to keep."""
    repeated = any(late[0] == early[0] for early, late in pairwise(rows))
    if repeated:
        return "; some are equal: write more digits, or keep the accelerations alone, one a line, and give dt"
    return "" if len(rows[0]) in (2, 3) else "; keep the columns of time and acceleration, and the vertical one if any"
