"""Two rigid blocks, one on the other, that rock about corners: Lagrange's equations, until a corner lands."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from .rigid_block import FloatArray

G = 9.80665  # m/s2


@dataclass(frozen=True)
class Slab:
    """A homogeneous rectangle: width and height m, mass kg."""

    width: float
    height: float
    mass: float

    @property
    def inertia(self) -> float:
        """About the centroid, kg m2."""
        return self.mass * (self.width**2 + self.height**2) / 12.0


@dataclass(frozen=True)
class Pair:
    """A block on another; sides: +1 where the lower one and the upper one on it rock about their right corners.

    Rotations are clockwise; of the upper block absolute. The equations hold while the lower block is on its corner and
    the upper one on that of its own: rotation and relative rotation keep the signs of the sides.
    """

    lower: Slab
    upper: Slab
    sides: tuple[int, int]

    def _arms(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the arms as built: from the lower corner to its centroid and to the corner above, and from there to
        the upper one.
        """
        half, over = 0.5 * self.sides[0] * self.lower.width, 0.5 * self.sides[1] * self.upper.width
        to_lower = np.array([-half, 0.5 * self.lower.height])
        to_corner = np.array([over - half, self.lower.height])
        return to_lower, to_corner, np.array([-over, 0.5 * self.upper.height])

    def accelerations(self, angles: FloatArray, rates: FloatArray) -> FloatArray:
        """Return the accelerations of both rotations, rad/s2: M q'' = -dV/dq - what centripetal accelerations
        ask for.
        """
        to_lower, to_corner, to_upper = self._arms()
        a, b = angles
        low, high, over = _slope(a, to_lower), _slope(a, to_corner), _slope(b, to_upper)
        m, n = self.lower.mass, self.upper.mass
        mass = np.array(
            [
                [m * low @ low + n * high @ high + self.lower.inertia, n * high @ over],
                [n * high @ over, n * over @ over + self.upper.inertia],
            ]
        )
        inward = -(_turn(a, to_corner) * rates[0] ** 2 + _turn(b, to_upper) * rates[1] ** 2)  # of the upper centroid
        own = -_turn(a, to_lower) * rates[0] ** 2
        weight = np.array([m * G * low[1] + n * G * high[1], n * G * over[1]])
        pulled = np.array([m * low @ own + n * high @ inward, n * over @ inward])
        return np.linalg.solve(mass, -weight - pulled)

    def energy(self, angles: FloatArray, rates: FloatArray) -> float:
        """Return the energy, J; zero of weight at the base."""
        to_lower, to_corner, to_upper = self._arms()
        a, b = angles
        slow = _slope(a, to_lower) * rates[0]
        fast = _slope(a, to_corner) * rates[0] + _slope(b, to_upper) * rates[1]
        kinetic = self.lower.mass * slow @ slow + self.lower.inertia * rates[0] ** 2
        kinetic += self.upper.mass * fast @ fast + self.upper.inertia * rates[1] ** 2
        rise = self.lower.mass * _turn(a, to_lower)[1]
        rise += self.upper.mass * (_turn(a, to_corner)[1] + _turn(b, to_upper)[1])
        return float(0.5 * kinetic + G * rise)

    def released(self, tilt: float, relative: float, end: float = 20.0) -> tuple[FloatArray, FloatArray]:
        """Return the times, s, and both rotations, (times, 2), from rest at these tilts, rad, until one of them is
        zero.
        """

        def rate(_: float, y: FloatArray) -> FloatArray:
            return np.concatenate([y[2:], self.accelerations(y[:2], y[2:])])

        def lands(_: float, y: FloatArray) -> float:
            left = [side * angle for side, angle in zip(self.sides, (y[0], y[1] - y[0]), strict=True)]
            return float(min(left))

        lands.terminal, lands.direction = True, -1.0  # type: ignore[attr-defined]
        start = [self.sides[0] * tilt, self.sides[0] * tilt + self.sides[1] * relative, 0.0, 0.0]
        found = solve_ivp(rate, (0.0, end), start, "DOP853", rtol=1e-11, atol=1e-13, events=lands, max_step=0.02)
        return found.t, found.y[:2].T


def _turn(angle: float, arm: FloatArray) -> FloatArray:
    """Return an arm (x, z) turned clockwise."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([arm[0] * c + arm[1] * s, arm[1] * c - arm[0] * s])


def _slope(angle: float, arm: FloatArray) -> FloatArray:
    """Return the derivative of an arm by the angle."""
    x, z = _turn(angle, arm)
    return np.array([z, -x])
