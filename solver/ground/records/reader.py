"""The format of a file of recorded accelerations, recognised by its content."""

from __future__ import annotations

import os

from ...common.errors import InputError, reading, shown
from ...common.text import lines_of
from . import columns, cosmos, esm, geonet, knet, others, peer, smc
from .record import Record

_READERS = {
    peer.NAME: peer.read,
    esm.NAME: esm.read,
    knet.NAME: knet.read,
    smc.NAME: smc.read,
    columns.CSV: columns.read_csv,
}
_OF_CHANNELS = {cosmos.NAME: cosmos.read, geonet.NAME: geonet.read}


def read_record(
    path: str | os.PathLike[str], dt: float | None = None, units: str | None = None, channel: int | None = None
) -> Record:
    """Return the record of a file in any of the known formats.

    dt (s) and units (g, m/s2 or cm/s2) are for plain columns, which state neither; channel, from 1, is for files of
    several. They are an error for formats that do not need them.

    Raises InputError that begins with `path`, with the line of the file if there is one.
    """
    with reading(path):
        lines = lines_of(path)
        name = _format(lines)
        if name == columns.PLAIN:
            others.check_is_none(lines, units)
        for key, value, used in (
            ("dt", dt, name == columns.PLAIN),
            ("units", units, name == columns.PLAIN),
            ("channel", channel, name in _OF_CHANNELS),
        ):
            if value is not None and not used:
                raise InputError(f"{key} = {shown(value)}: must be left out, the file is {name} and says all itself")
        if name == columns.PLAIN:
            return columns.read_plain(lines, dt, units)
        if name in _OF_CHANNELS:
            return _OF_CHANNELS[name](lines, channel)
        return _READERS[name](lines)


def format_of(path: str | os.PathLike[str]) -> str:
    """Return the name of the format that a file is recognised as. Raises InputError that begins with `path`."""
    with reading(path):
        return _format(lines_of(path))


def _format(lines: list[str]) -> str:
    if columns.recognised(lines):
        return columns.CSV
    return next(
        (known.NAME for known in (knet, esm, peer, smc, geonet, cosmos) if known.recognised(lines)), columns.PLAIN
    )
