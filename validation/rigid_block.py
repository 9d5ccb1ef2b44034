"""Housner's rigid block under a one-sine pulse: the truth that overturning maps are compared with."""

from __future__ import annotations

import math

import numpy as np
from numba import njit, vectorize
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Flags = NDArray[np.bool_]
STEPS = 200  # to a pulse or 1 / p, the shorter: RK4 then errs by less than 1e-8 of alpha
AFTER = 12.0  # times 1 / p after the pulse, within which a block falls or has turned back
RESTS = 1e-4  # alpha p: a block that leaves an impact more slowly stays where it is
HALVINGS = 40  # to find the impact within a step


def overturning(
    amplitude: FloatArray, speed: FloatArray, alpha: float, restitution: float, slender: bool = False
) -> NDArray[np.int64]:
    """Return the impacts before the block falls under a one-sine pulse, of the shape of the arrays; -1 where it stands.

    amplitude: over alpha g; speed: circular frequency over p; alpha: rad; restitution: rotation rate after over before
    an impact. Zhang and Makris (2001), Journal of Engineering Mechanics 127 (5): theta'' = -p^2 (sin(s alpha - theta)
    + a / g cos(s alpha - theta)), s the sign of theta; slender: its first order. Time runs in 1 / p, rotation in alpha.
    """
    found: NDArray[np.int64] = _overturning(amplitude, speed, alpha, restitution, slender)
    return found


@njit
def _acceleration(theta, side, time, pulse, alpha, slender):
    amplitude, speed = pulse
    push = amplitude * math.sin(speed * time) if time * speed < 2.0 * math.pi else 0.0
    if slender:
        return theta - side - push
    angle = alpha * (side - theta)
    return -(math.sin(angle) / alpha + push * math.cos(angle))


@njit
def _step(theta, rate, side, time, h, pulse, alpha, slender):
    """Make a step of the classical Runge-Kutta method."""
    half = 0.5 * h
    a1 = _acceleration(theta, side, time, pulse, alpha, slender)
    a2 = _acceleration(theta + half * rate, side, time + half, pulse, alpha, slender)
    a3 = _acceleration(theta + half * (rate + half * a1), side, time + half, pulse, alpha, slender)
    a4 = _acceleration(theta + h * (rate + half * a2), side, time + h, pulse, alpha, slender)
    return theta + h * (rate + h * (a1 + a2 + a3) / 6.0), rate + h * (a1 + 2.0 * (a2 + a3) + a4) / 6.0


@vectorize(["int64(float64, float64, float64, float64, boolean)"])
def _overturning(amplitude, speed, alpha, restitution, slender):
    lift = 1.0 if slender else math.tan(alpha) / alpha
    if amplitude <= lift:
        return -1
    pulse = (amplitude, speed)
    end = 2.0 * math.pi / speed + AFTER
    step = min(2.0 * math.pi / speed, 1.0) / STEPS
    time, theta, rate, side, impacts = math.asin(lift / amplitude) / speed, 0.0, 0.0, -1.0, 0
    while time < end and abs(theta) < 3.0:
        h = step
        ahead, rate_ahead = _step(theta, rate, side, time, h, pulse, alpha, slender)
        if ahead * side < 0.0:
            low, high = 0.0, step
            for _ in range(HALVINGS):
                h = 0.5 * (low + high)
                ahead, rate_ahead = _step(theta, rate, side, time, h, pulse, alpha, slender)
                if ahead * side < 0.0:
                    high = h
                else:
                    low = h
            ahead, rate_ahead, impacts = 0.0, restitution * rate_ahead, impacts + 1
            side = 1.0 if rate_ahead > 0.0 else -1.0
            if abs(rate_ahead) < RESTS:
                return -1
        theta, rate, time = ahead, rate_ahead, time + h
    return impacts if abs(theta) > 1.0 else -1
