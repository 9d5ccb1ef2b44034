"""The bed of a disc or ring: a disc cut by two chords that need not be parallel, in closed form.

Two half-planes leave of a disc a polygon between points of its rim, and a circular segment (engine/circle.py) beyond
each of its sides that joins the ends of an arc. The second moment of a segment along its chord is that of theory.md
section 10 across: R^4 times the integral 2/3 sin^4.
"""

import math
from typing import NamedTuple

from ..engine.circle import SMALL, TERMS, circle_part
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, greater, lesser, magnitude, opposite, square_root, where
from ..numba_ext.numbers import angle_of
from .bed import Bed, add, chosen, nothing, triangle, value, whole

# 2/3 of the integral of sin^4 over sin^5, in powers of sin^2, the highest first: 1 / cos = sum of these times sin^2k
ACROSS = tuple(2.0 / 3.0 * math.comb(2 * k, k) / 4**k / (5 + 2 * k) for k in range(TERMS))[::-1]
SHORT = 1e-9  # chord of an arc without a segment, over the radius; that of nearly a whole disc is longer than 1e-8
PARALLEL = 1e-14  # sine of the angle below which two chords are parallel


@leaf
def _across(sine, cosine):
    """Return 2/3 of the integral of sin^4 from 0 to the angle with this sine and cosine, 0 to pi."""
    square = sine * sine
    # the angle, from 0 to pi
    angle = angle_of(sine, magnitude(cosine))
    angle = where(cosine >= 0.0, angle, math.pi - angle)
    # closed form
    closed = 0.25 * (angle - sine * cosine) - sine * cosine * square / 6.0
    small = (sine < SMALL) & (cosine > 0.0)
    # series for small angles
    if any_of(small):
        total = 0.0 * square
        for coefficient in ACROSS:
            total = total * square + coefficient
        closed = where(small, total * square * square * sine, closed)
    return closed


@kernel
def with_segment(bed, there, radius, q, out_x, out_y, cut):
    """Add to a bed the circular segment beyond a chord, where `there` holds.

    Parameters
    ----------
    radius : float or lanes
        Radius of the disc about the origin, m.
    q : Plane
        Damped penetration, m.
    out_x, out_y : float or lanes
        Unit normal of the chord, away from the centre if `cut` is positive.
    cut : float or lanes
        Distance of the chord from the centre along the normal, m.
    """
    # moments of the segment across and along its chord
    about, area, first, second = circle_part(radius, cut, radius)
    half = square_root(greater((radius - cut) * (radius + cut), 0.0))
    across = _across(half / radius, cut / radius) * (radius * radius) * (radius * radius)
    # q in the frame of the chord
    rise = q.along_x * out_x + q.along_y * out_y
    slope = q.along_y * out_x - q.along_x * out_y
    # integrals of q, and of q times both coordinates
    middle = q.at + rise * about
    force = middle * area + rise * first
    outwards = about * force + (middle * first + rise * second)
    along = slope * across
    return add(bed, there, area, force, outwards * out_x - along * out_y, outwards * out_y + along * out_x)


@leaf
def with_triangle(bed, there, q, a, b, c):
    """Add to a bed the triangle of three points where `there` holds; the largest q is left to the caller."""
    values = value(q, a[0], a[1]), value(q, b[0], b[1]), value(q, c[0], c[1])
    area, force, first_x, first_y = triangle((a[0], b[0], c[0]), (a[1], b[1], c[1]), values)
    return add(bed, there, area, force, first_x, first_y)


class _Chord(NamedTuple):
    """The chord on which a function vanishes in the disc: normal to the positive side, distance, both ends.

    The positive side lies to the left of the direction from `begin` to `end`.
    """

    x: object
    y: object
    off: object
    begin: object
    end: object


