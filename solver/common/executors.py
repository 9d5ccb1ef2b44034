"""Pieces of work sent to any executor, and their results as they end.

An executor is anything with `submit(function, *arguments)` that returns futures with `result`, `cancel` and
`add_done_callback`: those of concurrent.futures, a client of Dask, studies/cluster.py.
"""

from __future__ import annotations

import multiprocessing
import os
import queue
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from typing import Any, TypeVar

from .errors import InputError, shown

AHEAD = 2  # pieces out for each worker: one waits while the other is processed
TRIES = 3  # of a piece whose worker died
PATIENCE = 120.0  # s for the result of a finished piece to arrive from the worker
LISTEN = 0.05  # s between two checks for an interrupt by the user and for an executor that is gone

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
    """Pieces and their results, as they end; a piece is requested when a worker is about to need it.

    failed: called with a piece, the number of tries and the error; it raises, or the piece is sent again.
    error: makes the exception, from its message, that is raised when the executor takes no more. idle: called while
    nothing ends.
    """
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
    under_way: dict[Any, tuple[Piece, int]] = {}

    def send(piece: Piece, tries: int) -> None:
        try:
            future = submit(piece)
        except Exception as refusal:  # the kind depends on the executor
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
            except (Exception, CancelledError) as wrong:  # of any kind: its worker died, or the program is wrong
                failed(piece, tries, wrong)
                send(piece, tries + 1)
                continue
            yield piece, made
    finally:
        for future in under_way:
            future.cancel()


def end_with_parent() -> None:
    """End this process soon after its parent process, however the parent ends: an initializer for workers.

    It waits for the end of the pipe that multiprocessing keeps between the two. Ctrl-C, which a terminal sends to all
    processes, is the parent's to answer.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, name="end with parent", daemon=True).start()


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def workers_of(executor: Any) -> int:
    """How many pieces an executor processes at once. Raises InputError if it is no executor."""
    if not hasattr(executor, "submit"):
        raise InputError(f"executor = {shown(executor)}: must have submit, as those of concurrent.futures")
    if hasattr(executor, "nthreads"):  # a client of Dask
        return max(1, int(sum(executor.nthreads().values())))
    return int(getattr(executor, "workers", 0) or getattr(executor, "_max_workers", 0)) or cores()


def said(error: BaseException) -> str:
    """The kind of an error and the first line of its message."""
    return f"{type(error).__name__}: {error}".splitlines()[0]
