"""Communication steps of any length until 4 s."""

from __future__ import annotations

import random
from math import sin
from typing import Any

from support.instance import Instance


def plan(kind: str) -> list[float]:
    """Return the lengths of the steps, s: a name, or one number."""
    some = random.Random(5)
    if kind == "whole":
        return [4.0]
    if kind == "uneven":  # from a microsecond to a third of a second
        steps = [10.0 ** some.uniform(-6.0, -0.5) for _ in range(45)]
        while sum(steps) >= 3.999:
            steps.pop()
        return [*steps, 4.0 - sum(steps)]
    if kind == "slivers":
        return [0.1 - 1e-6, 1e-6] * 40
    if kind == "microseconds":  # while the column rocks
        return [1.5, *[1e-6] * 20000, 4.0 - 1.52]
    return [float(kind)] * round(4.0 / float(kind))


def follow(fmu: str, values: dict[str, Any], kinds: tuple[str, ...], tries: bool = False) -> list[list[float]]:
    """Return the displacement and shear of the top at the end of each plan.

    tries: before each step another one is made and taken back.
    """
    ends = []
    for kind in kinds:
        column, some, t = Instance(fmu, values), random.Random(7), 0.0
        for h in plan(kind):
            if tries:
                saved = column.fmi.getFMUState()
                column.step(t, h * some.uniform(0.01, 2.0))
                column.get()
                column.fmi.setFMUState(saved)
                column.fmi.freeFMUState(saved)
            column.step(t, h)
            t += h
        ends.append(column.get("block[1].ux", "joint[1].S"))
    return ends


def too_long(fmu: str, values: dict[str, Any], lengths: list[float]) -> tuple[list[str], bool]:
    """Return the answers to steps that no call makes; whether outputs are as before, and a step of 0.01 s is made after
    it.
    """
    body = Instance(fmu, values)
    body.step(0.0, 0.1)
    before = body.get()
    heard = [body.attempt("step", 0.1, h) for h in lengths]
    same = body.get() == before
    body.step(0.1, 0.01)
    body.close()
    return heard, same


def alternating(fmu: str, name: str, grows: float, iterated: bool = False) -> None:
    """Step under an acceleration that changes its sign at each of them and grows by a factor, on a slow wave.

    iterated: each is made twice from the same state.
    """
    body, size = Instance(fmu, {}), 1e-5
    for k in range(100):
        body.set({name: (-1.0) ** k * size + 1e-3 * k})
        saved = body.fmi.getFMUState()
        body.step(0.01 * k, 0.01)
        if iterated:
            body.fmi.setFMUState(saved)
            body.step(0.01 * k, 0.01)
        body.fmi.freeFMUState(saved)
        size = min(0.5, size * grows)
    body.close()


def peaks(fmu: str, sliver: float, values: dict[str, Any]) -> list[float]:
    """Return all peaks after 0.6 s of steps that a step of `sliver` s follows; 0: none."""
    body, t = Instance(fmu, values), 0.0
    names = [name for name in body.variables if name.endswith("_peak")]
    for k in range(30):
        body.set({"base.ax": 3.0 * sin(0.5 * k)})
        body.step(t, 0.02)
        t += 0.02
        if sliver:
            body.step(t, sliver)
            t += sliver
    return [float(value) for value in body.get(*names)]
