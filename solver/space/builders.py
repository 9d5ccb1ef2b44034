"""Structures of many equal blocks: colonnades, arches, walls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from ..common.errors import InputError
from .structure import Structure

Law = Mapping[str, Any]  # keys of a joint: stiffness, damping, shear_ratio, shear_damping, friction, dowel, strength


def _at_least(key: str, value: int, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise InputError(f"{key} = {value!r}: must be a whole number, at least {least}")
    return int(value)


def colonnade(
    columns: int,
    drums: int,
    spacing: float,
    diameter: float,
    height: float,
    joint: Law,
    top_diameter: float | None = None,
    architrave: tuple[float, float] = (1.0, 1.0),
    density: float = 2700.0,
    tie: Law | None = None,
    name: str = "colonnade",
) -> Structure:
    """Columns of drums in a row along x, with an architrave from the middle of each to the middle of the next.

    spacing: m, of the axes; diameter, top_diameter: m, of the shafts, of this height in m; architrave: its height and
    depth, m; joint: the law of every joint; tie: keys of a tie (stiffness, yield, ...) that clamps the tops of
    neighbouring architraves, if any. Raises InputError.
    """
    columns, drums = _at_least("columns", columns, 1), _at_least("drums", drums, 1)
    top = diameter if top_diameter is None else top_diameter
    blocks: list[dict[str, Any]] = []
    for c in range(columns):
        for k in range(drums):
            wide, narrow = (diameter + (top - diameter) * part / drums for part in (k, k + 1))
            block = {"name": f"drum{c + 1}.{k + 1}", "shape": "drum", "height": height / drums, "density": density}
            block |= {"diameter": wide, "top_diameter": narrow}
            block |= {"on": f"drum{c + 1}.{k}"} if k else {"on": "base", "at": [c * spacing, 0.0]}
            blocks.append(block)
    beams = columns - 1
    for c in range(beams):
        supports = [f"drum{c + 1}.{drums}", f"drum{c + 2}.{drums}"]
        block = {"name": f"architrave{c + 1}", "width": spacing, "depth": architrave[1], "height": architrave[0]}
        blocks.append(block | {"density": density, "on": supports, "at": [(c + 0.5) * spacing, 0.0]})
    pairs = [[f"architrave{c}", f"architrave{c + 1}"] for c in range(1, beams)]
    reach = [0.25 * spacing, 0.0, 0.5 * architrave[0]]
    ties = []
    if tie is not None:
        start, end = [0.5 * spacing - reach[0], 0.0, reach[2]], [reach[0] - 0.5 * spacing, 0.0, reach[2]]
        ties = [{"between": pair, "from": start, "to": end, **tie} for pair in pairs]
    joints = [{"between": pair} for pair in pairs]
    data = {"name": name, "joints": dict(joint), "block": blocks, "joint": joints, "tie": ties}
    return Structure.from_dict(data)


def arch(
    voussoirs: int,
    radius: float,
    thickness: float,
    depth: float,
    joint: Law,
    angle: float = math.pi,
    density: float = 2000.0,
    name: str = "arch",
) -> Structure:
    """A circular arch in the plane x, z about the origin, that stands on the base at both ends.

    radius: m, of its middle line; thickness along the radius and depth along y, m; angle: rad, from end to end; joint:
    the law of every joint. Raises InputError.
    """
    count = _at_least("voussoirs", voussoirs, 1)
    if not 0.0 < thickness < 2.0 * radius:
        raise InputError(f"thickness = {thickness}: must be positive, and less than twice the radius = {radius} m")
    places = 0.5 * math.pi + angle * (0.5 - np.arange(count + 1) / count)  # from -x to +x would run the other way
    places = places[::-1]
    ways = np.column_stack([np.cos(places), np.sin(places)])
    inner, outer = (radius - 0.5 * thickness) * ways, (radius + 0.5 * thickness) * ways
    blocks = [
        {
            "name": f"voussoir{k + 1}",
            "shape": "prism",
            "outline": [corner.tolist() for corner in (inner[k], outer[k], outer[k + 1], inner[k + 1])],
            "depth": depth,
            "density": density,
            "position": [0.0, 0.0, 0.0],
        }
        for k in range(count)
    ]
    joints = []
    for k, way in enumerate(ways):
        upper = f"voussoir{k + 1}" if k < count else f"voussoir{count}"
        lower = f"voussoir{k}" if 0 < k < count else "base"
        along = np.array([-way[1], way[0]]) * (1.0 if k < count else -1.0)
        place = radius * way
        joints.append(
            {
                "between": [upper, lower],
                "at": [float(place[0]), 0.0, float(place[1])],
                "normal": [float(along[0]), 0.0, float(along[1])],
                "section": "rectangle",
                "width": thickness,
                "depth": depth,
            }
        )
    return Structure.from_dict({"name": name, "joints": dict(joint), "block": blocks, "joint": joints})


def wall(
    courses: int,
    length: int,
    block: tuple[float, float, float],
    joint: Law,
    density: float = 2000.0,
    name: str = "wall",
) -> Structure:
    """A wall along x of courses of equal blocks in half bond, with half blocks at the ends of every second course.

    courses, length: number of courses, and of blocks in the first one; block: its width, depth and height, m; joint:
    the law of every joint, of beds and of ends. Raises InputError.
    """
    courses, length = _at_least("courses", courses, 1), _at_least("length", length, 2)
    width, depth, height = block
    rows: list[list[tuple[str, float, float]]] = []  # name, begin and end along x
    for c in range(courses):
        edges = [k * width for k in range(length + 1)]
        if c % 2:
            edges = [0.0, *((k + 0.5) * width for k in range(length)), length * width]
        spans = pairwise(edges)
        rows.append([(f"stone{c + 1}.{k}", *span) for k, span in enumerate(spans, start=1)])
    blocks, joints = [], []
    for c, row in enumerate(rows):
        for stone, begin, end in row:
            below = [other for other, b, e in rows[c - 1] if b < end - 1e-9 and e > begin + 1e-9] if c else ["base"]
            size = {"width": end - begin, "depth": depth, "height": height, "density": density}
            blocks.append({"name": stone, **size, "on": below, "at": [0.5 * (begin + end), 0.0]})
        joints += [{"between": [right[0], left[0]]} for left, right in pairwise(row)]
    return Structure.from_dict({"name": name, "joints": dict(joint), "block": blocks, "joint": joints})
