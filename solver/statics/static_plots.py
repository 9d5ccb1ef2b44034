"""Pictures of a column at rest: its modes, its capacity curve. Imported late, for matplotlib."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from ..ground.motion import STANDARD_GRAVITY
from ..models.column.model import Column
from ..plotting.drawings import SHOWN, DisplacementHistories, draw_column, measure_column
from ..plotting.largest import length
from ..plotting.style import BLUE, GREY, RED, Figure, header, save, tidy

if TYPE_CHECKING:
    from ..models.column.modes import Modes
    from .capacity import CapacityCurve

SMALL = 1e-6  # m: the amplitude of shapes, which drawings magnify
LEAST_MOVED = 1e-9  # m: a displacement of the top that is drawn
TURNED, RAISED = 0.3, 0.1  # rad, and part of the lowest block's height: largest rotation and rise of a drawn shape


def plot_modes(modes: Modes, path: str | os.PathLike[str] | None, most: int) -> Figure:
    """Draw the shapes of the first `most` modes, and save the picture to `path` if given.

    Raises InputError, OSError as `save` does.
    """
    count = min(most, len(modes.frequency))
    figure = Figure(figsize=(max(4.0, 0.4 + 1.9 * count), 5.5), layout="constrained")
    height = sum(block.height for block in modes.model.blocks)
    above, below = figure.subplots(2, count, height_ratios=(0.14, 1.0), squeeze=False)
    for k, (words, axes) in enumerate(zip(above, below, strict=True)):
        ux, uz, theta = (SMALL * np.atleast_2d(values[k]) for values in (modes.ux, modes.uz, modes.ry))
        limits = (
            (SHOWN * height, ux),
            (TURNED, theta),
            (RAISED * min(block.height for block in modes.model.blocks), uz),
        )
        # largest scale at which displacement, rotation and rise stay within their limits
        scale = min(most / max(float(np.max(np.abs(values))), 1e-300) for most, values in limits)
        for patch in draw_column(axes, DisplacementHistories(modes.model, ux, uz, theta), 0, scale):
            patch.set_alpha(0.85)
        mass = abs(modes.mass_x[k] if modes.sways[k] else modes.mass_z[k]) / _mass(modes.model)
        way = "sways" if modes.sways[k] else "moves up"
        text = f"damping {100.0 * modes.damping_ratio[k]:.3g} %\n{way}, {100.0 * mass:.3g} % of the mass"
        words.text(0.5, 1.0, f"{k + 1}: {modes.frequency[k]:.4g} Hz", fontsize=12, ha="center", va="top")
        words.text(0.5, 0.55, text, fontsize=8, color=GREY, ha="center", va="top")
        words.set_axis_off()
    header(
        figure,
        f"{modes.model.name}: modes about rest",
        "Shapes of small motion, drawn large; damping in % of critical.",
    )
    return save(figure, path)


def plot_capacity(curve: CapacityCurve, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw base shear and moment over the top displacement, and the column at its largest push.

    The picture is saved to `path` if given. Raises InputError, OSError as `save` does.
    """
    figure = Figure(figsize=(11.0, 6.8), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=(1.15, 1.15, 1.1))
    strongest = curve.strongest
    top = curve.direction * curve.ux[:, 0]
    # shear and moment: close to the largest push, and up to the edge
    near, end = max(4.0 * float(top[strongest]), LEAST_MOVED), "to the end" if curve.ends else "to the edge"
    for place, limit, heading in ((0, near, "up to the largest push and beyond"), (1, float(top[-1]), end)):
        shear = figure.add_subplot(grid[0, place])
        moment = figure.add_subplot(grid[1, place], sharex=shear)
        _draw_curve(shear, moment, curve, limit)
        shear.set_title(heading)
        moment.set_title("moment at the base")
        if place == 0:
            _name_openings(shear, curve, limit)
        for axes, letters in ((shear, "ab"), (moment, "cd")):
            tidy(axes)
            axes.set_title(f"({letters[place]}) {axes.get_title(loc='left')}", loc="left", fontsize=10)
            axes.set_xlim(left=0.0)
            axes.set_ylim(bottom=0.0)
        if curve.pattern is None:
            _show_acceleration(shear, _mass(curve.model))
    # the column at the largest push, magnified
    drawn = figure.add_subplot(grid[:, 2])
    moved = float(top[strongest])
    wanted = SHOWN * sum(block.height for block in curve.model.blocks) / moved if moved > LEAST_MOVED else 1.0
    scale = max(1.0, float(f"{wanted:.0e}"))
    places = DisplacementHistories(curve.model, curve.ux[: strongest + 1], curve.uz, curve.ry)
    draw_column(drawn, places, strongest, scale)
    measure_column(drawn, places, strongest, scale)
    drawn.set_title("(e) at the largest push", loc="left", fontsize=10)
    steady = "a steady acceleration" if curve.pattern is None else "loads"
    unit, named = curve.unit
    push = f"{curve.largest_acceleration / unit:.4g} {named}, the top moved by {length(float(top[strongest]))}"
    steady += f" towards {curve.towards}" if curve.pattern is None and curve.model.off_axis else ""
    header(figure, f"{curve.model.name}: balance under {steady}", f"It balances {curve.limit} {push}.")
    return save(figure, path)


