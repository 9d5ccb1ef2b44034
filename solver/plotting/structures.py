"""Structures in space on 3D axes: blocks, walls, bearings, ground and a scale."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.patheffects import withStroke
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.proj3d import proj_transform

from ..models.structure.blocks.faces import FloatArray
from ..models.structure.blocks.parts import SpatialJoint
from ..models.structure.model import Structure
from .scene.bodies import normal_of, parts_of, walls_of
from .solids import EDGE, Solids, towards_viewer
from .style import GREY, Figure, nice

VISIBLE = 0.08  # of the extent: largest deformation in a picture
MARGIN, BAR = 0.06, 0.2  # of the extent: ground around the blocks, longest bar of the scale
FILLED = 0.96  # of the axes
GROUND, WALL = "#e9e6df", "#d9d5cb"
BEARING, SIDES, FLAT = "#4f4a44", 24, 0.3  # colour; points of its rim; ratio of height to diameter if not on the base


def structure_picture(structure: Structure, size: float = 5.0) -> Figure:
    """Draw the structure as built, on a square of this size, in."""
    figure = Figure(figsize=(size, size), layout="constrained")
    zero = np.zeros((structure.n, 3))
    draw_blocks(figure.add_subplot(projection="3d"), structure, zero, zero)
    return figure


def draw_blocks(
    axes: Any, structure: Structure, u: FloatArray, turn: FloatArray, room: FloatArray | None = None
) -> Solids:
    """Draw displaced blocks on 3D axes, with ground, walls, bearings and a scale.

    Parameters
    ----------
    axes : Axes3D
    structure : Structure
    u : array (n, 3)
        Displacements of the centroids, m.
    turn : array (n, 3)
        Rotations, axis times angle, rad.
    room : array (points, 3), optional
        Further points that must lie within the axes, m.

    Returns
    -------
    Solids
        The artist of the blocks.
    """
    solids = Solids(parts_of(structure)[0])
    solids.place(u, turn)
    axes.set_proj_type("ortho")
    axes.view_init(elev=18, azim=-62)
    axes.computed_zorder = False
    axes.add_collection(solids, autolim=False)
    # limits that hold blocks, walls, ground and `room`
    walls = [wall.centroid + wall.surfaces[0].points for wall in walls_of(structure)]
    corners = np.concatenate([solids.points, *walls, *([] if room is None else [room])])
    low, high = corners.min(axis=0), corners.max(axis=0)
    low[2] = min(low[2], 0.0)
    largest = float(np.max(high - low))
    margin = MARGIN * largest * np.array([1.0, 1.0, 0.0])
    low, high = low - margin, high + margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    # zoom at which the projected box fills the axes
    flat = axes.transLimits.transform(np.column_stack(proj_transform(*_box(low, high).T, axes.get_proj())[:2]))
    axes.set_box_aspect(high - low, zoom=FILLED / float(np.max(np.ptp(flat, axis=0))))
    axes.set_axis_off()
    # ground, walls, bearings and scale
    x, y = np.array([low[0], high[0], high[0], low[0]]), np.array([low[1], low[1], high[1], high[1]])
    ground = Poly3DCollection([np.column_stack([x, y, np.zeros(4)])], facecolors=GROUND, edgecolors="0.75", zorder=0.5)
    axes.add_collection3d(ground, autolim=False)
    for wall in walls:
        axes.add_collection3d(_wall(wall, axes), autolim=False)
    for joint in structure.bearings:
        moved = u[joint.lower] if joint.lower < structure.n else np.zeros(3)
        axes.add_collection3d(_bearing(joint, moved, joint.lower == structure.n), autolim=False)
    _measure(axes, np.array([low[0], low[1], 0.0]), nice(BAR * largest))
    return solids


def _wall(points: FloatArray, axes: Any) -> Poly3DCollection:
    """Return a wall: filled behind all blocks, or, seen from behind, its edges in front of them."""
    behind = float(normal_of(points) @ towards_viewer(axes)) > 0.0
    colour, order = (WALL, 0.6) if behind else ("none", 2.0)
    return Poly3DCollection([points], facecolors=colour, edgecolors=EDGE, linewidths=0.6, zorder=order)


def _bearing(joint: SpatialJoint, moved: FloatArray, on_base: bool) -> Poly3DCollection:
    """Return a bearing as a flat drum below its centre, behind all blocks; `moved`: displacement of its support, m."""
    high = joint.face.points(SIDES) + moved
    low = high - FLAT * 2.0 * joint.face.radius * joint.face.normal
    if on_base:
        low[:, 2] = 0.0
    sides = [np.array([low[k - 1], low[k], high[k], high[k - 1]]) for k in range(len(low))]
    return Poly3DCollection(sides, facecolors=BEARING, edgecolors=BEARING, linewidths=0.3, zorder=0.7)


def _box(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the corners of a box, (8, 3)."""
    return np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)


def _measure(axes: Any, corner: FloatArray, length: float) -> None:
    """Draw bars of one length along the three axes from a corner of the ground, and label them."""
    for k, name in enumerate("xyz"):
        end = corner + length * np.eye(3)[k]
        axes.plot(*zip(corner, end, strict=True), color=GREY, linewidth=1.6, zorder=0.8, solid_capstyle="round")
        text = f"{name}, {length:g} m" if k == 0 else name
        place = ("left", "top") if k == 0 else ("center", "bottom")
        halo = [withStroke(linewidth=2.5, foreground="white")]  # the edge of the ground would strike it through
        axes.text(*end, text, color=GREY, fontsize=8, ha=place[0], va=place[1], zorder=3.0, path_effects=halo)


def all_corners(structure: Structure) -> FloatArray:
    """Return the corners of all blocks as built, (points, 3) m."""
    return np.concatenate([block.corners for block in structure.blocks])


def extent_of(structure: Structure) -> float:
    """Return the largest extent of a structure along an axis, m."""
    return max(float(np.max(np.ptp(all_corners(structure), axis=0))), 1e-9)


def visible_scale(structure: Structure, u: FloatArray) -> float:
    """Return a factor, 1 or more, that makes displacements (m) visible in a picture of the structure."""
    return max(1.0, nice(VISIBLE * extent_of(structure) / max(float(np.max(np.abs(u))), 1e-12)))
