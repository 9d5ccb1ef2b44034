"""Measurements in the process of an FMU: `python -m benchmarks.in_host FUNCTION ARGUMENTS`.

Arguments and result are JSON. The tests' Instance must be in reach.
"""

from __future__ import annotations

import ctypes
import gc
import json
import sys
import time
from collections.abc import Callable
from ctypes import c_double, c_int, c_uint
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
from fmpy import read_model_description, simulate_fmu
from support.instance import Instance, unpacked


def shortest(call: Callable[[], object], rounds: int, count: int = 1) -> float:
    """Return the seconds of one call, the fastest of `rounds` times `count` calls."""
    best = np.inf
    for _ in range(rounds):
        begin = time.perf_counter()
        for _ in range(count):
            call()
        best = min(best, (time.perf_counter() - begin) / count)
    return float(best)


def resident() -> int:
    """Return the memory of this process, bytes."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def calls(fmu: str, rounds: int) -> float:
    """Return the seconds to set an input, step 1 ms and read an output, the shortest of batches of ten."""
    column = Instance(fmu)
    fmi, now = column.fmi, 0.0
    pushed, read = ([column.variables[name].valueReference] for name in ("base.ax", "block[1].ux"))

    def one() -> None:
        nonlocal now
        fmi.setReal(pushed, [0.3])
        fmi.doStep(now, 1e-3)
        now += 1e-3
        fmi.getReal(read)

    return shortest(one, rounds, 10)


def state(fmu: str, rounds: int) -> dict[str, float]:
    """Return the seconds to get, set and free a state, and its size in bytes."""
    column = Instance(fmu, {"base.ax": 1.0})
    column.step(0.0, 0.1)
    fmi = column.fmi

    def around() -> None:
        got = fmi.getFMUstate()
        fmi.setFMUstate(got)
        fmi.freeFMUstate(got)

    seconds = shortest(around, 20 * rounds, 50)
    return {"seconds": seconds, "bytes": len(fmi.serializeFMUstate(fmi.getFMUstate()))}


def race(fmus: list[str], steps: int, rounds: int, push: float) -> dict[str, Any]:
    """Return the seconds of a run of 20 s in FMPy under push * sin(12.6 t) m/s2, of each FMU, and how many outputs it
    reads.
    """
    h = 20.0 / steps
    t = h * np.arange(steps + 1)
    motion = np.zeros(t.size, dtype=[("time", float), ("base.ax", float)])
    motion["time"], motion["base.ax"] = t, push * np.sin(12.6 * t)
    folders = {fmu: unpacked(fmu) for fmu in fmus}
    descriptions = {fmu: read_model_description(folders[fmu]) for fmu in fmus}
    best = dict.fromkeys(fmus, np.inf)
    for _ in range(rounds):
        for fmu in fmus:
            given = {"stop_time": 20.0, "output_interval": h, "input": motion, "model_description": descriptions[fmu]}
            begin = time.perf_counter()
            result = simulate_fmu(folders[fmu], **given)
            best[fmu] = min(best[fmu], time.perf_counter() - begin)
            assert len(result) == steps + 1, len(result)
    return {"seconds": [best[fmu] for fmu in fmus], "outputs": len(result.dtype.names) - 1}


def threads(fmu: str, rounds: int) -> dict[str, float]:
    """Return the seconds of two long steps, one after the other and in two threads."""

    def work(column: Instance) -> None:
        column.fmi.reset()
        column.set({"base.ax": 0.5, "base.jx": -0.01, "solver.tolerance": 1e-11})
        column.initialize()
        column.step(0.0, 100.0)

    columns = [Instance(fmu), Instance(fmu)]

    def in_turns() -> None:
        for column in columns:
            work(column)

    def at_once() -> None:
        workers = [Thread(target=work, args=(column,)) for column in columns]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()

    one = both = np.inf
    for _ in range(rounds):  # by turns, so that both see the same machine
        one, both = min(one, shortest(in_turns, 1)), min(both, shortest(at_once, 1))
    return {"one": one, "both": both}


def memory(fmu: str, count: int) -> dict[str, int]:
    """Return the bytes, and entries of the search path, that `count` instances leave behind."""
    folder = unpacked(fmu)

    def life() -> None:
        column = Instance(fmu, {"base.ax": 0.5}, folder=folder)
        for k in range(10):
            column.step(0.01 * k, 0.01)
            column.get()
        column.fmi.freeFMUstate(column.fmi.getFMUstate())
        column.close()

    for _ in range(20):
        life()
    before, entries = resident(), len(sys.path)
    for _ in range(count):
        life()
    return {"bytes": resident() - before, "entries": len(sys.path) - entries}


def inputs(fmu: str, record: str, way: str, h: float, samples: list[float]) -> list[float]:
    """Return block[1].ux every 0.2 s until 4 s under samples of 0.01 s: held, slope, derivative or record."""
    column = Instance(fmu, {"solver.tolerance": 1e-8} | ({"base.record": record} if way == "record" else {}))

    def a(t: float) -> float:
        k = min(int(t / 0.01 + 1e-6), len(samples) - 2)
        return samples[k] + (samples[k + 1] - samples[k]) * (t / 0.01 - k)

    seen = []
    for k in range(round(4.0 / h)):
        slope = (a((k + 1) * h) - a(k * h)) / h
        if way != "record":
            column.set({"base.ax": a(k * h)})
        if way == "slope":
            column.set({"base.jx": slope})
        if way == "derivative":
            one = (c_uint * 1)(column.variables["base.ax"].valueReference), 1, (c_int * 1)(1), (c_double * 1)(slope)
            assert column.fmi.dll.fmi2SetRealInputDerivatives(column.fmi.component, *one) == 0
        column.step(k * h, h)
        if (k + 1) % round(0.2 / h) == 0:
            seen += column.get("block[1].ux")
    return seen


def native_calls(fmu: str, rounds: int) -> dict[str, float]:
    """Return the seconds of calls through ctypes: steps of 1 ms at rest and under 0.3 m/s2, outputs, state, and an
    empty call.
    """
    found = {}
    for name, push in (("rest", 0.0), ("rocks", 0.3)):
        column = Instance(fmu, {"base.ax": push})
        dll, c = column.fmi.dll, column.fmi.component
        step = dll.fmi2DoStep
        step.argtypes, step.restype = [ctypes.c_void_p, c_double, c_double, c_int], c_int
        now = 0.0

        def one(step: Callable[..., int] = step, c: Any = c) -> None:
            nonlocal now
            assert step(c, now, 1e-3, 1) == 0
            now += 1e-3

        found[name] = shortest(one, rounds, 1000)
    names = [name for name, item in column.variables.items() if item.causality == "output" and item.type == "Real"]
    read = (c_uint * 27)(*(column.variables[name].valueReference for name in names[:27]))
    pushed, push_value = (c_uint * 1)(column.variables["base.ax"].valueReference), (c_double * 1)(0.3)
    values, got = (c_double * 27)(), ctypes.c_void_p()

    def outputs() -> None:
        dll.fmi2SetReal(c, pushed, 1, push_value)
        dll.fmi2GetReal(c, read, 27, values)

    def around() -> None:
        dll.fmi2GetFMUstate(c, ctypes.byref(got))
        dll.fmi2SetFMUstate(c, got)

    found["outputs"] = shortest(outputs, rounds, 2000)
    found["state"] = shortest(around, rounds, 2000)
    found["nothing"] = shortest(lambda: dll.fmi2GetVersion(), rounds, 2000)
    return found


def native_lives(fmu: str, count: int) -> dict[str, float]:
    """Return the bytes that `count` instances leave behind, and seconds of each."""
    column = Instance(fmu)
    dll, callbacks, guid = column.fmi.dll, column.fmi.callbacks, column.fmi.guid.encode()

    def live() -> None:
        c = dll.fmi2Instantiate(b"column", 1, guid, b"", ctypes.byref(callbacks), 0, 0)
        assert dll.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == 0
        assert dll.fmi2EnterInitializationMode(c) == 0
        assert dll.fmi2ExitInitializationMode(c) == 0
        assert dll.fmi2DoStep(c, 0.0, 0.01, 1) == 0
        dll.fmi2FreeInstance(c)

    for _ in range(100):
        live()
    before = resident()
    seconds = shortest(live, 1, count)
    return {"bytes": resident() - before, "seconds": seconds}


if __name__ == "__main__":
    print(json.dumps(globals()[sys.argv[1]](*json.loads(sys.argv[2]))))
