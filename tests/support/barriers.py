"""The energy that a column needs to fall."""

from __future__ import annotations

from solver.models.column.kinematics import chain_of
from solver.models.column.model import Column
from solver.models.column.verdict import PARTS, Barrier, least_energy, limits_at


def barrier(column: Column) -> Barrier:
    """Return the energy that a column needs to fall, above rest; zero where its rest is not stable."""
    chain = chain_of(column)
    found = max((least_energy(chain, limits_at(chain, part)) for part in PARTS), key=lambda each: float(each.energy))
    return Barrier(max(0.0, float(found.energy)), found.limits)
