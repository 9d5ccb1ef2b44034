"""Where the machine code of a group is found, and loaded: in the package, kept for the user, or made now.

A package has shared libraries, or object code where nothing could link them when it was built. What is made now is
object code, kept in the private folder of the user under an identifier of sources and compiler. It is made by a process
of its own (numba_ext/make.py); only object code needs llvmlite in this one.
"""

import ctypes
import hashlib
import multiprocessing
import os
import platform
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TypeVar

from .folders import keep, kept, private_folder
from .groups import GROUPS
from .level import levels
from .sources import SOURCES

PACKAGED = Path(__file__).parent / "code"
KEPT = "code"  # folder, in that of the user
SUFFIXES = {"linux": ".so", "win32": ".dll", "darwin": ".dylib"}
MAKE = f"{__package__.rpartition('.')[0]}.numba_ext.make"  # the program that compiles
COMPILERS = ("numba", "llvmlite")

Function = Callable[[int], int]
Found = TypeVar("Found")
_PROTOTYPE = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)
_opened: dict[str, Callable[[str], int]] = {}
_loaded: dict[str, dict[str, Function]] = {}
_alive: list[Any] = []  # libraries and engines: the functions do not hold them
_lock = threading.RLock()


class MachineCodeError(ImportError):
    """There is no machine code for this processor, and none can be made."""


def file_name(group: str, level: str, suffix: str) -> str:
    """Return the name of the file of a group in a package."""
    return f"{group}.{level}.{SOURCES}{suffix}"


def load(group: str) -> dict[str, Function]:
    """Return the functions of a group by name; the first call in a process finds or makes them.

    Raises MachineCodeError.
    """
    with _lock:
        if group not in _loaded:
            address_of = _address_of(group)
            _loaded[group] = {name: _PROTOTYPE(_checked(name, group, address_of(name))) for name in _names(group)}
        return _loaded[group]


def open_packaged() -> None:
    """Open all machine code in the package, whose folder may not outlast this process.

    Raises MachineCodeError if a group is there for other systems or processors only.
    """
    carried = {file.name.partition(".")[0] for file in PACKAGED.glob(f"*.{SOURCES}.*")}
    with _lock:
        for group in sorted(carried):
            if _packaged(group) is None:
                here = f"{platform.system()} on {platform.machine()}"
                raise MachineCodeError(f"there is no machine code of {GROUPS[group].purpose} for {here}")
            _address_of(group)


def _address_of(group: str) -> Callable[[str], int]:
    """Return what finds the address of a function of a group, whose code is opened."""
    if group not in _opened:
        file = _packaged(group)
        if file is not None and file.suffix != ".o":
            _opened[group] = _linked(file)
        else:
            code = file.read_bytes() if file is not None else kept(KEPT, _key(group))
            _opened[group] = _from_object(code or _made([group])[0], group)
    return _opened[group]


def is_made(group: str) -> bool:
    """Return True if the machine code of a group is loaded, in the package, or kept."""
    return group in _loaded or _packaged(group) is not None or kept(KEPT, _key(group)) is not None


def on_terminal(line: str) -> None:
    """Print a line on a terminal, but from worker processes."""
    if sys.stderr and sys.stderr.isatty() and multiprocessing.parent_process() is None:
        print(line, file=sys.stderr, flush=True)


announce: Callable[[str], None] = on_terminal  # is called before a group is made, with what and how long


@contextmanager
def announcing(say: Callable[[str], None]) -> Iterator[None]:
    """Let another function announce what is made, within this context."""
    global announce
    usual, announce = announce, say
    try:
        yield
    finally:
        announce = usual


def make(groups: Iterable[str]) -> None:
    """Make what is missing of groups, on all cores. Raises MachineCodeError."""
    on_all_cores(_made, [group for group in groups if not is_made(group)])


def on_all_cores(make: Callable[[list[str]], Found], groups: Iterable[str]) -> list[Found]:
    """Call `make` with lists of groups that share kernels, side by side, and return what it returns."""
    families: dict[str, list[str]] = {}
    for group in groups:
        in_space = GROUPS[group].module.startswith("structure.")
        families.setdefault("space" if in_space else "plane", []).append(group)
    with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
        return list(threads.map(make, families.values()))


def _names(group: str) -> list[str]:
    from .entry import entries_of

    return [made.__name__ for made in entries_of(group)]


def _checked(name: str, group: str, address: int) -> int:
    """Return the address of a function. 0 stands for a name that is not there: calling it would end the process."""
    if not address:
        raise MachineCodeError(f"the machine code of {group} has no function {name}")
    return address


def _packaged(group: str) -> Path | None:
    """Return the file of a group in the package, for the highest level that this processor has."""
    for level in levels():
        for suffix in (SUFFIXES.get(sys.platform, ".so"), ".o"):
            file = PACKAGED / file_name(group, level, suffix)
            if file.is_file():
                return file
    return None


