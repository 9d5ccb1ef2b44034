"""Contact of two drums, and of a drum and a plane face (theory.md section 17).

Both sides overlap by delta(s), with s along the axis of the drum before a face, or along the bisector of both axes.
The force per length is stiffness times q = delta + damping d(delta)/dt where that is positive. The ends of the loaded
interval are in closed form; if an edge of the face or the end of a drum sets one, the energy changes as that end moves,
which is a force and a couple.
"""

import math
from typing import NamedTuple

from ..numba_ext.jit import leaf
from .kinematics import cross, dot, minus, plus, standing
from .sides import NOTHING, SLACK, Touch, arms_to, edge_of, push_both, rate_along, scaled, spin_of, velocity_of

PARALLEL = 1e-24  # squared sine of the angle below which axes are parallel
ALONG = 1e-9  # least cosine between the axis and the normal of an edge that ends a contact
NODES = (0.0, 0.5384693101056831, -0.5384693101056831, 0.906179845938664, -0.906179845938664)  # of Gauss-Legendre rule
WEIGHTS = (0.5688888888888889, 0.47862867049936647, 0.47862867049936647, 0.23692688505618908, 0.23692688505618908)


class Beside(NamedTuple):
    """An interval of s between two drums, m; empty if low > high."""

    low: float
    high: float
    end_low: float  # whose end limits it there: 1 for the first drum, -1 for the other one, 0 for neither
    end_high: float


class Before(NamedTuple):
    """An interval of s of a drum before a face, m; empty if low > high."""

    low: float
    high: float
    edge_low: object  # outward normal of the edge of the face that limits it there, (0, 0, 0) without one
    edge_high: object


# --- two drums


class _Axes(NamedTuple):
    """The axes of two drums, seen in planes across their bisector.

    A plane is at s - shift from the middle of the first axis, and at s + shift from that of the other one. There the
    vector from the other axis to the first one is w = at + s apart, m, and its component along the first axis, minus
    that along the other one, is lean + s leans.
    """

    u: object  # unit vectors of the first axis, and of the other one in the same sense
    v: object
    apart: object  # u - v
    more: float  # 1 + u . v
    shift: float  # m
    at: object
    lean: float
    leans: float
    level: float  # square of the distance where s = 0, m2


@leaf
def _axes(sides):
    # both axes in the same sense
    u = sides.u
    v = scaled(sides.v, math.copysign(1.0, dot(u, sides.v)))
    both, apart, more = plus(u, v, 1.0), minus(u, v), 1.0 + dot(u, v)
    # the plane in the middle between both, and the vector between the axes there
    shift = 0.5 * dot(sides.between, both) / more
    at = plus(sides.between, both, -shift)
    lean, leans = 0.5 * dot(apart, sides.between), 0.5 * dot(apart, apart)
    return _Axes(u, v, apart, more, shift, at, lean, leans, dot(at, at) - lean * lean)


@leaf
def _distance(axes, s):
    """Return the distance of the axes in plane s, m: the part of w that is perpendicular to an axis."""
    return math.sqrt(axes.level + axes.more * (2.0 * axes.lean + axes.leans * s) * s)


@leaf
def _across(axes, s):
    """Return w, its component along the first axis and the distance of the axes (m) in plane s."""
    return plus(axes.at, axes.apart, s), axes.lean + s * axes.leans, _distance(axes, s)


@leaf
def _plane_of_end(axes, half, radius, own, way):
    """Return the plane in which an end of a drum cuts the line of its side that is nearest to the other drum.

    half, radius: of the drum, m; own: 1 for the first drum, -1 for the other one; way: 1 or -1, along its axis.
    """
    s = way * half + own * axes.shift
    return s + radius * (axes.lean + s * axes.leans) / _distance(axes, s)


@leaf
def _beside_drum(axes, pairs, p):
    """Return the interval of planes between the ends of both drums; it has NaN where the axes meet."""
    low_a = _plane_of_end(axes, pairs.half_a[p], pairs.radius_a[p], 1.0, -1.0)
    low_b = _plane_of_end(axes, pairs.half_b[p], pairs.radius_b[p], -1.0, -1.0)
    high_a = _plane_of_end(axes, pairs.half_a[p], pairs.radius_a[p], 1.0, 1.0)
    high_b = _plane_of_end(axes, pairs.half_b[p], pairs.radius_b[p], -1.0, 1.0)
    end_low, end_high = 1.0 if low_a > low_b else -1.0, 1.0 if high_a < high_b else -1.0
    return Beside(max(low_a, low_b), min(high_a, high_b), end_low, end_high)


