"""The no-tension joint, in closed form (theory.md section 2); section.py has the integrals over its shape.

The penetration at abscissa s, left <= s <= right of its contact, is  pen(s) = -opening + s * slope.  The pressure is
max(0, stiffness * (pen + damping * dpen/dt)) where pen > 0: both factors are linear in s, hence the loaded part is one
interval, and with damping = 0 it is the elastic joint of the paper.

The law has two forms, the same to the last bit: branches for one column, where they are predictable, and selections
for lanes. A single column may also be held in a regime (regimes.py).
"""

from typing import NamedTuple

from ...layout.spaces import LAW
from ...numba_ext.jit import by_width, kernel, leaf
from ...numba_ext.lanes import (
    LanesType,
    greater,
    lesser,
    magnitude,
    mirrored,
    where,
)
from ..sections.section import (
    ROUND,
    contact_of,
    ends_of,
    energy_over,
    forces_over,
    forces_over_in_lanes,
    part_stiffness,
    rectangle_forces,
)
from .regimes import ANY, OPEN, open_margin, side_margin, sides


class PressureLaw(NamedTuple):
    """The parameters of the pressure on a joint, apart from its contact and its motion: the fields LAW of spaces.py."""

    stiffness: float  # N/m3
    damping: float  # s


assert PressureLaw._fields == LAW, (
    "solver/kernels/column/joint/law.py: PressureLaw must have the fields LAW of solver/kernels/layout/spaces.py"
)


@leaf
def law_of(blocks, i):
    """Return the law of joint i."""
    return PressureLaw(blocks.stiffness[i], blocks.damping[i])


@leaf
def positive_part(value, slope, lo, hi):
    """Return the part (lo, hi) of an interval where value + slope * s > 0; lo >= hi if there is none."""
    # the zero of the function becomes the left end
    if slope > 0.0:
        edge = -value / slope
        return edge if edge > lo else lo, hi
    # or the right end
    if slope < 0.0:
        edge = -value / slope
        return lo, edge if edge < hi else hi
    # a constant: the whole interval or nothing
    if value > 0.0:
        return lo, hi
    return hi, hi


@leaf
def loaded_part(left, right, damping, opening, slope, opening_rate, slope_rate):
    """Return the part (lo, hi) of the contact that carries pressure; lo >= hi if none does.

    lo, hi and the ends of the contact, left and right, in m from the middle of the block.
    """
    # faces overlap; there the damper must not pull
    lo, hi = positive_part(-opening, slope, left, right)
    if damping > 0.0 and lo < hi:
        lo, hi = positive_part(-(opening + damping * opening_rate), slope + damping * slope_rate, lo, hi)
    return lo, hi


@by_width
def pressed_part(left, right, opening, slope):
    """Return the part (lo, hi) of the contact (m) in which the faces overlap; lo >= hi if none. One joint or lanes."""
    if isinstance(slope, LanesType):
        return _pressed_part_of_lanes
    return lambda left, right, opening, slope: positive_part(-opening, slope, left, right)


def _pressed_part_of_lanes(left, right, opening, slope):
    slope, right = slope + 0.0, greater(right, left)
    edge, rises = _within(opening / slope, left, right), slope >= 0.0
    return where(rises, edge, left), where(rises, right, edge)


@leaf
def pressure_forces(contact, law, lo, hi, length, mean, gradient):
    """Return N (N) and M (N m) of the pressure on the loaded part.

    Parameters
    ----------
    contact : ContactSection
        The contact of the joint.
    law : PressureLaw
        Stiffness, N/m3, and damping, s.
    lo, hi, length : float
        Ends of the loaded part and its length, m.
    mean, gradient : float
        Opening, m, and slope, rad, with the damper's part; gradient * s - mean is not negative in the loaded part,
        unless the joint is held beyond its regime, where hi may be below lo too.
    """
    # the integral over the section
    return forces_over(contact, law.stiffness, lo, hi, length, mean, gradient)


