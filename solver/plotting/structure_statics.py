"""Figures of the statics of a structure: modes and push-over (imported lazily, for matplotlib)."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING

import numpy as np

from .structures import VISIBLE, draw_blocks, extent_of, visible_scale
from .style import BLUE, GREY, INK, RED, Figure, header, plain, save, tidy
from .words import drawn_larger

if TYPE_CHECKING:
    from ..models.structure.modes import SpatialModes
    from ..models.structure.push import PushOver

COLUMNS = 3  # mode shapes side by side


def plot_modes(modes: SpatialModes, path: str | os.PathLike[str] | None, most: int) -> Figure:
    """Draw the first `most` mode shapes, and save the figure if `path` is given.

    Raises InputError, OSError as `save` does.
    """
    structure, count = modes.model, min(most, len(modes.frequency))
    across = min(COLUMNS, count)
    down = math.ceil(count / across)
    figure = Figure(figsize=(max(5.0, 3.6 * across), 0.8 + 3.5 * down), layout="constrained")
    scale = VISIBLE * extent_of(structure)  # of a shape, whose largest displacement is 1 m
    for k in range(count):
        axes = figure.add_subplot(down, across, k + 1, projection="3d")
        draw_blocks(axes, structure, scale * modes.displacement[k], scale * modes.rotation[k])
        parts = ", ".join(f"{axis} {100.0 * modes.mass_ratio[k, i]:.1f}" for i, axis in enumerate("xyz"))
        axes.set_title(f"{k + 1}: {modes.frequency[k]:.4g} Hz, damping {100.0 * modes.damping_ratio[k]:.3g} %")
        axes.set_axis_off()
        axes.text2D(
            *(0.5, 0.99, f"mass % {parts}; twist {100.0 * modes.twists[k]:.1f}"),
            **{"transform": axes.transAxes, "fontsize": 8, "color": GREY, "ha": "center", "va": "top"},
        )
    words = "Shapes of small motion, drawn large, x to the right; damping in % of critical, effective mass in % of all."
    header(figure, f"{structure.name}: modes about rest", words)
    return save(figure, path)


def plot_push_over(found: PushOver, path: str | os.PathLike[str] | None) -> Figure:
    """Plot the push over the displacement, and draw the structure at its largest push; saved to `path` if given.

    Raises InputError, OSError as `save` does.
    """
    size, unit = found.unit
    structure, moved, push = found.model, 1e3 * found.moved, found.acceleration / size
    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=(1.1, 1.0))
    curve = figure.add_subplot(grid[0])
    curve.plot(moved, push, color=BLUE)
    # points of first opening, first sliding and largest push
    begins = {
        f"{found.uplift_joint} begins to open": (found.uplift, "o", INK),
        f"{found.sliding_joint} begins to slide": (found.sliding, "s", INK),
        "largest push": (found.largest_acceleration, "o", RED),
    }
    for words, (at, marker, colour) in begins.items():
        if math.isfinite(at):
            k = int(np.searchsorted(found.acceleration, at))
            curve.plot(moved[k], push[k], marker, color=colour, label=f"{words}, {push[k]:.3g} {unit}")
    curve.legend(loc="lower right", frameon=False, fontsize=9)
    curve.set(xlabel=f"displacement of {plain(structure.names[found.moves_most])} (mm)", ylabel=f"push ({unit})")
    curve.set_xlim(left=0.0)
    curve.set_ylim(bottom=0.0)
    tidy(curve)
    # deformed structure at the largest push
    drawn = figure.add_subplot(grid[1], projection="3d")
    u = np.stack([found.ux[-1], found.uy[-1], found.uz[-1]], axis=-1)
    scale = visible_scale(structure, u)
    draw_blocks(drawn, structure, scale * u, scale * found.rotation[-1])
    drawn.set_title(f"at the largest push, {drawn_larger(scale)}", fontsize=10)
    towards = f"Towards {math.degrees(found.direction):.4g} degrees from x to y it" if found.pattern is None else "It"
    words = f"{towards} balances {push[-1]:.3g} {unit} {found.limit}."
    header(figure, f"{structure.name}: push-over", words)
    return save(figure, path)
