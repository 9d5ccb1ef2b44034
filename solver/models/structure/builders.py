"""Structures of many equal blocks: colonnades, arches, walls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from ...common.errors import InputError, check_number, check_whole, shown
from ...common.ranges import LENGTH, MAX_BLOCKS, check
from .model import Structure

Law = Mapping[str, Any]  # keys of a joint: stiffness, damping, shear_ratio, shear_damping, friction, dowel, strength


def _count(key: str, value: object, least: int) -> int:
    return check_whole(key, value, least, MAX_BLOCKS, f"a whole number from {least} to {MAX_BLOCKS}")


def _check_count(blocks: int) -> None:
    if blocks > MAX_BLOCKS:  # before they are made
        raise InputError(f"block: {blocks} blocks, must be 1 to {MAX_BLOCKS}")


def _length(key: str, value: object) -> float:
    return check_number(key, value, *LENGTH)


def _lengths(key: str, value: object, names: tuple[str, ...]) -> list[float]:
    if not isinstance(value, (list, tuple, np.ndarray)) or len(value) != len(names):
        raise InputError(f"{key} = {shown(value)}: must be lengths in m: {', '.join(names)}")
    return [_length(f"{key}[{k}]", part) for k, part in enumerate(value)]


def _law(key: str, value: object) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise InputError(f"{key} = {shown(value)}: must be a mapping of its keys to numbers, stiffness and others")
    return dict(value)


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
    """Build a row of columns of drums along x, with an architrave from each column to the next. Raises InputError.

    Parameters
    ----------
    columns, drums : int
        Number of columns, and of drums in each.
    spacing : float
        Distance of the axes of the columns, m.
    diameter, top_diameter : float
        Diameters of the shafts at the bottom and at the top, m; top_diameter None: as at the bottom.
    height : float
        Height of the shafts, m.
    joint : mapping
        Law of every joint.
    architrave : tuple of float
        Height and depth of the architraves, m.
    density : float
        Density, kg/m3.
    tie : mapping or None
        Keys of a tie (stiffness, yield, ...) between the tops of neighbouring architraves; None: no ties.
    """
    columns, drums = _count("columns", columns, 1), _count("drums", drums, 1)
    _check_count(columns * (drums + 1) - 1)
    spacing, height, diameter = _length("spacing", spacing), _length("height", height), _length("diameter", diameter)
    top = diameter if top_diameter is None else _length("top_diameter", top_diameter)
    high, deep = _lengths("architrave", architrave, ("height", "depth"))
    joint, density = _law("joint", joint), check("density", density)
    # drums, column by column
    blocks: list[dict[str, Any]] = []
    for c in range(columns):
        for k in range(drums):
            wide, narrow = (diameter + (top - diameter) * part / drums for part in (k, k + 1))
            block = {"name": f"drum{c + 1}.{k + 1}", "shape": "drum", "height": height / drums, "density": density}
            block |= {"diameter": wide, "top_diameter": narrow}
            block |= {"on": f"drum{c + 1}.{k}"} if k else {"on": "base", "at": [c * spacing, 0.0]}
            blocks.append(block)
    # architraves, and ties between them
    beams = columns - 1
    for c in range(beams):
        supports = [f"drum{c + 1}.{drums}", f"drum{c + 2}.{drums}"]
        block = {"name": f"architrave{c + 1}", "width": spacing, "depth": deep, "height": high}
        blocks.append(block | {"density": density, "on": supports, "at": [(c + 0.5) * spacing, 0.0]})
    pairs = [[f"architrave{c}", f"architrave{c + 1}"] for c in range(1, beams)]
    reach = [0.25 * spacing, 0.0, 0.5 * high]
    ties = []
    if tie is not None:
        start, end = [0.5 * spacing - reach[0], 0.0, reach[2]], [reach[0] - 0.5 * spacing, 0.0, reach[2]]
        ties = [{"between": pair, "from": start, "to": end, **_law("tie", tie)} for pair in pairs]
    joints = [{"between": pair} for pair in pairs]
    data = {"name": name, "joints": joint, "block": blocks, "joint": joints, "tie": ties}
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
    """Build a circular arch in the plane x, z about the origin, both ends on the base. Raises InputError.

    Parameters
    ----------
    voussoirs : int
        Number of voussoirs.
    radius : float
        Radius of the middle line, m.
    thickness, depth : float
        Thickness along the radius and depth along y, m.
    joint : mapping
        Law of every joint.
    angle : float
        Angle from end to end, rad.
    density : float
        Density, kg/m3.
    """
    count = _count("voussoirs", voussoirs, 1)
    radius, thickness, depth = _length("radius", radius), _length("thickness", thickness), _length("depth", depth)
    angle = check_number("angle", angle, (1e-3, 2.0 * math.pi), "an angle in rad, from 1e-3 to a full turn")
    joint, density = _law("joint", joint), check("density", density)
    if angle >= count * math.pi:
        raise InputError(f"voussoirs = {count}: must be more, each turns by less than pi of the angle = {angle} rad")
    if not thickness < 2.0 * radius:
        raise InputError(f"thickness = {thickness}: must be less than twice the radius = {radius} m")
    # voussoirs between rays
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
    # joints between voussoirs, and with a plane of the base at each end
    joints: list[dict[str, Any]] = [{"between": [f"voussoir{k + 1}", f"voussoir{k}"]} for k in range(1, count)]
    ends = []
    for k, way, sign in ((1, ways[0], 1.0), (count, ways[-1], -1.0)):
        at, normal = [radius * float(way[0]), 0.0, radius * float(way[1])], [-sign * float(way[1]), 0.0]
        ends.append({"between": [f"voussoir{k}", "base"], "at": at, "normal": [*normal, sign * float(way[0])]})
    joints = [ends[0], *joints, ends[1]]
    return Structure.from_dict({"name": name, "joints": joint, "block": blocks, "joint": joints})


def wall(
    courses: int,
    length: int,
    block: tuple[float, float, float],
    joint: Law,
    density: float = 2000.0,
    name: str = "wall",
) -> Structure:
    """Build a wall along x of courses of equal blocks in half bond.

    Every second course has half blocks at its ends. Raises InputError.

    Parameters
    ----------
    courses, length : int
        Number of courses, and of blocks in the first one.
    block : tuple of float
        Width, depth and height of a block, m.
    joint : mapping
        Law of every joint, both bed and head joints.
    density : float
        Density, kg/m3.
    """
    courses, length = _count("courses", courses, 1), _count("length", length, 2)
    _check_count(courses * length + courses // 2)
    width, depth, height = _lengths("block", block, ("width", "depth", "height"))
    joint, density = _law("joint", joint), check("density", density)
    # edges of the blocks in each course
    rows: list[list[tuple[str, float, float]]] = []  # name, begin and end along x
    for c in range(courses):
        edges = [k * width for k in range(length + 1)]
        if c % 2:
            edges = [0.0, *((k + 0.5) * width for k in range(length)), length * width]
        spans = pairwise(edges)
        rows.append([(f"stone{c + 1}.{k}", *span) for k, span in enumerate(spans, start=1)])
    # each block stands on those below that it overlaps
    blocks, joints = [], []
    for c, row in enumerate(rows):
        for stone, begin, end in row:
            below = [other for other, b, e in rows[c - 1] if b < end - 1e-9 and e > begin + 1e-9] if c else ["base"]
            size = {"width": end - begin, "depth": depth, "height": height, "density": density}
            blocks.append({"name": stone, **size, "on": below, "at": [0.5 * (begin + end), 0.0]})
        joints += [{"between": [right[0], left[0]]} for left, right in pairwise(row)]
    return Structure.from_dict({"name": name, "joints": joint, "block": blocks, "joint": joints})
