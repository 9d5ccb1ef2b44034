"""The kinematic verification of a local mechanism: Circolare 21/01/2019 n. 7 to NTC 2018, C8.7.1.2.1.

The push curve is that of `statics.capacity`, with finite rotations and elastic joints. It therefore has an elastic
branch, as C8.7.1.2.1.3 requires for elements that are free to vibrate. The mechanism is the one at the end of the
curve: everything above one joint rotates about an edge of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..statics.capacity import CapacityCurve
from .spectra import FloatArray, Spectral

CONFIDENCE_FACTOR = 1.35  # of knowledge level LC1, which applies where the crushing strength is left out: C8.7.1.2.1.3
BEHAVIOUR_FACTOR = 2.0  # q, C8.7.1.2.1.7
# at SLV: part of d0, C8.7.1.2.1.6; factor of (C8.7.1.10); damping ratio, C8.7.1.2.1.8
LIFE_SAFETY, _PERIOD, _DAMPING = 0.4, 1.68 * math.pi, 0.08
PERIODS_LOOKED_AT = 60  # number of periods at which a spectrum of motions is read


@dataclass(frozen=True, eq=False)
class Mechanism:
    """The equivalent oscillator of a column along its push curve, from rest to the edge."""

    curve: CapacityCurve
    confidence_factor: float

    @cached_property
    def joint(self) -> int:
        """The index, from the top, of the joint about whose edge the column rotates at the end of the curve."""
        below = np.append(self.curve.ry[-1, 1:], 0.0)
        return int(np.argmax(np.abs(self.curve.ry[-1] - below)))

    @cached_property
    def shape(self) -> FloatArray:
        """The virtual horizontal displacements of the centroids (n,) and, last, of the top.

        They are the heights above the joint (m), 0 for blocks below it.
        """
        found, foot = np.zeros(self.curve.model.n + 1), 0.0
        for i in range(self.joint, -1, -1):
            block = self.curve.model.blocks[i]
            found[i] = foot + block.resolved_centroid
            foot += block.height
        found[-1] = foot
        return found

    @cached_property
    def _sums(self) -> tuple[float, float, float]:
        moving = slice(self.joint + 1)  # blocks below the joint do not move and add no force
        mass = np.array([block.mass for block in self.curve.model.blocks[moving]])
        centroids = self.shape[:-1][moving]
        return float(np.sum(mass)), float(mass @ centroids), float(mass @ centroids**2)

    @property
    def alpha0(self) -> float:
        """The multiplier that starts the mechanism: largest push over weight."""
        return self.curve.largest_acceleration / self.curve.model.g

    @property
    def mass_part(self) -> float:
        """The participating mass ratio e* of the rotating blocks (C8.7.1.5)."""
        whole, first, second = self._sums
        return first**2 / (whole * second)

    @cached_property
    def displacement(self) -> FloatArray:
        """The spectral displacements along the curve (m; C8.7.1.4), with the top as control point."""
        _, first, second = self._sums
        top = self.curve.direction * self.curve.ux[:, 0]
        return top * second / (self.shape[-1] * first)

    @cached_property
    def acceleration(self) -> FloatArray:
        """The spectral accelerations along the curve (m/s2; C8.7.1.3)."""
        return self.curve.acceleration / (self.mass_part * self.confidence_factor)

    @property
    def a0(self) -> float:
        """The spectral acceleration that starts the mechanism (m/s2)."""
        return float(self.acceleration[self.curve.strongest])

    @property
    def d0(self) -> float:
        """The spectral displacement at which the column balances without a push (m)."""
        return float(self.displacement[-1])

    @property
    def period(self) -> float:
        """The period at 0.4 of d0 (s; C8.7.1.10)."""
        k, d = self.curve.strongest, LIFE_SAFETY * self.d0
        order = np.argsort(self.displacement[k:], kind="stable")
        acceleration = np.interp(d, self.displacement[k:][order], self.acceleration[k:][order])
        return _PERIOD * math.sqrt(d / float(acceleration))

    def demand(self, action: Spectral, own_period: float, smooth: bool) -> float:
        """Return the spectral displacement demand (m) of an action at SLV (C8.7.1.2.1.8).

        A `smooth` spectrum, of a code, is read at the period of the mechanism. Of a spectrum of motions the largest
        displacement counts from `own_period`, that of the column at rest (s), to the period of the mechanism.
        """
        longest = self.period
        periods = np.array([longest])
        if not smooth:
            periods = np.geomspace(min(own_period, longest), longest, PERIODS_LOOKED_AT)
        return float(np.max(action.psa(periods, _DAMPING) * (periods / (2.0 * math.pi)) ** 2))


def rocking_period(height: float, g: float, confidence_factor: float) -> float:
    """Return the period (s; C8.7.1.10) of a rigid block whose centroid has this height (m), under gravity g (m/s2).

    The width enters d0 and a0 alike and cancels.
    """
    return _PERIOD * math.sqrt(LIFE_SAFETY * confidence_factor * height / ((1.0 - LIFE_SAFETY) * g))
