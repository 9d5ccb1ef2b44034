"""Drawings of the deformed column: a picture of one instant, a film of all. Imported late, for matplotlib."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from ..column.packing import FloatArray
from ..common.errors import POSITIVE, InputError, check_number
from ..common.files import whole_file
from .drawable import Shaken, Shapes
from .figures import Figure
from .plots import block_colours, draw_ground, save

STONE, INK = "#cdbfa7", "#3b3a38"
SHOWN = 0.15  # of the column's height: displacement of its top in a picture whose scale is not given
NICE = (1.0, 2.0, 5.0)  # times powers of ten: scales to choose from
FILMS = (".gif", ".mp4")
FRAMES_PER_SECOND = 20
MOST_FRAMES = 5000
FILM_DPI = 80


def plot_column(
    response: Shaken,
    path: str | os.PathLike[str] | None = None,
    at: float | None = None,
    scale: float | None = None,
) -> Figure:
    """Draw the deformed column, relative to its base; saved to `path` if given.

    at: time in s, of which the nearest row is drawn; None: the row of the largest |ux| of any block. scale: factor on
    rotations and openings; None: 1, 2 or 5 times a power of ten, so that the motion is seen, and 1 where it is large.
    The picture states it. Raises InputError, OSError.
    """
    k = _peak(response) if at is None else _row(response, at)
    scale = _scale(response, scale)
    figure = Figure(figsize=(4.2, 7.0), layout="constrained")
    axes = figure.add_subplot()
    draw_column(axes, response, k, scale)
    top = int(np.argmax(np.abs(response.ux[k])))
    axes.set_title(
        f"{response.column.name} at {response.time[k]:.3f} s\n"
        f"top of block {top + 1} at {1e3 * response.ux[k, top]:.3g} mm; {_scale_text(scale)}",
        fontsize=9,
    )
    return save(figure, path)


def draw_column(axes: Axes, response: Shapes, k: int, scale: float) -> list[Polygon]:
    """Draw row k of a response, rotations and openings times `scale`, on axes of equal units; returns the blocks."""
    patches = [
        Polygon(corners, facecolor=STONE, edgecolor=INK, linewidth=1.0) for corners in corners_of(response, k, scale)
    ]
    for patch in patches:
        axes.add_patch(patch)
    blocks = response.column.blocks
    height, width = (
        sum(block.height for block in blocks),
        max(max(block.width, block.top_width or 0.0) for block in blocks),
    )
    reach = 0.6 * width + max(SHOWN * height, scale * float(np.max(np.abs(response.ux))))
    axes.axhline(0.0, color=INK, linewidth=3.0)
    axes.plot([0.0, 0.0], [0.0, 1.03 * height], color=INK, linewidth=0.7, linestyle=":")
    axes.set(
        xlim=(-min(reach, 1.5 * height), min(reach, 1.5 * height)), ylim=(-0.03 * height, 1.1 * height), aspect="equal"
    )
    axes.set_axis_off()
    return patches


def corners_of(response: Shapes, k: int, scale: float) -> list[FloatArray]:
    """Corners (4, 2) of each block at row k, m, the top block first; at a scale of 1 their true places.

    From the base up: the relative displacement of the faces of a joint is taken in the frame of the body below, and
    scaled there.
    """
    found: list[FloatArray] = []
    # middle of the face below: as built, true, drawn; rotations of the body below
    built, foot, drawn = np.zeros(2), np.zeros(2), np.zeros(2)
    tilt_below, turned, turn = 0.0, 0.0, 0.0
    for i in range(response.column.n - 1, -1, -1):
        block, theta = response.column.blocks[i], float(response.theta[k, i])
        rise, lean = block.resolved_centroid, block.joint.inclination or 0.0
        tilt = lean + (block.tilt or 0.0)
        offset = (block.joint.offset or 0.0) * _frame(lean)[1]
        built = built + offset + block.height * _frame(tilt)[0]
        up = _frame(tilt + theta)[0]
        top_x = built[0] + response.ux[k, i]
        height = built[1] - (block.height - rise) * math.cos(tilt) + response.uz[k, i]
        centroid = np.array([top_x - (block.height - rise) * up[0], height])
        apart = np.array(_frame(turned)) @ (centroid - rise * up - foot)
        apart_built = np.array(_frame(tilt_below)) @ offset
        drawn = drawn + (apart_built + scale * (apart - apart_built)) @ np.array(_frame(turn))
        foot = centroid + (block.height - rise) * up
        tilt_below, turned, turn = tilt, tilt + theta, tilt + scale * theta
        lean_above = (response.column.blocks[i - 1].joint.inclination or 0.0) if i > 0 else tilt
        half = _across(0.5 * block.width, turn, lean - tilt)
        top = _across(0.5 * (block.top_width or block.width), turn, lean_above - tilt)
        tall = block.height * _frame(turn)[0]
        found.append(np.array([drawn - half, drawn + half, drawn + top + tall, drawn - top + tall]))
        drawn = drawn + tall
    return found[::-1]


def film(
    response: Shaken,
    path: str | os.PathLike[str],
    scale: float | None = None,
    fps: int = FRAMES_PER_SECOND,
    speed: float = 1.0,
) -> None:
    """Write the column in motion beside its base acceleration and ux: a GIF, or an MP4 where ffmpeg is.

    scale: as in `plot_column`. fps: pictures a second. speed: seconds of motion in a second of film.
    Raises InputError, OSError.
    """
    check_film(path)
    fps = round(check_number("fps", fps, (1.0, 100.0), "a whole number of pictures a second, from 1 to 100"))
    speed = check_number("speed", speed, POSITIVE, "seconds of motion in a second of film, positive")
    time = response.time
    instants = np.arange(time[0], time[-1] + 1e-9, speed / fps)
    if len(instants) > MOST_FRAMES:
        raise InputError(
            f"speed = {speed:g}: makes {len(instants)} pictures, must be larger, for at most {MOST_FRAMES}"
        )
    scale = _scale(response, scale)
    figure = Figure(figsize=(9.0, 5.4))
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.7), hspace=0.4, left=0.02, right=0.97, bottom=0.1, top=0.9)
    column = figure.add_subplot(grid[:, 0])
    ground, moved = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    patches = draw_column(column, response, 0, scale)
    draw_ground(ground, response.motion)
    largest = np.max(np.abs(response.ux))
    unit, factor = ("m", 1.0) if largest >= 1.0 else ("mm", 1e3)
    for i, colour in enumerate(block_colours(response.column.n)):
        moved.plot(time, factor * response.ux[:, i], color=colour, linewidth=0.8)
        patches[i].set_facecolor(colour)
        patches[i].set_alpha(0.75)
    moved.set_title("displacement of the top faces", loc="left", fontsize=10)
    moved.set(xlabel="time (s)", ylabel=f"$u_x$ ({unit})")
    moved.grid(color="0.9", linewidth=0.6)
    cursors = []
    for axes in (ground, moved):
        axes.set_xlim(time[0], time[-1])
        axes.spines[["top", "right"]].set_visible(False)
        cursors.append(axes.axvline(time[0], color="black", linewidth=0.8))
    writer: AbstractMovieWriter = (
        FFMpegWriter(fps=fps) if Path(path).suffix.lower() == ".mp4" else PillowWriter(fps=fps)
    )
    with whole_file(path) as partial, writer.saving(figure, os.fspath(partial), FILM_DPI):
        for instant in instants:
            k = _row(response, instant)
            for patch, corners in zip(patches, corners_of(response, k, scale), strict=True):
                patch.set_xy(corners)
            for cursor in cursors:
                cursor.set_xdata([time[k], time[k]])
            column.set_title(f"{response.column.name}, {time[k]:.2f} s\n{_scale_text(scale)}", fontsize=9)
            writer.grab_frame()


def check_film(path: str | os.PathLike[str]) -> None:
    """Raise InputError if a film of that name cannot be written here."""
    suffix = Path(path).suffix.lower()
    if suffix not in FILMS:
        raise InputError(f"{path}: must end in {' or '.join(FILMS)}")
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise InputError(f"{path}: needs ffmpeg, which is not installed; .gif does not")


def _frame(theta: float) -> tuple[FloatArray, FloatArray]:
    """Unit vectors of a body turned clockwise by theta: up, and along its faces to the right."""
    sine, cosine = math.sin(theta), math.cos(theta)
    return np.array([sine, cosine]), np.array([cosine, -sine])


def _across(half: float, turn: float, oblique: float) -> FloatArray:
    """From the middle to the end of a face of this half width, oblique to a body turned by `turn`."""
    return half / math.cos(oblique) * _frame(turn + oblique)[1]


def _peak(response: Shaken) -> int:
    return int(np.argmax(np.max(np.abs(response.ux), axis=1)))


def _row(response: Shaken, at: float) -> int:
    time = response.time
    at = check_number(
        "at", at, (float(time[0]), float(time[-1])), f"a time of the response, {time[0]:g} to {time[-1]:g} s"
    )
    return int(np.argmin(np.abs(time - at)))


def _scale(response: Shaken, scale: float | None) -> float:
    if scale is not None:
        return check_number("scale", scale, POSITIVE, "a positive factor on the deformation")
    largest = float(np.max(np.abs(response.ux)))
    wanted = SHOWN * sum(block.height for block in response.column.blocks) / max(largest, 1e-300)
    if wanted <= 1.0 or largest < 1e-12:
        return 1.0
    power = 10.0 ** math.floor(math.log10(wanted))
    return power * max(nice for nice in NICE if nice * power <= wanted)


def _scale_text(scale: float) -> str:
    return "deformation to scale" if scale == 1.0 else f"deformation times {scale:g}"
