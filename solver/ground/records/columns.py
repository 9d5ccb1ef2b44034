"""Columns of numbers: the CSV of this project with its header, and plain columns without any."""

from __future__ import annotations

import csv
from itertools import pairwise

import numpy as np

from ...common.errors import InputError
from .record import Record, equally_spaced
from .text import number, numbers
from .units import KNOWN, factor_of

CSV, PLAIN = "CSV", "plain columns"
SEPARATORS = (";", "\t", ",")
COMMENTS = ("#", "%", "!", "//")
_SAMPLES = ("base.ax", "base.ay", "base.az")
SLOPES = ("base.jx", "base.jz")  # within the steps of a master; a record has them from its samples
# of a sampling interval: how long before a sample stands the row with the slopes up to there, as masters draw straight
# lines between rows. Longer than what FMPy takes for the same instant, and than what times are rounded by.
LEAD = 1e-5


def recognised(lines: list[str]) -> bool:
    """Whether the first line names a column as the CSV of this project does."""
    return any(name in _header(lines)[1] for name in ("time", *_SAMPLES))


def read_csv(lines: list[str]) -> Record:
    """Return the record of `time,base.ax,base.ay,base.az` in s and m/s2; those that are absent are zeros.

    Between `;` or tabs as well, names in any case, blank lines at the end. Slopes base.jx and base.jz, as `convert`
    writes them, are passed over with the rows that are there for their sake. Raises InputError.
    """
    separator, header = _header(lines)
    given, slopes = [name for name in header[1:] if name not in SLOPES], [name for name in header if name in SLOPES]
    known = bool(given) and set(given) <= set(_SAMPLES) and len(set(header)) == len(header)
    if header[:1] != ["time"] or not known:
        raise InputError(
            f"line 1: {lines[0].strip()[:80]!r}: must be 'time,base.ax,base.az' (or without one of base.ax, base.az)"
        )
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    rows: list[list[float]] = []
    for k, texts in enumerate(_table(lines[1:], separator), start=2):
        if len(texts) != len(header):
            raise InputError(f"line {k}: {len(texts)} values, must be {len(header)} as in the header")
        rows.append([number(k, text) for text in texts])
        _check_order(k, rows)
    if len(rows) < 2:
        raise InputError(f"{len(rows)} rows of samples, must be at least 2")
    table = np.array(rows)
    if slopes:
        between = np.diff(table[:, 0])
        leads = between[1:] < 10.0 * LEAD * between[:-1]  # a row from the second on, and another one after it
        table = table[np.concatenate([[True], ~leads, [True]])]
    columns = dict(zip(header, table.T, strict=True))
    zero = np.zeros(len(table))
    ax, ay, az = (columns.get(name, zero) for name in _SAMPLES)
    return Record(CSV, columns["time"], ax, az, ay=ay if np.any(ay) else None)


def read_plain(lines: list[str], dt: float | None, units: str | None) -> Record:
    """Return the record of a file of numbers without a header; nothing is guessed. Raises InputError.

    With dt (s) every number is a sample, row by row; without, the first column is the time in s, the second ax and a
    third, if any, az. Columns are separated by blanks, commas, `;` or tabs; a line that begins with # % ! or // is a
    comment.
    """
    if units is None:
        raise InputError(
            "no known header (PEER AT2, ESM, K-NET, COSMOS, CSV): units must be given (--units) to read it as plain "
            f"columns, {KNOWN}"
        )
    factor = factor_of(units)
    rows: list[list[float]] = []
    at: list[int] = []
    for k, line in enumerate(lines, start=1):
        row = line.strip()
        if not row or row.startswith(COMMENTS):
            continue
        for separator in SEPARATORS:
            row = row.replace(separator, " ")
        rows.append(numbers(k, row))
        at.append(k)
    if dt is not None:
        if _has_times(rows):
            raise InputError("dt: must be left out, the first column increases as times do")
        return equally_spaced(PLAIN, dt, [factor * a for row in rows for a in row])
    for k in range(len(rows)):
        if len(rows[k]) not in (2, 3) or len(rows[k]) != len(rows[0]):
            raise InputError(
                f"line {at[k]}: {len(rows[k])} values, must be time, ax and perhaps az, or dt must be given (--dt)"
            )
        _check_order(at[k], rows[max(k - 1, 0) : k + 1])
    if len(rows) < 2:
        raise InputError(f"{len(rows)} rows of samples, must be at least 2")
    table = np.array(rows).T
    az = factor * table[2] if len(table) == 3 else np.zeros(len(rows))
    return Record(PLAIN, table[0], factor * table[1], az)


def _header(lines: list[str]) -> tuple[str, list[str]]:
    """Return the separator and the names in the first line."""
    separator = next((mark for mark in SEPARATORS if mark in lines[0]), ",")
    names = next(iter(_table(lines[:1], separator)), [])
    return separator, [name.strip().lower() for name in names]


def _table(lines: list[str], separator: str) -> list[list[str]]:
    try:
        return list(csv.reader(lines, strict=True, delimiter=separator))
    except csv.Error as error:
        raise InputError(f"is not CSV: {error}") from error


def _check_order(line: int, rows: list[list[float]]) -> None:
    if len(rows) > 1 and not rows[-1][0] > rows[-2][0]:
        raise InputError(f"line {line}: time = {rows[-1][0]}: must be later than the row before, {rows[-2][0]} s")


def _has_times(rows: list[list[float]]) -> bool:
    """Whether the rows look like a time and one or two accelerations."""
    if len(rows) < 3 or {len(row) for row in rows} not in ({2}, {3}):
        return False
    return all(late[0] > early[0] for early, late in pairwise(rows))
