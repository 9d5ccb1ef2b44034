"""The one place for compiler options.

`fastmath` stays off: contraction and reassociation would break mirror symmetry and repeatability to the last bit.
`error_model="numpy"` divides by zero as IEEE 754 does instead of raising. `_nrt=False` excludes numba's runtime:
without it nothing can be allocated, and arrays are not reference-counted as they are passed, which took half of the
time.
"""

import hashlib
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import partial, wraps
from pathlib import Path
from typing import Any, NoReturn

import numba
from numba import cfunc, njit
from numba.extending import overload, register_jitable

from .cache import NotPrivateError, code_folder
from .numba_parts import LINKING, FunctionCache

_OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": False, "nogil": True, "_nrt": False}

_INSIDE: dict[str, Any] = {**_OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # of kernels
_OUTSIDE: dict[str, Any] = dict(_OPTIONS)  # of entries
if LINKING:
    from .linking import EntryCompiler, KernelCompiler

    _INSIDE["pipeline_class"], _OUTSIDE["pipeline_class"] = KernelCompiler, EntryCompiler

# Building block of a kernel: compiled, and cached, as a part of its caller; not to be called from Python. LLVM decides
# whether to inline it. That is stated, since numba takes missing options from the caller: all that a leaf calls would
# be inlined at every call.
kernel: Callable[..., Any] = njit(forceinline=False, **_INSIDE)

# A leaf of the innermost loops: never worth a call.
leaf: Callable[..., Any] = njit(forceinline=True, **_INSIDE)

# Plain Python, and a leaf where kernels use it.
in_both: Callable[..., Any] = register_jitable(forceinline=True, **_INSIDE)


def from_python(function: Callable[..., Any]) -> Any:
    """A kernel, or a function for measurements and tests, that Python calls: compiled in every process."""
    return njit(**_OUTSIDE)(getattr(function, "py_func", function))


def native(*signature: Any) -> Callable[..., Any]:
    """Decorator of functions that programs without Python call."""
    compiles: Callable[..., Any] = cfunc(*signature, **_OUTSIDE)
    return compiles


def as_written(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, str]:
    """LLVM module of a kernel for these types of arguments, with all that it calls; its name in the module.

    It returns 0 and writes its result to an address that comes first, as numba's functions do. Needs `LINKING`.
    """
    typed: Any = kernel(function)
    typed.compile(arguments)
    (found,) = typed.overloads.values()
    name, module = found.fndesc.mangled_name, found.library.with_called()
    module.get_function(name).linkage = "external"
    return module, name


def by_width(chooses: Callable[..., Any], leaf: bool = True) -> Callable[..., Any]:
    """A function of kernels whose code `chooses` returns by the types of its arguments: numbers or lanes."""

    @wraps(chooses)
    def function(*_: Any, **__: Any) -> NoReturn:
        raise NotImplementedError("for kernels only")

    overload(function, jit_options={**_INSIDE, "forceinline": leaf})(chooses)  # type: ignore
    return function


def varied(function: Callable[..., Any], leaf: bool = False) -> Any:
    """A kernel, or leaf, that has other versions for some types of arguments: decorated by its `version(suits)`."""
    versions: list[tuple[Callable[..., bool], Callable[..., Any]]] = []

    @wraps(function)
    def chooses(*types: Any) -> Any:
        return next((own for suits, own in versions if suits(*types)), function)

    made: Any = by_width(chooses, leaf)
    made.version = lambda suits: lambda own: versions.append((suits, own))
    return made


varied_leaf = partial(varied, leaf=True)


def _sources() -> str:
    """Identifier of the kernels: a hash of every source file of this package."""
    folder = Path(__file__).parent.parent  # all kernels
    content = hashlib.sha256()
    for file in sorted(folder.rglob("*.py")):
        content.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return content.hexdigest()[:16]


SOURCES = _sources()
# of their machine code; other versions of numba keep theirs beside it
CODE = f"{SOURCES}_{numba.__version__.replace('.', '_')}{'' if LINKING else '_plain'}"


class _Cache(FunctionCache):  # type: ignore[misc]
    """Numba's cache of one entry. Machine code that cannot be read is made again; without room it is not kept.

    numba would end the process with whatever pickle or the disk says of a file: any exception may come.
    """

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        """Types and machine: the name says the rest. numba's own has what is closed over, new in every process."""
        return sig, codegen.magic_tuple()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception:
            with suppress(OSError):
                self.flush()  # an index that cannot be read cannot be added to
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        with suppress(Exception):
            super().save_overload(sig, data)


def entry(function: Callable[..., Any], module: str = "") -> Callable[..., Any]:
    """Compile, on first use, a kernel that Python calls; it runs without the interpreter lock.

    module: the one that it is made for, if a function makes it for several; its machine code lies with that function's.
    The machine code is cached (cache.py); if no folder can be written to, or others can, it is made in every process.
    Numba alone would use it until the file of the entry changes; its name here changes with any source of the kernels.
    """
    if module:
        function.__module__, package = module, module.split(".")[-2]
        function.__qualname__ = f"{package}.{function.__name__}"  # numba names files by it, and by where it is written
    function.__qualname__ += f"_{CODE}"
    compiled: Any = from_python(function)
    settings: Any = numba.config
    numbas = getattr(settings, "CACHE_DIR", "")
    try:
        settings.CACHE_DIR = code_folder(Path(function.__code__.co_filename), __name__, numbas)
        with suppress(RuntimeError):  # numba found no folder to write to
            compiled._cache = _Cache(function)  # as njit(cache=True) has its own
    except NotPrivateError as error:
        warnings.warn(f"machine code is not kept, and made in every process: {error}", RuntimeWarning, stacklevel=1)
    finally:
        settings.CACHE_DIR = numbas
    return compiled  # type: ignore[no-any-return]
