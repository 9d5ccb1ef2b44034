"""Drawings of the deformed column at one instant (imported lazily, since matplotlib is optional)."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from ..common.errors import POSITIVE, check_number
from ..models.column.model import Column
from ..models.column.packing import FloatArray
from ..models.column.response import Response
from .largest import length
from .style import GREY, INK, RED, STONE, Figure, header, nice, save
from .words import drawn_larger, setting_of

SHOWN = 0.15  # of the column's height: displacement of its top in a picture whose scale is not given
MOST_NUMBERED = 15  # joints that get a number; of more, every second, third ...
BAR = 0.3  # of the width of a drawing: the longest scale bar
LOST = 0.5  # of the height: displacement at which a column that falls is drawn


class Shapes(Protocol):
    """The histories of the displacements of a column, (rows, n) each: a Response, Modes or a CapacityCurve."""

    @property
    def model(self) -> Column: ...
    @property
    def ux(self) -> FloatArray: ...
    @property
    def uz(self) -> FloatArray: ...
    @property
    def ry(self) -> FloatArray: ...


@dataclass(frozen=True, eq=False)
class DisplacementHistories:
    """The displacement histories of a column, (rows, n) each, without the rest of a response."""

    model: Column
    ux: FloatArray  # m
    uz: FloatArray  # m
    ry: FloatArray  # rad


def plot_model(
    response: Response,
    path: str | os.PathLike[str] | None = None,
    at: float | None = None,
    scale: float | None = None,
) -> Figure:
    """Draw the deformed column relative to its base, and save the figure if `path` is given.

    The figure states the factor on the deformation, with a scale bar, the heights and the numbers of the joints.
    Arguments and errors are those of `Result.plot_model`. By default `at` is the time of the largest abs(ux) of any
    block, of a column that falls the last row before its top has moved by half the height; `scale` is 1, 2 or 5 times a
    power of ten at which the motion is visible, 1 where it is large.
    """
    k = _peak(response) if at is None else row_at(response, at)
    scale = scale_of(response, scale)
    figure = Figure(figsize=(5.4, 7.4), layout="constrained")
    axes = figure.add_subplot()
    draw_column(axes, response, k, scale)
    measure_column(axes, response, k, scale)
    wide, tall = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
    figure.set_size_inches(5.4, min(7.4, 5.3 * tall / wide + 0.8))
    top = int(np.argmax(np.abs(response.ux[k])))
    # state the largest displacement in the header
    line = f"At {response.time[k]:.3f} s the top of block {top + 1} is at {length(float(response.ux[k, top]))}."
    header(figure, setting_of(response.model, response.motion), line)
    return save(figure, path)


def draw_column(axes: Axes, response: Shapes, k: int, scale: float, linewidth: float = 1.0) -> list[Polygon]:
    """Draw one row of a response on axes of equal units, and return the outlines of the blocks.

    Parameters
    ----------
    axes : Axes
    response : Shapes
    k : int
        Index of the row.
    scale : float
        Factor on rotations and openings.
    linewidth : float
        Width of the outlines, points; the ground is drawn three times as thick.

    Returns
    -------
    list of Polygon
        One for each block, from the top down.
    """
    patches = [
        Polygon(corners, facecolor=STONE, edgecolor=INK, linewidth=linewidth)
        for corners in corners_of(response, k, scale)
    ]
    for patch in patches:
        axes.add_patch(patch)
    blocks = response.model.blocks
    height = sum(block.height for block in blocks)
    width = max(max(block.width, block.top_width or 0.0) for block in blocks)
    reach = 0.6 * width + max(SHOWN * height, scale * float(np.max(np.abs(response.ux))))
    axes.axhline(0.0, color=INK, linewidth=3.0 * linewidth)
    axes.plot([0.0, 0.0], [0.0, 1.03 * height], color=INK, linewidth=0.7, linestyle=":")
    side = min(reach, 1.5 * height)
    axes.set(xlim=(-side, side), ylim=(-0.03 * height, 1.1 * height), aspect="equal")
    axes.set_axis_off()
    return patches


def measure_column(axes: Axes, response: Shapes, k: int, scale: float) -> None:
    """Add heights on the left, joint numbers on the right, the factor on the deformation and a scale bar."""
    corners = corners_of(response, k, scale)
    height = sum(block.height for block in response.model.blocks)
    (left, _), (right, top) = np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))
    left, right, low = left - 0.22 * height, right + 0.2 * height, -0.17 * height
    number_joints(axes, corners)
    axes.set(xlim=(left, right), ylim=(low, max(1.04 * height, top + 0.03 * height)))
    axes.text(left, 0.25 * low, drawn_larger(scale), fontsize=11, color=RED, ha="left", va="top")
    # scale bar below that text, its length on its right
    bar = nice(BAR * (right - left) / scale)
    end = left + scale * bar
    axes.plot([left, end], 2 * [0.82 * low], color=RED, linewidth=3.0, solid_capstyle="butt")
    axes.text(end + 0.03 * (right - left), 0.82 * low, f"{length(bar)} of motion", fontsize=9, color=RED, va="center")
    rule_heights(axes, height, left)


def number_joints(axes: Axes, corners: Sequence[FloatArray]) -> None:
    """Write the numbers of the joints on the right of the blocks above them; of many every second, third ..."""
    n, every = len(corners), math.ceil(len(corners) / MOST_NUMBERED)
    for number, outline in enumerate(corners, start=1):
        if (n - number) % every == 0:
            beside = [*outline[:2], *(corners[number][2:] if number < n else ())]  # both faces of the joint
            end = max(beside, key=lambda corner: float(corner[0]))
            text = f"joint {number}" if number <= every else f"{number}"
            above = 6.0 if number == n else 0.0  # the ground would strike it through
            axes.annotate(text, end, (5.0, above), textcoords="offset points", fontsize=9, va="center", color=INK)


def rule_heights(axes: Axes, height: float, place: float) -> None:
    """Draw a scale of heights, m, from the ground to the top of the column as built."""
    every = nice(height / 4.0)
    marks = [every * k for k in range(math.ceil(height / every - 0.5))]
    axes.plot([place, place], [0.0, height], color=GREY, linewidth=1.0)
    for mark in [*marks, height]:
        text = f"{mark:.4g} m" if mark == height else f"{mark:g}"
        axes.plot([place, place + 0.015 * height], [mark, mark], color=GREY, linewidth=1.0)
        axes.text(place + 0.025 * height, mark, text, fontsize=9, color=GREY, va="bottom" if mark == 0.0 else "center")


def corners_of(response: Shapes, k: int, scale: float) -> list[FloatArray]:
    """Return the corners of each block at one row, (4, 2) m, from the top block down.

    At a scale of 1 these are the true positions. The blocks are placed from the base up: the relative displacement of
    the faces of a joint is taken in the frame of the body below, and scaled there.
    """
    found: list[FloatArray] = []
    # centre of the face below: as built, true, drawn; rotations of the body below
    built, foot, drawn = np.zeros(2), np.zeros(2), np.zeros(2)
    tilt_below, turned, turn = 0.0, 0.0, 0.0
    for i in range(response.model.n - 1, -1, -1):
        # angles and top centre of the block as built
        block, theta = response.model.blocks[i], float(response.ry[k, i])
        rise, lean = block.resolved_centroid, block.joint.inclination or 0.0
        tilt = lean + (block.tilt or 0.0)
        offset = (block.joint.offset or 0.0) * _frame(lean)[1]
        built = built + offset + block.height * _frame(tilt)[0]
        # true position of the centroid, from the displacement of the top face
        up = _frame(tilt + theta)[0]
        top_x = built[0] + response.ux[k, i]
        height = built[1] - (block.height - rise) * math.cos(tilt) + response.uz[k, i]
        centroid = np.array([top_x - (block.height - rise) * up[0], height])
        # joint displacement in the frame of the body below; scale only its change since built
        apart = np.array(_frame(turned)) @ (centroid - rise * up - foot)
        apart_built = np.array(_frame(tilt_below)) @ offset
        drawn = drawn + (apart_built + scale * (apart - apart_built)) @ np.array(_frame(turn))
        foot = centroid + (block.height - rise) * up
        # corners at the scaled rotation; oblique faces belong to inclined joints
        tilt_below, turned, turn = tilt, tilt + theta, tilt + scale * theta
        lean_above = (response.model.blocks[i - 1].joint.inclination or 0.0) if i > 0 else tilt
        half = _across(0.5 * block.width, turn, lean - tilt)
        top = _across(0.5 * (block.top_width or block.width), turn, lean_above - tilt)
        tall = block.height * _frame(turn)[0]
        found.append(np.array([drawn - half, drawn + half, drawn + top + tall, drawn - top + tall]))
        drawn = drawn + tall
    return found[::-1]


def _frame(theta: float) -> tuple[FloatArray, FloatArray]:
    """Return the unit vectors of a body turned clockwise by `theta`: up, and along its faces to the right."""
    sine, cosine = math.sin(theta), math.cos(theta)
    return np.array([sine, cosine]), np.array([cosine, -sine])


def _across(half: float, turn: float, oblique: float) -> FloatArray:
    """Return the vector from the middle to the end of a face of a half width, oblique to a body turned by `turn`."""
    return half / math.cos(oblique) * _frame(turn + oblique)[1]


def _peak(response: Response) -> int:
    moved = np.max(np.abs(response.ux), axis=1)
    if response.overturn_time <= response.time[-1]:
        far = np.flatnonzero(moved > LOST * sum(block.height for block in response.model.blocks))
        return max(0, int(far[0]) - 1) if len(far) else len(moved) - 1
    return int(np.argmax(moved))


def row_at(response: Any, at: float) -> int:
    """Return the row of a response that is nearest to a time, s. Raises InputError if it is not one of the run."""
    begin, end = response.time[[0, -1]].tolist()
    at = check_number("at", at, (begin, end), f"a time of the response, {begin:g} to {end:g} s")
    return int(np.argmin(np.abs(response.time - at)))


def check_scale(scale: float) -> float:
    """Return the factor on the deformation if it is valid. Raises InputError otherwise."""
    return check_number("scale", scale, POSITIVE, "a positive factor on the deformation")


def scale_of(response: Shapes, scale: float | None) -> float:
    """Return the factor on the deformation: `scale` if given, else one that makes it visible. Raises InputError."""
    if scale is not None:
        return check_scale(scale)
    largest = float(np.max(np.abs(response.ux)))
    wanted = SHOWN * sum(block.height for block in response.model.blocks) / max(largest, 1e-300)
    return 1.0 if wanted <= 1.0 or largest < 1e-12 else nice(wanted)
