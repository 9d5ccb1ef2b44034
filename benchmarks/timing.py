"""Run times: the shortest of warm runs."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TypeVar

T = TypeVar("T")

LEAST_RUNS = 3
MOST_RUNS = 25
ROUNDS = 15
ENOUGH = 0.01  # s that a round of a short function lasts, at least


def fastest(run: Callable[[], T], budget: float) -> tuple[T, float, int]:
    """Return what `run` returns, the shortest of its times in s, and the number of runs.

    A function that takes longer than the budget, s, runs once; any other runs until the budget is spent.
    """
    best, spent, runs = float("inf"), 0.0, 0
    while runs == 0 or (spent < budget and runs < MOST_RUNS) or (best < budget and runs < LEAST_RUNS):
        begin = time.perf_counter()
        result = run()
        lasted = time.perf_counter() - begin
        best = min(best, lasted)
        spent += lasted
        runs += 1
    return result, best, runs


def loops(runs: Sequence[Callable[[], object]], enough: float = ENOUGH, rounds: int = ROUNDS) -> list[float]:
    """Return the seconds of one call of each, the shortest of rounds of loops that last at least `enough` s.

    The rounds alternate, so that a disturbance from outside affects all alike.
    """
    counts = [_count(run, enough) for run in runs]
    best = [float("inf")] * len(runs)
    for _ in range(rounds):
        for k, run in enumerate(runs):
            begin = time.perf_counter()
            for _ in range(counts[k]):
                run()
            best[k] = min(best[k], (time.perf_counter() - begin) / counts[k])
    return best


def _count(run: Callable[[], object], enough: float) -> int:
    """Return the number of calls that last at least `enough` s."""
    count = 1
    while True:
        begin = time.perf_counter()
        for _ in range(count):
            run()
        if time.perf_counter() - begin >= enough:
            return count
        count *= 2
