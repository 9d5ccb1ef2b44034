"""Machine code of the kernels, made once, on all cores, before the workers begin."""

from __future__ import annotations

from solver.kernels.machine.groups import GROUPS
from solver.kernels.machine.making import make


def make_all() -> None:
    """Make what is not kept."""
    make(GROUPS)