@leaf
def _nearer_than(axes, part, distance):
    """Return the sub-interval of planes in which the axes are within `distance` (m) of each other."""
    beyond = axes.level - distance * distance
    square, product = axes.more * axes.leans, axes.more * axes.lean
    # parallel axes: everywhere or nowhere
    if square <= PARALLEL:
        return part if beyond < 0.0 else Beside(1.0, -1.0, 0.0, 0.0)
    # roots of the quadratic square s^2 + 2 product s + beyond
    found = product * product - square * beyond
    if found <= 0.0:
        return Beside(1.0, -1.0, 0.0, 0.0)
    far = -(product + math.copysign(math.sqrt(found), product))
    one, other = far / square, beyond / far
    low, high = min(one, other), max(one, other)
    # limits set by the distance are no ends
    end_low = 0.0 if low > part.low else part.end_low
    end_high = 0.0 if high < part.high else part.end_high
    return Beside(max(low, part.low), min(high, part.high), end_low, end_high)


@leaf
def _push_ends_of_drums(scene, sides, axes, pairs, p, part):
    """Add the forces of the ends of the loaded interval that are ends of a drum; return their sum, N."""
    reach, total = pairs.radius_a[p] + pairs.radius_b[p], NOTHING
    for way in (-1.0, 1.0):
        s, own = (part.low, part.end_low) if way < 0.0 else (part.high, part.end_high)
        delta = reach - _distance(axes, s)
        # an overlap at the end of a drum
        if own != 0.0 and delta > 0.0:
            half, radius = (pairs.half_a[p], pairs.radius_a[p]) if own > 0.0 else (pairs.half_b[p], pairs.radius_b[p])
            # how the end moves: derivatives by the motion of the axes in the plane in which it cuts its own axis
            plane = way * half + own * axes.shift
            w, lean, rho = _across(axes, plane)
            slope = lean / rho
            by_height = 0.5 * own * (1.0 + radius * (axes.leans - axes.more * slope * slope) / rho) / axes.more
            by_slope = 0.5 * radius * (1.0 + slope * slope) / rho
            moves = plus(scaled(plus(axes.u, axes.v, 1.0), by_height), axes.apart, by_slope)
            moves = plus(moves, w, -radius * slope / (rho * rho))
            # the change of the energy
            by = -0.5 * way * pairs.stiffness[p] * delta * delta
            couple = scaled(cross(axes.u, w), by * (by_height + by_slope))
            push_both(scene, sides, scaled(axes.u, plane - axes.shift), scaled(moves, by), couple)
            total = plus(total, moves, by)
    return total


@leaf
def load_drums(scene, phase, pairs, p, sides):
    """Add the normal forces of two drums; return their contact (`Touch`)."""
    k, eta, reach = pairs.stiffness[p], pairs.damping[p], pairs.radius_a[p] + pairs.radius_b[p]
    # the interval in which the drums overlap
    axes = _axes(sides)
    part = _nearer_than(axes, _beside_drum(axes, pairs, p), reach + SLACK)
    total, first, energy, resultant = 0.0, 0.0, 0.0, NOTHING
    if part.high > part.low:
        # middle and half length for the quadrature
        middle, half = 0.5 * (part.high + part.low), 0.5 * (part.high - part.low)
        # relative velocity of the axes along the interval, linear in s
        start = scaled(axes.u, -axes.shift)  # the first axis where s = 0
        on_a, on_b = plus(sides.arm_a, start, 1.0), plus(sides.arm_b, axes.v, axes.shift)
        moves = minus(velocity_of(scene, phase, sides.a, on_a), velocity_of(scene, phase, sides.b, on_b))
        turns = minus(cross(spin_of(scene, sides.a), axes.u), cross(spin_of(scene, sides.b), axes.v))
        # integrate the force by Gauss and Legendre; the last two sums give the couple
        pushed, times_s, times_lean = NOTHING, NOTHING, NOTHING
        for g in range(len(NODES)):
            s = middle + half * NODES[g]
            w, lean, rho = _across(axes, s)
            outwards = plus(w, axes.apart, -0.5 * lean)
            rate = (dot(outwards, moves) + s * dot(outwards, turns) - 0.5 * lean * dot(w, turns)) / rho
            delta = reach - rho
            force = k * half * WEIGHTS[g] * max(delta - eta * rate, 0.0)
            pushed, times_s = plus(pushed, outwards, force / rho), plus(times_s, outwards, s * force / rho)
            times_lean = plus(times_lean, w, lean * force / rho)
            total, first = total + force, first + s * force
            energy += 0.5 * k * half * WEIGHTS[g] * max(delta, 0.0) ** 2
        # forces of the pressure, then of the ends
        push_both(scene, sides, start, pushed, cross(axes.u, plus(times_s, times_lean, -0.5)))
        resultant = plus(pushed, _push_ends_of_drums(scene, sides, axes, pairs, p, part), 1.0)
    # the centre of the pressure, in the middle of the overlap
    place = NOTHING
    if total > 0.0:
        s = first / total
        w, _, rho = _across(axes, s)
        place = plus(scaled(axes.u, s - axes.shift), w, (0.5 * (reach - rho) - pairs.radius_a[p]) / rho)
    return Touch(total, energy, resultant if total > 0.0 else NOTHING, *arms_to(sides, place))


