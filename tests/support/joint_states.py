"""States of one joint as hypothesis draws them."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import assume, settings
from hypothesis import strategies as st

examples = settings(deadline=None, max_examples=100, derandomize=True)


@dataclass(frozen=True)
class State:
    """Arguments of `joint_forces`."""

    stiffness: float
    width: float
    depth: float
    damping: float
    opening: float
    slope: float
    opening_rate: float
    slope_rate: float

    @property
    def force(self) -> float:
        """N of the largest penetration and speed over the whole joint: what rounding is measured against."""
        edge = 0.5 * self.width
        deepest = edge * abs(self.slope) + abs(self.opening)
        fastest = edge * abs(self.slope_rate) + abs(self.opening_rate)
        return self.stiffness * self.width * self.depth * (deepest + self.damping * fastest)


@st.composite
def states(draw: st.DrawFn, damped: bool = True) -> State:
    """Return joints in every regime: the opening is up to three times what the turn lifts the edge by."""
    width, depth = draw(st.floats(0.1, 5.0)), draw(st.floats(0.1, 5.0))
    stiffness = 10.0 ** draw(st.floats(6.0, 11.0))
    lifted = 10.0 ** draw(st.floats(-7.0, -1.0))
    slope = draw(st.sampled_from([-1.0, 0.0, 1.0])) * 2.0 * lifted / width
    opening = draw(st.floats(-3.0, 2.0)) * lifted
    assume(slope != 0.0 or abs(opening) > 1e-6 * lifted)  # faces that touch without force are in contact, or not
    if not damped:
        return State(stiffness, width, depth, 0.0, opening, slope, 0.0, 0.0)
    damping = 10.0 ** draw(st.floats(-5.0, 0.0))
    speed = 10.0 ** draw(st.floats(-2.0, 2.0)) * lifted / damping
    turning = draw(st.floats(-1.0, 1.0)) * 2.0 * speed / width
    return State(stiffness, width, depth, damping, opening, slope, draw(st.floats(-1.0, 1.0)) * speed, turning)
