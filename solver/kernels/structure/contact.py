"""Contact of blocks that stand beside each other: a drum beside a drum, a drum before a plane face (theory.md 14).

Along the axis of the first drum, s from its middle, both sides overlap by delta(s). The force per length is stiffness
times q = delta + damping d(delta)/dt where that is positive. Its ends are in closed form; where the end of the other
drum, or an edge of the face, sets one, the energy changes as that end moves, which is a force there. Forces act on both
blocks at one place, so that momentum is kept. Along the contact a slider in series with a spring and a dashpot bears
what friction does, in the middle of the loaded part.

A pair touches or not from one end of a step to the next: a step ends where a gap closes (stepping.py), so that the
damping of an impact, which begins at once, leaves steps smooth. Nothing is evaluated of a pair that is apart.
"""

import math
from typing import NamedTuple

from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import LanesType, zero_like
from .kinematics import cross, dot, minus, plus, push, turned
from .layout import DRUMS, MEMORY, STRETCH

_stretch, _PER_JOINT = STRETCH.over, MEMORY.per_n

SLACK = 1e-9  # m: a pair lets go beyond this gap, and touches within half of it
PARALLEL = 1e-24  # square of the sine of the angle between axes that are taken as parallel
ALONG = 1e-9  # cosine of the angle to an axis from which on an edge across it ends a contact
NODES = (0.0, 0.5384693101056831, -0.5384693101056831, 0.906179845938664, -0.906179845938664)  # of Gauss and Legendre
WEIGHTS = (0.5688888888888889, 0.47862867049936647, 0.47862867049936647, 0.23692688505618908, 0.23692688505618908)


class Sides(NamedTuple):
    """Both sides of a pair as they are: directions along the axes of the base, lengths in m."""

    a: int  # bodies
    b: int
    arm_a: object  # from their centroids to the middle of the axis of the first drum, and to
    arm_b: object  # that of the other one, or the middle of the face
    between: object  # from the latter to the former
    u: object  # axis of the first drum
    v: object  # axis of the other one, or the normal of the face, towards the drum


class Part(NamedTuple):
    """A part of the axis of the first drum."""

    low: float
    high: float
    by_low: object  # what ends it there: a direction across which the other block ends; (0, 0, 0): something else
    by_high: object


class Touch(NamedTuple):
    """What a pair bears across, and where, for friction."""

    force: float  # N
    s: float  # m, middle of the loaded part
    energy: float  # J


@leaf
def _directed(scene, i, x, y, z):
    """A direction that is fixed to body i, along the axes of the base."""
    return plus((x, y, z), turned(scene.poses, i, x, y, z), 1.0)


@leaf
def _place(scene, phase, i):
    """Place of the centroid of body i, m."""
    bodies = scene.bodies
    if i == scene.n:
        return bodies.x[i], bodies.y[i], bodies.z[i]
    return bodies.x[i] + phase.ux[i], bodies.y[i] + phase.uy[i], bodies.z[i] + phase.uz[i]


@leaf
def _sides(scene, phase, pairs, p):
    a, b = int(pairs.one[p]), int(pairs.other[p])
    arm_a = _directed(scene, a, pairs.ax[p], pairs.ay[p], pairs.az[p])
    arm_b = _directed(scene, b, pairs.bx[p], pairs.by[p], pairs.bz[p])
    between = minus(plus(_place(scene, phase, a), arm_a, 1.0), plus(_place(scene, phase, b), arm_b, 1.0))
    u = _directed(scene, a, pairs.ux[p], pairs.uy[p], pairs.uz[p])
    v = _directed(scene, b, pairs.vx[p], pairs.vy[p], pairs.vz[p])
    return Sides(a, b, arm_a, arm_b, between, u, v)


_NOTHING = (0.0, 0.0, 0.0)


