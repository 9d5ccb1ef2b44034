"""Lines of histories, one for each block or joint, decimated to the pixels of a panel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..models.column.packing import FloatArray
from .style import FEW_COLOURS

COLUMNS = 600  # pixels across a panel, about: finer detail cannot be distinguished


def draw_lines(
    axes: Axes, time: FloatArray, values: FloatArray, colours: dict[int, str], largest_only: bool = False
) -> None:
    """Plot the columns of `values` that have a colour, those of the largest range first.

    If there are more samples than pixels, a line joins the smallest and the largest value of each pixel column, at
    their instants. If not all columns have a colour, a grey band shows the envelope of all.

    Parameters
    ----------
    axes : Axes
    time : array (nt,)
        Times, s.
    values : array (nt, n)
        Histories, in the unit of the axes.
    colours : dict of int to str
        Column index to colour.
    largest_only : bool
        If True, a decimated line joins the largest values alone.
    """
    width = 0.8 if len(colours) <= len(FEW_COLOURS) // 2 else 0.6
    if len(colours) < values.shape[1]:
        least, largest = (np.asarray(by.reduce(reduced(values, by), axis=1)) for by in (np.fmin, np.fmax))
        axes.fill_between(_pixels(time), least, largest, color="0.88", linewidth=0.0, zorder=1.0)
    ranges = {i: float(np.nan_to_num(np.fmax.reduce(values[:, i]) - np.fmin.reduce(values[:, i]))) for i in colours}
    for rank, i in enumerate(sorted(colours, key=lambda i: -ranges[i])):
        instants, line = thinned(time, values[:, i], largest_only)
        axes.plot(instants, line, color=colours[i], linewidth=width, zorder=3.0 + rank / len(colours))


def thinned(time: FloatArray, values: FloatArray, largest_only: bool = False) -> tuple[FloatArray, FloatArray]:
    """Return instants and values, (m,) each, that look like the history: all samples or the extremes of each pixel.

    Parameters
    ----------
    time, values : array (nt,)
        The history.
    largest_only : bool
        If True, return only the largest value of each pixel column, at its middle.
    """
    if len(time) <= 2 * COLUMNS:
        return time, values
    if largest_only:
        return _pixels(time), reduced(values[:, None], np.fmax)[:, 0]
    starts = starts_of(len(time))
    kept = []
    for first, last in zip(starts, [*starts[1:], len(time)], strict=True):
        part = values[first:last]
        if np.all(np.isnan(part)):
            kept.append(first)
        else:
            kept += sorted({first + int(np.nanargmin(part)), first + int(np.nanargmax(part))})
    chosen = np.unique([0, *kept, len(time) - 1])
    return time[chosen], values[chosen]


def draw_ensemble(axes: Axes, time: FloatArray, ensemble: FloatArray, colours: dict[int, str]) -> None:
    """Draw the 16 % to 84 % range of an ensemble as a band, and its median as a dashed line.

    Parameters
    ----------
    axes : Axes
    time : array (nt,)
        Times, s.
    ensemble : array (3, nt, n)
        The 16 %, 50 % and 84 % points, in the unit of the axes.
    colours : dict of int to str
        Column index to colour, of the columns to draw.
    """
    for i, colour in colours.items():
        low, median, high = ensemble[:, :, i]
        axes.fill_between(time, low, high, color=colour, alpha=0.3, linewidth=0.0, zorder=1.0)
        axes.plot(time, median, color=colour, linestyle="--", linewidth=0.7, zorder=2.0)
    text = "ensemble: 16 to 84 % (bands), median (dashed)"
    axes.text(0.99, 0.02, text, transform=axes.transAxes, ha="right", fontsize=7)


def starts_of(count: int) -> Any:
    """Return the index of the first sample of each pixel column."""
    return np.unique(np.linspace(0, count, min(count, COLUMNS), endpoint=False).astype(np.int64))


def _pixels(time: FloatArray) -> FloatArray:
    """Return the middle time of each pixel column; the first and the last lie at the ends of the history."""
    starts = starts_of(len(time))
    middles: FloatArray = 0.5 * (time[starts] + time[np.append(starts[1:], len(time)) - 1])
    middles[0], middles[-1] = time[0], time[-1]
    return middles


def reduced(values: FloatArray, by: Callable[..., Any]) -> FloatArray:
    """Return the minimum or maximum of each pixel column, (columns, n), ignoring NaN: `by` is np.fmin or np.fmax.

    The first sample of the next pixel column is included, so that the band of a steep line has no gaps.
    """
    starts = starts_of(len(values))
    found: FloatArray = by.reduceat(values, starts, axis=0)  # type: ignore[attr-defined]
    found[:-1] = by(found[:-1], values[starts[1:]])
    return found
