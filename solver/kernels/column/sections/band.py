"""A straight face and a round one: parts of their intersection, in closed form (theory.md section 10).

The straight face is a row of strips (strips.py), of which a rectangle is one. Across the motion each is a band about
the axis, which bears as far as it lies within the rim of the round face, and not where it lies over its bore: a circle
that a band cuts off is a part of a rectangle between two parts of the circle.
"""

import math

from ...engine.circle import circle_part
from ...numba_ext.jit import kernel, leaf
from .lens import push_of
from .strips import COUNT, DEPTHS, edge_of


@leaf
def _kink(radius, half):
    """Return the distance (m) from the centre at which a circle is as deep as a band of this half depth, or 0."""
    return math.sqrt((radius - half) * (radius + half)) if radius > half else 0.0


@leaf
def _about(part, about):
    """Return area, first and second moment of a part about the abscissa `about` instead of its own middle."""
    middle, area, first, second = part
    off = middle - about
    return area, first + off * area, second + off * (2.0 * first + off * area)


@kernel
def _arc(radius, lo, hi, about):
    return _about(circle_part(radius, lo, hi), about) if lo < hi else (0.0, 0.0, 0.0)


@kernel
def _cut_circle(radius, half, lo, hi, about):
    """Return area, first and second moment of the part from lo to hi of a circle within a band of this half depth."""
    lo, hi = max(lo, -radius), min(hi, radius)
    # parts of the circle on either side, shallower than the band
    kink = _kink(radius, half)
    left, right = _arc(radius, lo, min(hi, -kink), about), _arc(radius, max(lo, kink), hi, about)
    # the rectangle between them
    begin, end = max(lo, -kink), min(hi, kink)
    length = max(0.0, end - begin)
    area = 2.0 * half * length
    flat = _about((0.5 * (begin + end), area, 0.0, area * (length * length) * (1.0 / 12.0)), about)
    return (left[0] + right[0]) + flat[0], (left[1] + right[1]) + flat[1], (left[2] + right[2]) + flat[2]


@kernel
def _within_strip(strips, k, outer, inner, centre, lo, hi, about):
    """Return area, first and second moment of the intersection of strip k and an annulus."""
    # clip the strip, relative to the centre of the annulus
    half = 0.5 * strips[DEPTHS + k]
    lo, hi = max(lo, edge_of(strips, k)) - centre, min(hi, edge_of(strips, k + 1)) - centre
    if not (half > 0.0 and lo < hi):
        return 0.0, 0.0, 0.0
    # circle less bore
    area, first, second = _cut_circle(outer, half, lo, hi, about - centre)
    if inner > 0.0:
        a, b, c = _cut_circle(inner, half, lo, hi, about - centre)
        area, first, second = area - a, first - b, second - c
    return area, first, second


@kernel
def band_part(strips, outer, inner, centre, lo, hi):
    """Return middle, area, first and second moment about it of the intersection of strips and an annulus from lo to hi.

    Strips are summed in pairs from the outside, so that mirror images have mirrored moments: m, m2, m3, m4.

    Parameters
    ----------
    strips : row
        The strips (strips.py).
    outer, inner : float
        Radii of the annulus, m.
    centre : float
        Abscissa of its centre, m.
    lo, hi : float
        Ends of the part, m.
    """
    # moments about the middle of the interval
    about = 0.5 * (lo + hi)
    area = first = second = 0.0
    count = int(strips[COUNT])
    # strip k from the left with strip k from the right
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
    """Return the ends (m) of the part of strip k from lo to hi without ends over the bore; lo >= hi if none is left."""
    half = 0.5 * strips[DEPTHS + k]
    lo, hi = max(lo, edge_of(strips, k)), min(hi, edge_of(strips, k + 1))
    over = _kink(inner, half)
    # a strip without depth bears nothing
    if not half > 0.0:
        return hi, hi
    # move an end that lies over the bore to its edge
    if over > 0.0:
        if centre - over <= lo < centre + over:
            lo = centre + over
        if centre - over < hi <= centre + over:
            hi = centre - over
    return lo, hi


@kernel
def ends_of_band(strips, inner, centre, left, right):
    """Return the ends of the contact (m) between its rims, without strips that lie over the bore or have no depth."""
    if not left < right:
        return left, right
    first, last = right, left
    # first and last strip with a part beside the bore
    for k in range(int(strips[COUNT])):
        lo, hi = _first_touched(strips, k, inner, centre, left, right)
        if lo < hi:
            first, last = min(first, lo), max(last, hi)
    return first, last


@kernel
def _push_on_strip(strips, k, radius, slip, lo, hi, stiffness, opening, slope):
    """Return the decrease of energy per metre of slip (J/m) over the arcs of a circle about -slip bounding strip k."""
    # clip the strip to the circle
    half = 0.5 * strips[DEPTHS + k]
    lo, hi = max(max(lo, edge_of(strips, k)), -radius - slip), min(min(hi, edge_of(strips, k + 1)), radius - slip)
    kink, left, right = _kink(radius, half), 0.0, 0.0
    if not half > 0.0:
        return 0.0
    # arcs on the left and on the right, where the circle is shallower than the strip
    end, begin = min(hi, -kink - slip), max(lo, kink - slip)
    if lo < end:
        left = push_of(radius, slip, lo, end, stiffness, opening, slope)
    if begin < hi:
        right = push_of(radius, slip, begin, hi, stiffness, opening, slope)
    return left + right


@kernel
def band_push(strips, outer, inner, slip, lo, hi, stiffness, opening, slope):
    """Return the force (N, towards +x) of the rims of an annulus below on the strips above, pressed from lo to hi."""
    force, count = 0.0, int(strips[COUNT])
    # strips in pairs from the outside, so that mirror images have mirrored forces
    for k in range((count + 1) // 2):
        other = count - 1 - k
        part = _push_on_strip(strips, k, outer, slip, lo, hi, stiffness, opening, slope)
        if other > k:
            part += _push_on_strip(strips, other, outer, slip, lo, hi, stiffness, opening, slope)
        # less that of the bore
        if inner > 0.0:
            hollow = _push_on_strip(strips, k, inner, slip, lo, hi, stiffness, opening, slope)
            if other > k:
                hollow += _push_on_strip(strips, other, inner, slip, lo, hi, stiffness, opening, slope)
            part -= hollow
        force += part
    return force
