"""How an FMU starts on an account: what it finds compiled, and what it compiles."""

from __future__ import annotations

import pathlib
import sys
from typing import NoReturn

from support.instance import Instance, unpacked


def _read_only(*_: object, **__: object) -> NoReturn:
    raise PermissionError(13, "read-only")


def both(column: str, structure: str) -> list[int]:
    """How many kernels each of two FMUs in one process compiles."""
    made = []
    for fmu in (column, structure):
        known = set(sys.modules)
        body = Instance(fmu, {"base.ax": 0.5})
        body.step(0.0, 0.01)
        body.close()
        entries = [m for name, m in sys.modules.items() if name not in known and ".kernels" in name]
        kernels = {id(item): item for module in entries for item in vars(module).values() if hasattr(item, "stats")}
        made.append(sum(sum(kernel.stats.cache_misses.values()) for kernel in kernels.values()))
    return made


def start(fmu: str, hindrance: str = "", record: str = "") -> tuple[int, int, float]:
    """Kernels found compiled, kernels compiled, and a displacement.

    hindrance: "read-only", no folder can be made; "full", no file beyond 20 kB can be written.
    record: path of one to follow, or none.
    """
    folder = unpacked(fmu)
    if hindrance == "read-only":
        pathlib.Path.mkdir = _read_only  # type: ignore[method-assign]
    elif hindrance == "full":
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
    column = Instance(fmu, {"base.ax": 0.5, "base.record": record}, folder=folder)
    column.step(0.0, 0.1)
    (kernels,) = [m for name, m in sys.modules.items() if name.startswith("solver_") and name.endswith(ENTRIES)]
    stats = [kernel.stats for kernel in (kernels.assemble_column, kernels.run, kernels.observe_state)]
    hits, misses = (sum(map(len, part)) for part in ([s.cache_hits for s in stats], [s.cache_misses for s in stats]))
    ux = column.get("block[1].ux")[0]
    column.close()
    return hits, misses, ux


ENTRIES = "kernels.api.entries"  # the module with the kernels that the slave calls


def simulate() -> list[int]:
    """How often each kernel of a Python run, those of its outputs aside, was compiled in this process."""
    from typing import Any

    from solver import Motion
    from solver import simulate as run
    from solver.kernels.api import entries
    from support.probe import phocas

    run(phocas(), Motion.harmonic(0.1, 1.0, 0.1))
    used: list[Any] = [entries.assemble_column, entries.run]
    return [len(entry.stats.cache_misses) for entry in used]
