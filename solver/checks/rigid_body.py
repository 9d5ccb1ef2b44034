"""The approximate method for an unanchored rigid body: ASCE/SEI 43-05, appendix A.

The part of the column above one joint is a single rigid body, of half width b and with its centroid at a height h; off
its axis b is to the edge that the lesser push turns it about, on both sides.
Rocking (A.2): an oscillator with the energy of the body rotated by theta, damped by Housner's impacts, two per cycle.
Sliding (A.1): an oscillator whose strength is twice the friction force. The corrections of A.2 for vertical motion (FV)
and of A.1 for the second horizontal component (FH) are left out: the model is planar.
"""

from __future__ import annotations

import math

import numpy as np

from ..common.errors import InputError
from ..statics.rocking import RigidPart
from .spectra import FloatArray, Spectral

ANGLES = 400  # number of rotations tried, and of frequencies for sliding
SLIDING_DAMPING = 0.10
SLOWEST, FASTEST = 0.05, 33.0  # Hz, range of frequencies for sliding


class RigidBody(RigidPart):
    """The part of a column above a joint, as one rigid body that rocks.

    On its axis the restitution is C_R = 1 - 2 a^2 / C_I, with a = b / h and C_I = I / (M h^2).
    """

    @property
    def edge_angle(self) -> float:
        """The rotation at which the body balances on its edge (rad)."""
        return math.atan(self.slenderness)

    @property
    def damping(self) -> float:
        """The damping ratio beta_e, with gamma = -2 ln C_R. Raises InputError if C_R is not positive."""
        if self.restitution <= 0.0:
            raise InputError(f"joint {self.joint}: the part above is too stocky to rock as ASCE 43 assumes")
        gamma = -2.0 * math.log(self.restitution)
        return gamma / math.hypot(2.0 * math.pi, gamma)

    def frequency(self, theta: float, g: float) -> float:
        """Return the frequency f_e (Hz) of the oscillator for a rotation theta (rad)."""
        return math.sqrt(2.0 * self.mass * g * self.centroid * self._rise(theta) / self.inertia) / (
            2.0 * math.pi * theta
        )

    def capacity(self, theta: float, g: float) -> float:
        """Return the spectral acceleration (m/s2) that rotates the body by theta (rad)."""
        return 2.0 * g * self._rise(theta) / theta

    def _rise(self, theta: float) -> float:
        """Return the rise of the centroid over h: f1 - 1 = cos theta + a sin theta - 1."""
        return math.cos(theta) + self.slenderness * math.sin(theta) - 1.0

    def rotation(self, action: Spectral, g: float) -> float:
        """Return the largest rotation (rad) under an action: inf if it falls, 0 if it does not begin to rock.

        It is the least rotation from which on the capacity exceeds the demand, up to the edge.
        """
        if float(action.psa(0.0)) <= g * self.slenderness:
            return 0.0
        # demand less capacity at rotations up to the edge
        angles = self.edge_angle * np.arange(1, ANGLES + 1) / ANGLES
        frequency = np.array([self.frequency(float(theta), g) for theta in angles])
        demand = action.psa(1.0 / frequency, min(self.damping, 0.999))
        missing = demand - np.array([self.capacity(float(theta), g) for theta in angles])
        # last rotation at which the demand is larger
        short = np.flatnonzero(missing > 0.0)
        if not short.size:
            return float(angles[0])
        last = int(short[-1])
        return math.inf if last == ANGLES - 1 else _crossing(angles, missing, last)


def sliding_distance(friction: float, vertical: float, action: Spectral, g: float) -> float:
    """Return the largest slip (m), 0 if the spectrum does not reach the strength; (A-1) to (A-3).

    mu_e = mu (1 - 0.4 A_v / g), c_s = 2 mu_e g, delta = c_s / (2 pi f_es)^2; f_es is the lowest frequency at which the
    spectrum of 10 % damping reaches c_s. `friction` is mu, `vertical` the largest vertical acceleration A_v (m/s2), `g`
    the acceleration of gravity (m/s2).
    """
    strength = 2.0 * friction * (1.0 - 0.4 * vertical / g) * g
    if strength <= 0.0:
        return math.inf
    frequency = np.geomspace(SLOWEST, FASTEST, ANGLES)
    missing = np.log(action.psa(1.0 / frequency, SLIDING_DAMPING) / strength)
    reached = np.flatnonzero(missing >= 0.0)
    if not reached.size:
        return 0.0
    first = int(reached[0])
    found = math.exp(_crossing(np.log(frequency), missing, first - 1)) if first else SLOWEST
    return strength / (2.0 * math.pi * found) ** 2


def _crossing(x: FloatArray, y: FloatArray, k: int) -> float:
    """Return the zero of y between indices k and k + 1, by linear interpolation."""
    return float(x[k] - y[k] * (x[k + 1] - x[k]) / (y[k + 1] - y[k]))
