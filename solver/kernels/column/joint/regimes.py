"""The bounds of the loaded part of a joint on either side: its regime, in which the forces are smooth.

A regime is OPEN, or FULL + left + RIGHT * right with each side a CORNER, TOUCH or PULL.
"""

from ...numba_ext.jit import leaf

# regimes of a joint
ANY = 0  # any regime: not held
OPEN = 1
FULL = 16
RIGHT = 4
# what bounds the loaded part on one side
CORNER = 0  # the end of the joint
TOUCH = 1  # the edge where the faces part
PULL = 2  # the edge beyond which the damper would pull


@leaf
def contact_regime(left_end, right_end, damping, opening, slope, opening_rate, slope_rate):
    """Return the regime of a joint in this motion.

    As long as it is the same the forces are smooth functions of the joint's motion.

    Parameters
    ----------
    left_end, right_end : float
        Ends of the contact, m.
    damping : float
        Damping, s.
    opening, slope, opening_rate, slope_rate : float
        Motion of the joint: m, rad, m/s, rad/s.

    Returns
    -------
    regime : int
        OPEN, or FULL + left + RIGHT * right.
    """
    # where the faces overlap
    lo, hi = left_end, right_end
    left = right = CORNER
    if slope > 0.0:
        edge = opening / slope
        if edge > lo:
            lo, left = edge, TOUCH
    elif slope < 0.0:
        edge = opening / slope
        if edge < hi:
            hi, right = edge, TOUCH
    elif opening >= 0.0:
        return OPEN
    # where the damper does not pull
    if damping > 0.0:
        mean = opening + damping * opening_rate
        gradient = slope + damping * slope_rate
        if gradient > 0.0:
            edge = mean / gradient
            if edge > lo:
                lo, left = edge, PULL
        elif gradient < 0.0:
            edge = mean / gradient
            if edge < hi:
                hi, right = edge, PULL
        elif mean >= 0.0:
            return OPEN
    if not lo < hi:
        return OPEN
    return FULL + left + RIGHT * right


@leaf
def sides(regime):
    """Return the bounds of the loaded part on the left and on the right in a regime that is not OPEN."""
    return regime & 3, (regime >> 2) & 3


@leaf
def side_margin(bound, corner, damping, opening, slope, mean, gradient):
    """Return the end of the loaded part by this bound (m) and the margin within which the bound holds (m).

    Parameters
    ----------
    bound : int
        CORNER, TOUCH or PULL.
    corner : float
        End of the contact on that side, m.
    damping : float
        Damping, s.
    opening, slope : float
        Motion of the joint: m, rad.
    mean, gradient : float
        Opening, m, and slope, rad, with the damper's part.
    """
    # penetration of the corner, as it is and with the damper's part
    touching = corner * slope - opening
    pushing = corner * gradient - mean
    if bound == CORNER:
        return corner, min(touching, pushing) if damping > 0.0 else touching
    # the faces part at the edge, whose penetration is zero
    if bound == TOUCH:
        edge = opening / slope
        return edge, min(-touching, edge * gradient - mean) if damping > 0.0 else -touching
    # the pressure is zero at the edge
    edge = mean / gradient
    return edge, min(-pushing, edge * slope - opening)


@leaf
def open_margin(left_end, right_end, opening, slope, mean, gradient):
    """Return the distance (m) by which an open joint with these ends of its contact is from closing."""
    # maximum over the width of the smaller penetration: at a corner, or where both are equal
    most = min(left_end * slope - opening, left_end * gradient - mean)
    most = max(most, min(right_end * slope - opening, right_end * gradient - mean))
    # abscissa of equal penetrations
    same = (mean - opening) / (gradient - slope)
    if left_end < same < right_end:
        most = max(most, same * slope - opening)
    return -most


@leaf
def regime_margin(regime, left_end, right_end, damping, opening, slope, opening_rate, slope_rate):
    """Return the margin (m) within which the joint stays in the regime: zero where another begins, negative beyond.

    It is the least of the penetrations, as they are and with the damper's part, that have to be positive.
    """
    # opening and slope with the damper's part
    mean = opening + damping * opening_rate
    gradient = slope + damping * slope_rate
    # an open joint: distance to closing
    if regime == OPEN:
        return open_margin(left_end, right_end, opening, slope, mean, gradient)
    # a loaded joint: the smaller margin of both ends
    left, right = sides(regime)
    _, on_left = side_margin(left, left_end, damping, opening, slope, mean, gradient)
    _, on_right = side_margin(right, right_end, damping, opening, slope, mean, gradient)
    return min(on_left, on_right)
