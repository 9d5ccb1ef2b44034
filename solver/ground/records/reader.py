"""Recognition of the format of a record by its content, and dispatch to its reader."""

from __future__ import annotations

import os
import re

from ...common.errors import InputError, reading, shown
from ...common.text import lines_of
from . import columns, cosmos, esm, geonet, knet, peer, smc
from .record import Record

# modules of formats with a header, in the order in which they are recognized
_FORMATS = {known.NAME: known for known in (knet, esm, peer, smc)}  # of one record: read(lines)
_OF_CHANNELS = {known.NAME: known for known in (geonet, cosmos)}  # of several: read(lines, channel)
NAMES = tuple(sorted((columns.CSV, *_FORMATS, *_OF_CHANNELS)))
HEAD = 12  # lines among which a format that is not supported is recognized
_OTHERS = {
    "USC and Caltech Volume I and II": r"(FILE\s+\d+ OF UNCORRECTED ACCELEROGRAM DATA|CORRECTED ACCELEROGRAM\s+II)",
    "BHRC V1": r"\* VOL1DS FILE",
    "RENADIC V1 and CSMIP V1 before 1999": r"UNCORRECTED ACCELEROGRAM DATA\b",
    "CSMIP V3 (spectra)": r"Response and Fourier amplitude spectra\b",
    "NSMN (Turkey)": r"STRONG GROUND MOTION RECORDS OF TURK",
    "UNAM": r"\s*(INSTITUTO DE INGENIERIA, UNAM|ARCHIVO ESTANDAR DE ACELERACION)",
    "CWB (Taiwan)": r"#Earthquake Information\b",
}


def read_record(
    path: str | os.PathLike[str], dt: float | None = None, units: str | None = None, channel: int | None = None
) -> Record:
    """Read a record in any of the known formats, with the arguments and errors of `Motion.from_file`.

    `dt`, `units` and `channel` are refused for formats that do not need them.
    """
    with reading(path):
        lines = lines_of(path)
        name = _format(lines)
        if name == columns.PLAIN:
            _refuse_others(lines, units)
        # arguments that the format does not need are refused
        for key, value, used in (
            ("dt", dt, name == columns.PLAIN),
            ("units", units, name == columns.PLAIN),
            ("channel", channel, name in _OF_CHANNELS),
        ):
            if value is not None and not used:
                raise InputError(f"{key} = {shown(value)}: must be left out, the file is {name} and says all itself")
        if name == columns.PLAIN:
            return columns.read_plain(lines, dt, units, NAMES)
        if name in _OF_CHANNELS:
            return _OF_CHANNELS[name].read(lines, channel)
        return columns.read_csv(lines) if name == columns.CSV else _FORMATS[name].read(lines)


def _refuse_others(lines: list[str], units: str | None) -> None:
    """Raise InputError for a file in a known but unsupported format.

    With `units`, a file that begins with # is plain columns under comments, and accepted.
    """
    if units is not None and lines[0].startswith("#"):
        return
    for name, pattern in _OTHERS.items():
        if any(re.match(pattern, line) for line in lines[:HEAD]):
            raise InputError(
                f"{name} files are not read: convert with gmprocess (USGS) or by hand to columns of time and "
                "acceleration, and give units (--units)"
            )


def format_of(path: str | os.PathLike[str]) -> str:
    """Return the name of the format of a file. Raises InputError that begins with `path` if it cannot be read."""
    with reading(path):
        return _format(lines_of(path))


def has_channels(path: str | os.PathLike[str]) -> bool:
    """Return True if a file has several channels, so that one must be chosen. Raises InputError as `format_of`."""
    with reading(path):
        lines = lines_of(path)
        name = _format(lines)
        return name in _OF_CHANNELS and _OF_CHANNELS[name].count_channels(lines) > 1


def _format(lines: list[str]) -> str:
    if columns.recognised(lines):
        return columns.CSV
    return next((name for name, known in (_FORMATS | _OF_CHANNELS).items() if known.recognised(lines)), columns.PLAIN)
