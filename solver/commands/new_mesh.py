"""The option `new --mesh`: writes the structure of one mesh on the ground, and reports the geometry of its foot."""

from __future__ import annotations

import argparse
import json
import math
import os
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..common.errors import check_number, reading
from ..common.files import check_file_name, check_outputs, whole_file
from ..common.ranges import check_choice
from ..models.column.materials import MATERIALS
from ..models.structure.blocks.hulls import bulk_of, convex_surface, feet_of, middle_of
from ..models.structure.blocks.parts import Solid
from ..models.structure.hull_tables import FACTOR, in_folder
from ..models.structure.model import Structure
from .command_files import check_suffix
from .new_structures import bounce_damping

DAMPING = 1e-3  # s, until mass and foot are known
HOLLOW = 1.05  # times its volume: for a larger hull, convex parts are suggested
TURN = 22.5  # degrees between the directions listed for a foot with many edges


class Edge(NamedTuple):
    """An edge of a foot, over which a block may tip."""

    direction: float  # of the outward normal, degrees from x to y
    lever: float  # lever arm of the weight about the edge, m; below 0: the block tips over it
    slenderness: float  # angle from the vertical of the line from the edge to the centroid, rad

    @property
    def line(self) -> str:
        """The row of a table for the terminal."""
        return f"{self.direction:13.1f} {self.lever:12.4f} {self.slenderness:13.4f} {math.tan(self.slenderness):14.4f}"


def edges_of(block: Solid, feet: int = 1) -> list[Edge]:
    """Return the edges of the hull of a block's feet, which are the first of its faces, sorted by direction."""
    points = np.concatenate([face.points() for face in block.faces[:feet]])
    corners = feet_of(points, float(np.ptp(points[:, 2])))[0] - block.centroid[:2]  # anticlockwise from above
    side = np.roll(corners, -1, axis=0) - corners
    out = np.column_stack([side[:, 1], -side[:, 0]]) / np.hypot(*side.T)[:, None]
    lever = np.sum(out * corners, axis=1)
    height = float(block.centroid[2] - block.faces[0].centre[2])
    found = [
        Edge(math.degrees(math.atan2(y, x)) % 360.0, float(arm), math.atan2(float(arm), height))
        for (x, y), arm in zip(out, lever, strict=True)
    ]
    return sorted(found)


def new_from_mesh(options: argparse.Namespace, path: Path) -> None:
    """Write the file, print its geometry, and draw it if matplotlib is installed. Raises InputError."""
    mesh: Path = options.mesh
    picture = path.with_suffix(".png")
    check_suffix(path, ".toml")
    check_outputs((path, picture), (mesh,), options.force)
    name = check_file_name("name", path.stem)
    check_choice("--material", options.material, tuple(MATERIALS))
    check_number("--unit", options.unit, *FACTOR)
    # height, then damping, follow from the geometry: parse the file with trial values first
    given = name, os.path.relpath(mesh, path.parent), options
    structure = _structure(mesh_text(*given, height=1.0), path.parent)
    height = float(np.ptp(structure.blocks[0].corners[:, 2]))
    structure = _structure(mesh_text(*given, height=height), path.parent)
    text = mesh_text(*given, height=height, damping=bounce_damping(structure))
    with reading(path):
        structure = _structure(text, path.parent)
        with whole_file(path) as beside:
            beside.write_text(text, encoding="utf-8")
    print("\n".join(facts_of(structure)))
    # picture, if matplotlib is installed
    try:
        from ..plotting.structures import structure_picture
        from ..plotting.style import save
    except ModuleNotFoundError:
        print(f"{path}. Next:")
    else:
        save(structure_picture(structure), picture)
        print(f"{path}, {picture}. Next:")
    print(f"  multiblock check {path} --spectrum ec8 --ag 0.25 --soil B --report report.html")


