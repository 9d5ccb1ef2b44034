"""Checks for values that are valid but probably unintended, common to columns and structures."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from .errors import InputWarning

MOST_SETTLED = 0.1  # of a block's height; the mortar beds and soils under blocks settle less
MOST_PRESSED = 500e6  # Pa; more than the strength of nearly any stone
LEAST_STRENGTH = 1e5  # Pa; earth and the poorest mortars are stronger
DENSITIES = (500.0, 12000.0)  # kg/m3, from wood to lead
MOST_DAMPED = 0.2  # damping ratio of the first mode; dry joints have some percent
MOST_DAMPED_ON_RIMS = 1.0  # the same, with contact along rims, whose damping is critical as a block stands on its edge
MOST_FRICTION = 1.5  # rough stone on stone has some 0.8
MOST_SHAKEN = 1.5  # g, the largest acceleration of the ground; hardly a record or code has more
# the largest intensity of the ground on record, about: pga and the spectral measures in g, pgv in m/s
MOST_INTENSE = {"pga": 3.0, "pgv": 4.0}
MOST_SPECTRAL = 9.0
GRAVITIES = (9.7, 9.9)  # m/s2, on Earth; zero is accepted as intended
HIGHEST = 30.0  # m, of one block
UNITS_OF_STIFFNESS = "stiffness is in N/m3: 1 kgf/cm3 = 9.80665e6 N/m3, 1 MPa/mm = 1e9 N/m3"
UNITS_OF_WEIGHT = "mass is in kg, density in kg/m3, width and depth in m"

Numbers = Sequence[float]


class Facts(NamedTuple):
    """The checked quantities, an entry for each block or joint; keys and names for messages by index from 0."""

    block_key: Callable[[int], str]
    block_name: Callable[[int], str]
    joint_key: Callable[[int], str]  # the key of the table of its law
    joint_name: Callable[[int], str]
    mass: Numbers  # kg
    volume: Numbers  # m3
    loaded: Sequence[bool]  # whether the mass includes a load without volume
    height: Numbers  # m
    g: float  # m/s2
    laws: Sequence[Any]  # with stiffness (N/m3), damping (s), friction, strength (Pa); the last two may be None
    area: Numbers  # m2
    upper: Sequence[int]  # index of the block on each joint
    carried: Numbers  # N, force on each joint at rest; empty if no rest was computed
    damping_ratio: float  # of the first mode; 0 where it is small
    most_damped: float = MOST_DAMPED


def lines_of(facts: Facts) -> list[str]:
    """Return a line for each kind of mistake, about the worst block or joint; mostly none."""
    lines = [*_of_blocks(facts), *_at_rest(facts), *_of_laws(facts)]
    g, ratio = facts.g, facts.damping_ratio
    if g and not GRAVITIES[0] <= g <= GRAVITIES[1]:
        lines.append(f"g = {g:g}: should be {GRAVITIES[0]:g} to {GRAVITIES[1]:g} on Earth; g is in m/s2")
    if ratio > facts.most_damped:
        damping = [law.damping for law in facts.laws]
        i = damping.index(max(damping))
        lines.append(
            f"{facts.joint_key(i)}.damping = {damping[i]:g}: the first mode has {ratio:.3g} of critical "
            f"damping, should be {facts.most_damped:g} at most; damping is a time in s, not a ratio"
        )
    return lines


def warn_of(lines: Iterable[str]) -> None:
    """Warn (InputWarning) with each line."""
    for line in lines:
        warnings.warn(line, InputWarning, stacklevel=4)


def warn_of_first(lines: Iterable[Sequence[str]]) -> None:
    """Warn (InputWarning) of the first of many columns that has lines; `lines` holds those of each."""
    for number, found in enumerate(lines):
        if found:
            warnings.warn(f"columns[{number}]: {found[0]}", InputWarning, stacklevel=3)
            return


def _worst(values: Numbers, most: float) -> list[int]:
    """Return the index of the largest value if it is more than `most`, else none."""
    i = max(range(len(values)), key=values.__getitem__, default=0)
    return [i] if len(values) and values[i] > most else []


def _of_blocks(facts: Facts) -> Iterator[str]:
    """Check densities and heights."""
    density = [mass / volume for mass, volume in zip(facts.mass, facts.volume, strict=True)]
    most = [math.inf if loaded else DENSITIES[1] for loaded in facts.loaded]
    for i in _worst([max(DENSITIES[0] / own, own / limit) for own, limit in zip(density, most, strict=True)], 1.0):
        yield (
            f"{facts.block_key(i)}.mass = {facts.mass[i]:g}: is {density[i]:.3g} kg/m3 in {facts.volume[i]:.4g} m3, "
            f"should be {DENSITIES[0]:g} to {DENSITIES[1]:g}; mass is in kg, lengths in m"
        )
    for i in _worst(facts.height, HIGHEST):
        key, height = facts.block_key(i), facts.height[i]
        yield f"{key}.height = {height:g}: should be {HIGHEST:g} at most; height is in m"


def _at_rest(facts: Facts) -> Iterator[str]:
    """Check settlement relative to the height of the block, and pressure, at rest."""
    carried, area = facts.carried, facts.area
    if not len(carried):
        return
    settled = [force / (law.stiffness * a) for force, law, a in zip(carried, facts.laws, area, strict=True)]
    part = [own / facts.height[upper] for own, upper in zip(settled, facts.upper, strict=True)]
    for i in _worst(part, MOST_SETTLED):
        yield (
            f"{facts.joint_key(i)}.stiffness = {facts.laws[i].stiffness:g}: {facts.block_name(facts.upper[i])} settles "
            f"by {settled[i]:.3g} m at rest, {part[i]:.2g} of its height; {UNITS_OF_STIFFNESS}"
        )
    pressure = [force / a for force, a in zip(carried, area, strict=True)]
    for i in _worst(pressure, MOST_PRESSED):
        yield (
            f"{facts.joint_name(i)}: carries {carried[i]:.3g} N on {area[i]:.3g} m2 at rest, "
            f"{1e-6 * pressure[i]:.3g} MPa, which no stone bears; {UNITS_OF_WEIGHT}"
        )


def _of_laws(facts: Facts) -> Iterator[str]:
    """Check friction and strength."""
    friction = [law.friction or 0.0 for law in facts.laws]
    for i in _worst(friction, MOST_FRICTION):
        yield (
            f"{facts.joint_key(i)}.friction = {friction[i]:g}: should be {MOST_FRICTION:g} at most; it is a "
            "coefficient, not an angle in degrees"
        )
    strength = [math.inf if law.strength is None else law.strength for law in facts.laws]
    for i in _worst([-each for each in strength], -LEAST_STRENGTH):
        yield (
            f"{facts.joint_key(i)}.strength = {strength[i]:g}: should be {LEAST_STRENGTH:g} at least; strength is a "
            "pressure in Pa, 1 MPa = 1e6 Pa"
        )
