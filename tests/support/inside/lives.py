"""Instances at every stage of life, what a usual one shows, and how wrong calls are answered."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from support.instance import Instance

NAN, INF = float("nan"), float("inf")

# how the instance is made, and what is asked of it
WrongCall = tuple[Callable[[str, bool], Instance], Callable[[Instance], object]]


def fresh(fmu: str, logging: bool = False) -> Instance:
    """Return an instance that is not initialized."""
    return Instance(fmu, initialize=False, loggingOn=logging)


def started(fmu: str, logging: bool = False) -> Instance:
    """Return an instance after its first step, to 0.1 s."""
    column = Instance(fmu, {"base.ax": 0.5}, loggingOn=logging)
    column.step(0.0, 0.1)
    return column


def terminated(fmu: str, logging: bool = False) -> Instance:
    """Return the same, terminated."""
    column = started(fmu, logging)
    column.fmi.terminate()
    return column


def usual(column: Instance) -> list[Any]:
    """Return all outputs after the first step, after a restart."""
    column.fmi.reset()
    column.initialize()
    column.set({"base.ax": 0.5})
    column.step(0.0, 0.1)
    return column.get()


def answer(call: Callable[[], object]) -> str:
    """Return the result of a call: "ok", or the error that FMPy makes of its status."""
    try:
        call()
    except Exception as error:
        return str(error)
    return "ok"


def answers(fmu: str, calls: list[WrongCall], logging: bool = False) -> list[tuple[str, bool]]:
    """Return for each call the answer, and whether the instance shows what is usual afterwards.

    Both streams have a line `==` after what belongs to a call.
    """
    expected = usual(fresh(fmu))
    found = []
    for make, call in calls:
        column = make(fmu, logging)
        heard = answer(lambda call=call, column=column: call(column))  # type: ignore[misc]
        print("==", flush=True)
        print("==", file=sys.stderr, flush=True)
        found.append((heard, usual(column) == usual(column) == expected))
        column.close()
    return found


def read_as_reals(fmu: str, names: list[str]) -> list[float]:
    """Return the outputs after some steps, read by one call for reals, as a host does that knows no other kind."""
    column = Instance(fmu, {"base.ax": 0.5})
    for k in range(20):
        column.step(0.01 * k, 0.01)
    found = [float(value) for value in column.fmi.getReal([column.variables[name].valueReference for name in names])]
    column.close()
    return found
