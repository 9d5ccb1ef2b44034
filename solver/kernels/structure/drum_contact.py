"""Contact of two drums, and of a drum and a plane face (theory.md section 17).

Along the axis of the first drum, s from its middle, both sides overlap by delta(s). The force per length is stiffness
times q = delta + damping d(delta)/dt where that is positive. The ends of the loaded interval are in closed form; if the
end of the other drum or an edge of the face sets one, the energy changes as that end moves, which is a force there.
"""

import math
from typing import NamedTuple

from ..numba_ext.jit import leaf
from .kinematics import cross, dot, minus, plus, push, standing
from .sides import NOTHING, SLACK, Touch, arms_to, edge_of, push_both, rate_along, scaled, spin_of, velocity_of

PARALLEL = 1e-24  # squared sine of the angle below which axes are parallel
ALONG = 1e-9  # least cosine between the axis and the normal of an edge that ends a contact
NODES = (0.0, 0.5384693101056831, -0.5384693101056831, 0.906179845938664, -0.906179845938664)  # of Gauss-Legendre rule
WEIGHTS = (0.5688888888888889, 0.47862867049936647, 0.47862867049936647, 0.23692688505618908, 0.23692688505618908)


class Interval(NamedTuple):
    """An interval of the axis of the first drum, m from its middle; empty if low > high."""

    low: float
    high: float
    by_low: object  # normal of the edge of the other block that ends it there; (0, 0, 0) without one
    by_high: object


@leaf
def _cut(part, level, slope, edge):
    """Clip the interval to where level + slope s is positive; edge: outward normal of what sets the new end."""
    # a zero before which the function is negative
    if slope > 0.0:
        s = -level / slope
        return Interval(s, part.high, edge, part.by_high) if s > part.low else part
    # a zero behind which it is negative
    if slope < 0.0:
        s = -level / slope
        return Interval(part.low, s, part.by_low, edge) if s < part.high else part
    # a constant: the whole interval or nothing
    return part if level > 0.0 else Interval(1.0, -1.0, part.by_low, part.by_high)


# --- two drums


@leaf
def _beside_drum(sides, half_a, half_b):
    """Return the interval of the axis of the first drum that lies between the ends of both drums."""
    t0, c = dot(sides.between, sides.v), dot(sides.u, sides.v)
    part = Interval(-half_a, half_a, NOTHING, NOTHING)
    # perpendicular axes: all or nothing
    if abs(c) < ALONG:
        return part if abs(t0) < half_b else Interval(1.0, -1.0, NOTHING, NOTHING)
    # clip to both ends of the other drum
    part = _cut(part, half_b - t0, -c, sides.v)
    return _cut(part, half_b + t0, c, sides.v)


class _Axes(NamedTuple):
    """The vector across the axis of the other drum, from it to point s of the first axis: at + s along, m."""

    at: object
    along: object
    square: float  # along . along; at . along; at . at
    product: float
    level: float


@leaf
def _axes(sides):
    # components perpendicular to the other axis
    t0, c = dot(sides.between, sides.v), dot(sides.u, sides.v)
    at, along = plus(sides.between, sides.v, -t0), plus(sides.u, sides.v, -c)
    return _Axes(at, along, dot(along, along), dot(at, along), dot(at, at))


@leaf
def _nearer_than(axes, part, distance):
    """Return the sub-interval of the axis within `distance` (m) of the other axis."""
    beyond = axes.level - distance * distance
    # parallel axes: everywhere or nowhere
    if axes.square <= PARALLEL:
        return part if beyond < 0.0 else Interval(1.0, -1.0, part.by_low, part.by_high)
    # roots of the quadratic square s^2 + 2 product s + beyond
    found = axes.product * axes.product - axes.square * beyond
    if found <= 0.0:
        return Interval(1.0, -1.0, part.by_low, part.by_high)
    far = -(axes.product + math.copysign(math.sqrt(found), axes.product))
    one, other = far / axes.square, beyond / far
    low, high = min(one, other), max(one, other)
    # ends set by the distance are no edges
    by_low = NOTHING if low > part.low else part.by_low
    by_high = NOTHING if high < part.high else part.by_high
    return Interval(max(low, part.low), min(high, part.high), by_low, by_high)


