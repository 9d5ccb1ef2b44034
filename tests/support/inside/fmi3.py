"""The FMU of FMI 3.0 beside that of FMI 2.0, and what only it can do."""

from __future__ import annotations

import ctypes
from itertools import pairwise
from math import sin
from typing import Any

from fmpy import read_model_description
from fmpy.fmi3 import FMU3Slave, fmi3Int64, fmi3ValueReference

from support.instance import Instance, unpacked

OUTPUTS = ("base.Fx", "base.R0x", "base.mxx", "block.ux", "block.theta", "joint.N", "joint.S", "joint.contact")


class Instance3:
    """An FMU of FMI 3.0 by the names of its variables; an array has as many values as its dimension says."""

    def __init__(self, fmu: str, folder: str | None = None, **options: Any) -> None:
        description = read_model_description(fmu)
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.said: list[str] = []
        self.fmi = FMU3Slave(
            instanceName="column",
            guid=description.guid,
            unzipDirectory=folder or unpacked(fmu),
            modelIdentifier=description.coSimulation.modelIdentifier,
        )

        def hear(environment: Any, status: int, category: bytes, message: bytes) -> None:
            self.said.append(message.decode())

        self.fmi.instantiate(logMessage=hear, **options)

    def initialize(self, start: float = 0.0) -> None:
        self.fmi.enterInitializationMode(startTime=start)
        self.fmi.exitInitializationMode()

    def size(self, name: str) -> int:
        dimensions = self.variables[name].dimensions
        return int(dimensions[0].start) if dimensions else 1

    def _access(self, name: str) -> str:
        kind = self.variables[name].type
        return "Int64" if kind == "Enumeration" else str(kind)

    def get(self, *names: str) -> list[Any]:
        values = []
        for name in names:
            get = getattr(self.fmi, f"get{self._access(name)}")
            values += get([self.variables[name].valueReference], self.size(name))
        return values

    def set(self, **values: Any) -> None:
        for key, value in values.items():
            name = key.replace("__", ".")
            listed = value if isinstance(value, list) else [value]
            getattr(self.fmi, f"set{self._access(name)}")([self.variables[name].valueReference], listed)

    def step(self, t: float, h: float) -> Any:
        return self.fmi.doStep(t, h)

    def references(self, *names: str) -> list[int]:
        return [self.variables[name].valueReference for name in names]


def elements(column: Instance, names: tuple[str, ...]) -> list[str]:
    """Return the variables of FMI 2.0 that those of FMI 3.0 stand for."""
    found = []
    for name in names:
        owner, _, member = name.partition(".")
        own = [each for each in column.variables if each.startswith(f"{owner}[") and each.endswith(f"].{member}")]
        found += own or [name]
    return found


def beside(fmu2: str, fmu3: str) -> dict[str, Any]:
    """Compare bit for bit: steps, parameters as arrays, enumerations, derivatives, a state that goes through bytes."""
    two, three = Instance(fmu2, initialize=False), Instance3(fmu3)
    two.set({"joint[1].damping": 2e-3, "joint[2].damping": 1e-3, "joint[3].damping": 3e-3})
    three.set(joint__damping=[2e-3, 1e-3, 3e-3])
    two.initialize()
    three.initialize()
    names = elements(two, OUTPUTS)
    rows: list[Any] = []

    def drive(first: int, last: int, keep: bool = True) -> list[float]:
        for k in range(first, last):
            push = 2.0 * sin(0.06 * k)
            three.set(base__ax=push, base__jx=1.0)
            three.step(0.005 * k, 0.005)
            if keep:
                two.set({"base.ax": push, "base.jx": 1.0})
                two.step(0.005 * k, 0.005)
                rows.append((two.get(*names), three.get(*OUTPUTS)))
        return three.get(*OUTPUTS)

    drive(0, 100)
    knowns, unknowns = ("base.ax", "base.az"), OUTPUTS[:5]
    direct = two.fmi.getDirectionalDerivative(
        [two.variables[name].valueReference for name in elements(two, unknowns)],
        [two.variables[name].valueReference for name in knowns],
        [1.0, 0.5],
    )
    count = sum(three.size(name) for name in unknowns)
    again = three.fmi.getDirectionalDerivative(
        three.references(*unknowns), three.references(*knowns), [1.0, 0.5], count
    )
    saved = three.fmi.serializeFMUState(three.fmi.getFMUState())
    first = drive(100, 150)
    other = Instance3(fmu3)
    other.initialize()
    other.fmi.setFMUState(other.fmi.deserializeFMUState(saved))
    three.fmi.setFMUState(three.fmi.deserializeFMUState(saved))
    found = {
        "same": all(a == b for a, b in rows),
        "moved": max(abs(value) for value in rows[-1][0]),
        "time": three.get("time"),
        "time in between": three.fmi.getFloat64(three.references("block.ux", "time", "base.ax"), 5)[3],
        "direct": direct == again,
        "restored": drive(100, 150, keep=False) == first,
        "elsewhere": other.get("time", "joint.damping"),
        "size": three.size("block.ux"),
        "overturned": three.get("overturned", "overturn_joint", "solver.without"),
    }
    for column in (three, other):
        column.fmi.terminate()
        column.fmi.freeInstance()
    two.close()
    return found


