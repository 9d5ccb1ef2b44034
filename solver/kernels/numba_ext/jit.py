"""Decorators of kernels: numba's in a process that compiles, none in all others, which run machine code.

A process compiles if MULTIBLOCK_COMPILES=1 is in its environment when it imports this module: make.py is started with
it. Processes that it starts do not inherit it.
"""

import os
from collections.abc import Callable
from functools import partial
from typing import Any, NoReturn

COMPILES = os.environ.pop("MULTIBLOCK_COMPILES", "") == "1"


def for_kernels(*_: Any, **__: Any) -> NoReturn:
    """Raise NotImplementedError, in place of a function that only kernels can call."""
    raise NotImplementedError("for kernels only")


if COMPILES:
    from .compiling import as_written, by_width, from_python, in_both, kernel, leaf, native, varied, varied_leaf
else:

    def _unchanged(function: Any) -> Any:
        return function

    def by_width(chooses: Callable[..., Any], leaf: bool = True) -> Callable[..., Any]:
        """Return a stand-in."""
        return for_kernels

    def varied(function: Callable[..., Any], leaf: bool = False) -> Any:
        """Return a stand-in whose versions remain plain functions."""
        stand_in: Any = partial(for_kernels)
        stand_in.version = lambda suits: _unchanged
        return stand_in

    kernel = leaf = in_both = _unchanged
    varied_leaf = partial(varied, leaf=True)
    as_written = from_python = native = for_kernels

__all__ = [
    "COMPILES",
    "as_written",
    "by_width",
    "for_kernels",
    "from_python",
    "in_both",
    "kernel",
    "leaf",
    "native",
    "varied",
    "varied_leaf",
]
