"""FMUs of columns with ports: a base that a body drives beside loads, states, derivatives by loads and of outputs."""

from __future__ import annotations

from math import sin
from typing import Any

import numpy as np

from support.inside import states
from support.inside.native import directional, rates_of
from support.inside.states import bits
from support.instance import Instance

H = 5e-3  # s
PORT = [f"port[1].{name}" for name in ("x", "z", "vx", "vz", "ax", "az")]
SEEN = [*PORT, "base.Fx", "base.Fz", "base.My", "joint[2].T", "base.R0x"]


def push(body: Instance, t: float) -> None:
    """Set loads and accelerations of the base, or what a body at it says, with slopes."""
    body.set({"port[1].Fx": 2e4 * sin(9.0 * t), "port[1].dFx": 1e5 * sin(3.0 * t), "port[2].Fz": -1e4 * sin(t)})
    body.set({"port[1].My": 5e3, "base.ax": sin(11.0 * t), "base.jx": 4.0, "base.az": 0.2})
    if "body.Mxx" in body.variables:
        body.set({"body.F0x": 1e4 * sin(8.0 * t), "body.Mxx": 5e4, "body.Mzz": 5e4, "body.Mtt": 1e5})


def pushed(body: Instance, first: int, last: int) -> list[Any]:
    """Return all outputs after steps."""
    for k in range(first, last):
        push(body, H * k)
        body.step(H * k, H)
    return body.get()


def life(fmu: str) -> dict[str, bool]:
    """Return outputs over the life of a state, and of another gravity."""
    return states.life(fmu, pushed, 60, {"g": 9.0})


def follow(fmu: str, output: str) -> None:
    """Return all outputs after each step, saved as an array."""
    body = Instance(fmu)
    np.save(output, np.array([[float(value) for value in pushed(body, k, k + 1)] for k in range(200)]))


def derivatives(fmu: str) -> tuple[list[float], list[float]]:
    """Return derivatives of outputs over time, and central differences, amid loads with slopes."""
    body, h = Instance(fmu, {"solver.tolerance": 1e-11}), 1e-5
    pushed(body, 0, 100)
    push(body, 100 * H)
    return rates_of(body, SEEN, 100 * H, h)


def by_inputs(fmu: str, seeds: dict[str, float]) -> tuple[list[float], list[float], bool]:
    """Return the directional derivatives of outputs, what they change by as the inputs do, and whether asking changed
    nothing.
    """
    body = Instance(fmu, {"solver.tolerance": 1e-9})
    pushed(body, 0, 100)
    push(body, 100 * H)
    state = body.fmi.getFMUState()
    found = directional(body, SEEN, list(seeds), list(seeds.values()))
    before = body.get(*SEEN)
    end = bits(pushed(body, 100, 110))
    body.fmi.setFMUState(state)
    same = bits(pushed(body, 100, 110)) == end
    body.fmi.setFMUState(state)
    body.set({name: body.get(name)[0] + by for name, by in seeds.items()})
    after = body.get(*SEEN)
    return found, [b - a for a, b in zip(before, after, strict=True)], same
