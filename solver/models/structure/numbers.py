"""Numbers of a structure by their dotted names, so that a study can set any number of its file.

block[left].height      of a block by its name, or by its number in the file, from 1; block.density: of every block
block[left].at[1]       a coordinate, from 1
joint[beam-left].friction  the law of a joint by its name, as in the results, or its number; joint.stiffness: of all
bearing[1].friction     of a table of bearings by its number; bearing.friction: of all
tie[1].yield            of a tie; tie.stiffness: of all
neighbours.friction     of all neighbours
neighbours.pair[1].gap  of a pair by its number in the file; neighbours.pair.gap: of every pair of the file
g, solver.tolerance
structure.size          factor on every length; masses grow with its cube, moduli and ties' forces do not change
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import lru_cache
from typing import Any, NamedTuple

from ...common.errors import POSITIVE, InputError, UnknownKeyError, check_number
from ...common.ranges import NUMBERS, lengths_in
from ..column.numbers import resized, varied
from .bearing_tables import RANGES as OF_BEARINGS
from .blocks.contacts import with_law
from .blocks.parts import JointLaw
from .file import OF_TIES, OWN_RANGES, bed_from
from .hull_tables import FIXED
from .model import Structure
from .neighbours import RANGES as OF_NEIGHBOURS

SIZE = "structure.size"
_WHOLE = ("g", "solver.tolerance")
_PARTS = re.compile(r"(block|joint|tie|bearing)(?:\[([^\[\]]+)\])?\.([a-z_]+)(?:\[([1-9])\])?")
_NEIGHBOURS = re.compile(r"neighbours\.(?:(pair)(?:\[([1-9]\d*)\])?\.)?([a-z_]+)")
_VECTORS = ("at", "position", "from", "to", "outline")  # points, m
# keys in m of every table; the points of a hull follow its scale
_LENGTHS = (
    frozenset.union(frozenset(_VECTORS), *map(lengths_in, (NUMBERS, OWN_RANGES, OF_TIES, OF_BEARINGS, OF_NEIGHBOURS)))
    - FIXED
)


# keys that exclude each other, and the one that stands for both
_SAME = {"mass": "density", "restitution": "damping"}
_OTHER = _SAME | {other: key for key, other in _SAME.items()}


class Named(NamedTuple):
    """A dotted name in its parts."""

    kind: str  # block, joint, tie or bearing
    which: str  # name or number; "" for all
    key: str  # of the table
    coordinate: int  # from 1; 0 for a scalar


def is_of_structure(name: str) -> bool:
    """Return True if a dotted name belongs to a structure."""
    return name in (*_WHOLE, SIZE) or _named(name) is not None or is_of_neighbours(name)


def is_of_neighbours(name: str) -> bool:
    """Return True if a dotted name belongs to the table `neighbours`."""
    return _NEIGHBOURS.fullmatch(name) is not None


def single_names_in_space(name: str, structure: Structure) -> list[str]:
    """Expand a name of several numbers: `joint.stiffness` to `joint[1].stiffness`, `joint[2].stiffness`, ...

    A name of one number is returned as it is.
    """
    of_neighbours = _NEIGHBOURS.fullmatch(name)
    if of_neighbours and of_neighbours[1] and not of_neighbours[2]:
        pairs = _pairs_of(structure.described or {})
        return [f"neighbours.pair[{k}].{of_neighbours[3]}" for k in range(1, len(pairs) + 1)]
    found = _named(name)
    if found is None or found.which:
        return [name]
    key = f"{found.key}[{found.coordinate}]" if found.coordinate else found.key
    return [f"{found.kind}[{k}].{key}" for k in range(1, len(_names(found.kind, structure)) + 1)]


def numbers_set_in_space(name: str, structure: Structure) -> list[str]:
    """Return the numbers that a name sets, of blocks and joints by their numbers.

    Those that exclude each other, mass and density, restitution and damping, are one number.
    """
    places = []
    for single in single_names_in_space(name, structure):
        found = _named(single)
        if found is not None and found.which in (names := _names(found.kind, structure)):
            single = single.replace(f"[{found.which}]", f"[{names.index(found.which) + 1}]", 1)
        before, _, key = single.rpartition(".")
        places.append(f"{before}.{_SAME.get(key, key)}" if before else key)
    return places


def unit_in_space(name: str) -> str:
    """Return "m" for the name of a length, else "": the reference of the file has the other units."""
    return "m" if name.rpartition(".")[2].partition("[")[0] in _LENGTHS else ""


def structure_with(structure: Structure, values: Mapping[str, tuple[float, bool]]) -> Structure:
    """Return the structure with other numbers, by name: the number, and whether it is a factor on the present value.

    The size is set first, then numbers, then factors. Raises InputError if a name or number is wrong.
    """
    if not values:
        return structure
    # laws of joints are set on the joints, which may come from several tables; all else in the file
    order = sorted(values, key=lambda name: (name != SIZE, values[name][1]))
    beds = {name for name in values if (found := _named(name)) is not None and found.kind == "joint"}
    if beds != values.keys():
        data = structure.to_dict()
        for name in order:
            if name not in beds:
                _set(data, structure, name, *values[name])
        structure = Structure.from_dict(data)
    joints = list(structure.joints)
    for name in order:
        if name in beds:
            for j in _which(name, structure):
                joints[j] = with_law(joints[j], _bed_with(joints[j].bed, name, *values[name]))
    return replace(structure, joints=tuple(joints), described=None) if beds else structure


@lru_cache(maxsize=1024)
def _named(name: str) -> Named | None:
    found = _PARTS.fullmatch(name)
    return None if found is None else Named(found[1], found[2] or "", found[3], int(found[4] or 0))


def _names(kind: str, structure: Structure) -> Sequence[str]:
    if kind == "tie":
        return [str(e) for e in range(1, len(structure.ties) + 1)]
    if kind == "bearing":
        tables = structure.described.get("bearing", []) if structure.described is not None else []
        return [str(k) for k in range(1, len(tables) + 1)]
    joints = structure.joint_names[: len(structure.joints) - len(structure.bearings)]
    return structure.names if kind == "block" else joints


def _which(name: str, structure: Structure) -> Sequence[int]:
    """Return the indices of what a name refers to. Raises UnknownKeyError if there is none."""
    found = _named(name)
    assert found is not None
    names = _names(found.kind, structure)
    if not found.which and names:
        return range(len(names))
    if found.which in names:
        return [names.index(found.which)]
    if found.which.isdigit() and 1 <= int(found.which) <= len(names):
        return [int(found.which) - 1]
    listed = f"{', '.join(names[:8])}{', ...' if len(names) > 8 else ''}" or "there is none"
    raise UnknownKeyError(f"{name}: no such {found.kind}, must be one of {listed}, or a number from 1 to {len(names)}")


def _set(data: dict[str, Any], structure: Structure, name: str, number: float, relative: bool) -> None:
    found, of_neighbours = _named(name), _NEIGHBOURS.fullmatch(name)
    if of_neighbours:
        _set_neighbour_number(data, name, of_neighbours, number, relative)
    elif name == SIZE:
        resize(data, check_number(name, number, POSITIVE, "a positive number"))
    elif found is None:
        table, key = (data, "g") if name == "g" else (data.setdefault("solver", {}), "tolerance")
        table.setdefault(key, structure.g if name == "g" else structure.tolerance)
        table[key] = varied(name, table[key], number, relative)
    else:
        for place in _which(name, structure):
            _put(data[found.kind][place], name, found, number, relative)


def _put(table: dict[str, Any], name: str, found: Named, number: float, relative: bool) -> None:
    if table.get("shape") == "hull":
        if found.key in FIXED:
            raise InputError(
                f"{name}: no study varies it, must be mass, density, scale, at or position of a hull or mesh"
            )
        table.setdefault("scale", 1.0)
    if not found.coordinate:
        table[found.key] = varied(name, table.get(found.key), number, relative)
        if not relative:
            table.pop(_OTHER.get(found.key, ""), None)
        return
    point = table.get(found.key)
    if not isinstance(point, list) or found.coordinate > len(point):
        raise InputError(f"{name}: must be a coordinate that the file has")
    point[found.coordinate - 1] = varied(name, point[found.coordinate - 1], number, relative)


def _set_neighbour_number(data: dict[str, Any], name: str, found: re.Match[str], number: float, relative: bool) -> None:
    """Set a number of the table `neighbours`, of one of its pairs, or of all of them."""
    tables = _pairs_of(data) if found[1] else [data["neighbours"]] if "neighbours" in data else []
    if found[2]:
        tables = tables[int(found[2]) - 1 :][:1]
    if not tables:
        raise UnknownKeyError(f"{name}: no such table, must be in the file, [[neighbours.pair]] by its number from 1")
    key = found[3]
    for table in tables:
        table[key] = varied(name, table.get(key), number, relative)
        table.pop(_OTHER.get(key, ""), None)


def _pairs_of(data: Mapping[str, Any]) -> Sequence[dict[str, Any]]:
    """Return the tables of the pairs in the mapping of a structure's file."""
    pairs: Sequence[dict[str, Any]] = data.get("neighbours", {}).get("pair", [])
    return pairs


def _bed_with(bed: JointLaw, name: str, number: float, relative: bool) -> JointLaw:
    found = _named(name)
    assert found is not None
    law = {key: value for key, value in asdict(bed).items() if value is not None}
    if found.coordinate or (found.key not in law and found.key not in asdict(bed)):
        raise InputError(f"{name}: unknown name, must be of the law of a joint: {', '.join(asdict(bed))}")
    return bed_from(name.rpartition(".")[0], {**law, found.key: varied(name, law.get(found.key), number, relative)})


def resize(data: dict[str, Any], factor: float) -> None:
    """Multiply the lengths in the mapping of a structure's file by a factor, and masses by its cube."""
    for block in data.get("block", []):
        if block.get("shape") == "hull":
            block.setdefault("scale", 1.0)
    data.update(resized(data, factor, _LENGTHS | {"scale"}, {"mass": 3}))
