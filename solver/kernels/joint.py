"""The no-tension joint of a rectangular contact, in closed form (theory.md section 2).

The penetration at abscissa s, -width/2 <= s <= width/2, is  pen(s) = -opening + s * slope.  The pressure is
max(0, stiffness * (pen + damping * dpen/dt)) where pen > 0: both factors are linear in s, hence the loaded part is one
interval, and with damping = 0 it is the elastic joint of the paper.
"""

from .jit import kernel, leaf

# regimes of a joint
ANY = 0  # whichever applies
OPEN = 1
FULL = 2
# what bounds the loaded part on one side
CORNER = 0  # the end of the joint
TOUCH = 1  # the faces part there
PULL = 2  # the damper would pull there


@leaf
def positive_part(value, slope, lo, hi):
    """The part (lo, hi) of an interval where value + slope * s > 0; lo >= hi when there is none."""
    if slope > 0.0:
        return max(lo, -value / slope), hi
    if slope < 0.0:
        return lo, min(hi, -value / slope)
    if value > 0.0:
        return lo, hi
    return hi, hi


@leaf
def loaded_part(width, damping, opening, slope, opening_rate, slope_rate):
    """The part (lo, hi) of the joint's width that carries pressure, m from its centre; lo >= hi when there is none."""
    lo, hi = positive_part(-opening, slope, -0.5 * width, 0.5 * width)
    if damping > 0.0 and lo < hi:
        lo, hi = positive_part(-opening - damping * opening_rate, slope + damping * slope_rate, lo, hi)
    return lo, hi


@leaf
def contact_regime(width, damping, opening, slope, opening_rate, slope_rate):
    """What bounds the loaded part on either side: OPEN, or FULL + left + 3 right of CORNER, TOUCH and PULL.

    As long as it is the same the forces are smooth functions of the joint's motion.
    """
    lo, hi = -0.5 * width, 0.5 * width
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
    return FULL + left + 3 * right


@leaf
def _bounds(regime):
    """What bounds the loaded part on the left and on the right in a regime that is not OPEN."""
    right = (regime - FULL) // 3
    return regime - FULL - 3 * right, right


@leaf
def regime_margin(regime, width, damping, opening, slope, opening_rate, slope_rate):
    """How far the joint is from leaving the regime, m: negative beyond, zero where another one begins.

    The least of the penetrations, as they are and as the damper feels them, that have to be positive.
    """
    half = 0.5 * width
    mean = opening + damping * opening_rate
    gradient = slope + damping * slope_rate
    if regime == OPEN:
        # largest over the width of the lesser penetration: at a corner, or in between where they are the same
        most = min(-opening - half * slope, -mean - half * gradient)
        most = max(most, min(half * slope - opening, half * gradient - mean))
        same = (mean - opening) / (gradient - slope)
        if abs(same) < half:
            most = max(most, same * slope - opening)
        return -most
    left, right = _bounds(regime)
    margin = _bound_margin(left, -half, opening, slope, mean, gradient, damping)
    return min(margin, _bound_margin(right, half, opening, slope, mean, gradient, damping))


@leaf
def _bound_margin(bound, corner, opening, slope, mean, gradient, damping):
    touching = corner * slope - opening
    pushing = corner * gradient - mean
    if bound == CORNER:
        return min(touching, pushing) if damping > 0.0 else touching
    if bound == TOUCH:
        return min(-touching, opening / slope * gradient - mean) if damping > 0.0 else -touching
    return min(-pushing, mean / gradient * slope - opening)


@leaf
def _edge(bound, corner, damping, opening, slope, opening_rate, slope_rate):
    """Where the loaded part ends if it ends by this bound, m from the centre."""
    if bound == TOUCH:
        return opening / slope
    if bound == PULL:
        return (opening + damping * opening_rate) / (slope + damping * slope_rate)
    return corner


@leaf
def joint_forces(stiffness, width, depth, damping, opening, slope, opening_rate, slope_rate, regime=ANY):
    """Normal force N (N, compression positive), moment M (N m, restoring) and loaded length (m) of a joint.

    opening, slope: m and rad, their rates per s; stiffness N/m3; width, depth m; damping s. The regime is ANY, or the
    one by which to go on smoothly where the law would change to another.
    N = -dU/d(opening), M = dU/d(slope) of the potential below when damping = 0.
    """
    if regime == ANY:
        lo, hi = loaded_part(width, damping, opening, slope, opening_rate, slope_rate)
        if not hi > lo:
            return 0.0, 0.0, 0.0
    elif regime == OPEN:
        return 0.0, 0.0, 0.0
    else:
        left, right = _bounds(regime)
        lo = _edge(left, -0.5 * width, damping, opening, slope, opening_rate, slope_rate)
        hi = _edge(right, 0.5 * width, damping, opening, slope, opening_rate, slope_rate)
    length = hi - lo
    mean = -(opening + damping * opening_rate)
    gradient = slope + damping * slope_rate
    middle = 0.5 * (lo + hi)
    rigidity = stiffness * depth * length
    force = rigidity * (mean + gradient * middle)
    return force, middle * force + rigidity * gradient * (length * length) / 12.0, length


@kernel
def joint_peak_pressure(stiffness, width, damping, opening, slope, opening_rate, slope_rate):
    """Largest pressure on the joint, Pa: at an end of the loaded part, where a linear function has its maximum."""
    lo, hi = loaded_part(width, damping, opening, slope, opening_rate, slope_rate)
    if not hi > lo:
        return 0.0
    mean = -(opening + damping * opening_rate)
    gradient = slope + damping * slope_rate
    return max(0.0, stiffness * (mean + gradient * (hi if gradient > 0.0 else lo)))


@kernel
def joint_potential(stiffness, width, depth, opening, slope):
    """Elastic energy of the joint, J: the integral of stiffness * pen^2 / 2 over the loaded area."""
    lo, hi = loaded_part(width, 0.0, opening, slope, 0.0, 0.0)
    length = hi - lo
    if not length > 0.0:
        return 0.0
    middle = slope * 0.5 * (lo + hi) - opening
    return 0.5 * stiffness * depth * length * (middle * middle + slope * slope * (length * length) / 12.0)
