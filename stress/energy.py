"""Energy of the exact model and the work of the base, relative to the base, at phases of a run."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solver import Column, Motion

Array = NDArray[np.float64]


def below(values: Array) -> Array:
    """Return for each block the value of the block under it, zero for the base; blocks along the last axis."""
    return np.concatenate([values[..., 1:], np.zeros_like(values[..., :1])], axis=-1)


def from_base(steps: Array) -> Array:
    """Return the sums from the base up to each block, along the last axis."""
    return np.cumsum(steps[..., ::-1], axis=-1)[..., ::-1]


class Energies:
    """Energies at phases (r, 4 n or more): `kinetic`, `gravity`, `elastic` J (r,); x, z of the centroids.

    z is relative to the unloaded column.
    """

    def __init__(self, column: Column, phases: Array) -> None:
        n = column.n
        turn, opening, spin, opening_rate = (phases[:, k * n : (k + 1) * n] for k in range(4))
        height, rise, mass, inertia = (
            np.array([getattr(block, name) for block in column.blocks])
            for name in ("height", "resolved_centroid", "mass", "resolved_inertia")
        )
        width, depth = np.array([(contact.width, contact.depth) for contact in column.contacts]).T
        stiffness = np.array([block.joint.stiffness for block in column.blocks])
        phi = 0.5 * (turn + below(turn))
        phi_rate = 0.5 * (spin + below(spin))
        dip = -2.0 * np.sin(0.5 * turn) ** 2  # cos - 1 without cancellation
        sine, cosine = np.sin(turn), np.cos(turn)
        across, along = opening * np.sin(phi), opening * np.cos(phi)
        beyond = rise - height  # the centroid from the top face
        self.x = from_base(across + height * sine) + beyond * sine
        self.z = from_base(along + height * dip) + beyond * dip
        vx = from_base(opening_rate * np.sin(phi) + along * phi_rate + height * cosine * spin) + beyond * cosine * spin
        vz = from_base(opening_rate * np.cos(phi) - across * phi_rate - height * sine * spin) - beyond * sine * spin
        self.mass = mass
        self.kinetic = 0.5 * np.sum(mass * (vx**2 + vz**2) + inertia * spin**2, axis=1)
        self.gravity = column.g * np.sum(mass * self.z, axis=1)
        self.elastic = np.sum(
            _potential(stiffness, width, depth, opening, 2.0 * np.sin(0.5 * (turn - below(turn)))), axis=1
        )

    @property
    def total(self) -> Array:
        """J, (r,)."""
        return self.kinetic + self.gravity + self.elastic

    def work(self, motion: Motion) -> Array:
        """Return the work of the inertia forces in the moving frame since the first phase, J (r,); one phase at every
        sample.

        For held samples it is exact: the force is constant between two of them.
        """
        moved = np.diff(self.x @ self.mass), np.diff(self.z @ self.mass)
        count = len(moved[0])
        done = -(motion.ax[:count] * moved[0] + motion.az[:count] * moved[1])
        return np.concatenate([[0.0], np.cumsum(done)])


def _potential(k: Array, b: Array, t: Array, opening: Array, slope: Array) -> Array:
    """Return the elastic energy of the joints, J: the integral of k pen^2 / 2."""
    a = np.abs(slope)
    deepest, least = 0.5 * b * a - opening, -0.5 * b * a - opening
    full = 0.5 * k * b * t * (opening**2 + (a * b) ** 2 / 12.0)
    part = k * t * deepest**3 / (6.0 * np.where(a > 0.0, a, 1.0))
    return np.where(least >= 0.0, full, np.where(deepest > 0.0, part, 0.0))
