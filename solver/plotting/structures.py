"""Figures of structures in space: deformed at an instant, orbits in plan, histories."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.proj3d import proj_transform

from ..models.structure.blocks.faces import FloatArray
from ..models.structure.blocks.parts import Joint
from ..models.structure.blocks.shapes import rotation_matrix
from ..models.structure.model import Structure
from ..models.structure.response import SpatialResponse
from .figures import Figure
from .film import FILM_DPI, FRAMES_PER_SECOND, Progress, shoot
from .largest import largest_displacement, length
from .plots import draw_ground
from .scene.bodies import normal_of, parts_of, walls_of
from .solids import EDGE, SHADED, Solids, towards_viewer
from .style import GREY, GRID, INK, RED, TINT, VERDICT_COLOURS, aside, header, nice, plain, save, tidy
from .words import setting_of, verdict_of

VISIBLE = 0.08  # of the extent: largest deformation in a picture
MARGIN, BAR = 0.06, 0.2  # of the extent: ground around the blocks, longest bar of the scale
DPI = 130
FILLED = 0.96  # of the axes
GROUND, WALL = "#e9e6df", "#d9d5cb"
BEARING, SIDES, FLAT = "#4f4a44", 24, 0.3  # colour; points of its rim; ratio of height to diameter if not on the base


def plot_model(
    response: SpatialResponse, path: str | os.PathLike[str] | None, at: float | None, scale: float | None
) -> Figure:
    """Draw the structure at an instant with its deformation scaled, and save the figure if `path` is given.

    Parameters
    ----------
    response : SpatialResponse
    path : path-like or None
        File to save to.
    at : float or None
        Time, s, of which the nearest row is drawn. None: the row of the largest horizontal displacement.
    scale : float or None
        Factor on the deformation. None: one at which it is visible, 1 where it is large.

    Returns
    -------
    Figure

    Raises
    ------
    InputError, OSError
        As `save` does.
    """
    k = _row_at(response, at)
    scale = _scale_of(response, k) if scale is None else scale
    u, turn = _places(response, k)
    figure = Figure(figsize=(6.4, 6.8), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    draw_blocks(axes, response.model, scale * u, scale * turn)
    if _mark_cracks(axes, response, k, scale * u, scale * turn):
        axes.text2D(0.0, 0.0, "red: joints that have broken, dashed: cracked", transform=axes.transAxes, color=RED)
    factor = f", deformation x {scale:g}" if scale != 1.0 else ", to scale"
    axes.set_title(f"at {response.time[k]:.3g} s{factor}", fontsize=10, color=RED, loc="left")
    _head(figure, response)
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


def structure_picture(structure: Structure) -> Figure:
    """Draw the structure as built."""
    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    zero = np.zeros((structure.n, 3))
    draw_blocks(figure.add_subplot(projection="3d"), structure, zero, zero)
    return figure


def film(
    response: SpatialResponse,
    path: str | os.PathLike[str],
    scale: float | None = None,
    fps: int = FRAMES_PER_SECOND,
    speed: float = 1.0,
    callback: Progress | None = None,
) -> None:
    """Write a film of the structure in motion with its deformation scaled.

    Parameters
    ----------
    response : SpatialResponse
    path : path-like
        File to write: .gif, or .mp4 where ffmpeg is installed.
    scale : float, optional
        Factor on the deformation. Default: one at which it is visible, 1 where it is large.
    fps : int
        Frames per second.
    speed : float
        Seconds of motion in a second of film.
    callback : callable, optional
        Called after each frame with the number of frames made and the number of all.

    Raises
    ------
    InputError, OSError
        As `film.film` does.
    """
    scale = _scale_of(response, _row_at(response, None)) if scale is None else scale
    shoot(response, path, lambda end: _Scene(response, scale, end), fps, speed, callback)


class _Scene:
    """A figure in which only the blocks, the cursor and the clock move."""

    def __init__(self, response: SpatialResponse, scale: float, end: float) -> None:
        self._response, self._scale = response, scale
        self.figure = Figure(figsize=(5.6, 6.4), dpi=FILM_DPI, layout="constrained")
        self.canvas: Any = FigureCanvasAgg(self.figure)
        grid = self.figure.add_gridspec(2, 1, height_ratios=(5.0, 1.0))
        axes, ground = self.figure.add_subplot(grid[0], projection="3d"), self.figure.add_subplot(grid[1])
        zero = np.zeros((response.model.n, 3))
        self._solids = draw_blocks(axes, response.model, zero, zero, _reached(response, scale, end))
        draw_ground(ground, response.motion)
        tidy(ground)
        ground.set_xlim(response.time[0], end)
        mark_fall(ground, response.overturn_time)
        # titles, and the artists that change from frame to frame
        colour = _head(self.figure, response)
        factor = "to scale" if scale == 1.0 else rf"deformation $\times$ {scale:g}"
        axes.text2D(0.0, 1.02, factor, transform=axes.transAxes, color=RED)
        self._solids.set_antialiased(False)  # edges of mixed colours would double the size of a GIF
        self._clock = axes.text2D(1.0, 1.02, "", transform=axes.transAxes, ha="right", fontsize=12)
        self._cursor = ground.axvline(response.time[0], color="black", linewidth=0.8)
        self.moving: tuple[Artist, ...] = (self._solids, self._cursor, self._clock)
        for artist in self.moving:
            artist.set_animated(True)
        self.colours = (*SHADED, EDGE, GROUND, WALL, INK, RED, GRID, colour)

    def show(self, k: int) -> None:
        """Move the blocks, cursor and clock to row k."""
        u, turn = _places(self._response, k)
        self._solids.place(self._scale * u, self._scale * turn)
        self._solids.do_3d_projection()
        instant = self._response.time[k]
        self._cursor.set_xdata([instant, instant])
        self._clock.set_text(f"{instant:.2f} s")


def _reached(response: SpatialResponse, scale: float, end: float) -> FloatArray:
    """Return points that bound the film, m: corners as built, moved by the extremes of the centroid's displacement."""
    rows = response.time <= end
    corners = []
    for i, block in enumerate(response.model.blocks):
        moved = np.stack([getattr(response, name)[rows, i] for name in ("ux", "uy", "uz")], axis=-1)
        corners += [block.corners + scale * by(moved, axis=0) for by in (np.min, np.max)]
    reach = np.concatenate(corners)
    built = _all_corners(response.model)
    low, high = built.min(axis=0), built.max(axis=0)
    most = float(np.max(high - low))  # a block that flies off leaves the picture
    within: FloatArray = np.clip(reach, low - most, high + most)
    return within


