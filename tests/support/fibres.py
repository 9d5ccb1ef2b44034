"""A block on a bed of vertical fibres: a truth for sliding and rocking that shares nothing with the solver.

Each fibre stands on the ground, bears pressure k (p + eta p') where it is pressed, and a slider with a spring along the
ground, up to the friction of its own pressure. So forces act along and across the ground, whatever the tilt of the
block. Fibres are closer to each other at the edges, and steps are a small part of the fastest period.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

GRAVITY = 9.80665  # m/s2
FALLEN = 1.3  # rad
PART = 0.04  # of the fastest angular period: a step


@dataclass(frozen=True)
class Block:
    """A rectangle on its bed: m, kg/m3, N/m3, s. shear: stiffness along the ground over that across it."""

    width: float
    depth: float
    height: float
    density: float
    stiffness: float
    damping: float
    friction: float
    shear: float = 1.0

    @property
    def mass(self) -> float:
        return self.density * self.width * self.depth * self.height


@dataclass(frozen=True)
class Followed:
    """Largest rotation, rad; place of the centroid, m, and rotation at the end; whether it has fallen."""

    largest: float
    x: float
    theta: float
    fallen: bool


def follow(block: Block, amplitude: float, frequency: float, duration: float, fibres: int = 160) -> Followed:
    """Follow the block at rest under one sine of the ground, m/s2 and Hz, for so long or until it has fallen."""
    half = 0.5 * block.width
    ends = half * np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, fibres + 1))
    places, areas = 0.5 * (ends[1:] + ends[:-1]), block.depth * np.diff(ends)
    mass = block.mass
    inertia = mass * (block.width**2 + block.height**2) / 12.0
    area = block.width * block.depth
    # on one edge a fibre meets translation and rotation at once
    fastest = math.sqrt(
        max(1.0, block.shear) * block.stiffness * area * (1.0 / mass + 0.25 * block.height**2 / inertia)
    )
    law = np.array([block.stiffness, block.damping, block.friction, block.shear, mass, inertia, 0.5 * block.height])
    found = _follow(places, areas, law, amplitude, frequency, duration, PART / fastest)
    return Followed(float(found[0]), float(found[1]), float(found[2]), bool(found[0] > FALLEN))


@numba.njit
def _follow(
    places: NDArray[np.float64],
    areas: NDArray[np.float64],
    law: NDArray[np.float64],
    amplitude: float,
    frequency: float,
    duration: float,
    step: float,
) -> tuple[float, float, float]:
    k, eta, friction, shear, mass, inertia, low = law
    count = len(places)
    stretch = np.zeros(count)
    x, theta, vx, vz, omega = 0.0, 0.0, 0.0, 0.0, 0.0
    z = low - mass * GRAVITY / (k * np.sum(areas))
    largest, t = 0.0, 0.0
    while t < duration and largest <= FALLEN:
        sine, cosine = math.sin(theta), math.cos(theta)
        push, lift, couple = 0.0, 0.0, 0.0
        for i in range(count):
            # from the centroid to the foot of the block at this fibre; theta is clockwise
            rx, rz = places[i] * cosine - low * sine, -places[i] * sine - low * cosine
            p = -(z + rz)
            if p <= 0.0:
                stretch[i] = 0.0
                continue
            normal = k * (p - eta * (vz - omega * rx)) * areas[i]
            if normal <= 0.0:
                stretch[i] = 0.0
                continue
            along = k * shear * areas[i]
            stretch[i] += step * (vx + omega * rz)
            most = friction * normal / along
            stretch[i] = min(most, max(-most, stretch[i]))
            drag = -along * stretch[i]
            push, lift, couple = push + drag, lift + normal, couple + rz * drag - rx * normal
        ground = amplitude * math.sin(2.0 * math.pi * frequency * t) if t * frequency < 1.0 else 0.0
        vx += step * (push / mass - ground)
        vz += step * (lift / mass - GRAVITY)
        omega += step * couple / inertia
        x, z, theta = x + step * vx, z + step * vz, theta + step * omega
        largest, t = max(largest, abs(theta)), t + step
    return largest, x, theta
