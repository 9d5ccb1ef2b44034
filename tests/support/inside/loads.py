"""A column loaded from the project in the current folder."""

from __future__ import annotations


def normal_force(column: str) -> float:
    """Of the top joint at rest, N."""
    from solver import Column
    from solver.kernels.layout import spaces as at
    from solver.models.column.stepper import Stepper

    loaded = Column.from_toml(column)
    return float(at.ROW.see(Stepper(loaded).observe(0.0), loaded.n).joints.N[0])
