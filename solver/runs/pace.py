"""The size of the chunks sent to workers: some seconds of work, estimated from the last chunk.

While the last runs of a chunk end, most lanes have none: a chunk of few costly runs may take longer.
"""

from __future__ import annotations

import math

from ..kernels.numba_ext.lanes import WIDTH

CHUNK_SECONDS = 2.0  # of wall-clock time, for a worker
FIRST_SECONDS = 0.2  # of the first chunks, whose cost is a guess, and of the last ones
LEAST_RUNS, MOST_RUNS = 16, 2000  # in a chunk: enough to refill lanes, and bounded since the rows of a run take memory
# runs of a chunk that keep lanes full although their lengths differ; factor on the seconds of one that has fewer
FILLED, LONGER = 64, 5.0
GROWTH = 4.0  # largest ratio of a chunk to the previous one: the next runs may cost more


class Pace:
    """An estimator that decides when a chunk has enough runs.

    Parameters
    ----------
    total : int or None
        Number of all runs, if known.
    workers : int
        Number of workers.
    guess : float
        Cost of a unit of weight, s, before any chunk is measured.
    seconds : float
        Target cost of a chunk, s of wall-clock time; of one with fewer than 64 runs the largest is 5 times that.
    """

    def __init__(self, total: int | None, workers: int, guess: float, seconds: float = CHUNK_SECONDS) -> None:
        self._left, self._workers, self._wanted = total, workers, seconds
        self._share = 0.0 if total is None else total / workers
        self._cost, self._seconds = guess, min(FIRST_SECONDS, seconds)
        self._per_run, self._most = math.inf, MOST_RUNS

    def update_cost(self, runs: int, weight: float, seconds: float) -> None:
        """Update the cost from the time of the last chunk."""
        self._cost, self._per_run = max(seconds, 1e-6) / weight, max(seconds, 1e-6) / runs
        self._seconds = self._wanted
        self._most = min(MOST_RUNS, int(GROWTH * max(runs, LEAST_RUNS)))

    def sent(self, count: int) -> None:
        """Note that `count` runs have been sent."""
        if self._left is not None:
            self._left -= count

    def enough(self, count: int, weight: float) -> bool:
        """Return True if `count` runs of this weight make a chunk; near the end every worker should get some."""
        if count % WIDTH:  # some lanes would be empty
            return False
        if self._left is not None:
            rest = self._left - count
            whole = weight * self._cost * (1.0 + rest / count)  # s, with the rest, which alone would leave lanes empty
            if self._workers == 1 and 0 < rest < LEAST_RUNS and whole <= 2.0 * LONGER * self._wanted:
                return False
            alike = self._workers == 1 or self._per_run == math.inf
            share = self._share if alike else 0.5 * self._left / self._workers
            if count >= max(LEAST_RUNS, FIRST_SECONDS / self._per_run, share):
                return True
        seconds = self._seconds if count >= FILLED else LONGER * self._wanted
        return count >= self._most or weight * self._cost >= seconds
