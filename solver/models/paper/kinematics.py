"""The coordinates of the paper: displacements v of the top faces and settlements w of the blocks (m)."""

from __future__ import annotations

from ..column.kinematics import Chain, Places, from_base, over_below
from ..column.packing import FloatArray


class PaperChain(Chain):
    """A column whose rotations and openings follow from v and w to first order."""

    safe = 0.9  # part of the barrier, for the terms that the first order neglects

    def places(self, phase: FloatArray) -> Places:
        """Return the rotations and openings of a phase, and their rates."""
        v, w, v_rate, w_rate = (over_below(phase[..., k : k + self.n]) for k in range(0, 4 * self.n, self.n))
        return Places(v / self.height, -w, v_rate / self.height, -w_rate)

    @staticmethod
    def coordinates(height: FloatArray, theta: FloatArray, opening: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return v and w, or their rates, from rotations and openings, or their rates."""
        return from_base(height * theta), -from_base(opening)

    def top_displacements(self, phase: FloatArray) -> FloatArray:
        """Return v (m), (..., n)."""
        return phase[..., : self.n].copy()

    def centroid_displacements(self, phase: FloatArray) -> FloatArray:
        """Return the displacements of the centroids to first order, m (..., n)."""
        return self.top_displacements(phase) - (self.height - self.centroid) * self.places(phase).theta

    def top_velocities(self, phase: FloatArray) -> FloatArray:
        """Return the rates of v (m/s), (..., n)."""
        return phase[..., 2 * self.n : 3 * self.n].copy()
