"""The modules that an import loads."""

from __future__ import annotations

import importlib
import sys


def loaded_with(module: str, others: list[str]) -> list[str]:
    """Return which of `others` are loaded once `module` is imported."""
    importlib.import_module(module)
    return [name for name in others if name in sys.modules]


def with_numba(version: str) -> str:
    """Return the message of the import of what compiles kernels, under a numba of that version."""
    import numba

    numba.__version__ = version
    try:
        importlib.import_module("solver.kernels.numba_ext.lane_types")
    except ImportError as error:
        return str(error)
    return ""
