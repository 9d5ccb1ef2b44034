"""The one place for compiler options.

`fastmath` stays off: contraction and reassociation would break mirror symmetry and repeatability to the last bit.
`error_model="numpy"` divides by zero as IEEE 754 does instead of raising. `_nrt=False` keeps numba's runtime out:
without it nothing can be allocated, and no array is counted as it is handed on, which took half of the time.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit
from numba.extending import overload

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": False, "nogil": True, "_nrt": False}

# Building block of a kernel: compiled, and cached, as a part of whoever calls it.
kernel: Callable[..., Any] = njit(**OPTIONS)

# A part of the one kernel that calls it: apart to be read, but compiled as if it were written there. Every level of
# kernels that are compiled by themselves compiles all those below it once more.
part: Callable[..., Any] = njit(inline="always", **OPTIONS)

# A leaf of the innermost loops: never worth a call.
leaf: Callable[..., Any] = njit(forceinline=True, **OPTIONS)


def by_width(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorates what chooses the code behind `function` by the types of its arguments: numbers or lanes."""
    chooses: Callable[..., Any] = overload(function, jit_options={**OPTIONS, "forceinline": True})  # type: ignore
    return chooses


def _sources() -> str:
    """What identifies the kernels: a hash of every source file of this package."""
    folder = Path(__file__).parent
    content = hashlib.sha256()
    for file in sorted(folder.rglob("*.py")):
        content.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return content.hexdigest()[:16]


SOURCES = _sources()


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile, on first use, a kernel that Python calls; it runs without the interpreter lock.

    The machine code is cached beside the source or in the user's cache folder; where neither can be written it is made
    anew in every process. Numba would take it for current as long as the file of the entry is the same; under a name
    that changes with any source of the kernels it cannot.
    """
    function.__qualname__ += f"_{SOURCES}"
    compiled: Callable[..., Any]
    try:
        compiled = njit(cache=True, **OPTIONS)(function)
    except RuntimeError:  # numba found no folder that it may write to
        compiled = njit(**OPTIONS)(function)
    return compiled
