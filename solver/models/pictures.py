"""What results ask of the modules that draw them, which lie in higher layers.

`solver/registrations.py` registers a module for each class of results; it is imported when it is first asked for.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import singledispatch
from typing import TYPE_CHECKING, Any, Protocol

from ..common.errors import InputError, needing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Path = str | os.PathLike[str]


class Pictures(Protocol):
    """A module that draws responses."""

    def plot_response(self, response: Any, path: Path | None, /) -> Figure: ...
    def plot_model(self, response: Any, path: Path | None, at: float | None, scale: float | None, /) -> Figure: ...
    def film(
        self,
        response: Any,
        path: Path,
        scale: float | None,
        fps: int,
        speed: float,
        callback: Callable[[int, int], object] | None,
        /,
    ) -> None: ...


class PicturesOfModes(Protocol):
    """A module that draws modes."""

    def plot_modes(self, modes: Any, path: Path | None, most: int, /) -> Figure: ...


class PicturesOfStructures(Pictures, PicturesOfModes, Protocol):
    """A module that draws responses, modes and push-overs of structures."""

    def plot_plan(self, response: Any, path: Path | None, blocks: Sequence[str | int] | None, /) -> Figure: ...
    def plot_push_over(self, push_over: Any, path: Path | None, /) -> Figure: ...


class Scenes(Protocol):
    """A module that writes the motion of bodies in space: as pages, glTF, files for ParaView."""

    def write_view(self, response: Any, path: Path, scale: float | None, /) -> None: ...
    def frame_of(self, response: Any, /) -> str: ...
    def write_gltf(self, response: Any, path: Path, /) -> None: ...
    def write_vtk(self, response: Any, folder: Path, fps: float, /) -> None: ...


def pictures_of(result: Any) -> Any:
    """Return the module that draws a result.

    Raises InputError without matplotlib (the extra `plot`), and if none is registered.
    """
    with needing("plot", "matplotlib"):
        return drawing_of(result)


@singledispatch
def drawing_of(result: Any) -> Any:
    """Import the module that draws a result, registered by its class; `pictures_of` also checks matplotlib."""
    raise InputError(f"plot: no pictures of a {type(result).__name__}: drawing_of (models/pictures.py) adds them")


@singledispatch
def scenes_of(response: Any) -> Scenes:
    """Import the module that writes the scenes of a response, registered by its class."""
    raise InputError(f"scene: none of a {type(response).__name__}: scenes_of (models/pictures.py) adds it")
