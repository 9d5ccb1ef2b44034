"""Threads that make runs do their Python by turns, and their kernels at the same time.

Numpy gives the interpreter's lock up for a moment in every call on more than some hundred numbers. Where another thread
waits for it, it is gone, and both spend their time on waking each other: measured, two threads were slower than one.
So a thread keeps its turn for all of its Python, and lets others have theirs while a kernel runs.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

_turn = threading.Lock()
_own = threading.local()  # has `held` where the turn is this thread's


@contextmanager
def my_turn() -> Iterator[None]:
    """Wait until no other thread has its turn, and keep it."""
    if getattr(_own, "held", False):
        yield
        return
    with _turn:
        _own.held = True
        try:
            yield
        finally:
            _own.held = False


@contextmanager
def others_turn() -> Iterator[None]:
    """Let others have their turn, if this thread has it."""
    if not getattr(_own, "held", False):
        yield
        return
    _own.held = False
    _turn.release()
    try:
        yield
    finally:
        _turn.acquire()
        _own.held = True
