"""Two sides that face each other: their positions, their approach, and forces on both (theory.md section 17)."""

from typing import NamedTuple

from ..numba_ext.jit import leaf
from .kinematics import cross, dot, minus, plus, push, standing

NOTHING = (0.0, 0.0, 0.0)
SLACK = 1e-9  # m: a pair separates beyond this gap, and touches below half of it


class Sides(NamedTuple):
    """Both sides of a pair at present: directions along the axes of the base, lengths in m."""

    a: int  # bodies
    b: int
    arm_a: object  # from the centroid to the middle of the axis of the first drum, or of the first face
    arm_b: object  # likewise of the other side
    between: object  # from the middle of the other side to that of the first one
    u: object  # axis of the first drum, or the normal of the first face
    v: object  # that of the other one


class Touch(NamedTuple):
    """The normal contact of a pair."""

    force: float  # N, of the pressure
    energy: float  # J, of the sides of drums
    resultant: object  # N, on the first body: sum of pressure, edges and ends
    on_a: object  # m, centre of the pressure from the centroids of both bodies
    on_b: object


NO_TOUCH = Touch(0.0, 0.0, NOTHING, NOTHING, NOTHING)


@leaf
def place_of(scene, phase, i):
    """Return the position of the centroid of body i, m."""
    bodies = scene.bodies
    if i == scene.n:
        return bodies.x[i], bodies.y[i], bodies.z[i]
    return bodies.x[i] + phase.ux[i], bodies.y[i] + phase.uy[i], bodies.z[i] + phase.uz[i]


@leaf
def sides_of(scene, phase, pairs, p):
    """Return both sides of pair p at present."""
    a, b = int(pairs.one[p]), int(pairs.other[p])
    # middles of both sides, and the vector between them
    arm_a = standing(scene.poses, a, pairs.ax[p], pairs.ay[p], pairs.az[p])
    arm_b = standing(scene.poses, b, pairs.bx[p], pairs.by[p], pairs.bz[p])
    between = minus(plus(place_of(scene, phase, a), arm_a, 1.0), plus(place_of(scene, phase, b), arm_b, 1.0))
    # axes of drums, or normals of faces
    u = standing(scene.poses, a, pairs.ux[p], pairs.uy[p], pairs.uz[p])
    v = standing(scene.poses, b, pairs.vx[p], pairs.vy[p], pairs.vz[p])
    return Sides(a, b, arm_a, arm_b, between, u, v)


@leaf
def spin_of(scene, i):
    """Return the angular velocity of body i, rad/s, along the axes of the base."""
    return scene.poses.wx[i], scene.poses.wy[i], scene.poses.wz[i]


@leaf
def velocity_of(scene, phase, i, arm):
    """Return the velocity, m/s, of the end of an arm (m) from the centroid of body i."""
    if i == scene.n:
        return NOTHING
    return plus((phase.vx[i], phase.vy[i], phase.vz[i]), cross(spin_of(scene, i), arm), 1.0)


@leaf
def rate_along(scene, phase, sides, n, on_a, on_b):
    """Return the rate, m/s, at which the ends of arms on_a and on_b of both bodies approach each other along n."""
    return -dot(n, minus(velocity_of(scene, phase, sides.a, on_a), velocity_of(scene, phase, sides.b, on_b)))


@leaf
def arms_to(sides, place):
    """Return the arms from the centroids of both bodies to a point given from the middle of the first side, m."""
    return plus(sides.arm_a, place, 1.0), plus(plus(sides.arm_b, sides.between, 1.0), place, 1.0)


@leaf
def push_both(scene, sides, place, force, couple):
    """Add a force, N, and a couple, N m, to the first body and their opposites to the other one.

    place: point of action, m from the middle of the first side.
    """
    on_a, on_b = arms_to(sides, place)
    push(scene.poses, sides.a, on_a, force, couple, 1.0)
    push(scene.poses, sides.b, on_b, force, scaled(couple, -1.0), -1.0)


@leaf
def edge_of(scene, pairs, p, k):
    """Return x, y, dx, dy of edge k of the other face of pair p, m: its first corner and the vector to the next."""
    first, count, corners = int(pairs.first[p]), int(pairs.corners[p]), scene.corners
    after = k + 1 if k + 1 < count else 0
    x, y = corners[first + 2 * k], corners[first + 2 * k + 1]
    return x, y, corners[first + 2 * after] - x, corners[first + 2 * after + 1] - y


@leaf
def scaled(a, factor):
    """Return a vector times a number."""
    return a[0] * factor, a[1] * factor, a[2] * factor
