"""What a phase of the paper means: displacements v of the top faces and settlements w of the blocks, m."""

from __future__ import annotations

from ..column.kinematics import Chain, Places, from_base, over_below
from ..column.packing import FloatArray


class PaperChain(Chain):
    """A column whose rotations and openings are those of v and w, to the first order."""

    safe = 0.9  # terms that the first order neglects

    def places(self, phase: FloatArray) -> Places:
        """Rotations and openings of a phase."""
        v, w, v_rate, w_rate = (over_below(phase[..., k : k + self.n]) for k in range(0, 4 * self.n, self.n))
        return Places(v / self.height, -w, v_rate / self.height, -w_rate)

    @staticmethod
    def coordinates(height: FloatArray, theta: FloatArray, opening: FloatArray) -> tuple[FloatArray, FloatArray]:
        """v and w, or their rates, from rotations and openings, or theirs."""
        return from_base(height * theta), -from_base(opening)

    def top_displacements(self, phase: FloatArray) -> FloatArray:
        """v, (..., n)."""
        return phase[..., : self.n].copy()

    def top_velocities(self, phase: FloatArray) -> FloatArray:
        """The rates of v, (..., n)."""
        return phase[..., 2 * self.n : 3 * self.n].copy()
