"""The bed of a polygon: cut by both half-planes and summed over triangles, exactly.

Each triangle has a side of the remaining polygon as its base, and all share one point of its boundary. Where q cuts the
polygon this point lies on the cut, whose own triangle is then empty; so each side is cut independently.
"""

from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, greater, lesser, opposite, where, zero_like
from .bed import Bed, add, chosen, nothing, triangle, value


@leaf
def _corner(corners, place):
    return corners[2 * place], corners[2 * place + 1]


class _Point(NamedTuple):
    """A point of the section, m, and q there."""

    x: object
    y: object
    q: object


@leaf
def _between(a, b, begins, ends):
    """Return the zero of a linear function on the segment from a to b, and its fraction; begins, ends: values there."""
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
    """The points at which the outline enters and leaves the part where a function is positive."""

    enters: object
    leaves: object


@kernel
def _cuts(corners, count, p, q):
    """Return the cuts by p and by q, and the common point of all triangles."""
    a = _point(corners, count - 1, q)
    p0 = value(p, a.x, a.y)
    # signs of p and q at the last corner
    was_in, was_pressed = p0 > 0.0, a.q > 0.0
    enters_p, leaves_p, enters_q, leaves_q, on_cut, deepest = a, a, a, a, a, zero_like(p0)
    for k in range(count):
        b = _point(corners, k, q)
        # signs of p and q at the end of the side
        p1 = value(p, b.x, b.y)
        is_in, is_pressed = p1 > 0.0, b.q > 0.0
        # the side crosses the line p = 0
        crosses = was_in ^ is_in
        if any_of(crosses):
            crossing, _ = _between(a, b, p0, p1)
            enters_p = _one_of(crosses & is_in, crossing, enters_p)
            leaves_p = _one_of(crosses & was_in, crossing, leaves_p)
        # the side crosses the line q = 0; the deeper crossing is the common point
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
    # without one within p > 0, an end of the cut by p
    apex = _one_of(deepest > 0.0, on_cut, _one_of(leaves_p.q > enters_p.q, leaves_p, enters_p))
    return _Cut(enters_p, leaves_p), _Cut(enters_q, leaves_q), apex


@kernel
def _cut_bed(corners, count, p, q):
    """Return the bed of the part of the section where p and q are positive."""
    by_p, by_q, apex = _cuts(corners, count, p, q)
    # begin with the side from the last corner to the first
    bed, before = nothing(p), _point(corners, count - 1, q)
    was_in = value(p, before.x, before.y) > 0.0
    for k in range(count + 1):
        if k < count:
            # a side of the polygon
            after = _point(corners, k, q)
            is_in = value(p, after.x, after.y) > 0.0
            there, cut = was_in | is_in, by_q
            if not any_of(there):
                before, was_in = after, is_in
                continue
            crosses = (before.q > 0.0) ^ (after.q > 0.0)
            # the part of a side where p is positive
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
        # the part of it where q is positive
        starts, stops = begins.q > 0.0, ends.q > 0.0
        there = there & (starts | stops)
        if not any_of(there):
            continue
        # largest q at the ends
        highest = where(there, greater(begins.q, ends.q), 0.0)
        if any_of(crosses):
            begins = _one_of(crosses & opposite(starts), cut.enters, begins)
            ends = _one_of(crosses & opposite(stops), cut.leaves, ends)
        # its triangle with the common point
        places = (apex.x, begins.x, ends.x), (apex.y, begins.y, ends.y)
        bed = add(bed, there, *triangle(*places, (apex.q, begins.q, ends.q)))
        bed = Bed(bed.force, bed.first_x, bed.first_y, bed.area, greater(bed.largest, highest))
    return bed


@kernel
def polygon_bed(corners, count, full, p, q):
    """Return the bed of a convex polygon.

    Parameters
    ----------
    corners, count : row, int
        Corners, m, and their number.
    full : Bed
        The bed in full contact.
    p, q : Plane
        Penetration and damped penetration, m.
    """
    # values at the first corner
    x, y = _corner(corners, 0)
    least_p, least_q = value(p, x, y), value(q, x, y)
    most_p, most_q = least_p, least_q
    # extrema of p and q over the corners
    for k in range(1, count):
        x, y = _corner(corners, k)
        at_p, at_q = value(p, x, y), value(q, x, y)
        least_p, most_p = lesser(least_p, at_p), greater(most_p, at_p)
        least_q, most_q = lesser(least_q, at_q), greater(most_q, at_q)
    some = (most_p > 0.0) & (most_q > 0.0)
    # full contact
    closed = some & (least_p >= 0.0) & (least_q >= 0.0)
    bed = chosen(closed, Bed(full.force, full.first_x, full.first_y, full.area, most_q), nothing(p))
    # partial contact
    cut = some & opposite(closed)
    if any_of(cut):
        bed = chosen(cut, _cut_bed(corners, count, p, q), bed)
    return bed
