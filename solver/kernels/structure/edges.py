"""Line integrals of a pressure along straight edges, exact for linear p and q."""

from ..numba_ext.jit import kernel
from ..numba_ext.lanes import any_of, greater, lesser, where, zero_like
from .bed import value

SIMPSON = ((0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0))  # positions and weights, exact for cubics


@kernel
def edge_integrals(x0, y0, dx, dy, p, q):
    """Integrate p q along an edge times its outward normal.

    Parameters
    ----------
    x0, y0, dx, dy : float or lanes
        Begin of the edge and the vector to its end, m; the polygon lies on its left.
    p, q : Plane
        Penetration and damped penetration, m; the integral is over the part where both are positive.

    Returns
    -------
    along_x, along_y, moment : float or lanes
        Integral of p q n, m3, and of p q n . (-y, x), m4.
    x, y : float or lanes
        Middle of that part, m.
    """
    # clip the edge to where p and q are positive
    p0, q0 = value(p, x0, y0), value(q, x0, y0)
    p_rise, q_rise = p.along_x * dx + p.along_y * dy, q.along_x * dx + q.along_y * dy
    zero = zero_like(p0)
    low, high = zero, zero + 1.0
    cut = (lesser(p0, p0 + p_rise) <= 0.0) | (lesser(q0, q0 + q_rise) <= 0.0)
    if any_of(cut):
        for first, rise in ((p0, p_rise), (q0, q_rise)):
            # where the function vanishes along the edge
            root = -first / where(rise == 0.0, 1.0, rise)
            low = where(rise > 0.0, greater(low, root), low)
            high = where(rise < 0.0, lesser(high, root), where((rise == 0.0) & (first <= 0.0), 0.0, high))
    # integrate by Simpson's rule
    length = greater(high - low, 0.0)
    total, moment = zero, zero
    for part, weight in SIMPSON:
        s = low + part * length
        product = weight * length * (p0 + s * p_rise) * (q0 + s * q_rise)
        total += product
        moment -= product * (dx * (x0 + s * dx) + dy * (y0 + s * dy))
    # middle of the part
    s = low + 0.5 * length
    return dy * total, -(dx * total), moment, x0 + s * dx, y0 + s * dy
