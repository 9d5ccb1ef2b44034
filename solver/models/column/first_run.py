"""The machine code of the kernels, compiled by two processes at once if it is not cached.

Nearly all of it belongs to two entries. One is compiled here, the other in a second process, which leaves it in numba's
cache: two thirds of the time on two cores.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numba import typeof

from ...kernels.api import entries as exact
from .packing import unwritten
from .stepper import SILENCE

_SILENCE = (*SILENCE.arguments, np.empty(0))  # and no ports


def are_kept(entry: Any = exact.run) -> bool:
    """Whether the machine code of an entry is in the cache on disk, or in this process."""
    if entry.overloads:
        return True
    folder = entry.stats.cache_path
    return folder is not None and any(Path(folder).glob(f"*.{entry.py_func.__qualname__}-*.nbc"))


def is_made(entry: Any) -> bool:
    """Return True if machine code of an entry is in this process, or kept for this processor, Python and numba.

    True if that cannot be found out: `_cache_file` is a private name of numba.
    """
    if entry.overloads:
        return True
    if entry.stats.cache_path is None:
        return False
    try:
        here = entry.targetctx.codegen().magic_tuple()
        return any(machine == here for _, machine in entry._cache._cache_file._load_index())
    except Exception:
        return True


def make_kernels(entries: Any = exact) -> None:
    """Have the entries of a module that every run needs in this process: read from the disk, or compiled."""
    needed = entries.run, entries.assemble_column, entries.observe_snapshots, entries.observe_state
    if all(entry.overloads for entry in needed):
        return
    beside = None if are_kept(entries.run) else _process_beside(entries)
    try:
        compile_for(entries.run, *_column(), *_SILENCE, 0.0, 0.0, np.empty(0), np.empty(0), True)
        if beside is not None:
            beside.wait()
    finally:
        if beside is not None:
            beside.kill()
    compile_the_rest(entries)  # read from the disk where the other process left it


def _process_beside(entries: Any) -> subprocess.Popen[bytes] | None:
    """A process that compiles the rest; none in a worker of a pool, nor where Python is embedded in another program."""
    cached = entries.run.stats.cache_path is not None
    is_python = Path(sys.executable or "").stem.lower().startswith("python")
    if not cached or not is_python or multiprocessing.parent_process() is not None:
        return None
    program = (
        f"import {entries.__name__} as entries; from {__name__} import compile_the_rest; compile_the_rest(entries)"
    )
    command = [sys.executable, "-P", "-c", program]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    quiet: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
    try:
        return subprocess.Popen(command, env=environment, **quiet)
    except OSError:
        return None


def compile_the_rest(entries: Any) -> None:
    """Compile, or read from the disk, all entries that a run needs besides `run`."""
    row = np.empty(0)
    compile_for(entries.assemble_column, *_column(), row, 1, row, row)
    compile_for(entries.observe_snapshots, *_column(), *_SILENCE, row, row, row, 1)
    compile_for(entries.observe_state, *_column(), *_SILENCE, 0.0, row, row)
    compile_for(entries.arrive_base, 1, row, row, row, 0.0)
    compile_for(entries.couple_base, 1, row, row, row, row)
    compile_for(entries.examine_base, 1, row, row, 0.0)


def _column() -> tuple[Any, ...]:
    return 1, *unwritten(1)  # other spaces have the same types


def compile_for(entry: Any, *arguments: Any) -> None:
    """Compile for arguments of these types."""
    entry.compile(tuple(map(typeof, arguments)))
