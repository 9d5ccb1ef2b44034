"""The content of a file of recorded accelerations, in any format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.errors import POSITIVE, InputError, check_number

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Record:
    """Samples of a file in SI units, with the file's own description."""

    format: str  # format the file was recognised as, e.g. "PEER AT2"
    time: FloatArray  # (m,) s
    ax: FloatArray  # (m,) m/s2; the one component of most formats
    az: FloatArray  # (m,) m/s2; zeros where the file has one component
    title: str = ""  # event, station and direction in the file's own words
    notes: tuple[str, ...] = ()  # changes made to the samples, e.g. a mean subtracted
    ay: FloatArray | None = None  # (m,) m/s2, across ax, where the file has it
    warning: str = ""  # what was changed and may not be meant; `Motion.from_record` says it


def equally_spaced(
    name: str, dt: float, samples: Sequence[float] | FloatArray, title: str = "", notes: tuple[str, ...] = ()
) -> Record:
    """Return the record of samples in m/s2 at k dt, s. Raises InputError unless dt > 0 and two samples exist."""
    dt = check_number("dt", dt, POSITIVE, "a positive time in s")
    if len(samples) < 2:
        raise InputError(f"{len(samples)} samples, must be at least 2")
    ax = np.array(samples, dtype=np.float64)
    time = dt * np.arange(len(ax), dtype=np.float64)
    return Record(name, time, ax, np.zeros(len(ax)), " ".join(title.split()), notes)
