"""A section made of strips of the same width, each with its own depth: any shape, whole or damaged.

Its numbers are a row: how many strips, their width, then their depths from left to right. The strips lie symmetrically
about the middle of the block; where the outermost have no depth, there is no contact.
"""

from ..layout.spaces import MOST_STRIPS
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import WIDTH, any_of, greater, lane, lesser, where, with_lane
from ..numba_ext.views import one_lane

COUNT, PITCH, DEPTHS = 0, 1, 2  # places in the row


@leaf
def edge_of(strips, k):
    """Beginning of strip k, m; its mirror image is minus it, to the last bit."""
    return strips[PITCH] * (k - 0.5 * strips[COUNT])


@leaf
def _moments(strips, k, lo, hi, middle):
    """Of what lies in strip k of the part from lo to hi."""
    begin, end = max(lo, edge_of(strips, k)), min(hi, edge_of(strips, k + 1))
    length = end - begin
    if not length > 0.0:
        return 0.0, 0.0, 0.0
    area = strips[DEPTHS + k] * length
    off = 0.5 * (begin + end) - middle
    return area, area * off, area * (off * off + length * length * (1.0 / 12.0))


@kernel
def strips_part(strips, lo, hi):
    """Middle, area, first and second moment about it, of the part between two abscissas; strips are taken in pairs.

    So mirror images have mirrored moments.
    """
    middle = 0.5 * (lo + hi)
    area = first = second = 0.0
    count = int(strips[COUNT])
    for k in range((count + 1) // 2):
        a, b, c = _moments(strips, k, lo, hi, middle)
        if 2 * k + 1 < count:
            d, e, f = _moments(strips, count - 1 - k, lo, hi, middle)
            a, b, c = a + d, b + e, c + f
        area += a
        first += b
        second += c
    return middle, area, first, second


# --- the same in lanes, each with its own strips


@leaf
def _count_in_all(count):
    """Number of strips, where all lanes that have any have as many; else 0."""
    most = 0.0
    for i in range(WIDTH):
        most = max(most, lane(count, i))
    return 0 if any_of((count > 0.0) & (count < most)) else int(most)


@leaf
def _depth_from_the_end(strips, k, count):
    """Depth of strip k from the right, of any where there are fewer; count: of all lanes, 0 where it differs."""
    if count > 0:
        return strips[DEPTHS + max(count - 1 - k, 0)]
    depth = strips[DEPTHS]
    for i in range(WIDTH):
        own = one_lane(strips, i)
        depth = with_lane(depth, i, own[DEPTHS + max(int(own[COUNT]) - 1 - k, 0)])
    return depth


@leaf
def _moments_in_lanes(place, length, depth, middle):
    """As `_moments`, of what lies in a strip about a place."""
    area = depth * length
    off = place - middle
    return area, area * off, area * (off * off + length * length * (1.0 / 12.0))


@leaf
def _within_strip(strips, number, lo, hi):
    """Middle and length of what of the part lies in the strip with this number, in lanes."""
    origin = 0.5 * strips[COUNT]
    begin, end = greater(lo, strips[PITCH] * (number - origin)), lesser(hi, strips[PITCH] * (number + 1.0 - origin))
    return 0.5 * (begin + end), greater(end - begin, 0.0)


@kernel
def strips_part_in_lanes(strips, lo, hi):
    """As `strips_part`, to the last bit."""
    middle = 0.5 * (lo + hi)
    area = first = second = 0.0 * middle
    count = strips[COUNT]
    in_all = _count_in_all(count)
    for k in range((MOST_STRIPS + 1) // 2):
        some = count > 2.0 * k
        if not any_of(some):
            break
        place, length = _within_strip(strips, 0.0 * count + k, lo, hi)
        other, other_length = _within_strip(strips, count - 1.0 - k, lo, hi)
        length = where(some, length, 0.0)
        other_length = where(count > 2.0 * k + 1.0, other_length, 0.0)
        if any_of(length + other_length > 0.0):
            a, b, c = _moments_in_lanes(place, length, strips[DEPTHS + k], middle)
            d, e, f = _moments_in_lanes(other, other_length, _depth_from_the_end(strips, k, in_all), middle)
            area += a + d
            first += b + e
            second += c + f
    return middle, area, first, second
