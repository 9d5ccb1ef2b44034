"""Ports: points of blocks at which loads act and whose motion is an output (ground/loads.py)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..common.errors import InputError, shown
from ..common.ranges import check_choice
from ..common.tables import check_table
from ..ground.records.record import FloatArray

KEYS = ("name", "block", "at")
Point = Callable[[str, object, int], Sequence[float]]  # of the key, the value (None if absent) and the block's index


@dataclass(frozen=True)
class Port:
    """A point of a block at which loads act, and whose motion is an output."""

    name: str
    body: int  # index of the block, from 0
    # m, from its centroid: x, y, z along the axes of the base, as built; in the plane x, z along those of the block
    at: tuple[float, ...]


class Released(NamedTuple):
    """An initial state: rest under loads on the ports, (6, ports) N and N m, which are removed at the start."""

    loads: FloatArray


def ports_from(data: Mapping[str, Any], names: Sequence[str], point: Point) -> tuple[Port, ...]:
    """Read the ports in the tables `port` of a file, on blocks of these names; `point` makes coordinates (m) of `at`.

    Raises InputError if a table or name is invalid.
    """
    found: dict[str, Port] = {}
    tables = data.get("port", [])
    if not isinstance(tables, list):
        raise InputError("port: must be one table [[port]] for each")
    for number, table in enumerate(tables, start=1):
        key = f"port[{number}]"
        check_table(f"{key}.", table, KEYS)
        # a unique printable name without separators, on a known block
        name = table.get("name")
        if not isinstance(name, str) or not name or not name.isprintable() or set(name) & set('[].=,"'):
            raise InputError(f'{key}.name = {shown(name)}: must be a word that can be printed, without [ ] . = , and "')
        if name in found:
            raise InputError(f"{key}.name = {shown(name)}: must be another name, it is taken")
        check_choice(f"{key}.block", table.get("block"), names)
        body = names.index(table["block"])
        found[name] = Port(name, body, tuple(point(f"{key}.at", table.get("at"), body)))
    return tuple(found.values())
