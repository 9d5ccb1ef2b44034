"""Machine code made on demand by a separate process (numba_ext/make.py), and stored in the private folder of the user.

It is stored under an identifier of sources, processor level and compiler.
"""

import os
import platform
import re
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import PackageNotFoundError, version
from itertools import chain, pairwise
from pathlib import Path
from typing import TypeVar

from .folders import keep, kept, store
from .groups import GROUPS
from .level import levels
from .messages import MachineCodeError, announce
from .sources import SOURCES

KEPT = "code"  # folder, in that of the user
MAKE = f"{__package__.rpartition('.')[0]}.numba_ext.make"  # the program that compiles
COMPILERS = ("numba", "llvmlite")
HOST = f"{sys.platform}-{platform.machine()}"  # a folder may be shared between systems
Found = TypeVar("Found")
_COMPILING: set[subprocess.Popen[str]] = set()  # processes that run


def kept_code(group: str) -> bytes | None:
    """Return the object code of a group that is stored for this processor; None if there is none."""
    return kept(KEPT, _key(group))


def code_with(group: str, others: Iterable[str]) -> dict[str, bytes]:
    """Return the object code of a group, stored or made now; if made, with that of others for which none is stored."""
    if (code := kept_code(group)) is not None:
        return {group: code}
    missing = [group, *(other for other in others if kept_code(other) is None)]
    missing.sort(key=lambda name: -GROUPS[name].seconds)
    # the group that takes longest in a process of its own; one process on a single core types shared kernels once
    alone = 1 if len(missing) > 1 and (os.cpu_count() or 1) > 1 else len(missing)
    parts = list(filter(None, (missing[:alone], missing[alone:])))
    return dict(zip(missing, chain(*_in_parallel(made, parts)), strict=True))


def make(groups: Iterable[str]) -> None:
    """Make the code of those groups for which none is stored, on all cores. Raises MachineCodeError."""
    on_all_cores(made, [group for group in groups if kept_code(group) is None])


def on_all_cores(make: Callable[[list[str]], Found], groups: Iterable[str]) -> list[Found]:
    """Call `make` in parallel with lists of groups that share kernels, and return its results."""
    # groups of columns and of structures, each by one process
    families: dict[str, list[str]] = {}
    for group in groups:
        in_space = GROUPS[group].module.startswith("structure.")
        families.setdefault("space" if in_space else "plane", []).append(group)
    return _in_parallel(make, families.values())


def _in_parallel(make: Callable[[list[str]], Found], parts: Iterable[list[str]]) -> list[Found]:
    """Call `make` with each part in a thread of its own; an error or an interrupt ends all processes that compile."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
        try:
            return list(threads.map(make, parts))
        except BaseException:
            for process in tuple(_COMPILING):
                process.kill()
            raise


def sources_of(group: str) -> str:
    """Return the identifier of all sources of a group."""
    return "-".join(filter(None, (SOURCES, GROUPS[group].beside)))


def compilers() -> str:
    """Return names and versions of the compilers, "none" where one is not installed."""
    versions = []
    for name in COMPILERS:
        try:
            versions.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            versions.append(f"{name} none")
    return ", ".join(versions)


def _key(group: str) -> str:
    """Return the name under which machine code made on this machine is stored."""
    return f"{group}.{HOST}.{levels()[0]}.{sources_of(group)}.{compilers()}.o"


def made(groups: list[str]) -> list[bytes]:
    """Return the object code of groups for this processor, made by another process, and store it."""
    with tempfile.TemporaryDirectory(prefix="machine_code_") as folder:
        files = {group: Path(folder) / f"{group}.o" for group in groups}
        run_make({group: {levels()[0]: file} for group, file in files.items()})
        codes = {group: file.read_bytes() for group, file in files.items()}
    try:
        for group, code in codes.items():
            store(KEPT, _key(group), code)
    except (OSError, RuntimeError) as error:
        warnings.warn(f"machine code is not kept, and made in every process: {error}", RuntimeWarning, stacklevel=2)
    return list(codes.values())


def run_make(wanted: Mapping[str, Mapping[str, Path]]) -> None:
    """Let another process make machine code: group -> target word (make.py) -> file. Raises MachineCodeError."""
    with tempfile.TemporaryDirectory(prefix="bitcode_") as folder:
        # arguments: an optimized module that is stored is used again
        words, optimized_now = [], []
        for group, files in wanted.items():
            bitcode, key = Path(folder) / f"{group}.bc", f"{group}.{HOST}.{sources_of(group)}.{compilers()}.bc"
            if (optimized := kept(KEPT, key)) is not None:  # stored when another target was made
                bitcode.write_bytes(optimized)
            else:
                optimized_now.append((key, bitcode, files.values()))
                announce(f"compiling the kernels of {GROUPS[group].purpose}, once: about {GROUPS[group].seconds} s")
            name = f"{GROUPS[group].whole_module}:{group}"
            words += ["--", name, str(bitcode), *(f"{word}={file}" for word, file in files.items())]
        # compile, and store the optimized modules: one is complete if code of all targets was made of it
        command = [_python(), "-P", "-m", MAKE, *words[1:]]
        status, errors = _run(command)
        for key, bitcode, made_of_it in optimized_now:
            if all(file.is_file() for file in (bitcode, *made_of_it)):
                keep(KEPT, key, bitcode.read_bytes())
        # report the reason of an error
        for group, files in wanted.items():
            if status or not all(file.is_file() for file in files.values()):
                why = reason_in(errors)
                if "No module named 'numba'" in why or "No module named 'llvmlite'" in why:
                    why = "numba is not installed: pip install 'numba>=0.61,<1'"
                raise MachineCodeError(f"the kernels of {GROUPS[group].purpose} cannot be compiled: {why}")


def _run(command: list[str]) -> tuple[int, str]:
    """Run a command that compiles; return its exit code and what it wrote to stderr."""
    unread = subprocess.DEVNULL
    with subprocess.Popen(
        command, env=environment(), stdin=unread, stdout=unread, stderr=subprocess.PIPE, text=True
    ) as process:
        _COMPILING.add(process)
        try:
            _, errors = process.communicate()
        except BaseException:
            process.kill()
            raise
        finally:
            _COMPILING.remove(process)
    return process.returncode, errors


def reason_in(output: str) -> str:
    """Return the last line of an error; of numba's, which begin with the innermost call, the reason with its place."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    for reason, line in pairwise(lines):
        if place := re.match(r"During: typing of .* at (\S+) \((\d+)\)", line):
            return f"{place[1]}, line {place[2]}: {reason}"
    return lines[-1] if lines else "it was ended"


def environment() -> dict[str, str]:
    """Return the environment of a process that compiles: that of this process, without numba's settings.

    Modules beside the script that is run come last: they must not replace those of the standard library.
    """
    top, script = sys.modules[__package__.partition(".")[0]], getattr(sys.modules["__main__"], "__file__", None)
    beside = Path(script).resolve().parent if script else None
    found = sorted(filter(None, sys.path), key=lambda place: Path(place).resolve() == beside)
    paths = [str(Path(top.__path__[0]).parent), *found]
    kept_on = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    return kept_on | {"MULTIBLOCK_COMPILES": "1", "PYTHONPATH": os.pathsep.join(paths), "PYTHONHASHSEED": "0"}


def _python() -> str:
    """Return the interpreter of this process, which may be embedded in another program."""
    executable = Path(sys.executable or "")
    if executable.stem.lower().startswith("python"):
        return str(executable)
    beside = Path(sys.base_exec_prefix) / ("python.exe" if sys.platform == "win32" else "bin/python3")
    return str(beside)
