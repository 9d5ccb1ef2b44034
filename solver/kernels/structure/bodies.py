"""Contact of the convex bodies of a pair: their places, forces, energy and distance."""

import math
from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf
from .cells import Placed, facet_of, press
from .distance import corner_along, depth_by_planes, distance, is_within
from .kinematics import along, dot, minus, out_of, plus, push, seen_from, standing
from .layout import SOLID
from .sides import NO_TOUCH, NOTHING, SLACK, Touch, place_of, scaled, spin_of, velocity_of

_solid = SOLID.over
PARALLEL = 1e-12  # squared sine of the angle below which axes are parallel


class Bodies(NamedTuple):
    """Both bodies of a pair; the first one has no more planes than the other, so that its cells are the fewer."""

    own: int  # bodies
    opposite: int
    solid: object  # rows of both (layout.py, SOLID)
    other: object
    sign: float  # 1 if `own` is the first body of the pair, else -1


@leaf
def bodies_of(scene, pairs, p):
    """Return the bodies of pair p."""
    a, b = int(pairs.one[p]), int(pairs.other[p])
    solid, other = scene.corners[int(pairs.body_a[p]) :], scene.corners[int(pairs.body_b[p]) :]
    # of equal numbers of planes that of the larger one, whose faces are met by the edges of the other
    one, two = _solid(solid, 0), _solid(other, 0)
    if one.planes < two.planes or (one.planes == two.planes and one.size >= two.size):
        return Bodies(a, b, solid, other, 1.0)
    return Bodies(b, a, other, solid, -1.0)


@leaf
def _axis_between(scene, own, opposite, x, y, z):
    """Return an axis of the opposite body along the axes of the own one."""
    return seen_from(scene.poses, own, standing(scene.poses, opposite, x, y, z))


@leaf
def placed_of(scene, phase, own, opposite):
    """Return a body as another one sees it."""
    poses, between = scene.poses, minus(place_of(scene, phase, opposite), place_of(scene, phase, own))
    # relative velocity, at the centroid of the own body
    back = -between[0], -between[1], -between[2]
    moves = minus(velocity_of(scene, phase, opposite, back), velocity_of(scene, phase, own, NOTHING))
    return Placed(
        _axis_between(scene, own, opposite, 1.0, 0.0, 0.0),
        _axis_between(scene, own, opposite, 0.0, 1.0, 0.0),
        _axis_between(scene, own, opposite, 0.0, 0.0, 1.0),
        seen_from(poses, own, between),
        seen_from(poses, own, moves),
        seen_from(poses, own, minus(spin_of(scene, opposite), spin_of(scene, own))),
    )


@kernel
def load_bodies(scene, phase, pairs, p, farther):
    """Add the normal forces of the bodies of pair p, `farther` m apart; return their contact (`Touch`)."""
    both = bodies_of(scene, pairs, p)
    placed = placed_of(scene, phase, both.own, both.opposite)
    law = farther, 0.0, pairs.body_stiffness[p], pairs.damping[p]
    found = press(scene, both.solid, both.other, placed, *law, False)
    scene.extras.hits.highest[p] = found.highest
    if found.total == 0.0:
        return NO_TOUCH
    # along the axes of the base: equal forces on both bodies at the same place
    poses, own, opposite = scene.poses, both.own, both.opposite
    force = standing(poses, own, *found.force)
    moment = standing(poses, own, *found.moment)
    between = minus(place_of(scene, phase, own), place_of(scene, phase, opposite))
    push(poses, own, NOTHING, force, moment, 1.0)
    push(poses, opposite, between, force, (-moment[0], -moment[1], -moment[2]), -1.0)
    # centre of the pressure
    per = 1.0 / found.total
    arm = standing(poses, own, per * found.centre[0], per * found.centre[1], per * found.centre[2])
    beyond = plus(arm, between, 1.0)
    size = math.sqrt(dot(force, force))
    if both.sign > 0.0:
        return Touch(size, 0.0, force, arm, beyond)
    return Touch(size, 0.0, (-force[0], -force[1], -force[2]), beyond, arm)


@kernel
def energy_of_bodies(scene, phase, pairs, p, farther):
    """Return the elastic energy of the bodies of pair p, `farther` m apart, J: that of the cells of both.

    The planes of one body lie within its surface by `farther`, those that `load_bodies` moves.
    """
    both, k = bodies_of(scene, pairs, p), pairs.body_stiffness[p]
    seen, back = placed_of(scene, phase, both.own, both.opposite), placed_of(scene, phase, both.opposite, both.own)
    own = press(scene, both.solid, both.other, seen, farther, 0.0, k, 0.0, False)
    opposite = press(scene, both.other, both.solid, back, 0.0, farther, k, 0.0, True)
    return own.energy + opposite.energy