@leaf
def _cut(part, level, slope, edge):
    """The part where level + slope s is positive; edge: outwards across what ends it there."""
    if slope > 0.0:
        s = -level / slope
        return Part(s, part.high, edge, part.by_high) if s > part.low else part
    if slope < 0.0:
        s = -level / slope
        return Part(part.low, s, part.by_low, edge) if s < part.high else part
    return part if level > 0.0 else Part(1.0, -1.0, part.by_low, part.by_high)


# --- two drums


@leaf
def _beside_drum(sides, half_a, half_b):
    """The part of the axis of the first drum that lies between the ends of both."""
    t0, c = dot(sides.between, sides.v), dot(sides.u, sides.v)
    part = Part(-half_a, half_a, _NOTHING, _NOTHING)
    if abs(c) < ALONG:
        return part if abs(t0) < half_b else Part(1.0, -1.0, _NOTHING, _NOTHING)
    part = _cut(part, half_b - t0, -c, sides.v)
    return _cut(part, half_b + t0, c, sides.v)


class _Axes(NamedTuple):
    """From the axis of the other drum, across it, to a point of that of the first one: at + s along."""

    at: object
    along: object
    square: float  # of along, and so forth
    product: float
    level: float


@leaf
def _axes(sides):
    t0, c = dot(sides.between, sides.v), dot(sides.u, sides.v)
    at, along = plus(sides.between, sides.v, -t0), plus(sides.u, sides.v, -c)
    return _Axes(at, along, dot(along, along), dot(at, along), dot(at, at))


@leaf
def _nearer_than(axes, part, distance):
    """What of a part of the axis is nearer to the other one than that, m."""
    beyond = axes.level - distance * distance
    if axes.square <= PARALLEL:
        return part if beyond < 0.0 else Part(1.0, -1.0, part.by_low, part.by_high)
    found = axes.product * axes.product - axes.square * beyond
    if found <= 0.0:
        return Part(1.0, -1.0, part.by_low, part.by_high)
    far = -(axes.product + math.copysign(math.sqrt(found), axes.product))
    one, other = far / axes.square, beyond / far
    low, high = min(one, other), max(one, other)
    by_low = _NOTHING if low > part.low else part.by_low
    by_high = _NOTHING if high < part.high else part.by_high
    return Part(max(low, part.low), min(high, part.high), by_low, by_high)


@leaf
def _outwards(axes, s):
    """Unit vector and distance, m, from the axis of the other drum to place s of that of the first one."""
    w = plus(axes.at, axes.along, s)
    rho = math.sqrt(dot(w, w))
    return (w[0] / rho, w[1] / rho, w[2] / rho), rho


@leaf
def _rate_along(scene, phase, sides, n, on_a, on_b):
    """Rate, m/s, at which the ends of two arms from the centroids of both bodies approach each other along n."""
    return -dot(n, minus(_velocity(scene, phase, sides.a, on_a), _velocity(scene, phase, sides.b, on_b)))


@leaf
def _velocity(scene, phase, i, arm):
    """Velocity, m/s, of the end of an arm from the centroid of body i."""
    if i == scene.n:
        return _NOTHING
    spin = scene.poses.wx[i], scene.poses.wy[i], scene.poses.wz[i]
    return plus((phase.vx[i], phase.vy[i], phase.vz[i]), cross(spin, arm), 1.0)


@leaf
def _push_both(scene, sides, place, force):
    """Add a force, N, on the first body, and its opposite on the other one, at a place from the middle of its axis."""
    on_a = plus(sides.arm_a, place, 1.0)
    on_b = plus(plus(sides.arm_b, sides.between, 1.0), place, 1.0)
    push(scene.poses, sides.a, on_a, force, _NOTHING, 1.0)
    push(scene.poses, sides.b, on_b, force, _NOTHING, -1.0)


@leaf
def _scaled(a, factor):
    return a[0] * factor, a[1] * factor, a[2] * factor