@leaf
def _chord(radius, slope, plane):
    """Return the chord of the linear function `plane` in a disc; slope: its gradient's norm, not 0."""
    # unit normal and distance from the centre
    nx, ny = plane.along_x / slope, plane.along_y / slope
    off = -plane.at / slope
    # half the length of the chord
    half = square_root(greater((radius - off) * (radius + off), 0.0))
    return _Chord(
        nx, ny, off, (off * nx - half * ny, off * ny + half * nx), (off * nx + half * ny, off * ny - half * nx)
    )


@leaf
def _point(condition, a, b):
    return where(condition, a[0], b[0]), where(condition, a[1], b[1])


@leaf
def _with_arc(bed, there, radius, q, own, begins, ends):
    """Add to a bed the segment of an arc that starts at the end of chord `own`, anticlockwise.

    The arc ends at the start of the same chord where `begins` holds, else at `ends`, the start of the other chord.
    """
    out_x, out_y, cut = own.x, own.y, own.off
    # the chord of an arc to the other chord
    further = there & opposite(begins)
    if any_of(further):
        dx, dy = ends[0] - own.end[0], ends[1] - own.end[1]
        length = square_root(dx * dx + dy * dy)
        there = there & (begins | (length > SHORT * radius))
        out_x, out_y = where(begins, out_x, dy / length), where(begins, out_y, -dx / length)
        middle = 0.5 * ((own.end[0] + ends[0]) * out_x + (own.end[1] + ends[1]) * out_y)
        cut = lesser(where(begins, cut, middle), radius)
    return with_segment(bed, there, radius, q, out_x, out_y, cut)


@kernel
def _cut_disc(radius, p, q, slope_p, slope_q, some, cuts_p, cuts_q):
    """Return the bed of the part of a disc, cut by p, q or both, where both are positive.

    The part is bounded by arcs that start at the ends of the chords, and by the chords: both whole if they do not meet
    and leave a strip, else from where they meet. some: mask of where there is such a part; cuts_p, cuts_q: of where p
    and q cut the disc.
    """
    # both chords
    of_p, of_q = _chord(radius, slope_p, p), _chord(radius, slope_q, q)
    turn = of_p.x * of_q.y - of_p.y * of_q.x  # sine of the angle between the chords
    both = cuts_p & cuts_q
    # parallel ones that cut the same side away: the farther one counts
    parallel = both & (magnitude(turn) <= PARALLEL) & (of_p.x * of_q.x + of_p.y * of_q.y > 0.0)
    outer_p = of_p.off > of_q.off
    cuts_p, cuts_q = cuts_p & opposite(parallel & opposite(outer_p)), cuts_q & opposite(parallel & outer_p)
    alone_p, alone_q = some & cuts_p & opposite(cuts_q), some & cuts_q & opposite(cuts_p)
    both = some & cuts_p & cuts_q
    # ends of either chord on the positive side of the other function
    begins_p = alone_p | (both & (value(q, of_p.begin[0], of_p.begin[1]) > 0.0))
    ends_p = alone_p | (both & (value(q, of_p.end[0], of_p.end[1]) > 0.0))
    begins_q = alone_q | (both & (value(p, of_q.begin[0], of_q.begin[1]) > 0.0))
    ends_q = alone_q | (both & (value(p, of_q.end[0], of_q.end[1]) > 0.0))
    bed = nothing(p)
    # circular segments beyond the arcs
    if any_of(ends_p):
        bed = _with_arc(bed, ends_p, radius, q, of_p, begins_p & opposite(begins_q), of_q.begin)
    if any_of(ends_q):
        bed = _with_arc(bed, ends_q, radius, q, of_q, begins_q & opposite(begins_p), of_p.begin)
    # the polygon between the chords
    strip = begins_p & ends_p & begins_q & ends_q
    meet = (begins_p & opposite(ends_p)) | (ends_p & opposite(begins_p))
    if any_of(strip | meet):
        # the intersection of the chords
        x, y = (of_p.off * of_q.y - of_q.off * of_p.y) / turn, (of_q.off * of_p.x - of_p.off * of_q.x) / turn
        apex = _point(strip, of_p.begin, (x, y))
        first, second = _point(ends_p, of_p.end, of_q.end), _point(ends_p, of_q.begin, of_p.begin)
        bed = with_triangle(bed, strip | meet, q, apex, first, second)
        if any_of(strip):
            bed = with_triangle(bed, strip, q, of_p.begin, of_q.begin, of_q.end)
    return bed


