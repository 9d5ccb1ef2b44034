"""Contact of two convex bodies at any orientation (theory.md section 17).

The energy is the integral, over the common volume of both bodies, of stiffness times the distance from the nearest of
their planes. The points nearest to plane i are a cell over the part of that plane within both bodies. Over a point of
it the cell is as high as the least of d_j / g_j over all other planes j: d_j is the depth of the point below plane j,
and g_j half of the squared difference of both normals. So the pressure on plane i of the first body is stiffness times
this height, and no polyhedron is clipped, only polygons. The same pressure acts on the other body.
"""

import math
from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf
from .bed import Plane, triangle, value
from .clipping import cut
from .kinematics import cross, dot, minus, out_of, plus
from .layout import CELL_CORNERS, PER_ROOF, SOLID_CORNERS, SOLID_PLANE, SOLID_PLANES
from .sides import NOTHING

SAME = 1e-12  # difference of two heights, m, and of their slopes, below which they are one
_FACE = 4 * SOLID_PLANES  # in `cells`, behind the planes of the other body: the face, then the heights above it
_ROOFS = _FACE + CELL_CORNERS
COPLANAR = 1e-24  # squared difference of normals below which two planes never bound the same cell


class Facet(NamedTuple):
    """A plane of a body and its face, along the axes of the body."""

    n: object  # outward normal
    c: object  # m, distance from the centroid
    e1: object  # axes of the outline
    e2: object
    first: int  # place of the outline
    corners: int  # their number


class Placed(NamedTuple):
    """The other body as the first one sees it, along the axes of the first one."""

    x: object  # axes of the other body
    y: object
    z: object
    at: object  # m, its centroid from that of the first one
    moves: object  # m/s, its velocity at the centroid of the first one
    spins: object  # rad/s, its relative angular velocity


class Pressed(NamedTuple):
    """The pressure on the first body, along its own axes."""

    force: object  # N
    moment: object  # N m, about its centroid
    centre: object  # m, sum of the pressures times their places, over `total`
    total: float  # N, sum of the sizes of the pressures
    energy: float  # J, of the cells of its planes, without damping
    highest: float  # m, of a cell


@leaf
def _place_of(solid, i):
    """Return the place of plane i in the row of a body."""
    return SOLID_CORNERS + 3 * int(solid[1]) + SOLID_PLANE * i


@leaf
def facet_of(solid, i, inwards):
    """Return plane i of a body, `inwards` m within its surface."""
    k = _place_of(solid, i)
    n, e1 = (solid[k], solid[k + 1], solid[k + 2]), (solid[k + 4], solid[k + 5], solid[k + 6])
    return Facet(n, solid[k + 3] - inwards, e1, cross(n, e1), int(solid[k + 7]), int(solid[k + 8]))


@kernel
def _place_planes(cells, other, placed, farther):
    """Fill the cells with the planes of the other body along the axes of the first one; return their number."""
    count = int(other[0])
    for j in range(count):
        k = _place_of(other, j)
        n = out_of(placed.x, placed.y, placed.z, (other[k], other[k + 1], other[k + 2]))
        cells[4 * j], cells[4 * j + 1], cells[4 * j + 2] = n
        cells[4 * j + 3] = other[k + 3] + dot(n, placed.at) - farther
    return count


@leaf
def _normal(cells, j):
    """Return the normal of plane j of the other body."""
    return cells[4 * j], cells[4 * j + 1], cells[4 * j + 2]


@leaf
def _over(facet, n, c, factor):
    """Return the depth below a plane (n, c) times a factor, as a linear function over a facet."""
    foot = c - facet.c * dot(n, facet.n)
    return Plane(factor * foot, -factor * dot(n, facet.e1), -factor * dot(n, facet.e2))


@leaf
def _plane_of(solid, i, inwards):
    """Return normal and distance (m) of plane i of a body, `inwards` m within its surface."""
    k = _place_of(solid, i)
    return (solid[k], solid[k + 1], solid[k + 2]), solid[k + 3] - inwards


@leaf
def _is_beyond(solid, facet, depth):
    """Return True if all corners of a face are above a plane; depth: that below it, over the face."""
    for k in range(facet.first, facet.first + 2 * facet.corners, 2):
        if value(depth, solid[k], solid[k + 1]) > -SAME:
            return False
    return True


