"""What lower layers ask of higher ones, by class: the kinds of models, the modules that draw results.

A module is imported when it is first asked for, so that neither matplotlib nor the kernels of lanes are loaded before
they are used.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from .models.column.model import Column
from .models.column.modes import Modes
from .models.column.response import Response
from .models.pictures import drawing_of, scenes_of
from .models.protocol import Kind, kind_of, structure_of
from .models.response import Result
from .models.structure.model import Structure
from .models.structure.modes import SpatialModes
from .models.structure.outputs import StructureHistories


@kind_of.register(Column)
def _kind_of_column(column: Column) -> Kind:
    """Choose by formulation."""
    if column.settings.formulation == "paper":
        from .models.paper.kind import KIND as PAPER

        return PAPER
    from .models.column.kind import KIND

    return KIND


@kind_of.register(Structure)
def _kind_of_structure(structure: Structure) -> Kind:
    from .models.structure.kind import STRUCTURES

    return STRUCTURES


structure_of.register(Column, Structure.stack)


def _importing(module: str) -> Callable[[Any], Any]:
    """Return a function of any result that imports a module of this package."""
    return lambda result: import_module(module, __package__)


drawing_of.register(Response, _importing(".plotting.of_column"))
drawing_of.register(StructureHistories, _importing(".plotting.of_structure"))
drawing_of.register(SpatialModes, _importing(".plotting.of_structure"))
drawing_of.register(Modes, _importing(".statics.static_plots"))
scenes_of.register(Result, _importing(".plotting.scene"))
