"""Titles of figures: the column, the motion and its strength; and the verdict as a sentence."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..common.digits import three_digits
from ..common.errors import InputError
from ..ground.motion import STANDARD_GRAVITY, Motion
from ..models.outputs import BLOCK
from .largest import largest_displacement, length
from .style import INK, VERDICT_COLOURS, Figure, header, plain


def setting_of(column: Any, motion: Motion | None) -> str:
    """Return the column or structure and its base motion, with the peak acceleration along x (and y), as a title."""
    if motion is None:
        return str(column.name)
    under = f"{column.name} under {motion.name}" if motion.name else column.name
    if np.any(motion.az):
        under += " with a vertical component"
    try:
        under += f", PGA {motion.pga / STANDARD_GRAVITY:.3g} g"
        across = motion.peak("ay") / STANDARD_GRAVITY
        return f"{under} along x, {across:.3g} g along y" if across else under
    except InputError:  # a harmonic of more cycles than are searched for its peak
        return under


def drawn_larger(factor: float) -> str:
    """Return the factor on a deformation in words."""
    return "drawn to scale" if factor == 1.0 else f"drawn {three_digits(factor)} times larger"


def verdict_of(response: Any) -> tuple[str, str]:
    """Return the word of a response's verdict, and a sentence; ("", "") where it is not known.

    Parameters
    ----------
    response : object
        Has `overturn_time` (s, NaN while it stands) and `what_fell`; the rest as in a Response, if present.
    """
    word = getattr(response, "verdict", "")
    if math.isfinite(response.overturn_time):
        word = "overturned"
        text = f"Overturned at {response.overturn_time:.2f} s"
        what_fell = getattr(response, "what_fell", "")
        text += f": {plain(what_fell)}" if what_fell else ""
        time = getattr(response, "time", None)
        text += ", after the end of the histories" if time is not None and response.overturn_time > time[-1] else ""
    elif word in ("standing", "undecided"):
        largest, block = largest_displacement(response)
        names = response.labels[BLOCK] if hasattr(response, "labels") else range(1, response.model.n + 1)
        moved = f"largest displacement {length(largest)}, block {plain(str(names[block]))}"
        text = f"Stands: {moved}" if word == "standing" else f"Undecided, {response.reason}; {moved}"
    else:
        return "", ""
    # share of an ensemble
    ensemble = getattr(response, "ensemble", None)
    if ensemble is not None:
        text += f"; {ensemble.overturned} of {ensemble.size} varied runs overturn"
    return word, f"{text}."


def write_header(figure: Figure, title: str, verdict: tuple[str, str]) -> str:
    """Write a title and the sentence of a verdict over a figure, and return the colour of the verdict."""
    word, sentence = verdict
    colour = VERDICT_COLOURS.get(word, INK)
    header(figure, title, sentence, colour)
    return colour
