"""Interfaces of results that pictures draw; the modules of the results import from above this one."""

from __future__ import annotations

from typing import Protocol

from ..models.column.model import Column
from ..models.column.packing import FloatArray


class Shapes(Protocol):
    """Rows of places of a column, (rows, n) each: of a Response, of Modes, of a CapacityCurve."""

    @property
    def column(self) -> Column: ...
    @property
    def ux(self) -> FloatArray: ...
    @property
    def uz(self) -> FloatArray: ...
    @property
    def theta(self) -> FloatArray: ...
