"""Representations of objects: a line in a terminal; in a notebook also a small table and a picture (SVG)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

INK, STONE, BLUE = "#3b3a38", "#cdbfa7", "#0072b2"
COLOURS = BLUE, "#d55e00", "#009e73"  # of the lines of a picture
HEIGHT, WIDTH = 160.0, 360.0  # px, maximum size of a picture
MOST_ROWS = 6
BINS = 300  # intervals of a plotted history; the least and largest values in each are drawn


class NotebookRepr:
    """An object with a short representation in terminals and notebooks."""

    def _facts(self) -> tuple[str, ...]:
        """Return the name, then the most important facts."""
        raise NotImplementedError

    def _lines(self) -> Iterable[Sequence[object]]:
        """Return a small table, the header first."""
        return ()

    def _picture(self) -> str:
        """Return an SVG picture, or ""."""
        return ""

    def __repr__(self) -> str:
        name, *facts = self._facts()
        return f"<{type(self).__name__} {name}: {', '.join(facts)}>"

    def _repr_html_(self) -> str:
        name, *facts = map(escape, self._facts())
        head, *rows = [[_cell(item) for item in row] for row in self._lines()] or [[]]
        hidden = [["..."] * len(head)] if len(rows) > MOST_ROWS else []
        lines = [f"<th>{'</th><th>'.join(head)}</th>"] if head else []
        lines += [f"<td>{'</td><td>'.join(row)}</td>" for row in rows[:MOST_ROWS] + hidden]
        table = f"<table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>" if lines else ""
        text = f"<p><b>{type(self).__name__} {name}</b><br>{', '.join(facts)}</p>{table}"
        return f'<div style="display: flex; gap: 2em"><div>{text}</div><div>{self._picture()}</div></div>'


def counted(number: int, word: str) -> str:
    """Return a number with its noun, as in "1 block", "2 blocks"."""
    return f"{number} {word}" + ("" if number == 1 else "s")


def rows_of(columns: Mapping[str, NDArray[Any]]) -> list[Sequence[object]]:
    """Return the first rows of columns (m,) as a table for `NotebookRepr._lines`."""
    few = [values[: MOST_ROWS + 1].tolist() for values in columns.values()]
    return [tuple(columns), *zip(*few, strict=True)]


def _cell(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else escape(str(value))


def outlines(shapes: Iterable[ArrayLike]) -> str:
    """Draw polygons (m, 2) to scale, x to the right and z up, as SVG."""
    corners = [np.asarray(shape, dtype=np.float64) for shape in shapes]
    every = np.concatenate(corners)
    low, size = every.min(axis=0), np.ptp(every, axis=0)
    scale = min(HEIGHT / size[1], WIDTH / size[0])
    path = "".join(
        "M" + "L".join(f"{x:.1f} {HEIGHT - z:.1f}" for x, z in (scale * (polygon - low)).tolist()) + "Z"
        for polygon in corners
    )
    drawn = f'<path d="{path}" fill="{STONE}" stroke="{INK}" stroke-width="0.8"/>'
    return _svg(scale * size[0], HEIGHT, drawn)


def history(
    time: NDArray[np.float64], values: NDArray[np.float64] | Mapping[str, NDArray[np.float64]], label: str
) -> str:
    """Draw histories as SVG lines that keep their peaks, with their range and a label.

    Parameters
    ----------
    time : ndarray of shape (m,)
        The instants (s).
    values : ndarray of shape (m,), or mapping of str to such arrays
        The values; of several lines, three at most, by names that are written in their colours.
    label : str
        The quantity and its unit.
    """
    places = np.linspace(0, len(time), min(BINS, len(time)) + 1).astype(int)[:-1]
    named = values if isinstance(values, Mapping) else {"": values}
    every = np.array([*named.values()])
    low, high = np.minimum.reduceat(every, places, axis=1), np.maximum.reduceat(every, places, axis=1)
    bottom, top = float(min(low.min(), 0.0)), float(max(high.max(), 0.0))
    span = np.ptp(time) or 1.0
    x = np.repeat(WIDTH * (time[places] - time[0]) / span, 2)
    heights = 0.75 * HEIGHT * (1.0 - (np.stack([low, high], axis=-1) - bottom) / ((top - bottom) or 1.0))
    drawn, text = "", f"{escape(label)}, {bottom:.4g} to {top:.4g}, over {span:.4g} s"
    for name, colour, z in zip(named, COLOURS, heights.reshape(len(every), -1), strict=False):
        line = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x.tolist(), z.tolist(), strict=True))
        drawn += f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="0.8"/>'
        text += f'; <tspan fill="{colour}">{escape(name)}</tspan>' if len(named) > 1 else ""
    drawn += f'<text x="0" y="{0.9 * HEIGHT:.0f}" font-size="11" fill="{INK}">{text}</text>'
    return _svg(WIDTH, HEIGHT, drawn)


def _svg(width: float, height: float, drawn: str) -> str:
    frame = f'viewBox="-2 -2 {width + 4:.0f} {height + 4:.0f}" width="{width + 4:.0f}" height="{height + 4:.0f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {frame}>{drawn}</svg>'