@leaf
def whole_disc(radius, q):
    """Return the bed of a fully pressed disc about the origin; its largest q is left 0."""
    # second moment about a diameter
    area = math.pi * radius * radius
    second = 0.25 * area * radius * radius
    return Bed(q.at * area, q.along_x * second, q.along_y * second, area, 0.0 * area)


@kernel
def _disc(radius, p, q, slope_p, slope_q):
    """Return the bed of the part of a disc where p and q are positive."""
    # whether anything is pressed, and which function cuts
    some = (p.at + radius * slope_p > 0.0) & (q.at + radius * slope_q > 0.0)
    same = (p.along_x == q.along_x) & (p.along_y == q.along_y) & (p.at == q.at)
    cuts_p, cuts_q = p.at < radius * slope_p, (q.at < radius * slope_q) & opposite(same)
    # whole discs, then those that are cut
    bed = chosen(some, whole_disc(radius, q), nothing(p))
    cut = some & (cuts_p | cuts_q)
    if any_of(cut):
        bed = chosen(cut, _cut_disc(radius, p, q, slope_p, slope_q, some, cuts_p, cuts_q), bed)
    return bed


@leaf
def slope_of(plane):
    """Return the norm of the gradient of a linear function."""
    return square_root(plane.along_x * plane.along_x + plane.along_y * plane.along_y)


@kernel
def _highest(radius, p, q, slope_p, slope_q):
    """Return the largest q in the disc where p is not negative: at the rim, or where the chord of p meets the rim."""
    # at the rim, in the direction in which q rises
    top = q.at + radius * slope_q
    # the point of the rim with the largest q
    x, y = radius * q.along_x / slope_q, radius * q.along_y / slope_q
    below = (slope_q > 0.0) & (slope_p > 0.0) & (value(p, x, y) < 0.0)
    if any_of(below):
        of_p = _chord(radius, slope_p, p)
        ends = greater(value(q, of_p.end[0], of_p.end[1]), value(q, of_p.begin[0], of_p.begin[1]))
        top = where(below, ends, top)
    return top


@kernel
def round_bed(outer, inner, area, moments, p, q):
    """Return the bed of a disc or ring about the centre of its joint.

    Parameters
    ----------
    outer, inner : float or lanes
        Radii, m; inner is 0 of a disc.
    area : float or lanes
        Area, m2.
    moments : Moments
        Other integrals over the section.
    p, q : Plane
        Penetration and damped penetration, m.
    """
    # full contact; none where the faces only touch
    slope_p, slope_q = slope_of(p), slope_of(q)
    full = (p.at >= outer * slope_p) & (q.at >= outer * slope_q) & (p.at > 0.0) & (q.at > 0.0)
    bed = whole(area, moments, q, q.at + outer * slope_q)
    # partial contact: the outer disc less the bore
    if any_of(opposite(full)):
        part = nothing(p)
        for k in range(2):  # a loop, so that it is compiled once
            radius, sign = (outer, 1.0) if k == 0 else (inner, -1.0)
            there = radius > 0.0
            if any_of(there):
                disc = _disc(radius, p, q, slope_p, slope_q)
                part = add(part, there, sign * disc.area, sign * disc.force, sign * disc.first_x, sign * disc.first_y)
        # the largest q
        highest = _highest(outer, p, q, slope_p, slope_q)
        part = Bed(part.force, part.first_x, part.first_y, part.area, highest)
        bed = chosen(full, bed, chosen(part.force > 0.0, part, nothing(p)))
    return bed
