"""Bearings that are displaced by hand, for their loops."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from solver.models.outputs import places_of
from solver.models.structure.blocks.faces import FloatArray
from solver.models.structure.model import Structure
from solver.models.structure.outputs import OUTPUTS
from solver.models.structure.stepper import SpatialStepper


class Pulled:
    """The bearings of a structure, equal ones, whose blocks are displaced along x under a constant load on each, N."""

    def __init__(self, structure: Structure, load: float) -> None:
        self.stepper, self.load = SpatialStepper(structure), load
        places, self.many = places_of(OUTPUTS, structure.sizes), len(structure.bearings)
        self.along, self.across = places["Tx"], places["N"]
        joint = structure.bearings[0]
        assert joint.bearing is not None
        self.pendulum = joint.bearing.pendulum
        self.sag = load / (joint.bed.stiffness * math.pi * joint.face.radius**2)

    def force(self, u: float, v: float = 0.0) -> float:
        """Return the horizontal force on all of them, N; what slides remembers it."""
        see = self.stepper.see
        see.ux[:], see.uz[:] = u, 0.5 * self.pendulum * u * u - self.sag  # so far do they rise
        see.vx[:], see.vz[:] = v, self.pendulum * u * v
        self.stepper.observe(keep=True)
        row = self.stepper.row
        assert row[self.across][-self.many :] == pytest.approx(self.load, rel=1e-9)
        return float(np.sum(row[self.along][-self.many :]))


def loop(pulled: Pulled, amplitude: float, reach: float) -> float:
    """Return what one cycle of this amplitude dissipates, J; reach: m, what slides moves so far elastically.

    The force is piecewise linear in the place, with its corners among the places: trapezoids are exact.
    """
    back = amplitude * np.linspace(1.0, -1.0, 101)
    back = np.sort(np.append(back, amplitude - 2.0 * reach))[::-1]
    for place in np.linspace(0.0, amplitude, 51).tolist():
        pulled.force(place)
    u = np.concatenate([back, -back])
    t = np.array([pulled.force(place) for place in u.tolist()])
    return float(np.trapezoid(t, u))


def ellipse(pulled: Pulled, amplitude: float, omega: float) -> float:
    """Return what one cycle of this amplitude, m, and frequency, rad/s, dissipates, J."""
    angle = np.linspace(0.0, 2.0 * math.pi, 257)
    u, v = amplitude * np.sin(angle), amplitude * omega * np.cos(angle)
    t = np.array([pulled.force(*pair) for pair in zip(u.tolist(), v.tolist(), strict=True)])
    return float(np.trapezoid(t * v / omega, angle))


def stopped(
    mass: float, spring: float, dashpot: float, ring: tuple[float, float, float], start: FloatArray, times: FloatArray
) -> FloatArray:
    """Return the places u at these times, m, of a mass on a spring and a dashpot within a ring, in closed form.

    m u'' + c u' + k u = -k_r (|u| - u_r + eta_r |u|') sign(u), where |u| > u_r and the ring pushes: linear in pieces.

    Parameters
    ----------
    ring
        u_r, m; k_r, N/m; eta_r, s.
    start
        u and u' at the first of the times, m and m/s.
    """
    rim, stiffness, damping = ring

    def pushes(y: FloatArray) -> float:
        beyond = abs(y[0]) - rim
        return min(beyond, beyond + damping * math.copysign(y[1], y[0] * y[1]))

    def moved(y: FloatArray, t: float, touches: bool) -> FloatArray:
        k, c = (spring + stiffness, dashpot + stiffness * damping) if touches else (spring, dashpot)
        middle = np.array([math.copysign(stiffness * rim / k, y[0]), 0.0]) if touches else np.zeros(2)
        return middle + expm(t * np.array([[0.0, 1.0], [-k / mass, -c / mass]])) @ (y - middle)

    y, t, found, touches = start, float(times[0]), [], False
    for end in times.tolist():
        while t < end:
            sign = 1.0 if touches else -1.0  # it changes when sign times `pushes` falls below zero
            grid = np.linspace(0.0, end - t, 101)
            left = np.array([sign * pushes(moved(y, s, touches)) for s in grid.tolist()])
            after = np.flatnonzero((left[1:] < 0.0) & (left[:-1] >= 0.0))
            if not after.size:
                y, t = moved(y, end - t, touches), end
                break
            a, b = grid[after[0]], grid[after[0] + 1]
            s = brentq(lambda s, y=y, on=touches: pushes(moved(y, s, on)), a, b, xtol=1e-15) if left[after[0]] else a
            y, t, touches = moved(y, s, touches), t + s, not touches
        found.append(y[0])
    return np.array(found)
