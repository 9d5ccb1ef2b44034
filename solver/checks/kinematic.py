"""The kinematic verification of a local mechanism: Circolare 21/01/2019 n. 7 to NTC 2018, C8.7.1.2.1.

The curve of pushes is that of `statics.capacity`: finite rotations, elastic joints, so that it has an elastic branch as
C8.7.1.2.1.3 asks for elements that are free to vibrate. The mechanism is the one in which the curve ends: all above one
joint turns about an edge of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..common.errors import check_number
from ..models.column.model import Column
from ..statics.capacity import CapacityCurve, capacity_curve
from .spectra import FloatArray, Spectral

CONFIDENCE_FACTOR = 1.35  # of knowledge level LC1, which applies where the crushing strength is left out: C8.7.1.2.1.3
BEHAVIOUR_FACTOR = 2.0  # q, C8.7.1.2.1.7
LIFE_SAFETY, COLLAPSE = 0.4, 0.6  # parts of d0 at SLV and SLC, C8.7.1.2.1.6
_PERIOD = {LIFE_SAFETY: 1.68 * math.pi, COLLAPSE: 1.56 * math.pi}  # (C8.7.1.10), (C8.7.1.11)
_DAMPING = {LIFE_SAFETY: 0.08, COLLAPSE: 0.10}  # C8.7.1.2.1.8
PERIODS_LOOKED_AT = 60


@dataclass(frozen=True, eq=False)
class Mechanism:
    """The oscillator that stands for a column on its way to the edge."""

    curve: CapacityCurve
    confidence_factor: float

    @cached_property
    def joint(self) -> int:
        """Place of the joint about whose edge it turns where the curve ends, from the top."""
        below = np.append(self.curve.theta[-1, 1:], 0.0)
        return int(np.argmax(np.abs(self.curve.theta[-1] - below)))

    @cached_property
    def shape(self) -> FloatArray:
        """Virtual horizontal displacements of the centroids (n,), and last of the top: heights above the joint, m."""
        found, foot = np.zeros(self.curve.column.n + 1), 0.0
        for i in range(self.joint, -1, -1):
            block = self.curve.column.blocks[i]
            found[i] = foot + block.resolved_centroid
            foot += block.height
        found[-1] = foot
        return found

    @cached_property
    def _sums(self) -> tuple[float, float, float]:
        moving = slice(self.joint + 1)  # what stands still below generates no force on the mechanism
        mass = np.array([block.mass for block in self.curve.column.blocks[moving]])
        centroids = self.shape[:-1][moving]
        return float(np.sum(mass)), float(mass @ centroids), float(mass @ centroids**2)

    @property
    def alpha0(self) -> float:
        """Largest push over weight: multiplier that sets the mechanism in motion."""
        return self.curve.largest_acceleration / self.curve.column.g

    @property
    def mass_part(self) -> float:
        """e*, the part of the mass of the blocks that turn that takes part (C8.7.1.5)."""
        whole, first, second = self._sums
        return first**2 / (whole * second)

    @cached_property
    def displacement(self) -> FloatArray:
        """Spectral displacements along the curve, m (C8.7.1.4), of the top as the point of control."""
        _, first, second = self._sums
        top = self.curve.direction * self.curve.ux[:, 0]
        return top * second / (self.shape[-1] * first)

    @cached_property
    def acceleration(self) -> FloatArray:
        """Spectral accelerations along the curve, m/s2 (C8.7.1.3)."""
        return self.curve.acceleration / (self.mass_part * self.confidence_factor)

    @property
    def a0(self) -> float:
        """Spectral acceleration that sets the mechanism in motion, m/s2."""
        return float(self.acceleration[self.curve.strongest])

    @property
    def d0(self) -> float:
        """Spectral displacement at which it balances without a push, m."""
        return float(self.displacement[-1])

    def period(self, part: float = LIFE_SAFETY) -> float:
        """Period, s, at `part` of d0: (C8.7.1.10) at SLV, (C8.7.1.11) at SLC."""
        k, d = self.curve.strongest, part * self.d0
        order = np.argsort(self.displacement[k:], kind="stable")
        acceleration = np.interp(d, self.displacement[k:][order], self.acceleration[k:][order])
        return _PERIOD[part] * math.sqrt(d / float(acceleration))

    def demand(self, action: Spectral, own_period: float, smooth: bool, part: float = LIFE_SAFETY) -> float:
        """Spectral displacement, m, that an action asks for at SLV or SLC (C8.7.1.2.1.8).

        smooth: of a code, taken at the period itself; of motions it is the largest from the period of the column at
        rest, s, on.
        """
        longest = self.period(part)
        periods = np.array([longest])
        if not smooth:
            periods = np.geomspace(min(own_period, longest), longest, PERIODS_LOOKED_AT)
        return float(np.max(action.psa(periods, _DAMPING[part]) * (periods / (2.0 * math.pi)) ** 2))

    def capacity(self, part: float = LIFE_SAFETY) -> float:
        """Spectral displacement allowed, m (C8.7.1.2.1.6)."""
        return part * self.d0


def rocking_period(height: float, g: float, confidence_factor: float, part: float = LIFE_SAFETY) -> float:
    """Period (C8.7.1.10) of a rigid block with its centroid at a height, m: the width is in d0 and in a0, and drops."""
    return _PERIOD[part] * math.sqrt(part * confidence_factor * height / ((1.0 - part) * g))


def check_confidence_factor(value: object) -> float:
    """The factor FC as a float. Raises InputError."""
    return check_number("confidence_factor", value, (1.0, 3.0), "a confidence factor from 1 to 3")


def mechanism(column: Column, confidence_factor: float = CONFIDENCE_FACTOR) -> Mechanism:
    """The mechanism of a column, of the weaker of its two directions. Raises as `capacity_curve` does."""
    factor = check_confidence_factor(confidence_factor)
    curves = [capacity_curve(column, direction) for direction in ((1, -1) if column.off_axis else (1,))]
    return Mechanism(min(curves, key=lambda curve: curve.largest_acceleration), factor)
