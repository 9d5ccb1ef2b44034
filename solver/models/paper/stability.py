"""The longest stable step of central differences."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...common.errors import InputError
from ...ground.motion import STANDARD_GRAVITY
from ..column.linearization import SHORT, StillColumn, undamped
from ..column.model import Column
from ..column.modes import PART

SLACK = 1e-6  # relative accuracy of the limit


def check_step(column: Column) -> None:
    """Raise InputError for a step that is not stable."""
    step = column.settings.step
    if step > SHORT and step > (most := longest_stable_step(column.with_settings(step=SHORT))) * (1.0 + SLACK):
        raise InputError(f"solver.step = {step}: must be at most {most:.4g} s, where central differences are stable")


@lru_cache(maxsize=64)
def longest_stable_step(column: Column) -> float:
    """Return the stable limit of the step (s), 2 / (omega (sqrt(1 + d^2) + d)), of the column in full contact.

    omega is the angular frequency of the highest mode, and d = eta omega counts because rates are extrapolated
    explicitly: a mode x'' + eta omega^2 x' + omega^2 x = 0, stepped as in kernels/paper/stepping.py, reaches the
    amplification factor -1 where (omega h)^2 / 4 + d omega h = 1. Joints that open only become softer. Without gravity
    they are assumed closed.
    """
    still = StillColumn(undamped(replace(column, g=column.g or STANDARD_GRAVITY)))
    omega = math.sqrt(np.max(np.abs(np.linalg.eigvals(still.stiffness(still.rest, PART)))))
    d = omega * max(block.joint.damping for block in column.blocks)
    return 2.0 / (omega * (math.hypot(1.0, d) + d))
