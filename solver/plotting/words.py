"""Titles of pictures: the column, the motion and its strength; and the verdict in a sentence."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..common.errors import InputError
from ..ground.motion import STANDARD_GRAVITY, Motion
from ..models.column.model import Column


def setting_of(column: Column, motion: Motion | None) -> str:
    """The column and the motion of its base, with the largest horizontal acceleration."""
    if motion is None:
        return column.name
    under = f"{column.name} under {motion.name}" if motion.name else column.name
    if np.any(motion.az):
        under += " with a vertical component"
    try:
        return f"{under}, PGA {motion.pga / STANDARD_GRAVITY:.3g} g"
    except InputError:  # a harmonic of more cycles than are looked through for its crests
        return under


def verdict_of(response: Any) -> tuple[str, str]:
    """The word of a Response's verdict, and a sentence; ("", "") where it is not known.

    response: has `overturn_time` (s, NaN while it stands) and `overturned_joint`; the rest as in a Response, if there.
    """
    word = getattr(response, "verdict", "")
    if math.isfinite(response.overturn_time):
        word = "overturned"
        text = f"Overturned at {response.overturn_time:.2f} s"
        text += f" over joint {response.overturned_joint}" if response.overturned_joint else ""
        time = getattr(response, "time", None)
        text += ", after the end of the histories" if time is not None and response.overturn_time > time[-1] else ""
    elif word in ("standing", "undecided"):
        block = int(np.argmax(response.peaks["ux"]))
        moved = f"largest displacement {length(float(response.peaks['ux'][block]))}, block {block + 1}"
        text = f"Stands: {moved}" if word == "standing" else f"Undecided, {response.reason}; {moved}"
    else:
        return "", ""
    ensemble = getattr(response, "ensemble", None)
    if ensemble is not None:
        text += f"; {ensemble.overturned} of {ensemble.size} varied runs overturn"
    return word, f"{text}."


def length(metres: float) -> str:
    """A length in the unit in which it is read best."""
    return f"{metres:.3g} m" if abs(metres) >= 1.0 else f"{1e3 * metres:.3g} mm"