@leaf
def gap_of_drums(pairs, p, sides):
    """Return the distance of the sides of two drums, m, negative if they overlap; NaN if not beside each other."""
    axes = _axes(sides)
    part = _beside_drum(axes, pairs, p)
    if not part.low < part.high:
        return math.nan
    # the plane in which the axes are nearest to each other
    s = -axes.lean / axes.leans if axes.leans > PARALLEL else 0.0
    s = min(max(s, part.low), part.high)
    return _distance(axes, s) - pairs.radius_a[p] - pairs.radius_b[p]


# --- a drum before a face


@leaf
def _cut(part, level, slope, edge):
    """Clip the interval to where level + slope s is positive; edge: outward normal of what sets the new end."""
    # a zero before which the function is negative
    if slope > 0.0:
        s = -level / slope
        return Before(s, part.high, edge, part.edge_high) if s > part.low else part
    # a zero behind which it is negative
    if slope < 0.0:
        s = -level / slope
        return Before(part.low, s, part.edge_low, edge) if s < part.high else part
    # a constant: the whole interval or nothing
    return part if level > 0.0 else Before(1.0, -1.0, NOTHING, NOTHING)


@leaf
def _before_face(scene, pairs, p, sides, line):
    """Return the interval in which the generatrix nearest to the face lies between the edges of the face."""
    part = Before(-pairs.half_a[p], pairs.half_a[p], NOTHING, NOTHING)
    # the generatrix in the plane of the face
    e1 = standing(scene.poses, sides.b, pairs.e1x[p], pairs.e1y[p], pairs.e1z[p])
    e2, start = cross(sides.v, e1), plus(sides.between, line.off, 1.0)
    x0, x1 = dot(start, e1), dot(sides.u, e1)
    y0, y1 = dot(start, e2), dot(sides.u, e2)
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
def _push_edges(scene, sides, stiffness, part, off, at_low, at_high):
    """Add the forces of those ends of the loaded interval that edges of the face set; return their sum, N.

    off: from the axis of the drum to its generatrix, m; at_low, at_high: overlap at both ends, m.
    """
    total, c, radius = NOTHING, dot(sides.u, sides.v), max(math.sqrt(dot(off, off)), SLACK)
    side = cross(off, sides.u)  # along the face and across the generatrix, as long as the radius
    tilt = c / (radius * max(math.sqrt(max(1.0 - c * c, 0.0)), ALONG))
    for way in (-1.0, 1.0):
        s, edge, delta = (part.low, part.edge_low, at_low) if way < 0.0 else (part.high, part.edge_high, at_high)
        energy, across = 0.5 * stiffness * delta * delta, dot(sides.u, edge)  # per length, J/m
        # an overlap at an edge that crosses the generatrix
        if delta > 0.0 and abs(across) >= ALONG:
            by = way * energy / across
            # as the drum turns, another generatrix is nearest; about its own axis nothing turns it
            couple = plus(scaled(side, across), off, tilt * dot(edge, side))
            push_both(scene, sides, scaled(sides.u, s), scaled(edge, by), scaled(couple, by))
            total = plus(total, edge, by)
    return total


@leaf
def load_drum_before_face(scene, phase, pairs, p, sides):
    """Add the normal forces of a drum and a face; return their contact (`Touch`)."""
    k, eta, half, n = pairs.stiffness[p], pairs.damping[p], pairs.half_a[p], sides.v
    # the interval in which they overlap
    line = _lowest(sides, pairs.radius_a[p])
    total, energy, resultant, place = 0.0, 0.0, NOTHING, NOTHING
    if line.at < pairs.radius_a[p] and line.at + abs(line.along) * half > -SLACK:
        part = _cut(_before_face(scene, pairs, p, sides, line), line.at + SLACK, line.along, NOTHING)
        if part.high > part.low:
            # damped overlap, linear in s
            on_a, on_b = arms_to(sides, line.off)
            rate = rate_along(scene, phase, sides, n, on_a, on_b)
            pace = rate_along(scene, phase, sides, n, plus(on_a, sides.u, 1.0), plus(on_b, sides.u, 1.0)) - rate
            at, along = line.at + eta * rate, line.along + eta * pace
            low, high = part.low, part.high
            # forces of the ends, and the energy
            d0, d1 = max(line.at + line.along * low, 0.0), max(line.at + line.along * high, 0.0)
            resultant = _push_edges(scene, sides, k, part, line.off, d0, d1)
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
                push_both(scene, sides, place, scaled(n, total), NOTHING)
                resultant = plus(resultant, n, total)
    return Touch(total, energy, resultant if total > 0.0 else NOTHING, *arms_to(sides, place))


@leaf
def gap_before_face(scene, pairs, p, sides):
    """Return the distance of the side of a drum from a face, m, negative if they overlap; NaN if not before it."""
    line = _lowest(sides, pairs.radius_a[p])
    part = _before_face(scene, pairs, p, sides, line)
    if part.low >= part.high or line.at >= pairs.radius_a[p]:
        return math.nan
    return -max(line.at + line.along * part.low, line.at + line.along * part.high)
