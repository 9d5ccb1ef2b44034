"""A line before kernels are compiled, which takes long and is done once: of numba's events, so that no call is silent.

From Python it is written to stderr if that is a terminal; commands print it themselves, in a pipe too.
"""

from __future__ import annotations

import multiprocessing
import sys
from typing import Any

from numba.core.event import Listener, register

# by the package of kernels and what their names begin with: what they are for, s on two cores (measured)
TAKES = {
    ("api", "run"): ("columns", 30),
    ("paper", "run"): ("the paper's columns", 10),
    ("batch", "run"): ("columns in lanes", 10),
    ("structure", "run_structures_in_lanes"): ("structures in lanes", 10),
    ("structure", ""): ("structures", 35),
}
OURS = __name__.removesuffix(".common.waiting")  # an FMU has a copy of the solver under a name of its own
_said: set[str] = set()


def notice(module: str, name: str) -> str:
    """The line for an entry of the kernels that is about to be compiled; empty if it is quick, or has been said."""
    for (package, begin), (what, seconds) in TAKES.items():
        if module == f"{OURS}.kernels.{package}.entries" and name.startswith(begin):
            first = what not in _said
            _said.add(what)
            return f"compiling the kernels of {what}, once: about {seconds} s" if first else ""
    return ""


class _Compiling(Listener):
    """Is called by numba, under its lock, when it begins to compile a function and when it has ended."""

    depth = 0

    def on_start(self, event: Any) -> None:
        """Entries compile what they call: only they are announced."""
        self.depth += 1
        if self.depth == 1 and multiprocessing.parent_process() is None and sys.stderr and sys.stderr.isatty():
            entry = event.data["dispatcher"].py_func
            line = notice(entry.__module__, entry.__name__)
            if line:
                print(line, file=sys.stderr, flush=True)

    def on_end(self, event: Any) -> None:
        """Leave it."""
        self.depth -= 1


def announce() -> None:
    """Listen from now on."""
    register("numba:compile", _Compiling())  # type: ignore[no-untyped-call]
