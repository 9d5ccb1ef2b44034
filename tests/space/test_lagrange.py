"""Random structures against Lagrange's equations, derived here from energies alone, by numpy and scipy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.probe import G

from solver.kernels.structure import layout as at
from solver.models.structure.blocks.faces import Face, FloatArray, clipped, polygon_moments
from solver.models.structure.blocks.parts import Tie
from solver.models.structure.builders import arch, colonnade, wall
from solver.models.structure.model import Structure
from solver.models.structure.run import SpatialState, set_initial
from solver.models.structure.stepper import SpatialStepper

SMALL = 1e-5  # m and rad, of differences; terms of the third order are 1e-10 of the first


def random_structure(seed: int) -> Structure:
    """Return a colonnade, an arch or a wall of random sizes, with random ties and ratios of stiffness, undamped."""
    rng = np.random.default_rng(seed)
    law = {"stiffness": 1e8, "damping": 0.0, "shear_ratio": float(rng.uniform(0.3, 2.0))}
    a, b, c = rng.uniform(0.8, 1.4, 3)
    made = (
        lambda: colonnade(2, 2, 3.0 * c, a, 3.0 * b, law, architrave=(0.6, a)),
        lambda: arch(5, 4.0 * c, 0.8 * a, b, law, angle=2.6),
        lambda: wall(2, 2, (2.0 * a, 0.6 * b, 0.5 * c), law),
    )[seed % 3]
    structure = made()
    ties = [
        Tie(0, other, 0.3 * rng.normal(size=3), 0.3 * rng.normal(size=3), stiffness=1e6, tension_only=False)
        for other in (structure.n - 1, structure.n)
    ]
    return replace(structure, ties=tuple(ties))


# --- energies of coordinates q: displacement and rotation vector of each block


def split(q: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
    """Return the displacements and rotation matrices of all bodies, the base last."""
    parts = np.concatenate([q.reshape(-1, 6), np.zeros((1, 6))])
    return parts[:, :3], [Rotation.from_rotvec(part[3:]).as_matrix() for part in parts]


def potential(structure: Structure, q: FloatArray) -> float:
    u, turns = split(q)
    centroids = [*(block.centroid for block in structure.blocks), np.zeros(3)]
    total = sum(G * block.mass * u[i, 2] for i, block in enumerate(structure.blocks))
    for joint in structure.joints:
        axes, (i, j) = joint.face.axes, (joint.upper, joint.lower)
        apart = Rotation.from_matrix((turns[j] @ axes).T @ (turns[i] @ axes)).as_rotvec()
        angle = np.linalg.norm(apart)
        kappa = apart * (2.0 * np.sin(0.5 * angle) / angle)
        half = turns[j] @ axes @ Rotation.from_rotvec(0.5 * apart).as_matrix()
        places = [centroids[body] + u[body] + turns[body] @ (joint.face.centre - centroids[body]) for body in (i, j)]
        s1, s2, opening = half.T @ (places[0] - places[1])
        total += 0.5 * joint.bed.stiffness * squares(rim(joint.face), (-opening, kappa[1], -kappa[0]))
        area, ixx, iyy, _ = joint.face.moments
        along = joint.bed.shear_ratio * joint.bed.stiffness
        total += 0.5 * along * (area * (s1**2 + s2**2) + (ixx + iyy) * kappa[2] ** 2)
    for one in structure.ties:
        ends = [centroids[b] + u[b] + turns[b] @ arm for b, arm in ((one.one, one.from_), (one.other, one.to))]
        built = centroids[one.other] + one.to - centroids[one.one] - one.from_
        total += 0.5 * one.stiffness * (np.linalg.norm(ends[1] - ends[0]) - np.linalg.norm(built)) ** 2
    return float(total)


def rim(face: Face) -> FloatArray:
    """Return the outline of a face; of a disc that of a polygon of equal area, whose error is 1e-9."""
    if not face.radius:
        return face.outline
    angle = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    size = face.radius * np.sqrt(angle[1] / np.sin(angle[1]))
    return size * np.column_stack([np.cos(angle), np.sin(angle)])


def squares(outline: FloatArray, p: tuple[float, float, float]) -> float:
    """Return the integral of p^2 where the linear function p is positive."""
    far = 1e3
    slope = np.array(p[1:])
    size = float(np.linalg.norm(slope))
    foot, way = -p[0] / size * slope / size, slope / size
    across = np.array([-way[1], way[0]])
    pressed = clipped(outline, foot + far * np.array([-across, way - across, way + across, across]))
    if not len(pressed):
        return 0.0
    area, first, second = polygon_moments(pressed)
    return float(p[0] ** 2 * area + 2.0 * p[0] * (slope @ first) + slope @ second @ slope)


def spin_by(turn: FloatArray) -> FloatArray:
    """Return the matrix from the rate of a rotation vector to the spin along the axes of the block, by differences."""
    now, columns = Rotation.from_rotvec(turn).as_matrix(), []
    for axis in SMALL * np.eye(3):
        ahead, behind = (Rotation.from_rotvec(turn + way * axis).as_matrix() for way in (1.0, -1.0))
        skew = now.T @ (ahead - behind) / (2.0 * SMALL)
        columns.append([skew[2, 1], skew[0, 2], skew[1, 0]])
    return np.array(columns).T


def mass_matrix(structure: Structure, q: FloatArray) -> FloatArray:
    matrix = np.zeros((len(q), len(q)))
    for i, block in enumerate(structure.blocks):
        k = 6 * i
        by = spin_by(q[k + 3 : k + 6])
        matrix[k : k + 3, k : k + 3] = block.mass * np.eye(3)
        matrix[k + 3 : k + 6, k + 3 : k + 6] = by.T @ block.inertia @ by
    return matrix


def accelerations(structure: Structure, q: FloatArray, rates: FloatArray) -> FloatArray:
    """Return the accelerations of the coordinates: M q'' = dT/dq - dV/dq - M' q'."""

    def kinetic(at: FloatArray) -> float:
        return 0.5 * float(rates @ mass_matrix(structure, at) @ rates)

    def lagrangian(at: FloatArray) -> float:
        return kinetic(at) - potential(structure, at)

    steps = SMALL * np.eye(len(q))
    differences: FloatArray = np.array([lagrangian(q + step) - lagrangian(q - step) for step in steps])
    changed = (mass_matrix(structure, q + SMALL * rates) - mass_matrix(structure, q - SMALL * rates)) / (2.0 * SMALL)
    forces = differences / (2.0 * SMALL) - changed @ rates
    found: FloatArray = np.linalg.solve(mass_matrix(structure, q), forces).astype(np.float64)
    return found


@pytest.mark.parametrize("seed", range(6))
def test_accelerations_are_those_of_lagranges_equations(seed: int) -> None:
    structure, rng = random_structure(seed), np.random.default_rng(seed + 100)
    n = structure.n
    q = (rng.normal(size=(n, 6)) * ([5e-3] * 3 + [0.05] * 3) - [0.0, 0.0, 5e-3, 0.0, 0.0, 0.0]).ravel()
    rates = rng.normal(size=6 * n)
    expected = accelerations(structure, q, rates).reshape(n, 6)
    turns, spun = q.reshape(n, 6)[:, 3:], rates.reshape(n, 6)[:, 3:]
    spins, quickened = np.zeros((n, 3)), np.zeros((n, 3))
    for i, (turn, rate) in enumerate(zip(turns, spun, strict=True)):
        ahead, behind = (spin_by(turn + way * SMALL * rate) @ rate for way in (1.0, -1.0))
        spins[i] = spin_by(turn) @ rate
        quickened[i] = spin_by(turn) @ expected[i, 3:] + (ahead - behind) / (2.0 * SMALL)
    stepper = SpatialStepper(structure)
    world = np.array([Rotation.from_rotvec(turn).apply(spin) for turn, spin in zip(turns, spins, strict=True)])
    set_initial(stepper, SpatialState(q.reshape(n, 6)[:, :3], turns, rates.reshape(n, 6)[:, :3], world))
    for k in (1, 2, 3):
        getattr(stepper.slips, f"p{k}")[:] = 0.0
    stepper.observe()
    see = at.PHASE.see(stepper.rates, n)
    found = np.array([see.vx, see.vy, see.vz]).T, np.array([see.wx, see.wy, see.wz]).T
    for one, other in zip(found, (expected[:, :3], quickened), strict=True):
        assert np.max(np.abs(one - other)) <= 1e-6 * np.max(np.abs(other))  # measured 2e-8
