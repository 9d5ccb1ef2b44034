"""FMUs whose base bodies drive: what they say of inputs that do nothing, and of a base that never moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fmpy import read_model_description

from support.inside.fmi3 import Instance3
from support.instance import Instance

Given = Mapping[str, Any]


class Heard:
    """An instance of an FMU of FMI 2.0 or 3.0; what it says is printed, a message a line."""

    def __init__(self, fmu: str) -> None:
        self.three = read_model_description(fmu).fmiVersion.startswith("3")
        self.body: Any = Instance3(fmu) if self.three else Instance(fmu, initialize=False, loggingOn=True)

    def set(self, values: Given) -> None:
        if self.three:
            self.body.set(**{name.replace(".", "__"): value for name, value in values.items()})
        else:
            self.body.set(values)

    def close(self) -> None:
        self.body.fmi.terminate()
        self.body.fmi.freeInstance()
        if self.three:
            print(*self.body.said, sep="\n", flush=True)


def run(fmu: str, before: Given, steps: Sequence[Given], names: Sequence[str] = ("block[1].ux",)) -> list[list[Any]]:
    """Return the outputs after each step of 1 ms.

    Before: values of initialization; steps: those set before each step.
    """
    heard, rows = Heard(fmu), []
    heard.set(before)
    heard.body.initialize()
    for k, values in enumerate(steps):
        heard.set(values)
        heard.body.step(1e-3 * k, 1e-3)
        rows.append(heard.body.get(*names))
    heard.close()
    return rows


def turned_late(fmu: str, before: Given, turned: Given, act: Given, names: Sequence[str]) -> list[list[Any]]:
    """Return outputs read in initialization, after inputs were set behind it, and after a step of 1 ms under `act`."""
    heard, rows = Heard(fmu), []
    heard.set(before)
    if not heard.three:
        heard.body.fmi.setupExperiment(startTime=0.0)
    heard.body.fmi.enterInitializationMode()
    rows.append(heard.body.get(*names))
    heard.body.fmi.exitInitializationMode()
    heard.body.get(*names)
    heard.set(turned)
    rows.append(heard.body.get(*names))
    heard.set(act)
    heard.body.step(0.0, 1e-3)
    rows.append(heard.body.get(*names))
    heard.close()
    return rows


def example(fmu: str, code: str, given: dict[str, Any]) -> list[float]:
    """Return the displacements of the top after each step, where the partner is the code of the FMU's own
    documentation.
    """
    tops: list[float] = []

    class Watched(Instance):
        def step(self, t: float, h: float) -> None:
            super().step(t, h)
            tops.extend(self.get("block[1].ux"))

    exec(code, {**given, "fmu": Watched(fmu, {"base.drive": "horizontal"})})
    return tops
