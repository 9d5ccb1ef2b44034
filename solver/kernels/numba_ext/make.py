"""Machine code of groups of entries: `python -m solver.kernels.numba_ext.make GROUP BITCODE TARGET... [-- GROUP ...]`.

The entries are typed by numba, linked and optimized once, and emitted for each target. GROUP is MODULE:NAME. BITCODE is
the file of the optimized module, written if it does not exist. TARGET is LEVEL=FILE, or TRIPLE/CPU/PREFIX=FILE for
another machine or under other names (emitting.py); the suffix of the file decides the format: object code, or assembly
(.s). Groups in one process share the kernels that are typed.
"""

import importlib
import sys
from pathlib import Path
from typing import Any

from llvmlite import binding as llvm
from llvmlite import ir
from numba import types

from ..machine.bounds import BOUNDS
from ..machine.emitting import emit_all, initialize, optimize, tell
from ..machine.entry import Entry, entries_of
from ..machine.kinds import Int, Ints, Real, Reals, SizedReals
from ..machine.level import ARM, X86, is_arm
from .jit import as_written
from .linking import collecting_seldom, linked
from .rows import RowType, SizedType

_I32, _I64, _DOUBLE = ir.IntType(32), ir.IntType(64), ir.DoubleType()
_BYTES = ir.IntType(8).as_pointer()
# kind -> its type for numba, and those of its slots
NUMBAS = {
    Int: types.int64,
    Real: types.float64,
    Reals: RowType(types.float64),
    Ints: RowType(types.int64),
    SizedReals: SizedType(),
}
_SIZE = (_I64,) if BOUNDS else ()
_SLOTS: dict[Any, tuple[ir.Type, ...]] = {
    Int: (_I64,),
    Real: (_DOUBLE,),
    Reals: (_DOUBLE.as_pointer(), *_SIZE),
    Ints: (_I64.as_pointer(), *_SIZE),
    SizedReals: (_DOUBLE.as_pointer(), _I64),
}
# kind -> which of its slots numba's function takes: in a checked build the size as count and room of a row (bounds.py)
_TAKEN: dict[Any, tuple[int, ...]] = {Int: (0,), Real: (0,)}
_TAKEN |= dict.fromkeys((Reals, Ints), (0, 1, 1) if BOUNDS else (0,))
_TAKEN[SizedReals] = (0, 1, 1, 1) if BOUNDS else (0, 1)
BASELINE = X86[-1]


def module_of(group: str) -> llvm.ModuleRef:
    """Return the module of the entries of a group and all their callees, each once, not optimized."""
    # the module registers its entries
    module, _, name = group.partition(":")
    importlib.import_module(module)
    entries, libraries, bridges = entries_of(name), [], []
    # each entry, with its bridge
    for entry in entries:
        library, inside = as_written(entry.function, tuple(NUMBAS[kind] for kind in entry.kinds.values()))
        libraries.append(library)
        bridges.append(str(bridge(entry, inside)))
        tell(f"kernels typed: {entry.__name__}")
    whole, offered = linked(libraries), {entry.__name__ for entry in entries}
    for text in bridges:
        whole.link_in(llvm.parse_assembly(text))
    # only the entries are exported
    for item in [*whole.functions, *whole.global_variables]:
        if not item.is_declaration:
            item.linkage = "external" if item.name in offered else "internal"
    return whole


def bridge(entry: Entry, inside: str) -> ir.Module:
    """Return a function by the name of an entry that takes the address of a buffer, and calls numba's function.

    Numba's function returns 0, and takes the addresses of its result and of an exception before the arguments.

    Parameters
    ----------
    entry : Entry
        The entry.
    inside : str
        Name of numba's function.
    """
    module = ir.Module(name=f"bridge_{entry.__name__}")
    # slots of the buffer, and which of them numba's function takes
    slots: list[ir.Type] = []
    taken: list[int] = []
    for kind in entry.kinds.values():
        taken += [len(slots) + place for place in _TAKEN[kind]]
        slots += _SLOTS[kind]
    # declare both functions
    result = _DOUBLE if entry.result is Real else _I64
    called = ir.FunctionType(_I32, [result.as_pointer(), _BYTES.as_pointer(), *(slots[k] for k in taken)])
    numbas = ir.Function(module, called, name=inside)
    function = ir.Function(module, ir.FunctionType(_I64, [_I64.as_pointer()]), name=entry.__name__)
    # load the slots, call, and return the bits of the result
    builder = ir.IRBuilder(function.append_basic_block())
    found, raised = builder.alloca(result), builder.alloca(_BYTES)
    passed = []
    for k, slot in enumerate(slots):
        place = builder.gep(function.args[0], [_I64(k)])
        passed.append(builder.load(builder.bitcast(place, slot.as_pointer())))
    builder.call(numbas, [found, raised, *(passed[k] for k in taken)])
    if entry.result is None:
        builder.ret(_I64(0))
    else:
        builder.ret(builder.bitcast(builder.load(found), _I64))
    return module


def local_triple() -> str:
    """Return the triple of object code that llvmlite loads in this process."""
    triple: str = llvm.get_process_triple()
    return f"{triple}-elf" if sys.platform == "win32" else triple


def target_of(word: str) -> tuple[str, str, str]:
    """Return triple, processor and prefix of a target word: LEVEL or TRIPLE/CPU/PREFIX."""
    if "/" in word:
        triple, cpu, prefix = word.split("/")
        return triple, cpu, prefix
    return local_triple(), "generic" if word in ARM else word, ""


def make(group: str, bitcode: Path, targets: list[tuple[str, str, str, str]]) -> None:
    """Write the code of a group for each target (triple, processor, prefix, file), and its optimized module."""
    # optimize once for all targets
    if not bitcode.is_file():
        with collecting_seldom():
            whole = module_of(group)
        optimize(whole, local_triple(), target_of(ARM[0] if is_arm() else BASELINE)[1])
        tell(f"kernels optimized: {group}")
        bitcode.write_bytes(whole.as_bitcode())
    emit_all(bitcode.read_bytes(), targets)


def main(arguments: list[str]) -> int:
    """Write the code of each target of each group; the arguments are GROUP BITCODE TARGET=FILE ... [-- GROUP ...]."""
    initialize()
    while arguments:
        # the words of one group
        end = arguments.index("--") if "--" in arguments else len(arguments)
        (group, bitcode, *words), arguments = arguments[:end], arguments[end + 1 :]
        pairs = (word.partition("=") for word in words)
        make(group, Path(bitcode), [(*target_of(target), file) for target, _, file in pairs])
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
