"""Solids between two parallel faces of a section: volume, centroid and inertia of blocks, drums and hollow drums."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from .kernels.joint.section import whole

# Gauss's rule with three points is exact for what is of the fifth order in the height; nothing here is above the fourth
_OFF = 0.5 * math.sqrt(0.6)
POINTS = ((0.5 - _OFF, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.5 + _OFF, 5.0 / 18.0))


class Solid(NamedTuple):
    """Of a homogeneous solid of density 1: volume m3, centroid m above the bottom face, inertia m5 about the centroid.

    The inertia is that of turning in the plane of the motion.
    """

    volume: float
    centroid: float
    inertia: float


def solid_between(
    section: int, height: float, bottom: tuple[float, float], top: tuple[float, float], bore: float = 0.0
) -> Solid:
    """The solid between a bottom and a top face of (width, depth), m, that tapers evenly; bore: that of an annulus."""

    def face(part: float) -> tuple[float, ...]:
        width, depth = (low + part * (high - low) for low, high in zip(bottom, top, strict=True))
        return whole(section, width, depth, bore, ())

    def integral(of: Callable[[float, float, float], float]) -> float:
        """Over the height: of (height, area and second moment of the section there)."""
        slices = ((part * height, weight, face(part)) for part, weight in POINTS)
        return height * math.fsum(weight * of(z, area, second) for z, weight, (area, _, second) in slices)

    volume = integral(lambda z, area, second: area)
    centroid = integral(lambda z, area, second: area * z) / volume
    return Solid(volume, centroid, integral(lambda z, area, second: second + area * (z - centroid) ** 2))


def with_load(mass: float, centroid: float, inertia: float, load: float, place: float) -> tuple[float, float, float]:
    """Mass kg, centroid m and inertia kg m2 of a body and a load, a mass of no size at a height of `place` m."""
    both = mass + load
    middle = (mass * centroid + load * place) / both
    return both, middle, inertia + mass * (centroid - middle) ** 2 + load * (place - middle) ** 2