@kernel
def _common_face(room, cells, solid, planes, facet, hint, owns_flush):
    """Fill the room with the part of a face of the first body within the other one.

    Return its number of corners, and the plane of the other body that leaves nothing of the face, else -1: it is tried
    first for the next face. hint: that of the face before.
    """
    # faces next to each other lie beyond the same plane
    if hint >= 0 and _is_beyond(solid, facet, _over(facet, _normal(cells, hint), cells[4 * hint + 3], 1.0)):
        return 0, hint
    count = facet.corners
    for k in range(2 * count):
        room[k] = solid[facet.first + k]
    # clipped by each plane of the other body
    for j in range(planes):
        n = _normal(cells, j)
        depth = _over(facet, n, cells[4 * j + 3], 1.0)
        # a face of the other body in the same plane: not left to rounding
        if abs(depth.at) + abs(depth.along_x) + abs(depth.along_y) < SAME and dot(n, facet.n) > 0.0:
            if owns_flush:
                continue
            return 0, -1
        count = cut(room, count, depth)
        if count < 3:
            return 0, j
    return count, -1


@kernel
def _within_own(room, solid, i, facet, count, inwards):
    """Clip the face in the room to that of a body whose planes have moved inwards, m; return its number of corners."""
    for j in range(int(solid[0])):
        if j != i and count > 0:
            n, c = _plane_of(solid, j, inwards)
            away = minus(n, facet.n)
            if dot(away, away) >= COPLANAR:
                count = cut(room, count, _over(facet, n, c, 1.0))
    return count


@kernel
def _find_roofs(room, cells, solid, planes, i, facet, count, inwards):
    """Store the planes that may bound the cell over the face in the room, each as the height below it, m.

    Return their number, and the height that the cell does not exceed.
    """
    found, bound = 0, math.inf
    for j in range(planes + int(solid[0])):
        # planes of the other body first, then those of the first one
        n, c = (_normal(cells, j), cells[4 * j + 3]) if j < planes else _plane_of(solid, j - planes, inwards)
        away = minus(n, facet.n)
        square = dot(away, away)
        if j == planes + i or square < COPLANAR:
            continue
        # heights at the corners: nowhere the least, or a bound for all others
        roof = _over(facet, n, c, 2.0 / square)
        least, most = math.inf, -math.inf
        for k in range(count):
            height = value(roof, room[2 * k], room[2 * k + 1])
            least, most = min(least, height), max(most, height)
        if least < bound and not _is_stored(cells, found, roof):
            k = _ROOFS + PER_ROOF * found
            cells[k], cells[k + 1], cells[k + 2] = roof.at, roof.along_x, roof.along_y
            cells[k + 3], cells[k + 4], cells[k + 5] = least, float(j), 2.0 / square
            # the lowest one first, which cuts most from the others
            if most < bound:
                bound = most
                _swap(cells, _ROOFS, k)
            found += 1
    return found, bound


@leaf
def _is_stored(cells, found, roof):
    """Return True if a height is stored already, as where sides of both bodies are flush."""
    for r in range(found):
        other = _roof(cells, r)
        away = abs(other.at - roof.at) + abs(other.along_x - roof.along_x) + abs(other.along_y - roof.along_y)
        if away < SAME:
            return True
    return False


@leaf
def _swap(cells, first, other):
    """Exchange two stored heights."""
    for k in range(PER_ROOF):
        cells[first + k], cells[other + k] = cells[other + k], cells[first + k]


@leaf
def _roof(cells, r):
    """Return stored height r as a linear function."""
    k = _ROOFS + PER_ROOF * r
    return Plane(cells[k], cells[k + 1], cells[k + 2])


@kernel
def _lowest_part(room, cells, count, found, bound, r):
    """Fill the room with the part of the kept face over which roof r is the lowest; return its number of corners."""
    roof = _roof(cells, r)
    if cells[_ROOFS + PER_ROOF * r + 3] > bound:
        return 0
    for k in range(2 * count):
        room[k] = cells[_FACE + k]
    for s in range(found):
        if s == r or cells[_ROOFS + PER_ROOF * s + 3] > bound:
            continue
        other = _roof(cells, s)
        higher = Plane(other.at - roof.at, other.along_x - roof.along_x, other.along_y - roof.along_y)
        count = cut(room, count, higher)
        if count < 3:
            return 0
    return count