def push(t: float) -> float:
    """Return a motion, m/s2."""
    return 2.0 * sin(9.0 * t) * sin(31.0 * t)


def followed(fmu2: str, fmu3: str, step: float, count: int, anew: bool = True) -> list[list[float]]:
    """Return the top displacement after every step: the motion given within the step, and sampled at 1 ms with
    slopes. anew: given before each step, too; else before the first one alone.
    """
    seen: list[tuple[float, bool, bool, bool]] = []
    refused: list[str] = []

    def give(
        environment: Any, t: float, wanted: bool, allowed: bool, finished: bool, early: bool, request: Any, when: Any
    ) -> None:
        seen.append((t, wanted, allowed, early))
        if wanted:
            three.set(base__ax=push(t), base__az=0.1 * push(t))
        else:
            try:
                three.set(base__ax=1.0)
            except Exception:
                refused.append(three.said[-1])

    folder = unpacked(fmu3)
    references = Instance3(fmu3, folder).references("base.ax", "base.az")
    three = Instance3(fmu3, folder, intermediateUpdate=give, requiredIntermediateVariables=references)
    two = Instance(fmu2)
    three.initialize()
    fine = 1e-3
    per = round(step / fine)
    rows = []
    for k in range(count):
        if anew or k == 0:
            three.set(base__ax=push(k * step), base__az=0.1 * push(k * step))
        *_, last = three.step(k * step, step)
        assert last == k * step + step
        assert three.get("base.ax", "base.az") == [push(last), 0.1 * push(last)]
        for j in range(k * per, (k + 1) * per):
            now, then = push(j * fine), push(j * fine + fine)
            slope = (then - now) / fine
            two.set(
                {"base.ax": now, "base.az": 0.1 * now, "base.jx": slope, "base.jz": (0.1 * then - 0.1 * now) / fine}
            )
            two.step(j * fine, fine)
        rows.append([*three.get("block.ux")[:1], *two.get("block[1].ux")])
    assert len(seen) == 2 * per * count
    assert len(refused) == per * count  # where no set is requested
    assert all("no set is requested" in said for said in refused)
    assert all(t1 <= t2 for (t1, *_), (t2, *_) in pairwise(seen))
    assert not any(early for *_, early in seen)
    return rows


def continued(
    fmu2: str, fmu3: str, lines: dict[str, str], steps: list[dict[str, float]], outputs: list[str], h: float
) -> dict[str, Any]:
    """Compare steps of h s that FMI 3.0 makes in pieces with whole ones of FMI 2.0, under the same inputs and slopes.

    lines: input that FMI 3.0 is given within the step -> its slope. Return the outputs of both at each end, and
    whether the other inputs are then as they were set.
    """
    begun: dict[str, Any] = {"t": 0.0, "given": {}}
    within: list[float] = []

    def at(t: float) -> dict[str, float]:
        given = begun["given"]
        return {name: given[name] + given[slope] * (t - begun["t"]) for name, slope in lines.items()}

    def give(environment: Any, t: float, wanted: bool, *others: Any) -> None:
        if wanted:
            put(at(t))
        else:
            within.append(three.get(outputs[0])[0])

    def put(values: dict[str, float]) -> None:
        three.fmi.setFloat64(three.references(*values), list(values.values()))

    folder = unpacked(fmu3)
    references = Instance3(fmu3, folder).references(*lines)
    three = Instance3(fmu3, folder, intermediateUpdate=give, requiredIntermediateVariables=references)
    put({"solver.tolerance": 1e-9})
    two = Instance(fmu2, {"solver.tolerance": 1e-9})
    three.initialize()
    rows, kept = [], []
    for k, given in enumerate(steps):
        begun.update(t=k * h, given=given)
        put({name: value for name, value in given.items() if name not in lines.values()})
        two.set(given)
        three.step(k * h, h)
        two.step(k * h, h)
        others = [name for name in given if name not in {*lines, *lines.values()}]
        kept.append(three.get(*others) == [given[name] for name in others])
        rows.append((three.get(*outputs), two.get(*elements(two, tuple(outputs)))))
        kept.append(rows[-1][0][0] == within[-1])
    return {"rows": rows, "kept": all(kept), "pieces": len(within)}


