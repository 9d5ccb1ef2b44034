"""Neighbours: pairs of blocks that no joint connects and whose sides face each other (theory.md section 14)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...common.errors import InputError, check_number, shown
from ...common.ranges import NUMBERS, check_keys
from .blocks.faces import Face
from .blocks.parts import Joint, Pair, Side, Solid

_REACH = (0.0, 1e6), "a length in m, zero or positive: sides that face each other within it may meet"
_FRICTION = (0.0, 1e3), "a coefficient of friction, 0 without friction"
_RANGES = {
    "reach": _REACH,
    "line_stiffness": ((1e-6, 1e15), "a positive stiffness in N/m2, along the line in which drums meet"),
    "damping": NUMBERS["damping"],
    "restitution": ((1e-3, 1.0), "a coefficient of restitution, from 1e-3 to 1"),
    "friction": _FRICTION,
    "shear_ratio": ((1e-6, 1e6), "a positive ratio of the stiffness along the contact to that across it"),
}
_OF_PAIR = ("between", "gap", *(name for name in _RANGES if name != "reach"))
KEYS = (*_RANGES, "pair")
_GAP = (0.0, 1e6), "a length in m, zero or positive"
SHEAR_RATIO = 0.4
PARALLEL = 0.5  # cosine of the angle between the axis of a drum and a face beyond which the drum's end faces it
LEAST = 1e-6  # of half the length of a drum: sides that face each other over less do not meet
NEAR = 1e-6  # m: of less overlap as built nothing is said


def neighbours_from(data: Mapping[str, Any], blocks: tuple[Solid, ...], joints: Sequence[Joint]) -> tuple[Pair, ...]:
    """The pairs that the table `neighbours` of a structure describes; none without one. Raises InputError."""
    if "neighbours" not in data:
        return ()
    table = data["neighbours"]
    if not isinstance(table, Mapping):
        raise InputError(f"neighbours = {shown(table)}: must be a table with the keys {', '.join(KEYS)}")
    check_keys("neighbours.", table, KEYS)
    given = _numbers("neighbours", table, tuple(_RANGES))
    tables = table.get("pair", [])
    if not isinstance(tables, list) or not all(isinstance(part, Mapping) for part in tables):
        raise InputError("neighbours.pair: must be one table [[neighbours.pair]] for each")
    declared: dict[tuple[int, int], tuple[str, dict[str, float]]] = {}
    for number, part in enumerate(tables, start=1):
        key = f"neighbours.pair[{number}]"
        check_keys(f"{key}.", part, _OF_PAIR)
        declared[_between(key, part, blocks)] = key, _numbers(key, part, _OF_PAIR[1:])
    if "reach" not in given and not declared:
        raise InputError(f"neighbours.reach: missing, must be {_REACH[1]}, or give tables [[neighbours.pair]]")
    joined = {frozenset((joint.upper, joint.lower)) for joint in joints}
    found = []
    for one in range(len(blocks)):
        for other in range(one + 1, len(blocks)):
            key, own = declared.pop((one, other), ("", {}))
            if frozenset((one, other)) in joined:
                if key:
                    raise InputError(f"{key}.between: must be two blocks without a joint between them")
                continue
            pairs = list(_facing(blocks, one, other, math.inf if key else given.get("reach", -1.0)))
            if key and not pairs:
                raise InputError(f"{key}.between: must be two drums, or a drum and a plane face that it stands before")
            found += [_with_law(key or "neighbours", pair, {**_law(given, own), **own}, blocks) for pair in pairs]
    return tuple(found)


def _law(given: Mapping[str, float], own: Mapping[str, float]) -> dict[str, float]:
    """What holds for all pairs; damping and restitution say the same, so that one of a pair replaces the other."""
    says = {"damping", "restitution"} & own.keys()
    return {name: value for name, value in given.items() if not (says and name in ("damping", "restitution"))}


def _numbers(key: str, table: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, float]:
    ranges = {**_RANGES, "gap": _GAP}
    found = {name: check_number(f"{key}.{name}", table[name], *ranges[name]) for name in names if name in table}
    if "damping" in found and "restitution" in found:
        raise InputError(f"{key}.restitution: must be left out beside damping, which it stands for")
    return found


def _between(key: str, table: Mapping[str, Any], blocks: tuple[Solid, ...]) -> tuple[int, int]:
    names, pair = [block.name for block in blocks], table.get("between")
    if not isinstance(pair, (list, tuple)) or len(pair) != 2 or pair[0] == pair[1]:
        raise InputError(f"{key}.between = {shown(pair)}: must be two names of blocks")
    for name in pair:
        if name not in names:
            raise InputError(f"{key}.between: {shown(name)} must be the name of a block")
    one, other = sorted(names.index(name) for name in pair)
    return one, other


def side_of_drum(solid: Solid) -> Side | None:
    """The side of a drum whose ends are equal; None of other blocks."""
    ends = [face for face in solid.faces if face.radius]
    if len(ends) != 2 or len(solid.faces) != 2 or not math.isclose(ends[0].radius, ends[1].radius, rel_tol=1e-9):
        return None
    along = ends[1].centre - ends[0].centre
    length = float(np.linalg.norm(along))
    return Side(0.5 * (ends[0].centre + ends[1].centre), along / length, 0.5 * length, ends[0].radius)


def _facing(blocks: tuple[Solid, ...], one: int, other: int, reach: float) -> Iterator[Pair]:
    """Pairs of sides of two blocks that face each other within a reach, m, without their laws."""
    drums = side_of_drum(blocks[one]), side_of_drum(blocks[other])
    if drums[0] and drums[1]:
        gap, length = _gap_of_drums(drums[0], drums[1])
        if gap <= reach:
            yield Pair(one, other, drums[0], drums[1], gap, length)
    for a, b, drum in ((one, other, drums[0]), (other, one, drums[1])):
        if drum and not drums[0 if drum is drums[1] else 1]:
            for face in blocks[b].faces:
                found = _gap_before_face(drum, face)
                if found and found[0] <= reach:
                    yield Pair(a, b, drum, face, *found)


def _gap_of_drums(a: Side, b: Side) -> tuple[float, float]:
    """Distance of two drums, m, as sides by sides, and the length over which they face each other."""
    between, c = a.middle - b.middle, float(a.axis @ b.axis)
    low, high = -a.half, a.half
    if abs(c) > 1e-9:
        ends = sorted((way * b.half - float(between @ b.axis)) / c for way in (-1.0, 1.0))
        low, high = max(low, ends[0]), min(high, ends[1])
    elif abs(float(between @ b.axis)) > b.half:
        return math.inf, 0.0
    if high - low <= LEAST * min(a.half, b.half):
        return math.inf, 0.0
    at, along = between - float(between @ b.axis) * b.axis, a.axis - c * b.axis
    square = float(along @ along)
    s = min(max(-float(at @ along) / square if square > 1e-24 else 0.0, low), high)
    return float(np.linalg.norm(at + s * along)) - a.radius - b.radius, high - low


def _gap_before_face(drum: Side, face: Face) -> tuple[float, float] | None:
    """Distance of a drum from a face, m, and the length over which it stands before it; None if it does not."""
    c = float(drum.axis @ face.normal)
    if face.radius or abs(c) > PARALLEL:
        return None
    between = drum.middle - face.centre
    low, high = -drum.half, drum.half
    x, y = between @ face.axes[:, :2], drum.axis @ face.axes[:, :2]
    for a, b in zip(face.outline, np.roll(face.outline, -1, axis=0), strict=True):
        side = b - a
        level, slope = float(side[0] * (x[1] - a[1]) - side[1] * (x[0] - a[0])), float(side[0] * y[1] - side[1] * y[0])
        if slope > 1e-12:
            low = max(low, -level / slope)
        elif slope < -1e-12:
            high = min(high, -level / slope)
        elif level <= 0.0:
            return None
    if high - low <= LEAST * drum.half:
        return None
    away = float(between @ face.normal)
    gap = away + min(low * c, high * c) - drum.radius * math.sqrt(1.0 - c * c)
    return (gap, high - low) if away > 0.0 else None


def _with_law(key: str, pair: Pair, law: Mapping[str, float], blocks: tuple[Solid, ...]) -> Pair:
    """A pair with its law and gap. Raises InputError."""
    names = f"{blocks[pair.one].name} and {blocks[pair.other].name}"
    if "line_stiffness" not in law:
        raise InputError(f"{key}.line_stiffness: missing, must be {_RANGES['line_stiffness'][1]}: {names} may meet")
    if "friction" not in law:
        raise InputError(f"{key}.friction: missing, must be {_FRICTION[1]}: {names} may meet")
    if not {"damping", "restitution"} & law.keys():
        raise InputError(f"{key}.damping: missing, must be {NUMBERS['damping'][1]}, or a restitution: {names} may meet")
    if "gap" not in law and pair.gap < -NEAR:
        raise InputError(f"{key}: {names} overlap by {-pair.gap:.3g} m as built, must stand apart, or have a gap")
    stiffness = law["line_stiffness"] * pair.length
    if "damping" in law:
        damping = law["damping"]
    else:
        mass = 1.0 / sum(1.0 / blocks[i].mass for i in (pair.one, pair.other))
        damping = damping_of(law["restitution"], mass, stiffness)
    gap = law.get("gap", max(pair.gap, 0.0))
    return replace(
        pair,
        gap=gap,
        farther=gap - pair.gap,
        stiffness=law["line_stiffness"],
        damping=damping,
        friction=law["friction"],
        shear=law.get("shear_ratio", SHEAR_RATIO) * stiffness,
    )


def restitution_of(damping: float, mass: float, stiffness: float) -> float:
    """Restitution of a central impact of a mass, kg, on a bed, N/m, of this damping, s, without tension.

    The damped half-oscillation until its force is zero; of two blocks the mass is m1 m2 / (m1 + m2).
    Source: T. Schwager and T. Pöschel, Granular Matter 9 (2007) 465.
    """
    zeta = 0.5 * damping * math.sqrt(stiffness / mass)
    if zeta == 0.0:
        return 1.0
    if zeta < 1.0:
        free = math.sqrt(1.0 - zeta * zeta)
        return math.exp(-zeta / free * math.atan2(2.0 * zeta * free, 2.0 * zeta * zeta - 1.0))
    if zeta == 1.0:
        return math.exp(-2.0)
    fast = math.sqrt(zeta * zeta - 1.0)
    return math.exp(-zeta / fast * math.log((zeta + fast) / (zeta - fast)))


def damping_of(restitution: float, mass: float, stiffness: float) -> float:
    """The damping, s, that gives this restitution: the inverse of `restitution_of`, by halving."""
    low, high = 0.0, 1.0
    while restitution_of(high, mass, stiffness) > restitution:
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if restitution_of(middle, mass, stiffness) > restitution else (low, middle)
    return 0.5 * (low + high) if restitution < 1.0 else 0.0
