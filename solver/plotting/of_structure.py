"""Pictures of responses, modes and push-overs of structures, as `models/pictures.py` asks for them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..models.structure.blocks.faces import FloatArray
from ..models.structure.blocks.shapes import rotation_matrix
from ..models.structure.response import SpatialResponse
from . import film as films
from .drawings import check_scale, row_at
from .largest import largest_displacement, length
from .plots import draw_ground
from .solids import EDGE, SHADED
from .structure_statics import plot_modes, plot_push_over
from .structures import GROUND, WALL, all_corners, draw_blocks, visible_scale
from .style import RED, TINT, Figure, note_on_right, plain, save, tidy
from .words import drawn_larger, setting_of, verdict_of, write_header

__all__ = ["film", "plot_model", "plot_modes", "plot_plan", "plot_push_over", "plot_response"]

MOST_TIMES = 1e4  # factor on the deformation
DPI = 130


def plot_model(
    response: SpatialResponse, path: str | os.PathLike[str] | None, at: float | None, scale: float | None
) -> Figure:
    """Draw the structure at an instant with its deformation scaled, and save the figure if `path` is given.

    `at` is by default the time of the largest horizontal displacement; the factor `scale` makes the deformation visible
    by default, and is 1 where it is large. Raises InputError, OSError as `save` does.
    """
    k = _peak(response) if at is None else row_at(response, at)
    scale = _scale_of(response, k) if scale is None else check_scale(scale)
    u, turn = _places(response, k)
    figure = Figure(figsize=(6.4, 6.8), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    draw_blocks(axes, response.model, scale * u, scale * turn)
    if _mark_cracks(axes, response, k, scale * u, scale * turn):
        axes.text2D(0.0, 0.0, "red: joints that have broken, dashed: cracked", transform=axes.transAxes, color=RED)
    axes.set_title(f"at {response.time[k]:.3g} s, {drawn_larger(scale)}", fontsize=10, color=RED, loc="left")
    write_header(figure, setting_of(response.model, response.motion), verdict_of(response))
    return save(figure, path, DPI)


def _mark_cracks(axes: Any, response: SpatialResponse, k: int, u: FloatArray, turn: FloatArray) -> bool:
    """Draw the outlines of cracked joints on their lower blocks, and return True if there are any."""
    structure = response.model
    hurt = [
        (structure.joints[j], left) for j, left in zip(structure.bonds, response.bond[k], strict=True) if left < 1.0
    ]
    for joint, left in hurt:
        points, body = joint.face.points(), joint.lower
        if body < structure.n:
            centroid = structure.blocks[body].centroid
            points = centroid + u[body] + (points - centroid) @ rotation_matrix(turn[body]).T
        outline = np.concatenate([points, points[:1]])
        axes.plot(*outline.T, color=RED, linewidth=1.4, linestyle="--" if left else "-", zorder=3)
    return bool(hurt)


class _StructureFigure(films.AnimatedFigure):
    """The structure in motion over its base acceleration."""

    def __init__(self, response: SpatialResponse, scale: float | None, end: float) -> None:
        scale = _scale_of(response, _peak(response)) if scale is None else check_scale(scale)
        super().__init__(response, scale, figsize=(5.6, 6.4), layout="constrained")
        grid = self.figure.add_gridspec(2, 1, height_ratios=(5.0, 1.0))
        axes: Any = self.figure.add_subplot(grid[0], projection="3d")
        ground = self.figure.add_subplot(grid[1])
        zero = np.zeros((response.model.n, 3))
        self._solids = draw_blocks(axes, response.model, zero, zero, _reached(response, scale, end))
        self._solids.set_antialiased(False)  # edges of mixed colours would double the size of a GIF
        draw_ground(ground, response.motion)
        ground.set_xlabel("time (s)")
        axes.text2D(0.0, 1.02, self.factor, transform=axes.transAxes, color=RED)
        clock = axes.text2D(1.0, 1.02, "", transform=axes.transAxes, ha="right", fontsize=12)
        self.animate((self._solids,), clock, (ground,), end, (*SHADED, EDGE, GROUND, WALL))
        _mark_fall(ground, response.overturn_time)

    def place(self, k: int) -> None:
        u, turn = _places(self.response, k)
        self._solids.place(self.scale * u, self.scale * turn)
        self._solids.do_3d_projection()


film = partial(films.film, _StructureFigure)


def _reached(response: SpatialResponse, scale: float, end: float) -> FloatArray:
    """Return points that bound the film, m: corners as built, moved by the extremes of the centroid's displacement."""
    rows = response.time <= end
    corners = []
    for i, block in enumerate(response.model.blocks):
        moved = np.stack([getattr(response, name)[rows, i] for name in ("ux", "uy", "uz")], axis=-1)
        corners += [block.corners + scale * by(moved, axis=0) for by in (np.min, np.max)]
    built = all_corners(response.model)
    low, high = built.min(axis=0), built.max(axis=0)
    most = float(np.max(high - low))  # a block that flies off leaves the picture
    return np.clip(np.concatenate(corners), low - most, high + most)


