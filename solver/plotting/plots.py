"""Figures of a response over time: base motion, a panel for each quantity, and profiles over the height."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.gridspec import SubplotSpec

from ..common.digits import percent, three_digits
from ..common.errors import InputError
from ..ground.motion import STANDARD_GRAVITY, Motion
from ..kernels.layout.spaces import COUNTS_FROM
from ..models.column.model import Column
from ..models.column.packing import FloatArray, carried_weights
from ..models.column.response import Response, friction_history
from .drawings import DisplacementHistories
from .largest import rows_before_fall
from .lines import draw_ensemble, draw_lines, reduced
from .profiles import draw_last_moments, draw_offsets, draw_profiles
from .style import FEW_COLOURS, GREY, RED, TINT, Figure, name_of, note_on_right, save, show_names, tidy
from .words import setting_of, verdict_of, write_header

GROUND_SAMPLES = 20_000  # of a harmonic, which has no samples
HISTORIES = ("ux", "ry", "N", "My", "S", "Tx", "contact", "sigma_max")
OTHERS = ("uz", "slip")  # optional histories
PEAK = "peak between rows"
MISSED = 1.02  # times the largest row: a larger peak is marked
FAR = 3.0  # times the largest row: larger peaks are marked there by an arrow outwards
WHOLE = 1.0 - 1e-6  # contact of a joint that stays closed
AFTER_FALL = 0.03  # of the time until a fall: drawn beyond it


@dataclass(frozen=True)
class _Panel:
    name: str  # history, or "T/N"
    heading: str
    label: str
    unit: str = ""
    factor: float = 1.0  # from SI
    peak: str = ""  # name among `Response.peaks`, where it is not `name`
    largest_only: bool = False  # where samples are dense: the minimum carries no information


# row by row: the motion on the left, resultants on the right
_PANELS = (
    _Panel("ux", "displacement of the top face", "$u_x$", "mm", 1e3),
    _Panel("N", "normal force in the joint", "$N$", "kN", 1e-3),
    _Panel("ry", "rotation", r"$\theta$", "mrad", 1e3),
    _Panel("My", "moment in the joint", "$M$", "kN m", 1e-3),
    _Panel("contact", "width in contact, white: all", "joint"),
    _Panel("S", "horizontal shear in the joint", "$S$", "kN", 1e-3),
    _Panel("sigma_max", "largest pressure in the joint", r"$\sigma_{max}$", "MPa", 1e-6, "", True),
    _Panel("T/N", "friction demand", "$|T|/N$", "", 1.0, "friction", True),
)
_SLIP = _Panel("slip", "slip over the body below", "slip", "mm", 1e3)
_IN_METRES = _Panel("ux", "displacement of the top face", "$u_x$", "m")


@dataclass(frozen=True, eq=False)
class _Shown:
    """The data of a figure: histories (nt, n) in SI units until shortly after a fall, and the blocks with lines."""

    column: Column
    time: FloatArray
    histories: Mapping[str, FloatArray]
    peaks: Mapping[str, FloatArray]  # of the continuous motion; none of one with a fall
    chosen: dict[int, str]  # block, from 0 -> colour
    overturn_time: float  # s, NaN while it stands
    gone: int  # number of rows until it cannot come back; all while it stands

    @property
    def falls(self) -> bool:
        return self.gone < len(self.time)

    @property
    def has_profiles(self) -> bool:
        return len(self.chosen) < self.column.n

    @property
    def has_last_moments(self) -> bool:
        return bool(self.overturn_time <= self.time[-1]) and "uz" in self.histories

    @property
    def has_slip(self) -> bool:
        return self.column.slides and "slip" in self.histories and bool(np.any(self.histories["slip"]))

    def has(self, name: str) -> bool:
        """Return True if a history is there, and is not a contact that stays whole."""
        return name in self.histories and (name != "contact" or bool(np.min(self.histories[name]) < WHOLE))


def plot_response(
    response: Response,
    path: str | os.PathLike[str] | None = None,
    title: str | None = None,
    names: Sequence[str] = (*HISTORIES, *OTHERS),
) -> Figure:
    """Draw histories of a Response by name, and save the figure if `path` is given.

    If the response has an ensemble, the 16 % to 84 % range of ux is drawn as a band, its median as a dashed line.
    Raises InputError, OSError as `plot_histories` does.
    """
    ensemble = getattr(response, "ensemble", None)
    return plot_histories(
        response.time,
        {name: getattr(response, name) for name in names},
        response.model,
        response.motion,
        title,
        overturn_time=response.overturn_time,
        path=path,
        ensemble=None if ensemble is None else ensemble.ux,
        verdict=verdict_of(response),
        peaks=response.peaks,
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
    verdict: tuple[str, str] | None = None,
    peaks: Mapping[str, FloatArray] | None = None,
) -> Figure:
    """Draw the base motion, and below it the histories of every block and of the joint under it.

    If there are more blocks than colours, some blocks have lines, a band shows the envelope of all, and the peaks are
    drawn over the height.

    Parameters
    ----------
    time : array (nt,)
        Times, s, equally spaced.
    histories : mapping of str to array (nt, n)
        The quantities `HISTORIES` in SI units, block 1 (the top) first, as in `Response`. With uz the last moments
        before a fall are drawn, with slip that of a column that slides.
    column : Column
    motion : Motion, optional
        Motion of the base on the same clock. Default: not drawn.
    title : str, optional
        Default: the column, the motion and its PGA.
    overturn_time : float
        Time of the fall, s, NaN while the column stands; rows long after it are left out.
    path : path-like, optional
        File to save to, in the format of its suffix.
    ensemble : array (3, nt, n), optional
        The 16 %, 50 % and 84 % points of ux among many runs, m; NaN where there are none.
    verdict : tuple of str, optional
        A word of `Response.verdict`, and a sentence.
    peaks : mapping of str to array (n,), optional
        Peaks of the continuous motion, as `Response.peaks`; marked where the rows miss them.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are fewer than two instants, or matplotlib knows no format of that suffix.
    OSError
        If the file cannot be written.
    """
    if len(time) < 2:
        raise InputError(f"time: {len(time)} sample, must be at least 2 to draw a history")
    shown = _shown(time, histories, column, overturn_time, peaks or {})
    # base motion and histories
    figure, ground, panels = _layout(shown)
    draw_ground(ground, motion)
    for axes, panel in panels.items():
        cut = None if ensemble is None or panel.name != "ux" else ensemble[:, : len(shown.time)]
        _draw_panel(axes, panel, shown, cut)
    # common time axis, labelled in the lowest row
    rows = [axes for axes in figure.axes if axes is ground or axes in panels]
    for axes in rows:
        axes.set_xlim(shown.time[0], shown.time[-1])
        _mark_fall(axes, shown)
    for axes in list(panels)[-2:]:
        axes.set_xlabel("time (s)")
    for axes in list(panels)[:-2]:
        axes.tick_params(labelbottom=False)
    # profiles, and letters before the headings of all panels
    _draw_side_panels(figure, shown)
    for k, axes in enumerate(axes for axes in figure.axes if axes.get_title() or axes.get_title(loc="left")):
        tidy(axes, grid=axes is ground or panels.get(axes, _SLIP).name != "contact")
        axes.set_title(f"({chr(ord('a') + k % 26)}) {axes.get_title(loc='left')}", loc="left", fontsize=10)
    figure.align_ylabels(rows)
    # legend and title
    names = [name_of(i, column.n, "block and joint") for i in sorted(shown.chosen)]
    if len(shown.chosen) < column.n:
        names[0] += "; grey: all"
    marked = any(line.get_label() == PEAK for axes in panels for line in axes.lines)
    show_names(figure, names, [shown.chosen[i] for i in sorted(shown.chosen)], mark=PEAK if marked else "")
    verdict = verdict or verdict_of(SimpleNamespace(overturn_time=overturn_time, what_fell=""))
    write_header(figure, setting_of(column, motion) if title is None else title, verdict)
    return save(figure, path)


def draw_ground(axes: Axes, motion: Motion | None) -> None:
    """Plot the acceleration of the base in g; without a motion, write that it is not known."""
    axes.set_title("acceleration of the base", loc="left", fontsize=10)
    if motion is None:
        axes.text(0.5, 0.5, "not kept with these histories", transform=axes.transAxes, ha="center", va="center")
        axes.set_yticks([])
        return
    time, ax, az = _ground_lines(motion)
    lines = [("along x" if motion.has_ay else "horizontal", time, ax, "-"), ("vertical", time, az, ":")]
    if motion.has_ay:
        across, ay, _ = _ground_lines(motion.turned(-0.5 * math.pi))
        lines.insert(1, ("along y", across, ay, "--"))
    shown = [line for line in lines if line is lines[0] or np.any(line[2])]
    for name, instants, values, style in shown:
        axes.plot(instants, values / STANDARD_GRAVITY, color="0.2", linestyle=style, linewidth=0.7, label=name)
    if len(shown) > 1:
        axes.legend(loc="upper right", fontsize=8, frameon=False, ncols=3)
    axes.set_ylabel("$a$ (g)")
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)


def _ground_lines(motion: Motion) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return time, ax and az at the corners of the lines that make up the acceleration."""
    if motion.amplitude:
        time = np.union1d(motion.time, np.linspace(motion.start, motion.end, GROUND_SAMPLES))
        return time, *motion.acceleration(time)
    if motion.hold:
        time = np.repeat(np.append(motion.time, motion.end), 2)[1:-1]
        return time, np.repeat(motion.ax, 2), np.repeat(motion.az, 2)
    return motion.time, motion.ax, motion.az


