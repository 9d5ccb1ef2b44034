"""Work sent out in pieces, wherever an executor takes them, and what comes of each as it ends.

An executor is anything with `submit(function, *arguments)` that returns futures with `result`, `cancel` and
`add_done_callback`: those of concurrent.futures, a client of Dask, studies/cluster.py.
"""

from __future__ import annotations

import os
import queue
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from typing import Any, TypeVar

from .errors import InputError, shown

AHEAD = 2  # pieces out for each worker: one waits while the other is worked at
TRIES = 3  # of a piece whose worker died
PATIENCE = 120.0  # s for what comes of a piece that is done to come from the worker
LISTEN = 0.05  # s between two looks whether somebody interrupts, or the executor is still there

Piece = TypeVar("Piece")


def sent_out(
    pieces: Iterator[Piece],
    submit: Callable[[Piece], Any],
    workers: int,
    *,
    failed: Callable[[Piece, int, BaseException], None],
    error: Callable[[str], Exception],
    idle: Callable[[], None] = lambda: None,
) -> Iterator[tuple[Piece, Any]]:
    """Pieces and what came of them, as they end; a piece is asked for when a worker is about to need it.

    failed: called with a piece, how often it was tried and what was wrong; it raises, or the piece is sent again.
    error: what is raised, with what is to be said, where the executor takes no more. idle: called while nothing ends.
    """
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
    under_way: dict[Any, tuple[Piece, int]] = {}

    def send(piece: Piece, tries: int) -> None:
        try:
            future = submit(piece)
        except Exception as refusal:  # of whatever kind of executor
            raise error(f"the executor takes no more runs: {said(refusal)}") from refusal
        under_way[future] = piece, tries
        future.add_done_callback(ended.put)

    try:
        while True:
            while len(under_way) < AHEAD * workers:
                try:
                    piece = next(pieces)
                except StopIteration:
                    break
                send(piece, 1)
            if not under_way:
                return
            try:
                future = ended.get(timeout=LISTEN)
            except queue.Empty:
                idle()
                continue
            piece, tries = under_way.pop(future)
            try:
                made = future.result(timeout=PATIENCE)
            except (Exception, CancelledError) as wrong:  # of whatever kind: its worker died, or the program is wrong
                failed(piece, tries, wrong)
                send(piece, tries + 1)
                continue
            yield piece, made
    finally:
        for future in under_way:
            future.cancel()


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def workers_of(executor: Any) -> int:
    """How many pieces an executor works at. Raises InputError if it is none."""
    if not hasattr(executor, "submit"):
        raise InputError(f"executor = {shown(executor)}: must have submit, as those of concurrent.futures")
    if hasattr(executor, "nthreads"):  # a client of Dask
        return max(1, int(sum(executor.nthreads().values())))
    return int(getattr(executor, "workers", 0) or getattr(executor, "_max_workers", 0)) or cores()


def said(error: BaseException) -> str:
    """What kind of error it is and the first line of what it says."""
    return f"{type(error).__name__}: {error}".splitlines()[0]
