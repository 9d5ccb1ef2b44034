"""FMUs of columns with ports: a base that a body drives beside loads, states, derivatives by loads and of outputs."""

from __future__ import annotations

from ctypes import c_double, c_int
from math import sin
from typing import Any

import numpy as np

from support.inside.native import directional, references
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
    """All outputs after steps."""
    for k in range(first, last):
        push(body, H * k)
        body.step(H * k, H)
    return body.get()


def life(fmu: str) -> dict[str, bool]:
    """State kept, serialized, set elsewhere; reset; another gravity."""
    body = Instance(fmu)
    first = bits(body.get())
    pushed(body, 0, 60)
    saved = body.fmi.getFMUState()
    data = body.fmi.serializeFMUstate(saved)
    end = bits(pushed(body, 60, 120))
    body.fmi.setFMUState(saved)
    found = {"further on": bits(pushed(body, 60, 120)) == end}
    body.fmi.setFMUState(saved)
    body.set({"g": 9.0})
    found["gravity acts"] = bits(pushed(body, 60, 120)) != end
    other = Instance(fmu, initialize=False)
    other.fmi.setFMUState(other.fmi.deSerializeFMUstate(data))
    found["elsewhere"] = bits(pushed(other, 60, 120)) == end
    body.fmi.reset()
    body.initialize()
    found["reset"] = bits(body.get()) == first
    found["again"] = bits(pushed(body, 0, 120)) == end
    return found


def follow(fmu: str, output: str) -> None:
    """All outputs after each step, saved as an array."""
    body = Instance(fmu)
    np.save(output, np.array([[float(value) for value in pushed(body, k, k + 1)] for k in range(200)]))


def derivatives(fmu: str) -> tuple[list[float], list[float]]:
    """Of outputs over time, and central differences, amid loads with slopes."""
    body, h = Instance(fmu, {"solver.tolerance": 1e-11}), 1e-5
    pushed(body, 0, 100)
    push(body, 100 * H)
    state, seen = body.fmi.getFMUState(), []
    body.step(100 * H, h)
    values = (c_double * len(SEEN))()
    one = references(body, *SEEN), len(SEEN), (c_int * len(SEEN))(*[1] * len(SEEN)), values
    assert body.fmi.dll.fmi2GetRealOutputDerivatives(body.fmi.component, *one) == 0
    for length in (0.0, 2 * h):
        body.fmi.setFMUState(state)
        if length:
            body.step(100 * H, length)
        seen.append(body.get(*SEEN))
    return list(values), [(b - a) / (2 * h) for a, b in zip(*seen, strict=True)]


def by_inputs(fmu: str, seeds: dict[str, float]) -> tuple[list[float], list[float], bool]:
    """Directional derivatives of outputs, what they change by as the inputs do, and whether asking changed nothing."""
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
