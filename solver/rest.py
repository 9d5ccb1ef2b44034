"""The column at rest under its own weight: whether it stands there, and what speaks for a slip of units."""

from __future__ import annotations

import warnings
from functools import lru_cache

import numpy as np

from .column import Column
from .errors import InputError, InputWarning
from .packing import carried_weights, settlements

MOST_SETTLED = 0.1  # of a block's height; the mortar beds and soils under blocks settle by less
MOST_PRESSED = 500e6  # Pa; hardly any stone has that strength
UNITS_OF_STIFFNESS = "stiffness is in N/m3: 1 kgf/cm3 = 9.80665e6 N/m3, 1 MPa/mm = 1e9 N/m3"
UNITS_OF_WEIGHT = "mass is in kg, density in kg/m3, width and depth in m"


def check_rest(column: Column, from_rest: bool = True) -> None:
    """Warn (InputWarning) of each of the column's `doubts`.

    Raises InputError if a run is to start `from_rest` and that rest is not stable.
    """
    if from_rest:
        check_stable(column)
    for doubt in _known_doubts(column):
        warnings.warn(doubt, InputWarning, stacklevel=3)


@lru_cache(maxsize=64)
def _known_doubts(column: Column) -> tuple[str, ...]:
    return tuple(doubts(column))


def check_stable(column: Column) -> None:
    """Raise InputError if the rest under gravity is not stable."""
    if not is_stable(column):
        i = int(np.argmax(settlements(column))) + 1
        raise InputError(
            f"{column.name} cannot stand: its rest under gravity is not stable, the joints are too soft for the weight "
            f"above them (block[{i}].joint.stiffness = {column.blocks[i - 1].joint.stiffness:g} settles by "
            f"{settlements(column)[i - 1]:.3g} m); {UNITS_OF_STIFFNESS}"
        )


def doubts(column: Column) -> list[str]:
    """What can be computed but is probably not meant, a line each, about the worst of the joints; mostly none."""
    lines = []
    settled = settlements(column)
    part = settled / np.array([block.height for block in column.blocks])
    i = int(np.argmax(part))
    if part[i] > MOST_SETTLED:
        lines.append(
            f"block[{i + 1}].joint.stiffness = {column.blocks[i].joint.stiffness:g}: block {i + 1} settles by "
            f"{settled[i]:.3g} m at rest, {part[i]:.2g} of its height; {UNITS_OF_STIFFNESS}"
        )
    area = np.array([block.joint_moments[0] for block in column.blocks])
    pressure = carried_weights(column) / area
    i = int(np.argmax(pressure))
    if pressure[i] > MOST_PRESSED:
        lines.append(
            f"joint {i + 1}: carries {carried_weights(column)[i]:.3g} N on {area[i]:.3g} m2 at rest, "
            f"{1e-6 * pressure[i]:.3g} MPa, which no stone does; {UNITS_OF_WEIGHT}"
        )
    return lines


def is_stable(column: Column) -> bool:
    """Whether the rest under gravity, all joints in full contact, is a minimum of the potential energy.

    Of a column that is off its axis no model can be made otherwise.

    With the openings of theory.md, section 4, its second derivatives with respect to the rotations form a symmetric
    tridiagonal matrix; the openings are stable by themselves. Elimination leaves pivots that are all positive, or not.
    """
    if column.off_axis:  # its rest is looked for, and its stability with it, as the model is made (packing.py)
        return True
    pivot, coupling = np.inf, 0.0
    turned_above = spread_above = weight_above = 0.0
    for block in column.blocks:
        area, _, second_moment = block.joint_moments
        stiffness, own = block.joint.stiffness, column.g * block.mass
        weight = weight_above + own
        turning = stiffness * second_moment
        spread = 0.25 * weight * weight / (stiffness * area)  # the compressed joint is shortened along its mean normal
        falling = weight_above * block.height + own * block.resolved_centroid
        pivot = turning + turned_above + spread + spread_above - falling - coupling * coupling / pivot
        if not pivot > 0.0:
            return False
        coupling, turned_above, spread_above, weight_above = spread - turning, turning, spread, weight
    return True
