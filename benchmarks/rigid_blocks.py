"""Rigid rocking solved independently of the project: the truths of the comparison with other programs.

One degree of freedom, theta'' = -p^2 (sin(alpha s - theta) + (a / g) cos(alpha s - theta)) with s = sign(theta), and
a loss of angular velocity, omega+ = e omega-, at each passage through upright. G. W. Housner (1963) for a block; N.
Makris and M. F. Vassiliou (2013) for columns under a beam, which rock as a block of another p and e.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .right_hand_side import Array
from .scenes import G

STEP, STANDING = 1e-3, 1e-5  # s, of the integration; while it stands
AT_REST = 1e-7  # rad/s after an impact below which the block stands
FALLEN = 1.0  # rad


class Shaking(NamedTuple):
    """The acceleration of the base, amplitude sin(2 pi frequency t + phase) until `end`."""

    amplitude: float  # g
    frequency: float  # Hz
    end: float  # s
    phase: float = 0.0  # rad

    def wave(self, t: float) -> float:
        """Return the sine (m/s2), whether it has ended or not."""
        return self.amplitude * G * math.sin(2.0 * math.pi * self.frequency * t + self.phase)

    def acceleration(self, t: float) -> float:
        """Return the acceleration of the base (m/s2)."""
        return self.wave(t) if t < self.end else 0.0


class Rocker(NamedTuple):
    """A rigid block, or a frame of equal columns."""

    slenderness: float  # rad
    p: float  # rad/s
    restitution: float
    diagonal: float  # m, twice the distance from edge to centroid of a column


def block(width: float, height: float) -> Rocker:
    """Return Housner's block."""
    alpha, diagonal = math.atan(width / height), math.hypot(width, height)
    return Rocker(alpha, math.sqrt(1.5 * G / diagonal), 1.0 - 1.5 * math.sin(alpha) ** 2, diagonal)


def frame(width: float, height: float, ratio: float) -> Rocker:
    """Return the rocking frame; ratio: mass of the beam over that of all columns."""
    one = block(width, height)
    p = one.p * math.sqrt((1.0 + 2.0 * ratio) / (1.0 + 3.0 * ratio))
    kept = (one.restitution + 3.0 * ratio * math.cos(2.0 * one.slenderness)) / (1.0 + 3.0 * ratio)
    return Rocker(one.slenderness, p, kept, one.diagonal)


def follow(rocker: Rocker, shaking: Shaking, rows: Array, limit: float = FALLEN) -> Array:
    """Integrate from rest by RK4, each impact located; rotations (rad) at the rows, constant beyond the limit."""
    least = math.tan(rocker.slenderness) * G
    times, turns = [0.0], [0.0]
    t, theta, omega, side = 0.0, 0.0, 0.0, 0.0
    while t < rows[-1] and abs(theta) < limit:
        h = min(STEP, (shaking.end - t if t < shaking.end else math.inf), float(rows[-1]) - t) + 1e-15
        if not side:  # it stands until the base acceleration turns it
            along = shaking.acceleration(t)
            if abs(along) <= least:
                t += min(h, STANDING)
                continue
            side = -math.copysign(1.0, along)
        after = _stepped(rocker, shaking, t, theta, omega, side, h)
        if after[0] * side < 0.0:  # it passes upright within the step
            low, high = 0.0, h
            for _ in range(50):
                middle = 0.5 * (low + high)
                inside = _stepped(rocker, shaking, t, theta, omega, side, middle)[0] * side >= 0.0
                low, high = (middle, high) if inside else (low, middle)
            h = high
            omega = rocker.restitution * _stepped(rocker, shaking, t, theta, omega, side, h)[1]
            theta, side = 0.0, (math.copysign(1.0, omega) if abs(omega) > AT_REST else 0.0)
            omega = omega if side else 0.0
        else:
            theta, omega = after
        t += h
        times.append(t)
        turns.append(theta)
    found: Array = np.interp(rows, times, turns)
    return found


def _stepped(
    rocker: Rocker, shaking: Shaking, t: float, theta: float, omega: float, side: float, h: float
) -> tuple[float, float]:
    """Return rotation and its rate a step of RK4 later."""
    moves = t < shaking.end - 1e-12

    def turning(after: float, angle: float) -> float:
        lean = rocker.slenderness * side - angle
        along = shaking.wave(t + after) / G if moves else 0.0
        return -(rocker.p**2) * (math.sin(lean) + along * math.cos(lean))

    k1 = turning(0.0, theta)
    k2 = turning(0.5 * h, theta + 0.5 * h * omega)
    k3 = turning(0.5 * h, theta + 0.5 * h * (omega + 0.5 * h * k1))
    k4 = turning(h, theta + h * (omega + 0.5 * h * k2))
    return theta + h * (omega + h / 6.0 * (k1 + k2 + k3)), omega + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def displacement(rocker: Rocker, theta: Array) -> Array:
    """Return the displacement of what the columns carry (m), along the motion."""
    lean = rocker.slenderness - np.abs(theta)
    moved: Array = np.sign(theta) * rocker.diagonal * (math.sin(rocker.slenderness) - np.sin(lean))
    return moved


def falls(rocker: Rocker, shaking: Shaking, duration: float, limit: float = FALLEN) -> bool:
    """Return True if it turns by more than the limit (rad) within the duration."""
    return bool(abs(follow(rocker, shaking, np.array([0.0, duration]), limit)[-1]) >= 0.99 * limit)
