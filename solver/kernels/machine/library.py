"""Search and loading of the machine code of a group: from the package, else stored for the user or made (making.py).

A package has shared libraries, or object code where nothing could link them when it was built. Stored or made code is
object code. Only that needs llvmlite in this process.
"""

import ctypes
import hashlib
import platform
import sys
import threading
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .folders import private_folder, write_whole
from .groups import GROUPS
from .level import levels
from .messages import MachineCodeError
from .sources import SOURCES

PACKAGED = [Path(__file__).parent / "code"]  # folders that are searched in order
SUFFIXES = {"linux": ".so", "win32": ".dll", "darwin": ".dylib"}

Function = Callable[[int], int]
NAMES: dict[str, list[str]] = defaultdict(list)  # of the entries of each group, which entry.py adds
_PROTOTYPE = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)
_opened: dict[str, Callable[[str], int]] = {}
_loaded: dict[str, dict[str, Function]] = {}
_alive: list[Any] = []  # libraries and engines, to which the functions hold no reference
_lock = threading.RLock()


def file_name(group: str, level: str, suffix: str) -> str:
    """Return the name of the file of a group in a package."""
    return f"{group}.{level}.{SOURCES}{suffix}"


def load(group: str) -> dict[str, Function]:
    """Return the functions of a group by name; the first call in a process finds or makes them.

    Raises MachineCodeError.
    """
    with _lock:
        if group not in _loaded:
            addresses = dict(zip(NAMES[group], map(_address_of(group), NAMES[group]), strict=True))
            if missing := [name for name, address in addresses.items() if not address]:  # a call would end the process
                raise MachineCodeError(f"the machine code of {group} has no function {missing[0]}")
            _loaded[group] = {name: _PROTOTYPE(address) for name, address in addresses.items()}
        return _loaded[group]


def open_packaged(folder: Path) -> None:
    """Open all machine code in a folder, which may not outlast this process.

    Raises MachineCodeError if a group is there for other systems or processors only.
    """
    PACKAGED.append(folder)
    # groups of which it has code for any system
    carried = {file.name.partition(".")[0] for file in folder.glob(f"*.{SOURCES}.*")}
    with _lock:
        for group in sorted(carried):
            if _packaged(group) is None:
                here = f"{platform.system()} on {platform.machine()}"
                raise MachineCodeError(f"there is no machine code of {GROUPS[group].purpose} for {here}")
            _address_of(group)


def _address_of(group: str) -> Callable[[str], int]:
    """Return a function name -> address of a group, and open its code at the first call."""
    if group not in _opened:
        # a library of the package, else object code: packaged, stored or made
        file = _packaged(group)
        if file is not None and file.suffix != ".o":
            _opened[group] = _linked(file)
        else:
            codes = {group: file.read_bytes()} if file is not None else _kept_or_made(group)
            _opened.update({name: _from_object(code, name) for name, code in codes.items()})
    return _opened[group]


def _kept_or_made(group: str) -> dict[str, bytes]:
    from .making import code_with  # what is in the package needs no compiler

    return code_with(group, [other for other in GROUPS[group].along if other not in _opened and not _packaged(other)])


def _packaged(group: str) -> Path | None:
    """Return the file of a group in the package, for the highest level that this processor has."""
    suffixes = (SUFFIXES.get(sys.platform, ".so"), ".o")
    names = [file_name(group, level, suffix) for level in levels() for suffix in suffixes]
    return next((folder / name for folder in PACKAGED for name in names if (folder / name).is_file()), None)


def _linked(file: Path) -> Callable[[str], int]:
    if sys.platform == "win32":  # Windows keeps the file of a loaded library open
        file = _lasting(file)
    library = ctypes.CDLL(str(file))
    return lambda name: ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0


def _lasting(file: Path) -> Path:
    """Return a copy of a library that the user alone can write to; the file itself where none can be made."""
    try:
        # named by its content, so that versions do not collide
        content = file.read_bytes()
        copy = private_folder("loaded") / f"{hashlib.sha256(content).hexdigest()[:16]}-{file.name}"
        if not copy.is_file() or copy.read_bytes() != content:
            write_whole(copy, content)
    except (OSError, RuntimeError):
        return file
    return copy


def _from_object(code: bytes, group: str) -> Callable[[str], int]:
    """Load object code; return a function name -> address."""
    try:
        from llvmlite import binding as llvm
    except ImportError:
        raise MachineCodeError(f"the machine code of {group} is not linked, and needs llvmlite") from None
    for begin in ("initialize", "initialize_native_target", "initialize_native_asmprinter"):
        try:
            getattr(llvm, begin)()
        except RuntimeError:  # deprecated since llvmlite 0.45, does it itself
            continue
    # load it into an engine that lives as long as the process
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _alive.extend([engine, machine])
    address_of: Callable[[str], int] = engine.get_function_address
    return address_of
