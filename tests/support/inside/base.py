"""A base that rotates, and the split of its reaction."""

from __future__ import annotations

import math
from typing import Any

from support.instance import Instance

SPLIT = tuple(f"base.{name}" for name in ("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt"))
REACTION = ("base.Fx", "base.Fz", "base.My")


def follow(column: Instance, first: int, last: int, h: float = 5e-3) -> None:
    """Push and rotate the base."""
    for k in range(first, last):
        t = k * h
        column.set(
            {
                "base.ax": math.sin(12.0 * t),
                "base.theta": 1e-3 * math.sin(9.0 * t),
                "base.omega": 9e-3 * math.cos(9.0 * t),
                "base.alpha": -81e-3 * math.sin(9.0 * t),
            }
        )
        column.step(t, h)


def reactions(fmu: str, accelerations: list[tuple[float, float, float]], turned: float) -> list[list[float]]:
    """Return the reaction and split under some (ax, az, alpha) of one instant, and with the base turned."""
    column = Instance(fmu)
    follow(column, 0, 60)
    seen = []
    for ax, az, alpha in accelerations:
        column.set({"base.ax": ax, "base.az": az, "base.alpha": alpha})
        seen.append(column.get(*REACTION, *SPLIT))
    column.set({"base.theta": turned})
    return [*seen, column.get(*REACTION, *SPLIT)]


def restored(fmu: str) -> dict[str, Any]:
    """Return a column that begins on a turned base, and goes on from a state on one that rotates."""
    column = Instance(fmu, {"base.theta": 4e-4})
    start = column.get("block[1].theta", "joint[3].M")
    column.set({"base.theta": 0.0})
    follow(column, 0, 40)
    saved = column.fmi.getFMUState()
    follow(column, 40, 80)
    first = column.get()
    column.fmi.setFMUState(column.fmi.deSerializeFMUstate(column.fmi.serializeFMUstate(saved)))
    follow(column, 40, 80)
    same = column.get() == first
    column.set({"base.omega": math.nan})
    return {
        "start": start,
        "same": same,
        "moved": abs(first[0]) > 1e-4,
        "no number": column.attempt("step", 0.4, 0.01),
        "end": column.attempt("close"),
    }


def paper_that_rotates(fmu: str) -> list[str]:
    """Return what an FMU of the formulation `paper` answers while the base rotates, and afterwards."""
    column = Instance(fmu)
    column.set({"base.omega": 1e-3})
    heard = [column.attempt("step", 0.0, 0.01)]
    column.set({"base.omega": 0.0})
    return [*heard, column.attempt("step", 0.0, 0.01)]
