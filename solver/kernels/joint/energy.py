"""What a joint of any section has of energy: for judging a column, not for moving it."""

from ..jit import kernel
from .law import joint_forces, joint_potential
from .section import part_stiffness

MOST_TRIALS = 100
CLOSE = 1e-15  # of the largest penetration


@kernel
def balanced_opening(contact, stiffness, slope, weight):
    """Opening, m, at which the joint, its faces turned by slope > 0, carries this weight, N > 0.

    Newton's method within bounds: the force falls with the opening, and is convex in it.
    """
    low = -weight / part_stiffness(contact, stiffness, contact.left, contact.right)[0] - contact.right * slope
    high = contact.right * slope
    opening = low
    for _ in range(MOST_TRIALS):
        force, _, _ = joint_forces(contact, stiffness, 0.0, opening, slope, 0.0, 0.0)
        if force > weight:
            low = opening
        else:
            high = opening
        lo = max(contact.left, opening / slope)
        steep = part_stiffness(contact, stiffness, lo, max(lo, contact.right))[0]
        last, opening = opening, 0.5 * (low + high)
        if steep > 0.0 and low < last + (force - weight) / steep < high:
            opening = last + (force - weight) / steep
        if abs(opening - last) <= CLOSE * (abs(low) + abs(high)):
            break
    return opening


@kernel
def least_energy(contact, stiffness, slope, weight):
    """Least of elastic energy and weight * opening, J, over the openings of a joint turned by slope >= 0."""
    if not weight > 0.0:
        return 0.0
    if not slope > 0.0:
        return -0.5 * weight * weight / part_stiffness(contact, stiffness, contact.left, contact.right)[0]
    opening = balanced_opening(contact, stiffness, slope, weight)
    return joint_potential(contact, stiffness, opening, slope) + weight * opening
