"""Contact of two plane faces across a gap (theory.md section 17).

Over the plane of the other face, x and y from its middle, the first one overlaps by delta(x, y). The pressure is
stiffness times q = delta + damping d(delta)/dt where both are positive, over the intersection of the faces as they
stand. The energy is half the stiffness times the integral of delta squared. It also changes as the edges of the first
face move over the other one, which is a force there; so undamped contact without friction conserves energy.
"""

import math
from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf
from .bed import Plane, value
from .clipping import cut
from .edges import SIMPSON
from .kinematics import cross, dot, minus, plus, standing
from .sides import NOTHING, SLACK, Touch, apart, edge_of, push_both, scaled, spin_of, velocity_of

FACING = -0.1  # largest cosine between the normals of opposite faces


class _Facing(NamedTuple):
    """The first face projected on the plane of the other one."""

    e1: object  # axes of that plane
    e2: object
    f1: object  # of the first face
    f2: object
    pull: object  # normal of the first face, scaled to component 1 along that of the other one
    shift: float  # m, offset that moves the first face nearer
    delta: Plane  # m, overlap


@leaf
def _facing(scene, pairs, p, sides):
    # axes of both faces along those of the base
    e1 = standing(scene.poses, sides.b, pairs.e1x[p], pairs.e1y[p], pairs.e1z[p])
    f1 = standing(scene.poses, sides.a, pairs.f1x[p], pairs.f1y[p], pairs.f1z[p])
    e2, f2 = cross(sides.v, e1), cross(sides.u, f1)
    # overlap over the plane of the other face
    pull, shift = scaled(sides.u, 1.0 / dot(sides.u, sides.v)), pairs.radius_a[p]
    delta = Plane(shift - dot(sides.between, pull), dot(e1, pull), dot(e2, pull))
    return _Facing(e1, e2, f1, f2, pull, shift, delta)


@leaf
def _corner(scene, pairs, p, sides, facing, k):
    """Return (x, y) of corner k of the first face in the plane of the other one, m; the corners run clockwise there."""
    # from the middle of the other face
    place = int(pairs.first_a[p]) + 2 * k
    on_a = plus(sides.between, facing.f1, scene.corners[place])
    on_a = plus(on_a, facing.f2, scene.corners[place + 1])
    return dot(on_a, facing.e1), dot(on_a, facing.e2)


@leaf
def _edge(scene, pairs, p, k):
    """Return the linear function that is positive inside of edge k of the other face, m2, and the edge's length, m."""
    ax, ay, dx, dy = edge_of(scene, pairs, p, k)
    return Plane(dy * ax - dx * ay, -dy, dx), math.sqrt(dx * dx + dy * dy)


@kernel
def _share(scene, pairs, p, sides, facing):
    """Fill the room with the intersection of both faces, as x and y; return the number of its corners."""
    room, count = scene.room, int(pairs.corners_a[p])
    # the first face, anticlockwise
    for k in range(count):
        room[2 * k], room[2 * k + 1] = _corner(scene, pairs, p, sides, facing, count - 1 - k)
    # clipped by each edge of the other face
    for k in range(int(pairs.corners[p])):
        count = cut(room, count, _edge(scene, pairs, p, k)[0])
    return count


@leaf
def _above(sides, facing, x, y):
    """Return the point of the first face over (x, y), m from the middle of that face."""
    # point of the other plane, then along its normal
    on_b = plus(scaled(facing.e1, x), facing.e2, y)
    rise = facing.shift - value(facing.delta, x, y)
    return minus(plus(on_b, sides.v, rise), sides.between)


@leaf
def _rate(scene, phase, sides, facing):
    """Return the rate of the overlap, m/s, as a linear function of x and y."""
    place = plus(_above(sides, facing, 0.0, 0.0), sides.between, 1.0)  # from the middle of the other face, m
    on_a, on_b = plus(plus(sides.arm_a, place, 1.0), sides.between, -1.0), plus(sides.arm_b, place, 1.0)
    # velocity at the middle, then its gradient by the relative rotation
    moves = minus(velocity_of(scene, phase, sides.a, on_a), velocity_of(scene, phase, sides.b, on_b))
    spin = minus(spin_of(scene, sides.a), spin_of(scene, sides.b))
    along_x = cross(spin, plus(facing.e1, sides.v, -facing.delta.along_x))
    along_y = cross(spin, plus(facing.e2, sides.v, -facing.delta.along_y))
    return Plane(-dot(facing.pull, moves), -dot(facing.pull, along_x), -dot(facing.pull, along_y))


@leaf
def _linear(plane, x0, y0, x1, y1, x2, y2):
    """Return the values of a linear function at three corners."""
    return value(plane, x0, y0), value(plane, x1, y1), value(plane, x2, y2)


@leaf
def _product(a, b):
    """Return twelve times the mean over a triangle of the product of two linear functions, from their corner values."""
    return (a[0] + a[1] + a[2]) * (b[0] + b[1] + b[2]) + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class _Sums(NamedTuple):
    """The integrals over a polygon of a linear function f, and of its products with x, y and the overlap."""

    force: float
    x: float
    y: float
    delta: float


