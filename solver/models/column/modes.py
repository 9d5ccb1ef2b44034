"""Natural frequencies, shapes and damping ratios of the column about its rest, all joints in full contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.aliases import Alias
from ...common.errors import InputError, SolverError, check_type
from ..response import ModeTable
from .linearization import StillColumn, stuck, undamped
from .model import Column
from .packing import FloatArray
from .rest import check_rest

PART = 1e-2  # of the rotation that opens a joint: size of finite differences


@dataclass(frozen=True, eq=False)
class Modes(ModeTable):
    """The 2 n modes of a column, by frequency. Shapes (2 n, n): block 1, the top block, first.

    A shape is scaled so that the largest of its ux and uz is 1 m; block i then has the rotation ry (rad).
    """

    model: Column
    frequency: FloatArray  # (2 n,) Hz, undamped, gravity included
    damping_ratio: FloatArray  # (2 n,) of critical; the coupling of modes by dampers is neglected
    sways: NDArray[np.bool_]  # (2 n,) whether blocks rotate, rather than move up and down
    ux: FloatArray  # m, top faces
    uz: FloatArray  # m, centroids, up
    ry: FloatArray  # rad, clockwise
    mass_x: FloatArray  # (2 n,) kg, effective mass under horizontal motion; the remaining mass follows the base
    mass_z: FloatArray  # (2 n,) kg, under vertical motion
    column, theta = Alias("model"), Alias("ry")
    units = MappingProxyType({"frequency": "Hz", "mass_x": "kg", "mass_z": "kg", "ux": "m", "uz": "m", "theta": "rad"})

    @property
    def _columns(self) -> dict[str, NDArray[Any]]:
        names = ("frequency", "damping_ratio", "sways", "mass_x", "mass_z", "ux", "uz")
        return {name: getattr(self, name) for name in names} | {"theta": self.ry}


def natural_frequencies(column: Column, formulation: str | None = None) -> FloatArray:
    """Compute the undamped natural frequencies (Hz), ascending, (2 n,), gravity included.

    `formulation` replaces that of the column. Raises InputError without gravity, as the joints are then open at rest;
    SolverError if the rest is unstable.
    """
    check_type("column", column, Column)
    _check_bonds(column)
    still = StillColumn(undamped(column.with_settings(formulation=formulation)))
    return np.sort(_frequencies(np.linalg.eigvals(still.stiffness(still.rest, PART))))


def natural_modes(column: Column, formulation: str | None = None) -> Modes:
    """Compute frequencies, shapes, damping ratios and effective masses about rest.

    `formulation` replaces that of the column. Warns (InputWarning) as `simulate` does. Raises as `natural_frequencies`
    does.
    """
    check_type("column", column, Column)
    check_rest(column, from_rest=False)
    return modes_about_rest(column, formulation)


def modes_about_rest(column: Column, formulation: str | None = None) -> Modes:
    """Compute the modes without warnings, for columns whose joints are being identified.

    Raises as `natural_frequencies` does.
    """
    _check_bonds(column)
    column = column.with_settings(formulation=formulation)
    still, damped = StillColumn(undamped(column)), StillColumn(stuck(column))
    n, rest, blocks = column.n, still.rest, still.blocks
    # undamped frequencies, and damping in modal coordinates
    squares, vectors = np.linalg.eig(still.stiffness(rest, PART))
    frequency = _frequencies(squares)
    order = np.argsort(frequency, kind="stable")
    frequency, vectors = frequency[order], vectors[:, order].real
    damping = np.linalg.solve(vectors, damped.damping(rest, PART) @ vectors)
    ux, uz, theta = (np.empty((2 * n, n)) for _ in range(3))
    # shapes, by central differences of the outputs along each mode
    for k in range(2 * n):
        step = PART * vectors[:, k] / np.max(np.abs(vectors[:, k]) / still.sizes)
        ahead, behind = still.row(rest + step).joints, still.row(rest - step).joints
        shape = np.array([getattr(ahead, name) - getattr(behind, name) for name in ("ux", "uz", "theta")])
        # second-order terms in one direction cancel, or are rounding errors
        largest = shape[:2].flat[np.argmax(np.abs(shape[:2]))]
        ux[k], uz[k], theta[k] = shape / largest
        vectors[:, k] *= 2.0 * PART / np.max(np.abs(vectors[:, k]) / still.sizes) / largest
    # participation of each mode under a base acceleration of 1 m/s2, and its inertia force
    along = -np.linalg.solve(vectors, still.accelerations(rest, 1.0) - still.accelerations(rest, 0.0))
    upwards = -np.linalg.solve(vectors, still.accelerations(rest, 0.0, az=1.0) - still.accelerations(rest, 0.0))
    # ux of the centroids, which are below the tops along the blocks as they stand
    below, angle = blocks.height - blocks.centroid, still.row(rest).joints.theta + blocks.tilt
    sway = ux - below * np.cos(angle) * theta
    return Modes(
        column,
        frequency,
        np.maximum(np.diag(damping), 0.0) / (4.0 * math.pi * frequency) + 0.0,  # avoids negative zero
        np.max(np.abs(ux), axis=1) > np.max(np.abs(uz), axis=1),
        ux,
        uz,
        theta,
        along * (sway @ blocks.mass),
        upwards * (uz @ blocks.mass),
    )


def _check_bonds(column: Column) -> None:
    """Raise InputError for bonds off the axis; on it, in full contact, bonds change nothing."""
    if column.is_brittle and column.off_axis:
        raise InputError(f"joint.{column.brittle_key}: must be left out of modes of a column off its axis")


def _frequencies(squares: NDArray[Any]) -> FloatArray:
    """Convert eigenvalues of M^-1 K (1/s2) to frequencies (Hz). Raises SolverError if one is not positive."""
    if np.min(squares.real) <= 0.0:
        raise SolverError("the rest state is not stable: the joints are too soft for the weight above them")
    return np.sqrt(squares.real) / (2.0 * math.pi)