def refusals(fmu: str) -> dict[str, Any]:
    """Return refused calls and their messages; afterwards the instance still answers."""
    folder = unpacked(fmu)
    column = Instance3(fmu, folder)
    fmi = column.fmi
    found: dict[str, Any] = {}

    def attempt(name: str, call: Any, *arguments: Any) -> None:
        column.said.clear()
        try:
            call(*arguments)
            found[name] = "ok"
        except Exception as error:
            found[name] = " ".join([str(error), *column.said])

    attempt("early", column.get, "base.Fx")
    attempt("two sizes", fmi.setFloat64, column.references("block.mass"), [1.0, 2.0])
    attempt("one mass", fmi.setFloat64, [column.references("block.mass")[0] + 1], [1.0])
    column.initialize()
    attempt("element", fmi.getFloat64, [column.references("block.ux")[0] + 1])
    attempt("short", fmi.getFloat64, column.references("block.ux"), 2)
    attempt("long", fmi.getFloat64, column.references("block.ux"), 4)
    attempt("unknown", fmi.getFloat64, [99999])
    attempt("kind", fmi.getInt64, column.references("base.Fx"))
    attempt("small", fmi.getInt32, column.references("overturn_joint"))
    attempt("fixed", fmi.setFloat64, column.references("block.mass"), [1.0, 2.0, 3.0])
    attempt("event mode", fmi.enterEventMode)
    attempt("backwards", fmi.doStep, 0.0, -1.0)
    column.set(base__ax=float("nan"))
    attempt("no number", fmi.doStep, 0.0, 0.01)
    column.set(base__ax=0.5)
    attempt("state", fmi.deserializeFMUState, b"nonsense" * 100)
    column.step(0.0, 0.01)
    found["answers"] = abs(column.get("block.ux")[0]) > 0.0
    guid, called = fmi.guid, fmi.instanceName
    for name, (fmi.guid, fmi.instanceName), events in (
        ("events", (guid, called), True),
        ("token", ("{wrong}", called), False),
        ("unnamed", (guid, ""), False),
    ):
        attempt(name, lambda: fmi.instantiate(eventModeUsed=events))  # noqa: B023

    def give(environment: Any, t: float, wanted: bool, *others: Any) -> None:
        if wanted:
            within.set(base__ax=float("nan") if t > 0.005 else 0.5)

    within = Instance3(fmu, folder, intermediateUpdate=give, requiredIntermediateVariables=column.references("base.ax"))
    within.initialize()
    attempt("no number within", within.fmi.doStep, 0.0, 0.01)
    found["no number within"] = " ".join(within.said)
    exchange = fmi.dll.fmi3InstantiateModelExchange
    exchange.restype = ctypes.c_void_p
    found["exchange"] = exchange(b"column", guid.encode(), b"", False, False, None, fmi.logMessage)
    found["nothing"] = int(fmi.dll.fmi3GetInt64(None, (fmi3ValueReference * 1)(1014), 1, (fmi3Int64 * 1)(), 1))
    return found


def along_an_array(fmu: str) -> dict[str, Any]:
    """Return directional derivatives of two ports by their loads, which are one array, and what wrong seeds give."""
    column = Instance3(fmu)
    column.initialize()
    column.step(0.0, 0.01)
    outputs, inputs = column.references("port.ax"), column.references("port.Fx")

    def along(*seeds: float) -> Any:
        try:
            return list(column.fmi.getDirectionalDerivative(outputs, inputs, list(seeds), 2))
        except Exception:
            return column.said[-1]

    seeds = {"first": (1.0, 0.0), "second": (0.0, 1.0), "both": (2.0, -3.0), "short": (1.0,), "long": (1.0, 0.0, 0.0)}
    return {name: along(*given) for name, given in seeds.items()}
