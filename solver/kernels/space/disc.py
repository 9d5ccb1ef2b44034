"""The bed of a disc or a ring: a disc cut by two chords that need not be parallel, in closed form.

What two half-planes leave of a disc is a polygon between points of its rim and, beyond each of its sides that joins the
ends of an arc, a segment of the disc (sections/circle.py). Along a segment's chord its second moment is that of
theory.md section 10 across: R^4 times the integral 2/3 sin^4.
"""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.numbers import angle_of
from ..sections.circle import SMALL, TERMS, circle_part
from .bed import Bed, add, nothing, triangle, value, whole

# 2/3 of the integral of sin^4 over sin^5, in powers of sin^2, the highest first: 1 / cos = sum of these times sin^2k
ACROSS = tuple(2.0 / 3.0 * math.comb(2 * k, k) / 4**k / (5 + 2 * k) for k in range(TERMS))[::-1]
TINY = 1e-300
PARALLEL = 1e-14  # sine of the angle between two chords that are taken as parallel


@leaf
def _across(sine, cosine):
    """2/3 of the integral of sin^4 from 0 to the angle with this sine and cosine, 0 to pi."""
    square = sine * sine
    if sine < SMALL and cosine > 0.0:
        total = 0.0
        for coefficient in ACROSS:
            total = total * square + coefficient
        return total * square * square * sine
    angle = angle_of(sine, abs(cosine))
    angle = angle if cosine >= 0.0 else math.pi - angle
    return 0.25 * (angle - sine * cosine) - sine * cosine * square / 6.0


@leaf
def _segment(bed, radius, q, out_x, out_y, cut):
    """A bed with the segment beyond a chord, whose normal away from the centre is (out_x, out_y), `cut` m from it."""
    about, area, first, second = circle_part(radius, cut, radius)
    half = math.sqrt(max(0.0, (radius - cut) * (radius + cut)))
    across = _across(half / radius, cut / radius) * (radius * radius) * (radius * radius)
    rise = q.along_x * out_x + q.along_y * out_y
    slope = q.along_y * out_x - q.along_x * out_y
    middle = q.at + rise * about
    force = middle * area + rise * first
    outwards = about * force + (middle * first + rise * second)
    along = slope * across
    return add(bed, area, force, outwards * out_x - along * out_y, outwards * out_y + along * out_x)


@leaf
def _arc(bed, radius, q, begin, end):
    """A bed with the segment beyond the chord of an arc, anticlockwise from its beginning to its end."""
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    length = math.sqrt(dx * dx + dy * dy)
    if length <= TINY:
        return bed
    out_x, out_y = dy / length, -dx / length
    cut = 0.5 * ((begin[0] + end[0]) * out_x + (begin[1] + end[1]) * out_y)
    return _segment(bed, radius, q, out_x, out_y, min(cut, radius))


@leaf
def _side(bed, q, a, b, c):
    """A bed with the triangle of three points."""
    values = value(q, a[0], a[1]), value(q, b[0], b[1]), value(q, c[0], c[1])
    area, force, first_x, first_y = triangle((a[0], b[0], c[0]), (a[1], b[1], c[1]), values)
    return add(bed, area, force, first_x, first_y)


@leaf
def _chord(radius, slope, plane):
    """Where a function passes zero in the disc: normal to the positive side, distance, the chord's two ends.

    slope: of the function, not 0. The positive side is on the left from the first to the second end.
    """
    nx, ny = plane.along_x / slope, plane.along_y / slope
    off = -plane.at / slope
    half = math.sqrt(max(0.0, (radius - off) * (radius + off)))
    return nx, ny, off, (off * nx - half * ny, off * ny + half * nx), (off * nx + half * ny, off * ny - half * nx)


