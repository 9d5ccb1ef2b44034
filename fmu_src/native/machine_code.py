"""The kernels as object code for any platform, made on this one.

numba types and optimizes them for the oldest x86-64 processor in question, whatever the builder's own; LLVM emits that
module for each target. It is made in a process of its own, since numba takes the processor from the environment, and
kept in the user's cache: it does not depend on the column.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import llvmlite
import numba
from llvmlite import binding as llvm

from solver.kernels.jit import OPTIONS, SOURCES

from ..host import CACHE_FOLDER, user_cache
from .platforms import Target

BASELINE = "x86-64-v2"
PREFIX = "kernel_"  # of the entries in the object code


@dataclass(frozen=True)
class Kernels:
    """The kernels of one kind of FMU.

    entries: where they are found, as MODULE:NAME of a mapping from each function to the types of its arguments.
    beside: what identifies the sources that do not belong to solver/kernels/.
    """

    entries: str
    beside: str = ""


COLUMN = Kernels("solver.kernels.pointers:ENTRIES")


def made_with(kernels: Kernels) -> str:
    """What the object code depends on beside the target."""
    content = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:16]
    versions = f"numba {numba.__version__}, llvmlite {llvmlite.__version__}, kernels {SOURCES}, {content}"
    return versions if kernels == COLUMN else f"{versions}, {kernels.entries} {kernels.beside}"


def object_code(targets: list[Target], kernels: Kernels, suffix: str = ".o") -> list[bytes]:
    """The object code of every target, or its assembly (".s"). Raises OSError, subprocess.CalledProcessError."""
    key = hashlib.sha256(made_with(kernels).encode()).hexdigest()[:16]
    kept = user_cache() / CACHE_FOLDER / "native" / key
    with tempfile.TemporaryDirectory(prefix="machine_code_") as temporary:
        folder = Path(temporary)
        missing = []
        for target in targets:
            if not (kept / _file(target, suffix)).is_file():
                missing.append(f"{target.triple}={target.cpu}={suffix}")
        if missing:
            environment = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA_")}
            settings = {"NUMBA_CPU_NAME": BASELINE, "NUMBA_CPU_FEATURES": "", "PYTHONHASHSEED": "0"}
            command = [sys.executable, "-m", __spec__.name, str(folder), kernels.entries, *missing]
            path = os.pathsep.join(entry for entry in sys.path if entry)
            subprocess.run(command, check=True, env=environment | settings | {"PYTHONPATH": path})
            with contextlib.suppress(OSError):  # no room: made again next time
                kept.mkdir(parents=True, exist_ok=True)
                for file in folder.iterdir():
                    partial = kept / f"{file.name}.{os.getpid()}"
                    partial.write_bytes(file.read_bytes())
                    partial.replace(kept / file.name)
        made = [folder / _file(target, suffix) for target in targets]
        return [(file if file.is_file() else kept / file.name).read_bytes() for file in made]


def _file(target: Target, suffix: str) -> str:
    return f"{target.triple}-{target.cpu}{suffix}"


def module(entries: str) -> llvm.ModuleRef:
    """The entries and all that they call; nothing else is left."""
    place, _, attribute = entries.partition(":")
    whole = None
    for function, arguments in getattr(importlib.import_module(place), attribute).items():
        compile_entry: Any = numba.cfunc(numba.types.int64(*arguments), **OPTIONS)
        part = llvm.parse_assembly(compile_entry(function).inspect_llvm())
        native = [item for item in part.functions if not item.is_declaration and function.__name__ in item.name]
        name = min((item.name for item in native if not item.name.startswith("cfunc.")), key=len)
        for item in [*part.functions, *part.global_variables]:
            if not item.is_declaration:
                item.linkage = "external" if item.name == name else "internal"
        entry = part.get_function(name)
        entry.name = PREFIX + function.__name__
        entry.visibility = "hidden"
        if whole is None:
            whole = part
        else:
            whole.link_in(part)
    assert whole is not None
    return whole


def emit(whole: llvm.ModuleRef, triple: str, cpu: str, suffix: str) -> bytes:
    """Object code (.o) or assembly (.s) of the module for one target, rid of what nobody calls."""
    copy = whole.clone()
    copy.triple = triple
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu=cpu, opt=3, reloc="pic", codemodel="default")
    copy.data_layout = str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(copy, builder)
    code: bytes = machine.emit_object(copy) if suffix == ".o" else machine.emit_assembly(copy).encode()
    return code


def main(arguments: list[str]) -> int:
    """FOLDER ENTRIES TRIPLE=CPU=SUFFIX ...: write the code of each target to the folder."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    whole = module(arguments[1])
    for word in arguments[2:]:
        triple, cpu, suffix = word.split("=")
        (Path(arguments[0]) / f"{triple}-{cpu}{suffix}").write_bytes(emit(whole, triple, cpu, suffix))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
