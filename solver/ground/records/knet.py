"""K-NET and KiK-net ASCII (NIED): 17 header lines, then counts of the recorder in 8 columns."""

from __future__ import annotations

import re

import numpy as np

from ...common.errors import InputError
from ...common.text import number, rows_of_numbers
from .record import Record, equally_spaced
from .units import factor_of

NAME = "K-NET ASCII"
_HEADER = 17  # lines
_FREQUENCY, _DURATION, _SCALE = 10, 11, 13  # lines, from 0
_WHOLE = 1e-6  # samples, by which the product of frequency and duration may differ from a whole number
_TITLE = (("Origin Time", 0), ("Station Code", 5), ("Dir.", 12))
_VALUE = {
    _FREQUENCY: re.compile(r"Sampling Freq\S*\s+([\d.]+)\s*Hz\s*$", re.IGNORECASE),
    _DURATION: re.compile(r"Duration Time\S*\s+([\d.]+)\s*$", re.IGNORECASE),
    _SCALE: re.compile(r"Scale Factor\s+([\d.]+)\s*\((\w+)\)\s*/\s*([\d.]+)\s*$", re.IGNORECASE),
}
_EXAMPLE = {
    _FREQUENCY: "Sampling Freq(Hz) 100Hz",
    _DURATION: "Duration Time(s) 120",
    _SCALE: "Scale Factor 3920(gal)/6182761",
}


def recognised(lines: list[str]) -> bool:
    """Return True if the first line and the scale factor are those of NIED's header."""
    return lines[0].startswith("Origin Time") and any(line.startswith("Scale Factor") for line in lines[:_HEADER])


def read(lines: list[str]) -> Record:
    """Read the record and subtract its mean: the recorder's zero is not that of the ground.

    NIED computes the largest acceleration of its header in the same way. Raises InputError if the header or a value is
    wrong.
    """
    if not lines[_HEADER - 1 : _HEADER] or not lines[_HEADER - 1].startswith("Memo"):
        raise InputError(f"line {_HEADER}: must begin with 'Memo', the last of {_HEADER} header lines")
    # the header
    (frequency,), (duration,) = _values(lines, _FREQUENCY), _values(lines, _DURATION)
    full, unit, counts = _values(lines, _SCALE)
    per_second = _positive(lines, _FREQUENCY, frequency)
    factor = _positive(lines, _SCALE, full) / _positive(lines, _SCALE, counts)
    factor *= factor_of(unit, _SCALE + 1)
    # the samples
    samples = np.array(rows_of_numbers(lines, _HEADER))
    wanted = per_second * _positive(lines, _DURATION, duration)
    if abs(len(samples) - wanted) > _WHOLE:
        raise InputError(
            f"{len(samples)} samples found, must be {wanted:.10g} as lines {_FREQUENCY + 1} and {_DURATION + 1} say"
        )
    # the zero of the recorder
    mean = float(np.mean(samples))
    note = f"mean of {mean:g} counts ({factor * mean:.4g} m/s2) taken away"
    title = " ".join(lines[k].removeprefix(key) for key, k in _TITLE)
    return equally_spaced(NAME, 1.0 / per_second, factor * (samples - mean), title, (note,))


def _values(lines: list[str], k: int) -> tuple[str, ...]:
    """Return the values of header line k, from 0."""
    found = _VALUE[k].match(lines[k])
    if found is None:
        raise _unlike(lines, k)
    return found.groups()


def _positive(lines: list[str], k: int, text: str) -> float:
    value = number(k + 1, text)
    if not value > 0.0:
        raise _unlike(lines, k)
    return value


def _unlike(lines: list[str], k: int) -> InputError:
    return InputError(f"line {k + 1}: {lines[k].strip()[:80]!r}: must be like {_EXAMPLE[k]!r}")
