"""The one place for compiler options.

`fastmath` stays off: contraction and reassociation would break mirror symmetry and repeatability to the last bit.
`error_model="numpy"` divides by zero as IEEE 754 does instead of raising. `_nrt=False` keeps numba's runtime out:
without it nothing can be allocated, and no array is counted as it is handed on, which took half of the time.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import cfunc, njit
from numba.extending import overload, register_jitable

from .linking import EntryCompiler, KernelCompiler

_OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": False, "nogil": True, "_nrt": False}

_INSIDE: dict[str, Any] = {**_OPTIONS, "pipeline_class": KernelCompiler}
_OUTSIDE: dict[str, Any] = {**_OPTIONS, "pipeline_class": EntryCompiler}

# Building block of a kernel: compiled, and cached, as a part of whoever calls it; not to be called from Python. Whether
# it is worth a call is left to LLVM. That is said, since what is not said numba takes from the caller: all that a leaf
# calls would be taken in as often as it is called.
kernel: Callable[..., Any] = njit(forceinline=False, **_INSIDE)

# A leaf of the innermost loops: never worth a call.
leaf: Callable[..., Any] = njit(forceinline=True, **_INSIDE)

# Plain Python, and a leaf where kernels use it.
in_both: Callable[..., Any] = register_jitable(forceinline=True, **_INSIDE)


def from_python(function: Callable[..., Any]) -> Any:
    """What Python calls to measure or to test a kernel, or a kernel itself: compiled anew in every process."""
    return njit(**_OUTSIDE)(getattr(function, "py_func", function))


def native(*signature: Any) -> Callable[..., Any]:
    """Decorates what programs without Python call."""
    compiles: Callable[..., Any] = cfunc(*signature, **_OUTSIDE)
    return compiles


def as_written(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, str]:
    """LLVM module of a kernel for these types of arguments, with all that it calls, not optimized; its name in there.

    It returns 0 and leaves its result at an address that comes first, as numba's functions do.
    """
    typed: Any = kernel(function)
    typed.compile(arguments)
    (found,) = typed.overloads.values()
    module, name = found.library.with_called(), found.fndesc.mangled_name
    module.get_function(name).linkage = "external"
    return module, name


def by_width(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorates what chooses the code behind `function` by the types of its arguments: numbers or lanes."""
    chooses: Callable[..., Any] = overload(function, jit_options={**_INSIDE, "forceinline": True})  # type: ignore
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
        compiled = njit(cache=True, **_OUTSIDE)(function)
    except RuntimeError:  # numba found no folder that it may write to
        compiled = from_python(function)
    return compiled