def _head(figure: Figure, response: SpatialResponse) -> str:
    """Write title and verdict, and return the colour of the verdict."""
    word, sentence = verdict_of(response)
    colour = VERDICT_COLOURS.get(word, INK)
    header(figure, setting_of(response.model, response.motion), sentence, colour)
    return colour


def draw_blocks(
    axes: Any, structure: Structure, u: FloatArray, turn: FloatArray, room: FloatArray | None = None
) -> Solids:
    """Draw displaced blocks on 3D axes, with ground, walls, bearings and a scale.

    Parameters
    ----------
    axes : Axes3D
    structure : Structure
    u : array (n, 3)
        Displacements of the centroids, m.
    turn : array (n, 3)
        Rotations, axis times angle, rad.
    room : array (points, 3), optional
        Further points that must lie within the axes, m.

    Returns
    -------
    Solids
        The artist of the blocks.
    """
    solids = Solids(parts_of(structure)[0])
    solids.place(u, turn)
    axes.set_proj_type("ortho")
    axes.view_init(elev=18, azim=-62)
    axes.computed_zorder = False
    axes.add_collection(solids, autolim=False)
    # limits that hold blocks, walls, ground and `room`
    walls = [wall.centroid + wall.surfaces[0].points for wall in walls_of(structure)]
    corners = np.concatenate([solids.points, *walls, *([] if room is None else [room])])
    low, high = corners.min(axis=0), corners.max(axis=0)
    low[2] = min(low[2], 0.0)
    largest = float(np.max(high - low))
    margin = MARGIN * largest * np.array([1.0, 1.0, 0.0])
    low, high = low - margin, high + margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    # zoom at which the projected box fills the axes
    flat = axes.transLimits.transform(np.column_stack(proj_transform(*_box(low, high).T, axes.get_proj())[:2]))
    axes.set_box_aspect(high - low, zoom=FILLED / float(np.max(np.ptp(flat, axis=0))))
    axes.set_axis_off()
    # ground, walls, bearings and scale
    x, y = np.array([low[0], high[0], high[0], low[0]]), np.array([low[1], low[1], high[1], high[1]])
    ground = Poly3DCollection([np.column_stack([x, y, np.zeros(4)])], facecolors=GROUND, edgecolors="0.75", zorder=0.5)
    axes.add_collection3d(ground, autolim=False)
    for wall in walls:
        axes.add_collection3d(_wall(wall, axes), autolim=False)
    for joint in structure.bearings:
        moved = u[joint.lower] if joint.lower < structure.n else np.zeros(3)
        axes.add_collection3d(_bearing(joint, moved, joint.lower == structure.n), autolim=False)
    _measure(axes, np.array([low[0], low[1], 0.0]), nice(BAR * largest))
    return solids


def _wall(points: FloatArray, axes: Any) -> Poly3DCollection:
    """Return a wall: filled behind all blocks, or, seen from behind, its edges in front of them."""
    behind = float(normal_of(points) @ towards_viewer(axes)) > 0.0
    colour, order = (WALL, 0.6) if behind else ("none", 2.0)
    return Poly3DCollection([points], facecolors=colour, edgecolors=EDGE, linewidths=0.6, zorder=order)


