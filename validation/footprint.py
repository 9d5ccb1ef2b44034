"""A rock as a structure in space: mass properties of its scan, and the face that it stands on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from multiblock import InputError, Structure
from solver.models.structure.blocks.contacts import GROUND
from solver.models.structure.blocks.faces import Face, polygon_moments
from solver.models.structure.blocks.parts import Bed, Joint, Solid

from .rigid_block import FloatArray

MILLIMETRES = 10.0  # a scan that is higher than this, m, is in mm


@dataclass(frozen=True)
class Rock:
    """mass kg; inertia kg m2 about the centroid; height m of the centroid; foot (corners, 2) m from below it."""

    mass: float
    inertia: FloatArray
    height: float
    foot: FloatArray

    def structure(self, scale: float, stiffness: float, damping: float, friction: float) -> Structure:
        """The rock on the base, its foot larger by `scale` about the point below the centroid."""
        points = scale * self.foot
        area, first, _ = polygon_moments(points)
        middle = first / area
        foot = Face(np.array([*middle, 0.0]), np.eye(3), points - middle)
        top = Face(np.array([0.0, 0.0, 2.0 * self.height]), np.eye(3), points - middle)  # says how high it is
        solid = Solid("rock", self.mass, np.array([0.0, 0.0, self.height]), self.inertia, (top, foot))
        bed = Bed(stiffness, damping, friction=friction)
        return Structure("rock", (solid,), (Joint(0, 1, foot, bed, "", foot, GROUND),))


def rock_from(path: Path, mass: float, level: float) -> Rock:
    """The rock of a scan (OBJ) of uniform density as it is stored, z up; its foot: the hull of points within `level` m.

    A scan without faces is taken as its convex hull. Raises InputError.
    """
    vertices, faces = scan(path)
    volume, centroid, second = mass_properties(vertices, faces)
    bottom = float(np.min(vertices[:, 2]))
    low = vertices[vertices[:, 2] < bottom + level, :2] - centroid[:2]
    foot = low[ConvexHull(low).vertices]
    inertia = mass / volume * (np.trace(second) * np.eye(3) - second)
    return Rock(mass, inertia, float(centroid[2]) - bottom, foot)


def scan(path: Path) -> tuple[FloatArray, np.ndarray]:
    """Vertices, m, and triangles, with their outside anticlockwise or all clockwise. Raises InputError."""
    if not path.is_file():
        raise InputError(f"{path}: no such file, though the folder of the data is there")
    rows: dict[str, list[list[str]]] = {"v": [], "f": []}
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        kind, *words = line.split() or [""]
        if kind in rows and len(words) >= 3:
            rows[kind].append(words[:3])
    if len(rows["v"]) < 4:
        raise InputError(f"{path}: must have at least four lines `v x y z`")
    vertices = np.array(rows["v"], dtype=np.float64)
    vertices = 1e-3 * vertices if np.ptp(vertices[:, 2]) > MILLIMETRES else vertices
    if rows["f"]:
        return vertices, np.array([[int(word.partition("/")[0]) - 1 for word in row] for row in rows["f"]])
    hull = ConvexHull(vertices)
    corners = vertices[hull.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0.0
    return vertices, np.where(inside[:, None], hull.simplices[:, ::-1], hull.simplices)


def mass_properties(vertices: FloatArray, faces: np.ndarray) -> tuple[float, FloatArray, FloatArray]:
    """Volume m3, centroid m, and the integrals of x_i x_j about it, m5, of a closed surface of triangles."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0  # tetrahedra with the origin
    volume = float(np.sum(parts))
    total = a + b + c
    centroid = np.einsum("i,ij->j", parts, total) / (4.0 * volume)
    products = sum(np.einsum("i,ij,ik->jk", parts, corner, corner) for corner in (a, b, c, total)) / 20.0
    second = np.asarray(products) - volume * np.outer(centroid, centroid)
    return abs(volume), centroid, second if volume > 0.0 else -second
