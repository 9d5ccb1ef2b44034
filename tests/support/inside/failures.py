"""Calls that a master must not make, and what is left of the instance."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from support.inside.lives import INF, NAN, WrongCall, answers, fresh, started, terminated
from support.instance import Instance, unpacked

# how the instance was made, the call, what is said
Case = tuple[Callable[[str, bool], Instance], Callable[[Instance], object], str]

ALIKE: list[Case] = [  # of both FMUs
    (fresh, lambda c: c.get("block[1].ux"), "outputs can be read from initialization on"),
    (fresh, lambda c: c.step(0.0, 0.1), "the slave is not initialized"),
    (fresh, lambda c: c.fmi.setupExperiment(None, NAN), "start time = nan: must be a finite time"),
    (fresh, lambda c: c.fmi.getReal([4294967295]), "is not that of a Real variable"),
    (
        fresh,
        lambda c: c.fmi.setReal([100000], [1.0]),
        "value reference 100000: is not an input or a parameter",
    ),
    (fresh, lambda c: c.set({"block[1].ux": 1.0}), "is not an input or a parameter"),
    (started, lambda c: c.set({"block[1].mass": 1.0}), "block[1].mass: can be set before the end"),
    (started, lambda c: c.step(0.1, 0.0), "the step must be a positive time"),
    (started, lambda c: c.step(0.05, 0.1), "the last step ended at t = 0.1 s"),
    (terminated, lambda c: c.step(0.1, 0.1), "the run is terminated"),
    (terminated, lambda c: c.set({"base.ax": 1.0}), "nothing can be set, the run is terminated"),
]


def _real_of_a_string(column: Instance) -> object:
    return column.fmi.getReal([column.variables["base.record"].valueReference])


PYTHON: list[Case] = [
    *ALIKE,
    (fresh, _real_of_a_string, "not that of a Real"),
    (started, lambda c: c.fmi.exitInitializationMode(), "the slave is in the state stepping"),
    (started, lambda c: c.fmi.setupExperiment(), "the slave is in the state stepping"),
    (started, lambda c: c.step(0.1, -0.1), "the step must be a positive time"),
    (started, lambda c: c.step(0.1, INF), "the step must be a positive time"),
    (started, lambda c: c.step(NAN, 0.1), "the last step ended at t = 0.1 s"),
    (terminated, lambda c: c.fmi.exitInitializationMode(), "the slave is in the state terminated"),
]

NATIVE: list[Case] = [
    *ALIKE,
    (fresh, lambda c: c.fmi.exitInitializationMode(), "the slave is in the state instantiated"),
    (fresh, lambda c: c.fmi.terminate(), "the slave is in the state instantiated"),
    (
        fresh,
        lambda c: c.set({"base.record": "x" * 300}),
        "base.record: must be a text of less than 256 bytes",
    ),
    (started, lambda c: c.fmi.enterInitializationMode(), "the slave is in the state stepping"),
    (started, lambda c: c.fmi.setupExperiment(), "the slave is in the state stepping"),
]


def _calls(cases: list[Case]) -> list[WrongCall]:
    return [(make, call) for make, call, _ in cases]


def python_answers(fmu: str, logging: bool) -> list[tuple[str, bool]]:
    """Return the wrong calls to the PythonFMU."""
    return answers(fmu, _calls(PYTHON), logging)


def native_answers(fmu: str, values: list[dict[str, Any]]) -> list[tuple[str, bool]]:
    """Return the wrong calls to the native FMU, then initializations with wrong values."""

    def with_values(given: dict[str, Any]) -> Callable[[str, bool], Instance]:
        def make(fmu: str, logging: bool = False) -> Instance:
            column = fresh(fmu, logging)
            column.set(given)
            return column

        return make

    return answers(fmu, [*_calls(NATIVE), *((with_values(given), Instance.initialize) for given in values)])


def wrong_values(fmu: str, values: list[tuple[str, Any]]) -> list[list[str]]:
    """Return what an initialization with each wrong value answers, one after a reset, and a step."""
    heard = []
    for name, value in values:
        column = Instance(fmu, {name: value}, initialize=False)
        first = column.attempt("initialize")
        column.fmi.reset()
        again = column.attempt("initialize")
        column.set({"base.ax": 1.0})
        heard.append([first, again, column.attempt("step", 0.0, 1e-2)])
        column.close()
    return heard


def impossible_steps(fmu: str) -> list[str]:
    """Return a step, five that cannot be made, and another."""
    column = Instance(fmu)
    heard = [column.attempt("step", 0.0, 1e-2)]
    for t, h in ((1e-2, 0.0), (1e-2, -1e-2), (0.0, 1e-2), (1e-2, NAN)):
        heard.append(column.attempt("step", t, h))
    for ax in (INF, 1.0):
        column.set({"base.ax": ax})
        heard.append(column.attempt("step", 1e-2, 1e-2))
    column.fmi.freeInstance()
    return heard


def bad_inputs_and_parameters(fmu: str) -> tuple[list[str], list[Any], list[Any]]:
    """Return the answers to steps over what is no input or parameter; outputs after a good step, with and without them
    before.
    """
    column = started(fmu)
    heard = []
    for name, bad, good in (
        ("base.ax", NAN, 0.5),
        ("base.jz", INF, 0.0),
        ("base.ax", 1e300, 0.5),
        ("base.az", 1e14, 0.0),
        ("base.jz", 1e14, 0.0),
        ("joint[1].damping", -1.0, 1e-3),
        ("g", NAN, 9.80665),
    ):
        column.set({name: bad})
        heard.append(column.attempt("step", 0.1, 0.1))
        column.set({name: good})
    column.step(0.1, 0.1)
    plain = started(fmu)
    plain.step(0.1, 0.1)
    return heard, column.get(), plain.get()


def outputs_without_an_input(fmu: str) -> tuple[list[float], list[float], float]:
    """Return the outputs that do not follow the input at once, before and while it is no number; and one that does."""
    names = ("block[1].ux", "joint[1].N")
    column = started(fmu)
    before = column.get(*names)
    column.set({"base.ax": NAN})
    return before, column.get(*names), column.get("base.Fx")[0]


def outputs_of_initialization(fmu: str) -> list[float]:
    """Return the base's normal force as parameters and inputs are set in initialization."""
    column = fresh(fmu)
    column.fmi.setupExperiment()
    column.fmi.enterInitializationMode()
    heard = column.get("joint[3].N")
    column.set({"g": 5.0})
    heard += column.get("joint[3].N")
    column.set({"base.az": 1.0})
    return heard + column.get("base.Fz")