@kernel
def _integrals(room, count, f, delta):
    """Integrate f, f x, f y and f delta over the polygon of `count` corners in the room."""
    force, first_x, first_y, product = 0.0, 0.0, 0.0, 0.0
    x0, y0 = room[0], room[1]
    # a fan of triangles
    for k in range(2, count):
        x1, y1, x2, y2 = room[2 * k - 2], room[2 * k - 1], room[2 * k], room[2 * k + 1]
        # exact for products of linear functions
        twelfth = ((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) / 24.0
        q = _linear(f, x0, y0, x1, y1, x2, y2)
        force += 4.0 * twelfth * (q[0] + q[1] + q[2])
        first_x += twelfth * _product(q, (x0, x1, x2))
        first_y += twelfth * _product(q, (y0, y1, y2))
        product += twelfth * _product(q, _linear(delta, x0, y0, x1, y1, x2, y2))
    return _Sums(force, first_x, first_y, product)


@kernel
def _push_edges(scene, pairs, p, sides, facing, q):
    """Add the forces of the edges of the first face where they overlap the other one; return their sum, N.

    q: damped overlap, m.
    """
    count, total = int(pairs.corners_a[p]), NOTHING
    for k in range(count):
        # an edge of the first face
        x0, y0 = _corner(scene, pairs, p, sides, facing, k)
        x1, y1 = _corner(scene, pairs, p, sides, facing, k + 1 if k + 1 < count else 0)
        dx, dy, low, high = x1 - x0, y1 - y0, 0.0, 1.0
        # clip the edge to the other face and to where it overlaps
        for e in range(int(pairs.corners[p]) + 1):
            inside = facing.delta if e == int(pairs.corners[p]) else _edge(scene, pairs, p, e)[0]
            begin, end = value(inside, x0, y0), value(inside, x1, y1)
            if begin <= 0.0 and end <= 0.0:
                high = -1.0
            elif begin < 0.0:
                low = max(low, begin / (begin - end))
            elif end < 0.0:
                high = min(high, begin / (begin - end))
        # integrate by Simpson's rule
        if high > low:
            out = plus(scaled(facing.e1, -dy), facing.e2, dx)  # outward normal of a clockwise outline
            for part, weight in SIMPSON:
                s = low + part * (high - low)
                x, y = x0 + s * dx, y0 + s * dy
                delta = value(facing.delta, x, y)
                size = -0.5 * pairs.stiffness[p] * delta * max(value(q, x, y), 0.0) * weight * (high - low)
                push_both(scene, sides, _above(sides, facing, x, y), scaled(out, size))
                total = plus(total, out, size)
    return total


@kernel
def load_faces(scene, phase, pairs, p, sides):
    """Add the normal forces of two faces; return their contact (`Touch`)."""
    # faces that do not face each other exert nothing
    if dot(sides.u, sides.v) > FACING:
        return Touch(0.0, 0.0, NOTHING, NOTHING)
    facing, room, k = _facing(scene, pairs, p, sides), scene.room, pairs.stiffness[p]
    force, energy, total, place = 0.0, 0.0, NOTHING, NOTHING
    # the overlapping part
    count = _share(scene, pairs, p, sides, facing)
    delta = facing.delta
    count = cut(room, count, Plane(delta.at + SLACK, delta.along_x, delta.along_y))
    if count > 2:
        # energy, and the damped overlap
        energy = 0.5 * k * _integrals(room, count, delta, delta).delta
        q = delta
        if pairs.damping[p] != 0.0:
            rate, eta = _rate(scene, phase, sides, facing), pairs.damping[p]
            q = Plane(delta.at + eta * rate.at, delta.along_x + eta * rate.along_x, delta.along_y + eta * rate.along_y)
        # forces of edges, then of the pressure
        edges = _push_edges(scene, pairs, p, sides, facing, q)
        count = cut(room, count, q)
        if count > 2:
            sums = _integrals(room, count, q, delta)
            force = k * sums.force
            place = plus(scaled(facing.e1, sums.x / sums.force), facing.e2, sums.y / sums.force)
            place = minus(plus(place, sides.v, facing.shift - sums.delta / sums.force), sides.between)
            push_both(scene, sides, place, scaled(facing.pull, force))
            total = plus(edges, facing.pull, force)
    return Touch(force, energy, total, place)


@kernel
def gap_of_faces(scene, pairs, p, sides):
    """Return the distance of two faces, m: negative by the deepest overlap, beyond their edges that to the edges."""
    # faces that do not face each other: distance of their middles
    if dot(sides.u, sides.v) > FACING:
        return math.sqrt(dot(sides.between, sides.between))
    # intersection in projection
    facing = _facing(scene, pairs, p, sides)
    count, corners = _share(scene, pairs, p, sides, facing), int(pairs.corners_a[p])
    # the deepest corner of the intersection
    if count > 2:
        deepest = value(facing.delta, scene.room[0], scene.room[1])
        for k in range(1, count):
            deepest = max(deepest, value(facing.delta, scene.room[2 * k], scene.room[2 * k + 1]))
        return -deepest
    # faces that do not overlap in projection: the farthest edge that separates them
    beside, highest = 0.0, -facing.delta.at
    for e in range(int(pairs.corners[p])):
        inside, length = _edge(scene, pairs, p, e)
        nearest = 1e300
        for k in range(corners):
            x, y = _corner(scene, pairs, p, sides, facing, k)
            nearest = min(nearest, -value(inside, x, y) / length)
            highest = min(highest, -value(facing.delta, x, y))
        beside = max(beside, nearest)
    return apart(highest, max(beside, SLACK))
