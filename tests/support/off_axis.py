"""Columns off their axis: one block changed, and the rest by the reference."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from solver import Column
from solver.models.column.stepper import Stepper
from support.lagrange import Array
from support.probe import phocas
from support.sliding import SlidingReference


def changed(column: Column, number: int, tilt: float | None = None, **joint: Any) -> Column:
    """Return the column with another joint under a block, which is tilted."""
    blocks = list(column.blocks)
    own = blocks[number - 1]
    blocks[number - 1] = replace(own, joint=replace(own.joint, **joint), tilt=tilt)
    return replace(column, blocks=tuple(blocks))


def leaning(eta: float = 1e-3, sign: float = 1.0, **joint: Any) -> Column:
    """Return Phocas off its axis in several ways, all joints in full contact at rest; sign -1: its mirror image."""
    column = changed(phocas(eta), 1, tilt=-0.004 * sign, offset=0.08 * sign, inclination=0.005 * sign, **joint)
    return changed(column, 2, tilt=0.05 * sign, offset=-0.03 * sign, inclination=-0.05 * sign, **joint)


def chipped(eta: float = 1e-3, sign: float = 1.0) -> Column:
    """Return Phocas with a chipped edge."""
    return changed(phocas(eta), 3, section="strips", strips=((1.56,) * 7 + (0.0,))[:: int(sign)])


def crooked(eta: float = 1e-3, sign: float = 1.0, **settings: Any) -> Column:
    """Return Phocas with a bit of everything: it rocks soon."""
    column = changed(phocas(eta, **settings), 1, tilt=-0.01 * sign, offset=0.11 * sign, inclination=0.02 * sign)
    column = changed(column, 2, offset=-0.04 * sign, inclination=-0.006 * sign)
    return changed(column, 3, section="strips", strips=(1.3, 1.5, 1.5, 1.5, 1.2, 0.0)[:: int(sign)])


def reference_rest(column: Column) -> tuple[SlidingReference, Array]:
    phase = Stepper(column).state.phase
    return SlidingReference.of(column), np.concatenate([phase.theta, phase.opening, phase.slip])
