"""Recognition of the format of a record by its content, and dispatch to its reader."""

from __future__ import annotations

import os

from ...common.errors import InputError, reading, shown
from ...common.text import lines_of
from . import columns, cosmos, esm, geonet, knet, others, peer, smc
from .record import Record

# modules of formats with a header, in the order in which they are recognized
_FORMATS = (knet, esm, peer, smc)  # of one record: read(lines)
_OF_CHANNELS = (geonet, cosmos)  # of several: read(lines, channel)
_READERS = {columns.CSV: columns.read_csv} | {known.NAME: known.read for known in _FORMATS}
_READERS_OF_CHANNELS = {known.NAME: known.read for known in _OF_CHANNELS}
NAMES = tuple(sorted({*_READERS, *_READERS_OF_CHANNELS}))


def read_record(
    path: str | os.PathLike[str], dt: float | None = None, units: str | None = None, channel: int | None = None
) -> Record:
    """Read a record in any of the known formats.

    `dt`, `units` and `channel` are refused for formats that do not need them.

    Parameters
    ----------
    path : path-like
        The file.
    dt : float, optional
        The sampling interval (s) of plain columns, which do not state it.
    units : {"g", "m/s2", "cm/s2"}, optional
        The unit of plain columns, which do not state it.
    channel : int, optional
        The channel, from 1, of a file that holds several.

    Raises
    ------
    InputError
        If the file is invalid: begins with `path`, with the line of the file if there is one.
    """
    with reading(path):
        lines = lines_of(path)
        name = _format(lines)
        if name == columns.PLAIN:
            others.check_is_none(lines, units)
        # arguments that the format does not need are refused
        for key, value, used in (
            ("dt", dt, name == columns.PLAIN),
            ("units", units, name == columns.PLAIN),
            ("channel", channel, name in _READERS_OF_CHANNELS),
        ):
            if value is not None and not used:
                raise InputError(f"{key} = {shown(value)}: must be left out, the file is {name} and says all itself")
        if name == columns.PLAIN:
            return columns.read_plain(lines, dt, units, NAMES)
        if name in _READERS_OF_CHANNELS:
            return _READERS_OF_CHANNELS[name](lines, channel)
        return _READERS[name](lines)


def format_of(path: str | os.PathLike[str]) -> str:
    """Return the name of the format of a file.

    Raises InputError that begins with `path` if it cannot be read.
    """
    with reading(path):
        return _format(lines_of(path))


def _format(lines: list[str]) -> str:
    if columns.recognised(lines):
        return columns.CSV
    return next((known.NAME for known in (*_FORMATS, *_OF_CHANNELS) if known.recognised(lines)), columns.PLAIN)