@kernel
def gap_of_bodies(scene, phase, pairs, p, farther, highest):
    """Return the distance of the bodies of pair p, m; if they overlap, less twice the height of their highest cell.

    farther: added to the distance, m; highest: that height, m, 0 if it is not known.
    """
    if highest > 0.0:
        return -2.0 * highest
    both = bodies_of(scene, pairs, p)
    placed = placed_of(scene, phase, both.own, both.opposite)
    away, n = distance(both.solid, both.other, placed)
    if away > 0.0:
        hits = scene.extras.hits
        hits.nx[p], hits.ny[p], hits.nz[p] = scaled(n, 1.0 / away)
        return farther + away
    highest = press(scene, both.solid, both.other, placed, farther, 0.0, 1.0, 0.0, False).highest
    if highest > 0.0:
        return -2.0 * highest
    # bodies that count as farther apart, or one wholly within the other, whose surfaces do not cross
    back = placed_of(scene, phase, both.opposite, both.own)
    depth = min(depth_by_planes(both.solid, both.other, placed), depth_by_planes(both.other, both.solid, back))
    if is_within(both.solid, both.other, placed, SLACK) or is_within(both.other, both.solid, back, SLACK):
        return farther - depth
    return max(farther - depth, 0.0)


@kernel
def _thickness(solid):
    """Return the least width of a body across one of its planes, m."""
    least = math.inf
    for i in range(int(solid[0])):
        facet = facet_of(solid, i, 0.0)
        back = scaled(facet.n, -1.0)
        least = min(least, facet.c + dot(back, corner_along(solid, back)))
    return least


@kernel
def path_through(scene, pairs, p):
    """Return the path, m, on which the bodies of pair p overlap where one passes straight through the other."""
    both = bodies_of(scene, pairs, p)
    return _thickness(both.solid) + _thickness(both.other)


@leaf
def _reach_of_drum(solid, n):
    """Return how far a drum reaches along a unit vector from its centroid, m."""
    record = _solid(solid, 0)
    cosine = dot(n, (record.ux, record.uy, record.uz))
    return record.half * abs(cosine) + record.radius * math.sqrt(max(0.0, 1.0 - cosine * cosine))


@kernel
def _reach(solid, n):
    """Return how far a body, or the drum about a prism, reaches along a unit vector from its centroid, m."""
    return _reach_of_drum(solid, n) if _solid(solid, 0).radius > 0.0 else dot(n, corner_along(solid, n))


@kernel
def least_gap_of_bodies(scene, phase, pairs, p, farther):
    """Return a lower bound of the distance of the bodies of pair p, m, along the direction of their last distance.

    It is -inf before there has been one. farther: as of `gap_of_bodies`.
    """
    both, hits, poses = bodies_of(scene, pairs, p), scene.extras.hits, scene.poses
    n = hits.nx[p], hits.ny[p], hits.nz[p]
    if n[0] == 0.0 and n[1] == 0.0 and n[2] == 0.0:
        return -math.inf
    across = standing(poses, both.own, *n)
    between = minus(place_of(scene, phase, both.opposite), place_of(scene, phase, both.own))
    back = scaled(seen_from(poses, both.opposite, across), -1.0)
    return farther + dot(across, between) - _reach(both.solid, n) - _reach(both.other, back)


@leaf
def _square_of_segments(u, half_a, v, half_b, at):
    """Return the squared distance, m2, of two segments about the origin and `at`; u, v: their directions."""
    c, a, b = dot(u, v), dot(u, at), dot(v, at)
    sine = 1.0 - c * c
    # the point of the first one nearest to the line of the other, then the nearest points of both
    s = min(max((a - c * b) / sine, -half_a), half_a) if sine > PARALLEL else 0.0
    t = min(max(c * s - b, -half_b), half_b)
    s = min(max(a + c * t, -half_a), half_a)
    between = minus(plus(at, v, t), scaled(u, s))
    return dot(between, between)


@kernel
def _is_before_plane(solid, drum, placed, farther):
    """Return True if a plane of a body separates it from a drum."""
    for i in range(int(solid[0])):
        facet = facet_of(solid, i, 0.0)
        own = along(placed.x, placed.y, placed.z, facet.n)
        if dot(facet.n, placed.at) - _reach_of_drum(drum, own) > facet.c - farther:
            return True
    return False


@kernel
def may_press(scene, phase, pairs, p, farther):
    """Return False if a quick test separates the bodies of pair p, of which one at least is a drum.

    Their axes, or a plane of the one that is no drum, are far enough apart. farther: added to the distance, m.
    """
    both = bodies_of(scene, pairs, p)
    one, other = _solid(both.solid, 0), _solid(both.other, 0)
    placed = placed_of(scene, phase, both.own, both.opposite)
    if one.radius > 0.0 and other.radius > 0.0:
        axis = out_of(placed.x, placed.y, placed.z, (other.ux, other.uy, other.uz))
        square = _square_of_segments((one.ux, one.uy, one.uz), one.half, axis, other.half, placed.at)
        reach = one.radius + other.radius - farther
        return square < reach * abs(reach)
    if other.radius > 0.0:
        return not _is_before_plane(both.solid, both.other, placed, farther)
    back = placed_of(scene, phase, both.opposite, both.own)
    return not _is_before_plane(both.other, both.solid, back, farther)
