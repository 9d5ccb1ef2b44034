"""Pictures of a response over time.

This module, `drawings` and `record_plots` are the ones of the solver that import matplotlib; without pyplot they need
no display and have no state.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize, to_hex
from matplotlib.lines import Line2D

from ..column.column import Column
from ..column.friction import friction_history
from ..column.packing import FloatArray, carried_weights
from ..common.errors import InputError
from ..common.files import whole_file
from ..ground.motion import STANDARD_GRAVITY, Motion
from ..kernels.layout.spaces import COUNTS_FROM
from .drawable import Shaken
from .figures import Figure

Where = Literal["outside lower center", "outside upper center"]

DPI = 150
COLUMNS = 600  # pixels across a panel, about: finer detail cannot be distinguished
GROUND_SAMPLES = 20_000  # of a harmonic, which has none of its own
# Okabe and Ito's colours that stand out on white; the colour-blind can distinguish them too
FEW_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
HISTORIES = ("ux", "theta", "N", "M", "S", "T", "contact", "sigma_max")


@dataclass(frozen=True)
class _Panel:
    name: str  # history, or "T/N"
    heading: str
    label: str
    factor: float = 1.0  # from SI
    largest_only: bool = False  # where samples are dense: the minimum carries no information


# row by row: the motion on the left, resultants on the right
_PANELS = (
    _Panel("ux", "(b) displacement of the top face", "$u_x$ (mm)", 1e3),
    _Panel("N", "(f) normal force in the joint", "$N$ (kN)", 1e-3),
    _Panel("theta", "(c) rotation", r"$\theta$ (mrad)", 1e3),
    _Panel("M", "(g) moment in the joint", "$M$ (kN m)", 1e-3),
    _Panel("contact", "(d) least width in contact: white all, dark none", "joint"),
    _Panel("S", "(h) horizontal shear in the joint", "$S$ (kN)", 1e-3),
    _Panel("sigma_max", "(e) largest pressure in the joint", r"$\sigma_{max}$ (MPa)", 1e-6, True),
    _Panel("T/N", "(i) friction demand", "$|T|/N$"),
)
_LABEL_IN_METRES = "$u_x$ (m)"


def plot_response(response: Shaken, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw a Response; saved to `path` if given. Raises InputError, OSError as `plot_histories` does.

    If the response has an ensemble, its 16 % to 84 % of ux are a band, its median a dashed line.
    """
    ensemble = getattr(response, "ensemble", None)
    return plot_histories(
        response.time,
        {name: getattr(response, name) for name in HISTORIES},
        response.column,
        response.motion,
        overturn_time=response.overturn_time,
        path=path,
        ensemble=None if ensemble is None else ensemble.ux,
    )


