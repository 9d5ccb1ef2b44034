"""Loads on the ports of a column by virtual work: the reference of lagrange.py, and off the axis that of sliding.py."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver import Column
from support.lagrange import TINY, Array, Reference, below, from_base


def place(column: Column, q: NDArray[Any], number: int, turn: float = 0.0) -> tuple[Any, Any]:
    """Place (x, z) m of a port in space; q: theta, delta, and slips of a column that has some; turn: of the base."""
    n, port = column.n, column.ports[number]
    height, centroid = (
        np.array([getattr(block, name) for block in column.blocks]) for name in ("height", "resolved_centroid")
    )
    lean = np.array([block.joint.inclination or 0.0 for block in column.blocks])
    tilt = np.array([block.tilt or 0.0 for block in column.blocks]) + lean
    theta, delta = q[:n], q[n : 2 * n]
    slip = q[2 * n :] if len(q) > 2 * n else np.zeros(n)
    phi = 0.5 * (theta + below(theta)) + lean + turn
    along = theta + tilt + turn
    x = delta * np.sin(phi) + slip * np.cos(phi)
    z = delta * np.cos(phi) - slip * np.sin(phi)
    top_x, top_z = (from_base(x + height * np.sin(along)), from_base(z + height * np.cos(along)))
    i, (right, up) = port.body, port.at
    up = up - (height[i] - centroid[i])
    return (
        top_x[i] + up * np.sin(along[i]) + right * np.cos(along[i]),
        top_z[i] + up * np.cos(along[i]) - right * np.sin(along[i]),
    )


def generalized(column: Column, q: Array, loads: Array, turn: float = 0.0) -> Array:
    """Return the forces on the coordinates of loads (ports, 3): Fx, Fz (N), My (N m, clockwise)."""
    found = np.zeros(len(q))
    for number, (fx, fz, my) in enumerate(loads):
        found[column.ports[number].body] += my
        for k, unit in enumerate(np.eye(len(q))):
            x, z = place(column, q + 1j * TINY * unit, number, turn)
            found[k] += (fx * x.imag + fz * z.imag) / TINY
    return found


def accelerations(column: Column, q: Array, rate: Array, ax: float, az: float, loads: Array) -> Array:
    """Return q'' (2n,) of a column on its axis under loads."""
    reference = Reference.of(column)
    forces = reference.forces(q, rate, ax, az) + generalized(column, q, loads)
    found: Array = np.linalg.solve(reference.mass_matrix(q), forces)
    return found


def motion_of(column: Column, q: Array, rate: Array, second: Array, number: int) -> Array:
    """Return x, z, vx, vz, ax, az of a port, from the column as built."""
    built = np.zeros(len(q))
    if len(q) > 2 * column.n:
        built[2 * column.n :] = [block.joint.offset or 0.0 for block in column.blocks]
    here, there = place(column, q, number), place(column, built, number)
    speed = place(column, q + 1j * TINY * rate, number)
    push = place(column, q + 1j * TINY * second, number)
    # the second derivative along the rates, by Cauchy's integral over a circle
    radius = 0.1 / (1.0 + np.max(np.abs(rate)))
    around = np.exp(2j * np.pi * np.arange(32) / 32)
    on_circle = np.array([place(column, q + radius * unit * rate, number) for unit in around])
    bend = 2.0 * np.mean(on_circle / around[:, None] ** 2, axis=0).real / radius**2
    return np.array(
        [
            here[0] - there[0],
            here[1] - there[1],
            speed[0].imag / TINY,
            speed[1].imag / TINY,
            push[0].imag / TINY + bend[0],
            push[1].imag / TINY + bend[1],
        ]
    )