def _shown(
    time: FloatArray,
    histories: Mapping[str, FloatArray],
    column: Column,
    overturn_time: float,
    peaks: Mapping[str, FloatArray],
) -> _Shown:
    """Leave out rows long after a fall, and choose the blocks that have lines."""
    # rows up to shortly after a fall, and up to which it can come back
    rows, falls = len(time), overturn_time <= time[-1]
    if falls:
        end = overturn_time + AFTER_FALL * (overturn_time - time[0])
        rows = min(rows, max(2, int(np.searchsorted(time, end, side="right"))))
    cut = {name: values[:rows] for name, values in histories.items()}
    gone = rows
    if falls:
        widest = max(block.width for block in column.blocks)
        gone = rows_before_fall(time[:rows], np.abs(cut["ux"]), overturn_time, widest)
    # friction demand, left out where the joint carries little of the weight
    carried = carried_weights(column)
    if np.all(carried > 0.0):
        ratio = friction_history(cut["Tx"], cut["N"], carried)
        cut["T/N"] = np.where(COUNTS_FROM * carried < cut["N"], ratio, math.nan)
    kept = {} if falls else dict(peaks)
    return _Shown(column, time[:rows], cut, kept, _chosen(column.n, cut, gone), overturn_time, gone)


def _chosen(n: int, histories: Mapping[str, FloatArray], rows: int) -> dict[int, str]:
    """Return the colours of the blocks that have lines: all, or the ends and those of the largest pressure and bend."""
    if n <= len(FEW_COLOURS):
        return dict(enumerate(FEW_COLOURS[:n]))
    below = np.column_stack([histories["ry"][:rows, 1:], np.zeros(rows)])
    joint = histories["ry"][:rows] - below
    ranked = [
        np.argsort(-np.max(np.nan_to_num(np.abs(values)), axis=0), kind="stable")
        for values in (histories["sigma_max"][:rows], joint)
    ]
    found = [0, n - 1]
    for order in ranked:  # a neighbour of a chosen block would look like it
        found.append(next(int(i) for i in order if min(abs(i - j) for j in found) > n // 7))
    return dict(zip(sorted(found), FEW_COLOURS, strict=False))


def _layout(shown: _Shown) -> tuple[Figure, Axes, dict[Axes, _Panel]]:
    """Return the figure, the panel of the base motion, and the panels of the histories."""
    wanted = [panel for panel in (*_PANELS, *([_SLIP] if shown.has_slip else [])) if shown.has(panel.name)]
    rows = math.ceil((len(wanted) + shown.has_slip) / 2)
    beside = shown.has_profiles + shown.has_last_moments
    figure = Figure(figsize=(10.0, 2.0 * (rows + 1 + 1.1 * beside)), layout="constrained")
    heights = (0.7, *(1.0,) * rows, *(1.15,) * beside)
    grid = figure.add_gridspec(rows + 1 + beside, 2, height_ratios=heights)
    ground = figure.add_subplot(grid[0, :])
    panels = {figure.add_subplot(grid[1 + k // 2, k % 2], sharex=ground): panel for k, panel in enumerate(wanted)}
    return figure, ground, panels


def _draw_side_panels(figure: Figure, shown: _Shown) -> None:
    """Draw the final offsets, the peaks over the height and the last moments before a fall."""
    grid = figure.axes[0].get_subplotspec().get_gridspec()  # type: ignore[union-attr]
    last = grid.nrows - 1 - shown.has_last_moments
    if shown.has_profiles:
        draw_profiles(_split(grid[last, :], 4), shown.column, _largest(shown), shown.chosen)
        last -= 1
    if shown.has_last_moments:
        places = DisplacementHistories(shown.column, *(shown.histories[name] for name in ("ux", "uz", "ry")))
        draw_last_moments(_split(grid[-1, :], 6), shown.time, places, shown.gone, shown.overturn_time)
    if shown.has_slip:
        draw_offsets(figure.add_subplot(grid[last, 1]), 1e3 * shown.histories["slip"][-1])


def _split(place: SubplotSpec, count: int) -> Sequence[Axes]:
    """Return `count` panels side by side."""
    return place.subgridspec(1, count).subplots(squeeze=False)[0]


def _largest(shown: _Shown) -> dict[str, FloatArray]:
    """Return the peak of each quantity, (n,), and the least contact, of the motion or of the rows before a fall."""
    rows = {name: np.fmax.reduce(np.abs(values[: shown.gone])) for name, values in shown.histories.items()}
    rows["contact"] = np.min(shown.histories["contact"][: shown.gone], axis=0)
    if "T/N" in rows:
        rows["friction"] = rows["T/N"]
    return rows | dict(shown.peaks)


def _mark_fall(axes: Axes, shown: _Shown) -> None:
    """Draw a dashed line at the time of the fall, and a tint from where the column cannot come back."""
    if not math.isfinite(shown.overturn_time):
        return
    axes.axvline(shown.overturn_time, color="black", linestyle="--", linewidth=1.0)
    if shown.falls:
        lost = float(shown.time[shown.gone])
        axes.axvspan(lost, shown.time[-1], color=TINT, linewidth=0.0, zorder=0.0)
        if axes is axes.figure.axes[0]:
            axes.text(lost, 0.97, " falls", transform=axes.get_xaxis_transform(), va="top", fontsize=9, color=RED)


def _draw_panel(axes: Axes, panel: _Panel, shown: _Shown, ensemble: FloatArray | None) -> None:
    axes.set_title(panel.heading, loc="left")
    if panel.name == "contact":
        _draw_contact(axes, shown.time, shown.histories["contact"])
        least = _largest(shown)["contact"]
        note_on_right(axes, f"least {np.min(least):.2g}, joint {np.argmin(least) + 1}")
        return
    # lines, over the band of an ensemble
    values = shown.histories[panel.name]
    if panel.name == "ux" and np.max(np.abs(values[: shown.gone])) >= 1.0:
        panel = _IN_METRES
    if ensemble is not None:
        draw_ensemble(axes, shown.time, panel.factor * ensemble, shown.chosen)
    draw_lines(axes, shown.time, panel.factor * values, shown.chosen, panel.largest_only)
    axes.set_ylabel(f"{panel.label} ({panel.unit})" if panel.unit else panel.label)
    if panel.name == "T/N":
        note = f"where N > {percent(COUNTS_FROM)} of the weight"
        axes.text(0.01, 0.98, note, transform=axes.transAxes, va="top", fontsize=7, color=GREY)
    # range and peaks
    _limit(axes, panel, shown)
    _mark_peak(axes, panel, shown)
    if panel.name == "T/N":
        axes.set_ylim(top=1.12 * axes.get_ylim()[1])  # for the note


def _limit(axes: Axes, panel: _Panel, shown: _Shown) -> None:
    """Fit the panel to the rows before a fall."""
    if shown.falls:
        values = panel.factor * shown.histories[panel.name][: shown.gone]
        low, high = float(np.fmin.reduce(values, axis=None)), float(np.fmax.reduce(values, axis=None))
        if high > low:
            axes.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))
    if panel.largest_only and np.isfinite(axes.get_ylim()[1]):
        axes.set_ylim(bottom=0.0)


def _mark_peak(axes: Axes, panel: _Panel, shown: _Shown) -> None:
    """Write the largest value over the panel; mark peaks of the continuous motion that the rows miss, on the right."""
    rows = np.nan_to_num(np.abs(shown.histories[panel.name][: shown.gone]))
    largest = np.max(rows, axis=0)
    true = shown.peaks.get(panel.peak or panel.name, largest)
    top = int(np.argmax(true))
    of = "block" if panel.name in ("ux", "ry", "slip") else "joint"
    value = f"{three_digits(panel.factor * true[top])} {panel.unit}".rstrip()
    until = "before the fall" if math.isfinite(shown.overturn_time) else "peak"
    note_on_right(axes, f"{until} {value}, {of} {top + 1}")
    # marks of missed peaks; an arrow outwards where a peak is far beyond the rows
    missed = [i for i in (*shown.chosen, top) if true[i] > MISSED * max(largest[i], 1e-300)]
    low, high = axes.get_ylim()
    for i in missed:
        k = int(np.argmax(rows[:, i]))
        sign = -1.0 if shown.histories[panel.name][k, i] < 0.0 else 1.0
        inside = true[i] <= FAR * np.max(largest)
        place = sign * panel.factor * min(true[i], FAR * np.max(largest))
        low, high = min(low, 1.08 * place), max(high, 1.08 * place)
        marker = "<" if inside else "^" if sign > 0.0 else "v"
        style: dict[str, Any] = {"color": shown.chosen.get(i, GREY), "markersize": 6.0, "clip_on": False, "zorder": 9.0}
        axes.plot([1.0], [place], marker, transform=axes.get_yaxis_transform(), label=PEAK, **style)
    axes.set_ylim(low, high)


def _draw_contact(axes: Axes, time: FloatArray, contact: FloatArray) -> None:
    """Draw a strip for each joint, since lines of joints that open and close often would cover one another."""
    n = contact.shape[1]
    least = reduced(contact, np.fmin)
    half = 0.5 * (time[-1] - time[0]) / max(1, len(least) - 1)
    extent = (time[0] - half, time[-1] + half, n + 0.5, 0.5)
    shades = LinearSegmentedColormap.from_list("contact", ["0.2", "1.0"])
    axes.imshow(
        least.T, cmap=shades, vmin=0.0, vmax=1.0, extent=extent, aspect="auto", interpolation="nearest", zorder=0.5
    )
    axes.set_ylabel("joint")
    if n <= len(FEW_COLOURS):
        axes.set_yticks(range(1, n + 1))
        axes.hlines(np.arange(1, n) + 0.5, time[0], time[-1], color="0.6", linewidth=1.0)
    else:
        axes.set_yticks(np.unique(np.linspace(1, n, 5).round().astype(int)))