def plot_histories(
    time: FloatArray,
    histories: Mapping[str, FloatArray],
    column: Column,
    motion: Motion | None = None,
    title: str | None = None,
    overturn_time: float = math.nan,
    path: str | os.PathLike[str] | None = None,
    ensemble: FloatArray | None = None,
) -> Figure:
    """Draw the ground motion, and below it the histories of every block and of the joint under it.

    time: (nt,) s, equally spaced. histories: HISTORIES -> (nt, n) in SI units, block 1 (the top) first, as in
    `Response`. motion: of the base, on the same clock; None: not drawn. title: None is the column's name.
    overturn_time: s, NaN while the column stands. path: file to save to, in the format of its suffix.
    ensemble: (3, nt, n) m, the 16 %, 50 % and 84 % points of ux among many runs; NaN where there are none.

    More samples than pixels are drawn as the band from their least to their largest, bordered by lines.

    Raises InputError on less than two instants or if matplotlib knows no format of that suffix, OSError if the file
    cannot be written.
    """
    if len(time) < 2:
        raise InputError(f"time: {len(time)} sample, must be at least 2 to draw a history")
    figure = Figure(figsize=(10.0, 10.0), layout="constrained")
    rows = len(_PANELS) // 2
    grid = figure.add_gridspec(rows + 1, 2, height_ratios=(0.7, *(1.0,) * rows))
    ground = figure.add_subplot(grid[0, :])
    panels = [figure.add_subplot(grid[1 + k // 2, k % 2], sharex=ground) for k in range(len(_PANELS))]
    colours = block_colours(column.n)
    draw_ground(ground, motion)
    ground.set_title(f"(a) {ground.get_title(loc='left')}", loc="left", fontsize=10)
    for axes, panel in zip(panels, _PANELS, strict=True):
        if panel.name == "contact":
            _draw_contact(axes, time, histories["contact"])
        elif panel.name == "T/N":
            _draw_friction(axes, time, histories, column, colours)
        else:
            _draw_panel(axes, time, panel, histories[panel.name], colours, ensemble)
        axes.set_title(panel.heading, loc="left", fontsize=10)
    for axes in (ground, *panels):
        axes.set_xlim(time[0], time[-1])
        axes.spines[["top", "right"]].set_visible(False)
        if math.isfinite(overturn_time):
            axes.axvline(overturn_time, color="black", linestyle="--", linewidth=1.0)
        if axes in panels[:-2]:
            axes.tick_params(labelbottom=False)
    for axes in panels[-2:]:
        axes.set_xlabel("time (s)")
    figure.align_ylabels()
    show_blocks(figure, panels, colours, of="block and joint")
    title = column.name if title is None else title
    if math.isfinite(overturn_time):
        title = f"{title}: overturned at {overturn_time:.2f} s".removeprefix(": ")
    figure.suptitle(title)
    return save(figure, path)


def draw_ground(axes: Axes, motion: Motion | None) -> None:
    """Draw the acceleration of the base in g; without a motion, say that it is not known."""
    axes.set_title("acceleration of the base", loc="left", fontsize=10)
    if motion is None:
        axes.text(0.5, 0.5, "not kept with these histories", transform=axes.transAxes, ha="center", va="center")
        axes.set_yticks([])
        return
    time, ax, az = _ground_lines(motion)
    for name, values, style in (("horizontal", ax, "-"), ("vertical", az, ":")):
        if np.any(values) or name == "horizontal":
            axes.plot(time, values / STANDARD_GRAVITY, color="0.2", linestyle=style, linewidth=0.7, label=name)
    if np.any(az):
        axes.legend(loc="upper right", fontsize=8, frameon=False, ncols=2)
    axes.set_ylabel("$a$ (g)")
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)


def _ground_lines(motion: Motion) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Corners of the lines that the acceleration consists of: time, ax, az."""
    if motion.amplitude:
        time = np.union1d(motion.time, np.linspace(motion.start, motion.end, GROUND_SAMPLES))
        return time, *motion.acceleration(time)
    if motion.hold:
        time = np.repeat(np.append(motion.time, motion.end), 2)[1:-1]
        return time, np.repeat(motion.ax, 2), np.repeat(motion.az, 2)
    return motion.time, motion.ax, motion.az


def block_colours(n: int) -> list[str]:
    """One colour for each of n blocks from the top down; the colour-blind can distinguish them too."""
    if n <= len(FEW_COLOURS):
        return list(FEW_COLOURS[:n])
    # the last tenth of the map is too pale for thin lines on white
    return [to_hex(colour) for colour in colormaps["viridis"](np.linspace(0.0, 0.9, n))]


def show_blocks(
    figure: Figure,
    axes: Sequence[Axes],
    colours: Sequence[str],
    where: Where = "outside lower center",
    of: str = "block",
) -> None:
    """Show the colour of each block (`block_colours`): a legend at `where` for few, a colour bar aside for many."""
    n = len(colours)
    names = [f"{of} {i}" for i in range(1, n + 1)]
    if n > 1:
        names[-1] += " (bottom)"
        names[0] += " (top)"
    if n <= len(FEW_COLOURS):
        handles = [Line2D([], [], color=colour, linewidth=2.0) for colour in colours]
        figure.legend(handles, names, loc=where, ncols=min(n, 3), frameon=False)
        return
    mappable = ScalarMappable(Normalize(0.5, n + 0.5), ListedColormap(list(colours)))
    bar = figure.colorbar(mappable, ax=list(axes), aspect=60, pad=0.01)
    bar.set_ticks([1, n], labels=[names[0], names[-1]])
    bar.ax.invert_yaxis()


def tidy(axes: Axes, grid: bool = True) -> None:
    """Put the title on the left, a pale grid behind what is drawn, and no frame above and on the right."""
    axes.set_title(axes.get_title() or axes.get_title(loc="left"), loc="left", fontsize=10)
    axes.set_title("")
    if grid:
        axes.grid(color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def save(figure: Figure, path: str | os.PathLike[str] | None) -> Figure:
    """The figure, written in the format of the file's suffix if there is a path.

    Raises InputError for an unknown suffix, OSError.
    """
    if path is None:
        return figure
    known = sorted(figure.canvas.get_supported_filetypes())
    if Path(path).suffix.lower().removeprefix(".") not in known:
        raise InputError(f"{path}: must end in one of .{', .'.join(known)}")
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=DPI)
    return figure


def _draw_panel(
    axes: Axes, time: FloatArray, panel: _Panel, values: FloatArray, colours: Sequence[str], ensemble: FloatArray | None
) -> None:
    label, factor = panel.label, panel.factor
    if panel.name == "ux":
        if np.max(np.abs(values)) >= 1.0:
            label, factor = _LABEL_IN_METRES, 1.0
        if ensemble is not None:
            _draw_ensemble(axes, time, factor * ensemble, colours)
    _draw_histories(axes, time, factor * values, colours, panel.largest_only)
    axes.set_ylabel(label)


def _draw_histories(
    axes: Axes, time: FloatArray, values: FloatArray, colours: Sequence[str], largest_only: bool = False
) -> None:
    """Draw one line per column of values, those with the largest range first so that they hide no other.

    Histories with more samples than pixels would be a block of colour: their minimum and maximum are drawn, and the
    band between them, pale enough to show what is behind it.
    """
    n = values.shape[1]
    few = n <= len(FEW_COLOURS)
    ranges = np.nan_to_num(np.fmax.reduce(values) - np.fmin.reduce(values))
    order = np.argsort(-ranges, kind="stable")
    dense = len(time) > 2 * COLUMNS
    if dense:
        instants, (least, largest) = _pixels(time), (_reduced(values, by) for by in (np.fmin, np.fmax))
    for rank, i in enumerate(order):
        style: dict[str, Any] = {"color": colours[i], "linewidth": 0.7 if few else 0.4, "zorder": 3.0 + rank / n}
        if not dense:
            axes.plot(time, values[:, i], **style)
            continue
        axes.plot(instants, largest[:, i], **style)
        if not largest_only:
            axes.plot(instants, least[:, i], **style)
            band = {"color": colours[i], "alpha": 0.25 if few else 0.1, "linewidth": 0.0}
            axes.fill_between(instants, least[:, i], largest[:, i], **band)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)


def _draw_ensemble(axes: Axes, time: FloatArray, ensemble: FloatArray, colours: Sequence[str]) -> None:
    """Draw the middle two thirds of an ensemble as a band, its median dashed."""
    for i, colour in enumerate(colours):
        low, median, high = ensemble[:, :, i]
        axes.fill_between(time, low, high, color=colour, alpha=0.3, linewidth=0.0, zorder=1.0)
        axes.plot(time, median, color=colour, linestyle="--", linewidth=0.7, zorder=2.0)
    axes.text(
        0.99, 0.02, "ensemble: 16 to 84 % (bands), median (dashed)", transform=axes.transAxes, ha="right", fontsize=7
    )


def _draw_friction(
    axes: Axes, time: FloatArray, histories: Mapping[str, FloatArray], column: Column, colours: Sequence[str]
) -> None:
    """Draw |T| / N where the joint is pressed; without gravity there is no weight to compare N with."""
    axes.set_ylabel("$|T|/N$")
    carried = carried_weights(column)
    if not np.all(carried > 0.0):
        axes.text(0.5, 0.5, "no gravity", transform=axes.transAxes, ha="center", va="center")
        return
    N = histories["N"]
    ratio = friction_history(histories["T"], N, carried)
    _draw_histories(axes, time, np.where(COUNTS_FROM * carried < N, ratio, math.nan), colours, largest_only=True)
    axes.set_ylim(bottom=0.0)
    axes.text(
        0.99,
        0.97,
        f"where N is above {COUNTS_FROM:.0%} of the weight",
        transform=axes.transAxes,
        ha="right",
        va="top",
        fontsize=7,
    )


def _draw_contact(axes: Axes, time: FloatArray, contact: FloatArray) -> None:
    """Draw a strip per joint: joints open and close so often that lines would cover one another."""
    n = contact.shape[1]
    least = _reduced(contact, np.fmin)
    half = 0.5 * (time[-1] - time[0]) / max(1, len(least) - 1)
    extent = (time[0] - half, time[-1] + half, n + 0.5, 0.5)
    shades = LinearSegmentedColormap.from_list("contact", ["0.2", "1.0"])
    axes.imshow(least.T, cmap=shades, vmin=0.0, vmax=1.0, extent=extent, aspect="auto", interpolation="nearest")
    axes.set_ylabel("joint")
    if n <= len(FEW_COLOURS):
        axes.set_yticks(range(1, n + 1))
        axes.hlines(np.arange(1, n) + 0.5, time[0], time[-1], color="0.6", linewidth=1.0)
    else:
        axes.set_yticks([1, n])


def _starts(count: int) -> Any:
    """Index of the first sample of each pixel column."""
    return np.unique(np.linspace(0, count, min(count, COLUMNS), endpoint=False).astype(np.int64))


def _pixels(time: FloatArray) -> FloatArray:
    """Middle of each pixel column, the first and the last at the ends."""
    starts = _starts(len(time))
    middles: FloatArray = 0.5 * (time[starts] + time[np.append(starts[1:], len(time)) - 1])
    middles[0], middles[-1] = time[0], time[-1]
    return middles


def _reduced(values: FloatArray, by: Callable[..., Any]) -> FloatArray:
    """The minimum or maximum (`by`) of the samples (nt, n) in each pixel column and the first of the next.

    The first of the next is included so that the band of a steep line has no gaps. NaN is left out.
    """
    starts = _starts(len(values))
    found: FloatArray = by.reduceat(values, starts, axis=0)  # type: ignore[attr-defined]
    found[:-1] = by(found[:-1], values[starts[1:]])
    return found
