"""The one place for compiler options.

`fastmath` stays off: contraction and reassociation would break mirror symmetry and repeatability to the last bit.
`error_model="numpy"` divides by zero as IEEE 754 does instead of raising.
"""

from collections.abc import Callable
from typing import Any

from numba import njit

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": False, "nogil": True}

# Building block of a kernel: compiled, and cached, as a part of whoever calls it.
kernel: Callable[..., Any] = njit(**OPTIONS)


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile, on first use, a kernel that Python calls; it runs without the interpreter lock.

    The machine code is cached beside the source or in the user's cache folder; where neither can be written it is made
    anew in every process.
    """
    compiled: Callable[..., Any]
    try:
        compiled = njit(cache=True, **OPTIONS)(function)
    except RuntimeError:  # numba found no folder that it may write to
        compiled = njit(**OPTIONS)(function)
    return compiled