def on_another_system(fmu: str) -> None:
    """Return an instance of an FMU that carries no machine code for this system."""
    folder = Path(unpacked(fmu))
    for library in (folder / "resources").rglob("*.so"):
        library.unlink()
    Instance(fmu, folder=str(folder))


def rings(fmu: str, dampings: list[tuple[float, float]]) -> list[float]:
    """Return the largest displacements of the top at the end of free motions with damping changed as they begin."""
    return [_ring(fmu, *pair) for pair in dampings]


def _ring(fmu: str, damping: float, later: float) -> float:
    joints = [f"joint[{i}].damping" for i in (1, 2, 3)]
    column = Instance(fmu, dict.fromkeys(joints, damping))
    column.set({"base.ax": 0.5})
    column.step(0.0, 0.3)
    column.set({"base.ax": 0.0} | dict.fromkeys(joints, later))
    seen = []
    for k in range(200):
        column.step(0.3 + 0.01 * k, 0.01)
        seen += column.get("block[1].ux")
    return max(map(abs, seen[-50:]))


def instant(fmu: str) -> list[list[float]]:
    """Return outputs after a step, under two inputs of that instant."""
    column = Instance(fmu)
    column.step(0.0, 1e-2)
    heard = []
    for ax in (0.0, 1.0):
        column.set({"base.ax": ax})
        heard.append(column.get("block[1].ux", "joint[1].N", "joint[3].M", "joint[3].S", "base.Fx", "base.My"))
    return heard