@leaf
def _push_end(scene, sides, s, edge, energy, way):
    """The force of an end of the loaded part that the other block sets; energy: per length there, J/m."""
    across = dot(sides.u, edge)
    if energy > 0.0 and abs(across) >= ALONG:
        _push_both(scene, sides, _scaled(sides.u, s), _scaled(edge, way * energy / across))


@leaf
def _load_drums(scene, phase, pairs, p, sides):
    """Add the forces across of two drums."""
    k, eta, reach = pairs.stiffness[p], pairs.damping[p], pairs.radius_a[p] + pairs.radius_b[p]
    axes, c, t0 = _axes(sides), dot(sides.u, sides.v), dot(sides.between, sides.v)
    part = _nearer_than(axes, _beside_drum(sides, pairs.half_a[p], pairs.half_b[p]), reach + SLACK)
    total, first, energy = 0.0, 0.0, 0.0
    if part.high > part.low:
        middle, half = 0.5 * (part.high + part.low), 0.5 * (part.high - part.low)
        for g in range(len(NODES)):
            s = middle + half * NODES[g]
            n, rho = _outwards(axes, s)
            delta = reach - rho
            on_a = plus(sides.arm_a, sides.u, s)
            on_b = plus(sides.arm_b, sides.v, t0 + s * c)
            q = delta + eta * _rate_along(scene, phase, sides, n, on_a, on_b)
            force = k * half * WEIGHTS[g] * max(q, 0.0)
            push(scene.poses, sides.a, on_a, _scaled(n, force), _NOTHING, 1.0)
            push(scene.poses, sides.b, on_b, _scaled(n, force), _NOTHING, -1.0)
            total, first = total + force, first + s * force
            energy += 0.5 * k * half * WEIGHTS[g] * max(delta, 0.0) ** 2
        for way in (-1.0, 1.0):
            s = part.low if way < 0.0 else part.high
            n, rho = _outwards(axes, s)
            delta = max(reach - rho, 0.0)
            _push_end(scene, sides, s, part.by_low if way < 0.0 else part.by_high, 0.5 * k * delta * delta, way)
    return Touch(total, first / total if total > 0.0 else 0.0, energy)


# --- a drum before a face


@leaf
def _before_face(scene, pairs, p, sides, part):
    """What of a part of the axis lies within the edges of the face."""
    e1 = _directed(scene, sides.b, pairs.e1x[p], pairs.e1y[p], pairs.e1z[p])
    e2 = cross(sides.v, e1)
    x0, x1 = dot(sides.between, e1), dot(sides.u, e1)
    y0, y1 = dot(sides.between, e2), dot(sides.u, e2)
    first, count = int(pairs.first[p]), int(pairs.corners[p])
    corners = scene.corners
    for k in range(count):
        after = k + 1 if k + 1 < count else 0
        ax, ay = corners[first + 2 * k], corners[first + 2 * k + 1]
        dx, dy = corners[first + 2 * after] - ax, corners[first + 2 * after + 1] - ay
        edge = plus(_scaled(e1, dy), e2, -dx)  # outwards
        level, slope = dx * (y0 - ay) - dy * (x0 - ax), dx * y1 - dy * x1
        part = _cut(part, level, slope, edge)
    return part


class _Lowest(NamedTuple):
    """The line of a drum that is nearest to a face: its overlap at + along s, and where it is from the axis, m."""

    at: float
    along: float
    off: object


@leaf
def _lowest(sides, radius):
    c = dot(sides.u, sides.v)
    sine = math.sqrt(max(1.0 - c * c, 0.0))
    off = _NOTHING if sine < ALONG else _scaled(plus(sides.v, sides.u, -c), -radius / sine)
    return _Lowest(radius * sine - dot(sides.between, sides.v), -c, off)


