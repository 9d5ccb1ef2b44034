"""Several FMUs in one process."""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Callable
from math import sin
from pathlib import Path
from typing import Any

from fmu_src.host import finalize_at_exit
from support.instance import Instance, unpacked


def steps(column: Instance, first: int = 0, last: int = 200) -> list[Any]:
    """Return all outputs after some steps."""
    for k in range(first, last):
        column.set({"base.ax": 1.2 * sin(0.12 * k)})
        column.step(0.01 * k, 0.01)
    return column.get()


def in_threads(calls: list[Callable[[], Any]]) -> list[Any]:
    """Return the result of each call, made in a thread of its own."""
    results: list[Any] = [None] * len(calls)

    def work(k: int) -> None:
        results[k] = calls[k]()

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(calls))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return results


def alone(fmu: str) -> list[Any]:
    """Return one column alone."""
    return steps(Instance(fmu))


def together(fmus: list[str]) -> dict[str, Any]:
    """Return the outputs of each FMU alone, and whether they are the same in turns and in threads."""
    by_itself = [alone(fmu) for fmu in fmus]
    columns = [Instance(fmu) for fmu in fmus]
    for k in range(199):
        for column in columns:
            steps(column, k, k + 1)
    in_turns = [steps(column, 199, 200) for column in columns] == by_itself
    threaded = []
    for _ in range(5):
        columns = [Instance(fmu) for fmu in fmus]
        threaded.append(in_threads([lambda column=column: steps(column) for column in columns]) == by_itself)  # type: ignore[misc]
    return {"alone": by_itself, "in turns": in_turns, "in threads": threaded}


def beside(ours: str, theirs: str, ours_first: bool) -> tuple[list[Any], list[float]]:
    """Return our outputs beside an FMU of another tool, and its own.

    The other FMU is left as ours leaves itself (host.finalize_at_exit): PythonFMU's library frees its Python state
    twice at the end of a process otherwise, also without an instance, and aborts it now and then.
    """
    folder = unpacked(theirs)
    finalize_at_exit(Path(folder, "resources"))
    if ours_first:
        column, other = Instance(ours), Instance(theirs, folder=folder)
    else:
        other, column = Instance(theirs, folder=folder), Instance(ours)
    outputs = steps(column)
    other.step(0.0, 1.0)
    other.step(1.0, 1.0)
    y = other.get("y")
    other.close()
    return outputs, y


def steps_during_a_long_one(fmu: str) -> int:
    """Return how many steps one instance makes while another makes a single long one."""
    slow = Instance(fmu, {"base.ax": 0.5, "base.jx": -1e-3, "solver.tolerance": 1e-12})
    quick = Instance(fmu, {"base.ax": 0.5})
    done = threading.Event()

    def work() -> None:
        slow.step(0.0, 300.0)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    made = 0
    while not done.is_set():
        quick.step(0.01 * made, 0.01)
        made += 1
    thread.join()
    return made


def resident() -> int:
    """Return the memory of this process, bytes."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def left_behind(fmu: str) -> tuple[int, int]:
    """Return the bytes, and entries of the search path, that 300 lives leave behind."""
    folder = unpacked(fmu)

    def live() -> None:
        column = Instance(fmu, {"base.ax": 0.5}, folder=folder)
        column.step(0.0, 0.1)
        column.get()
        column.close()

    for _ in range(20):
        live()
    before, entries = resident(), len(sys.path)
    for _ in range(300):
        live()
    return resident() - before, len(sys.path) - entries


def build_foreign(folder: str) -> None:
    """Build the FMU of another tool from its folder."""
    from pythonfmu import FmuBuilder

    sys.path.insert(0, folder)
    FmuBuilder.build_FMU(f"{folder}/foreign.py", dest=folder, project_files=[f"{folder}/solver.py"])
