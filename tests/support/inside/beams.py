"""Runs inside a process of its own: a beam on the ports of two FMUs of columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from support.beam import Column, Seen, coupled, thrown
from support.instance import Instance


def on_fmu(fmu: str) -> Column:
    """Return the first port of an FMU of its own."""
    body, time = Instance(fmu), [0.0]
    names = [f"port[1].{name}" for name in ("x", "z", "vx", "vz", "ax", "az")]

    def see() -> Seen:
        values = [float(value) for value in body.get(*names)]
        return Seen(*np.reshape(values, (3, 2)))

    def push(force: Any, slope: Any, h: float) -> None:
        body.set({"port[1].Fx": force[0], "port[1].Fz": force[1], "port[1].dFx": slope[0], "port[1].dFz": slope[1]})
        body.step(time[0], h)
        time[0] += h

    return see, push


def on_two(one: str, other: str, h: float, steps: int, output: str) -> None:
    """Return the places of the ports of two FMUs, saved."""
    np.save(output, coupled(thrown(), [on_fmu(one), on_fmu(other)], h, steps))