def _draw_curve(shear: Axes, moment: Axes, curve: CapacityCurve, limit: float) -> None:
    """Draw base shear and moment up to a top displacement `limit` (m), with dots where joints open."""
    strongest, top = curve.strongest, curve.direction * curve.ux[:, 0]
    factor, unit = (1.0, "m") if limit >= 1.0 else (1e3, "mm")
    shown = top <= limit
    for axes, values in ((shear, curve.base_shear), (moment, curve.base_moment)):
        axes.plot(factor * top[shown], 1e-3 * values[shown], color=BLUE)
        axes.plot(factor * top[strongest], 1e-3 * values[strongest], "o", color=RED)
        for k in _openings(curve).values():
            axes.plot(factor * top[k], 1e-3 * values[k], "o", color="black", markersize=3.5)
    shear.set(ylabel="base shear (kN)")
    moment.set(xlabel=f"displacement of the top ({unit})", ylabel="base moment (kN m)")


def _openings(curve: CapacityCurve) -> dict[int, int]:
    """Return the row of the curve at which each joint opens, by the number of the joint, from 1."""
    rising = curve.acceleration[: curve.strongest + 1]
    return {i + 1: int(np.argmin(np.abs(rising - push))) for i, push in enumerate(curve.uplift) if math.isfinite(push)}


def _name_openings(shear: Axes, curve: CapacityCurve, limit: float) -> None:
    """Label the joints that open, one below the other, with lines to their dots."""
    factor = 1.0 if limit >= 1.0 else 1e3
    opened = sorted(_openings(curve).items(), key=lambda item: -curve.base_shear[item[1]])
    if not opened:
        return
    reach = 1e-3 * float(np.max(curve.base_shear))
    wanted = [1e-3 * float(curve.base_shear[k]) for _, k in opened]
    gap = min(0.075 * reach, 0.8 * reach / len(opened))
    for (joint, k), place, height in zip(opened, spread(wanted, gap, 0.5 * gap, 0.9 * reach), wanted, strict=True):
        dot = factor * curve.direction * float(curve.ux[k, 0]), height
        name = f"joint {joint} opens, {curve.acceleration[k] / curve.unit[0]:.3g} {curve.unit[1]}"
        line = {"arrowstyle": "-", "color": GREY, "linewidth": 0.6}
        line |= {"shrinkA": 0.0, "shrinkB": 2.0, "relpos": (0.0, 0.5)}
        shear.annotate(name, dot, (0.3 * factor * limit, place), fontsize=7, va="center", arrowprops=line)


def spread(wanted: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Return heights for labels near the wanted ones, from the highest down, at least `gap` apart.

    They lie between `low` and `high` if there is room.
    """
    places: list[float] = []
    for height in wanted:
        places.append(min(height, high if not places else places[-1] - gap))
    floor = low
    for k in range(len(places) - 1, -1, -1):
        places[k] = max(places[k], floor)
        floor = places[k] + gap
    return places


def _show_acceleration(shear: Axes, mass: float) -> None:
    """Add an axis on the right that shows the base shear as an acceleration of the whole mass (kg)."""
    beside = shear.secondary_yaxis(
        "right",
        functions=(
            lambda force: 1e3 / (mass * STANDARD_GRAVITY) * np.asarray(force),
            lambda push: 1e-3 * mass * STANDARD_GRAVITY * np.asarray(push),
        ),
    )
    beside.set_ylabel("acceleration (g)")


def _mass(column: Column) -> float:
    return sum(block.mass for block in column.blocks)
