"""A column loaded from the project in the current folder."""

from __future__ import annotations

from typing import Any


def normal_force(column: str) -> float:
    """Of the top joint at rest, N."""
    from solver import Column
    from solver.kernels.layout import spaces as at
    from solver.models.column.stepper import Stepper

    loaded = Column.from_toml(column)
    return float(at.ROW.see(Stepper(loaded).observe(0.0), loaded.n).joints.N[0])


def entries_compiled_here() -> dict[str, int]:
    """How often this process compiled each entry that a first `simulate` needs; what it found on the disk counts 0."""
    from solver import Block, Column, Joint, Motion, simulate
    from solver.kernels.api import entries

    column = Column("one", (Block(1.0, 0.5, 0.5, 500.0, Joint(1e8, 0.01)),))
    simulate(column, Motion.harmonic(0.1, 1.0, 0.1)).observe()
    used: list[Any] = [entries.run, entries.assemble_column, entries.observe_snapshots, entries.observe_state]
    return {entry.py_func.__name__: sum(entry.stats.cache_misses.values()) for entry in used}
