"""What lower layers ask of higher ones, by class: the kinds of models, the modules that draw results.

Each function imports what it returns, so that neither matplotlib nor the kernels of lanes are loaded before they are
used.
"""

from __future__ import annotations

from typing import Any

from .models.column.model import Column
from .models.column.modes import Modes
from .models.column.response import Response
from .models.pictures import Pictures, PicturesOfModes, PicturesOfStructures, Scenes, drawing_of, scenes_of
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


@structure_of.register(Column)
def _stack(column: Column) -> Structure:
    return Structure.stack(column)


@drawing_of.register(Response)
def _pictures_of_columns(response: Response) -> Pictures:
    from .plotting import of_column

    return of_column


@drawing_of.register(StructureHistories)
@drawing_of.register(SpatialModes)
def _pictures_of_structures(result: Any) -> PicturesOfStructures:
    from .plotting import of_structure

    return of_structure


@drawing_of.register(Modes)
def _pictures_of_modes(modes: Modes) -> PicturesOfModes:
    from .statics import static_plots

    return static_plots


@scenes_of.register(Result)
def _scenes(response: Result) -> Scenes:
    from .plotting import scene

    return scene
