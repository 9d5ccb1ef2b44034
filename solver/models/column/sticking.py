"""The test whether a column whose joints may slide has come to rest for good.

Slips change the barrier, so the energy alone decides nothing (verdict.py). But a column that sticks moves as one that
is off its axis by its slips and never slides. In full contact it swings about its rest, and this is linear: its motion
is a sum of modes, each of which keeps or loses its energy; pressures at the edges and forces along the joints are
linear in them. So the energies of the modes bound each. If all modes together take no more than a part of the pressure
at any edge, and leave every joint some of its shear capacity, none opens or slides ever again.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...common.errors import SolverError
from .kinematics import Chain, chain_of
from .linearization import StillColumn, stuck
from .model import Column
from .packing import FloatArray

SAFE = 0.8  # of the margins at rest; the remainder covers nonlinear effects
PART = 1e-3  # of the motion that opens a joint: step of finite differences
MOST_BLOCKS = 200  # limit beyond which the matrices take too long
ALIKE = 1e-6  # relative difference of dampings below which each mode loses its energy independently


class _Swinging(NamedTuple):
    """A column that sticks, about its rest: m modes, limits of forces and pressures."""

    rest: FloatArray  # coordinates (2 n,)
    into_modes: FloatArray  # of coordinates or rates, (m, 2 n)
    omega: FloatArray  # rad/s (m,)
    left: FloatArray  # margin of each limit at rest
    taken: FloatArray  # (limits, m), largest amount that a mode with half a unit of energy takes from a limit
    apart: bool  # whether the modes exchange no energy


def always_sticks(column: Column, phase: FloatArray) -> bool:
    """Return True if no joint of a column with this phase (kinematics.py) ever slides or opens on a still base."""
    place = chain_of(column).places(phase)
    if column.n > MOST_BLOCKS or np.any(place.slip_rate != 0.0):
        return False
    try:
        swinging = _swinging(column, tuple(float(value) for value in np.asarray(place.slip)))
    except (ValueError, SolverError):  # such a column does not stand
        return False
    if swinging is None:
        return False
    moved = swinging.into_modes @ (np.concatenate([place.theta, place.opening]) - swinging.rest)
    rates = swinging.into_modes @ np.concatenate([place.spin, place.opening_rate])
    size = np.hypot(rates, swinging.omega * moved)
    most = swinging.taken @ size if swinging.apart else np.linalg.norm(swinging.taken, axis=1) * np.linalg.norm(size)
    return bool(np.all(most <= SAFE * swinging.left))


@lru_cache(maxsize=32)
def _swinging(column: Column, slips: tuple[float, ...]) -> _Swinging | None:
    """Return the column that sticks with these slips (m); None if it is not stable, or not closed and stuck at rest.

    Raises InputError or SolverError if it does not stand at all.
    """
    blocks = tuple(
        replace(block, joint=replace(block.joint, offset=slip or None))
        for block, slip in zip(stuck(column).blocks, slips, strict=True)
    )
    still = StillColumn(replace(column, blocks=blocks))
    # modes about the rest
    mass = _mass(Chain(still.column), still.rest)
    stiffness = mass @ still.stiffness(still.rest, PART)
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares, turned = np.linalg.eigh(root @ (0.5 * (stiffness + stiffness.T)) @ root.T)
    if squares[0] <= 0.0:
        return None
    omega, shapes = np.sqrt(squares), root.T @ turned
    # margins of pressure and shear at rest, and the amounts that modes take from them
    pressed, by_place = _penetrations(still)
    eta = np.array([block.joint.damping for block in column.blocks])
    held, held_by_place, held_by_rate = _borne(column, still)
    left = np.concatenate([pressed, pressed, held])
    if np.min(left) <= 0.0:
        return None
    of_place = np.concatenate([by_place, by_place, held_by_place]) @ shapes
    of_rate = np.concatenate([0.0 * by_place, np.tile(eta, 2)[:, None] * by_place, held_by_rate]) @ shapes
    apart = bool(np.ptp(eta) <= ALIKE * np.max(eta))
    return _Swinging(still.rest, shapes.T @ mass, omega, left, np.hypot(of_place / omega, of_rate), apart)


def _mass(chain: Chain, rest: FloatArray) -> FloatArray:
    """Return the mass matrix about the rest, (2 n, 2 n), from the velocities that each rate gives."""
    n = chain.n
    count = 4 * n + (2 * n if chain.off_axis else 0)
    phases = np.zeros((2 * n, count))
    phases[:, : 2 * n] = rest
    phases[:, 2 * n : 4 * n] = np.eye(2 * n)
    if chain.off_axis:
        phases[:, 4 * n : 5 * n] = chain.offset
    places = chain.places(phases)
    velocities = chain.velocities(places, chain.joints(places))
    moving: FloatArray = ((velocities * chain.mass) @ velocities.conj().T).real
    return np.asarray(moving + (places.spin * chain.inertia) @ places.spin.T)


def _penetrations(still: StillColumn) -> tuple[FloatArray, FloatArray]:
    """Return the penetrations at both ends of all contacts at rest, m (2 n,), and their derivatives (2 n, 2 n)."""
    n, blocks = still.n, still.blocks
    slip = np.array([block.joint.offset or 0.0 for block in still.column.blocks])
    turning = np.eye(n) - np.eye(n, k=1)
    found = []
    left, right = blocks.rim_left - slip, blocks.rim_right - slip
    for edge in (np.maximum(blocks.own_left, left), np.minimum(blocks.own_right, right)):
        found.append(np.hstack([(edge + 0.5 * slip)[:, None] * turning, -np.eye(n)]))
    derivatives = np.concatenate(found)
    return derivatives @ still.rest, derivatives


def _borne(column: Column, still: StillColumn) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the margins of shear capacity at rest, both ways (N), and their derivatives by coordinates and by rates.

    Only joints that may slide have them.
    """
    sliding = np.array([block.joint.friction is not None for block in column.blocks])
    friction = np.array([block.joint.friction or 0.0 for block in column.blocks])
    dowel = np.array([block.joint.dowel or 0.0 for block in column.blocks])
    # bound of the force of a rim along the joint, a small force: four times the one at rest
    rims = np.array([2.0 * block.joint.stiffness for block in column.blocks]) * still.blocks.depth
    rims = rims * np.max(_penetrations(still)[0].reshape(2, -1), axis=0) ** 2

    def margins(q: FloatArray, rates: FloatArray) -> FloatArray:
        joints = still.row(q, rates=rates).joints
        turned = 0.5 * (q[: still.n] - np.append(q[1 : still.n], 0.0))
        asked, bears = joints.T + joints.N * np.sin(turned), friction * joints.N + dowel - rims
        return np.concatenate([(bears - asked)[sliding], (bears + asked)[sliding]])

    still_stands, sizes = np.zeros(2 * still.n), PART * still.sizes
    by_place = still.derivatives(lambda change: margins(still.rest + change, still_stands), sizes)
    by_rate = still.derivatives(lambda change: margins(still.rest, change), sizes)
    return margins(still.rest, still_stands), -by_place, -by_rate
