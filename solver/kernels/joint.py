"""The no-tension joint of a rectangular contact, in closed form (theory.md section 2).

The penetration at abscissa s, -width/2 <= s <= width/2, is  pen(s) = -opening + s * slope.  The pressure is
max(0, stiffness * (pen + damping * dpen/dt)) where pen > 0: both factors are linear in s, hence the loaded part is one
interval, and with damping = 0 it is the elastic joint of the paper.
"""

from .jit import kernel, leaf


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
def joint_forces(stiffness, width, depth, damping, opening, slope, opening_rate, slope_rate):
    """Normal force N (N, compression positive), moment M (N m, restoring) and loaded length (m) of a joint.

    opening, slope: m and rad, their rates per s; stiffness N/m3; width, depth m; damping s.
    N = -dU/d(opening), M = dU/d(slope) of the potential below when damping = 0.
    """
    lo, hi = loaded_part(width, damping, opening, slope, opening_rate, slope_rate)
    length = hi - lo
    if not length > 0.0:
        return 0.0, 0.0, 0.0
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
