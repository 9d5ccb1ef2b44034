"""The column at rest under its own weight: whether it is stable there, and signs of mistaken units."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from ..common.errors import InputError, InputWarning
from .column import Column
from .packing import FloatArray, carried_weights, settlements

MOST_SETTLED = 0.1  # of a block's height; the mortar beds and soils under blocks settle by less
MOST_PRESSED = 500e6  # Pa; more than the strength of nearly any stone
DENSITIES = (500.0, 12000.0)  # kg/m3, from wood to lead
MOST_DAMPED = 0.2  # of critical, in the first mode; dry joints have some percent
MOST_FRICTION = 1.5  # rough stone on stone has some 0.8
GRAVITIES = (9.7, 9.9)  # m/s2, on Earth; zero is taken as intended
HIGHEST = 30.0  # m, of one block
ITERATIONS = 4  # to the first mode, from a rigid rotation of the column
UNITS_OF_STIFFNESS = "stiffness is in N/m3: 1 kgf/cm3 = 9.80665e6 N/m3, 1 MPa/mm = 1e9 N/m3"
UNITS_OF_WEIGHT = "mass is in kg, density in kg/m3, width and depth in m"


def check_rest(column: Column, from_rest: bool = True) -> None:
    """Warn (InputWarning) with each line of `warnings_of`.

    Raises InputError if a run starts `from_rest` and that rest is not stable.
    """
    if from_rest:
        check_stable(column)
    for line in _known_warnings(column):
        warnings.warn(line, InputWarning, stacklevel=3)


def check_columns(columns: Iterable[Column]) -> None:
    """Warn (InputWarning) of the first of many columns that has values which are probably not intended."""
    for number, column in enumerate(columns):
        if found := _known_warnings(column):
            warnings.warn(f"columns[{number}]: {found[0]}", InputWarning, stacklevel=3)
            return


@lru_cache(maxsize=64)
def _known_warnings(column: Column) -> tuple[str, ...]:
    return tuple(warnings_of(column))


def check_stable(column: Column) -> None:
    """Raise InputError if the rest under gravity is not stable."""
    if not is_stable(column):
        raise InputError(instability(column))


def instability(column: Column) -> str:
    """Why a column whose rest is not stable cannot stand, in one line."""
    i = int(np.argmax(settlements(column))) + 1
    return (
        f"{column.name} cannot stand: its rest under gravity is not stable, the joints are too soft for the weight "
        f"above them (block[{i}].joint.stiffness = {column.blocks[i - 1].joint.stiffness:g} settles by "
        f"{settlements(column)[i - 1]:.3g} m); {UNITS_OF_STIFFNESS}"
    )


def warnings_of(column: Column) -> list[str]:
    """Values that can be computed with but are probably not intended, a line each; mostly none.

    Of all blocks or joints with the same mistake, the line is about the worst.
    """
    lines = [*_of_blocks(column), *_of_joints(column)]
    if column.g and not GRAVITIES[0] <= column.g <= GRAVITIES[1]:
        lines.append(f"g = {column.g:g}: should be {GRAVITIES[0]:g} to {GRAVITIES[1]:g} on Earth; g is in m/s2")
    if _may_be_damped_much(column) and (ratio := first_damping_ratio(column)) > MOST_DAMPED:
        i = int(np.argmax([block.joint.damping for block in column.blocks]))
        lines.append(
            f"block[{i + 1}].joint.damping = {column.blocks[i].joint.damping:g}: the first mode has {ratio:.3g} of "
            f"critical damping, should be {MOST_DAMPED:g} at most; damping is a time in s, not a ratio"
        )
    return lines


def _of_blocks(column: Column) -> list[str]:
    """Warnings about densities and heights."""
    lines = []
    # a block that carries a load, whose mass is included, has a centroid and an inertia of its own
    density = [block.mass / block.volume for block in column.blocks]
    most = [math.inf if block.centroid and block.inertia else DENSITIES[1] for block in column.blocks]
    wrong = [max(DENSITIES[0] / own, own / limit) for own, limit in zip(density, most, strict=True)]
    i = wrong.index(max(wrong))
    if wrong[i] > 1.0:
        block = column.blocks[i]
        lines.append(
            f"block[{i + 1}].mass = {block.mass:g}: is {density[i]:.3g} kg/m3 in {block.volume:.4g} m3, should be "
            f"{DENSITIES[0]:g} to {DENSITIES[1]:g}; mass is in kg, lengths in m"
        )
    height = [block.height for block in column.blocks]
    i = height.index(max(height))
    if height[i] > HIGHEST:
        lines.append(f"block[{i + 1}].height = {height[i]:g}: should be {HIGHEST:g} at most; height is in m")
    return lines


def _of_joints(column: Column) -> list[str]:
    """Warnings about settlement, pressure and friction."""
    lines = []
    settled = settlements(column)
    part = settled / np.array([block.height for block in column.blocks])
    i = int(np.argmax(part))
    if part[i] > MOST_SETTLED:
        lines.append(
            f"block[{i + 1}].joint.stiffness = {column.blocks[i].joint.stiffness:g}: block {i + 1} settles by "
            f"{settled[i]:.3g} m at rest, {part[i]:.2g} of its height; {UNITS_OF_STIFFNESS}"
        )
    area = np.array([contact.area for contact in column.contacts])
    pressure = carried_weights(column) / area
    i = int(np.argmax(pressure))
    if pressure[i] > MOST_PRESSED:
        lines.append(
            f"joint {i + 1}: carries {carried_weights(column)[i]:.3g} N on {area[i]:.3g} m2 at rest, "
            f"{1e-6 * pressure[i]:.3g} MPa, which no stone bears; {UNITS_OF_WEIGHT}"
        )
    friction = [block.joint.friction or 0.0 for block in column.blocks]
    i = friction.index(max(friction))
    if friction[i] > MOST_FRICTION:
        lines.append(
            f"block[{i + 1}].joint.friction = {friction[i]:g}: should be {MOST_FRICTION:g} at most; it is a "
            "coefficient, not an angle in degrees"
        )
    return lines


def is_stable(column: Column) -> bool:
    """Whether the rest under gravity, all joints in full contact, is a minimum of the potential energy.

    A column off its axis always passes: without a stable rest no model of it can be made.

    The energy is always a minimum over the openings. The rest is stable if elimination of the rotations leaves positive
    pivots only.
    """
    if column.off_axis:  # packing.py finds its rest and checks the stability when it makes the model
        return True
    pivot, coupling = math.inf, 0.0
    for diagonal, beside in zip(*_rocking_stiffness(column), strict=True):
        pivot = diagonal - coupling * coupling / pivot
        if not pivot > 0.0:
            return False
        coupling = beside
    return True


def _rocking_stiffness(column: Column) -> tuple[list[float], list[float]]:
    """Diagonal and off-diagonal of the stiffness against the rotations of the blocks, gravity included, N m.

    With the openings of theory.md, section 4, the second derivatives of the potential energy with respect to the
    rotations form a symmetric tridiagonal matrix. The last off-diagonal entry couples the lowest block to the base.
    """
    diagonal, beside = [], []
    turned_above = spread_above = weight_above = 0.0
    for block, contact in zip(column.blocks, column.contacts, strict=True):
        area, _, second_moment = contact.moments
        stiffness, own = block.joint.stiffness, column.g * block.mass
        weight = weight_above + own
        turning = stiffness * second_moment
        spread = 0.25 * weight * weight / (stiffness * area)  # the compressed joint is shortened along its mean normal
        falling = weight_above * block.height + own * block.resolved_centroid
        diagonal.append(turning + turned_above + spread + spread_above - falling)
        beside.append(spread - turning)
        turned_above, spread_above, weight_above = turning, spread, weight
    return diagonal, beside


def _may_be_damped_much(column: Column) -> bool:
    """Whether the damping ratio is worth computing, which takes as long as a tenth of a short run.

    One rigid block on the lowest joint is stiffer than the column in its first mode, and so has more damping.
    """
    base, eta = column.blocks[-1], max(block.joint.damping for block in column.blocks)
    if not eta:
        return False
    rise = inertia = falling = 0.0
    for block in reversed(column.blocks):
        place = rise + block.resolved_centroid
        inertia += block.resolved_inertia + block.mass * place * place
        falling += column.g * block.mass * place
        rise += block.height
    turning = base.joint.stiffness * column.contacts[-1].moments[2]
    left = turning - falling
    return left <= 0.0 or eta * turning > MOST_DAMPED * math.sqrt(left * inertia)


def first_damping_ratio(column: Column) -> float:
    """Damping ratio of the first sway mode, as if on its axis and stuck; 0 without damping or a stable rest.

    Found by inverse iteration, accurate enough for a warning; `modes.natural_modes` has it exactly.
    """
    eta = np.array([block.joint.damping for block in column.blocks])
    if not column.g or not np.any(eta) or not is_stable(column):
        return 0.0
    n = column.n
    diagonal, beside = (np.array(part) for part in _rocking_stiffness(column))
    stiffness = np.diag(diagonal) + np.diag(beside[:-1], 1) + np.diag(beside[:-1], -1)
    mass = np.array([block.mass for block in column.blocks])
    inertia = np.array([block.resolved_inertia for block in column.blocks])
    # displacement of the centroid of each block (row) for a rotation of 1 rad of each block (column)
    reach = np.triu(np.broadcast_to([block.height for block in column.blocks], (n, n)), 1)
    reach += np.diag([block.resolved_centroid for block in column.blocks])
    moduli = np.array([block.joint.stiffness for block in column.blocks])
    turning = moduli * np.array([contact.moments[2] for contact in column.contacts])

    def inertial(shape: FloatArray) -> FloatArray:
        return np.asarray(reach.T @ (mass * (reach @ shape)) + inertia * shape)

    shape = np.ones(n)
    for _ in range(ITERATIONS):
        try:
            shape = np.linalg.solve(stiffness, inertial(shape))
        except np.linalg.LinAlgError:
            return 0.0
        shape /= np.max(np.abs(shape))
    elastic = float(np.sum(eta * turning * np.diff(shape, append=0.0) ** 2))
    return elastic / (2.0 * math.sqrt(abs(float(shape @ stiffness @ shape) * float(shape @ inertial(shape)))))
