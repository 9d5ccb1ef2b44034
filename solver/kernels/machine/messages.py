"""What is said of machine code: that it is made now, and that there is none."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class MachineCodeError(ImportError):
    """There is no machine code for this processor, and none can be made."""


def on_terminal(line: str) -> None:
    """Print a line on a terminal, but from worker processes."""
    if sys.stderr and sys.stderr.isatty():
        from multiprocessing import parent_process

        if parent_process() is None:
            print(line, file=sys.stderr, flush=True)


_announce: Callable[[str], None] = on_terminal


def announce(line: str) -> None:
    """Say what is going to be made, and how long it takes."""
    _announce(line)


@contextmanager
def announcing(say: Callable[[str], None]) -> Iterator[None]:
    """Let another function say what is made, within this context."""
    global _announce
    usual, _announce = _announce, say
    try:
        yield
    finally:
        _announce = usual