def _linked(file: Path) -> Callable[[str], int]:
    if sys.platform == "win32":  # keeps the file of a library open
        file = _lasting(file)
    library = ctypes.CDLL(str(file))
    return lambda name: ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0


def _lasting(file: Path) -> Path:
    """Return a copy of a library that the user alone can write to; the file itself where there is none."""
    try:
        content = file.read_bytes()
        copy = private_folder("loaded") / f"{hashlib.sha256(content).hexdigest()[:16]}-{file.name}"
        if not copy.is_file() or copy.read_bytes() != content:
            partial = copy.with_name(f"{copy.name}.{os.getpid()}")
            partial.write_bytes(content)
            partial.replace(copy)
    except (OSError, RuntimeError):
        return file
    return copy


def _from_object(code: bytes, group: str) -> Callable[[str], int]:
    """Load object code."""
    try:
        from llvmlite import binding as llvm
    except ImportError:
        raise MachineCodeError(f"the machine code of {group} is not linked, and needs llvmlite") from None
    for begin in ("initialize", "initialize_native_target", "initialize_native_asmprinter"):
        try:
            getattr(llvm, begin)()
        except RuntimeError:  # deprecated since llvmlite 0.45, does it itself
            continue
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _alive.extend([engine, machine])
    address_of: Callable[[str], int] = engine.get_function_address
    return address_of


def _compilers() -> str:
    """Return the versions of what compiles, "none" where something is not installed."""
    versions = []
    for name in COMPILERS:
        try:
            versions.append(version(name))
        except PackageNotFoundError:
            versions.append("none")
    return "-".join(versions)


def _key(group: str) -> str:
    """Return the name under which machine code is kept that is made on this machine."""
    return f"{group}.{levels()[0]}.{SOURCES}.{_compilers()}.o"


def _made(groups: list[str]) -> list[bytes]:
    """Return the object code of groups for this processor, made by another process, and keep it."""
    for group in groups:
        announce(f"compiling the kernels of {GROUPS[group].purpose}, once: about {GROUPS[group].seconds} s")
    with tempfile.TemporaryDirectory(prefix="machine_code_") as folder:
        files = {group: Path(folder) / f"{group}.o" for group in groups}
        run_make({group: {levels()[0]: file} for group, file in files.items()})
        codes = {group: file.read_bytes() for group, file in files.items()}
    try:
        private_folder(KEPT)
    except (OSError, RuntimeError) as error:
        warnings.warn(f"machine code is not kept, and made in every process: {error}", RuntimeWarning, stacklevel=2)
    for group, code in codes.items():
        keep(KEPT, _key(group), code)
    return list(codes.values())


def run_make(wanted: Mapping[str, Mapping[str, Path]]) -> None:
    """Let another process make machine code: group -> word for a target (make.py) -> file. Raises MachineCodeError."""
    top = sys.modules[__package__.partition(".")[0]]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    paths = [str(Path(top.__path__[0]).parent), *filter(None, sys.path)]
    environment |= {"MULTIBLOCK_COMPILES": "1", "PYTHONPATH": os.pathsep.join(paths), "PYTHONHASHSEED": "0"}
    with tempfile.TemporaryDirectory(prefix="bitcode_") as folder:
        words, made = [], {}
        for group, files in wanted.items():
            bitcode, key = Path(folder) / f"{group}.bc", f"{group}.{SOURCES}.{_compilers()}.bc"
            if (optimized := kept(KEPT, key)) is not None:  # for another target
                bitcode.write_bytes(optimized)
            else:
                made[key] = bitcode
            words += ["--", group, str(bitcode), *(f"{word}={file}" for word, file in files.items())]
        command = [_python(), "-P", "-m", MAKE, *words[1:]]
        done = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        for key, bitcode in made.items():
            if bitcode.is_file():
                keep(KEPT, key, bitcode.read_bytes())
        for group, files in wanted.items():
            if done.returncode or not all(file.is_file() for file in files.values()):
                last = (done.stderr.strip().splitlines() or ["it was ended"])[-1]
                if "No module named 'numba'" in last or "No module named 'llvmlite'" in last:
                    last = "numba is not installed: pip install 'numba>=0.61,<1'"
                raise MachineCodeError(f"the kernels of {GROUPS[group].purpose} cannot be compiled: {last}")


def _python() -> str:
    """Return the interpreter of this process, which may be embedded in another program."""
    executable = Path(sys.executable or "")
    if executable.stem.lower().startswith("python"):
        return str(executable)
    beside = Path(sys.base_exec_prefix) / ("python.exe" if sys.platform == "win32" else "bin/python3")
    return str(beside)
