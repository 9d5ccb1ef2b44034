"""Messages about machine code: that it is being made, and that none is available."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class MachineCodeError(ImportError):
    """The error of missing machine code: there is none for this processor, and none can be made."""


def on_terminal(line: str) -> None:
    """Print a line if stderr is a terminal, except in worker processes."""
    if sys.stderr and sys.stderr.isatty():
        from multiprocessing import parent_process

        if parent_process() is None:
            print(line, file=sys.stderr, flush=True)


_announce: Callable[[str], None] = on_terminal


def announce(line: str) -> None:
    """Report what is going to be made, and how long it takes."""
    _announce(line)


@contextmanager
def announcing(say: Callable[[str], None]) -> Iterator[None]:
    """Send announcements to another function within this context."""
    global _announce
    usual, _announce = _announce, say
    try:
        yield
    finally:
        _announce = usual
