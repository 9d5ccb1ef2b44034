"""Least pulses that overturn Housner's slender rigid block, in parts of alpha g (../shared/validation/cases.md).

Lengths are multiples of 1 / p, speeds multiples of p; p is the frequency parameter of the block, 1/s.
"""

from __future__ import annotations

import math

from scipy.optimize import brentq


def rectangle_amplitude(length: float) -> float:
    """Return the amplitude of a rectangle."""
    return 1.0 / (1.0 - math.exp(-length))


def half_sine_amplitude(speed: float) -> float:
    """Return the amplitude of half a sine."""

    def starting_at(psi: float) -> float:
        return (math.cos(psi) + math.exp(-(math.pi - psi) / speed)) / math.sin(psi) - speed

    return float(1.0 / math.sin(brentq(starting_at, 1e-3, 0.5 * math.pi)))


def one_sine_amplitude(speed: float) -> float:
    """Return the amplitude of a whole sine that overturns the block before it has hit the base on the other side."""

    def starting_at(psi: float) -> float:
        return math.cos(psi) - speed * math.sin(psi) - math.exp(-(2.0 * math.pi - psi) / speed)

    return float(1.0 / math.sin(brentq(starting_at, 1e-6, 0.5 * math.pi)))
