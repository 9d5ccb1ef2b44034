"""Numbers of a column by their dotted names, so that a study can vary any of them, independent of the keys of columns.

joint.stiffness     of every joint
joint[3].damping    of the joint under block 3, counted from 1, the top one
block[1].height     of a block
g, solver.tolerance
column.size         factor on every length; masses scale with its cube, given moments of inertia with its fifth power
column.slenderness  sum of heights divided by the width of the lowest block; widths and depths are scaled to match
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from functools import lru_cache
from typing import Any

from ...common.errors import POSITIVE, InputError, UnknownKeyError, check_number
from ...common.ranges import NUMBERS, lengths_in
from .block import Given
from .file import ROUND
from .model import Column

_PARTS = re.compile(r"(block|joint)(?:\[([1-9]\d*)\])?\.([a-z_]+)")
_WHOLE = ("g", "solver.step", "solver.tolerance")
SIZE = "column.size"
SLENDERNESS = "column.slenderness"
SHAPES = (SIZE, SLENDERNESS)
_OWN = ("stiffness", "damping")  # numbers of a joint on which no other value of a column depends
_TOLERANCE = "solver.tolerance"
_LENGTHS = lengths_in(NUMBERS) | {"strips", "at"}
_ACROSS = _LENGTHS - {"height", "centroid"}  # not along the axis of the column
_EITHER = {"mass": "density", "density": "mass"}  # each replaces the other


def is_of_column(name: str) -> bool:
    """Return True if a dotted name is that of a number of the column."""
    return name in _WHOLE or name in SHAPES or _parts(name) is not None


def single_names(name: str, blocks: int) -> list[str]:
    """Expand `joint.stiffness` to `joint[1].stiffness`, `joint[2].stiffness` ...; keep the name of one number."""
    found = _parts(name)
    if found is None or found[1]:
        return [name]
    return [f"{found[0]}[{i}].{found[2]}" for i in range(1, blocks + 1)]


def numbers_set(column: Column, name: str) -> list[str]:
    """Return the numbers that a name sets: of a diameter width and depth, of a mass the density."""
    blocks = _to_dict(column, tuple(block.given for block in column.blocks))["block"]
    if name == SLENDERNESS:
        keys = ("width", "depth", "height")
        return [f"block[{i}].{key}" for i in range(1, column.n + 1) for key in keys]
    found = _parts(name)
    if found is None:
        return [name]
    which = [i for i in range(1, column.n + 1) if found[1] in (0, i)]
    tables = {i: blocks[i - 1] if found[0] == "block" else blocks[i - 1]["joint"] for i in which}
    keyed = [(i, key) for i, table in tables.items() for key in _keys(found[2], table, blocks[i - 1])]
    return [f"{found[0]}[{i}].{'density' if key == 'mass' else key}" for i, key in keyed]


def column_with(column: Column, values: Mapping[str, tuple[float, bool]]) -> Column:
    """Return the column with other numbers, by name: the number, and whether it is a factor on the present value.

    Shapes are set first, then numbers, then factors. Raises InputError if a name or number is invalid.
    """
    if not values:
        return column
    if all(name == _TOLERANCE or _joint_number(name) in _OWN for name in values):
        return _with_own(column, values)
    data = _to_dict(column, tuple(block.given for block in column.blocks))
    blocks = [{**block, "joint": dict(block["joint"])} for block in data["block"]]
    data = {**data, "block": blocks, "solver": dict(data["solver"])}  # a copy, which may be modified
    for name in sorted(values, key=lambda name: (name not in SHAPES, values[name][1])):
        number, relative = values[name]
        _set(data, name, number, relative)
    return Column.from_dict(data)


@lru_cache(maxsize=8)
def _to_dict(column: Column, given: tuple[Given | None, ...]) -> dict[str, Any]:
    """Return `Column.to_dict`, which depends on what is given beside the numbers by which columns compare."""
    return column.to_dict()


@lru_cache(maxsize=1024)
def _parts(name: str) -> tuple[str, int, str] | None:
    """Split a name into `block` or `joint`, number (0: all) and key; None for a name of the whole column."""
    found = _PARTS.fullmatch(name)
    return None if found is None else (found[1], int(found[2] or 0), found[3])


def _joint_number(name: str) -> str:
    found = _parts(name)
    return found[2] if found is not None and found[0] == "joint" else ""


def _with_own(column: Column, values: Mapping[str, tuple[float, bool]]) -> Column:
    """Return the column with independent numbers changed, without the conversion to a dict and back."""
    own = {key: [getattr(block.joint, key) for block in column.blocks] for key in _OWN}
    for name, (number, relative) in sorted(values.items(), key=lambda item: item[1][1]):  # factors last
        if name == _TOLERANCE:
            column = column.with_settings(tolerance=number * column.settings.tolerance if relative else number)
            continue
        numbers = own[_joint_number(name)]
        for i in _which(name, column.n):
            numbers[i] = number * numbers[i] if relative else number
    return column.with_joints(**own)


def _which(name: str, blocks: int) -> range:
    """Return the indices of the blocks that a name refers to. Raises UnknownKeyError if there are fewer blocks."""
    found = _parts(name)
    if found is None or not found[1]:
        return range(blocks)
    number = found[1]
    if number > blocks:
        raise UnknownKeyError(f"{name}: there are {blocks} blocks")
    return range(number - 1, number)


def _set(data: dict[str, Any], name: str, number: float, relative: bool) -> None:
    found = _parts(name)
    if name in SHAPES:
        factor = check_number(name, number, POSITIVE, "a positive number")
        if name == SIZE:
            data.update(resized(data, factor, _LENGTHS, {"mass": 3, "inertia": 5}))
        else:
            _widen(data, factor, relative)
    elif name == "g":
        _put(data, name, "g", number, relative)
    elif found is None:
        _put(data["solver"], name, name.removeprefix("solver."), number, relative)
    else:
        blocks = data["block"]
        for block in (blocks[i] for i in _which(name, len(blocks))):
            table = block if found[0] == "block" else block["joint"]
            for key in _keys(found[2], table, block):
                _put(table, name, key, number, relative)


def _keys(key: str, table: Mapping[str, Any], block: Mapping[str, Any]) -> list[str]:
    """Return the keys of `Column.to_dict` for one of a block or its joint: of a diameter width and, if any, depth."""
    if not key.endswith("diameter") or table.get("section", block["section"]) not in ROUND:
        return [key]
    return [key.replace("diameter", size) for size in (("width", "depth") if table is block else ("width",))]


def _put(table: dict[str, Any], name: str, key: str, number: float, relative: bool) -> None:
    if relative and key == "mass" and "density" in table:
        key = "density"  # to which the mass is proportional
    table[key] = varied(name, table.get(key), number, relative)
    table.pop(_EITHER.get(key, ""), None)


def varied(name: str, present: object, number: float, relative: bool) -> float:
    """Return a number, or the present one times it. Raises InputError if there is none that could be multiplied."""
    if not relative:
        return number
    if isinstance(present, bool) or not isinstance(present, (int, float)):
        raise InputError(f"{name}: the file has none that could be multiplied, must be given without relative")
    return number * present


def resized(table: Any, factor: float, lengths: Collection[str], powers: Mapping[str, int], key: str = "") -> Any:
    """Return a table of a file and all in it with a factor on its `lengths`, and with powers of it on other numbers."""
    if isinstance(table, dict):
        return {name: resized(part, factor, lengths, powers, name) for name, part in table.items()}
    if isinstance(table, (list, tuple)):
        return [resized(part, factor, lengths, powers, key) for part in table]
    power = 1 if key in lengths else powers.get(key, 0)
    return factor**power * table if power else table


def widen_ports(data: dict[str, Any], factor: float) -> None:
    """Multiply the horizontal coordinates of the ports beside a column by a factor."""
    if "port" in data:
        data["port"] = [dict(port) for port in data["port"]]
    for port in data.get("port", []):
        if "at" in port:
            *across, upright = port["at"]
            port["at"] = [*(factor * part for part in across), upright]


def _widen(data: dict[str, Any], slenderness: float, relative: bool) -> None:
    blocks = data["block"]
    for i, block in enumerate(blocks, start=1):
        if {"inertia", "load"} & block.keys():
            raise InputError(f"{SLENDERNESS}: block[{i}] must have no inertia or load: its inertia would not follow")
    present = math.fsum(block["height"] for block in blocks) / blocks[-1]["width"]
    factor = 1.0 / slenderness if relative else present / slenderness
    data["block"] = [resized(block, factor, _ACROSS, {"mass": 2}) for block in blocks]
    widen_ports(data, factor)
