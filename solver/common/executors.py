"""Tasks sent to any executor, and their results in the order of completion.

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
from itertools import islice
from typing import Any, TypeVar

from .errors import InputError, shown

AHEAD = 2  # tasks submitted for each worker: one waits while the other is processed
TRIES = 3  # attempts at a task whose worker died
PATIENCE = 120.0  # s, timeout for the result of a finished task to arrive from the worker
LISTEN = 0.05  # s between two checks for an interrupt by the user or a lost executor

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
    """Send tasks to an executor and yield each with its result, in the order of completion.

    A task is requested from `pieces` only when a worker is about to need it.

    Parameters
    ----------
    pieces : iterator
        The tasks.
    submit : callable
        Called with a task; returns its future.
    workers : int
        The number of tasks processed at once.
    failed : callable
        Called with a task, the number of attempts and the error; unless it raises, the task is submitted again.
    error : callable
        Called with a message; returns the exception to raise when the executor refuses tasks.
    idle : callable
        Called while no task completes.

    Yields
    ------
    tuple
        A task and its result.
    """
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
    under_way: dict[Any, tuple[Piece, int]] = {}

    def send(piece: Piece, tries: int) -> None:
        try:
            future = submit(piece)
        except Exception as refusal:  # the kind depends on the executor
            raise error(f"the executor takes no more runs: {error_text(refusal)}") from refusal
        under_way[future] = piece, tries
        future.add_done_callback(ended.put)

    try:
        while True:
            # keep the queue of the executor filled
            for piece in islice(pieces, AHEAD * workers - len(under_way)):
                send(piece, 1)
            if not under_way:
                return
            # wait for the next completion
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
    # cancel all other tasks if the caller stops early
    finally:
        for future in under_way:
            future.cancel()


def end_with_parent() -> None:
    """End this process soon after its parent process, however the parent ends; an initializer for workers.

    It waits for the end of the pipe that multiprocessing keeps between the two. Ctrl-C, which a terminal sends to all
    processes, is left to the parent.
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
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def workers_of(executor: Any) -> int:
    """Return the number of tasks that an executor processes at once. Raises InputError if it has no `submit`."""
    if not hasattr(executor, "submit"):
        raise InputError(f"executor = {shown(executor)}: must have submit, as those of concurrent.futures")
    if hasattr(executor, "nthreads"):  # a client of Dask
        return max(1, int(sum(executor.nthreads().values())))
    return int(getattr(executor, "workers", 0) or getattr(executor, "_max_workers", 0)) or cores()


def error_text(error: BaseException) -> str:
    """Return the type of an error and the first line of its message."""
    return f"{type(error).__name__}: {error}".splitlines()[0]