@leaf
def _load_face(scene, phase, pairs, p, sides):
    """Add the forces across of a drum before a face."""
    k, eta, half, n = pairs.stiffness[p], pairs.damping[p], pairs.half_a[p], sides.v
    line = _lowest(sides, pairs.radius_a[p])
    total, first, energy = 0.0, 0.0, 0.0
    part = Part(-half, half, _NOTHING, _NOTHING)
    if line.at < pairs.radius_a[p] and line.at + abs(line.along) * half > -SLACK:
        part = _cut(_before_face(scene, pairs, p, sides, part), line.at + SLACK, line.along, _NOTHING)
        if part.high > part.low:
            on_a = plus(sides.arm_a, line.off, 1.0)
            on_b = plus(plus(sides.arm_b, sides.between, 1.0), line.off, 1.0)
            rate = _rate_along(scene, phase, sides, n, on_a, on_b)
            pace = _rate_along(scene, phase, sides, n, plus(on_a, sides.u, 1.0), plus(on_b, sides.u, 1.0)) - rate
            at, along = line.at + eta * rate, line.along + eta * pace
            low, high = part.low, part.high
            for way in (-1.0, 1.0):
                s = low if way < 0.0 else high
                delta = max(line.at + line.along * s, 0.0)
                _push_end(scene, sides, s, part.by_low if way < 0.0 else part.by_high, 0.5 * k * delta * delta, way)
            d0, d1 = max(line.at + line.along * low, 0.0), max(line.at + line.along * high, 0.0)
            energy = k * (high - low) * (d0 * d0 + d0 * d1 + d1 * d1) / 6.0
            pressed = _cut(part, at, along, _NOTHING)
            low, high = pressed.low, pressed.high
            if high > low:
                length, middle = high - low, 0.5 * (high + low)
                mean = at + along * middle
                total = k * length * mean
                first = total * middle + k * along * length * length * length / 12.0
                place = plus(line.off, sides.u, first / total)
                _push_both(scene, sides, place, _scaled(n, total))
    return Touch(total, first / total if total > 0.0 else 0.0, energy)


# --- a pair


@leaf
def _contact_point(pairs, p, sides, s):
    """Normal towards the first body, and place from the middle of its axis, m, half-way through the overlap at s."""
    if pairs.kind[p] == DRUMS:
        n, rho = _outwards(_axes(sides), s)
        overlap = pairs.radius_a[p] + pairs.radius_b[p] - rho
        return n, plus(_scaled(sides.u, s), n, 0.5 * overlap - pairs.radius_a[p])
    line = _lowest(sides, pairs.radius_a[p])
    return sides.v, plus(line.off, sides.u, s)


@leaf
def _rub(scene, phase, extras, p, sides, touch):
    """Add the force of friction; the rates of what it stretches by are left in the scene."""
    pairs, stretch, giving = extras.pairs, extras.stretches, extras.giving_stretches
    n, place = _contact_point(pairs, p, sides, touch.s)
    on_a = plus(sides.arm_a, place, 1.0)
    on_b = plus(plus(sides.arm_b, sides.between, 1.0), place, 1.0)
    v = minus(_velocity(scene, phase, sides.a, on_a), _velocity(scene, phase, sides.b, on_b))
    v = plus(v, n, -dot(v, n))
    z = stretch.z1[p], stretch.z2[p], stretch.z3[p]
    z = plus(z, n, -dot(z, n))
    lag, limit = pairs.shear_damping[p], pairs.friction[p] * touch.force
    force = _scaled(plus(z, v, lag), -pairs.shear[p])
    size = math.sqrt(dot(force, force))
    if size > limit:
        part = limit / size
        v = plus(v, plus(_scaled(z, 1.0 / lag), v, 1.0), part - 1.0)
        force = _scaled(force, part)
        extras.hits.slides[p] = 1.0
    giving.z1[p], giving.z2[p], giving.z3[p] = v
    extras.hits.along[p] = min(size, limit)
    _push_both(scene, sides, place, force)


