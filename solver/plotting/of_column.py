"""Pictures of the response of a column, as `models/pictures.py` asks for them."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes

from ..models.column.packing import FloatArray
from ..models.column.response import Response
from . import film as films
from .drawings import corners_of, draw_column, plot_model, scale_of
from .lines import thinned
from .plots import draw_ground, plot_response
from .style import FEW_COLOURS, RED, STONE

__all__ = ["film", "plot_model", "plot_response"]


class _ColumnFigure(films.AnimatedFigure):
    """The column in motion beside its base acceleration and displacements."""

    def __init__(self, response: Response, scale: float | None, end: float) -> None:
        super().__init__(response, scale_of(response, scale), figsize=(9.0, 5.4))
        grid = self.figure.add_gridspec(
            2, 2, width_ratios=(1.0, 1.7), hspace=0.4, left=0.02, right=0.97, bottom=0.1, top=0.82
        )
        column = self.figure.add_subplot(grid[:, 0])
        ground, moved = self.figure.add_subplot(grid[0, 1]), self.figure.add_subplot(grid[1, 1])
        self.patches = draw_column(column, response, 0, self.scale)
        draw_ground(ground, response.motion)
        self._draw_displacements(moved)
        column.text(0.5, -0.01, self.factor, transform=column.transAxes, ha="center", va="top", fontsize=11, color=RED)
        clock = column.text(0.98, 1.0, "", transform=column.transAxes, ha="right", va="top", fontsize=12)
        self.animate(self.patches, clock, (ground, moved), end, (STONE, *FEW_COLOURS[: len(self.patches)]))

    def _draw_displacements(self, axes: Axes) -> None:
        """Plot ux of the blocks that have a colour: of all of few blocks, of the top one of many."""
        few = len(self.patches) <= len(FEW_COLOURS)
        ux: FloatArray = self.response.ux
        factor, unit = (1.0, "m") if np.max(np.abs(ux)) >= 1.0 else (1e3, "mm")
        for i, patch in enumerate(self.patches):
            if few or i == 0:
                axes.plot(*thinned(self.response.time, factor * ux[:, i]), color=FEW_COLOURS[i], linewidth=1.0)
                patch.set_facecolor(FEW_COLOURS[i])
            else:
                patch.set_facecolor(STONE)
        axes.set_title("displacement of the top faces" if few else "displacement of the top", loc="left")
        axes.set(xlabel="time (s)", ylabel=f"$u_x$ ({unit})")

    def place(self, k: int) -> None:
        for patch, corners in zip(self.patches, corners_of(self.response, k, self.scale), strict=True):
            patch.set_xy(corners)


film = partial(films.film, _ColumnFigure)
