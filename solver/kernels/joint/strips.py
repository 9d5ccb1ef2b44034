"""A section made of strips of the same width, each with its own depth: any shape, whole or damaged.

Its numbers are a row: how many strips, their width, then their depths from left to right. The strips lie symmetrically
about the middle of the block; where the outermost have no depth, there is no contact.
"""

from ..jit import kernel, leaf

COUNT, PITCH, DEPTHS = 0, 1, 2  # places in the row


@leaf
def edge_of(strips, k):
    """Where strip k begins, m; its mirror image is minus it, to the last bit."""
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
    return area, area * off, area * (off * off + length * length / 12.0)


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