@leaf
def _rate_over(cells, r, facet, placed, roof):
    """Return the rate at which a roof of the other body rises over a facet, m/s, as a linear function."""
    k = _ROOFS + PER_ROOF * r
    j, factor = int(cells[k + 4]), cells[k + 5]
    n = _normal(cells, j)
    # n . (moves + spins x place), with the place on the roof
    m = cross(n, placed.spins)
    below = dot(m, facet.n)
    return Plane(
        factor * (dot(n, placed.moves) + facet.c * below - below * roof.at),
        factor * (dot(m, facet.e1) - below * roof.along_x),
        factor * (dot(m, facet.e2) - below * roof.along_y),
    )


@kernel
def _integrals(room, count, f):
    """Integrate a linear function f, f x and f y over the polygon in the room."""
    total, first_x, first_y = 0.0, 0.0, 0.0
    # a fan of triangles
    for k in range(2, count):
        x = room[0], room[2 * k - 2], room[2 * k]
        y = room[1], room[2 * k - 1], room[2 * k + 1]
        q = value(f, x[0], y[0]), value(f, x[1], y[1]), value(f, x[2], y[2])
        _, force, along_x, along_y = triangle(x, y, q)
        total, first_x, first_y = total + force, first_x + along_x, first_y + along_y
    return total, first_x, first_y


@leaf
def _highest(room, count, roof, highest):
    for k in range(count):
        highest = max(highest, value(roof, room[2 * k], room[2 * k + 1]))
    return highest


@kernel
def press(scene, solid, other, placed, farther, inwards, stiffness, damping, owns_flush):
    """Integrate the pressure on the planes of a body that another one presses on.

    Parameters
    ----------
    scene : KernelScene
        Its rooms are used.
    solid, other : row
        Both bodies (layout.py, SOLID).
    placed : Placed
        The other body along the axes of the first one.
    farther, inwards : float
        How far the planes of the other body and those of this one lie within their surfaces, m.
    stiffness, damping : float
        N/m3; s, by which the rate of a height counts beside the height.
    owns_flush : bool
        Whether the cell below two faces in one plane is that of the first body. Forces leave it to the other body, so
        that bodies whose tops are level do not push each other up or down.

    Returns
    -------
    Pressed
        Zero for bodies without a common volume.
    """
    room, cells = scene.room, scene.cells
    force, moment, centre, total, energy, highest = NOTHING, NOTHING, NOTHING, 0.0, 0.0, 0.0
    planes, hint = _place_planes(cells, other, placed, farther), -1
    for i in range(int(solid[0])):
        # the face within the other body, kept beside the room
        facet = facet_of(solid, i, inwards)
        count, hint = _common_face(room, cells, solid, planes, facet, hint, owns_flush)
        if inwards != 0.0:
            count = _within_own(room, solid, i, facet, count, inwards)
        if count < 3:
            continue
        for k in range(2 * count):
            cells[_FACE + k] = room[k]
        found, bound = _find_roofs(room, cells, solid, planes, i, facet, count, inwards)
        # the part below each roof
        push, x, y = 0.0, 0.0, 0.0
        for r in range(found):
            kept = _lowest_part(room, cells, count, found, bound, r)
            if kept < 3:
                continue
            roof = _roof(cells, r)
            highest = _highest(room, kept, roof, highest)
            q = roof
            # roofs of the other body move
            if damping != 0.0 and cells[_ROOFS + PER_ROOF * r + 4] < planes:
                rate = _rate_over(cells, r, facet, placed, roof)
                q = Plane(
                    roof.at + damping * rate.at,
                    roof.along_x + damping * rate.along_x,
                    roof.along_y + damping * rate.along_y,
                )
                kept = cut(room, kept, q)
            force_of, x_of, y_of = _integrals(room, kept, q)
            energy += 0.5 * stiffness * (roof.at * force_of + roof.along_x * x_of + roof.along_y * y_of)
            push, x, y = push + force_of, x + x_of, y + y_of
        # resultant, moment and centre
        push, x, y = stiffness * push, stiffness * x, stiffness * y
        force = plus(force, facet.n, -push)
        moment = plus(plus(moment, facet.e2, x), facet.e1, -y)
        centre = plus(plus(plus(centre, facet.n, facet.c * push), facet.e1, x), facet.e2, y)
        total += push
    return Pressed(force, moment, centre, total, energy, highest)
