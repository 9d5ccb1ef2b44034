"""Every directional derivative of an FMU beside differences of its own outputs."""

from __future__ import annotations

import re
from math import sin
from typing import Any

from support.inside.native import Pair, directional, rates_of
from support.instance import Instance

H = 5e-3  # s, a step
OWN_PART = 0.01  # of a probe: what the FMU's own differences are over, by the rotation of the base
EPSILON, SMALLEST = 1e-15, 1.0  # of an output, and of outputs that are differences of lengths
Row = tuple[str, str, float, float, float]
# input -> amplitude, probe: half the distance of the two values between which outputs are differenced
USUAL = {
    r"base\.a[xyz]$": (1.5, 1.0),
    r"base\.j[xyz]$": (5.0, 1.0),
    r"base\.theta.*": (1e-4, 1e-7),
    r"base\.omega.*": (2e-3, 1e-5),
    r"base\.alpha.*": (0.05, 1.0),
    r"port\[\d+\]\.d?[FM]\w*": (2e3, 100.0),
    r"body\d*\.F0\w*": (5e3, 100.0),
    r"body\d*\.(M|Mxx|Mzz|Mtt|Jxx|Jyy)$": (0.0, 10.0),
    r"body\d*\.(Mxz|Mxt|Mzt|Mxry|Myrx|Jxy)$": (0.0, 10.0),
}


def _usual(name: str) -> tuple[float, float]:
    return next(value for pattern, value in USUAL.items() if re.fullmatch(pattern, name))


def rates_after_a_fall(fmu: str, held: dict[str, float], steps: int) -> list[Pair]:
    """Return the rates of outputs under held inputs after some steps, and differences over 10 us, three times."""
    body, found = Instance(fmu, {"solver.tolerance": 1e-9}), []
    outputs = [
        name for name in body.variables if re.fullmatch(r"block\[\d+\]\.(u[xyz]|theta|r[xyz])|port\[\d+\]\.v[xz]", name)
    ]
    body.set(held)
    for k in range(steps):
        body.step(H * k, H)
    t = H * steps
    for _ in range(3):
        found.append(rates_of(body, outputs, t, 1e-5))
        body.step(t + 2e-5, H)
        t += 2e-5 + H
    return found


def rates_while_cracking(fmu: str, outputs: list[str]) -> list[Pair]:
    """Return the rates of outputs and differences over 2 us, while the base acceleration grows by 20 m/s3, thrice."""
    found = []
    for t in (0.14, 0.16, 0.18):
        body = Instance(fmu, {"solver.tolerance": 1e-10})
        body.set({"base.jx": 20.0})
        body.step(0.0, t)
        body.set({"base.ax": 20.0 * t})
        found.append(rates_of(body, outputs, t, 1e-6))
        body.close()
    return found


def compare(fmu: str, start: dict[str, Any], mass: dict[str, float], steps: int) -> tuple[list[Row], bool]:
    """Return what every continuous output changes by with every input, after some steps; whether it has overturned.

    Rows are (output, input, derivative, difference, rounding). mass: inputs that are held, those of bodies at the base.
    """
    body = Instance(fmu, {"solver.tolerance": 1e-9, **start})
    names = [name for name, item in body.variables.items() if item.causality == "input" and item.type == "Real"]
    outputs = [
        name
        for name, item in body.variables.items()
        if item.causality == "output" and item.type == "Real" and item.variability == "continuous"
    ]

    def push(k: int) -> None:
        wave = {name: _usual(name)[0] * sin(0.1 * (1.0 + 0.07 * i) * k + i) for i, name in enumerate(names)}
        body.set(wave | mass)

    for k in range(steps):
        push(k)
        body.step(H * k, H)
    push(steps)
    found = []
    for name in names:
        derivatives = directional(body, outputs, [name], [1.0])
        at, probe, seen = body.get(name)[0], _usual(name)[1], []
        for value in (at - probe, at + probe):
            state = body.fmi.getFMUState()
            body.set({name: value})
            seen.append(body.get(*outputs))
            body.fmi.setFMUState(state)
            body.fmi.freeFMUState(state)
        for output, derivative, low, high in zip(outputs, derivatives, *seen, strict=True):
            rounding = EPSILON * max(abs(low), abs(high), SMALLEST) / (OWN_PART * probe)
            found.append((output, name, derivative, (high - low) / (2.0 * probe), rounding))
    return found, bool(body.get("overturned")[0])
