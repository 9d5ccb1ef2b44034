"""GeoNet V1A and V2A (New Zealand): channels of 26 header lines and numbers in mm/s2, in columns of 8."""

from __future__ import annotations

import re

from ...common.errors import InputError
from ...common.text import fixed_columns
from .record import Record, equally_spaced, place_of_channel

NAME = "GeoNet V1A/V2A"
_FIRST = re.compile(r"(Unc|C)orrected accelerogram\b.*\bGNS\b")
_HEADER = 26  # lines of a channel
_COMPONENT, _INTEGERS, _REALS = 12, 19, 22  # lines, from 0: direction, counts, duration and steps
_COUNT, _STEP = 3, 5  # indices in these lines, from 0: accelerations (then velocities, displacements), s


def recognised(lines: list[str]) -> bool:
    """Return True if the first line is that of a channel."""
    return _FIRST.match(lines[0]) is not None


def count_channels(lines: list[str]) -> int:
    """Return the number of channels."""
    return sum(_FIRST.match(line) is not None for line in lines)


def read(lines: list[str], channel: int | None = None) -> Record:
    """Read the accelerations of a channel, counted from 1; None means the only one.

    Raises InputError if the channel is missing or ambiguous, or its data are invalid.
    """
    # the channel
    first = [k for k, line in enumerate(lines) if _FIRST.match(line)]
    k = first[place_of_channel(channel, [_direction(lines, k) for k in first])]
    # its header
    is_whole = len(lines) >= k + _HEADER
    counts, steps = (fixed_columns(at + 1, lines[at], 8) if is_whole else [] for at in (k + _INTEGERS, k + _REALS))
    if len(counts) <= _COUNT or len(steps) <= _STEP:
        raise InputError(f"line {k + 1}: a channel without its {_HEADER} lines of header")
    # its samples
    count, at = int(counts[_COUNT]), k + _HEADER
    samples: list[float] = []
    while len(samples) < count and at < len(lines):
        samples += fixed_columns(at + 1, lines[at], 8)
        at += 1
    if len(samples) != count:
        raise InputError(f"{len(samples)} samples found, must be {count} as line {k + _INTEGERS + 1} says")
    title = f"{lines[k + 1][:12]} {_direction(lines, k)}"
    return equally_spaced(NAME, steps[_STEP], [1e-3 * a for a in samples], title)


def _direction(lines: list[str], first: int) -> str:
    words = (lines[first + _COMPONENT : first + _COMPONENT + 1] or [""])[0].split()
    return words[1] if len(words) > 1 else ""
