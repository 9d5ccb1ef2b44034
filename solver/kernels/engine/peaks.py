"""Parabolas through three values, for the search of a maximum within a step."""

from ..numba_ext.jit import leaf
from ..numba_ext.lanes import greater, magnitude, opposite, where

MARGIN = 0.1  # of the bend of a parabola through three values: largest deviation of the curve above it


NEAR = 2.6  # of the bend: a smaller rise may turn within the step; 2 on a parabola, 2.4 on a sine over 1.5 rad


MOST_TRIALS = 8


CLOSE = 1e-4  # of a step: least distance of two evaluations


@leaf
def vertex(a, f_a, b, f_b, c, f_c):
    """Return (place, height) of the top of the parabola through three points; of the best one if no top is inside."""
    # slopes of the two intervals, and the second difference
    left, right = (f_b - f_a) / (b - a), (f_c - f_b) / (c - b)
    bend = (left - right) / (c - a)
    curved, slope = bend > 0.0, left - bend * (b - a)  # at b
    per = where(curved, bend, 1.0)
    # vertex, where the parabola is concave and the vertex inside
    place = b + 0.5 * slope / per
    inside = curved & (a < place) & (place < c)
    top, best = f_b + 0.25 * slope * slope / per, greater(f_a, greater(f_b, f_c))
    return where(inside, place, b), where(inside, top, best)


@leaf
def apart(known, s):
    """Return a trial point near s that keeps a least distance from the second of three known points."""
    a, _, b, _, c, _ = known
    return where(magnitude(s - b) < CLOSE, where(c - b > b - a, b + CLOSE, b - CLOSE), s)


@leaf
def nearer(known, s, f_s):
    """Update the three points that bracket the maximum, each with its value, after a trial at s."""
    a, f_a, b, f_b, c, f_c = known
    # the trial replaces the middle if it is better, else the end on its side
    before, better = s < b, f_s >= f_b
    first, last = better ^ before, better ^ opposite(before)  # s or b is the first; the last
    return (
        where(first, where(before, s, b), a),
        where(first, where(before, f_s, f_b), f_a),
        where(better, s, b),
        where(better, f_s, f_b),
        where(last, where(before, b, s), c),
        where(last, where(before, f_b, f_s), f_c),
    )
