"""The quintic of a step through displacements, velocities and accelerations at its ends."""

from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf


class Quintic(NamedTuple):
    """The polynomial q = c0 + c1 s + ... + c5 s^5 + bump s^3 (1 - s)^3 over 0 <= s <= 1; s is time times `per_step`."""

    per_step: float
    c0: float
    c1: float
    c2: float
    c3: float
    c4: float
    c5: float
    bump: float


@leaf
def quintic_through(h, q0, v0, a0, q1, v1, a1, bump):
    """Return the quintic through coordinates q, rates v and accelerations a at both ends of `h` s."""
    c1, c2 = h * v0, 0.5 * h * h * a0
    # difference at the end from a parabola through the start, in displacement, velocity and acceleration
    miss_q = (q1 - q0) - (c1 + c2)
    miss_v = h * v1 - (c1 + 2.0 * c2)
    miss_a = h * h * a1 - 2.0 * c2
    # coefficients that remove the differences
    c3 = 10.0 * miss_q - 4.0 * miss_v + 0.5 * miss_a
    c4 = -15.0 * miss_q + 7.0 * miss_v - miss_a
    c5 = 6.0 * miss_q - 3.0 * miss_v + 0.5 * miss_a
    return Quintic(1.0 / h, q0, c1, c2, c3, c4, c5, bump)


class Weights(NamedTuple):
    """The coefficients of a coordinate or rate within a step: of its rise, and of rates, accelerations and bump."""

    rise: float
    v0: float
    v1: float
    a0: float
    a1: float
    bump: float


@leaf
def weights_at(h, s):
    """Return the weights of a coordinate less its start, and of its rate, at fraction s of a step of `h` s.

    They give `value_of` as sums over the values at both ends.
    """
    r = 1.0 - s
    hill = s * r
    cube, square = s * s * s, 0.5 * h * h
    # of the coordinate
    q = Weights(
        cube * (10.0 + s * (6.0 * s - 15.0)),
        h * (s - cube * (6.0 + s * (3.0 * s - 8.0))),
        -h * cube * (4.0 + s * (3.0 * s - 7.0)),
        square * s * s * r * r * r,
        square * cube * r * r,
        hill * hill * hill,
    )
    # of the rate: derivatives of the former, over h
    v = Weights(
        30.0 * hill * hill / h,
        1.0 - s * s * (18.0 + s * (15.0 * s - 32.0)),
        -s * s * (12.0 + s * (15.0 * s - 28.0)),
        0.5 * h * s * r * r * (2.0 - 5.0 * s),
        0.5 * h * s * s * r * (3.0 - 5.0 * s),
        3.0 * hill * hill * (1.0 - 2.0 * s) / h,
    )
    return q, v


@leaf
def value_of(quintic, s):
    """Return a coordinate and its rate at fraction s of the step."""
    q, v = value_without_bump(quintic, s)
    # bump s^3 (1 - s)^3 and its derivative
    if quintic.bump != 0.0:
        hill = s * (1.0 - s)
        q += quintic.bump * hill * hill * hill
        v += quintic.bump * 3.0 * hill * hill * (1.0 - 2.0 * s)
    return q, v * quintic.per_step


@leaf
def value_without_bump(quintic, s):
    """Return the value and the rate per step of the quintic without bump, for one step or one step per lane."""
    _, c0, c1, c2, c3, c4, c5, _ = quintic
    q = c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    return q, c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))


@kernel
def turning_point(d0, v0, d1, v1, h):
    """Return the fraction of a step of `h` s where the cubic by displacements d and velocities v turns; v0 * v1 < 0."""
    # velocity of the cubic: v0 + 2 b s + 3 c s^2 over a step of unit length
    rise = (d1 - d0) / h
    b = 3.0 * rise - 2.0 * v0 - v1
    c = v0 + v1 - 2.0 * rise
    root = max(0.0, b * b - 3.0 * c * v0) ** 0.5
    # the root inside is the one whose denominator does not cancel
    below = -(b + root) if b > 0.0 else -(b - root)
    first = v0 / below if below != 0.0 else 0.5
    if 0.0 <= first <= 1.0:
        return first
    second = below / (3.0 * c) if c != 0.0 else 0.5
    return min(1.0, max(0.0, second))
