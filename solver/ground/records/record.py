"""The content of a record, in any format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.errors import POSITIVE, InputError, check_number, check_whole

FloatArray = NDArray[np.float64]
MOST_STEP = 20.0  # longest step over the median one; a longer one is a gap


@dataclass(frozen=True, eq=False)
class Record:
    """The samples of a file in SI units, with the file's own description."""

    format: str  # name of the format, e.g. "PEER AT2"
    time: FloatArray  # (m,) s
    ax: FloatArray  # (m,) m/s2; the only component of most formats
    az: FloatArray  # (m,) m/s2; zeros where the file has one component
    title: str = ""  # event, station and direction as in the file
    notes: tuple[str, ...] = ()  # changes made to the samples, e.g. a mean subtracted
    ay: FloatArray | None = None  # (m,) m/s2, along y, if the file has it
    warnings: tuple[str, ...] = ()  # what may be unintended; `Motion.from_record` issues them


def equally_spaced(
    name: str, dt: float, samples: Sequence[float] | FloatArray, title: str = "", notes: tuple[str, ...] = ()
) -> Record:
    """Return the record of samples (m/s2) at k dt (s).

    Parameters
    ----------
    name : str
        The name of the format.
    dt : float
        The sampling interval (s).
    samples : sequence of float
        The acceleration ax (m/s2).
    title : str
        The description in the file.
    notes : tuple of str
        The changes made to the samples.

    Raises
    ------
    InputError
        Unless dt > 0 and there are at least two samples.
    """
    dt = check_number("dt", dt, POSITIVE, "a positive time in s")
    if len(samples) < 2:
        raise InputError(f"{len(samples)} samples, must be at least 2")
    ax = np.array(samples, dtype=np.float64)
    time = dt * np.arange(len(ax), dtype=np.float64)
    return Record(name, time, ax, np.zeros(len(ax)), " ".join(title.split()), notes)


def gap_in(time: FloatArray, *components: FloatArray) -> str:
    """Return the warning of the longest gap (s) between samples (m/s2) that are not zero, or ""; (m,) each."""
    steps, moving = np.diff(time), np.any(components, axis=0)
    usual = float(np.median(steps))
    k = int(np.argmax(np.where(moving[:-1] | moving[1:], steps, 0.0)))
    if not steps[k] > MOST_STEP * usual:
        return ""
    return (
        f"no samples between {time[k]:.6g} and {time[k + 1]:.6g} s, others are {usual:.3g} s apart: the acceleration "
        "is interpolated, the gap should be filled or the record cut there"
    )


def place_of_channel(channel: int | None, titles: Sequence[str]) -> int:
    """Return the index of a channel, counted from 1, of those of a file; None means the only one. Raises InputError."""
    if channel is None and len(titles) > 1:
        listed = ", ".join(f"{k} {title}".strip() for k, title in enumerate(titles, start=1))
        raise InputError(f"{len(titles)} channels: channel must be given, one of {listed[:200]}")
    return (1 if channel is None else check_whole("channel", channel, 1, len(titles), f"1 to {len(titles)}")) - 1
