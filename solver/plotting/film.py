"""Films of responses: frames of a scene in which only the blocks, cursors and the clock move, as GIF or MP4."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.text import Text
from numpy.typing import NDArray
from PIL import Image

from ..common.errors import POSITIVE, InputError, check_number, check_whole, whole
from ..common.files import whole_file
from .style import GRID, INK, RED, Figure, tidy
from .words import drawn_larger, setting_of, verdict_of, write_header

FILMS = (".gif", ".mp4")
FRAMES_PER_SECOND = 20
MOST_FRAMES = 5000
FILM_DPI = 72
BLENDS = (1.0, 0.6, 0.25)  # of a colour with white, in a GIF: at the edges of lines
PALE = 240  # of 255: a paler blend would replace white in the palette
AFTER_FALL = 1.0  # s, filmed after a fall

Progress = Callable[[int, int], object]
Pixels = NDArray[np.uint8]  # (height, width, 4)


class AnimatedFigure:
    """A figure in which only the blocks, the cursors and the clock move.

    A subclass is made from the response, the factor on the deformation (None: automatic) and the last instant, s. It
    draws the figure, calls `animate` at the end, and moves the blocks in `place`.
    """

    def __init__(self, response: Any, scale: float, **figure: Any) -> None:
        self.response, self.scale = response, scale
        self.figure = Figure(dpi=FILM_DPI, **figure)
        self.canvas: Any = FigureCanvasAgg(self.figure)
        self.factor = drawn_larger(scale)

    def animate(
        self, blocks: Sequence[Artist], clock: Text, panels: Sequence[Axes], end: float, colours: Sequence[str]
    ) -> None:
        """Write the title, add the cursors, and mark the artists that move.

        Parameters
        ----------
        blocks : sequence of Artist
            The artists that `place` moves.
        clock : Text
        panels : sequence of Axes
            The panels over time, which get a cursor each.
        end : float
            Last instant, s.
        colours : sequence of str
            Further colours that the palette of a GIF must contain.
        """
        for axes in panels:
            tidy(axes)
            axes.set_xlim(self.response.time[0], end)
        title = setting_of(self.response.model, self.response.motion)
        colour = write_header(self.figure, title, verdict_of(self.response))
        self.colours = ("black", INK, GRID, RED, colour, *colours)
        self._clock = clock
        self._cursors = [axes.axvline(self.response.time[0], color="black", linewidth=0.8) for axes in panels]
        self.moving: tuple[Artist, ...] = (*blocks, *self._cursors, clock)
        for artist in self.moving:
            artist.set_animated(True)

    def place(self, k: int) -> None:
        """Move the blocks to row k."""
        raise NotImplementedError

    def show(self, k: int) -> None:
        """Move the blocks, cursors and clock to row k."""
        self.place(k)
        instant = self.response.time[k]
        for cursor in self._cursors:
            cursor.set_xdata([instant, instant])
        self._clock.set_text(f"{instant:.2f} s")


def film(
    scene_of: Callable[[Any, float | None, float], AnimatedFigure],
    response: Any,
    path: str | os.PathLike[str],
    scale: float | None,
    fps: int,
    speed: float,
    callback: Progress | None,
) -> None:
    """Write a film of a response, which ends 1 s after a fall, or with the run.

    The arguments but the first are those of `Result.film`.

    The frames of a GIF are a whole number of hundredths of a second apart, for which each is shown. Raises InputError
    if an argument is out of range, the film has more than `MOST_FRAMES` frames, or its format cannot be written;
    OSError.
    """
    check_film(path)
    fps = check_whole("fps", whole(fps), 1, 100, "a whole number of pictures a second, from 1 to 100")
    speed = check_number("speed", speed, POSITIVE, "seconds of motion in a second of film, positive")
    time = response.time
    # instants of the frames, up to shortly after a fall
    after = max(AFTER_FALL, getattr(response.model, "after_fall", 0.0))
    end = min(float(time[-1]), np.nan_to_num(response.overturn_time + after, nan=np.inf))
    is_gif = Path(path).suffix.lower() == ".gif"
    delay = max(1, round(100.0 / fps))  # hundredths of a second, in a GIF
    instants = np.arange(time[0], end + 1e-9, speed * delay / 100.0 if is_gif else speed / fps)
    if len(instants) > MOST_FRAMES:
        raise InputError(
            f"speed = {speed:g}: makes {len(instants)} pictures, must be larger, for at most {MOST_FRAMES}"
        )
    scene = scene_of(response, scale, end)
    rows = np.minimum(np.searchsorted(time, instants - 1e-9), len(time) - 1)
    frames = _pictures(scene, rows, callback)
    with whole_file(path) as partial:
        if is_gif:
            _write_gif(scene, frames, delay, partial)
        else:
            writer = _PixelWriter(fps=fps)
            with writer.saving(scene.figure, os.fspath(partial), FILM_DPI):
                for picture in frames:
                    writer.write(picture)


def check_film(path: str | os.PathLike[str]) -> None:
    """Raise InputError if a film of that name cannot be written here."""
    suffix = Path(path).suffix.lower()
    if suffix not in FILMS:
        raise InputError(f"{path}: must end in {' or '.join(FILMS)}")
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise InputError(f"{path}: needs ffmpeg, which is not installed; .gif does not")


class _PixelWriter(FFMpegWriter):
    """A writer that sends rendered frames to ffmpeg; `grab_frame` would render each one again."""

    def write(self, picture: Pixels) -> None:
        """Send one frame to ffmpeg."""
        self._proc.stdin.write(picture.tobytes())  # type: ignore[attr-defined]


def _pictures(scene: AnimatedFigure, rows: Any, callback: Progress | None) -> Iterator[Pixels]:
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


def _write_gif(scene: AnimatedFigure, frames: Iterator[Pixels], delay: int, path: Path) -> None:
    """Write the frames, `delay` hundredths of a second each, with one palette: each stores the pixels that change."""
    palette = _palette(scene.colours)
    images = [Image.fromarray(frame[..., :3]).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    images[0].save(
        path, format="GIF", save_all=True, append_images=images[1:], duration=10 * delay, loop=0, optimize=True
    )


def _palette(colours: Sequence[str]) -> Image.Image:
    """Return a palette of colours and their blends with white, as at edges; that of a frame would lose rare ones."""
    blends = {tuple(round(255 * (1.0 - part * (1.0 - c))) for c in to_rgb(name)) for name in colours for part in BLENDS}
    whole = {blend for blend in blends if min(blend) < PALE} | {tuple(round(255 * c) for c in to_rgb(GRID))}
    palette = Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *(value for colour in sorted(whole) for value in colour)])
    return palette
