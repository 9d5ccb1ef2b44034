"""Formats of networks that are not supported: a file in one of them is refused by name."""

from __future__ import annotations

import re

from ...common.errors import InputError

HEAD = 12  # lines among which a format is recognized
_FORMATS = {
    "USC and Caltech Volume I and II": r"(FILE\s+\d+ OF UNCORRECTED ACCELEROGRAM DATA|CORRECTED ACCELEROGRAM\s+II)",
    "BHRC V1": r"\* VOL1DS FILE",
    "RENADIC V1 and CSMIP V1 before 1999": r"UNCORRECTED ACCELEROGRAM DATA\b",
    "CSMIP V3 (spectra)": r"Response and Fourier amplitude spectra\b",
    "NSMN (Turkey)": r"STRONG GROUND MOTION RECORDS OF TURK",
    "UNAM": r"\s*(INSTITUTO DE INGENIERIA, UNAM|ARCHIVO ESTANDAR DE ACELERACION)",
    "CWB (Taiwan)": r"#Earthquake Information\b",
}
_PATTERNS = {name: re.compile(pattern) for name, pattern in _FORMATS.items()}


def check_is_none(lines: list[str], units: str | None) -> None:
    """Raise InputError for a file in a known but unsupported format.

    With `units`, a file that begins with # is plain columns under comments, and accepted.
    """
    if units is not None and lines[0].startswith("#"):
        return
    for name, pattern in _PATTERNS.items():
        if any(pattern.match(line) for line in lines[:HEAD]):
            raise InputError(
                f"{name} files are not read: convert with gmprocess (USGS) or by hand to columns of time and "
                "acceleration, and give units (--units)"
            )
