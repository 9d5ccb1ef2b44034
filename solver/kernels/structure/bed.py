"""The pressure on a joint and its integrals over the loaded part of the section (theory.md section 13).

The penetration p and the damped penetration q = p + damping dp/dt are linear over the section. The pressure is
stiffness times q where p and q are positive, so the section is cut by two half-planes. All integrals are sums of
positive parts, so that slivers keep their digits.
"""

from typing import Any, NamedTuple

from ..numba_ext.jit import leaf
from ..numba_ext.lanes import lane, where, zero_like


class Plane(NamedTuple):
    """A linear function over the section of a joint: at + along_x x + along_y y."""

    at: Any
    along_x: Any
    along_y: Any


class Bed(NamedTuple):
    """The integrals of the pressure over the loaded part of a section, divided by the stiffness."""

    force: Any  # of q, m3
    first_x: Any  # of q x and q y, m4
    first_y: Any
    area: Any  # m2
    largest: Any  # of q, m


class Moments(NamedTuple):
    """The integrals over a section of x, y (m3) and of x^2, x y, y^2 (m4)."""

    x: Any
    y: Any
    xx: Any
    xy: Any
    yy: Any


@leaf
def nothing(plane):
    """Return the bed of a joint without contact."""
    zero = zero_like(plane.at)
    return Bed(zero, zero, zero, zero, zero)


@leaf
def chosen(condition, bed, other):
    """Return `bed` where the condition holds, else `other`."""
    return Bed(
        where(condition, bed.force, other.force),
        where(condition, bed.first_x, other.first_x),
        where(condition, bed.first_y, other.first_y),
        where(condition, bed.area, other.area),
        where(condition, bed.largest, other.largest),
    )


@leaf
def value(plane, x, y):
    """Evaluate the linear function at (x, y)."""
    return plane.at + plane.along_x * x + plane.along_y * y


@leaf
def plane_of_lane(plane, k):
    """Extract the linear function of lane k."""
    return Plane(lane(plane.at, k), lane(plane.along_x, k), lane(plane.along_y, k))


@leaf
def whole(area, moments, q, largest):
    """Return the bed of a section in full contact.

    Parameters
    ----------
    area : float or lanes
        Area of the section, m2.
    moments : Moments
        The other integrals over the section.
    q : Plane
        Damped penetration, m.
    largest : float or lanes
        Largest q, m.
    """
    # integrals of q, q x and q y over the whole section
    force = q.at * area + (q.along_x * moments.x + q.along_y * moments.y)
    first_x = q.along_x * moments.xx + q.along_y * moments.xy + q.at * moments.x
    first_y = q.along_x * moments.xy + q.along_y * moments.yy + q.at * moments.y
    return Bed(force, first_x, first_y, area, largest)


@leaf
def subtract(bed, other):
    """Subtract the bed of a part of its section from a bed; the largest q stays."""
    return Bed(
        bed.force - other.force,
        bed.first_x - other.first_x,
        bed.first_y - other.first_y,
        bed.area - other.area,
        bed.largest,
    )


@leaf
def triangle(x, y, q):
    """Integrate a linear function over a triangle.

    Parameters
    ----------
    x, y, q : tuple
        Coordinates of the three corners, m, and the values of the function there. The area is computed from differences
        to the first corner.

    Returns
    -------
    area, force, first_x, first_y : float or lanes
        Area, and the integrals of q, q x and q y.
    """
    # area, and the mean of q
    area = 0.5 * ((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]))
    total = q[0] + q[1] + q[2]
    third, twelfth = area / 3.0, area / 12.0
    # products of two linear functions, from their values at the corners
    first_x = twelfth * (total * (x[0] + x[1] + x[2]) + (q[0] * x[0] + q[1] * x[1] + q[2] * x[2]))
    first_y = twelfth * (total * (y[0] + y[1] + y[2]) + (q[0] * y[0] + q[1] * y[1] + q[2] * y[2]))
    return area, third * total, first_x, first_y


@leaf
def add(bed, there, area, force, first_x, first_y):
    """Add a part to a bed where the mask `there` holds."""
    # the largest q is left to the caller
    return Bed(
        bed.force + where(there, force, 0.0),
        bed.first_x + where(there, first_x, 0.0),
        bed.first_y + where(there, first_y, 0.0),
        bed.area + where(there, area, 0.0),
        bed.largest,
    )
