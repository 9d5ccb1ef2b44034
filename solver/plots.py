"""Pictures of a response over time.

The one module of the solver that imports matplotlib, without pyplot: it needs no display and has no state.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, Protocol

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .column import Column
from .errors import InputError
from .files import whole_file
from .packing import FloatArray

Where = Literal["outside lower center", "outside upper center"]

DPI = 150
CONTACT_COLUMNS = 800  # no more than pixels across a panel
# Okabe and Ito's colours that stand out on white; told apart by the colour-blind too
FEW_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")

# history -> title of its panel, axis label, factor from SI; row by row, the motion on the left, resultants on the right
_PANELS = {
    "ux": ("(a) displacement of the top face", "$u_x$ (mm)", 1e3),
    "N": ("(d) normal force in the joint", "$N$ (kN)", 1e-3),
    "theta": ("(b) rotation", r"$\theta$ (mrad)", 1e3),
    "M": ("(e) moment in the joint", "$M$ (kN m)", 1e-3),
    "contact": ("(c) width in contact: white all, dark none", "joint", 1.0),
    "S": ("(f) shear in the joint", "$S$ (kN)", 1e-3),
}
_LABEL_IN_METRES = "$u_x$ (m)"


class Drawable(Protocol):
    """What `plot_response` needs of a Response beside its histories; its module stands above this one."""

    @property
    def column(self) -> Column: ...
    @property
    def time(self) -> FloatArray: ...
    @property
    def overturn_time(self) -> float: ...


def plot_response(response: Drawable, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw a Response; saved to `path` if given. Raises InputError, OSError as `plot_histories` does."""
    histories = {name: getattr(response, name) for name in _PANELS}
    return plot_histories(response.time, histories, response.column.name, response.overturn_time, path)


def plot_histories(
    time: FloatArray,
    histories: Mapping[str, FloatArray],
    title: str = "",
    overturn_time: float = math.nan,
    path: str | os.PathLike[str] | None = None,
) -> Figure:
    """Draw ux, theta, N, M, S and contact of every block, and of the joint under it, over one time axis.

    time: (nt,) s, equally spaced. histories: those six names -> (nt, n) in SI units, block 1 (the top) first, as in
    `Response`. overturn_time: s, NaN while the column stands. path: file to save to, in the format of its suffix.

    Raises InputError on less than two instants or if matplotlib knows no format of that suffix, OSError if the file
    cannot be written.
    """
    if len(time) < 2:
        raise InputError(f"time: {len(time)} sample, must be at least 2 to draw a history")
    figure = Figure(figsize=(10.0, 7.0), layout="constrained")
    grid = figure.subplots(3, 2, sharex=True)
    colours = block_colours(histories["ux"].shape[1])
    for axes, (name, (heading, label, factor)) in zip(grid.flat, _PANELS.items(), strict=True):
        values = histories[name]
        if name == "ux" and np.max(np.abs(values)) >= 1.0:
            label, factor = _LABEL_IN_METRES, 1.0
        if name == "contact":
            _draw_contact(axes, time, values)
        else:
            _draw_histories(axes, time, factor * values, colours)
        axes.set_title(heading, loc="left", fontsize=10)
        axes.set_ylabel(label)
        axes.set_xlim(time[0], time[-1])
        axes.spines[["top", "right"]].set_visible(False)
        if math.isfinite(overturn_time):
            axes.axvline(overturn_time, color="black", linestyle="--", linewidth=1.0)
    for axes in grid[-1]:
        axes.set_xlabel("time (s)")
    figure.align_ylabels()
    show_blocks(figure, grid.ravel().tolist(), colours)
    if math.isfinite(overturn_time):
        title = f"{title}: overturned at {overturn_time:.2f} s".removeprefix(": ")
    figure.suptitle(title)
    if path is not None:
        save(figure, path)
    return figure


def block_colours(n: int) -> list[str]:
    """One colour for each of n blocks from the top down, told apart by the colour-blind too."""
    if n <= len(FEW_COLOURS):
        return list(FEW_COLOURS[:n])
    # the last tenth of the map is too pale for thin lines on white
    return [to_hex(colour) for colour in colormaps["viridis"](np.linspace(0.0, 0.9, n))]


def show_blocks(
    figure: Figure, axes: Sequence[Axes], colours: Sequence[str], where: Where = "outside lower center"
) -> None:
    """Say which block has which of the `block_colours`: a legend of few `where` told, a colour bar of many aside."""
    n = len(colours)
    names = [str(i) for i in range(1, n + 1)]
    names[-1] += " (bottom)"
    names[0] = "block 1 (top)" if n > 1 else "block 1"
    if n <= len(FEW_COLOURS):
        handles = [Line2D([], [], color=colour, linewidth=2.0) for colour in colours]
        figure.legend(handles, names, loc=where, ncols=n, frameon=False)
        return
    mappable = ScalarMappable(Normalize(0.5, n + 0.5), ListedColormap(list(colours)))
    bar = figure.colorbar(mappable, ax=list(axes), aspect=60, pad=0.01)
    bar.set_ticks([1, n], labels=[names[0], names[-1]])
    bar.ax.invert_yaxis()


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure in the format of the file's suffix. Raises InputError if there is none such, OSError."""
    known = sorted(figure.canvas.get_supported_filetypes())
    if Path(path).suffix.lower().removeprefix(".") not in known:
        raise InputError(f"{path}: must end in one of .{', .'.join(known)}")
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=DPI)


def _draw_histories(axes: Axes, time: FloatArray, values: FloatArray, colours: Sequence[str]) -> None:
    """Draw one line per column of values, those with the largest range first so that they hide no other."""
    n = values.shape[1]
    width = 0.7 if n <= len(FEW_COLOURS) else 0.4
    for i in np.argsort(-np.ptp(values, axis=0), kind="stable"):
        axes.plot(time, values[:, i], color=colours[i], linewidth=width)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)


def _draw_contact(axes: Axes, time: FloatArray, contact: FloatArray) -> None:
    """Draw a strip per joint: joints open and close so often that lines would cover one another."""
    samples, n = contact.shape
    each = -(-samples // CONTACT_COLUMNS)  # samples whose mean is one column of the picture
    columns = samples // each
    means = contact[: columns * each].reshape(columns, each, n).mean(axis=1)
    extent = (time[0], time[columns * each - 1], n + 0.5, 0.5)
    shades = LinearSegmentedColormap.from_list("contact", ["0.2", "1.0"])
    axes.imshow(means.T, cmap=shades, vmin=0.0, vmax=1.0, extent=extent, aspect="auto", interpolation="nearest")
    if n <= len(FEW_COLOURS):
        axes.set_yticks(range(1, n + 1))
        axes.hlines(np.arange(1, n) + 0.5, time[0], time[-1], color="white", linewidth=2.0)
    else:
        axes.set_yticks([1, n])
