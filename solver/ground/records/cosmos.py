"""COSMOS V1 and V2, and the CSMIP files that they come from: blocks of fixed columns, each under a descriptive line."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ...common.errors import InputError
from ...common.text import number, rows_of_columns, rows_of_numbers
from .record import Record, equally_spaced, place_of_channel
from .units import factor_of

NAME = "COSMOS or CSMIP V1/V2"

_FLAGS = re.IGNORECASE | re.ASCII
_FORMAT = r"Format\s*[=:]\s*\(\s*(?P<each>\d*)[A-Z](?P<width>\d+)[^)]*\)"
_REALS = re.compile(
    rf"\s*(?P<count>\d+)\s+Real-?\s?header values follow on\s+(?P<lines>\d+)\s+lines?.*?{_FORMAT}", _FLAGS
)
_COSMOS = re.compile(
    rf"\s*(?P<count>\d+)\s+(?:raw\s+)?(?P<what>[a-z]+)\.?\s+(?:pts|points)\b.*?units\s*=(?P<units>[^,]*?),?\s*{_FORMAT}",
    _FLAGS,
)
_CSMIP_V1 = re.compile(  # of 1999 to 2019
    rf"\s*(?P<count>\d+)\s+(?P<what>accel)\w* points at\s*(?P<rate>\d*\.?\d+)\s*pts/sec in units of\s+"
    rf"(?P<units>[a-z][\w/*^]*)[ .,]*{_FORMAT}",
    _FLAGS,
)
_CSMIP = re.compile(
    r"\s*(?P<count>\d+)\s+points of (?P<what>accel|veloc|displ)\w* data equally spaced at\s*(?P<dt>\d*\.?\d+)\s*sec"
    r"[.,]?\s*(?:in|\(units:?)\s+(?P<units>[a-z][\w/*^]*)[).,]*\s*(?:\(\s*(?P<each>\d+)[a-z](?P<width>\d+)[^)]*\))?",
    _FLAGS,
)
_END = re.compile(r".*end[- ]of[- ]data", re.IGNORECASE)
_CHANNEL = re.compile(r"\s*(?:Sta\s+)?Chan\w*\s*\d+\s*:\s*(?P<direction>[^(]*)", re.IGNORECASE)
_STEP = 34  # index in the real header, from 1: s between samples


@dataclass(frozen=True)
class _Block:
    """A block of accelerations below its descriptive line."""

    line: int  # of its first row, from 0
    heading: re.Match[str]
    dt: float
    title: str


def recognised(lines: list[str]) -> bool:
    """Return True if any line describes a block of data."""
    return any(_heading(line) for line in lines)


def _heading(line: str) -> re.Match[str] | None:
    """Match the descriptive line of a block of data; None if the line is none."""
    return next((found for pattern in (_COSMOS, _CSMIP, _CSMIP_V1) if (found := pattern.match(line))), None)


def count_channels(lines: list[str]) -> int:
    """Return the number of channels. Raises InputError if their headers are invalid."""
    return len(_accelerations(lines))


def read(lines: list[str], channel: int | None = None) -> Record:
    """Read the accelerations of a channel, counted from 1; None means the only one.

    Raises InputError if the channel is missing or ambiguous, or its data are invalid.
    """
    blocks = _accelerations(lines)
    if not blocks:
        raise InputError("no block of accelerations, must have one (V1 or V2)")
    block = blocks[place_of_channel(channel, [block.title for block in blocks])]
    units = re.sub(r"\(\s*\d+\s*\)", "", block.heading["units"]).strip(" .")
    factor = factor_of(units, block.line, " (counts are raw: take the V1 or V2 file)")
    samples = _samples(lines, block)
    if len(samples) != int(block.heading["count"]):
        raise InputError(f"{len(samples)} samples found, must be {block.heading['count']} as line {block.line} says")
    return equally_spaced(NAME, block.dt, [factor * a for a in samples], block.title)


def _accelerations(lines: list[str]) -> list[_Block]:
    found: list[_Block] = []
    step, title = 0.0, ""
    for k, line in enumerate(lines):
        if channel := _CHANNEL.match(line):
            title = channel["direction"].strip()
        if reals := _REALS.match(line):
            step = _real_header(lines, k + 1, reals)
        # the sampling interval is in the descriptive line or the real header
        heading = _heading(line)
        stated = {} if heading is None else heading.groupdict()
        if "dt" in stated:
            step = number(k + 1, stated["dt"])
        elif "rate" in stated:
            step = 1.0 / max(number(k + 1, stated["rate"]), 1e-12)
        if heading is not None and heading["what"].lower().startswith("acc"):
            if not step > 0.0:
                raise InputError(
                    f"line {k + 1}: no sampling interval: value {_STEP} of the real header must be one in s"
                )
            found.append(_Block(k + 1, heading, step, title))
    return found


def _real_header(lines: list[str], first: int, heading: re.Match[str]) -> float:
    """Return the time between samples in the real header (s); 0 if the header is too short."""
    values = rows_of_columns(lines, first, first + int(heading["lines"]), int(heading["width"]))
    return values[_STEP - 1] if len(values) >= _STEP else 0.0


def _samples(lines: list[str], block: _Block) -> list[float]:
    """Return the numbers of a block, up to the line that ends it or begins the next."""
    ends = (k for k in range(block.line, len(lines)) if _END.match(lines[k]) or _heading(lines[k]))
    end = next(ends, len(lines))
    if block.heading["width"] is None:
        return rows_of_numbers(lines[:end], block.line)
    return rows_of_columns(lines, block.line, end, int(block.heading["width"]))