@kernel
def load_pair(scene, phase, extras, p):
    """Add the forces of a pair that touches to those on its two blocks."""
    hits, giving, pairs = extras.hits, extras.giving_stretches, extras.pairs
    hits.force[p], hits.along[p], hits.energy[p], hits.slides[p] = 0.0, 0.0, 0.0, 0.0
    giving.z1[p], giving.z2[p], giving.z3[p] = 0.0, 0.0, 0.0
    if extras.stretches.touches[p] == 0.0:
        return
    sides = _sides(scene, phase, pairs, p)
    if pairs.kind[p] == DRUMS:
        touch = _load_drums(scene, phase, pairs, p, sides)
    else:
        touch = _load_face(scene, phase, pairs, p, sides)
    hits.force[p], hits.energy[p] = touch.force, touch.energy
    if pairs.friction[p] > 0.0:
        _rub(scene, phase, extras, p, sides, touch)


@by_width
def load_pairs(scene, phase, like):
    """Add the forces of all pairs that touch; like: a number of the scene. Lanes have none."""
    return _nothing_on if isinstance(like, LanesType) else _load_on


def _nothing_on(scene, phase, like):
    return


def _load_on(scene, phase, like):
    for p in range(scene.extras.met):
        load_pair(scene, phase, scene.extras, p)


@by_width
def error_of_pairs(scene, errors, like):
    """Largest error, m, of what pairs are stretched by; like: a number of the scene."""
    return _no_error if isinstance(like, LanesType) else _largest_error


def _no_error(scene, errors, like):
    return zero_like(like)


def _largest_error(scene, errors, like):
    z, largest = _stretch(errors[_PER_JOINT * scene.m + scene.k :], scene.extras.met), 0.0
    for p in range(scene.extras.met):
        largest = max(largest, abs(z.z1[p]) + abs(z.z2[p]) + abs(z.z3[p]))
    return largest


@kernel
def pairs_energy(scene):
    """Elastic energy of all pairs, J, of the last evaluation."""
    z, pairs, total = scene.extras.stretches, scene.extras.pairs, 0.0
    for p in range(scene.extras.met):
        square = z.z1[p] * z.z1[p] + z.z2[p] * z.z2[p] + z.z3[p] * z.z3[p]
        total += scene.extras.hits.energy[p] + 0.5 * pairs.shear[p] * square
    return total


# --- gaps


@kernel
def gap_of(scene, phase, pairs, p):
    """Distance of both sides of pair p, m, below 0 by the deepest overlap; beside their ends that of these."""
    sides = _sides(scene, phase, pairs, p)
    half = pairs.half_a[p]
    if pairs.kind[p] == DRUMS:
        part, axes = _beside_drum(sides, half, pairs.half_b[p]), _axes(sides)
        low, high = max(min(part.low, half), -half), min(max(part.high, -half), half)
        beside = max(low - high, 0.0) * abs(dot(sides.u, sides.v))
        s = -axes.product / axes.square if axes.square > PARALLEL else 0.0
        s = min(max(s, min(low, high)), max(low, high))
        gap = _outwards(axes, s)[1] - pairs.radius_a[p] - pairs.radius_b[p]
    else:
        line = _lowest(sides, pairs.radius_a[p])
        part = _before_face(scene, pairs, p, sides, Part(-half, half, _NOTHING, _NOTHING))
        low, high = max(min(part.low, half), -half), min(max(part.high, -half), half)
        beside = max(part.low - part.high, 0.0)
        gap = -max(line.at + line.along * low, line.at + line.along * high)
    return gap if beside == 0.0 else math.sqrt(beside * beside + max(gap, 0.0) ** 2)


@leaf
def is_near(scene, phase, pairs, p):
    """Whether the spheres about both blocks of a pair overlap."""
    between = minus(_place(scene, phase, int(pairs.one[p])), _place(scene, phase, int(pairs.other[p])))
    return dot(between, between) < pairs.reach[p] * pairs.reach[p]
