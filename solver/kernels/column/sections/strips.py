"""A section made of strips of the same width, each with its own depth: any shape, whole or damaged.

A section is a row: number of strips, their width, m, then their depths from left to right, m. The strips lie
symmetrically about the middle of the block; where the outermost have no depth, there is no contact.
"""

from ...layout.spaces import MOST_STRIPS
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.lanes import (
    WIDTH,
    any_of,
    greater,
    lane,
    lesser,
    where,
    with_lane,
)
from ...numba_ext.views import one_lane

COUNT, PITCH, DEPTHS = 0, 1, 2  # offsets in the row


@leaf
def edge_of(strips, k):
    """Return the left end of strip k (m); the ends of mirror images are opposite to the last bit."""
    return strips[PITCH] * (k - 0.5 * strips[COUNT])


@leaf
def _moments(strips, k, lo, hi, middle):
    """Return area, first and second moment about the middle of the part of strip k between lo and hi."""
    # clip the strip to the interval
    begin, end = max(lo, edge_of(strips, k)), min(hi, edge_of(strips, k + 1))
    length = end - begin
    if not length > 0.0:
        return 0.0, 0.0, 0.0
    # moments of a rectangle
    area = strips[DEPTHS + k] * length
    off = 0.5 * (begin + end) - middle
    return area, area * off, area * (off * off + length * length * (1.0 / 12.0))


@kernel
def strips_part(strips, lo, hi):
    """Return middle, area (m2), first and second moment (m3, m4) about it, of the part between two abscissas (m).

    Strips are summed in pairs from the outside, so that mirror images have mirrored moments.
    """
    # moments about the middle of the interval
    middle = 0.5 * (lo + hi)
    area = first = second = 0.0
    count = int(strips[COUNT])
    # strip k from the left with strip k from the right
    for k in range((count + 1) // 2):
        a, b, c = _moments(strips, k, lo, hi, middle)
        if 2 * k + 1 < count:
            d, e, f = _moments(strips, count - 1 - k, lo, hi, middle)
            a, b, c = a + d, b + e, c + f
        area += a
        first += b
        second += c
    return middle, area, first, second


# --- in lanes, each with its own strips


@leaf
def _count_in_all(count):
    """Return the number of strips if all lanes that have strips have the same number; else 0."""
    most = 0.0
    for i in range(WIDTH):
        most = max(most, lane(count, i))
    return 0 if any_of((count > 0.0) & (count < most)) else int(most)


@leaf
def _depth_from_the_end(strips, k, count):
    """Return the depth (m) of strip k from the right, in lanes; undefined in lanes with fewer strips.

    count: number of strips of all lanes, 0 where they differ.
    """
    # one index for all lanes
    if count > 0:
        return strips[DEPTHS + max(count - 1 - k, 0)]
    # else one lane after the other
    depth = strips[DEPTHS]
    for i in range(WIDTH):
        own = one_lane(strips, i)
        depth = with_lane(depth, i, own[DEPTHS + max(int(own[COUNT]) - 1 - k, 0)])
    return depth


@leaf
def _moments_in_lanes(place, length, depth, middle):
    """Return `_moments` of the part of a strip with this middle (place), length and depth, in lanes."""
    area = depth * length
    off = place - middle
    return area, area * off, area * (off * off + length * length * (1.0 / 12.0))


@leaf
def _within_strip(strips, number, lo, hi):
    """Return middle and length (m) of the intersection of the interval and the strip with this number, in lanes."""
    origin = 0.5 * strips[COUNT]
    begin, end = greater(lo, strips[PITCH] * (number - origin)), lesser(hi, strips[PITCH] * (number + 1.0 - origin))
    return 0.5 * (begin + end), greater(end - begin, 0.0)


@kernel
def strips_part_in_lanes(strips, lo, hi):
    """Return `strips_part` in lanes, equal to the last bit."""
    # moments about the middle of the interval
    middle = 0.5 * (lo + hi)
    area = first = second = 0.0 * middle
    count = strips[COUNT]
    in_all = _count_in_all(count)
    for k in range((MOST_STRIPS + 1) // 2):
        # lanes that have strips k from either side
        some = count > 2.0 * k
        if not any_of(some):
            break
        # strip k from the left, and strip k from the right where that is another one
        place, length = _within_strip(strips, 0.0 * count + k, lo, hi)
        other, other_length = _within_strip(strips, count - 1.0 - k, lo, hi)
        length = where(some, length, 0.0)
        other_length = where(count > 2.0 * k + 1.0, other_length, 0.0)
        # add the moments of both
        if any_of(length + other_length > 0.0):
            a, b, c = _moments_in_lanes(place, length, strips[DEPTHS + k], middle)
            d, e, f = _moments_in_lanes(other, other_length, _depth_from_the_end(strips, k, in_all), middle)
            area += a + d
            first += b + e
            second += c + f
    return middle, area, first, second
