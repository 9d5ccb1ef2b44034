"""A straight face and a round one: parts of what they share, in closed form (theory.md section 10).

The straight face is a row of strips (strips.py), of which a rectangle is one. Across the motion each is a band about
the axis, which bears as far as it lies within the rim of the round face, and not where it lies over its bore: a circle
that a band cuts off is a part of a rectangle between two parts of the circle.
"""

import math

from ..numba_ext.jit import kernel, leaf
from .circle import circle_part
from .lens import push_of
from .strips import COUNT, DEPTHS, edge_of


@leaf
def _kink(radius, half):
    """Abscissas at which a circle is as deep as a band of this half depth, m to either side of its centre."""
    return math.sqrt((radius - half) * (radius + half)) if radius > half else 0.0


@leaf
def _about(part, about):
    """Area, first and second moment of a part about another place than its middle, or than that of a rectangle."""
    middle, area, first, second = part
    off = middle - about
    return area, first + off * area, second + off * (2.0 * first + off * area)


@kernel
def _arc(radius, lo, hi, about):
    return _about(circle_part(radius, lo, hi), about) if lo < hi else (0.0, 0.0, 0.0)


@kernel
def _cut_circle(radius, half, lo, hi, about):
    """Area, first and second moment of the part from lo to hi of a circle that a band of this half depth cuts off."""
    lo, hi = max(lo, -radius), min(hi, radius)
    kink = _kink(radius, half)
    left, right = _arc(radius, lo, min(hi, -kink), about), _arc(radius, max(lo, kink), hi, about)
    begin, end = max(lo, -kink), min(hi, kink)
    length = max(0.0, end - begin)
    area = 2.0 * half * length
    flat = _about((0.5 * (begin + end), area, 0.0, area * (length * length) * (1.0 / 12.0)), about)
    return (left[0] + right[0]) + flat[0], (left[1] + right[1]) + flat[1], (left[2] + right[2]) + flat[2]


@kernel
def _within_strip(strips, k, outer, inner, centre, lo, hi, about):
    """Area, first and second moment of the common part of strip k and an annulus."""
    half = 0.5 * strips[DEPTHS + k]
    lo, hi = max(lo, edge_of(strips, k)) - centre, min(hi, edge_of(strips, k + 1)) - centre
    if not (half > 0.0 and lo < hi):
        return 0.0, 0.0, 0.0
    area, first, second = _cut_circle(outer, half, lo, hi, about - centre)
    if inner > 0.0:
        a, b, c = _cut_circle(inner, half, lo, hi, about - centre)
        area, first, second = area - a, first - b, second - c
    return area, first, second


@kernel
def band_part(strips, outer, inner, centre, lo, hi):
    """Middle, area, first and second moment about it, of what strips share with an annulus about a centre, m.

    From lo to hi; strips are taken in pairs, so that mirror images have mirrored moments.
    """
    about = 0.5 * (lo + hi)
    area = first = second = 0.0
    count = int(strips[COUNT])
    for k in range((count + 1) // 2):
        a, b, c = _within_strip(strips, k, outer, inner, centre, lo, hi, about)
        if 2 * k + 1 < count:
            d, e, f = _within_strip(strips, count - 1 - k, outer, inner, centre, lo, hi, about)
            a, b, c = a + d, b + e, c + f
        area += a
        first += b
        second += c
    return about, area, first, second


@leaf
def _first_touched(strips, k, inner, centre, lo, hi):
    """Ends, m, of the part of strip k from lo to hi that is not all over the bore; lo >= hi: nothing."""
    half = 0.5 * strips[DEPTHS + k]
    lo, hi = max(lo, edge_of(strips, k)), min(hi, edge_of(strips, k + 1))
    over = _kink(inner, half)
    if not half > 0.0:
        return hi, hi
    if over > 0.0:
        if centre - over <= lo < centre + over:
            lo = centre + over
        if centre - over < hi <= centre + over:
            hi = centre - over
    return lo, hi


@kernel
def ends_of_band(strips, inner, centre, left, right):
    """Ends of the contact, m, between its rims: where strips lie over the bore, or are none, nothing touches."""
    if not left < right:
        return left, right
    first, last = right, left
    for k in range(int(strips[COUNT])):
        lo, hi = _first_touched(strips, k, inner, centre, left, right)
        if lo < hi:
            first, last = min(first, lo), max(last, hi)
    return first, last


@kernel
def _push_on_strip(strips, k, radius, slip, lo, hi, stiffness, opening, slope):
    """Decrease of the energy over the arcs of a circle about -slip that bound strip k, for a slip of 1 m, J/m."""
    half = 0.5 * strips[DEPTHS + k]
    lo, hi = max(max(lo, edge_of(strips, k)), -radius - slip), min(min(hi, edge_of(strips, k + 1)), radius - slip)
    kink, left, right = _kink(radius, half), 0.0, 0.0
    if not half > 0.0:
        return 0.0
    end, begin = min(hi, -kink - slip), max(lo, kink - slip)
    if lo < end:
        left = push_of(radius, slip, lo, end, stiffness, opening, slope)
    if begin < hi:
        right = push_of(radius, slip, begin, hi, stiffness, opening, slope)
    return left + right


@kernel
def band_push(strips, outer, inner, slip, lo, hi, stiffness, opening, slope):
    """Force of the rims of an annulus below on the strips above, pressed from lo to hi: N, outwards, towards +x."""
    force, count = 0.0, int(strips[COUNT])
    for k in range((count + 1) // 2):
        other = count - 1 - k
        part = _push_on_strip(strips, k, outer, slip, lo, hi, stiffness, opening, slope)
        if other > k:
            part += _push_on_strip(strips, other, outer, slip, lo, hi, stiffness, opening, slope)
        if inner > 0.0:
            hollow = _push_on_strip(strips, k, inner, slip, lo, hi, stiffness, opening, slope)
            if other > k:
                hollow += _push_on_strip(strips, other, inner, slip, lo, hi, stiffness, opening, slope)
            part -= hollow
        force += part
    return force
