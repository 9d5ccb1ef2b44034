"""Checks for base motions that are probably unintended."""

from __future__ import annotations

import numpy as np

from ..common.plausible import warn_of
from .motion import STANDARD_GRAVITY, Motion

# g; no record has more: 2.7 horizontally (Tsukidate, 2011), 3.9 vertically (Ichinoseki-West, 2008)
MOST = {"ax": 3.0, "ay": 3.0, "az": 4.0}
UNITS = "accelerations are in m/s2, a record in other units has to say so"


def check_strength(motion: Motion) -> bool:
    """Warn (InputWarning) of a motion that is stronger than any on record; return True if it is."""
    beside = {"ax": motion.amplitude, "ay": motion.amplitude_y, "az": 0.0}
    for name, most in MOST.items():
        largest = (float(np.max(np.abs(getattr(motion, name)))) + abs(beside[name])) / STANDARD_GRAVITY
        if largest > most:
            warn_of([f"motion.{name}: reaches {largest:.4g} g, should be {most:g} g at most; {UNITS}"])
            return True
    return False
