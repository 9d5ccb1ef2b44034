"""Tables of bearings: the law of a joint at a point from the keys of each kind."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...common.errors import InputError, check_number, shown
from ...common.ranges import LENGTH, NUMBERS, check_choice, check_keys
from .blocks.faces import Face, FloatArray
from .blocks.parts import Bearing, JointLaw, SpatialJoint

_OF_STIFFNESS = (1e-6, 1e15), "a positive stiffness in N/m, from 1e-6 to 1e15"
_OF_DASHPOT = (0.0, 1e15), "a damping in N s/m, zero or positive"
RANGES = {
    "diameter": LENGTH,
    "vertical_stiffness": _OF_STIFFNESS,
    "vertical_damping": NUMBERS["damping"],
    "capacity": (
        (1e-6, 1e6),
        "a displacement in m, from 1e-6 to 1e6, beyond which what the bearing carries has come off it",
    ),
    "radius": ((1e-3, 1e6), "a radius of curvature in m, from 1e-3 to 1e6, the effective one of a pendulum"),
    "height": ((0.0, 1e6), "a height in m between the two concave surfaces, zero or positive"),
    "friction": ((0.0, 1e3), "a coefficient of friction, 0 without friction"),
    "initial_stiffness": (
        (1e-6, 1e15),
        "a positive stiffness in N/m, from 1e-6 to 1e15, of what slides or yields until it does",
    ),
    "initial_damping": NUMBERS["damping"],
    "stiffness": ((1e-6, 1e15), "a positive horizontal stiffness in N/m, from 1e-6 to 1e15, of the rubber"),
    "damping": _OF_DASHPOT,
    "yield": ((1e-6, 1e15), "a positive force in N, from 1e-6 to 1e15, at which the lead yields"),
    "rim": ((1e-6, 1e6), "a displacement in m, from 1e-6 to 1e6, at which a stiff ring stops the bearing"),
    "rim_stiffness": _OF_STIFFNESS,
    "rim_damping": NUMBERS["damping"],
    "strength": NUMBERS["strength"],
}
_SLIDER = "initial_stiffness", "initial_damping"
_OF_RIM = ("rim", "rim_stiffness", "rim_damping")
_PLACE = ("kind", "between", "at", "normal")
_NEEDED = ("diameter", "vertical_stiffness", "vertical_damping", "capacity")
# by kind: keys required in addition to _PLACE and _NEEDED, and optional ones in addition to _OF_RIM and strength
KINDS = {
    "pendulum": (("radius", "friction"), (*_SLIDER, "damping")),
    "double_concave": (("radius", "height", "friction"), (*_SLIDER, "damping")),
    "elastomeric": (("stiffness", "damping"), ("tension",)),
    "lead_rubber": (("stiffness", "yield", "initial_stiffness"), ("initial_damping", "damping", "tension")),
    "rolling": (("friction",), ("radius", *_SLIDER, "damping")),
}


def check_table(key: str, table: Mapping[str, Any]) -> None:
    """Check the keys of a table of bearings. Raises InputError."""
    kind = table.get("kind")
    check_choice(f"{key}.kind", kind, tuple(KINDS))
    needed, other = KINDS[str(kind)]
    needed = (*_NEEDED, *needed)
    check_keys(f"{key}.", table, (*_PLACE, *needed, *other, *_OF_RIM, "strength"), of=f" of a {kind} bearing")
    for word in needed:
        if word not in table:
            raise InputError(f"{key}.{word}: missing, must be {RANGES[word][1]}")


def bearings_from(
    key: str, table: Mapping[str, Any], bodies: tuple[int, int], axes: FloatArray, places: Sequence[FloatArray]
) -> list[SpatialJoint]:
    """Return the bearings of a table, after `check_table`, between two bodies (upper, lower) at places (3,), m.

    `key` names the table in messages; `axes` (3, 3) are those of the bearings by columns, the normal last. Raises
    InputError if a value is wrong.
    """
    given = {
        word: check_number(f"{key}.{word}", table[word], *RANGES[word]) for word in RANGES if _is_number(word, table)
    }
    bearing, bed = _laws(key, table["kind"], table, given)
    # a round face of the size of the bearing at each position
    radius = 0.5 * given["diameter"]
    many = len(places) > 1
    return [
        SpatialJoint(
            *bodies,
            Face(place, axes, np.zeros((0, 2)), radius),
            bed,
            f"{key}.at[{k}]" if many else key,
            bearing=bearing,
        )
        for k, place in enumerate(places)
    ]


def _is_number(word: str, table: Mapping[str, Any]) -> bool:
    return word in table and not (word == "radius" and table["kind"] == "double_concave")


def _laws(key: str, kind: str, table: Mapping[str, Any], given: Mapping[str, float]) -> tuple[Bearing, JointLaw]:
    friction: float | None = given.get("friction")
    # sliders
    if kind in ("pendulum", "double_concave", "rolling"):
        if friction and "initial_stiffness" not in given:
            raise InputError(f"{key}.initial_stiffness: missing, must be {RANGES['initial_stiffness'][1]}")
        for word in _SLIDER:
            if not friction and word in given:
                raise InputError(f"{key}.{word}: must be left out where friction = 0, nothing slides")
    friction = 0.0 if kind == "lead_rubber" else friction or None  # lead yields at any weight
    # the ring
    if "rim" in given:
        for word in _OF_RIM:
            if word not in given:
                raise InputError(f"{key}.{word}: missing beside rim, must be {RANGES[word][1]}")
        if not given["rim"] < given["capacity"]:
            raise InputError(f"{key}.rim = {given['rim']}: must be less than capacity = {given['capacity']} m")
    elif "rim_stiffness" in given or "rim_damping" in given:
        raise InputError(f"{key}.rim: missing beside rim_stiffness and rim_damping, must be {RANGES['rim'][1]}")
    holds = table.get("tension", False)
    if not isinstance(holds, bool):
        raise InputError(f"{key}.tension = {shown(holds)}: must be true or false")
    # bed of the joint: vertical stiffness and friction
    radius = _double(key, table, given) if kind == "double_concave" else given.get("radius", math.inf)
    across = given["vertical_stiffness"]
    area = 0.25 * math.pi * given["diameter"] ** 2
    bed = JointLaw(
        stiffness=across / area,
        damping=given["vertical_damping"],
        shear_ratio=given.get("initial_stiffness", 0.0) / across,
        shear_damping=given.get("initial_damping", 0.0),
        friction=friction,
        dowel=given.get("yield", 0.0),
        strength=given.get("strength"),
    )
    ring = given.get("rim", math.inf), given.get("rim_stiffness", 0.0), given.get("rim_damping", 0.0)
    spring, dashpot = given.get("stiffness", 0.0), given.get("damping", 0.0)
    return Bearing(kind, 1.0 / radius, spring, dashpot, *ring, given["capacity"], holds), bed


def _double(key: str, table: Mapping[str, Any], given: Mapping[str, float]) -> float:
    """Return the effective radius of two concave surfaces (m): the sum of both radii less the height between them."""
    pair = table["radius"]
    if not isinstance(pair, (list, tuple)) or len(pair) != 2:
        raise InputError(f"{key}.radius = {shown(pair)}: must be the radii of curvature of both surfaces, in m")
    radii = [check_number(f"{key}.radius[{k}]", part, *RANGES["radius"]) for k, part in enumerate(pair)]
    effective = sum(radii) - given["height"]
    if not effective > 0.0:
        raise InputError(f"{key}.height = {given['height']}: must be less than both radii together = {sum(radii):g} m")
    return effective
