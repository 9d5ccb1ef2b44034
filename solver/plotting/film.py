"""Films: the column in motion beside its base acceleration and displacements (imported lazily, for matplotlib)."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image

from ..common.errors import POSITIVE, InputError, check_number
from ..common.files import whole_file
from ..models.column.packing import FloatArray
from ..models.column.response import Response
from .drawings import corners_of, draw_column, scale_of
from .figures import Figure
from .lines import thinned
from .plots import draw_ground
from .style import FEW_COLOURS, GRID, INK, RED, STONE, VERDICT_COLOURS, header, tidy
from .words import setting_of, verdict_of

FILMS = (".gif", ".mp4")
FRAMES_PER_SECOND = 20
MOST_FRAMES = 5000
FILM_DPI = 72
BLENDS = (1.0, 0.6, 0.25)  # of a colour with white, in a GIF: at the edges of lines
PALE = 240  # of 255: a paler blend would replace white in the palette
AFTER_FALL = 1.0  # s, filmed after a fall

Progress = Callable[[int, int], object]
Pixels = NDArray[np.uint8]  # (height, width, 4)


def film(
    response: Response,
    path: str | os.PathLike[str],
    scale: float | None = None,
    fps: int = FRAMES_PER_SECOND,
    speed: float = 1.0,
    callback: Progress | None = None,
) -> None:
    """Write a film of the column in motion beside its base acceleration and ux.

    The film ends 1 s after a fall.

    Parameters
    ----------
    response : Response
    path : path-like
        File to write: .gif, or .mp4 where ffmpeg is installed.
    scale : float, optional
        Factor on the deformation, as in `plot_model`.
    fps : int
        Frames per second; a GIF shows each frame for a whole number of hundredths of a second.
    speed : float
        Seconds of motion in a second of film.
    callback : callable, optional
        Called after each frame with the number of frames made and the number of all.

    Raises
    ------
    InputError
        If an argument is out of range, the film has more than `MOST_FRAMES` frames, or its format cannot be written.
    OSError
        If the file cannot be written.
    """
    shoot(response, path, lambda end: _Scene(response, scale_of(response, scale), end), fps, speed, callback)


def shoot(
    response: Any,
    path: str | os.PathLike[str],
    scene_of: Callable[[float], Scene],
    fps: int,
    speed: float,
    callback: Progress | None,
) -> None:
    """Write the frames of a scene to a GIF or an MP4.

    Parameters
    ----------
    response : Response or SpatialResponse
    path : path-like
        File to write.
    scene_of : callable
        Makes the scene, from the time at which the film ends, s.
    fps, speed, callback
        As in `film`.

    Raises
    ------
    InputError, OSError
        As in `film`.
    """
    check_film(path)
    fps = round(check_number("fps", fps, (1.0, 100.0), "a whole number of pictures a second, from 1 to 100"))
    speed = check_number("speed", speed, POSITIVE, "seconds of motion in a second of film, positive")
    time = response.time
    # instants of the frames, up to shortly after a fall
    end = min(float(time[-1]), np.nan_to_num(response.overturn_time + AFTER_FALL, nan=np.inf))
    instants = np.arange(time[0], end + 1e-9, speed / fps)
    if len(instants) > MOST_FRAMES:
        raise InputError(
            f"speed = {speed:g}: makes {len(instants)} pictures, must be larger, for at most {MOST_FRAMES}"
        )
    scene = scene_of(end)
    rows = np.minimum(np.searchsorted(time, instants - 1e-9), len(time) - 1)
    frames = _pictures(scene, rows, callback)
    with whole_file(path) as partial:
        if Path(path).suffix.lower() == ".mp4":
            writer = _PixelWriter(fps=fps)
            with writer.saving(scene.figure, os.fspath(partial), FILM_DPI):
                for picture in frames:
                    writer.write(picture)
        else:
            _write_gif(scene, frames, fps, partial)


def check_film(path: str | os.PathLike[str]) -> None:
    """Raise InputError if a film of that name cannot be written here."""
    suffix = Path(path).suffix.lower()
    if suffix not in FILMS:
        raise InputError(f"{path}: must end in {' or '.join(FILMS)}")
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise InputError(f"{path}: needs ffmpeg, which is not installed; .gif does not")


class Scene(Protocol):
    """A figure in which only some artists move.

    Attributes
    ----------
    figure : Figure
    canvas : FigureCanvasAgg
    moving : tuple of Artist
        The artists that `show` moves.
    """

    figure: Figure
    canvas: Any
    moving: tuple[Artist, ...]

    @property
    def colours(self) -> Sequence[str]:
        """The colours that the palette of a GIF must contain; each is blended with white at edges."""

    def show(self, k: int) -> None:
        """Move the artists to row k."""


class _Scene:
    """A figure in which only the blocks, the cursors and the clock change."""

    def __init__(self, response: Response, scale: float, end: float) -> None:
        self.response, self.scale = response, scale
        self.figure = Figure(figsize=(9.0, 5.4), dpi=FILM_DPI)
        self.canvas: Any = FigureCanvasAgg(self.figure)
        grid = self.figure.add_gridspec(
            2, 2, width_ratios=(1.0, 1.7), hspace=0.4, left=0.02, right=0.97, bottom=0.1, top=0.82
        )
        column = self.figure.add_subplot(grid[:, 0])
        ground, moved = self.figure.add_subplot(grid[0, 1]), self.figure.add_subplot(grid[1, 1])
        self.patches = draw_column(column, response, 0, scale)
        draw_ground(ground, response.motion)
        self._draw_displacements(moved)
        for axes in (ground, moved):
            tidy(axes)
            axes.set_xlim(response.time[0], end)
        # title, verdict and the colours that a palette needs
        word, sentence = verdict_of(response)
        colour = VERDICT_COLOURS.get(word, INK)
        header(self.figure, setting_of(response.model, response.motion), sentence, colour)
        self.colours = (INK, GRID, STONE, RED, colour, *FEW_COLOURS[: len(self.patches)])
        factor = "to scale" if scale == 1.0 else rf"deformation $\times$ {scale:g}"
        column.text(0.5, -0.01, factor, transform=column.transAxes, ha="center", va="top", fontsize=11, color=RED)
        # artists that change from frame to frame
        self.clock = column.text(0.98, 1.0, "", transform=column.transAxes, ha="right", va="top", fontsize=12)
        self.cursors = [axes.axvline(response.time[0], color="black", linewidth=0.8) for axes in (ground, moved)]
        self.moving: tuple[Artist, ...] = (*self.patches, *self.cursors, self.clock)
        for artist in self.moving:
            artist.set_animated(True)

    def _draw_displacements(self, axes: Axes) -> None:
        """Plot ux of the blocks that have a colour: of all of few blocks, of the top one of many."""
        response, few = self.response, self.response.model.n <= len(FEW_COLOURS)
        ux: FloatArray = response.ux
        factor, unit = (1.0, "m") if np.max(np.abs(ux)) >= 1.0 else (1e3, "mm")
        for i, patch in enumerate(self.patches):
            if few or i == 0:
                axes.plot(*thinned(response.time, factor * ux[:, i]), color=FEW_COLOURS[i], linewidth=1.0)
                patch.set_facecolor(FEW_COLOURS[i])
            else:
                patch.set_facecolor(STONE)
        axes.set_title("displacement of the top faces" if few else "displacement of the top", loc="left")
        axes.set(xlabel="time (s)", ylabel=f"$u_x$ ({unit})")

    def show(self, k: int) -> None:
        """Move the blocks, cursors and clock to row k."""
        for patch, corners in zip(self.patches, corners_of(self.response, k, self.scale), strict=True):
            patch.set_xy(corners)
        instant = self.response.time[k]
        for cursor in self.cursors:
            cursor.set_xdata([instant, instant])
        self.clock.set_text(f"{instant:.2f} s")


class _PixelWriter(FFMpegWriter):
    """A writer that sends rendered frames to ffmpeg; `grab_frame` would render each one again."""

    def write(self, picture: Pixels) -> None:
        """Send one frame to ffmpeg."""
        self._proc.stdin.write(picture.tobytes())  # type: ignore[attr-defined]


def _pictures(scene: Scene, rows: Any, callback: Progress | None) -> Iterator[Pixels]:
    """Yield the frames, drawing the moving artists over a cached background: some 20 times faster than whole frames."""
    scene.canvas.draw()
    still = scene.canvas.copy_from_bbox(scene.figure.bbox)
    for done, k in enumerate(rows, start=1):
        scene.show(int(k))
        scene.canvas.restore_region(still)
        for artist in scene.moving:
            scene.figure.draw_artist(artist)
        yield np.asarray(scene.canvas.buffer_rgba())
        if callback is not None:
            callback(done, len(rows))


def _write_gif(scene: Scene, frames: Iterator[Pixels], fps: int, path: Path) -> None:
    """Write the frames with one palette, so that a frame stores only the pixels that change."""
    palette = _palette(scene)
    images = [Image.fromarray(frame[..., :3]).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    images[0].save(
        path, format="GIF", save_all=True, append_images=images[1:], duration=round(1e3 / fps), loop=0, optimize=True
    )


def _palette(scene: Scene) -> Image.Image:
    """Return a palette of the colours of a scene and their blends with white.

    A palette that is derived from a frame loses the rare colours.
    """
    used = ("black", *scene.colours)
    blends = {tuple(round(255 * (1.0 - part * (1.0 - c))) for c in to_rgb(name)) for name in used for part in BLENDS}
    whole = {blend for blend in blends if min(blend) < PALE} | {tuple(round(255 * c) for c in to_rgb(GRID))}
    palette = Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *(value for colour in sorted(whole) for value in colour)])
    return palette
