"""Equal runs by threads, by processes and on Dask, in turn: runs per second, and processor time of each process.

Clock time is the time a user waits; processor time is the fair measure where other work takes the cores. The scheduler
of Dask and the code that sends the runs out are in this process, whose time is listed separately.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

import numpy as np

from solver import InputError, simulate_many
from solver.studies import Study, run_study
from solver.studies.cluster import Cluster

from .studies import ROCKING, STUDY, phocas_runs

WORKERS = 2
ROUNDS = 3
SECONDS, QUICK_SECONDS = 25.0, 2.0  # of a round of each
TRIAL = 1000  # runs that show how long one takes
FEW = 64  # runs in which workers start and load the kernels
TOLERANCE = 1e-2  # of Phocas: an error of 1e-3
STEADY = (0.2, 0.8)  # parts of the runs between which all workers have whole chunks
WAYS = ("threads", "processes", "dask")
Work = Callable[..., object]  # to be called with `threads` or `executor`, and `callback`


@dataclass
class Spent:
    """Time spent in some rounds."""

    runs: int = 0
    seconds: float = 0.0  # of the clock
    steady_runs: int = 0
    steady_seconds: float = 0.0
    own: float = 0.0  # s of the processor, of this process
    workers: float = 0.0  # s of the processor, of the workers

    def as_dict(self) -> dict[str, float]:
        """Return runs per second of the clock, in all and in the middle; s of the processor for 1000 runs."""
        return {
            "runs": self.runs,
            "throughput": self.runs / self.seconds,
            "steady": self.steady_runs / self.steady_seconds if self.steady_seconds else 0.0,
            "own": 1e3 * self.own / self.runs,
            "workers": 1e3 * self.workers / self.runs,
        }


def columns_sent(count: int) -> Work:
    """Return `count` runs of damped Phocas, whose columns are sent with them."""
    columns, motions, duration = phocas_runs(count, ROCKING)
    return lambda **options: simulate_many(columns, motions, duration=duration, tolerance=TOLERANCE, **options)


def numbers_sent(count: int) -> Work:
    """Return `count` runs of the fragility study, of which only the numbers are sent."""
    study = Study.from_toml(STUDY).with_runs(count)
    return lambda **options: run_study(study, **options)


SCENES: dict[str, Callable[[int], Work]] = {
    "damped Phocas by `simulate_many`": columns_sent,
    "the fragility study by `run_study`": numbers_sent,
}


def follow(work: Work, options: dict[str, Any], workers: Sequence[Any], spent: Spent) -> None:
    """Add the time of a round. workers: processes, as of psutil."""
    ended: list[tuple[float, int]] = []
    own, theirs, begin = clock.process_time(), processor(workers), clock.perf_counter()
    work(**options, callback=lambda done, total: ended.append((clock.perf_counter(), done)))
    spent.seconds += clock.perf_counter() - begin
    spent.own += clock.process_time() - own
    spent.workers += processor(workers) - theirs
    times, done = np.array(ended).T
    spent.runs += int(done[-1])
    middle = np.flatnonzero((done >= STEADY[0] * done[-1]) & (done <= STEADY[1] * done[-1]))
    if middle.size > 1:
        spent.steady_runs += int(done[middle[-1]] - done[middle[0]])
        spent.steady_seconds += times[middle[-1]] - times[middle[0]]


def processor(workers: Sequence[Any]) -> float:
    """Return the processor time used by the processes, s."""
    return sum(sum(worker.cpu_times()[:2]) for worker in workers)


def compare(making: Callable[[int], Work], seconds: float) -> dict[str, dict[str, float]]:
    """Compare throughput and times by each way, in rounds of about `seconds` s. Raises InputError without Dask."""
    import psutil  # installed with Dask

    def children() -> set[Any]:
        return set(psutil.Process().children(recursive=True))

    few = making(FEW)
    few(threads=WORKERS)
    begin = clock.perf_counter()
    making(TRIAL)(threads=WORKERS)
    whole = making(int(TRIAL * seconds / (clock.perf_counter() - begin)))
    with ExitStack() as stack:
        before = children()
        pool = stack.enter_context(ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")))
        few(executor=pool)
        of_pool = children() - before
        cluster = stack.enter_context(Cluster(workers=WORKERS))
        few(executor=cluster)
        of_cluster = children() - of_pool - before
        ways: dict[str, tuple[dict[str, Any], set[Any]]] = {
            "threads": ({"threads": WORKERS}, set()),
            "processes": ({"executor": pool}, of_pool),
            "dask": ({"executor": cluster}, of_cluster),
        }
        spent = {way: Spent() for way in ways}
        for _ in range(ROUNDS):
            for way, (options, workers) in ways.items():
                follow(whole, options, list(workers), spent[way])
    return {way: found.as_dict() for way, found in spent.items()}


def measure(quick: bool) -> dict[str, Any]:
    """Measure for each scene the comparison of all ways, or the reason why it is not measured."""
    try:
        return {scene: compare(making, QUICK_SECONDS if quick else SECONDS) for scene, making in SCENES.items()}
    except (InputError, ModuleNotFoundError) as error:
        return {"absent": str(error)}


def parts(found: dict[str, dict[str, float]], way: str) -> dict[str, float]:
    """Return the throughput of a way in parts of that of threads: of the clock, in the middle, of the processor."""
    of, threads = found[way], found["threads"]
    return {
        "clock": of["throughput"] / threads["throughput"],
        "steady": of["steady"] / threads["steady"] if threads["steady"] else 0.0,
        "processor": (threads["own"] + threads["workers"]) / (of["own"] + of["workers"]),
    }