@leaf
def _outwards(axes, s):
    """Return the unit vector and the distance (m) from the axis of the other drum to point s of the first axis."""
    w = plus(axes.at, axes.along, s)
    rho = math.sqrt(dot(w, w))
    return (w[0] / rho, w[1] / rho, w[2] / rho), rho


@leaf
def _push_ends(scene, sides, stiffness, part, at_low, at_high):
    """Add the forces of those ends of the loaded interval that the other block sets; return their sum, N.

    at_low, at_high: overlap at both ends, m.
    """
    total = NOTHING
    for way in (-1.0, 1.0):
        s, edge, delta = (part.low, part.by_low, at_low) if way < 0.0 else (part.high, part.by_high, at_high)
        energy, across = 0.5 * stiffness * delta * delta, dot(sides.u, edge)  # per length, J/m
        # an overlap at an edge that crosses the axis
        if delta > 0.0 and abs(across) >= ALONG:
            push_both(scene, sides, scaled(sides.u, s), scaled(edge, way * energy / across))
            total = plus(total, edge, way * energy / across)
    return total


@leaf
def load_drums(scene, phase, pairs, p, sides):
    """Add the normal forces of two drums; return their contact (`Touch`)."""
    k, eta, reach = pairs.stiffness[p], pairs.damping[p], pairs.radius_a[p] + pairs.radius_b[p]
    # the interval in which the drums overlap
    axes, c, t0 = _axes(sides), dot(sides.u, sides.v), dot(sides.between, sides.v)
    part = _nearer_than(axes, _beside_drum(sides, pairs.half_a[p], pairs.half_b[p]), reach + SLACK)
    total, first, energy, resultant = 0.0, 0.0, 0.0, NOTHING
    if part.high > part.low:
        # middle and half length for the quadrature
        middle, half = 0.5 * (part.high + part.low), 0.5 * (part.high - part.low)
        # relative velocity along the interval, linear in s
        on_a, on_b, along_b = sides.arm_a, plus(sides.arm_b, sides.v, t0), scaled(sides.v, c)
        moves = minus(velocity_of(scene, phase, sides.a, on_a), velocity_of(scene, phase, sides.b, on_b))
        turns = minus(cross(spin_of(scene, sides.a), sides.u), cross(spin_of(scene, sides.b), along_b))
        # integrate the force by Gauss and Legendre
        pushed, times_s = NOTHING, NOTHING  # integrals of the force, and of s times the force
        for g in range(len(NODES)):
            s = middle + half * NODES[g]
            n, rho = _outwards(axes, s)
            delta = reach - rho
            q = delta - eta * (dot(n, moves) + s * dot(n, turns))
            force = k * half * WEIGHTS[g] * max(q, 0.0)
            pushed, times_s = plus(pushed, n, force), plus(times_s, n, s * force)
            total, first = total + force, first + s * force
            energy += 0.5 * k * half * WEIGHTS[g] * max(delta, 0.0) ** 2
        # forces of the pressure, then of the ends
        push(scene.poses, sides.a, on_a, pushed, cross(sides.u, times_s), 1.0)
        push(scene.poses, sides.b, on_b, pushed, scaled(cross(along_b, times_s), -1.0), -1.0)
        at_low, at_high = reach - _outwards(axes, part.low)[1], reach - _outwards(axes, part.high)[1]
        resultant = plus(pushed, _push_ends(scene, sides, k, part, at_low, at_high), 1.0)
    # the centre of the pressure
    place = NOTHING
    if total > 0.0:
        s = first / total
        normal, rho = _outwards(axes, s)
        place = plus(scaled(sides.u, s), normal, 0.5 * (reach - rho) - pairs.radius_a[p])
    return Touch(total, energy, resultant if total > 0.0 else NOTHING, *arms_to(sides, place))


@leaf
def gap_of_drums(pairs, p, sides):
    """Return the distance of the sides of two drums, m, negative if they overlap; NaN if not beside each other."""
    axes, part = _axes(sides), _beside_drum(sides, pairs.half_a[p], pairs.half_b[p])
    low, high = part.low, part.high
    if low >= high:
        return math.nan
    # the point of the first axis nearest to the other one
    s = -axes.product / axes.square if axes.square > PARALLEL else 0.0
    s = min(max(s, low), high)
    return _outwards(axes, s)[1] - pairs.radius_a[p] - pairs.radius_b[p]


