"""Panels beside the histories: peaks over the height, final offsets, the last moments before a fall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..models.column.model import Column
from ..models.column.packing import FloatArray
from .drawings import Shapes, corners_of, draw_column
from .style import GREY, GRID, INK

MOST_LABELLED = 12  # bars with a number beside each
MOST_FRICTION = 3.0  # |T| / N that the axis reaches: no friction is larger
AT_LEAST = 0.5  # s, drawn at least before the column is lost
BEFORE = 0.25  # of the time in which a column falls: drawn before it is lost
# name of the peak, heading, factor from SI
_PROFILES = (
    ("ux", "displacement (mm)", 1e3),
    ("contact", "least contact", 1.0),
    ("sigma_max", "pressure (MPa)", 1e-6),
    ("friction", "$|T|/N$, at most 3 drawn", 1.0),
)


def draw_profiles(
    panels: Sequence[Axes], column: Column, largest: Mapping[str, FloatArray], chosen: Mapping[int, str]
) -> None:
    """Plot the peak values of every block and joint over the height, m, in four panels.

    Parameters
    ----------
    panels : sequence of Axes
        Four panels: displacement, least contact, pressure and friction demand.
    column : Column
    largest : mapping of str to array (n,)
        Peak values in SI units; a missing one leaves its panel empty.
    chosen : mapping of int to str
        Block index to colour, of the blocks that have lines.
    """
    heights = np.array([block.height for block in column.blocks])
    tops = np.cumsum(heights[::-1])[::-1]
    for axes, (name, heading, factor) in zip(panels, _PROFILES, strict=True):
        axes.set_title("extremes over the height" if name == "ux" else "", loc="left")
        axes.set_xlabel(heading)
        place = tops if name == "ux" else tops - heights
        if name in largest:
            values = factor * largest[name]
            # clip the friction demand, which is unbounded as N vanishes
            if name == "friction" and np.nanmax(values, initial=0.0) > MOST_FRICTION:
                axes.set_xlim(right=MOST_FRICTION)
                values = np.minimum(values, MOST_FRICTION)  # on the edge
            axes.plot(values, place, "o-", color=GREY, linewidth=0.8, markersize=2.5)
            for i, colour in chosen.items():
                axes.plot(values[i], place[i], "o", color=colour, markersize=5.0, clip_on=False)
        axes.set_xlim(left=0.0)
        axes.set_ylim(0.0, 1.03 * tops[0])
        axes.grid(color=GRID, linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        if name == "ux":
            axes.set_ylabel("height (m)")
        else:
            axes.tick_params(labelleft=False)


def draw_offsets(axes: Axes, offsets: FloatArray) -> None:
    """Draw the final offset of each block on the body below, mm (n,), as bars over the joints."""
    n = len(offsets)
    joints = np.arange(1, n + 1)
    axes.set_title("offset left in the joint at the end", loc="left")
    axes.barh(joints, offsets, height=0.6, color=GREY)
    axes.axvline(0.0, color=INK, linewidth=0.8)
    if n <= MOST_LABELLED:
        reach = max(float(np.max(np.abs(offsets))), 1e-9)
        axes.set_xlim(-1.5 * reach, 1.5 * reach)  # room for eight letters
        axes.locator_params(axis="x", nbins=4)
        for joint, offset in zip(joints, offsets, strict=True):
            side = 1.0 if offset >= 0.0 else -1.0
            text: dict[str, Any] = {"ha": "left" if side > 0.0 else "right", "va": "center", "fontsize": 8}
            axes.text(offset + 0.03 * side * reach, float(joint), f"{offset:.3g}", **text)
        axes.set_yticks(joints)
    axes.set(ylim=(n + 0.6, 0.4), xlabel="offset (mm)", ylabel="joint")


def draw_last_moments(
    panels: Sequence[Axes], time: FloatArray, places: Shapes, gone: int, overturn_time: float
) -> None:
    """Draw the column to scale at equal intervals, from shortly before it is lost until it lies.

    Parameters
    ----------
    panels : sequence of Axes
        One panel for each instant.
    time : array (rows,)
        Times, s.
    places : Shapes
        Displacements of the blocks at these times.
    gone : int
        Number of rows before the column cannot come back.
    overturn_time : float
        Time of the fall, s.
    """
    lost = float(time[min(gone, len(time) - 1)])
    first = max(float(time[0]), lost - max(BEFORE * (overturn_time - lost), AT_LEAST))
    rows = [int(np.argmin(np.abs(time - instant))) for instant in np.linspace(first, overturn_time, len(panels))]
    corners = np.concatenate([corner for k in rows for corner in corners_of(places, k, 1.0)])
    (left, _), (right, top) = corners.min(axis=0), corners.max(axis=0)
    margin = 0.04 * (right - left)
    for k, axes in zip(rows, panels, strict=True):
        draw_column(axes, places, k, 1.0, linewidth=0.6)
        axes.set(xlim=(left - margin, right + margin), ylim=(-0.03 * top, 1.03 * top))
        axes.set_anchor("S")
        axes.text(0.5, -0.04, f"{time[k]:.2f} s", transform=axes.transAxes, ha="center", va="top", fontsize=8)
    panels[0].set_title("the last moments, to scale", loc="left")
