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
from .sides import NOTHING, scaled

SAME = 1e-12  # difference of two heights, m, and of their slopes, below which they are one
_FACE = 4 * SOLID_PLANES  # in `cells`, behind the planes of the other body: the face, then the heights above it
_ROOFS = _FACE + CELL_CORNERS
LEFT = 1e-9  # of the pressure: less is none
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
            cells[k + 3] = least
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
def _area(room, count):
    """Return the area of the polygon in the room, m2."""
    total = 0.0
    for k in range(2, count):
        x1, y1 = room[2 * k - 2] - room[0], room[2 * k - 1] - room[1]
        x2, y2 = room[2 * k] - room[0], room[2 * k + 1] - room[1]
        total += x1 * y2 - x2 * y1
    return 0.5 * total


@kernel
def _normal_of_contact(scene, solid, planes, inwards):
    """Return the unit vector along which both bodies are damped, and the range of faces within the other body.

    The vector is that of the area of these faces of the first body: the normal of a face that an edge or a corner
    presses on, whichever of both bodies is the first one.
    """
    faces = int(solid[0])
    if faces == 1:
        return facet_of(solid, 0, inwards).n, 0, 1
    whole, hint, first, end = NOTHING, -1, 0, 0
    for i in range(faces):
        facet = facet_of(solid, i, inwards)
        count, hint = _common_face(scene.room, scene.cells, solid, planes, facet, hint, False)
        if inwards != 0.0:
            count = _within_own(scene.room, solid, i, facet, count, inwards)
        if count >= 3:
            whole = plus(whole, facet.n, _area(scene.room, count))
            first, end = i if end == 0 else first, i + 1
    # of one face exactly its normal
    size = math.sqrt(dot(whole, whole))
    if end == first + 1:
        return facet_of(solid, first, inwards).n, first, end
    return scaled(whole, 1.0 / size) if size > 0.0 else NOTHING, first, end


@leaf
def _closing_over(facet, placed, n, factor):
    """Return `factor` times the velocity at which the other body approaches against n, over a facet, m/s."""
    m = cross(n, placed.spins)
    at = dot(n, placed.moves) + facet.c * dot(m, facet.n)
    return Plane(-factor * at, -factor * dot(m, facet.e1), -factor * dot(m, facet.e2))


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
        N/m3; s, by which half of the velocity at which both bodies approach counts beside a height. This part of the
        pressure acts along the normal of the contact, so it never adds energy and never drags an edge along a face.
    owns_flush : bool
        Whether the cell below two faces in one plane is that of the first body. Forces leave it to the other body, so
        that bodies whose tops are level do not push each other up or down.

    Returns
    -------
    Pressed
        Zero for bodies without a common volume.
    """
    room, cells = scene.room, scene.cells
    force, moment, centre, total, undamped, energy, highest = NOTHING, NOTHING, NOTHING, 0.0, 0.0, 0.0, 0.0
    planes, hint = _place_planes(cells, other, placed, farther), -1
    along, first, end = NOTHING, 0, int(solid[0])
    if damping != 0.0:
        along, first, end = _normal_of_contact(scene, solid, planes, inwards)
    for i in range(first, end):
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
        # the part below each roof; damped: of the height, with the closing velocity
        push, x, y, damped, damped_x, damped_y = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        closing = _closing_over(facet, placed, along, 0.5 * damping)
        for r in range(found):
            kept = _lowest_part(room, cells, count, found, bound, r)
            if kept < 3:
                continue
            roof = _roof(cells, r)
            highest = _highest(room, kept, roof, highest)
            force_of, x_of, y_of = _integrals(room, kept, roof)
            energy += 0.5 * stiffness * (roof.at * force_of + roof.along_x * x_of + roof.along_y * y_of)
            push, x, y = push + force_of, x + x_of, y + y_of
            if damping != 0.0:
                q = Plane(roof.at + closing.at, roof.along_x + closing.along_x, roof.along_y + closing.along_y)
                force_of, x_of, y_of = _integrals(room, cut(room, kept, q), q)
                damped, damped_x, damped_y = damped + force_of, damped_x + x_of, damped_y + y_of
        # resultant and moment of the heights
        push, x, y = stiffness * push, stiffness * x, stiffness * y
        undamped += push
        force = plus(force, facet.n, -push)
        moment = plus(plus(moment, facet.e2, x), facet.e1, -y)
        # and of the damping, along the normal of the contact
        if damping != 0.0:
            damped, damped_x, damped_y = stiffness * damped, stiffness * damped_x, stiffness * damped_y
            more, per = damped - push, max(dot(along, facet.n), 0.0)
            force = plus(force, along, -per * more)
            at = plus(plus(scaled(facet.n, facet.c * more), facet.e1, damped_x - x), facet.e2, damped_y - y)
            moment = plus(moment, cross(at, along), -per)
            push, x, y = damped, damped_x, damped_y
        # centre
        centre = plus(plus(plus(centre, facet.n, facet.c * push), facet.e1, x), facet.e2, y)
        total += push
    # where damping takes all of the pressure, no force of its rounding, which friction would follow
    if total <= LEFT * undamped:
        force, moment, centre, total = NOTHING, NOTHING, NOTHING, 0.0
    return Pressed(force, moment, centre, total, energy, highest)
