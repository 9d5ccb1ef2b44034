"""What the shape of a contact comes to: a rectangle of width (along the motion) by depth.

Nothing else knows that the contact is a rectangle; only its width, over which the faces touch, is known elsewhere.
"""

from ..jit import leaf


@leaf
def part_stiffness(blocks, i, lo, hi):
    """Stiffness of the part of joint i from lo to hi, m from its centre: (N/m, N, N m), by opening and by slope.

    Derivatives of N by the opening, of N (or M) by the slope (or opening) and of M by the slope, signs aside.
    """
    length = hi - lo
    middle = 0.5 * (lo + hi)
    along = blocks.stiffness[i] * blocks.depth[i] * length
    return along, along * middle, along * (middle * middle + length * length / 12.0)


@leaf
def strip_stiffness(blocks, i, place, width):
    """The same of a narrow strip of this width at this place, m from the centre."""
    along = blocks.stiffness[i] * blocks.depth[i] * width
    return along, along * place, along * place * place


@leaf
def full_stiffness(blocks, i):
    """Stiffness of joint i in full contact, N/m."""
    return blocks.stiffness[i] * blocks.width[i] * blocks.depth[i]


@leaf
def full_turning_stiffness(blocks, i):
    """Stiffness of joint i in full contact against rotation, N m/rad."""
    return full_stiffness(blocks, i) * (blocks.width[i] * blocks.width[i]) / 12.0


@leaf
def forces_over(lo, hi, length, rigidity, mean, gradient):
    """N and M of the pressure gradient * s - mean over the part from lo to hi, of this length; rigidity in N/m2."""
    middle = 0.5 * (lo + hi)  # its mirror image is minus it, to the last bit
    area = rigidity * length
    force = area * (gradient * middle - mean)
    return force, middle * force + area * gradient * (length * length) * (1.0 / 12.0)
