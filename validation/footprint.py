"""A rock as a block of a structure in space: the mesh of its scan, standing on a foot of another size."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from multiblock import InputError, Structure
from solver.models.structure.hull_tables import with_hulls
from solver.statics.rocking import damping_on_edge

from .rigid_block import FloatArray
from .rims import WHOLE

MILLIMETRES = 10.0  # a scan that is higher than this, m, is in mm


@dataclass(frozen=True)
class Rock:
    """The table of a block that has the mass properties, the hull and the foot of the scan."""

    table: dict[str, Any]

    def structure(
        self, scale: float, stiffness: float, damping: float, friction: float, rim: float | None = None
    ) -> Structure:
        """Return the rock on the base, its foot larger by `scale` about the point below the centroid.

        rim: width over that of the foot of a rim in which it touches, as stiff in all as the whole foot and critically
        damped. The width of the foot is that of the square which has its area over its perimeter.
        """
        below = np.array(self.table["centroid"][:2])
        foot = below + scale * (self.foot - below)
        law = {"stiffness": stiffness, "damping": damping, "friction": friction}
        table = {"name": "rock", "joints": law, "block": [{**self.table, "foot": foot.tolist()}]}
        whole = Structure.from_dict(table)
        if rim is None:
            return whole
        area = whole.joints[0].face.moments[0]
        sides = np.roll(foot, -1, axis=0) - foot
        width = 4.0 * area / float(np.sum(np.hypot(*sides.T)))
        table["joints"] = law | {"rim": min(rim, WHOLE) * width}
        inside = Structure.from_dict(table).joints[0].inside
        law["stiffness"] = stiffness * area / (area - inside.moments[0]) if inside is not None else stiffness
        block = whole.blocks[0]
        inertia = 0.5 * float(np.trace(block.inertia[:2, :2]))
        edge = min(rim, WHOLE) * width**2
        law["damping"] = damping_on_edge(law["stiffness"], edge, block.mass, inertia, 0.5 * width)
        table["joints"] = law | ({"rim": rim * width} if rim < WHOLE else {})
        return Structure.from_dict(table)

    @property
    def foot(self) -> FloatArray:
        """Its corners as scanned, (corners, 2) m."""
        return np.array(self.table["foot"])


def rock_from(path: Path, mass: float, level: float) -> Rock:
    """Return the rock of a scan (OBJ) of uniform density as it is stored, z up; its foot: the hull of points within
    `level` m.

    A scan without faces is taken as its convex hull. Raises InputError.
    """
    points, has_faces = scan(path)
    high = float(np.ptp(points[:, 2]))
    unit = 1e-3 if high > MILLIMETRES else 1.0
    table: dict[str, Any] = {"name": "rock", "on": "base", "mass": mass, "level": level / (unit * high)}
    if has_faces:
        table |= {"shape": "mesh", "file": str(path), "unit": unit, "up": "z"}
    else:
        corners = unit * points
        table |= {"shape": "hull", "points": corners.tolist()}
    made, _ = with_hulls({"block": [table]})
    return Rock(made["block"][0])


def scan(path: Path) -> tuple[FloatArray, bool]:
    """Return the vertices (n, 3) of a scan, in its own unit, and whether it has faces. Raises InputError."""
    if not path.is_file():
        raise InputError(f"{path}: no such file, though the folder of the data is there")
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    rows = [line.split()[1:4] for line in lines if line.startswith("v ")]
    if len(rows) < 4:
        raise InputError(f"{path}: must have at least four lines `v x y z`")
    return np.array(rows, dtype=np.float64), any(line.startswith("f ") for line in lines)
