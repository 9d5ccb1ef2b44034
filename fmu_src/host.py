"""Life in the process of a host: compiled kernels that outlast the FMU's folder, and a clean exit.

An FMU is extracted to a new folder for every run. Machine code cached there would never be found again. So the solver
is copied once to a folder of the user's, named after its content, and imported from there, together with the machine
code that the builder's machine made of it. That code is used where processor, Python and numba are the same.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import hashlib
import importlib.util
import io
import marshal
import os
import pickletools
import runpy
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

MACHINE_CODE = "machine_code"  # folder among the resources
MOST_COPIES = 8  # of a package, each but one damaged
PYC_HEADER = 16  # bytes
PICKLES = {".nbi": 2, ".nbc": 1}  # in each file of numba's cache, one after the other
CACHED = (".pyc", *PICKLES)


def import_solver(package: str, resources: Path) -> None:
    """Import `package` from its lasting copy, made if there is none; from the FMU itself if none can be made."""
    if package in sys.modules:
        return
    folder = resources / package
    if (resources / MACHINE_CODE).is_dir():  # else the FMU is being built: a copy made now would never get any
        try:
            # the solver itself cannot be imported before it is known from where
            cache = SimpleNamespace(**runpy.run_path(str(folder / "kernels" / "numba_ext" / "cache.py")))
            cache.make_private(cache.user_folder())
            folder = lasting_copy(folder, cache.user_folder() / package, resources / MACHINE_CODE, cache.is_private)
        except (OSError, RuntimeError):  # a home that is read-only, full or absent
            with contextlib.suppress(OSError):  # not even here: the run is slower but correct
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


def content_hash(texts: Mapping[str, str]) -> str:
    """A hash for the name of a carried package: of its modules, path within the package -> text."""
    content = "\0".join(f"{path}\0{texts[path]}" for path in sorted(texts))
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def lasting_copy(source: Path, target: Path, machine_code: Path, is_private: Callable[[Path], bool]) -> Path:
    """The copy of a package that equals `source` and that only the user can write to; made, if there is none.

    A copy that is damaged, or that others can write to, is not changed, since a process may be importing from it;
    the next one, `target`.1 ..., is used instead. Other processes see no copy or a complete one. Raises OSError.
    """
    for folder in (target, *(target.with_name(f"{target.name}.{k}") for k in range(1, MOST_COPIES))):
        if not folder.exists():
            with tempfile.TemporaryDirectory(dir=target.parent) as staging:  # which only the user can enter
                staged = Path(staging) / target.name
                _copy_modules(source, staged)
                _provide(staged, machine_code)
                staged.chmod(0o700)
                with contextlib.suppress(OSError):  # another process was faster
                    staged.replace(folder)
        if is_private(folder) and _is_sound(folder, target.name, machine_code):
            return folder
    raise OSError(f"{target}: damaged, or others can write to it")


def _is_sound(folder: Path, name: str, machine_code: Path) -> bool:
    """Whether a copy holds the modules whose hash its name has, and code made from them, all owned by the user."""
    try:
        files = [path for path in (folder, *folder.rglob("*")) if not _is_left_over(path)]
        if not all(_is_own(path) for path in files):
            return False
        texts = {path.relative_to(folder).as_posix(): path for path in files if path.is_file()}
        modules = {key: path.read_text(encoding="utf-8") for key, path in texts.items() if path.suffix == ".py"}
        if name.rpartition("_")[2] != content_hash(modules):
            return False
        given = {_place(file, machine_code).as_posix(): file for file in machine_code.rglob("*.nbc")}
        if not given.keys() <= texts.keys():
            return False
        if any(texts[key].read_bytes() != file.read_bytes() for key, file in given.items()):
            return False
        return all(_is_whole(path) for path in texts.values() if path.suffix != ".py")
    except (OSError, ValueError):
        return False


def _is_left_over(path: Path) -> bool:
    """Whether a file is an unfinished one of Python or numba, which neither reads."""
    return path.parent.name == "__pycache__" and path.suffix not in CACHED


def _is_own(path: Path) -> bool:
    """Whether a file or folder is the user's, and no link."""
    about = path.lstat()
    return not stat.S_ISLNK(about.st_mode) and (not hasattr(os, "getuid") or about.st_uid == os.getuid())


def _is_whole(path: Path) -> bool:
    """Whether a file of a cache has its full length. Code for another processor than the builder's has no copy for a
    comparison; the file is only parsed here, and none of it is executed.
    """
    if path.parent.name != "__pycache__":
        return False  # a module from outside the package
    content = path.read_bytes()
    try:
        if path.suffix == ".pyc":
            marshal.loads(content[PYC_HEADER:])
            return True
        rest = io.BytesIO(content)
        for _ in range(PICKLES[path.suffix]):
            for _ in pickletools.genops(rest):
                pass
        return not rest.read()
    except (EOFError, TypeError, ValueError):
        return False


def _copy_modules(source: Path, target: Path) -> None:
    """Copy the modules of a package, and nothing else, whatever mode the files have in the FMU."""
    for file in sorted(source.rglob("*.py")):
        copy = target / file.relative_to(source)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)


def _place(file: Path, machine_code: Path) -> Path:
    """Path at which numba looks for a file of machine code, within the package."""
    return file.parent.relative_to(machine_code) / "__pycache__" / file.name


def _provide(package: Path, machine_code: Path) -> None:
    """Put machine code where numba looks for that of a package; numba identifies it by the content of the sources."""
    for file in machine_code.rglob("*.nb?"):
        folder = (package / _place(file, machine_code)).parent
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

    The wrapper drops it twice, by the destructor of its pointer and by that of the library, and the second time writes
    into freed memory: the process aborts more often than not once numba is loaded, and sometimes if there was no
    instance. Dropped here, the pointer is empty by then; also if the wrapper itself started Python, which then ends
    within the first of the two.
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

    All modules needed from it have been imported by now; other packages must find their own modules, not ours.
    """
    sys.path[:] = [entry for entry in sys.path if Path(entry) != resources]


def survive_exception(*objects: Any) -> None:
    """Balance the references that the wrapper drops when an exception reaches it, so that the instance lives on."""
    for item in objects:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(item))
