"""Compilation of an LLVM module for any target: it is optimized once for all, then emitted for each."""

import multiprocessing
import os
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from llvmlite import binding as llvm

from .bounds import BOUNDS

SPEED = 1 if BOUNDS else 3  # of LLVM's levels: the branches of checks take the highest eight times as long


def optimize(whole: llvm.ModuleRef, triple: str, cpu: str) -> None:
    """Optimize a module, without functions that are never called."""
    machine = machine_for(whole, triple, cpu)
    for level in (0, SPEED):  # small functions into their callers first, as numba does
        builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=level))
        passes = builder.getModulePassManager()
        # simplify small functions before they are inlined
        if not level:
            passes.add_loop_rotate_pass()
            passes.add_instruction_combine_pass()
            passes.add_jump_threading_pass()
        passes.run(whole, builder)


def machine_for(whole: llvm.ModuleRef, triple: str, cpu: str) -> llvm.TargetMachine:
    """Return the target machine, and set the module to its triple and data layout."""
    # position-independent code
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu=cpu, opt=3, reloc="pic", codemodel="default")
    whole.triple, whole.data_layout = triple, str(machine.target_data)
    return machine


def emit(bitcode: bytes, triple: str, cpu: str, prefix: str, file: str) -> None:
    """Write the object code, or assembly (.s), of an optimized module for one target.

    Parameters
    ----------
    bitcode : bytes
        The optimized module.
    triple, cpu : str
        The target, as LLVM names it.
    prefix : str
        Prefix of the exported names, which are then hidden from all but the code linked with it; "" leaves the names
        as they are.
    file : str
        The file; its suffix decides the format.
    """
    initialize()
    whole = llvm.parse_bitcode(bitcode)
    # prefix the exported functions
    for function in whole.functions if prefix else ():
        if not function.is_declaration and function.linkage == llvm.Linkage.external:
            function.name, function.visibility = prefix + function.name, "hidden"
    # code of the whole module for the target
    machine = machine_for(whole, triple, cpu)
    code = machine.emit_assembly(whole).encode() if file.endswith(".s") else machine.emit_object(whole)
    Path(file).write_bytes(code)


def emit_all(bitcode: bytes, targets: Sequence[tuple[str, str, str, str]]) -> None:
    """Write the code of an optimized module for each target (triple, processor, prefix, file), on all cores."""
    if len(targets) == 1:
        emit(bitcode, *targets[0])
        return
    # a new interpreter would import the compiler once more, for some seconds each
    context = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
    with ProcessPoolExecutor(min(len(targets), os.cpu_count() or 1), context) as workers:
        begun = {workers.submit(emit, bitcode, *target): target for target in targets}
        for done in as_completed(begun):
            done.result()
            tell(f"machine code: {'/'.join(begun[done][:2])}")


def initialize() -> None:
    """Initialize LLVM's code generators of all targets."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()


def tell(text: str) -> None:
    """Print a line of progress, with the processor time (s) that this process has used so far."""
    print(f"{text} ({time.process_time():.0f} s)", file=sys.stderr, flush=True)
