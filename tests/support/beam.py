"""A beam on two columns: a partner that is coupled with their ports once a step, and all of them as one system.

The beam is rigid, weightless and has a mass and an inertia; at each end an elastic bearing connects it with a port:
k and c times how far the port is from the end. Columns say place, velocity and acceleration of their ports, relative to
where they rest; the partner says the forces on them and their slopes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Seen(NamedTuple):
    """The motion of a port along x and z: place m, velocity m/s, acceleration m/s2, (2,) each."""

    place: Array
    velocity: Array
    acceleration: Array


@dataclass
class Beam:
    """State (6,): displacement along x and z, m, rotation, rad clockwise, and their rates."""

    state: Array
    mass: float = 4e3  # kg
    inertia: float = 8e3  # kg m2
    length: float = 5.0  # m, between the ports
    spring: tuple[float, float] = (2e7, 6e7)  # N/m, along x and z
    damper: tuple[float, float] = (2e4, 6e4)  # N s/m

    def ends(self, motion: Array) -> Array:
        """Return the motion of both ends along x and z, (2, 2), by that of the beam (3,)."""
        lift = 0.5 * self.length * motion[2]
        return np.array([[motion[0], motion[1] + lift], [motion[0], motion[1] - lift]])

    def forces(self, state: Array, places: Array, velocities: Array) -> Array:
        """Return the forces on the ports, (2, 2) N."""
        found: Array = np.array(self.spring) * (self.ends(state[:3]) - places)
        return found + np.array(self.damper) * (self.ends(state[3:]) - velocities)

    def rates(self, state: Array, places: Array, velocities: Array) -> Array:
        """Return the rates of the state."""
        on_beam = -self.forces(state, places, velocities)
        turning = 0.5 * self.length * (on_beam[0, 1] - on_beam[1, 1])
        return np.array([*state[3:], *(on_beam.sum(axis=0) / self.mass), turning / self.inertia])

    def said(self, ports: Sequence[Seen]) -> tuple[Array, Array]:
        """Return the forces on the ports and their slopes, (2, 2) N and N/s."""
        place, velocity, acceleration = (np.array([getattr(port, name) for port in ports]) for name in Seen._fields)
        rates = self.rates(self.state, place, velocity)
        slopes = np.array(self.spring) * (self.ends(self.state[3:]) - velocity)
        slopes = slopes + np.array(self.damper) * (self.ends(rates[3:]) - acceleration)
        return self.forces(self.state, place, velocity), slopes

    def step(self, ports: Sequence[Seen], h: float) -> None:
        """Advance by h s, by Runge and Kutta, while the ports go on as they accelerate now."""
        place, velocity, acceleration = (np.array([getattr(port, name) for port in ports]) for name in Seen._fields)

        def rates(state: Array, t: float) -> Array:
            return self.rates(state, place + t * velocity + 0.5 * t * t * acceleration, velocity + t * acceleration)

        a = rates(self.state, 0.0)
        b = rates(self.state + 0.5 * h * a, 0.5 * h)
        c = rates(self.state + 0.5 * h * b, 0.5 * h)
        d = rates(self.state + h * c, h)
        self.state = self.state + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)


def thrown() -> Beam:
    """Return a beam that moves as the columns rest."""
    return Beam(np.array([0.0, 0.0, 0.0, 0.03, -0.02, 0.004]))


Column = tuple[Callable[[], Seen], Callable[[Array, Array, float], None]]  # see; push by forces and slopes over h s


def coupled(beam: Beam, columns: Sequence[Column], h: float, steps: int) -> Array:
    """Place of both ports after each step, (steps + 1, 2, 2) m: one exchange before each."""
    rest = [see().place for see, _ in columns]
    found = [np.zeros((2, 2))]
    for _ in range(steps):
        ports = [see() for see, _ in columns]
        ports = [port._replace(place=port.place - still) for port, still in zip(ports, rest, strict=True)]
        forces, slopes = beam.said(ports)
        beam.step(ports, h)
        for (_, push), force, slope in zip(columns, forces, slopes, strict=True):
            push(force, slope, h)
        found.append(np.array([see().place - still for (see, _), still in zip(columns, rest, strict=True)]))
    return np.array(found)