@leaf
def joint_tangent(contact, law, lo, hi, mean, gradient):
    """Return the derivatives of `pressure_forces` by mean and gradient, without signs, as `part_stiffness`.

    They are zero where nothing is loaded (hi <= lo).

    Implicit steps solve with them: an approximation keeps the order, but a poor one makes the steps short.
    """
    return part_stiffness(contact, law.stiffness, lo, max(lo, hi))


@leaf
def joint_forces(contact, law, opening, slope, opening_rate, slope_rate):
    """Return the normal force N, the moment M and the loaded length of a joint.

    With damping = 0, N = -dU/d(opening) and M = dU/d(slope) of the potential U (`joint_potential`).

    Parameters
    ----------
    contact : ContactSection
        The contact of the joint.
    law : PressureLaw
        Stiffness, N/m3, and damping, s.
    opening, slope, opening_rate, slope_rate : float
        Motion of the joint: m, rad, m/s, rad/s.

    Returns
    -------
    force, moment : float
        N, N (compression positive), and M, N m (restoring).
    length : float
        Loaded length, m.
    """
    # part in which the faces overlap and the damper does not pull
    lo, hi = loaded_part(contact.left, contact.right, law.damping, opening, slope, opening_rate, slope_rate)
    if not hi > lo:
        return 0.0, 0.0, 0.0
    # opening and slope with the damper's part
    mean = opening + law.damping * opening_rate
    gradient = slope + law.damping * slope_rate
    length = hi - lo
    force, moment = pressure_forces(contact, law, lo, hi, length, mean, gradient)
    return force, moment, length


@leaf
def _within(x, lo, hi):
    """Clip x to the interval from lo to hi; return hi where x is NaN."""
    return greater(lesser(x, hi), lo)


@leaf
def loaded_part_in_lanes(near, far, damping, opening, slope, opening_rate, slope_rate):
    """Return the loaded part of a joint in lanes, without a branch, in the mirror image where the slope is negative.

    In that image the slope is positive, so that the faces touch between an edge and `far`.

    Parameters
    ----------
    near, far : lanes
        Ends of the contact in that image, m.
    damping : lanes
        Damping, s.
    opening, slope, opening_rate, slope_rate : lanes
        Motion of the joint: m, rad, m/s, rad/s.

    Returns
    -------
    one, other : lanes
        Ends of the loaded part in that image, m, in either order.
    mean, gradient : lanes
        Opening, m, and slope, rad, with the damper's part.
    """
    steep = magnitude(slope)
    mean = opening + damping * opening_rate
    gradient = steep + damping * mirrored(slope_rate, slope)
    # edge of the overlap, then the edge of the pressure
    edge = _within(opening / steep, near, far)
    pushed = _within(mean / gradient, edge, far)  # the same edge again where there is no damping
    return pushed, where(gradient >= 0.0, far, edge), mean, gradient


@leaf
def joint_forces_in_lanes(near, far, rigidity, damping, opening, slope, opening_rate, slope_rate):
    """Return `joint_forces` of rectangles in lanes; rigidity in N/m2, near and far as in `loaded_part_in_lanes`."""
    one, other, mean, gradient = loaded_part_in_lanes(near, far, damping, opening, slope, opening_rate, slope_rate)
    length = magnitude(other - one)
    force, moment = rectangle_forces(one, other, length, rigidity, mean, gradient)
    return force, mirrored(moment, slope), length


@leaf
def held_forces(regime, contact, law, opening, slope, opening_rate, slope_rate):
    """Return N, M and loaded length by the formula of a regime, even where it does not apply, and its margin (m)."""
    damping = law.damping
    # opening and slope with the damper's part
    mean = opening + damping * opening_rate
    gradient = slope + damping * slope_rate
    if regime == OPEN:
        return 0.0, 0.0, 0.0, open_margin(contact.left, contact.right, opening, slope, mean, gradient)
    # ends of the loaded part by the bounds of the regime, and their margins
    left, right = sides(regime)
    lo, on_left = side_margin(left, contact.left, damping, opening, slope, mean, gradient)
    hi, on_right = side_margin(right, contact.right, damping, opening, slope, mean, gradient)
    length = hi - lo
    force, moment = pressure_forces(contact, law, lo, hi, length, mean, gradient)
    return force, moment, length, min(on_left, on_right)


