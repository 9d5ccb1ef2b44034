"""The start of an FMU on an account: with Python and numpy alone, and whatever folders can be written to."""

from __future__ import annotations

import pathlib
import sys
from typing import NoReturn

from support.instance import Instance, unpacked

COMPILERS = ("numba", "llvmlite")


def _read_only(*_: object, **__: object) -> NoReturn:
    raise PermissionError(13, "read-only")


def both(column: str, structure: str) -> list[bool]:
    """Return the step two FMUs in one process, the first of which is gone when the second starts; whether each has
    moved.
    """
    for name in COMPILERS:
        sys.modules[name] = None  # type: ignore[assignment]
    moved = []
    for fmu in (column, structure, column):
        body = Instance(fmu, {"base.ax": 0.5})
        body.step(0.0, 0.01)
        moved.append(body.get("block[1].ux")[0] != 0.0)
        body.close()
    return moved


def start(fmu: str, hindrance: str = "", record: str = "") -> float:
    """Return a displacement after a step, where neither numba nor llvmlite is installed.

    hindrance: "read-only", no folder can be made. record: path of one to follow, or none.
    """
    for name in COMPILERS:
        sys.modules[name] = None  # type: ignore[assignment]
    folder = unpacked(fmu)
    if hindrance == "read-only":
        pathlib.Path.mkdir = _read_only  # type: ignore[method-assign]
    column = Instance(fmu, {"base.ax": 0.5, "base.record": record}, folder=folder)
    column.step(0.0, 0.1)
    ux = float(column.get("block[1].ux")[0])
    column.close()
    return ux


def extremes_before_a_step(fmu: str) -> tuple[dict[str, tuple[float, float]], bool]:
    """Return each output that has an extreme, with it, before the first step; whether a step ends as one without.

    Outputs are read before under another motion of the base.
    """
    body, other = Instance(fmu), Instance(fmu)
    found = {}
    for moves in (0.1, 0.0):
        body.set({name: moves for name in ("base.ax", "base.theta") if name in body.variables})
        for name in body.variables:
            output, _, extreme = name.rpartition("_")
            if extreme in ("peak", "least") and output in body.variables:
                found[name] = tuple(body.get(output, name))
    for each in (body, other):
        each.step(0.0, 0.01)
    return found, body.get() == other.get()
