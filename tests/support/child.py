"""A function called in a process of its own: what an FMU does to a process, it does not do to the tests.

Such functions stand in the modules of `inside/`, which a new process can import without the tests. They take and return
what JSON can carry; paths arrive as text.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

if __name__ == "__main__":  # whatever PYTHONPATH is there
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.fmus import ROOT, environment, finish, run

CHILD_FILE = __file__
MARK = "returned: "  # before the result, among whatever else the process prints


def command(function: Callable[..., object], *arguments: object, **named: object) -> list[str]:
    """Return the command line of a process that calls the function and prints what it returns."""
    given = json.dumps([arguments, named], default=str)
    return [sys.executable, __file__, function.__module__, function.__name__, given]


def call(function: Callable[..., object], *arguments: object, **named: object) -> Any:
    """Return the value that the function returns there; fails unless the process exits with 0."""
    return returned(run(*command(function, *arguments, **named)))


def call_with_example(function: Callable[..., object], *arguments: object, **variables: str) -> Any:
    """Call as `call` does, with the modules of examples/coupling in reach and more variables in the environment."""
    return returned(run(*command(function, *arguments), PYTHONPATH=_with_example(), **variables))


def ended_with_example(function: Callable[..., object], *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run as `ended` does, with the same modules in reach."""
    return finish(*command(function, *arguments), PYTHONPATH=_with_example())


def _with_example() -> str:
    return os.pathsep.join((str(ROOT / "examples" / "coupling"), environment()["PYTHONPATH"]))


def ended(function: Callable[..., object], *arguments: object, **named: object) -> subprocess.CompletedProcess[str]:
    """Return the process after its end, whatever it exits with; `returned` finds the result in what it printed."""
    return finish(*command(function, *arguments, **named))


def returned(printed: str) -> Any:
    """Return the result among all that a process printed."""
    (line,) = [line for line in printed.splitlines() if line.startswith(MARK)]
    return json.loads(line.removeprefix(MARK))


def said(printed: str) -> list[str]:
    """Return the lines that are not the result."""
    return [line for line in printed.splitlines() if not line.startswith(MARK)]


def main() -> None:
    """Call what the command line names."""
    module, name, given = sys.argv[1:]
    arguments, named = json.loads(given)
    result = getattr(importlib.import_module(module), name)(*arguments, **named)
    print(MARK + json.dumps(result), flush=True)


if __name__ == "__main__":
    main()
