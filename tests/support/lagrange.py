"""Reference for the exact formulation: Lagrange's equations of theory.md section 4 in plain numpy.

It uses only the column's data of `solver`. Kinematics and energies are written out; velocity terms and gradients follow
by complex steps, exact to rounding. Arrays count blocks and joints from the top; q = (theta (n,) rad, delta (n,) m).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver import Block, Column

Array = NDArray[np.float64]

TINY = 1e-30  # complex step


def linear(pressure: Array) -> Array:
    """Return the identity: the law max(0, k pen + eta k dpen) without a change."""
    return pressure


@dataclass(frozen=True)
class Reference:
    """The data of a column as arrays (n,), SI."""

    height: Array
    centroid: Array
    mass: Array
    inertia: Array
    stiffness: Array
    width: Array
    depth: Array
    damping: Array
    g: float
    # another law of the joints, as `pressure_resultants` takes it
    law: Callable[[Array], Array] = field(default=linear, kw_only=True)
    bends: tuple[float, ...] = field(default=(), kw_only=True)

    @classmethod
    def of(cls, column: Column) -> Reference:
        def each(value: Callable[[Block], float]) -> Array:
            return np.array([value(block) for block in column.blocks])

        return cls(
            height=each(lambda block: block.height),
            centroid=each(lambda block: block.resolved_centroid),
            mass=each(lambda block: block.mass),
            inertia=each(lambda block: block.resolved_inertia),
            stiffness=each(lambda block: block.joint.stiffness),
            width=each(lambda block: block.joint_width),
            depth=each(lambda block: block.joint_depth),
            damping=each(lambda block: block.joint.damping),
            g=column.g,
        )

    @property
    def n(self) -> int:
        return len(self.mass)

    # --- kinematics

    def tops(self, q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the centres of the top faces (x, z), each (n,) m."""
        theta, delta = q[: self.n], q[self.n :]
        phi = 0.5 * (theta + below(theta))
        return from_base(delta * np.sin(phi) + self.height * np.sin(theta)), from_base(
            delta * np.cos(phi) + self.height * np.cos(theta)
        )

    def centroids(self, q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        theta = q[: self.n]
        x, z = self.tops(q)
        return x - (self.height - self.centroid) * np.sin(theta), z - (self.height - self.centroid) * np.cos(theta)

    def joint_middles(self, q: Array) -> tuple[Array, Array]:
        """Return the points half way between the centres of the two faces of each joint (x, z)."""
        x, z = self.tops(q)
        theta, delta = q[: self.n], q[self.n :]
        phi = 0.5 * (theta + below(theta))
        return below(x) + 0.5 * delta * np.sin(phi), below(z) + 0.5 * delta * np.cos(phi)

    def jacobians(self, q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the derivatives of the centroids (x, z) by q, each (n, 2n)."""
        n = self.n
        theta, delta = q[:n, None], q[n:, None]
        turn, slide = np.eye(2 * n)[:n], np.eye(2 * n)[n:]
        phi, mean = 0.5 * (theta + below(theta)), 0.5 * (turn + below(turn))
        low, high = self.height[:, None], (self.height - self.centroid)[:, None]
        x = from_base(slide * np.sin(phi) + delta * np.cos(phi) * mean + low * np.cos(theta) * turn)
        z = from_base(slide * np.cos(phi) - delta * np.sin(phi) * mean - low * np.sin(theta) * turn)
        return x - high * np.cos(theta) * turn, z + high * np.sin(theta) * turn

    # --- energies

    def mass_matrix(self, q: NDArray[Any]) -> NDArray[Any]:
        """Return the mass matrix (2n, 2n) of the kinetic energy rate' M rate / 2."""
        x, z = self.jacobians(q)
        matrix: NDArray[Any] = x.T @ (self.mass[:, None] * x) + z.T @ (self.mass[:, None] * z)
        matrix[: self.n, : self.n] += np.diag(self.inertia)
        return matrix

    def kinetic(self, q: Array, rate: Array) -> float:
        return float(0.5 * rate @ self.mass_matrix(q) @ rate)

    def elastic(self, q: Array) -> float:
        """Return the energy of the joints, J."""
        slope, opening = self.slopes(q), q[self.n :]
        total = 0.0
        for k, b, t, a, dw in zip(self.stiffness, self.width, self.depth, np.abs(slope), opening, strict=True):
            deepest, least = 0.5 * b * a - dw, -0.5 * b * a - dw
            if least >= 0.0:
                total += 0.5 * k * b * t * (dw * dw + (a * b) ** 2 / 12.0)
            elif deepest > 0.0:
                total += k * t * deepest**3 / (6.0 * a)
        return total

    def energy(self, q: Array, rate: Array) -> float:
        """Return the kinetic, gravitational and elastic energy, J."""
        return self.kinetic(q, rate) + float(self.g * self.mass @ self.centroids(q)[1]) + self.elastic(q)

    # --- joints

    def slopes(self, q: Array) -> Array:
        theta = q[: self.n]
        return 2.0 * np.sin(0.5 * (theta - below(theta)))

    def resultants(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Return N (N) and M (N m) of every joint."""
        theta, spin = q[: self.n], rate[: self.n]
        half = 0.5 * (theta - below(theta))
        states = zip(
            self.stiffness, self.width, self.depth, self.damping, q[self.n :], 2.0 * np.sin(half), rate[self.n :],
            np.cos(half) * (spin - below(spin)), strict=True,
        )  # fmt: skip
        normal, moment = np.array([pressure_resultants(*state, law=self.law, bends=self.bends) for state in states]).T
        return normal, moment

    # --- motion

    def accelerations(self, q: Array, rate: Array, ax: float = 0.0, az: float = 0.0) -> Array:
        """Return q'' (2n,) of d/dt dL/dq' - dL/dq = Q, the base acceleration as fictitious forces in L."""
        found: Array = np.linalg.solve(self.mass_matrix(q), self.forces(q, rate, ax, az))
        return found

    def on_rotating_base(self) -> Reference:
        """Return the column on one more body, the last, of no height, mass or stiffness: the base."""
        beside = {"width": 1.0, "depth": 1.0}
        more: dict[str, Any] = {
            name: np.append(value, beside.get(name, 0.0))
            for name, value in vars(self).items()
            if isinstance(value, np.ndarray)
        }
        return replace(self, **more)

    def accelerations_on_base(self, q: Array, rate: Array, ax: float, az: float, alpha: float) -> Array:
        """Return q'' (2n,) where the last body is the base: rotation and opening under it follow alpha rad/s2
        and zero.
        """
        n = self.n
        found = np.zeros(2 * n)
        found[n - 1] = alpha
        free = np.delete(np.arange(2 * n), [n - 1, 2 * n - 1])
        matrix = self.mass_matrix(q)
        rest = self.forces(q, rate, ax, az) - matrix @ found
        found[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest[free])
        return found

    def with_base(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Return the mass matrix and forces, of the base along x and z, then of q.

        The last body is the base (`on_rotating_base`): its rotation comes third, and it does not open.
        """
        n = self.n
        order = [n - 1, *range(n - 1), *range(n, 2 * n - 1)]
        across = np.array([self.mass @ along for along in self.jacobians(q)])[:, order]
        dx, dz = self.centroid_accelerations(q, rate, np.zeros(2 * n))
        own = self.mass_matrix(q)[np.ix_(order, order)]
        matrix = np.block([[np.sum(self.mass) * np.eye(2), across], [across.T, own]])
        along = [-self.mass @ dx, -self.mass @ (self.g + dz)]
        return matrix, np.append(along, self.forces(q, rate, 0.0, 0.0)[order])

    def forces(self, q: Array, rate: Array, ax: float, az: float) -> Array:
        """Return the generalized forces, equal to the mass matrix times q'' (2n,)."""
        n = self.n

        def lagrangian(at: NDArray[Any]) -> Any:
            x, z = self.centroids(at)
            return 0.5 * rate @ self.mass_matrix(at) @ rate - self.mass @ (ax * x + (self.g + az) * z)

        change = self.mass_matrix(q + 1j * TINY * rate).imag / TINY
        gradient = [lagrangian(q + 1j * TINY * unit).imag / TINY for unit in np.eye(2 * n)]
        normal, moment = self.resultants(q, rate)
        theta = q[:n]
        couple = moment * np.cos(0.5 * (theta - below(theta)))  # of the joint under the block, against the rotation
        joints = np.concatenate([np.concatenate([[0.0], couple[:-1]]) - couple, normal])
        found: Array = np.array(gradient) - change @ rate + joints
        return found

    def centroid_accelerations(self, q: Array, rate: Array, acceleration: Array) -> tuple[Array, Array]:
        """Return the accelerations of the centroids relative to the base (x, z), each (n,) m/s2."""
        x, z = self.jacobians(q)
        dx, dz = (part.imag @ rate / TINY for part in self.jacobians(q + 1j * TINY * rate))
        return x @ acceleration + dx, z @ acceleration + dz


def below(values: NDArray[Any]) -> NDArray[Any]:
    """Return for each block the value of the block under it; zero for the base."""
    return np.concatenate([values[1:], np.zeros_like(values[:1])])


def from_base(steps: NDArray[Any]) -> NDArray[Any]:
    """Return the sums from the base up to each block."""
    return np.cumsum(steps[::-1], axis=0)[::-1]


def pressure_resultants(
    k: float,
    b: float,
    t: float,
    eta: float,
    opening: float,
    slope: float,
    opening_rate: float,
    slope_rate: float,
    *,
    law: Callable[[Array], Array] = linear,
    bends: tuple[float, ...] = (),
) -> tuple[float, float]:
    """Return N and M of the pressure max(0, k pen + eta k dpen) where pen > 0, by Gauss's rule between its kinks.

    law: function of that pressure, for another law; bends: pressures at which it has kinks; it is linear between them.
    """

    def pressure(s: Array) -> Array:
        pen = -opening + slope * s
        force = k * (pen + eta * (-opening_rate + slope_rate * s))
        return np.where((pen > 0.0) & (force > 0.0), law(force), 0.0)

    kinks = [-0.5 * b, 0.5 * b]
    mean, felt_slope = opening + eta * opening_rate, slope + eta * slope_rate
    for value, gradient in ((opening, slope), (mean, felt_slope), *((mean + bend / k, felt_slope) for bend in bends)):
        if gradient != 0.0 and abs(value / gradient) < 0.5 * b:
            kinks.append(value / gradient)
    ends = np.array(sorted(kinks))
    half, middle = 0.5 * np.diff(ends), 0.5 * (ends[1:] + ends[:-1])
    s = np.concatenate([middle - half / np.sqrt(3.0), middle + half / np.sqrt(3.0)])
    force = np.concatenate([half, half]) * t * pressure(s)
    return float(np.sum(force)), float(np.sum(force * s))
