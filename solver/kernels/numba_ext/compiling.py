"""Decorators and compiler options of kernels, for the processes that compile (jit.py).

`fastmath` stays off: contraction and reassociation would break mirror symmetry and repeatability to the last bit.
`error_model="numpy"` divides by zero as IEEE 754 does instead of raising. `_nrt=False` excludes numba's runtime:
without it nothing can be allocated, and arrays are not reference-counted as they are passed, which took half of the
time.
"""

from collections.abc import Callable
from functools import partial, wraps
from typing import Any, NoReturn

from numba import cfunc, njit
from numba.extending import overload, register_jitable

from .linking import KernelCompiler, WholeCompiler

_OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": False, "nogil": True, "_nrt": False}
# of kernels, and of what Python or another program calls
_INSIDE = {**_OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": KernelCompiler}
_OUTSIDE = {**_OPTIONS, "pipeline_class": WholeCompiler}

# Building block of a kernel: compiled as a part of its caller, not to be called from Python. LLVM decides whether to
# inline it. That is stated, since numba takes missing options from the caller: all that a leaf calls would be inlined
# at every call.
kernel: Callable[..., Any] = njit(forceinline=False, **_INSIDE)

# A leaf of the innermost loops: never worth a call.
leaf: Callable[..., Any] = njit(forceinline=True, **_INSIDE)

# Plain Python, and a leaf where kernels use it.
in_both: Callable[..., Any] = register_jitable(forceinline=True, **_INSIDE)


def from_python(function: Callable[..., Any]) -> Any:
    """Compile, in this process, a kernel or a function for measurements and tests that Python calls."""
    return njit(**_OUTSIDE)(getattr(function, "py_func", function))


def native(*signature: Any) -> Callable[..., Any]:
    """Return a decorator of functions that programs without Python call."""
    compiles: Callable[..., Any] = cfunc(*signature, **_OUTSIDE)
    return compiles


def as_written(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, str]:
    """Return the library of a kernel for these types, to be linked (linking.py), and its name in the module.

    The function returns 0 and writes its result to the address in its first argument, as numba's functions do.
    """
    typed: Any = kernel(function)
    typed.compile(arguments)
    # the only signature
    (found,) = typed.overloads.values()
    return found.library, found.fndesc.mangled_name


def by_width(chooses: Callable[..., Any], leaf: bool = True) -> Callable[..., Any]:
    """Return a function of kernels whose code `chooses` returns by the types of its arguments: numbers or lanes."""

    # Python sees a function that refuses to run; numba replaces it
    @wraps(chooses)
    def function(*_: Any, **__: Any) -> NoReturn:
        raise NotImplementedError("for kernels only")

    overload(function, jit_options={**_INSIDE, "forceinline": leaf})(chooses)  # type: ignore
    return function


def varied(function: Callable[..., Any], leaf: bool = False) -> Any:
    """Return a kernel, or leaf, with versions for some types of arguments: decorated by its `version(suits)`."""
    versions: list[tuple[Callable[..., bool], Callable[..., Any]]] = []

    # the version for these types, if there is one
    @wraps(function)
    def chooses(*types: Any) -> Any:
        return next((own for suits, own in versions if suits(*types)), function)

    made: Any = by_width(chooses, leaf)
    made.version = lambda suits: lambda own: versions.append((suits, own))
    return made


varied_leaf = partial(varied, leaf=True)
