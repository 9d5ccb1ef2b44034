"""How many runs are sent out at once: as many as keep a worker busy for some seconds, going by what the last took."""

from __future__ import annotations

import math

from .kernels.lanes import WIDTH

CHUNK_SECONDS = 2.0  # of the clock, for a worker
FIRST_SECONDS = 0.2  # of the first chunks, whose cost is guessed, and of those at the end
LEAST_RUNS, MOST_RUNS = 16, 2000  # in a chunk: lanes are refilled; rows of a run take memory
GROWTH = 4.0  # of a chunk over what the one before says: its runs may have been unlike those to come


class Pace:
    """Says when a chunk has enough runs. total: of all runs, None where that is not known.

    guess: s for a unit of weight, whatever runs are weighed by, before anything is known.
    """

    def __init__(self, total: int | None, workers: int, guess: float, seconds: float = CHUNK_SECONDS) -> None:
        self._left, self._workers, self._wanted = total, workers, seconds
        self._cost, self._seconds = guess, min(FIRST_SECONDS, seconds)
        self._per_run, self._most = math.inf, MOST_RUNS

    def learn(self, runs: int, weight: float, seconds: float) -> None:
        """Go by what the last chunk took."""
        self._cost, self._per_run = max(seconds, 1e-6) / weight, max(seconds, 1e-6) / runs
        self._seconds = self._wanted
        self._most = min(MOST_RUNS, int(GROWTH * max(runs, LEAST_RUNS)))

    def sent(self, count: int) -> None:
        """Note that so many runs have gone out."""
        if self._left is not None:
            self._left -= count

    def enough(self, count: int, weight: float) -> bool:
        """Whether so many runs of this weight make a chunk. Towards the end all workers shall have some."""
        if count % WIDTH:  # lanes would be left empty
            return False
        if self._left is not None:
            rest = self._left - count
            whole = weight * self._cost * (1.0 + rest / count)  # s, with the rest, by which lanes would be left empty
            if self._workers == 1 and 0 < rest < LEAST_RUNS and whole <= self._wanted:
                return False
            share = self._left / (self._workers if self._per_run == math.inf else 2 * self._workers)
            if count >= max(LEAST_RUNS, FIRST_SECONDS / self._per_run, share):
                return True
        return count >= self._most or weight * self._cost >= self._seconds