def _bearing(joint: Joint, moved: FloatArray, on_base: bool) -> Poly3DCollection:
    """Return a bearing as a flat drum below its centre, behind all blocks; `moved`: displacement of its support, m."""
    high = joint.face.points(SIDES) + moved
    low = high - FLAT * 2.0 * joint.face.radius * joint.face.normal
    if on_base:
        low[:, 2] = 0.0
    sides = [np.array([low[k - 1], low[k], high[k], high[k - 1]]) for k in range(len(low))]
    return Poly3DCollection(sides, facecolors=BEARING, edgecolors=BEARING, linewidths=0.3, zorder=0.7)


def _box(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the corners of a box, (8, 3)."""
    found: FloatArray = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    return found


def _measure(axes: Any, corner: FloatArray, length: float) -> None:
    """Draw bars of one length along the three axes from a corner of the ground, and label them."""
    for k, name in enumerate("xyz"):
        end = corner + length * np.eye(3)[k]
        axes.plot(*zip(corner, end, strict=True), color=GREY, linewidth=1.6, zorder=0.8, solid_capstyle="round")
        text = f"{name}, {length:g} m" if k == 0 else name
        place = ("left", "top") if k == 0 else ("center", "bottom")
        axes.text(*end, text, color=GREY, fontsize=8, ha=place[0], va=place[1], zorder=3.0)


def plot_plan(
    response: SpatialResponse, path: str | os.PathLike[str] | None, blocks: Sequence[str | int] | None = None
) -> Figure:
    """Plot the orbits of block centroids in plan, mm, and save the figure if `path` is given.

    Parameters
    ----------
    response : SpatialResponse
    path : path-like or None
        File to save to.
    blocks : sequence of str or int, optional
        Names or numbers of the blocks. Default: the highest one.

    Returns
    -------
    Figure

    Raises
    ------
    InputError, OSError
        As `save` does.
    """
    if blocks is None:
        blocks = [int(np.argmax([block.centroid[2] for block in response.model.blocks]))]
    figure = Figure(figsize=(5.2, 5.0), layout="constrained")
    axes = figure.add_subplot()
    for block in blocks:
        i = response.model.number(block)
        axes.plot(1e3 * response.ux[:, i], 1e3 * response.uy[:, i], linewidth=0.9, label=plain(response.model.names[i]))
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("$u_x$ (mm)")
    axes.set_ylabel("$u_y$ (mm)")
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
    aside(top, f"{until} {length(largest)} horizontally")
    top.legend(ncols=3, frameon=False, fontsize=8)
    middle.plot(response.time, 1e3 * np.max(np.linalg.norm(response.rotation, axis=2), axis=1), linewidth=0.9)
    middle.set(title="largest rotation of a block", ylabel="rotation (mrad)")
    bottom.plot(response.time, np.min(response.contact, axis=1), linewidth=0.9)
    bottom.set(title="least contact of a joint", ylabel="part of its area", xlabel="time (s)", ylim=(-0.03, 1.03))
    for axes in (ground, top, middle, bottom):
        tidy(axes)
        mark_fall(axes, response.overturn_time)
    top.set_xlim(response.time[0], response.time[-1])
    _head(figure, response)
    return save(figure, path, DPI)


def mark_fall(axes: Axes, overturn_time: float) -> None:
    """Draw a dashed line at the time of a fall, and a tint after it; nothing if no block falls."""
    if np.isfinite(overturn_time):
        axes.axvline(overturn_time, color="black", linestyle="--", linewidth=1.0)
        axes.axvspan(overturn_time, axes.get_xlim()[1], color=TINT, linewidth=0.0, zorder=0.0)


def _row_at(response: SpatialResponse, at: float | None) -> int:
    if at is not None:
        return int(np.argmin(np.abs(response.time - at)))
    return int(np.argmax(np.max(np.hypot(response.ux, response.uy), axis=1)))


def _all_corners(structure: Structure) -> FloatArray:
    return np.concatenate([block.corners for block in structure.blocks])


def _places(response: SpatialResponse, k: int) -> tuple[FloatArray, FloatArray]:
    """Return displacements and rotations of all blocks at row k, (n, 3) each."""
    u = np.stack([response.ux[k], response.uy[k], response.uz[k]], axis=-1)
    turn: FloatArray = response.rotation[k]
    return u, turn


def _scale_of(response: SpatialResponse, k: int) -> float:
    """Return a factor that makes the deformation at row k visible; 1 where it is large."""
    largest = max(float(np.max(np.abs(_places(response, k)[0]))), 1e-12)
    return min(max(1.0, nice(VISIBLE * extent_of(response.model) / largest)), 1e4)


def extent_of(structure: Structure) -> float:
    """Return the largest extent of a structure along an axis, m."""
    return max(float(np.max(np.ptp(_all_corners(structure), axis=0))), 1e-9)
