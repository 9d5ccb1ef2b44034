"""Modes of vibration of a structure in space about its rest, weight included."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..common.errors import InputError
from .blocks.faces import FloatArray
from .rest import full_stiffness, rest_of
from .structure import Structure


@dataclass(frozen=True, eq=False)
class SpatialModes:
    """The 6 n modes of a structure by frequency; joints that are partly open at rest stay so.

    Shapes (6 n, n, 3): displacements of the centroids, m, and rotations, rad, scaled so that the largest displacement,
    or rotation times the size of its block, is 1 m. mass (6 n, 6): effective masses along x, y, z, kg, and inertias
    about axes through the origin, kg m2.
    """

    structure: Structure
    frequency: FloatArray  # (6 n,) Hz
    displacement: FloatArray
    rotation: FloatArray
    mass: FloatArray

    @property
    def twists(self) -> FloatArray:
        """Part of the mass moment of inertia about the vertical axis of the structure that each mode moves, (6 n,)."""
        return self.mass[:, 5] / float(np.sum(self.mass[:, 5]))


def modes_in_space(structure: Structure) -> SpatialModes:
    """Modes about rest. Raises InputError for a structure that has no stable rest."""
    n = structure.n
    stiffness = rest_of(structure).stiffness if structure.weight > 0.0 else full_stiffness(structure)
    root = np.zeros((6 * n, 6 * n))
    for i, block in enumerate(structure.blocks):
        at = 6 * i
        root[at : at + 3, at : at + 3] = np.eye(3) * math.sqrt(block.mass)
        root[at + 3 : at + 6, at + 3 : at + 6] = np.linalg.cholesky(block.inertia)
    inverse = np.linalg.inv(root)
    squares, vectors = np.linalg.eigh(inverse @ (0.5 * (stiffness + stiffness.T)) @ inverse.T)
    if squares[0] <= 0.0:
        raise InputError(f"{structure.name}: its rest is not stable, it falls without any motion")
    shapes = inverse.T @ vectors
    mass = (_rigid(structure).T @ root @ vectors).T ** 2
    parts = shapes.T.reshape(6 * n, n, 6)
    sizes = np.array([block.size for block in structure.blocks])[None, :, None]
    largest = np.maximum(np.abs(parts[..., :3]), np.abs(parts[..., 3:]) * sizes).max(axis=(1, 2))
    parts = parts / largest[:, None, None]
    return SpatialModes(structure, np.sqrt(squares) / (2.0 * math.pi), parts[..., :3], parts[..., 3:], mass)


def _rigid(structure: Structure) -> FloatArray:
    """Displacements and rotations of all blocks as the base moves along, or turns about, each axis, (6 n, 6)."""
    found = np.zeros((6 * structure.n, 6))
    for i, block in enumerate(structure.blocks):
        x, y, z = block.centroid
        found[6 * i : 6 * i + 6, :3] = np.eye(6)[:, :3]
        found[6 * i : 6 * i + 6, 3:] = np.vstack([[[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]], np.eye(3)])
    return found
