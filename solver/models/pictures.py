"""The modules that draw results, which lie in higher layers: `solver/registrations.py` registers one for each class."""

from __future__ import annotations

from functools import singledispatch
from typing import TYPE_CHECKING, Any

from ..common.errors import InputError, needing

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(result: Any, name: str, *arguments: Any) -> Figure:
    """Call the function of this name in the module that draws a result, with the result and the arguments.

    Raises InputError without matplotlib (the extra `plot`), and if no module is registered.
    """
    with needing("plot", "matplotlib"):
        module = drawing_of(result)
    figure: Figure = getattr(module, name)(result, *arguments)
    return figure


@singledispatch
def drawing_of(result: Any) -> Any:
    """Import the module that draws a result with matplotlib, registered by its class."""
    raise InputError(f"plot: no pictures of a {type(result).__name__}: drawing_of (models/pictures.py) adds them")


@singledispatch
def scenes_of(response: Any) -> Any:
    """Import the module that writes the motion of bodies (pages, glTF, files for ParaView), registered by the class."""
    raise InputError(f"scene: none of a {type(response).__name__}: scenes_of (models/pictures.py) adds it")
