"""A rock as a block of a structure in space: the mesh of its scan, standing on a foot of another size."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from multiblock import InputError, Structure
from solver.models.structure.hull_tables import with_hulls

from .rigid_block import FloatArray

MILLIMETRES = 10.0  # a scan that is higher than this, m, is in mm


@dataclass(frozen=True)
class Rock:
    """The table of a block that has the mass properties, the hull and the foot of the scan."""

    table: dict[str, Any]

    def structure(self, scale: float, stiffness: float, damping: float, friction: float) -> Structure:
        """The rock on the base, its foot larger by `scale` about the point below the centroid."""
        below = np.array(self.table["centroid"][:2])
        foot = below + scale * (self.foot - below)
        law = {"stiffness": stiffness, "damping": damping, "friction": friction}
        return Structure.from_dict({"name": "rock", "joints": law, "block": [{**self.table, "foot": foot.tolist()}]})

    @property
    def foot(self) -> FloatArray:
        """Its corners as scanned, (corners, 2) m."""
        return np.array(self.table["foot"])


def rock_from(path: Path, mass: float, level: float) -> Rock:
    """The rock of a scan (OBJ) of uniform density as it is stored, z up; its foot: the hull of points within `level` m.

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
    """Vertices (n, 3) of a scan, in its own unit, and whether it has faces. Raises InputError."""
    if not path.is_file():
        raise InputError(f"{path}: no such file, though the folder of the data is there")
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    rows = [line.split()[1:4] for line in lines if line.startswith("v ")]
    if len(rows) < 4:
        raise InputError(f"{path}: must have at least four lines `v x y z`")
    return np.array(rows, dtype=np.float64), any(line.startswith("f ") for line in lines)
