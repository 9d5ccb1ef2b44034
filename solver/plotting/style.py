"""The common style of all figures: colours, headings, legends, files. Without pyplot: no display, no state."""

from __future__ import annotations

import io
import math
import os
import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize, to_hex
from matplotlib.figure import Figure as PlainFigure
from matplotlib.lines import Line2D

from ..common.errors import InputError
from ..common.files import whole_file

Where = Literal["outside lower center", "outside upper center", "outside right upper"]

DPI, SHOWN_DPI = 150, 72  # of files, in notebooks
NICE = (1.0, 2.0, 5.0)  # times powers of ten: scales to choose from
STONE, INK, GREY, GRID = "#cdbfa7", "#3b3a38", "#7a7873", "0.9"
# Okabe and Ito's colours that stand out on white; the colour-blind can distinguish them too
FEW_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
BLUE, RED, GREEN = FEW_COLOURS[:3]
TINT = "#f6e3d8"  # background while a column falls
# colours of the line under the title
VERDICT_COLOURS = {"standing": "#00704f", "overturned": "#b04a00", "undecided": GREY}
TITLE, LINE, LETTER = 13.0, 10.5, 0.112  # font sizes of title and line, points; mean width of a letter of the title, in


class Figure(PlainFigure):
    """A matplotlib figure with the PNG representation that IPython asks for: a notebook shows it without pyplot."""

    def _repr_png_(self) -> bytes:
        png = io.BytesIO()
        self.savefig(png, format="png", dpi=SHOWN_DPI)
        return png.getvalue()


def plain(name: str) -> str:
    """Return a name, escaped so that matplotlib shows it unchanged.

    "$" would begin a formula, and a leading "_" hides an entry of a legend.
    """
    return (" " if name.startswith("_") else "") + name.replace("$", r"\$")


def nice(most: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten up to `most`."""
    power = 10.0 ** math.floor(math.log10(most))
    return float(f"{power * max(factor for factor in NICE if factor * power <= most * (1.0 + 1e-9)):.3g}")


def header(figure: Figure, title: str, line: str = "", colour: str = INK) -> None:
    """Put a bold title on the upper left and a coloured line below; a constrained layout reserves the space."""
    wide, tall = figure.get_size_inches()
    whole = re.sub(r"(\d) (?=\w{1,4}\b)", "\\1\u00a0", plain(title))  # a number stays with its unit
    titles = [part.replace("\u00a0", " ") for part in textwrap.wrap(whole, int((wide - 0.2) / LETTER))] or [""]
    lines = textwrap.wrap(line, int((wide - 0.2) / LETTER * TITLE / LINE))
    figure.suptitle(
        "\n".join(titles), x=0.1 / wide, y=1.0 - 0.08 / tall, ha="left", va="top", fontsize=TITLE, weight="bold"
    )
    below = 0.12 + 0.225 * len(titles)
    if lines:
        text = "\n".join(lines)
        figure.text(0.1 / wide, 1.0 - below / tall, text, ha="left", va="top", fontsize=LINE, color=colour)
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.set(rect=(0.0, 0.0, 1.0, 1.0 - (below + 0.185 * len(lines) + 0.08) / tall))  # type: ignore[call-arg]


def tidy(axes: Axes, grid: bool = True) -> None:
    """Put the title on the left, a pale grid behind the lines, and hide the spines above and on the right."""
    axes.set_title(axes.get_title() or axes.get_title(loc="left"), loc="left", fontsize=10)
    axes.set_title("")
    if grid:
        axes.grid(color=GRID, linewidth=0.6)
        axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def note_on_right(axes: Axes, text: str) -> None:
    """Write a note in small letters over the panel, on the right."""
    axes.set_title(text, loc="right", fontsize=8, color=GREY)


def block_colours(n: int) -> list[str]:
    """Return a colour for each of n blocks from the top down, also distinguishable by the colour-blind."""
    if n <= len(FEW_COLOURS):
        return list(FEW_COLOURS[:n])
    # the last tenth of the map is too pale for thin lines on white
    return [to_hex(colour) for colour in colormaps["viridis"](np.linspace(0.0, 0.9, n))]


def name_of(i: int, n: int, of: str = "block") -> str:
    """Return the name of block i (from 0) of n, with its position at the ends."""
    place = "" if n == 1 else {0: " (top)", n - 1: " (bottom)"}.get(i, "")
    return f"{of} {i + 1}{place}"


def show_blocks(figure: Figure, axes: Sequence[Axes], colours: Sequence[str], where: Where) -> None:
    """Show the colour of each block (`block_colours`): a legend at `where` for few, a colour bar for many."""
    n = len(colours)
    if n <= len(FEW_COLOURS):
        show_names(figure, [name_of(i, n) for i in range(n)], colours, where)
        return
    mappable = ScalarMappable(Normalize(0.5, n + 0.5), ListedColormap(list(colours)))
    bar = figure.colorbar(mappable, ax=list(axes), aspect=60, pad=0.01)
    bar.set_ticks([1, n], labels=[name_of(i, n) for i in (0, n - 1)])
    bar.ax.invert_yaxis()


def show_names(
    figure: Figure, names: Sequence[str], colours: Sequence[str], where: Where = "outside lower center", mark: str = ""
) -> None:
    """Add a legend of colours to the figure, and the mark of a peak if it has a name."""
    handles = [Line2D([], [], color=colour, linewidth=2.0) for colour in colours]
    if mark:
        handles.append(Line2D([], [], color=GREY, marker="<", linestyle=""))
    across = 1 if "right" in where else min(len(handles), 3)
    figure.legend(handles, [*names, *filter(None, [mark])], loc=where, ncols=across, frameon=False)


def save(figure: Figure, path: str | os.PathLike[str] | None, dpi: int = DPI) -> Figure:
    """Save the figure in the format of the file's suffix if `path` is given, and return it.

    Parameters
    ----------
    figure : Figure
    path : path-like or None
        File to write.
    dpi : int
        Resolution, dots per inch.

    Raises
    ------
    InputError
        If matplotlib knows no format of that suffix.
    OSError
        If the file cannot be written.
    """
    if path is None:
        return figure
    known = sorted(figure.canvas.get_supported_filetypes())
    if Path(path).suffix.lower().removeprefix(".") not in known:
        raise InputError(f"{path}: must end in one of .{', .'.join(known)}")
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=dpi)
    return figure
