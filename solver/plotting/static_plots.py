"""Pictures of a column at rest: its modes, its capacity curve. Imported late, for matplotlib."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes

from ..column.column import Column
from ..column.packing import FloatArray
from ..ground.motion import STANDARD_GRAVITY
from .drawable import Shapes
from .drawings import SHOWN, draw_column
from .figures import Figure
from .plots import FEW_COLOURS, save

SMALL = 1e-6  # m: the amplitude of shapes, which drawings magnify
TURNED, RAISED = 0.3, 0.1  # rad, and part of the lowest block's height: largest rotation and rise of a drawn shape
CURVE, MARK = FEW_COLOURS[0], FEW_COLOURS[1]


class DrawableModes(Shapes, Protocol):
    """The fields needed of Modes."""

    @property
    def frequency(self) -> FloatArray: ...
    @property
    def damping_ratio(self) -> FloatArray: ...
    @property
    def sways(self) -> Any: ...
    @property
    def mass_x(self) -> FloatArray: ...
    @property
    def mass_z(self) -> FloatArray: ...


class DrawableCurve(Shapes, Protocol):
    """The fields needed of a CapacityCurve."""

    @property
    def acceleration(self) -> FloatArray: ...
    @property
    def base_shear(self) -> FloatArray: ...
    @property
    def base_moment(self) -> FloatArray: ...
    @property
    def uplift(self) -> FloatArray: ...
    @property
    def direction(self) -> int: ...
    @property
    def strongest(self) -> int: ...
    @property
    def largest_acceleration(self) -> float: ...


@dataclass(frozen=True, eq=False)
class _Places:
    """Rows of places of a column, for `drawings`."""

    column: Column
    ux: FloatArray
    uz: FloatArray
    theta: FloatArray


def plot_modes(modes: DrawableModes, path: str | os.PathLike[str] | None = None, most: int = 6) -> Figure:
    """Draw the first `most` shapes; saved to `path` if given. Raises InputError, OSError as `save` does."""
    count = min(most, len(modes.frequency))
    figure = Figure(figsize=(1.0 + 2.1 * count, 5.6), layout="constrained")
    height = sum(block.height for block in modes.column.blocks)
    for k, axes in enumerate(np.atleast_1d(figure.subplots(1, count))):
        ux, uz, theta = (SMALL * np.atleast_2d(values[k]) for values in (modes.ux, modes.uz, modes.theta))
        limits = (
            (SHOWN * height, ux),
            (TURNED, theta),
            (RAISED * min(block.height for block in modes.column.blocks), uz),
        )
        scale = min(most / max(float(np.max(np.abs(values))), 1e-300) for most, values in limits)
        for patch in draw_column(axes, _Places(modes.column, ux, uz, theta), 0, scale):
            patch.set_alpha(0.85)
        mass = modes.mass_x[k] if modes.sways[k] else modes.mass_z[k]
        moving = f"{'horizontal' if modes.sways[k] else 'vertical'} mass {abs(mass) / _mass(modes.column):.1%}"
        damped = f"damping {modes.damping_ratio[k]:.2%}"
        axes.set_title(f"{k + 1}: {modes.frequency[k]:.4g} Hz\n{damped}\n{moving}", fontsize=9)
    figure.suptitle(f"{modes.column.name}: modes about rest")
    return save(figure, path)


def plot_capacity(curve: DrawableCurve, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw base shear and moment over the top's displacement, and the column at its largest push; saved to `path`.

    Raises InputError, OSError as `save` does.
    """
    figure = Figure(figsize=(10.0, 6.4), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=(1.15, 1.15, 1.0))
    strongest = curve.strongest
    top = curve.direction * curve.ux[:, 0]
    near = max(4.0 * float(top[strongest]), 1e-9)
    mass = _mass(curve.column)
    for place, limit, heading in ((0, near, "up to the largest push and beyond"), (1, float(top[-1]), "to the edge")):
        shear = figure.add_subplot(grid[0, place])
        moment = figure.add_subplot(grid[1, place], sharex=shear)
        factor, unit = (1.0, "m") if limit >= 1.0 else (1e3, "mm")
        shown = top <= limit
        shear.plot(factor * top[shown], 1e-3 * curve.base_shear[shown], color=CURVE)
        moment.plot(factor * top[shown], 1e-3 * curve.base_moment[shown], color=CURVE)
        shear.plot(factor * top[strongest], 1e-3 * curve.base_shear[strongest], "o", color=MARK)
        for i, push in enumerate(curve.uplift):
            if math.isfinite(push):
                k = int(np.argmin(np.abs(curve.acceleration[: strongest + 1] - push)))
                shear.plot(factor * top[k], 1e-3 * curve.base_shear[k], "o", color="black", markersize=3.5)
                if place == 0:
                    name = f"joint {i + 1} opens"
                    shear.annotate(
                        name,
                        (factor * top[k], 1e-3 * curve.base_shear[k]),
                        (6.0, -3.0),
                        textcoords="offset points",
                        fontsize=7,
                    )
        beside = shear.secondary_yaxis(
            "right",
            functions=(
                lambda force: 1e3 / (mass * STANDARD_GRAVITY) * np.asarray(force),
                lambda push: 1e-3 * mass * STANDARD_GRAVITY * np.asarray(push),
            ),
        )
        beside.set_ylabel("acceleration (g)")
        shear.set_title(f"({'ab'[place]}) {heading}", loc="left", fontsize=10)
        shear.set_ylabel("base shear (kN)")
        moment.set(xlabel=f"displacement of the top ({unit})", ylabel="base moment (kN m)")
        for axes in (shear, moment):
            _plain(axes)
    drawn = figure.add_subplot(grid[:, 2])
    wanted = SHOWN * sum(block.height for block in curve.column.blocks) / max(float(top[strongest]), 1e-300)
    scale = max(1.0, float(f"{wanted:.0e}"))
    draw_column(drawn, _Places(curve.column, curve.ux[: strongest + 1], curve.uz, curve.theta), strongest, scale)
    drawn.set_title(
        f"(c) at {curve.largest_acceleration / STANDARD_GRAVITY:.4g} g: top at {1e3 * top[strongest]:.4g} mm\n"
        f"deformation times {scale:g}",
        fontsize=9,
    )
    figure.suptitle(f"{curve.column.name}: balance under a steady acceleration")
    return save(figure, path)


def _plain(axes: Axes) -> None:
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top"]].set_visible(False)


def _mass(column: Column) -> float:
    return sum(block.mass for block in column.blocks)
