"""Pictures of structures in space: deformed at an instant, orbits in plan, histories."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from ..common.errors import POSITIVE, check_number
from ..common.files import whole_file
from ..models.structure.blocks.faces import FloatArray
from ..models.structure.blocks.parts import Solid
from ..models.structure.blocks.shapes import turned
from ..models.structure.model import Structure
from ..models.structure.response import SpatialResponse
from .figures import Figure
from .film import FILM_DPI, check_film
from .style import nice, plain, save

ROOM = 0.12  # of the extent: around a structure that is filmed
VISIBLE = 0.08  # of the extent: largest deformation in a picture
STONE, EDGE = "#d9d2c3", "#6b6558"
SIDES = 24
DPI = 130
TICKS = 6  # along the longest axis


def plot_structure(
    response: SpatialResponse, path: str | os.PathLike[str] | None, at: float | None, scale: float | None
) -> Figure:
    """The structure at an instant, deformation enlarged."""
    k = _row_at(response, at)
    scale = _scale_of(response, k) if scale is None else scale
    u, turn = _places(response, k)
    figure = Figure(figsize=(6.4, 6.4), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    draw_blocks(axes, response.structure, scale * u, scale * turn)
    times = f", deformation x {scale:g}" if scale != 1.0 else ""
    axes.set_title(f"{plain(response.structure.name)} at {response.time[k]:.3g} s{times}", fontsize=10)
    return save(figure, path, DPI)


def structure_picture(structure: Structure) -> Figure:
    """The structure as built."""
    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    zero = np.zeros((structure.n, 3))
    draw_blocks(figure.add_subplot(projection="3d"), structure, zero, zero)
    return figure


def film(response: SpatialResponse, path: str | os.PathLike[str], scale: float | None, fps: int, speed: float) -> None:
    """The structure in motion, deformation enlarged; fps: pictures a second, speed: s of motion in a second of film."""
    check_film(path)
    fps = round(check_number("fps", fps, (1.0, 100.0), "a whole number of pictures a second, from 1 to 100"))
    speed = check_number("speed", speed, POSITIVE, "seconds of motion in a second of film, positive")
    time, scale = response.time, _scale_of(response, _row_at(response, None)) if scale is None else scale
    figure = Figure(figsize=(5.6, 5.6), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    writer: AbstractMovieWriter = FFMpegWriter(fps=fps) if os.fspath(path).endswith(".mp4") else PillowWriter(fps=fps)
    with whole_file(path) as partial, writer.saving(figure, os.fspath(partial), FILM_DPI):
        for instant in np.arange(time[0], time[-1] + 1e-9, speed / fps):
            k = _row_at(response, float(instant))
            axes.clear()
            u, turn = _places(response, k)
            draw_blocks(axes, response.structure, scale * u, scale * turn, _limits(response.structure))
            axes.set_title(f"{time[k]:.2f} s, deformation x {scale:g}", fontsize=10)
            writer.grab_frame()


def draw_blocks(
    axes: Any,
    structure: Structure,
    u: FloatArray,
    turn: FloatArray,
    limits: tuple[FloatArray, FloatArray] | None = None,
) -> None:
    """Blocks displaced by u, m (n, 3), and turned, rad (n, 3), into axes in space; limits: of the axes, m."""
    points = []
    for block, moved, rotation in zip(structure.blocks, u, turn, strict=True):
        faces = [_moved(face, block, moved, rotation) for face in _surfaces(block)]
        points += faces
        edge = STONE if len(block.surface) else EDGE  # triangles of a scan are too many to be outlined
        axes.add_collection3d(Poly3DCollection(faces, facecolors=STONE, edgecolors=edge, linewidth=0.3, shade=True))
    corners = np.concatenate(points)
    low, high = (corners.min(axis=0), corners.max(axis=0)) if limits is None else limits
    low = low.copy()
    low[2] = min(low[2], 0.0)
    middle, half = 0.5 * (low + high), 0.5 * float(np.max(high - low))
    span = np.maximum(high - low, 0.25 * 2.0 * half)
    for k, name in enumerate("xyz"):
        begin = middle[k] - 0.5 * span[k] if k < 2 else low[2]
        getattr(axes, f"set_{name}lim")(begin, begin + span[k])
        getattr(axes, f"set_{name}label")(f"{name} (m)")
        few = max(1, round(TICKS * span[k] / float(np.max(span))))
        getattr(axes, f"{name}axis").set_major_locator(MaxNLocator(few))
    axes.set_box_aspect(span)
    axes.view_init(elev=18, azim=-62)


def plot_plan(
    response: SpatialResponse, path: str | os.PathLike[str] | None, blocks: Sequence[str | int] | None = None
) -> Figure:
    """Orbits of the centroids of blocks in plan, mm; of the highest one unless some are named."""
    if blocks is None:
        blocks = [int(np.argmax([block.centroid[2] for block in response.structure.blocks]))]
    figure = Figure(figsize=(5.2, 5.0), layout="constrained")
    axes = figure.add_subplot()
    for block in blocks:
        i = response.structure.number(block)
        axes.plot(
            1e3 * response.ux[:, i], 1e3 * response.uy[:, i], linewidth=0.9, label=plain(response.structure.names[i])
        )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("$u_x$ (mm)")
    axes.set_ylabel("$u_y$ (mm)")
    axes.grid(alpha=0.3)
    axes.legend()
    return save(figure, path, DPI)


def plot_response(response: SpatialResponse, path: str | os.PathLike[str] | None) -> Figure:
    """Displacements of the block that moves most, the largest rotation, and the least contact, over time."""
    figure = Figure(figsize=(7.5, 7.0), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    i = int(np.argmax(response.peaks["u"]))
    for name in ("ux", "uy", "uz"):
        top.plot(response.time, 1e3 * getattr(response, name)[:, i], linewidth=0.9, label=f"$u_{name[1]}$")
    top.set_ylabel(f"{plain(response.structure.names[i])} (mm)")
    top.legend(ncols=3)
    middle.plot(response.time, 1e3 * np.max(np.linalg.norm(response.rotation, axis=2), axis=1), linewidth=0.9)
    middle.set_ylabel("largest rotation (mrad)")
    bottom.plot(response.time, np.min(response.contact, axis=1), linewidth=0.9)
    bottom.set_ylabel("least contact")
    bottom.set_xlabel("time (s)")
    for axes in (top, middle, bottom):
        axes.grid(alpha=0.3)
    return save(figure, path, DPI)


def _row_at(response: SpatialResponse, at: float | None) -> int:
    if at is not None:
        return int(np.argmin(np.abs(response.time - at)))
    return int(np.argmax(np.max(np.hypot(response.ux, response.uy), axis=1)))


def _all_corners(structure: Structure) -> FloatArray:
    return np.concatenate([block.corners for block in structure.blocks])


def _limits(structure: Structure) -> tuple[FloatArray, FloatArray]:
    """Corners of a box around the structure, with room for its motion, m."""
    corners = _all_corners(structure)
    low, high = corners.min(axis=0), corners.max(axis=0)
    room = ROOM * float(np.max(high - low))
    return low - room * np.array([1.0, 1.0, 0.0]), high + room


def _places(response: SpatialResponse, k: int) -> tuple[FloatArray, FloatArray]:
    """Displacements and rotations of all blocks at row k, (n, 3) each."""
    u = np.stack([response.ux[k], response.uy[k], response.uz[k]], axis=-1)
    turn: FloatArray = response.rotation[k]
    return u, turn


def _scale_of(response: SpatialResponse, k: int) -> float:
    """A scale by which the deformation at row k is seen; 1 where it is large."""
    largest = max(float(np.max(np.abs(_places(response, k)[0]))), 1e-12)
    return min(max(1.0, nice(VISIBLE * extent_of(response.structure) / largest)), 1e4)


def _surfaces(block: Solid) -> list[FloatArray]:
    """Polygons of the surface of a block as built, (corners, 3) m each; a drum's side in strips."""
    if len(block.surface):
        return list(block.surface)
    found = [face.points(SIDES) for face in block.faces]
    round_faces = [face for face in block.faces if face.radius]
    if len(round_faces) == 2:
        low, high = (face.points(SIDES) for face in round_faces)
        high = np.roll(high[::-1], 1, axis=0)  # seen from the other side
        found += [np.array([low[k - 1], low[k], high[k], high[k - 1]]) for k in range(SIDES)]
    elif len(block.faces) == 2:  # a box that tapers
        low, high = (face.points() for face in block.faces)
        high = high[[int(np.argmin(np.linalg.norm(high[:, :2] - corner[:2], axis=1))) for corner in low]]
        found += [np.array([low[k - 1], low[k], high[k], high[k - 1]]) for k in range(len(low))]
    return found


def _moved(points: FloatArray, block: Solid, u: FloatArray, turn: FloatArray) -> FloatArray:
    arms = points - block.centroid
    found: FloatArray = points + u + turned(np.broadcast_to(turn, arms.shape), arms)
    return found


def extent_of(structure: Structure) -> float:
    """The largest extent of a structure along an axis, m."""
    return max(float(np.max(np.ptp(_all_corners(structure), axis=0))), 1e-9)