@kernel
def _two_chords(radius, p, q, slope_p, slope_q):
    """The bed where both functions pass zero within the disc."""
    px, py, off_p, p_begin, p_end = _chord(radius, slope_p, p)
    qx, qy, off_q, q_begin, q_end = _chord(radius, slope_q, q)
    bed = nothing()
    turn = px * qy - py * qx  # sine of the angle between the chords
    if abs(turn) <= PARALLEL and px * qx + py * qy > 0.0:  # both cut the same side away: the farther one counts
        if off_p > off_q:
            return _segment(bed, radius, q, px, py, off_p)
        return _segment(bed, radius, q, qx, qy, off_q)
    # ends of either chord on the positive side of the other function
    begins_p, ends_p = value(q, p_begin[0], p_begin[1]) > 0.0, value(q, p_end[0], p_end[1]) > 0.0
    begins_q, ends_q = value(p, q_begin[0], q_begin[1]) > 0.0, value(p, q_end[0], q_end[1]) > 0.0
    if begins_p and ends_p:
        if begins_q and ends_q:  # a strip between both
            bed = _side(bed, q, p_begin, p_end, q_begin)
            bed = _side(bed, q, p_begin, q_begin, q_end)
            bed = _arc(bed, radius, q, p_end, q_begin)
            return _arc(bed, radius, q, q_end, p_begin)
        return _segment(bed, radius, q, px, py, off_p)
    if begins_q and ends_q:
        return _segment(bed, radius, q, qx, qy, off_q)
    if begins_p == ends_p:
        return bed
    # they cross in the disc
    x, y = (off_p * qy - off_q * py) / turn, (off_q * px - off_p * qx) / turn
    if begins_p:
        bed = _side(bed, q, (x, y), q_end, p_begin)
        return _arc(bed, radius, q, q_end, p_begin)
    bed = _side(bed, q, (x, y), p_end, q_begin)
    return _arc(bed, radius, q, p_end, q_begin)


@kernel
def _disc(radius, p, q, slope_p, slope_q):
    """The bed of a disc: of its part where p and q are positive."""
    if p.at + radius * slope_p <= 0.0 or q.at + radius * slope_q <= 0.0:
        return nothing()
    cuts_p, cuts_q = p.at < radius * slope_p, q.at < radius * slope_q
    if cuts_p and cuts_q:
        same = p.along_x == q.along_x and p.along_y == q.along_y and p.at == q.at
        if not same:
            return _two_chords(radius, p, q, slope_p, slope_q)
    if cuts_p:
        return _segment(nothing(), radius, q, p.along_x / slope_p, p.along_y / slope_p, -p.at / slope_p)
    if cuts_q:
        return _segment(nothing(), radius, q, q.along_x / slope_q, q.along_y / slope_q, -q.at / slope_q)
    area = math.pi * radius * radius
    second = 0.25 * area * radius * radius
    return Bed(q.at * area, q.along_x * second, q.along_y * second, area, 0.0)


@leaf
def _slope(plane):
    return math.sqrt(plane.along_x * plane.along_x + plane.along_y * plane.along_y)


@kernel
def _highest(radius, p, q, slope_p, slope_q):
    """The largest q where p is not negative, in a disc: at the rim, or where the chord of p meets it."""
    top = q.at + radius * slope_q
    if slope_q == 0.0:
        return top
    x, y = radius * q.along_x / slope_q, radius * q.along_y / slope_q
    if value(p, x, y) >= 0.0 or slope_p == 0.0:
        return top
    _, _, _, begin, end = _chord(radius, slope_p, p)
    return max(value(q, end[0], end[1]), value(q, begin[0], begin[1]))


@kernel
def round_bed(scene, j, p, q):
    """The bed of joint j, whose section is a disc or a ring."""
    outer, inner = scene.joints.outer[j], scene.joints.inner[j]
    slope_p, slope_q = _slope(p), _slope(q)
    if p.at >= outer * slope_p and q.at >= outer * slope_q:
        return whole(scene.joints, j, q, q.at + outer * slope_q)
    bed = nothing()
    for k in range(2):  # which is compiled once
        radius = outer if k == 0 else inner
        if radius > 0.0:
            sign = 1.0 if k == 0 else -1.0
            part = _disc(radius, p, q, slope_p, slope_q)
            bed = add(bed, sign * part.area, sign * part.force, sign * part.first_x, sign * part.first_y)
    if not bed.force > 0.0:
        return nothing()
    return Bed(bed.force, bed.first_x, bed.first_y, bed.area, _highest(outer, p, q, slope_p, slope_q))


@kernel
def round_square(scene, j, p):
    """The integral of p^2 over the part of joint j where p is positive, m4: that of p times p."""
    bed = round_bed(scene, j, p, p)
    return p.at * bed.force + p.along_x * bed.first_x + p.along_y * bed.first_y
