"""What living in somebody else's process takes: compiled kernels that outlast the FMU's folder, and a clean exit.

An FMU is extracted to a new folder for every run. Machine code cached there would never be found again, so the solver
is copied once to a folder of the user's that is named after its content, and imported from there, together with the
machine code that the builder's machine made of it: it fits where processor, Python and numba are alike.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import importlib.util
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

CACHE_FOLDER = "multiblock-fmu"
MACHINE_CODE = "machine_code"  # folder among the resources
MOST_KERNELS = 4  # that one first call compiles


def user_cache() -> Path:
    """The folder where programs of this user keep what can be made again."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def import_solver(package: str, resources: Path) -> None:
    """Import `package` from its lasting copy, made if there is none; from the FMU itself where none can be made."""
    if package in sys.modules:
        return
    folder = resources / package
    if (resources / MACHINE_CODE).is_dir():  # else the FMU is just being built: a copy now would stay without
        try:
            folder = lasting_copy(folder, user_cache() / CACHE_FOLDER / package, resources / MACHINE_CODE)
        except (OSError, RuntimeError):  # a home that is read-only, full or absent
            with contextlib.suppress(OSError):  # not even here: slower, not wrong
                _provide(folder, resources / MACHINE_CODE)
    spec = importlib.util.spec_from_file_location(
        package, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[package] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[package]
        raise


def lasting_copy(source: Path, target: Path, machine_code: Path) -> Path:
    """Copy a package so that others see either nothing or the whole of it; its name tells its content."""
    if not (target / "__init__.py").is_file():
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent) as staging:
            staged = Path(staging) / target.name
            shutil.copytree(source, staged, ignore=shutil.ignore_patterns("__pycache__"))
            _provide(staged, machine_code)
            try:
                staged.replace(target)
            except OSError:  # another process was faster
                if not (target / "__init__.py").is_file():
                    raise
    return target


def _provide(package: Path, machine_code: Path) -> None:
    """Put machine code where numba will look for that of a package; numba goes by the content of the sources."""
    for file in machine_code.rglob("*.nb?"):
        folder = package / file.parent.relative_to(machine_code) / "__pycache__"
        folder.mkdir(exist_ok=True)
        partial = folder / f"{file.name}.{os.getpid()}"
        try:
            shutil.copyfile(file, partial)
            partial.replace(folder / file.name)
        except OSError:
            partial.unlink(missing_ok=True)
            raise


def finalize_at_exit(resources: Path) -> None:
    """Let the wrapper library of this FMU drop its Python state before the process ends.

    The wrapper drops it twice, once by the destructor of its pointer and once by that of the library, and the second
    time writes into what is freed: the process aborts more often than not once numba is loaded, and now and then where
    no instance came about. Dropped here, the pointer is empty by then; also where the wrapper itself started Python,
    which ends within the first of the two.
    """
    if not hasattr(os, "RTLD_NOLOAD"):
        return
    for library in sorted((resources.parent / "binaries").glob("*/*.so")):
        atexit.unregister(_finalize)
        _libraries.add(str(library))
        atexit.register(_finalize)


_libraries: set[str] = set()


def _finalize() -> None:
    for library in sorted(_libraries):
        try:
            loaded = ctypes.CDLL(library, mode=os.RTLD_NOLOAD | os.RTLD_NOW)
            loaded.finalizePythonInterpreter()
        except (OSError, AttributeError):  # not loaded (any more), or a wrapper without that function
            continue


def leave_search_path(resources: Path) -> None:
    """Take the FMU's folder off Python's search path, where the wrapper puts it at every instantiation.

    All that is needed from it has been imported by now; others are to find their own modules, not ours.
    """
    sys.path[:] = [entry for entry in sys.path if Path(entry) != resources]


def compile_by(call: Callable[[], object]) -> None:
    """Have the kernels compiled by a first call; on a full disk they are, and only the cache is left out.

    There each kernel that the call comes to ends it once.
    """
    for _ in range(MOST_KERNELS):
        with contextlib.suppress(OSError):
            call()
            return
    call()


def survive_exception(*objects: Any) -> None:
    """Balance the references that the wrapper drops when an exception reaches it, so that the instance lives on."""
    for item in objects:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(item))
