"""The bed of a polygon: cut by both half-planes, then summed over triangles, exactly."""

from ..numba_ext.jit import kernel, leaf
from .bed import add, highest, nothing, square, triangle, value, whole
from .layout import MOST_CORNERS

ROOM = MOST_CORNERS + 4  # corners of a cut polygon


@leaf
def _corner(corners, place):
    return corners[2 * place], corners[2 * place + 1]


@leaf
def _crossing(x0, y0, f0, x1, y1, f1):
    """Place where a linear function passes zero between two corners, and the part of the way to it."""
    part = f0 / (f0 - f1)
    return part, x0 + part * (x1 - x0), y0 + part * (y1 - y0)


@kernel
def _cut(scene, j, p, q):
    """The part of the section where p is positive, in the scratch: x, y, p, q of each corner. Returns their number."""
    first, count = int(scene.joints.first[j]), int(scene.joints.corners[j])
    x, y, ps, qs = scene.scratch, scene.scratch[ROOM:], scene.scratch[2 * ROOM :], scene.scratch[3 * ROOM :]
    x0, y0 = _corner(scene.corners, first + count - 1)
    p0, q0 = value(p, x0, y0), value(q, x0, y0)
    left = 0
    for k in range(count):
        x1, y1 = _corner(scene.corners, first + k)
        p1, q1 = value(p, x1, y1), value(q, x1, y1)
        if (p0 > 0.0) != (p1 > 0.0):
            part, x[left], y[left] = _crossing(x0, y0, p0, x1, y1, p1)
            ps[left], qs[left] = 0.0, q0 + part * (q1 - q0)
            left += 1
        if p1 > 0.0:
            x[left], y[left], ps[left], qs[left] = x1, y1, p1, q1
            left += 1
        x0, y0, p0, q0 = x1, y1, p1, q1
    return left


@kernel
def _sum(scene, count):
    """The bed of the polygon in the scratch, where q is positive: triangles from its first such corner on."""
    x, y, qs = scene.scratch, scene.scratch[ROOM:], scene.scratch[3 * ROOM :]
    x0, y0, q0 = x[count - 1], y[count - 1], qs[count - 1]
    bed, found = nothing(), 0
    fx, fy, fq = 0.0, 0.0, 0.0
    lx, ly, lq = 0.0, 0.0, 0.0
    for k in range(count):
        x1, y1, q1 = x[k], y[k], qs[k]
        for corner in range(2):
            if corner == 0:
                if (q0 > 0.0) == (q1 > 0.0):
                    continue
                _, cx, cy = _crossing(x0, y0, q0, x1, y1, q1)
                cq = 0.0
            else:
                if not q1 > 0.0:
                    continue
                cx, cy, cq = x1, y1, q1
                bed = highest(bed, q1)
            if found == 0:
                fx, fy, fq = cx, cy, cq
            elif found > 1:
                area, force, first_x, first_y = triangle((fx, lx, cx), (fy, ly, cy), (fq, lq, cq))
                bed = add(bed, area, force, first_x, first_y)
            lx, ly, lq = cx, cy, cq
            found += 1
        x0, y0, q0 = x1, y1, q1
    return bed


@kernel
def polygon_bed(scene, j, p, q):
    """The bed of joint j, whose section is a polygon that is convex."""
    first, count = int(scene.joints.first[j]), int(scene.joints.corners[j])
    least_p, most_p, least_q, most_q = 1.0, -1.0, 1.0, -1.0
    for k in range(count):
        x, y = _corner(scene.corners, first + k)
        at_p, at_q = value(p, x, y), value(q, x, y)
        if k == 0:
            least_p, most_p, least_q, most_q = at_p, at_p, at_q, at_q
        least_p, most_p = min(least_p, at_p), max(most_p, at_p)
        least_q, most_q = min(least_q, at_q), max(most_q, at_q)
    if most_p <= 0.0 or most_q <= 0.0:
        return nothing()
    if least_p >= 0.0 and least_q >= 0.0:
        return whole(scene.joints, j, q, most_q)
    left = _cut(scene, j, p, q)
    return _sum(scene, left) if left > 2 else nothing()


@kernel
def polygon_square(scene, j, p):
    """The integral of p^2 over the part of joint j where p is positive, m4."""
    left = _cut(scene, j, p, p)
    x, y, ps = scene.scratch, scene.scratch[ROOM:], scene.scratch[2 * ROOM :]
    total = 0.0
    for k in range(2, left):
        total += square((x[0], x[k - 1], x[k]), (y[0], y[k - 1], y[k]), (ps[0], ps[k - 1], ps[k]))
    return total