def facts_of(structure: Structure) -> list[str]:
    """Return lines on mass, centroid, foot and slenderness of the only block of a structure."""
    block = structure.blocks[0]
    feet = block.faces[: len(structure.joints)]
    edges = edges_of(block, len(feet))
    x, y, z = (float(part) for part in block.centroid - middle_of(feet))
    least = min(edges, key=lambda edge: edge.slenderness)
    high, count = float(np.ptp(block.corners[:, 2])), len(block.surface)
    # support
    if len(feet) == 1:
        stands = f"foot: {len(feet[0].outline)} corners, {feet[0].moments[0]:.4g} m2, least width {feet[0].width:.4g} m"
    else:
        area = sum(float(foot.moments[0]) for foot in feet)
        stands = f"feet: {len(feet)}, {area:.4g} m2 in all; it tips over the {len(edges)} edges around them"
    lines = [
        f"{structure.name}: {block.mass:.5g} kg, {block.volume:.5g} m3, {high:.4g} m high, {count} triangles",
        f"centroid: {z:.4g} m over the foot, {x:.4g} m along x and {y:.4g} m along y from its middle",
        stands,
        *_hull_volume_lines(block),
        "direction (deg)    lever (m)  slenderness (rad)  tips at (g)",
    ]
    # directions in which it tips
    shown = edges if len(edges) <= 360.0 / TURN else [_nearest(edges, turn) for turn in np.arange(0.0, 360.0, TURN)]
    lines += [edge.line for edge in dict.fromkeys(shown)]
    lines.append(f"least: {least.slenderness:.4g} rad towards {least.direction:.4g} degrees from x")
    if least.lever <= 0.0:
        lines.append(
            "  It does not stand: its centroid is not over its foot. Give foot = [[x, y], ...] or another level."
        )
    return lines


def _hull_volume_lines(block: Solid) -> list[str]:
    """Return lines on the volume of a block's convex hull, or of its convex parts, relative to its own."""
    around = bulk_of(convex_surface(block.corners)).volume / block.volume
    if block.parts:
        corners = (np.concatenate([face.points() for face in part]) for part in block.parts)
        together = sum(bulk_of(convex_surface(points)).volume for points in corners) / block.volume
        return [
            f"others meet {len(block.parts)} convex parts of it, together of {together:.3g} times its volume; "
            f"its convex hull has {around:.3g}"
        ]
    line = f"others meet its convex hull, of {around:.3g} times its volume"
    return [line] if around < HOLLOW else [f"{line}; with parts = 8 in the file convex parts of it instead"]


def _nearest(edges: list[Edge], direction: float) -> Edge:
    """Return the edge whose direction is nearest to `direction`, degrees."""
    return min(edges, key=lambda edge: abs((edge.direction - direction + 180.0) % 360.0 - 180.0))


def mesh_text(name: str, file: str, options: argparse.Namespace, height: float, damping: float = DAMPING) -> str:
    """Return the text of the file of a structure from the path of a mesh and the options of `new` on it.

    `height` is that of the mesh (m), from which the modulus of its joint follows, `damping` that of the joint (s).
    """
    found, up, feet, parts = MATERIALS[options.material], options.up, options.feet, options.parts
    lines = [
        f"# A block from the mesh {Path(file).name}. Lengths in m, masses in kg.",
        f"# {options.material}: {found.source}",
        "# Better than any table: measure a natural frequency, and choose the stiffness by `multiblock modes`.",
        f'name = "{name}"',
        "",
        "[joints]                     # under the block",
        f"stiffness = {found.modulus(height):.4g}        # N/m3, of the material over its height, and a dry joint",
        f"damping = {damping!r}          # s, eta = 2 sqrt(m / (k A)), critical as it bounces: no measured value",
        f"friction = {found.friction!r}",
        f"strength = {found.strength!r}      # Pa, with which `multiblock check` compares the pressure",
        "",
        "[[block]]",
        'name = "statue"',
        'shape = "mesh"',
        f"file = {json.dumps(Path(file).as_posix())}",
        f"unit = {options.unit!r}                  # m of a unit of the mesh",
        *([f'up = "{up}"                     # axis of the mesh'] if up else []),
        'on = "base"',
        f"density = {found.density!r}",
        *(["repair = true                # triangles that look the wrong way are turned"] if options.repair else []),
        *([f"feet = {feet}                     # groups of the points that bear"] if feet != 1 else []),
        *([f"parts = {parts}                    # convex ones that others meet, at most"] if parts is not None else []),
        "# foot = [[x, y], ...]       # m; else the points within level = 1e-3 of its height of the lowest",
    ]
    return "\n".join(lines) + "\n"


def _structure(text: str, folder: Path) -> Structure:
    return Structure.from_dict(in_folder(tomllib.loads(text), folder))