@by_width
def resultants(blocks, hold, i, opening, slope, opening_rate, slope_rate, slip=0.0):
    """Return N, M and loaded length of joint i; for one column, flag in `hold` that the joint has left its regime."""
    if not isinstance(opening, LanesType):
        return _resultants_of_one
    return _resultants_of_round_lanes if ROUND in blocks.names else _resultants_of_lanes


def _resultants_of_one(blocks, hold, i, opening, slope, opening_rate, slope_rate, slip=0.0):
    regime = hold.held[i]
    # a joint that may change its regime
    contact, law = contact_of(blocks, i, slip), law_of(blocks, i)
    if regime == ANY:
        return joint_forces(contact, law, opening, slope, opening_rate, slope_rate)
    # the formula of the regime of the step; `outside` marks that it no longer applies
    normal, moment, length, margin = held_forces(regime, contact, law, opening, slope, opening_rate, slope_rate)
    if margin < 0.0:
        hold.outside[i] = 1
    return normal, moment, length


@by_width
def _image(blocks, i, slope, slip):
    """Return ends of the contact, slip and slope of joint i in lanes, in the mirror image where the slope is negative.

    The slope itself is not mirrored.
    """
    if isinstance(slip, LanesType):
        return _slipped_image
    # without a slip the contact is its own mirror image
    return lambda blocks, i, slope, slip: (blocks.left[i], blocks.right[i], 0.0, slope)


def _slipped_image(blocks, i, slope, slip):
    slope = slope + 0.0  # minus zero becomes zero
    # ends of the contact, mirrored so that the slope is not negative
    left, right = ends_of(blocks, i, slip)
    right = greater(right, left)  # faces that no longer meet: no contact
    falls = slope < 0.0
    return where(falls, -right, left), where(falls, -left, right), mirrored(slip, slope), slope


def _resultants_of_lanes(blocks, hold, i, opening, slope, opening_rate, slope_rate, slip=0.0):
    near, far, _, slope = _image(blocks, i, slope, slip)
    rigidity, damping = blocks.rigidity[i], blocks.damping[i]
    return joint_forces_in_lanes(near, far, rigidity, damping, opening, slope, opening_rate, slope_rate)


def _resultants_of_round_lanes(blocks, hold, i, opening, slope, opening_rate, slope_rate, slip=0.0):
    near, far, slip, slope = _image(blocks, i, slope, slip)
    damping = blocks.damping[i]
    one, other, mean, gradient = loaded_part_in_lanes(near, far, damping, opening, slope, opening_rate, slope_rate)
    # unlike a rectangle, other sections need the ends in order
    lo, hi = lesser(one, other), greater(one, other)
    length = hi - lo
    force, moment = forces_over_in_lanes(blocks, i, slip, slope, (near, far), lo, hi, length, mean, gradient)
    return force, mirrored(moment, slope), length


@kernel
def joint_peak_pressure(contact, law, length, opening, slope, opening_rate, slope_rate):
    """Return the largest pressure on the joint (Pa).

    It acts at an end of the loaded part, where a linear function has its maximum. length: loaded length, m, as
    `joint_forces` returns it.
    """
    if not length > 0.0:
        return 0.0
    # ends of the loaded part
    lo, hi = contact.left, contact.right
    if length < hi - lo:
        lo, hi = loaded_part(lo, hi, law.damping, opening, slope, opening_rate, slope_rate)
    # the pressure is linear: evaluate it at its higher end
    mean = -(opening + law.damping * opening_rate)
    gradient = slope + law.damping * slope_rate
    return max(0.0, law.stiffness * (mean + gradient * (hi if gradient > 0.0 else lo)))


@leaf
def joint_potential(contact, law, opening, slope):
    """Return the elastic energy of the joint (J): the integral of stiffness * pen^2 / 2 over the loaded area."""
    lo, hi = loaded_part(contact.left, contact.right, 0.0, opening, slope, 0.0, 0.0)
    return energy_over(contact, law.stiffness, lo, hi, opening, slope) if hi > lo else 0.0
