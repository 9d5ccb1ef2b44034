"""Turns of threads that make runs: one at a time executes Python, while the kernels of others run.

NumPy releases the interpreter's lock for a moment in every call on more than some hundred numbers. A waiting thread
takes it, and both spend their time on waking each other: measured, two threads were slower than one. So a thread keeps
a lock for all of its Python, and releases it while a kernel runs.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

_turn = threading.Lock()
_own = threading.local()  # has `held` if this thread has the lock


@contextmanager
def lock_held() -> Iterator[None]:
    """Hold the lock for Python within the context; do nothing if this thread has it already."""
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
def lock_released() -> Iterator[None]:
    """Release the lock for Python within the context; do nothing if this thread does not have it."""
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
