"""The bed of a polygon: cut by both half-planes and summed over triangles, exactly.

The triangles have a side of what is left as their base, and one point of its boundary in common. Where q cuts the
polygon this point lies on the cut, whose own triangle is then nothing; so each side is cut for itself.
"""

from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, greater, lesser, opposite, where, zero_like
from .bed import Bed, add, chosen, nothing, triangle, value


@leaf
def _corner(corners, place):
    return corners[2 * place], corners[2 * place + 1]


class _Point(NamedTuple):
    """A place on the section, and q there."""

    x: object
    y: object
    q: object


@leaf
def _between(a, b, begins, ends):
    """The point where a linear function passes zero that has these values at two points; and the part of the way."""
    part = begins / (begins - ends)
    return _Point(a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), a.q + part * (b.q - a.q)), part


@leaf
def _one_of(condition, a, b):
    return _Point(where(condition, a.x, b.x), where(condition, a.y, b.y), where(condition, a.q, b.q))


@leaf
def _point(corners, place, q):
    x, y = _corner(corners, place)
    return _Point(x, y, value(q, x, y))


class _Cut(NamedTuple):
    """Where the sides of the section enter and leave the part where a function is positive."""

    enters: object
    leaves: object


@kernel
def _cuts(corners, count, p, q):
    """The cuts by p and by q, and the point that all triangles share."""
    a = _point(corners, count - 1, q)
    p0 = value(p, a.x, a.y)
    was_in, was_pressed = p0 > 0.0, a.q > 0.0
    enters_p, leaves_p, enters_q, leaves_q, on_cut, deepest = a, a, a, a, a, zero_like(p0)
    for k in range(count):
        b = _point(corners, k, q)
        p1 = value(p, b.x, b.y)
        is_in, is_pressed = p1 > 0.0, b.q > 0.0
        crosses = was_in ^ is_in
        if any_of(crosses):
            crossing, _ = _between(a, b, p0, p1)
            enters_p = _one_of(crosses & is_in, crossing, enters_p)
            leaves_p = _one_of(crosses & was_in, crossing, leaves_p)
        crosses = was_pressed ^ is_pressed
        if any_of(crosses):
            crossing, part = _between(a, b, a.q, b.q)
            crossing = _Point(crossing.x, crossing.y, zero_like(p0))
            enters_q = _one_of(crosses & is_pressed, crossing, enters_q)
            leaves_q = _one_of(crosses & was_pressed, crossing, leaves_q)
            depth = p0 + part * (p1 - p0)
            deeper = crosses & (depth > deepest)
            on_cut, deepest = _one_of(deeper, crossing, on_cut), where(deeper, depth, deepest)
        a, p0, was_in, was_pressed = b, p1, is_in, is_pressed
    apex = _one_of(deepest > 0.0, on_cut, _one_of(leaves_p.q > enters_p.q, leaves_p, enters_p))
    return _Cut(enters_p, leaves_p), _Cut(enters_q, leaves_q), apex


@kernel
def _cut_bed(corners, count, p, q):
    """The bed of the part of the section where p and q are positive."""
    by_p, by_q, apex = _cuts(corners, count, p, q)
    bed, before = nothing(p), _point(corners, count - 1, q)
    was_in = value(p, before.x, before.y) > 0.0
    for k in range(count + 1):
        if k < count:
            after = _point(corners, k, q)
            is_in = value(p, after.x, after.y) > 0.0
            there, cut = was_in | is_in, by_q
            if not any_of(there):
                before, was_in = after, is_in
                continue
            crosses = (before.q > 0.0) ^ (after.q > 0.0)
            begins, ends = _one_of(was_in, before, by_p.enters), _one_of(is_in, after, by_p.leaves)
            before, was_in = after, is_in
        else:  # the cut by p is the last side
            begins, ends, cut = by_p.leaves, by_p.enters, by_q
            crosses = (begins.q > 0.0) ^ (ends.q > 0.0)
            there = begins.q == begins.q
            if any_of(crosses):
                crossing, _ = _between(begins, ends, begins.q, ends.q)
                crossing = _Point(crossing.x, crossing.y, zero_like(crossing.q))
                cut = _Cut(crossing, crossing)
        starts, stops = begins.q > 0.0, ends.q > 0.0
        there = there & (starts | stops)
        if not any_of(there):
            continue
        highest = where(there, greater(begins.q, ends.q), 0.0)
        if any_of(crosses):
            begins = _one_of(crosses & opposite(starts), cut.enters, begins)
            ends = _one_of(crosses & opposite(stops), cut.leaves, ends)
        places = (apex.x, begins.x, ends.x), (apex.y, begins.y, ends.y)
        bed = add(bed, there, *triangle(*places, (apex.q, begins.q, ends.q)))
        bed = Bed(bed.force, bed.first_x, bed.first_y, bed.area, greater(bed.largest, highest))
    return bed


@kernel
def polygon_bed(corners, count, full, p, q):
    """The bed of a convex polygon of `count` corners; full: that where all of it is pressed."""
    x, y = _corner(corners, 0)
    least_p, least_q = value(p, x, y), value(q, x, y)
    most_p, most_q = least_p, least_q
    for k in range(1, count):
        x, y = _corner(corners, k)
        at_p, at_q = value(p, x, y), value(q, x, y)
        least_p, most_p = lesser(least_p, at_p), greater(most_p, at_p)
        least_q, most_q = lesser(least_q, at_q), greater(most_q, at_q)
    some = (most_p > 0.0) & (most_q > 0.0)
    closed = some & (least_p >= 0.0) & (least_q >= 0.0)
    bed = chosen(closed, Bed(full.force, full.first_x, full.first_y, full.area, most_q), nothing(p))
    cut = some & opposite(closed)
    if any_of(cut):
        bed = chosen(cut, _cut_bed(corners, count, p, q), bed)
    return bed
