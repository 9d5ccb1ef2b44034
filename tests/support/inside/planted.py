"""Kernels that reach out of their rows, for processes with checks of bounds."""

from __future__ import annotations

import os
import sys
from typing import NamedTuple

import numpy as np

from solver.kernels.numba_ext.jit import from_python, kernel
from solver.kernels.numba_ext.views import (
    FieldTable,
    Numbers,
    Record,
    Space,
    clear,
    copy,
    lanes_of,
    one_lane,
    packs_of,
    row_of,
)
from solver.kernels.structure.bed import Plane
from solver.kernels.structure.cracking import _grows

SPACE = Space(head=Record("first", "second"), table=FieldTable("a", "b"), more=Numbers(per_n=2, beside=1))
_over, _over_begin = SPACE.over, SPACE.over_begin
SIZE = 5 * 8  # numbers of the array, in lanes 5 elements; the space takes 15 of them


@kernel
def _element(row, i):
    return row[i]


@from_python
def read(array, n, i):
    """Read an element of the field a; the field b lies behind it."""
    return _element(_over(row_of(array), n).table.a, i)


@from_python
def write(array, n, i):
    """Write an element of the last part."""
    _over(row_of(array), n).more[i] = 1.0
    return 0.0


@from_python
def read_from(array, begin, i):
    """Read an element of the rest of a row."""
    return row_of(array)[begin:][i]


@from_python
def read_between(array, begin, i):
    """Read an element of a part of eight numbers."""
    return row_of(array)[begin : begin + 8][i]


@from_python
def read_lanes(array, i, k):
    """Read a number of lane k of a row of lanes."""
    return one_lane(lanes_of(array), k)[i]


@from_python
def write_lanes(array, i, k):
    """Write all lanes of an element of a row of lanes."""
    lanes = lanes_of(array)
    lanes[i] = lanes[k] + 1.0
    return 0.0


@from_python
def add_packs(array, n, i):
    """Add to eight numbers of the field b at once, of which the last reach into what is behind it."""
    packs = packs_of(_over(row_of(array), n).table.b)
    packs[i] = packs[i] + 1.0
    return 0.0


@from_python
def copy_some(array, begin, count):
    """Copy from the beginning of the array to further on."""
    copy(row_of(array)[begin:], row_of(array), count)
    return 0.0


@from_python
def clear_some(array, n, count):
    """Clear the beginning of a space, of names that are laid over a part of the array."""
    clear(_over_begin(row_of(array)[:12], n).row, count)
    return 0.0


class Room(NamedTuple):
    """The members of a structure that `_grows` reads."""

    room: object


@from_python
def crack_front(array, corners, i):
    """Return True if a crack grows in the rest of a bond, which has no corners once it has broken."""
    tip = Plane(array[i] - 2.0, 1.0, 0.0)
    return 1.0 if _grows(Room(row_of(array)), corners, tip, tip, 0.0) else 0.0


FUNCTIONS = {
    function.__name__: function
    for function in (
        read, write, read_from, read_between, read_lanes, write_lanes, add_packs, copy_some, clear_some, crack_front,
    )
}  # fmt: skip


def results(calls: list[tuple[str, int, int]]) -> list[list[float]]:
    """Return for each call its result and the array after it, which is the same before each."""
    found = []
    for name, *arguments in calls:
        array = np.sqrt(np.arange(SIZE) + 1.0)
        found.append([FUNCTIONS[name](array, *arguments), *array.tolist()])
    return found


def ends(calls: list[tuple[str, int, int]], before: list[tuple[str, int, int]]) -> list[tuple[int, str]]:
    """Return how a process of its own ends that makes each call: its signal, 0 of none, and what it prints.

    before: calls that this process makes first, so that everything is compiled.
    """
    results(before)
    found = []
    for name, *arguments in calls:
        reads, writes = os.pipe()
        child = os.fork()
        if not child:
            os.dup2(writes, 2)
            FUNCTIONS[name](np.zeros(SIZE), *arguments)
            os._exit(0)
        os.close(writes)
        with open(reads, encoding="utf-8") as said:
            text = said.read()
        _, status = os.waitpid(child, 0)
        found.append((os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0, text))
    return found


def short_array() -> None:
    """Call an entry with an array that is shorter than the others."""
    from solver.kernels.column.api import entries

    edges, radii, found = np.zeros(4), np.ones(4), np.zeros(4)
    entries.rings_beyond(radii, np.zeros(4), edges, found, np.zeros(4))
    print("as long", file=sys.stderr, flush=True)
    entries.rings_beyond(radii, np.zeros(4), edges, found[:3].copy(), np.zeros(4))
