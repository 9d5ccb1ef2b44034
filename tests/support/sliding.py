"""Reference for joints that slide and columns off their axis: Lagrange's equations, theory.md sections 9 and 12.

q = (theta (n,) rad, delta (n,) m, slip (n,) m), rotations from the column as built, slips with the offsets. The contact
belongs to the block above, as far as the face below reaches. A joint of direction 1 or -1 slides that way, one of
direction 0 sticks. It uses only the column's data of `solver`. Sections are rectangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from solver import Column
from support.lagrange import TINY, Array, Reference, below, from_base, pressure_resultants


@dataclass(frozen=True)
class SlidingReference(Reference):
    """The data of a column; without friction the shear capacity of a joint is unlimited."""

    friction: Array
    dowel: Array
    offset: Array
    lean: Array  # rad, of the joints as built
    tilt: Array  # rad, of the blocks as built
    rim: Array  # m, half the width of the face below

    @classmethod
    def of(cls, column: Column) -> SlidingReference:
        joints = [block.joint for block in column.blocks]
        lean = np.array([joint.inclination or 0.0 for joint in joints])
        faces = np.array([*(0.5 * (block.top_width or block.width) for block in column.blocks[1:]), np.inf])
        deep = np.array([*(block.top_depth or block.depth for block in column.blocks[1:]), np.inf])
        whole = vars(Reference.of(column))
        return cls(
            **whole | {"depth": np.minimum(whole["depth"], deep)},
            friction=np.array([joint.friction or 0.0 for joint in joints]),
            dowel=np.array([1e300 if joint.friction is None else joint.dowel or 0.0 for joint in joints]),
            offset=np.array([joint.offset or 0.0 for joint in joints]),
            lean=lean,
            tilt=lean + np.array([block.tilt or 0.0 for block in column.blocks]),
            rim=faces,
        )

    @property
    def built(self) -> Array:
        """The column as built (3n,)."""
        return np.concatenate([np.zeros(2 * self.n), self.offset])

    def ends(self, slip: Array) -> tuple[Array, Array]:
        """Return the ends of the contacts, m from the middle of the block."""
        return np.maximum(-0.5 * self.width, -self.rim - slip), np.minimum(0.5 * self.width, self.rim - slip)

    def split(self, q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        n = self.n
        return q[:n], q[n : 2 * n], q[2 * n :]

    def tops(self, q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        theta, delta, slip = self.split(q)
        phi, turned = 0.5 * (theta + below(theta)) + self.lean, theta + self.tilt
        return (
            from_base(delta * np.sin(phi) + slip * np.cos(phi) + self.height * np.sin(turned)),
            from_base(delta * np.cos(phi) - slip * np.sin(phi) + self.height * np.cos(turned)),
        )

    def jacobians(self, q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the derivatives of the centroids (x, z) by q, each (n, 3n)."""
        n = self.n
        theta, delta, slip = (part[:, None] for part in self.split(q))
        turn, open_, slide = np.eye(3 * n)[:n], np.eye(3 * n)[n : 2 * n], np.eye(3 * n)[2 * n :]
        phi, mean = 0.5 * (theta + below(theta)) + self.lean[:, None], 0.5 * (turn + below(turn))
        theta = theta + self.tilt[:, None]
        low, high = self.height[:, None], (self.height - self.centroid)[:, None]
        sine, cosine = np.sin(phi), np.cos(phi)
        x = from_base(
            open_ * sine + slide * cosine + (delta * cosine - slip * sine) * mean + low * np.cos(theta) * turn
        )
        z = from_base(
            open_ * cosine - slide * sine - (delta * sine + slip * cosine) * mean - low * np.sin(theta) * turn
        )
        return x - high * np.cos(theta) * turn, z + high * np.sin(theta) * turn

    def pressures(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Return N and its moment about the middle of the block above, which is displaced by slip / 2."""
        theta, delta, slip = self.split(q)
        spin, delta_rate, slip_rate = self.split(rate)
        half = 0.5 * (theta - below(theta))
        slope, slope_rate = 2.0 * np.sin(half), np.cos(half) * (spin - below(spin))
        left, right = self.ends(slip)
        middle = 0.5 * (left + right)  # of the contact
        states = zip(
            self.stiffness, right - left, self.depth, self.damping, delta - (0.5 * slip + middle) * slope, slope,
            delta_rate - 0.5 * (slip_rate * slope + slip * slope_rate) - middle * slope_rate, slope_rate, strict=True,
        )  # fmt: skip
        normal, moment = np.array([pressure_resultants(*state) for state in states]).T
        return normal, moment + middle * normal

    def at_rims(self, q: Array) -> Array:
        """Return the forces along the joints, on the blocks above, from rims that end contacts, N: the energy density
        there.
        """
        theta, delta, slip = self.split(q)
        slope = 2.0 * np.sin(0.5 * (theta - below(theta)))
        found = np.zeros(self.n)
        for edge, whole, sign in zip(self.ends(slip), (-0.5 * self.width, 0.5 * self.width), (-1.0, 1.0), strict=True):
            pressed = np.maximum(0.0, slope * edge - delta + 0.5 * slip * slope)
            found += np.where(edge == whole, 0.0, sign * 0.5 * self.stiffness * self.depth * pressed**2)
        return found

    def elastic(self, q: Array) -> float:
        theta, delta, slip = self.split(q)
        slope = 2.0 * np.sin(0.5 * (theta - below(theta)))
        left, right = self.ends(slip)
        data = {name: getattr(self, name) for name in Reference.__dataclass_fields__} | {"width": right - left}
        return Reference(**data).elastic(np.concatenate([theta, delta - 0.5 * (slip + left + right) * slope]))

    def solve(
        self, q: Array, rate: Array, direction: Array, ax: float = 0.0, az: float = 0.0
    ) -> tuple[Array, Array, Array, Array]:
        """Return q'' (3n,), T of every joint on the block above, the part of it that is not friction, the capacity
        (n,).
        """
        n = self.n
        theta, _, slip = self.split(q)
        half = 0.5 * (theta - below(theta))
        normal, moment = self.pressures(q, rate)
        # virtual work of the pressure on d(delta - slip slope / 2) and d(slope)
        turning = (moment + 0.5 * slip * normal) * np.cos(half)
        drift = self.at_rims(q) - normal * np.sin(half)
        bears = self.friction * normal + self.dowel
        joints = np.concatenate([np.concatenate([[0.0], turning[:-1]]) - turning, normal, drift - direction * bears])
        matrix, rest = self.mass_matrix(q), self.inertial(q, rate, ax, az) + joints
        found = np.zeros(3 * n)
        free = np.concatenate([np.arange(2 * n), 2 * n + np.flatnonzero(direction)])
        found[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest[free])
        tangential = np.where(direction == 0, (matrix @ found - rest)[2 * n :] + drift, drift - direction * bears)
        return found, tangential, drift, bears

    def inertial(self, q: Array, rate: Array, ax: float, az: float) -> Array:
        """Return the gravity, the base and the velocity terms (3n,)."""

        def lagrangian(at: NDArray[Any]) -> Any:
            x, z = self.centroids(at)
            return 0.5 * rate @ self.mass_matrix(at) @ rate - self.mass @ (ax * x + (self.g + az) * z)

        change = self.mass_matrix(q + 1j * TINY * rate).imag / TINY
        gradient = [lagrangian(q + 1j * TINY * unit).imag / TINY for unit in np.eye(3 * self.n)]
        found: Array = np.array(gradient) - change @ rate
        return found

    def centroids(self, q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        theta = q[: self.n] + self.tilt
        x, z = self.tops(q)
        high = self.height - self.centroid
        return x - high * np.sin(theta), z - high * np.cos(theta)


def follow(
    reference: SlidingReference, q: Array, rate: Array, ax: float, until: float, tolerance: float
) -> tuple[Array, int]:
    """Return (q and rates at time `until` s under a held ax, changes of sliding): DOP853 between these."""
    n = reference.n
    direction, t, changes = np.sign(rate[2 * n :]), 0.0, 0
    y: Array = np.concatenate([q, rate])
    scale = np.concatenate([np.full(3 * n, 1e-4), np.full(3 * n, 1e-1)])
    while t < until:
        _settle(reference, y, direction, ax)
        kept = direction.copy()

        def slope(_: float, here: Array, kept: Array = kept) -> Array:
            return np.concatenate([here[3 * n :], reference.solve(here[: 3 * n], here[3 * n :], kept, ax)[0]])

        def margins(i: int, kept: Array = kept) -> Any:
            def margin(t: float, here: Array) -> float:
                if kept[i] != 0.0:
                    return float(kept[i] * here[5 * n + i])
                _, force, drift, bears = reference.solve(here[: 3 * n], here[3 * n :], kept, ax)
                return float(bears[i] - abs(force[i] - drift[i]))

            margin.terminal, margin.direction = True, -1.0  # type: ignore[attr-defined]
            return margin

        events = [margins(i) for i in range(n)]
        run = solve_ivp(slope, (t, until), y, "DOP853", events=events, rtol=tolerance, atol=tolerance * scale)
        t, y = float(run.t[-1]), run.y[:, -1]
        if t < until:
            changes += 1
            for i, times in enumerate(run.t_events):
                if times.size:
                    if kept[i] == 0.0:
                        _, force, drift, _ = reference.solve(y[: 3 * n], y[3 * n :], kept, ax)
                        direction[i] = -np.sign(force[i] - drift[i])
                    else:
                        direction[i] = y[5 * n + i] = 0.0
    return y, changes


def _settle(reference: SlidingReference, y: Array, direction: Array, ax: float) -> None:
    """Let joints slide that stick beyond their capacity, in the direction of the force on them."""
    n = reference.n
    for _ in range(n + 1):
        _, force, drift, bears = reference.solve(y[: 3 * n], y[3 * n :], direction, ax)
        beyond = (direction == 0.0) & (np.abs(force - drift) > bears * (1.0 + 1e-12))
        if not np.any(beyond):
            return
        direction[beyond] = -np.sign(force - drift)[beyond]
