"""The time in which a command loads its modules: Ctrl-C, or a setting that numba cannot take, ends it with one line.

`solver/__init__.py` begins with it, because modules take a second or more to load. It does not affect programs that
import the solver: their Ctrl-C and their environment stay as they are.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from typing import Any, NoReturn

INTERRUPTED = 130  # exit code, as of shells
THREADS = "NUMBA_NUM_THREADS"
_SCRIPTS = {"multiblock": "multiblock", "build_fmu.py": "build_fmu.py"}


def begin() -> None:
    """Until `done`: Ctrl-C ends the process with one line and code 130; settings that stop numba end it with 2."""
    program = _program()
    if not program:
        return
    threads = os.environ.get(THREADS)
    if threads and not (threads.isascii() and threads.isdigit() and int(threads) > 0):
        _end(f"{program}: {THREADS} = {threads!r}: must be a whole number, at least 1, or not set", 2)
    if _is_heard():

        def end(*_: Any) -> None:
            _end(f"{program}: interrupted", INTERRUPTED)

        end.ours = True  # type: ignore[attr-defined]
        with suppress(ValueError):  # not in the main thread
            signal.signal(signal.SIGINT, end)


def done() -> None:
    """From here on Ctrl-C raises KeyboardInterrupt again."""
    if getattr(signal.getsignal(signal.SIGINT), "ours", False):
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _is_heard() -> bool:
    """Whether Ctrl-C has Python's own handler: it is not ignored, and no other program handles it."""
    return signal.getsignal(signal.SIGINT) is signal.default_int_handler


def _program() -> str:
    """The name of the command that this process runs; empty if it is no command of the project."""
    words, arguments = getattr(sys, "orig_argv", []), getattr(sys, "argv", [])  # a host of Python may have neither
    if "--multiprocessing-fork" in words:  # a worker
        return ""
    module = words[words.index("-m") + 1 :][:1] if "-m" in words else []
    if module in (["solver"], ["multiblock"]):
        return "python -m solver" if module == ["solver"] else "multiblock"
    return _SCRIPTS.get(os.path.basename(arguments[0]).removesuffix(".exe"), "") if arguments else ""


def _end(line: str, code: int) -> NoReturn:
    """Leave at once: modules that are half loaded cannot be cleaned up."""
    os.write(2, f"{line}\n".encode(errors="backslashreplace"))
    os._exit(code)
