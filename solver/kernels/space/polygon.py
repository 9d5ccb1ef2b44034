"""The bed of a polygon: cut by both half-planes, corner after corner, and summed over triangles, exactly.

A corner of the polygon, or the place where a side crosses the edge of the first half-plane, goes on to the second cut;
what is left there goes on to the sum. So nothing is stored, and eight polygons pass at once.
"""

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, greater, index_of, lesser, opposite, where
from .bed import Bed, add, chosen, nothing, triangle, value, whole


@leaf
def _corner(corners, place):
    return corners[2 * place], corners[2 * place + 1]


@leaf
def _crosses(a, b):
    """Whether a linear function changes its sign between two corners, where it has these values."""
    return ((a > 0.0) & (b <= 0.0)) | ((a <= 0.0) & (b > 0.0))


@leaf
def _towards(part, a, b):
    return a + part * (b - a)


@kernel
def _cut_bed(scene, j, p, q, nowhere):
    """The bed of the part of the section where p and q are positive; nowhere: a condition that never holds."""
    first, count = index_of(scene.joints.first[j]), index_of(scene.joints.corners[j])
    x0, y0 = _corner(scene.corners, first + count - 1)
    p0, q0 = value(p, x0, y0), value(q, x0, y0)
    bed = nothing(p)
    # of what the first cut leaves: its first corner, the one before, and whether there is one
    begin_x, begin_y, begin_q, last_x, last_y, last_q, some = x0, y0, q0, x0, y0, q0, nowhere
    # of what the second cut leaves
    fan_x, fan_y, fan_q, side_x, side_y, side_q, found = x0, y0, q0, x0, y0, q0, nowhere
    for k in range(count + 1):  # the last time the second cut comes back to its beginning
        x1, y1 = _corner(scene.corners, first + (k if k < count else 0))
        p1, q1 = value(p, x1, y1), value(q, x1, y1)
        for corner in range(2):
            if k == count:
                if corner == 1:
                    break
                there, x, y, at_q = some, begin_x, begin_y, begin_q
            elif corner == 0:
                there = _crosses(p0, p1)
                part = p0 / (p0 - p1)
                x, y, at_q = _towards(part, x0, x1), _towards(part, y0, y1), _towards(part, q0, q1)
            else:
                there, x, y, at_q = p1 > 0.0, x1, y1, q1
            if not any_of(there):
                continue
            for step in range(2):
                if step == 0:
                    left = there & some & _crosses(last_q, at_q)
                    part = last_q / (last_q - at_q)
                    cx, cy, cq = _towards(part, last_x, x), _towards(part, last_y, y), 0.0 * at_q
                else:
                    left, cx, cy, cq = there & (at_q > 0.0), x, y, at_q
                    if k == count:
                        break
                if not any_of(left):
                    continue
                further = left & found
                if any_of(further):
                    area, force, first_x, first_y = triangle(
                        (fan_x, side_x, cx), (fan_y, side_y, cy), (fan_q, side_q, cq)
                    )
                    bed = add(bed, further, area, force, first_x, first_y)
                fresh = left & opposite(found)
                fan_x, fan_y, fan_q = where(fresh, cx, fan_x), where(fresh, cy, fan_y), where(fresh, cq, fan_q)
                side_x, side_y, side_q = where(left, cx, side_x), where(left, cy, side_y), where(left, cq, side_q)
                highest = where(left, greater(bed.largest, cq), bed.largest)
                bed = Bed(bed.force, bed.first_x, bed.first_y, bed.area, highest)
                found = found | left
            fresh = there & opposite(some)
            begin_x, begin_y, begin_q = where(fresh, x, begin_x), where(fresh, y, begin_y), where(fresh, at_q, begin_q)
            last_x, last_y, last_q = where(there, x, last_x), where(there, y, last_y), where(there, at_q, last_q)
            some = some | there
        x0, y0, p0, q0 = x1, y1, p1, q1
    return bed


@kernel
def polygon_bed(scene, j, p, q):
    """The bed of joint j, whose section is a polygon that is convex."""
    first, count = index_of(scene.joints.first[j]), index_of(scene.joints.corners[j])
    x, y = _corner(scene.corners, first)
    least_p, least_q = value(p, x, y), value(q, x, y)
    most_p, most_q = least_p, least_q
    for k in range(1, count):
        x, y = _corner(scene.corners, first + k)
        at_p, at_q = value(p, x, y), value(q, x, y)
        least_p, most_p = lesser(least_p, at_p), greater(most_p, at_p)
        least_q, most_q = lesser(least_q, at_q), greater(most_q, at_q)
    some = (most_p > 0.0) & (most_q > 0.0)
    full = some & (least_p >= 0.0) & (least_q >= 0.0)
    bed = chosen(full, whole(scene.joints, j, q, most_q), nothing(p))
    cut = some & opposite(full)
    if any_of(cut):
        bed = chosen(cut, _cut_bed(scene, j, p, q, most_p < least_p), bed)
    return bed
