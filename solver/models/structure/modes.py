"""Modes of vibration of a structure in space about its rest under weight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ...common.aliases import Alias
from ...common.errors import InputError, check_type
from ...kernels.structure.layout import OF_BLOCK
from ..outputs import component, places_of
from ..response import ModeTable
from .blocks.faces import FloatArray
from .model import Structure
from .neighbours import NEAR
from .outputs import OUTPUTS, UNITS
from .rest import SpatialRest, closed, deltas_of, full_stiffness, moved_with, residual_of, rest_of, sticking
from .stepper import SpatialStepper

SLIDING_PART = 1e-3  # of the settlement: differences for the tangent while bearings slide
PART = 1e-6  # of the settlement: differences of rates, times 1 / omega of the fastest mode


@dataclass(frozen=True, eq=False)
class SpatialModes(ModeTable):
    """The 6 n modes of a structure by increasing frequency; joints that are partly open at rest stay so.

    Each shape is scaled so that the largest displacement, or rotation times the size of its block, is 1 m.
    """

    model: Structure
    frequency: FloatArray  # (6 n,) Hz
    displacement: FloatArray  # (6 n, n, 3) m, of the centroids
    rotation: FloatArray  # (6 n, n, 3) rad
    mass: FloatArray  # (6 n, 6) effective masses along x, y, z, kg, and inertias about axes through the origin, kg m2
    damping_ratio: FloatArray  # (6 n,) of critical, without coupling of modes; NaN without weight: contacts unknown
    twists: FloatArray  # (6 n,) share of the moment of inertia about the vertical axis through the centroid
    structure = Alias("model")
    units = MappingProxyType({"frequency": "Hz", **dict.fromkeys(("mass_x", "mass_y", "mass_z"), "kg"), **UNITS})

    ux = component("displacement", 0, "The displacements of the centroids along x in each shape, m (6 n, n).")
    uz = component("displacement", 2, "The displacements of the centroids upwards in each shape, m (6 n, n).")
    ry = component("rotation", 1, "The rotations about y in each shape, rad (6 n, n).")
    mass_x = component("mass", 0, "The effective masses along x, kg (6 n,).")
    mass_z = component("mass", 2, "The effective masses along z, kg (6 n,).")

    @property
    def mass_ratio(self) -> FloatArray:
        """The effective masses along x, y, z relative to the mass of the structure, (6 n, 3)."""
        return self.mass[:, :3] / sum(block.mass for block in self.model.blocks)

    @property
    def _columns(self) -> dict[str, FloatArray]:
        found = {"frequency": self.frequency, "damping_ratio": self.damping_ratio}
        found |= {f"mass_{axis}": self.mass[:, k] for k, axis in enumerate("xyz")} | {"twist": self.twists}
        shapes = np.concatenate([self.displacement, self.rotation], axis=2)
        return found | {name: shapes[..., k] for k, name in enumerate(OF_BLOCK)}


def modes_in_space(structure: Structure) -> SpatialModes:
    """Compute the modes of a structure about its rest.

    Ties without slack that bear hardly anything at rest count as taut, as in vibrations larger than the settlement.
    Raises InputError if the structure has no stable rest, or neighbours that touch there.
    """
    check_type("structure", structure, Structure)
    rest = rest_of(structure)
    _check_gaps(structure, rest)
    return _modes(structure, rest)


def _modes(structure: Structure, rest: SpatialRest) -> SpatialModes:
    """Return the modes about a rest; neighbours that touch there stay in contact."""
    n = structure.n
    # eigenvalues of the stiffness scaled by the Cholesky factor of the mass
    root = _root_of_mass(structure)
    inverse = np.linalg.inv(root)
    taut, stiffness = _taut(structure, rest), rest.stiffness if structure.weight > 0.0 else full_stiffness(structure)
    stuck = _at(structure, rest, taut)
    if np.any(taut):
        stiffness = stuck.stiffness(deltas_of(structure, closed(structure)))
    squares, vectors = np.linalg.eigh(inverse @ (0.5 * (stiffness + stiffness.T)) @ inverse.T)
    if squares[0] <= 0.0:
        raise InputError(f"{structure.name}: its rest is not stable, it falls without any motion")
    shapes = inverse.T @ vectors
    omega = np.sqrt(squares)
    # damping ratios: diagonal of the modal damping matrix
    damping = np.full((6 * n, 6 * n), math.nan)
    if structure.weight > 0.0:
        damping = _damping(stuck, float(omega[-1]))
    modal = np.einsum("ik,ij,jk->k", shapes, damping, shapes)
    # effective masses; twist about the vertical axis through the centroid
    # motions of all blocks as the base moves along or turns about each axis
    rigid = np.vstack([moved_with(structure, np.eye(3), block.centroid, n) for block in structure.blocks])
    participation = rigid.T @ root @ vectors
    masses = np.array([block.mass for block in structure.blocks])
    x, y, _ = masses @ np.array([block.centroid for block in structure.blocks]) / np.sum(masses)
    twists = (participation[5] + y * participation[0] - x * participation[1]) ** 2
    # scale of the shapes
    parts = shapes.T.reshape(6 * n, n, 6)
    sizes = np.array([block.size for block in structure.blocks])[None, :, None]
    largest = np.maximum(np.abs(parts[..., :3]), np.abs(parts[..., 3:]) * sizes).max(axis=(1, 2))
    parts = parts / largest[:, None, None]
    frequency, ratio = omega / (2.0 * math.pi), np.maximum(modal, 0.0) / (2.0 * omega)
    mass, twists = participation.T**2, twists / np.sum(twists)
    return SpatialModes(structure, frequency, parts[..., :3], parts[..., 3:], mass, ratio, twists)


def frequencies_at_rest(structure: Structure) -> FloatArray:
    """Return the natural frequencies, Hz (6 n,), as if neighbours that touch at rest stayed in contact.

    Raises InputError if the structure has no stable rest.
    """
    return _modes(structure, rest_of(structure)).frequency


def touching(structure: Structure, rest: SpatialRest) -> NDArray[np.bool_]:
    """Return the mask of pairs of neighbours that touch at rest."""
    return np.asarray(rest.row[places_of(OUTPUTS, structure.sizes)["gap"]] <= NEAR)


def _check_gaps(structure: Structure, rest: SpatialRest) -> None:
    """Raise InputError for neighbours that touch at rest: their contact resists in one direction only."""
    touch = touching(structure, rest).tolist()
    for name, pair, touches in zip(structure.pair_names, structure.neighbours, touch, strict=True):
        if touches:
            one, other = structure.names[pair.one], name.removeprefix(f"{structure.names[pair.one]}-")
            raise InputError(
                f"{structure.name}: {one} and {other} touch at rest, modes need a gap between them, or no [neighbours]"
            )


def sliding_frequencies(structure: Structure) -> FloatArray:
    """Return the natural frequencies while all bearings slide or yield, Hz (6 n,).

    Pendulums act under their weight, rubber without its initial stiffness; 0 where there is no restoring force. Raises
    InputError if the structure has no stable rest.
    """
    rest = rest_of(structure)
    stuck = _at(structure, rest, np.zeros(len(structure.ties), dtype=bool))
    stuck.model.joints.shear[len(structure.joints) - len(structure.bearings) :] = 0.0
    inverse = np.linalg.inv(_root_of_mass(structure))
    stiffness = stuck.stiffness(
        deltas_of(structure, SLIDING_PART * float(np.max(np.abs(rest.phase[: 3 * structure.n]))))
    )
    squares = np.linalg.eigvalsh(inverse @ (0.5 * (stiffness + stiffness.T)) @ inverse.T)
    found: FloatArray = np.sqrt(np.maximum(0.0, squares)) / (2.0 * math.pi)
    return found


def _root_of_mass(structure: Structure) -> FloatArray:
    """Return the Cholesky factor of the mass matrix, (6 n, 6 n)."""
    root = np.zeros((6 * structure.n, 6 * structure.n))
    for i, block in enumerate(structure.blocks):
        at = 6 * i
        root[at : at + 3, at : at + 3] = np.eye(3) * math.sqrt(block.mass)
        root[at + 3 : at + 6, at + 3 : at + 6] = np.linalg.cholesky(block.inertia)
    return root


def _taut(structure: Structure, rest: SpatialRest) -> NDArray[np.bool_]:
    """Return the mask of ties without slack that bear hardly anything at rest, (ties,)."""
    if not structure.weight > 0.0:
        return np.zeros(len(structure.ties), dtype=bool)
    force, least = rest.row[places_of(OUTPUTS, structure.sizes)["tie"]], closed(structure)
    loose = [tie.tension_only and not tie.slack for tie in structure.ties]
    return np.array(loose, dtype=bool) & (force <= least * np.array([tie.stiffness for tie in structure.ties]))


def _at(structure: Structure, rest: SpatialRest, taut: NDArray[np.bool_]) -> SpatialStepper:
    """Return a structure at rest, with joints that stick, and with the ties of a mask bearing both ways."""
    stepper = SpatialStepper(structure)
    stepper.phase[:] = rest.phase
    stuck = sticking(stepper)
    stuck.model.ties.tension_only[: len(taut)][taut] = 0.0
    return stuck


def _damping(stepper: SpatialStepper, fastest: float) -> FloatArray:
    """Return the damping matrix: forces and moments on the blocks per rate, (6 n, 6 n).

    It is found by central differences, so that only the part of a joint in contact damps. Blocks at rest have turned so
    little that their axes are those of the base.

    fastest: largest angular frequency of the modes, rad/s.
    """
    structure, see = stepper.structure, stepper.see
    n = structure.n
    deltas = deltas_of(structure, PART * fastest * float(np.max(np.abs(stepper.phase[: 3 * n]))))
    # central differences of the forces by each rate
    rates = see.vx, see.vy, see.vz, see.wx, see.wy, see.wz
    found = np.empty((6 * n, 6 * n))
    for column, delta in enumerate(deltas):
        i, axis = divmod(column, 6)
        forces = []
        for rate in (delta, -delta):
            rates[axis][i] = rate
            forces.append(residual_of(stepper)[0])
        rates[axis][i] = 0.0
        found[:, column] = (forces[1] - forces[0]) / (2.0 * delta)
    return found
