"""A figure of a table of runs."""

from __future__ import annotations

import math
import os

import numpy as np
from matplotlib.ticker import MaxNLocator

from ..common.errors import InputError
from ..common.frames import Frame
from ..common.notebook import counted
from .style import INK, VERDICT_COLOURS, Figure, header, save, tidy

MOVES = ("peak_u", "peak_ux")  # keys of structures, of columns: the first one in the table is plotted
NAMES = "peak_u, peak_top_ux, peak_centroid_ux"  # of the same in Python


def plot_table(frame: Frame, path: str | os.PathLike[str] | None) -> Figure:
    """Plot the largest displacement of each run over its number, coloured by verdict; overturned runs at the top.

    Raises InputError if the table has no displacement, OSError if the file cannot be written.
    """
    name = next((name for name in MOVES if name in frame.columns), None)
    if name is None:
        raise InputError(f"keep: must have one of {NAMES} for a picture")
    # largest displacement of each run, NaN if it was not made
    runs, peaks = frame.index[1], 1e3 * np.atleast_2d(frame.columns[name].T).T
    moved = np.max(np.where(np.isnan(peaks), -math.inf, peaks), axis=1)
    moved[np.isinf(moved)] = math.nan  # not made
    verdicts = frame.columns.get("verdict", np.full(len(runs), ""))
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    fell = verdicts == "overturned"
    # one marker for each verdict; overturned runs at the top
    for verdict in sorted(set(verdicts.tolist())):
        here = verdicts == verdict
        colour = VERDICT_COLOURS.get(verdict, INK)
        label = f"{verdict}: {np.sum(here)}"
        if verdict == "overturned":
            top = np.full(np.sum(here), 0.97)
            axes.plot(runs[here], top, "^", color=colour, label=label, transform=axes.get_xaxis_transform())
        else:
            axes.plot(runs[here], moved[here], "o", color=colour, label=label, markersize=4.0)
    seen = moved[~fell & ~np.isnan(moved)]
    if seen.size:
        axes.set_ylim(0.0, 1.15 * float(np.max(seen)) or 1.0)
    axes.set(xlabel="run", ylabel="largest displacement (mm)")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if "verdict" in frame.columns:
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    tidy(axes)
    header(figure, counted(len(runs), "run"))
    return save(figure, path)
