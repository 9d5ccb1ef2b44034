"""The capabilities of the native FMU alone, and its bits against those of the other."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from math import sin
from typing import Any

from fmpy.fmi2 import fmi2Integer, fmi2Real, fmi2ValueReference

from support.inside.base import SPLIT
from support.inside.guarded import last_step
from support.inside.neighbours import resident
from support.instance import Instance

OUTPUTS = [
    f"{owner}[{i}].{name}"
    for i in (1, 2, 3)
    for owner, names in (("block", ("ux", "uz", "theta")), ("joint", ("N", "M", "S", "T")))
    for name in names
] + ["base.Fx", "base.Fz", "base.My"]
Pair = tuple[list[float], list[float]]


def compare(first: str, second: str, values: Sequence[dict[str, Any]]) -> list[tuple[bool, float]]:
    """Return for each set of start values whether all outputs of two FMUs have the same bits, and how far they are
    apart.
    """
    found = []
    for given in values:
        start = {name: value for name, value in given.items() if name != "push"}
        push = given.get("push", 1.5)
        columns = [Instance(fmu, start) for fmu in (first, second)]
        worst: dict[int, float] = {}
        peak: dict[int, float] = {}
        same = True
        for k in range(400):
            seen = []
            for column in columns:
                ax = push * sin(12.6 * 0.005 * k)
                column.set({"base.ax": ax, "base.az": 0.2 * ax, "base.jx": 12.6 * push - 0.1 * push * k})
                if k == 200:
                    column.set({"g": 9.7, "joint[1].damping": 4e-3})
                column.step(0.005 * k, 0.005)
                seen.append(column.get())
            same = same and seen[0] == seen[1]
            for i, (a, b) in enumerate(zip(*seen, strict=True)):
                worst[i] = max(worst.get(i, 0.0), abs(a - b))
                peak[i] = max(peak.get(i, 1e-300), abs(b))
        found.append((same, max(worst[i] / peak[i] for i in worst)))
    return found


def references(column: Instance, *names: str) -> Any:
    """Return the value references of variables, as C has them."""
    return (fmi2ValueReference * len(names))(*(column.variables[name].valueReference for name in names))


def rates_of(body: Instance, names: Sequence[str], t: float, h: float) -> Pair:
    """Return the derivatives of outputs by the FMU after a step of h s, and central differences of them over two."""
    state, seen = body.fmi.getFMUState(), []
    body.step(t, h)
    count = len(names)
    values = (fmi2Real * count)()
    one = references(body, *names), count, (fmi2Integer * count)(*[1] * count), values
    assert body.fmi.dll.fmi2GetRealOutputDerivatives(body.fmi.component, *one) == 0
    for length in (0.0, 2 * h):
        body.fmi.setFMUState(state)
        if length:
            body.step(t, length)
        seen.append(body.get(*names))
    return list(values), [(b - a) / (2 * h) for a, b in zip(*seen, strict=True)]


def input_derivative(column: Instance, name: str, value: float, order: int = 1) -> int:
    """Return the status of setting a derivative of an input."""
    one = references(column, name), 1, (fmi2Integer * 1)(order), (fmi2Real * 1)(value)
    return int(column.fmi.dll.fmi2SetRealInputDerivatives(column.fmi.component, *one))


def directional(column: Instance, outputs: Sequence[str], inputs: Sequence[str], seeds: list[float]) -> list[float]:
    """Return the directional derivative of outputs by inputs."""
    of, by = (list(references(column, *names)) for names in (outputs, inputs))
    return [float(value) for value in column.fmi.getDirectionalDerivative(of, by, seeds)]


def rocking(fmu: str) -> Instance:
    """Return a column that has rocked for 0.6 s."""
    column = Instance(fmu, {"solver.tolerance": 1e-9})
    for k in range(60):
        column.set({"base.ax": 1.5 * sin(0.126 * k), "base.az": 0.3})
        column.step(0.01 * k, 0.01)
    return column


def slopes(fmu: str) -> tuple[bool, list[int]]:
    """Return True if a derivative does what the slope does; the status of four derivatives."""

    def follow(derivative: bool) -> list[Any]:
        column, seen = Instance(fmu), []
        for k in range(100):
            slope = 15.0 - 0.3 * k
            column.set({"base.ax": 1.5 * sin(0.126 * k)} | ({} if derivative else {"base.jx": slope}))
            if derivative:
                assert input_derivative(column, "base.ax", slope) == 0
            column.step(0.01 * k, 0.01)
            seen += column.get()
        return seen

    column = Instance(fmu)
    statuses = [
        input_derivative(column, "base.ax", 1.0, order=2),
        input_derivative(column, "base.jx", 1.0),
        input_derivative(column, "g", 1.0),
        input_derivative(column, "base.jx", 0.0),
    ]
    return follow(True) == follow(False), statuses


def output_derivatives(fmu: str) -> Pair:
    """Return the derivatives of outputs, and central differences of the outputs."""
    column = rocking(fmu)
    column.set({"base.ax": 0.4, "base.jx": 3.0})
    return rates_of(column, OUTPUTS, 0.6, 1e-5)


def by_acceleration(fmu: str) -> list[Pair]:
    """Return the directional derivatives by the base acceleration, and what the outputs change by."""
    column, found = rocking(fmu), []
    for given in ({}, {"base.ax": 0.7, "base.jz": 2.0}):
        column.set(given)
        before = column.get(*OUTPUTS)
        derivative = directional(column, OUTPUTS, ["base.ax", "base.az"], [2.0, -3.0])
        column.set({name: column.get(name)[0] + by for name, by in (("base.ax", 2.0), ("base.az", -3.0))})
        after = column.get(*OUTPUTS)
        found.append((derivative, [b - a for a, b in zip(before, after, strict=True)]))
    return found


def by_rotation(fmu: str, name: str, step: float) -> Pair:
    """Return the directional derivatives by a rotation of the base, and differences of the outputs."""
    outputs = [*OUTPUTS, *SPLIT]
    column = rocking(fmu)
    column.set({"base.theta": 1e-4, "base.omega": 2e-3, "base.alpha": 0.05})
    found = directional(column, outputs, [name], [1.0])
    at = column.get(name)[0]
    seen = []
    for value in (at - step, at + step):
        column.set({name: value})
        seen.append(column.get(*outputs))
    return found, [(b - a) / (2.0 * step) for a, b in zip(*seen, strict=True)]


def status(fmu: str) -> list[Any]:
    """Return the answers to questions about a step that was refused, and to its cancellation."""
    column = rocking(fmu)
    column.attempt("step", 0.0, 0.1)
    return [last_step(column), column.fmi.dll.fmi2CancelStep(column.fmi.component)]


def left_behind(fmu: str) -> int:
    """Return the bytes that ten thousand lives leave behind."""
    column = Instance(fmu)
    dll, callbacks, guid = column.fmi.dll, column.fmi.callbacks, column.fmi.guid.encode()
    state = ctypes.c_void_p()

    def live() -> None:
        c = dll.fmi2Instantiate(b"column", 1, guid, b"", ctypes.byref(callbacks), 0, 0)
        assert dll.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == 0
        assert dll.fmi2EnterInitializationMode(c) == 0
        assert dll.fmi2ExitInitializationMode(c) == 0
        assert dll.fmi2DoStep(c, 0.0, 0.01, 1) == 0
        assert dll.fmi2GetFMUstate(c, ctypes.byref(state)) == 0
        assert dll.fmi2FreeFMUstate(c, ctypes.byref(state)) == 0
        dll.fmi2FreeInstance(c)

    for _ in range(100):
        live()
    before = resident()
    for _ in range(10000):
        live()
    return resident() - before
