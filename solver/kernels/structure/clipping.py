"""Clipping of convex polygons in `room`: the corners of one, then scratch space for a cut."""

import math

from ..numba_ext.jit import kernel, leaf
from .bed import value
from .layout import NO_ROOM, ROOM

_CUT = ROOM // 2
_MOST_LEFT = (ROOM - _CUT) // 2  # most corners after a cut, which no convex polygon exceeds


@leaf
def put_square(room, x, y, half):
    """Fill the room with a square about (x, y) of half width `half`, m; return the number of its corners, 4."""
    room[0], room[1] = x - half, y - half
    room[2], room[3] = x + half, y - half
    room[4], room[5] = x + half, y + half
    room[6], room[7] = x - half, y + half
    return 4


@kernel
def cut(room, count, plane):
    """Clip the polygon in the room to where a linear function is positive; return the number of its corners.

    If a non-convex outline would leave more corners than the room holds, nothing is left and `room[NO_ROOM]` counts it.
    """
    least, most = math.inf, -math.inf
    # extrema over the corners: nothing or everything may be left
    for k in range(count):
        here = value(plane, room[2 * k], room[2 * k + 1])
        least, most = min(least, here), max(most, here)
    if least > 0.0 or not most > 0.0:
        return count if least > 0.0 else 0
    # walk along the edges
    kept, cut = 0, room[_CUT:]
    x0, y0 = room[2 * count - 2], room[2 * count - 1]
    before = value(plane, x0, y0)
    for k in range(count):
        x1, y1 = room[2 * k], room[2 * k + 1]
        here = value(plane, x1, y1)
        # the edge crosses the line
        if (before > 0.0) != (here > 0.0):
            if kept == _MOST_LEFT:
                room[NO_ROOM] += 1.0
                return 0
            part = before / (before - here)
            cut[2 * kept], cut[2 * kept + 1] = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
            kept += 1
        # the corner stays
        if here > 0.0:
            if kept == _MOST_LEFT:
                room[NO_ROOM] += 1.0
                return 0
            cut[2 * kept], cut[2 * kept + 1] = x1, y1
            kept += 1
        x0, y0, before = x1, y1, here
    # back to the front of the room
    for k in range(2 * kept):
        room[k] = cut[k]
    return kept
