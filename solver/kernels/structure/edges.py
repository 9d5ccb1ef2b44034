"""Line integrals of a squared penetration along straight edges, exact where it is linear."""

from ..numba_ext.jit import kernel
from ..numba_ext.lanes import any_of, greater, lesser, where, zero_like
from .bed import value

SIMPSON = ((0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0))  # positions and weights, exact for cubics


@kernel
def edge_integrals(x0, y0, dx, dy, p):
    """Integrate p^2 along an edge times its outward normal.

    Parameters
    ----------
    x0, y0, dx, dy : float or lanes
        Begin of the edge and the vector to its end, m; the polygon lies on its left.
    p : Plane
        Penetration, m; the integral is over the part where it is positive.

    Returns
    -------
    along_x, along_y, moment : float or lanes
        Integral of p^2 n, m3, and of p^2 n . (-y, x), m4.
    x, y : float or lanes
        Middle of that part, m.
    """
    # clip the edge to where p is positive
    first, rise = value(p, x0, y0), p.along_x * dx + p.along_y * dy
    zero = zero_like(first)
    low, high = zero, zero + 1.0
    if any_of(lesser(first, first + rise) <= 0.0):
        root = -first / where(rise == 0.0, 1.0, rise)
        low = where(rise > 0.0, greater(low, root), low)
        high = where(rise < 0.0, lesser(high, root), where((rise == 0.0) & (first <= 0.0), 0.0, high))
    # integrate by Simpson's rule
    length = greater(high - low, 0.0)
    total, moment = zero, zero
    for part, weight in SIMPSON:
        s = low + part * length
        here = first + s * rise
        product = weight * length * here * here
        total += product
        moment -= product * (dx * (x0 + s * dx) + dy * (y0 + s * dy))
    # middle of the part
    s = low + 0.5 * length
    return dy * total, -(dx * total), moment, x0 + s * dx, y0 + s * dy
