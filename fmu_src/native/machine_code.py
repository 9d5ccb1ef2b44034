"""The kernels as object code for any platform, made on this one.

numba types them once, LLVM optimizes them once, and emits that module for each target. Both get the oldest supported
x86-64 processor, whatever the builder's own; the other targets have vectors of two numbers as well. They work in
processes of their own, since numba takes the processor from the environment, and print their progress. The code is
kept in the user's cache: it does not depend on the column.
"""

from __future__ import annotations

import hashlib
import importlib
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from llvmlite import binding as llvm

from solver.kernels.machine.emitting import emit_all, initialize, optimize, tell
from solver.kernels.machine.folders import keep, kept
from solver.kernels.machine.kinds import Int, Ints, Real, Reals
from solver.kernels.machine.making import environment
from solver.kernels.machine.sources import SOURCES
from solver.kernels.machine.zig import LINUX, Target
from solver.kernels.numba_ext.jit import as_written

BASELINE = "x86-64-v2"
PREFIX = "kernel_"  # of the entries in the object code
OPTIMIZED = "kernels.bc"  # the module from which the code of every target is made


@dataclass(frozen=True)
class Kernels:
    """The kernels of one kind of FMU.

    entries: where they are found, as MODULE:NAME of a mapping from each function to the types of its arguments.
    beside: what identifies the sources that do not belong to solver/kernels/.
    """

    entries: str
    beside: str = ""


COLUMN = Kernels("solver.kernels.api.pointers:ENTRIES")
COLUMN_WITH_PORTS = Kernels("solver.kernels.ports.pointers:ENTRIES")
BRITTLE_COLUMN = Kernels("solver.kernels.bonds.pointers:ENTRIES")
STRUCTURE = Kernels("solver.kernels.api.pointers_of_structures:ENTRIES")


def made_with(kernels: Kernels) -> str:
    """Everything that the object code depends on beside the target."""
    content = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:16]
    versions = f"numba {version('numba')}, llvmlite {version('llvmlite')}, kernels {SOURCES}, {content}"
    return versions if kernels == COLUMN else f"{versions}, {kernels.entries} {kernels.beside}"


def object_code(targets: list[Target], kernels: Kernels, suffix: str = ".o") -> list[bytes]:
    """The object code of every target, or its assembly (".s"). Raises OSError, subprocess.CalledProcessError."""
    key = hashlib.sha256(made_with(kernels).encode()).hexdigest()[:16]
    names = [_file(target, suffix) for target in targets]
    made = {name: kept("native", f"{key}-{name}") for name in names}
    missing = [target for target, name in zip(targets, names, strict=True) if made[name] is None]
    if missing:
        with tempfile.TemporaryDirectory(prefix="machine_code_") as temporary:
            folder = Path(temporary)
            oldest = {"NUMBA_CPU_NAME": BASELINE, "NUMBA_CPU_FEATURES": ""}
            if optimized := kept("native", f"{key}-{OPTIMIZED}"):  # for other targets
                (folder / OPTIMIZED).write_bytes(optimized)
            wanted = [f"{target.triple}={target.cpu}={suffix}" for target in missing]
            command = [sys.executable, "-m", __spec__.name, str(folder), kernels.entries, *wanted]
            subprocess.run(command, check=True, env=environment() | oldest)
            for file in folder.iterdir():
                made[file.name] = file.read_bytes()
                keep("native", f"{key}-{file.name}", file.read_bytes())
    return [made[name] or b"" for name in names]


def _file(target: Target, suffix: str) -> str:
    return f"{target.triple}-{target.cpu}{suffix}"


def module(entries: str) -> llvm.ModuleRef:
    """The entries and all functions that they call, each once, as written."""
    from numba import types

    pointer: Any = types.CPointer
    passed: dict[Any, Any] = {Int: types.int64, Real: types.float64}
    passed |= {Reals: pointer(types.float64), Ints: pointer(types.int64)}
    place, _, attribute = entries.partition(":")
    whole, names = llvm.parse_assembly(""), {}
    for function, kinds in getattr(importlib.import_module(place), attribute).items():
        part, name = as_written(function, tuple(passed[kind] for kind in kinds))
        whole.link_in(part)
        names[name] = PREFIX + function.__name__
        tell(f"kernels typed: {function.__name__}")
    for item in [*whole.functions, *whole.global_variables]:
        if item.name in names:
            item.name, item.linkage, item.visibility = names[item.name], "external", "hidden"
        elif not item.is_declaration:
            item.linkage = "internal"
    return whole


def _optimized(file: Path, entries: str) -> bytes:
    """The bitcode in this file; made, if it is not there."""
    if not file.is_file():
        initialize()
        whole = module(entries)
        optimize(whole, LINUX.triple, BASELINE)
        tell("kernels optimized")
        file.write_bytes(whole.as_bitcode())
    return file.read_bytes()


def main(arguments: list[str]) -> int:
    """FOLDER ENTRIES TRIPLE=CPU=SUFFIX ...: write the code of each target, and its optimized module, to the folder."""
    folder, entries, *words = arguments
    bitcode = _optimized(Path(folder) / OPTIMIZED, entries)
    targets = [tuple(word.split("=")) for word in words]
    emit_all(bitcode, [(triple, cpu, f"{folder}/{triple}-{cpu}{suffix}") for triple, cpu, suffix in targets])
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
