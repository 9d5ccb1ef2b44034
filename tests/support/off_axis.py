"""Columns off their axis: one block changed, and the rest by the reference."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from solver import Column
from solver.dynamics.stepper import Stepper
from support.lagrange import Array
from support.sliding import SlidingReference


def changed(column: Column, number: int, tilt: float | None = None, **joint: Any) -> Column:
    """The column with another joint under a block, which is tilted."""
    blocks = list(column.blocks)
    own = blocks[number - 1]
    blocks[number - 1] = replace(own, joint=replace(own.joint, **joint), tilt=tilt)
    return replace(column, blocks=tuple(blocks))


def reference_rest(column: Column) -> tuple[SlidingReference, Array]:
    phase = Stepper(column).state.phase
    return SlidingReference.of(column), np.concatenate([phase.theta, phase.opening, phase.slip])