# --- a drum before a face


@leaf
def _before_face(scene, pairs, p, sides, part):
    """Clip the interval of the axis to the edges of the face."""
    # the axis in the plane of the face
    e1 = standing(scene.poses, sides.b, pairs.e1x[p], pairs.e1y[p], pairs.e1z[p])
    e2 = cross(sides.v, e1)
    x0, x1 = dot(sides.between, e1), dot(sides.u, e1)
    y0, y1 = dot(sides.between, e2), dot(sides.u, e2)
    # each edge clips it
    for k in range(int(pairs.corners[p])):
        ax, ay, dx, dy = edge_of(scene, pairs, p, k)
        edge = plus(scaled(e1, dy), e2, -dx)  # outward normal
        level, slope = dx * (y0 - ay) - dy * (x0 - ax), dx * y1 - dy * x1
        part = _cut(part, level, slope, edge)
    return part


class _Lowest(NamedTuple):
    """The generatrix of a drum nearest to a face: overlap at + along s, m, and its vector from the axis, m."""

    at: float
    along: float
    off: object


@leaf
def _lowest(sides, radius):
    # direction from the axis towards the face
    c = dot(sides.u, sides.v)
    sine = math.sqrt(max(1.0 - c * c, 0.0))
    off = NOTHING if sine < ALONG else scaled(plus(sides.v, sides.u, -c), -radius / sine)
    return _Lowest(radius * sine - dot(sides.between, sides.v), -c, off)


@leaf
def load_drum_before_face(scene, phase, pairs, p, sides):
    """Add the normal forces of a drum and a face; return their contact (`Touch`)."""
    k, eta, half, n = pairs.stiffness[p], pairs.damping[p], pairs.half_a[p], sides.v
    # the interval in which they overlap
    line = _lowest(sides, pairs.radius_a[p])
    total, energy, resultant, place = 0.0, 0.0, NOTHING, NOTHING
    part = Interval(-half, half, NOTHING, NOTHING)
    if line.at < pairs.radius_a[p] and line.at + abs(line.along) * half > -SLACK:
        part = _cut(_before_face(scene, pairs, p, sides, part), line.at + SLACK, line.along, NOTHING)
        if part.high > part.low:
            # damped overlap, linear in s
            on_a, on_b = arms_to(sides, line.off)
            rate = rate_along(scene, phase, sides, n, on_a, on_b)
            pace = rate_along(scene, phase, sides, n, plus(on_a, sides.u, 1.0), plus(on_b, sides.u, 1.0)) - rate
            at, along = line.at + eta * rate, line.along + eta * pace
            low, high = part.low, part.high
            # forces of the ends, and the energy
            d0, d1 = max(line.at + line.along * low, 0.0), max(line.at + line.along * high, 0.0)
            resultant = _push_ends(scene, sides, k, part, d0, d1)
            energy = k * (high - low) * (d0 * d0 + d0 * d1 + d1 * d1) / 6.0
            # force of the pressure, where the damped overlap is positive
            pressed = _cut(part, at, along, NOTHING)
            low, high = pressed.low, pressed.high
            if high > low:
                length, middle = high - low, 0.5 * (high + low)
                mean = at + along * middle
                total = k * length * mean
                first = total * middle + k * along * length * length * length / 12.0  # about the middle of the drum
                place = plus(line.off, sides.u, first / total)
                push_both(scene, sides, place, scaled(n, total))
                resultant = plus(resultant, n, total)
    return Touch(total, energy, resultant if total > 0.0 else NOTHING, *arms_to(sides, place))


@leaf
def gap_before_face(scene, pairs, p, sides):
    """Return the distance of the side of a drum from a face, m, negative if they overlap; NaN if not before it."""
    half, line = pairs.half_a[p], _lowest(sides, pairs.radius_a[p])
    part = _before_face(scene, pairs, p, sides, Interval(-half, half, NOTHING, NOTHING))
    if part.low >= part.high or line.at >= pairs.radius_a[p]:
        return math.nan
    return -max(line.at + line.along * part.low, line.at + line.along * part.high)
