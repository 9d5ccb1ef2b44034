"""The distance of two convex bodies by their corners.

The point of the Minkowski difference nearest to the origin is found from support points (E. G. Gilbert, D. W. Johnson,
S. S. Keerthi, IEEE J. Robotics and Automation 4, 1988, p. 193).
"""

import math
from typing import Any, NamedTuple

from ..numba_ext.jit import kernel, leaf
from .cells import facet_of
from .kinematics import along, cross, dot, minus, out_of, plus
from .layout import SOLID_CORNERS

MOST_SUPPORTS = 100
CLOSE = 1e-13  # of the squared distance, by which a support point must be nearer
ROUNDING = 1e-15  # of products
FLAT = 1e-11  # sine of the angle between an edge and a plane below which its end counts as in the plane


class _Simplex(NamedTuple):
    """One to four support points, and the point of their hull nearest to the origin."""

    size: int  # number of points
    a: Any
    b: Any
    c: Any
    nearest: Any


@kernel
def corner_along(solid, direction):
    """Return the corner of a body that is farthest along a direction."""
    best, found = -math.inf, SOLID_CORNERS
    for q in range(int(solid[1])):
        k = SOLID_CORNERS + 3 * q
        reached = solid[k] * direction[0] + solid[k + 1] * direction[1] + solid[k + 2] * direction[2]
        if reached > best:
            best, found = reached, k
    return solid[found], solid[found + 1], solid[found + 2]


@kernel
def _support(solid, other, placed, direction):
    """Return the point of the difference, other body less the first one, that is farthest along a direction."""
    own = along(placed.x, placed.y, placed.z, direction)
    reached = plus(placed.at, out_of(placed.x, placed.y, placed.z, corner_along(other, own)), 1.0)
    return minus(reached, corner_along(solid, (-direction[0], -direction[1], -direction[2])))


@leaf
def _on_segment(a, b):
    """Return the simplex of two points, less what the nearest point does not need."""
    way = minus(b, a)
    square, part = dot(way, way), -dot(a, way)
    if part <= 0.0:
        return _Simplex(1, a, a, a, a)
    if part >= square:
        return _Simplex(1, b, b, b, b)
    return _Simplex(2, a, b, b, plus(a, way, part / square))


@kernel
def _on_triangle(a, b, c):
    """Return the simplex of three points, less what the nearest point does not need (Voronoi regions of a triangle)."""
    ab, ac = minus(b, a), minus(c, a)
    d1, d2, d3, d4, d5, d6 = -dot(ab, a), -dot(ac, a), -dot(ab, b), -dot(ac, b), -dot(ab, c), -dot(ac, c)
    # corners
    if d1 <= 0.0 and d2 <= 0.0:
        return _Simplex(1, a, a, a, a)
    if d3 >= 0.0 and d4 <= d3:
        return _Simplex(1, b, b, b, b)
    if d6 >= 0.0 and d5 <= d6:
        return _Simplex(1, c, c, c, c)
    # edges
    if d1 >= 0.0 >= d3 and d1 * d4 - d3 * d2 <= 0.0:
        return _Simplex(2, a, b, b, plus(a, ab, d1 / (d1 - d3)))
    if d2 >= 0.0 >= d6 and d5 * d2 - d1 * d6 <= 0.0:
        return _Simplex(2, a, c, c, plus(a, ac, d2 / (d2 - d6)))
    if d4 - d3 >= 0.0 and d5 - d6 >= 0.0 and d3 * d6 - d5 * d4 <= 0.0:
        return _Simplex(2, b, c, c, plus(b, minus(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))))
    # inside
    n = cross(ab, ac)
    square = dot(n, n)
    if square == 0.0:
        return _on_segment(a, b)
    factor = dot(a, n) / square
    return _Simplex(3, a, b, c, (factor * n[0], factor * n[1], factor * n[2]))


@leaf
def _is_beyond(a, b, c, d):
    """Return True if the origin lies on the other side of the plane (a, b, c) than d, or if d lies in that plane."""
    n, edge = cross(minus(b, a), minus(c, a)), minus(d, a)
    height = dot(n, edge)
    return dot(n, a) * height > 0.0 or height * height <= FLAT * FLAT * dot(n, n) * dot(edge, edge)


@kernel
def _on_tetrahedron(a, b, c, d):
    """Return the simplex of four points, less what the nearest point does not need; count 4 if it holds the origin."""
    found, least = _Simplex(4, a, b, c, (0.0, 0.0, 0.0)), math.inf
    for p, q, r, s in ((a, b, c, d), (a, b, d, c), (a, c, d, b), (b, c, d, a)):
        # the nearest of the sides beyond which the origin lies
        if _is_beyond(p, q, r, s):
            one = _on_triangle(p, q, r)
            square = dot(one.nearest, one.nearest)
            if square < least:
                found, least = one, square
    return found


@kernel
def distance(solid, other, placed):
    """Return the distance of two bodies, m, and the vector from the first to the other one; 0 if they overlap.

    Parameters
    ----------
    solid, other : row
        Both bodies (layout.py, SOLID).
    placed : Placed
        The other body along the axes of the first one.
    """
    first = _support(solid, other, placed, (-placed.at[0], -placed.at[1], -placed.at[2]))
    found = _Simplex(1, first, first, first, first)
    extent = dot(placed.at, placed.at)
    for _ in range(MOST_SUPPORTS):
        v = found.nearest
        square = dot(v, v)
        if square <= 1e-30 * extent:
            return 0.0, v
        w = _support(solid, other, placed, (-v[0], -v[1], -v[2]))
        # no point is nearer
        if square - dot(v, w) <= max(CLOSE * square, ROUNDING * math.sqrt(square * dot(w, w))):
            return math.sqrt(square), v
        if found.size == 1:
            found = _on_segment(found.a, w)
        elif found.size == 2:
            found = _on_triangle(found.a, found.b, w)
        else:
            found = _on_tetrahedron(found.a, found.b, found.c, w)
        if found.size == 4:
            return 0.0, found.nearest
        # rounding: no progress
        if dot(found.nearest, found.nearest) >= square:
            return math.sqrt(square), v
    return math.sqrt(dot(found.nearest, found.nearest)), found.nearest


@kernel
def depth_by_planes(solid, other, placed):
    """Return how deep another body reaches below that plane of a body below which it is the least deep, m."""
    least = math.inf
    for i in range(int(solid[0])):
        facet = facet_of(solid, i, 0.0)
        n = facet.n
        own = along(placed.x, placed.y, placed.z, n)
        nearest = corner_along(other, (-own[0], -own[1], -own[2]))
        reached = plus(placed.at, out_of(placed.x, placed.y, placed.z, nearest), 1.0)
        least = min(least, facet.c - dot(n, reached))
    return least


@kernel
def is_within(solid, other, placed, margin):
    """Return True if another body lies wholly within a body, but for a margin, m."""
    for i in range(int(solid[0])):
        facet = facet_of(solid, i, 0.0)
        highest = corner_along(other, along(placed.x, placed.y, placed.z, facet.n))
        reached = plus(placed.at, out_of(placed.x, placed.y, placed.z, highest), 1.0)
        if dot(facet.n, reached) > facet.c + margin:
            return False
    return True