def plot_plan(
    response: SpatialResponse, path: str | os.PathLike[str] | None, blocks: Sequence[str | int] | None
) -> Figure:
    """Plot the orbits of block centroids in plan, mm, by names or numbers; by default of the highest block.

    The figure is saved if `path` is given. Raises InputError, OSError as `save` does.
    """
    if blocks is None:
        blocks = [int(np.argmax([block.centroid[2] for block in response.model.blocks]))]
    figure = Figure(figsize=(5.2, 5.0), layout="constrained")
    axes = figure.add_subplot()
    for block in blocks:
        i = response.model.number(block)
        axes.plot(1e3 * response.ux[:, i], 1e3 * response.uy[:, i], linewidth=0.9, label=plain(response.model.names[i]))
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="$u_x$ (mm)", ylabel="$u_y$ (mm)")
    axes.grid(alpha=0.3)
    axes.legend()
    return save(figure, path, DPI)


def plot_response(response: SpatialResponse, path: str | os.PathLike[str] | None) -> Figure:
    """Plot base motion, displacement of the block that moves most, largest rotation and least contact over time.

    Marks a fall, and saves the figure if `path` is given. Raises InputError, OSError as `save` does.
    """
    figure = Figure(figsize=(7.5, 8.4), layout="constrained")
    ground, top, middle, bottom = figure.subplots(4, 1, sharex=True)
    draw_ground(ground, response.motion)
    # displacement of the block that moves most, rotation, contact
    largest, i = largest_displacement(response)
    for name in ("ux", "uy", "uz"):
        top.plot(response.time, 1e3 * getattr(response, name)[:, i], linewidth=0.9, label=f"$u_{name[1]}$")
    until = "before the fall" if np.isfinite(response.overturn_time) else "at most"
    top.set(title=f"displacement of {plain(response.model.names[i])}", ylabel="$u$ (mm)")
    note_on_right(top, f"{until} {length(largest)} horizontally")
    top.legend(ncols=3, frameon=False, fontsize=8)
    middle.plot(response.time, 1e3 * np.max(np.linalg.norm(response.rotation, axis=2), axis=1), linewidth=0.9)
    middle.set(title="largest rotation of a block", ylabel="rotation (mrad)")
    bottom.plot(response.time, np.min(response.contact, axis=1), linewidth=0.9)
    bottom.set(title="least contact of a joint", ylabel="part of its area", xlabel="time (s)", ylim=(-0.03, 1.03))
    for axes in (ground, top, middle, bottom):
        tidy(axes)
        _mark_fall(axes, response.overturn_time)
    top.set_xlim(response.time[0], response.time[-1])
    write_header(figure, setting_of(response.model, response.motion), verdict_of(response))
    return save(figure, path, DPI)


def _mark_fall(axes: Axes, overturn_time: float) -> None:
    """Draw a dashed line at the time of a fall, and a tint after it; nothing if no block falls."""
    if np.isfinite(overturn_time):
        axes.axvline(overturn_time, color="black", linestyle="--", linewidth=1.0)
        axes.axvspan(overturn_time, axes.get_xlim()[1], color=TINT, linewidth=0.0, zorder=0.0)


def _peak(response: SpatialResponse) -> int:
    return int(np.argmax(np.max(np.hypot(response.ux, response.uy), axis=1)))


def _places(response: SpatialResponse, k: int) -> tuple[FloatArray, FloatArray]:
    """Return displacements and rotations of all blocks at row k, (n, 3) each."""
    u = np.stack([response.ux[k], response.uy[k], response.uz[k]], axis=-1)
    turn: FloatArray = response.rotation[k]
    return u, turn


def _scale_of(response: SpatialResponse, k: int) -> float:
    """Return a factor that makes the deformation at row k visible; 1 where it is large."""
    return min(visible_scale(response.model, _places(response, k)[0]), MOST_TIMES)
