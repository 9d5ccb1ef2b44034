"""The kernels as object code for any platform, made on this one.

numba types them once, LLVM optimizes them once, and emits that module for each target. Both get the oldest supported
x86-64 processor, whatever the builder's own; the other targets have vectors of two numbers as well. They work in
processes of their own, since numba takes the processor from the environment, and print their progress. The code is
kept in the user's cache: it does not depend on the column.
"""

from __future__ import annotations

import hashlib
import importlib
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import llvmlite
import numba
from llvmlite import binding as llvm

from solver.common.executors import cores
from solver.kernels.numba_ext.cache import keep, kept
from solver.kernels.numba_ext.jit import SOURCES, as_written

from .platforms import LINUX, Target

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
    versions = f"numba {numba.__version__}, llvmlite {llvmlite.__version__}, kernels {SOURCES}, {content}"
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
            environment = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA_")}
            settings = {"NUMBA_CPU_NAME": BASELINE, "NUMBA_CPU_FEATURES": "", "PYTHONHASHSEED": "0"}
            if optimized := kept("native", f"{key}-{OPTIMIZED}"):  # for other targets
                (folder / OPTIMIZED).write_bytes(optimized)
            wanted = [f"{target.triple}={target.cpu}={suffix}" for target in missing]
            command = [sys.executable, "-m", __spec__.name, str(folder), kernels.entries, *wanted]
            path = os.pathsep.join(entry for entry in sys.path if entry)
            subprocess.run(command, check=True, env=environment | settings | {"PYTHONPATH": path})
            for file in folder.iterdir():
                made[file.name] = file.read_bytes()
                keep("native", f"{key}-{file.name}", file.read_bytes())
    return [made[name] or b"" for name in names]


def _file(target: Target, suffix: str) -> str:
    return f"{target.triple}-{target.cpu}{suffix}"


def module(entries: str) -> llvm.ModuleRef:
    """The entries and all functions that they call, each once, as written."""
    place, _, attribute = entries.partition(":")
    whole, names = llvm.parse_assembly(""), {}
    for function, arguments in getattr(importlib.import_module(place), attribute).items():
        part, name = as_written(function, arguments)
        whole.link_in(part)
        names[name] = PREFIX + function.__name__
        tell(f"kernels typed: {function.__name__}")
    for item in [*whole.functions, *whole.global_variables]:
        if item.name in names:
            item.name, item.linkage, item.visibility = names[item.name], "external", "hidden"
        elif not item.is_declaration:
            item.linkage = "internal"
    return whole


def optimize(whole: llvm.ModuleRef) -> None:
    """Optimize for all targets at once, without functions that are never called."""
    machine = _machine_for(whole, LINUX.triple, BASELINE)
    for level in (0, 3):  # small functions into their callers first, as numba does
        builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=level))
        passes = builder.getModulePassManager()
        if not level:
            passes.add_loop_rotate_pass()
            passes.add_instruction_combine_pass()
            passes.add_jump_threading_pass()
        passes.run(whole, builder)


def emit(bitcode: bytes, triple: str, cpu: str, suffix: str) -> bytes:
    """Object code (.o) or assembly (.s) of the optimized module for one target."""
    _initialize()
    whole = llvm.parse_bitcode(bitcode)
    machine = _machine_for(whole, triple, cpu)
    code: bytes = machine.emit_object(whole) if suffix == ".o" else machine.emit_assembly(whole).encode()
    return code


def _initialize() -> None:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()


def _machine_for(whole: llvm.ModuleRef, triple: str, cpu: str) -> llvm.TargetMachine:
    """The target machine; the module is set to its triple and layout."""
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu=cpu, opt=3, reloc="pic", codemodel="default")
    whole.triple, whole.data_layout = triple, str(machine.target_data)
    return machine


def tell(text: str) -> None:
    """Print a line of progress, with the processor time that this process has taken so far."""
    print(f"{text} ({time.process_time():.0f} s)", file=sys.stderr, flush=True)


def _optimized(file: Path, entries: str) -> bytes:
    """The bitcode in this file; made, if it is not there."""
    if not file.is_file():
        _initialize()
        whole = module(entries)
        optimize(whole)
        tell("kernels optimized")
        file.write_bytes(whole.as_bitcode())
    return file.read_bytes()


def main(arguments: list[str]) -> int:
    """FOLDER ENTRIES TRIPLE=CPU=SUFFIX ...: write the code of each target, and its optimized module, to the folder."""
    folder, entries, *words = arguments
    bitcode = _optimized(Path(folder) / OPTIMIZED, entries)
    with ProcessPoolExecutor(cores(), multiprocessing.get_context("spawn")) as workers:
        begun = {workers.submit(emit, bitcode, *word.split("=")): word.split("=") for word in words}
        for done in as_completed(begun):
            triple, cpu, suffix = begun[done]
            (Path(folder) / f"{triple}-{cpu}{suffix}").write_bytes(done.result())
            tell(f"machine code: {triple}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
