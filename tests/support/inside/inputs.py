"""The effects of base inputs on an FMU: held inputs, slopes, records."""

from __future__ import annotations

import math
from typing import Any

from support.instance import Instance


def history(fmu: str, values: dict[str, Any], way: str, h: float, part: float = 1.0) -> list[float]:
    """Return block[1].ux every 0.1 s until 1.6 s.

    way: how the harmonic, times `part`, is handed over: "held", "linear", "none".
    """

    def a(k: int) -> float:
        return part * 0.6 * math.sin(4.0 * math.pi * k * h)

    column, seen = Instance(fmu, values), []
    for k in range(round(1.6 / h)):
        if way == "held":
            column.set({"base.ax": a(k)})
        elif way == "linear":
            column.set({"base.ax": a(k), "base.jx": (a(k + 1) - a(k)) / h})
        column.step(k * h, h)
        if (k + 1) % round(0.1 / h) == 0:
            seen += column.get("block[1].ux")
    return seen


def record_inside(fmu: str, values: dict[str, Any], elsewhere: str) -> dict[str, Any]:
    """Return the histories at steps of 0.1 s with the record inside, half of it, none, and one from a path."""
    half = values | {"base.record_scale": 0.5}
    path = values | {"base.record": elsewhere}
    return {
        "inside": history(fmu, values, "none", 0.1),
        "pga": Instance(fmu, values).get("base.record_pga")[0],
        "half": history(fmu, half, "none", 0.1),
        "half pga": Instance(fmu, half).get("base.record_pga")[0],
        "without": history(fmu, values | {"base.record": ""}, "none", 0.1),
        "by path": history(fmu, path, "none", 0.1),
    }


def slopes(fmu: str) -> list[float]:
    """Return the shear at the base as inputs and a parameter, to its own value, are set and left alone."""
    column = Instance(fmu, {"base.ax": 0.5, "base.jx": 10.0})
    heard = column.get("joint[3].S")
    column.step(0.0, 0.05)
    for change in ({}, {"g": 9.80665}, {"base.ax": 1.0}, {"base.jx": 0.0}, {"base.ax": 0.5}):
        column.set(change)
        heard += column.get("joint[3].S")
    return heard


def ten_steps(fmu: str, values: dict[str, Any], h: float, logging: bool) -> None:
    """Return a short run, for what is logged."""
    column = Instance(fmu, values, loggingOn=logging)
    for k in range(10):
        column.step(k * h, h)
    column.close()


def wrong_record(fmu: str, record: str) -> str:
    """Return what initialization answers; fails unless the instance works without the record afterwards."""
    column = Instance(fmu, {"base.record": record}, initialize=False)
    heard = column.attempt("initialize")
    column.fmi.reset()
    column.initialize()
    return heard


def whole_history(fmu: str, values: dict[str, Any], h: float) -> list[Any]:
    """Return all outputs at every step until 1.8 s."""
    column = Instance(fmu, values)
    seen = column.get()
    for k in range(round(1.8 / h)):
        column.step(k * h, h)
        seen += column.get()
    column.close()
    return seen
