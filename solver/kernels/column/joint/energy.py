"""The energy of a joint of any section: for the verdict on a column, not for its motion."""

from ...numba_ext.jit import kernel
from ..sections.section import part_stiffness
from .law import joint_forces, joint_potential

MOST_TRIALS = 100
CLOSE = 1e-15  # relative to the largest penetration


@kernel
def balanced_opening(contact, law, slope, weight):
    """Return the opening (m) at which the joint carries a weight (N, > 0) at a slope of either sign (rad).

    Newton's method between bounds: the force decreases with the opening, and is convex in it.
    """
    # bounds of the opening: each fibre pressed by at least weight / stiffness, and none pressed
    stiffness = law.stiffness
    one, other = contact.left * slope, contact.right * slope
    low = -weight / part_stiffness(contact, stiffness, contact.left, contact.right)[0] + min(one, other)
    high = max(one, other)
    opening = low
    # Newton's method within these bounds
    for _ in range(MOST_TRIALS):
        force, _, _ = joint_forces(contact, law, opening, slope, 0.0, 0.0)
        # the force decreases with the opening: narrow the bounds
        if force > weight:
            low = opening
        else:
            high = opening
        # stiffness of the pressed part, from lo to hi: minus the derivative of the force
        edge = min(max(contact.left, opening / slope), contact.right)  # edge of the pressed part
        lo, hi = (edge, contact.right) if slope > 0.0 else (contact.left, edge)
        steep = part_stiffness(contact, stiffness, lo, hi)[0]
        # Newton step, or bisection where it leaves the bounds
        last, opening = opening, 0.5 * (low + high)
        if steep > 0.0 and low < last + (force - weight) / steep < high:
            opening = last + (force - weight) / steep
        if abs(opening - last) <= CLOSE * (abs(low) + abs(high)):
            break
    return opening


@kernel
def least_energy(contact, law, slope, weight):
    """Return the minimum over the opening of elastic energy plus weight * opening (J), for the linear law."""
    # a joint without weight is open
    if not weight > 0.0:
        return 0.0
    # parallel faces: -W^2 / (2 k)
    if slope == 0.0:
        return -0.5 * weight * weight / part_stiffness(contact, law.stiffness, contact.left, contact.right)[0]
    # tilted faces: at the opening of balance
    opening = balanced_opening(contact, law, slope, weight)
    return joint_potential(contact, law, opening, slope) + weight * opening
