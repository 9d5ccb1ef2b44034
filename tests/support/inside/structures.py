"""FMUs of structures in space."""

from __future__ import annotations

from itertools import pairwise
from math import sin
from typing import Any

import numpy as np
from fmpy import simulate_fmu

from support.inside import states
from support.inside.native import directional
from support.inside.states import bits
from support.instance import Instance

AXES = "xyz"


def follow(fmu: str, samples: list[list[float]], h: float, values: dict[str, Any], output: str) -> None:
    """Return all outputs after each step of h s under samples of three components that lines join; saved as an
    array.
    """
    body, seen = Instance(fmu, values), []
    for k, (now, then) in enumerate(pairwise(samples)):
        for axis, a, b in zip(AXES, now, then, strict=True):
            body.set({f"base.a{axis}": a, f"base.j{axis}": (b - a) / h})
        body.step(k * h, h)
        seen.append([float(value) for value in body.get()])
    np.save(output, np.array(seen))
    body.close()


def follow_inputs(fmu: str, samples: dict[str, list[float]], slopes: dict[str, str], h: float, output: str) -> None:
    """Return all outputs after each step of h s under samples of inputs that lines join; saved as an array."""
    body, seen = Instance(fmu), []
    for k in range(len(next(iter(samples.values()))) - 1):
        body.set({name: values[k] for name, values in samples.items()})
        body.set({slopes[name]: (values[k + 1] - values[k]) / h for name, values in samples.items()})
        body.step(k * h, h)
        seen.append([float(value) for value in body.get()])
    np.save(output, np.array(seen))
    body.close()


def simulate(fmu: str, duration: float, h: float, values: dict[str, Any], output: str) -> None:
    """Return the table of a run of FMPy's own without inputs, of an FMU with a record inside."""
    result = simulate_fmu(fmu, stop_time=duration, output_interval=h, start_values=values)
    np.save(output, np.asarray(result))


def shaken(body: Instance, first: int, last: int) -> list[Any]:
    """Return all outputs after steps that differ from one to the next, hard enough to rock and slide."""
    t = sum(1e-3 * (1 + k % 7) for k in range(first))
    for k in range(first, last):
        h = 1e-3 * (1 + k % 7)
        body.set({"base.ax": 2.5 * sin(9.0 * t), "base.ay": 1.0 * sin(7.0 * t), "base.jx": 5.0 * sin(3.0 * t)})
        body.step(t, h)
        t += h
    return body.get()


def life(fmu: str) -> dict[str, bool]:
    """Return outputs over the life of a state, and of another damping."""
    return states.life(fmu, shaken, 100, {"joints.damping_scale": 3.0})


def refused(fmu: str) -> list[str]:
    """Return the answers to wrong parameters and steps; an instance lives on after each."""
    answers = []
    for name, value in (
        ("joints.damping_scale", -1.0),
        ("solver.tolerance", 7.0),
        ("solver.without", "peeks"),
        ("base.record_scale", float("nan")),
    ):
        body = Instance(fmu, {name: value}, initialize=False)
        body.fmi.setupExperiment()
        body.fmi.enterInitializationMode()
        answers.append(body.attempt("exitInitializationMode"))
    body = Instance(fmu)
    for values in ({"base.ay": float("inf")}, {"base.ay": 2e6}, {"base.ay": 1.0, "base.jy": 1e12}):
        body.set(values)
        answers.append(body.attempt("step", 0.0, 0.01))
        body.set({"base.ay": 0.0, "base.jy": 0.0})
    answers += [body.attempt("step", 0.5, 0.01), body.attempt("step", 0.0, 0.01)]
    return answers


def fall(fmu: str) -> list[Any]:
    """Return the verdict before and after a push that overturns, and after one more step; whether outputs are held."""
    names = ("overturned", "overturn_time", "overturned_block", "verdict")
    body = Instance(fmu)
    body.step(0.0, 0.01)
    found = [body.get(*names)]
    body.set({"base.ax": 6.0})
    body.step(0.01, 5.0)
    found.append(body.get(*names))
    before = bits(body.get())
    body.step(5.01, 1.0)
    return [*found, bits(body.get()) == before]


def rates(fmu: str) -> tuple[list[float], list[float]]:
    """Return the derivatives of all continuous outputs by the FMU, and central differences of them, of a native FMU."""
    from support.inside.native import rates_of

    body, h = Instance(fmu, {"solver.tolerance": 1e-10}), 1e-6
    shaken(body, 0, 100)
    t = sum(1e-3 * (1 + k % 7) for k in range(100))
    body.set({"base.ax": 1.0, "base.ay": 0.0, "base.jx": 0.0})
    kinds = {name: (item.causality, item.variability) for name, item in body.variables.items()}
    names = [name for name, kind in kinds.items() if kind == ("output", "continuous")]
    return rates_of(body, names, t, h)


def thrown(body: Instance, first: int, last: int) -> list[Any]:
    """Return all outputs after steps of 20 ms, under a push of 0.6 s that throws a slender block over."""
    for k in range(first, last):
        body.set({"base.ax": 4.0 if k < 30 else 0.0})
        body.step(0.02 * k, 0.02)
    return body.get()


def life_of_a_fall(fmu: str) -> dict[str, bool]:
    """Return outputs over the life of a state, taken while a block falls, and of another damping."""
    return states.life(fmu, thrown, 60, {"joints.damping_scale": 3.0})


def held(fmu: str, steps: int) -> dict[str, Any]:
    """Return the acceleration of a port in the last steps of 10 ms under a late load, its peak and derivatives."""
    body, shown = Instance(fmu), []
    for k in range(steps):
        if k > 0.75 * steps:
            body.set({"port[1].Fx": 1e4, "base.ax": 2.0})
        body.step(0.01 * k, 0.01)
        if k > 0.75 * steps:
            shown.append(float(body.get("port[1].ax")[0]))
    derivatives = directional(body, ["port[1].ax"], ["base.ax"], [1.0])
    derivatives += directional(body, ["port[1].ax"], ["port[1].Fx"], [1.0])
    return {"shown": shown, "peak": float(body.get("port[1].ax_peak")[0]), "derivatives": derivatives}
