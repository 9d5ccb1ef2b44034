"""The integration of an FMU into the process of a host: import of the carried solver, clean exit.

An FMU is extracted to a new folder for every run. The solver is imported from there, under a name with a hash of its
content, once in a process.
"""

from __future__ import annotations

import atexit
import ctypes
import importlib.util
import os
import sys
import zipimport
from pathlib import Path
from typing import Any

ARCHIVE, CODE_FOLDER = "python.zip", "code"  # in the resources of an FMU: its packages, their machine code


def import_solver(package: str, archive: Path) -> None:
    """Import `package` from the archive of the FMU, and open its machine code, which outlasts the folder of the FMU."""
    if package in sys.modules:
        return
    spec = zipimport.zipimporter(str(archive)).find_spec(package)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[package] = module
    try:
        spec.loader.exec_module(module)
        importlib.import_module(f"{package}.kernels.machine.library").open_packaged(archive.with_name(CODE_FOLDER))
    except BaseException:
        del sys.modules[package]
        raise


def finalize_at_exit(resources: Path) -> None:
    """Let the wrapper library of this FMU release its Python state before the process ends.

    The wrapper releases it twice, in the destructor of its pointer and in that of the library, and the second time
    writes into freed memory: the process aborts more often than not once an extension is loaded, and sometimes if there
    was no instance. If it is released here, the pointer is empty by then; also if the wrapper itself started Python,
    which then ends within the first of the two.
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
    """Remove the FMU's folder from Python's search path, where the wrapper puts it at every instantiation.

    All modules needed from it have been imported by now; other packages must find their own modules, not ours.
    """
    sys.path[:] = [entry for entry in sys.path if Path(entry) not in {resources, resources / ARCHIVE}]


def survive_exception(*objects: Any) -> None:
    """Add the references that the wrapper drops when an exception reaches it, so that the instance stays alive."""
    for item in objects:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(item))
