"""The bed of a joint that has slid: what its two faces still share (theory.md section 13).

Each face moves with its block by half of the slip and twist that friction has given way by. Two polygons share a
polygon. Of two discs, each counts on its side of the line through both rims. So any contact is a sum of convex
polygons, each as a whole or as far as it lies within a disc; pressure cuts them further. Rings count as a disc less its
bore.
"""

import math
from typing import NamedTuple

from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import (
    WIDTH,
    LanesType,
    MaskType,
    any_of,
    bits,
    greater,
    index_of,
    lane,
    lesser,
    opposite,
    square_root,
    where,
    with_lane,
    zero_like,
)
from ..numba_ext.views import numbers_of, one_lane
from .bed import Bed, Plane, add, chosen, nothing, triangle, value
from .disc import round_bed, slope_of, whole_disc, with_segment
from .layout import FACE, JOINTS, MEMORY, ROOM, SHARED
from .polygon import polygon_bed

_face, _joints, _memory, _shared = FACE.over, JOINTS.over, MEMORY.over, SHARED.over
_FACE, _SHARED, _CUT = FACE.beside, SHARED.beside, ROOM // 2
BOX = 2.0  # radii, half the width of the square about a disc that another disc or a pressure cuts
NEARLY = 1.0 - 1e-15  # square of the distance of a chord from the centre, over that of the rim, that is taken as none
NEAR = 1e-14  # of the radius: distance between the centres of discs that are taken as concentric


class _Placed(NamedTuple):
    """A face where its block is: turned by the angle of this sine and cosine, then moved by dx, dy."""

    record: object
    corners: object
    sine: float
    cosine: float
    dx: float
    dy: float


@leaf
def _place(corners, first, slips, j, half):
    """The face at `first` of the corners, moved by `half` of what joint j has slid and twisted."""
    part, sine = corners[index_of(first) :], half * slips.p3[j]
    cosine = square_root(greater(1.0 - sine * sine, 0.0))
    return _Placed(_face(part, 0), part[_FACE:], sine, cosine, half * slips.p1[j], half * slips.p2[j])


@leaf
def _moved(face, x, y):
    return face.dx + (face.cosine * x - face.sine * y), face.dy + (face.sine * x + face.cosine * y)


@leaf
def _corner(face, k):
    """Corner k of a polygon; the one after the last is the first."""
    k = 0 if k >= index_of(face.record.corners) else k
    return _moved(face, face.corners[2 * k], face.corners[2 * k + 1])


@leaf
def _centre(face):
    return _moved(face, face.record.x, face.record.y)


@leaf
def _is_round(face):
    return index_of(face.record.corners) == 0


# --- convex polygons, in `room`: the corners of one, then space for a cut


@kernel
def _outline(room, face):
    """Put the corners of a polygon into the room; returns their number."""
    count = index_of(face.record.corners)
    for k in range(count):
        room[2 * k], room[2 * k + 1] = _corner(face, k)
    return count


@leaf
def _square(room, x, y, half):
    """Put a square about a point into the room; returns the number of its corners."""
    room[0], room[1] = x - half, y - half
    room[2], room[3] = x + half, y - half
    room[4], room[5] = x + half, y + half
    room[6], room[7] = x - half, y + half
    return 4


@kernel
def cut(room, count, plane):
    """Leave the part of the polygon where a linear function is positive; returns the number of its corners."""
    least, most = math.inf, -math.inf
    for k in range(count):
        here = value(plane, room[2 * k], room[2 * k + 1])
        least, most = min(least, here), max(most, here)
    if least > 0.0 or not most > 0.0:
        return count if least > 0.0 else 0
    kept, cut = 0, room[_CUT:]
    x0, y0 = room[2 * count - 2], room[2 * count - 1]
    before = value(plane, x0, y0)
    for k in range(count):
        x1, y1 = room[2 * k], room[2 * k + 1]
        here = value(plane, x1, y1)
        if (before > 0.0) != (here > 0.0):
            part = before / (before - here)
            cut[2 * kept], cut[2 * kept + 1] = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
            kept += 1
        if here > 0.0:
            cut[2 * kept], cut[2 * kept + 1] = x1, y1
            kept += 1
        x0, y0, before = x1, y1, here
    for k in range(2 * kept):
        room[k] = cut[k]
    return kept


@kernel
def _within(room, count, face):
    """Leave what a polygon shares with a face that is another polygon; one that has no end leaves it whole."""
    for k in range(int(face.record.corners)):
        x0, y0 = _corner(face, k)
        x1, y1 = _corner(face, k + 1)
        count = cut(room, count, Plane((y1 - y0) * x0 - (x1 - x0) * y0, y0 - y1, x1 - x0))
    return count


@leaf
def _differ(p, q):
    return (q.at != p.at) | (q.along_x != p.along_x) | (q.along_y != p.along_y)


@leaf
def _cuts_disc(plane, x, y, radius):
    """Whether a linear function passes zero, or is negative, somewhere within a disc."""
    level, square = value(plane, x, y), plane.along_x * plane.along_x + plane.along_y * plane.along_y
    return opposite((level > 0.0) & (level * level >= radius * radius * square))


@leaf
def _pressed_in(room, count, x, y, radius, p, q):
    """Leave the part of a polygon where p and q are positive, as far as that lies within a disc."""
    if _cuts_disc(p, x, y, radius):
        count = cut(room, count, p)
    if _differ(p, q) and _cuts_disc(q, x, y, radius):
        count = cut(room, count, q)
    return count


# --- integrals


@leaf
def _with(bed, sign, part):
    """A bed with another part, or without it."""
    return Bed(
        bed.force + sign * part.force,
        bed.first_x + sign * part.first_x,
        bed.first_y + sign * part.first_y,
        bed.area + sign * part.area,
        max(bed.largest, part.largest) if sign > 0.0 else bed.largest,
    )


@leaf
def _with_triangle(bed, q, a, b, c):
    values = value(q, a[0], a[1]), value(q, b[0], b[1]), value(q, c[0], c[1])
    area, force, first_x, first_y = triangle((a[0], b[0], c[0]), (a[1], b[1], c[1]), values)
    largest = max(bed.largest, max(values[0], max(values[1], values[2])))
    return Bed(bed.force + force, bed.first_x + first_x, bed.first_y + first_y, bed.area + area, largest)


@leaf
def _with_arc(bed, radius, q, begin, end):
    """A bed with the segment of a disc about the origin beyond the chord of an arc, anticlockwise."""
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    length = math.sqrt(dx * dx + dy * dy)
    if length <= 0.0:
        return bed
    out_x, out_y = dy / length, -dx / length
    off = min(max(0.5 * ((begin[0] + end[0]) * out_x + (begin[1] + end[1]) * out_y), -radius), radius)
    largest, slope = bed.largest, slope_of(q)
    if slope > 0.0 and radius * (q.along_x * out_x + q.along_y * out_y) >= off * slope:  # the highest point is on it
        largest = max(largest, q.at + radius * slope)
    bed = with_segment(bed, True, radius, q, out_x, out_y, off)
    return Bed(bed.force, bed.first_x, bed.first_y, bed.area, largest)


@kernel
def _of_disc(room, count, x, y, radius, plane):
    """The bed of the part of the polygon that lies within a disc: its sides there, and arcs between them."""
    q = Plane(value(plane, x, y), plane.along_x, plane.along_y)  # from the centre
    bed, begun, first_cut, was_cut, holds = nothing(q), False, False, False, True
    first, last = (0.0, 0.0), (0.0, 0.0)
    for k in range(count):
        after = k + 1 if k + 1 < count else 0
        ax, ay = room[2 * k] - x, room[2 * k + 1] - y
        dx, dy = room[2 * after] - x - ax, room[2 * after + 1] - y - ay
        square = dx * dx + dy * dy
        if square == 0.0:
            continue
        across = ax * dy - ay * dx  # the side's length times its distance to the right of the centre
        holds = holds and across > 0.0
        if not across * across < NEARLY * radius * radius * square:
            continue
        off = across / math.sqrt(square)
        middle = -(ax * dx + ay * dy) / square
        half = math.sqrt((radius - off) * (radius + off) / square)
        enters, leaves = max(0.0, middle - half), min(1.0, middle + half)
        if enters >= leaves:
            continue
        begin, end = (ax + enters * dx, ay + enters * dy), (ax + leaves * dx, ay + leaves * dy)
        if not begun:
            begun, first, first_cut = True, begin, enters > 0.0
        else:
            bed = _with_triangle(bed, q, first, last, begin)
            if was_cut or enters > 0.0:
                bed = _with_arc(bed, radius, q, last, begin)
        bed = _with_triangle(bed, q, first, begin, end)
        last, was_cut = end, leaves < 1.0
    if begun:
        if was_cut or first_cut:
            bed = _with_arc(bed, radius, q, last, first)
    elif holds and count > 2:
        whole = whole_disc(radius, q)
        bed = Bed(whole.force, whole.first_x, whole.first_y, whole.area, q.at + radius * slope_of(q))
    return Bed(bed.force, bed.first_x + x * bed.force, bed.first_y + y * bed.force, bed.area, bed.largest)


@kernel
def _of_one_disc(room, x, y, radius, other_x, other_y, other, first, p, q):
    """The bed of the part of a disc on its side of the line through both rims: all of it lies in the other disc too.

    first: it is the one of the two that counts where they are equal and concentric.
    """
    dx, dy = other_x - x, other_y - y
    count = _square(room, x, y, BOX * radius)
    if dx * dx + dy * dy <= (NEAR * radius) * (NEAR * radius):
        if radius > other or (radius == other and not first):
            return nothing(q)
    else:  # distance^2 - radius^2 about the own centre less the same about the other one
        more = (other - radius) * (other + radius) - dx * (x + other_x) - dy * (y + other_y)
        count = cut(room, count, Plane(more, 2.0 * dx, 2.0 * dy))
    return _of_disc(room, _pressed_in(room, count, x, y, radius, p, q), x, y, radius, q)


@kernel
def _of_faces(room, above, below, outer_a, outer_b, p, q):
    """The bed of what two faces share, of which one is round; outer: radii of the discs that count, of round faces."""
    if _is_round(above) and _is_round(below):
        (ax, ay), (bx, by) = _centre(above), _centre(below)
        bed = _of_one_disc(room, ax, ay, outer_a, bx, by, outer_b, True, p, q)
        return _with(bed, 1.0, _of_one_disc(room, bx, by, outer_b, ax, ay, outer_a, False, p, q))
    face, other, radius = (above, below, outer_a) if _is_round(above) else (below, above, outer_b)
    x, y = _centre(face)
    return _of_disc(room, _pressed_in(room, _outline(room, other), x, y, radius, p, q), x, y, radius, q)


@kernel
def _bed_of_one(room, joints, corners, slips, j, p, q):
    """The bed of joint j."""
    above, below = _place(corners, joints.above[j], slips, j, 0.5), _place(corners, joints.below[j], slips, j, -0.5)
    bed = nothing(q)
    for k in range(4):  # outer discs, less bores
        hollow_a, hollow_b = k & 1, k >> 1
        a = above.record.inner if hollow_a == 1 else above.record.outer
        b = below.record.inner if hollow_b == 1 else below.record.outer
        if (hollow_a == 1 and a == 0.0) or (hollow_b == 1 and b == 0.0):
            continue
        bed = _with(bed, 1.0 if hollow_a == hollow_b else -1.0, _of_faces(room, above, below, a, b, p, q))
    return bed if bed.force > 0.0 else nothing(q)


@by_width
def _round_bed_after_slip(scene, j, slid, p, q):
    """The bed of joint j, of which a face is round; of lanes of those that have `slid`, one after the other."""
    return _of_lanes if isinstance(p.types[0], LanesType) else _of_one


def _of_one(scene, j, slid, p, q):
    return _bed_of_one(scene.room, scene.joints, scene.corners, scene.slips, j, p, q)


@leaf
def _plane_of_lane(plane, k):
    return Plane(lane(plane.at, k), lane(plane.along_x, k), lane(plane.along_y, k))


def _of_lanes(scene, j, slid, p, q):
    a, b, _ = _corners_of_faces(scene, j)
    if a > 0 or b > 0:
        return _disc_on_polygon(scene, j, slid, p, q)
    found = nothing(q)
    those = bits(slid)
    for k in range(WIDTH):
        if (those >> k) & 1:
            one = _of_lane(scene, k)
            bed = _bed_of_one(*one, j, _plane_of_lane(p, k), _plane_of_lane(q, k))
            found = Bed(
                with_lane(found.force, k, bed.force),
                with_lane(found.first_x, k, bed.first_x),
                with_lane(found.first_y, k, bed.first_y),
                with_lane(found.area, k, bed.area),
                with_lane(found.largest, k, bed.largest),
            )
    return found


@kernel
def _disc_on_polygon(scene, j, slid, p, q):
    """The bed of a disc, less its bore, and a polygon, of the lanes in a mask, with the bits of `_bed_of_one`.

    Pressure cuts the polygon lane by lane; the sum over its sides and arcs is that of all lanes.
    """
    room, found = scene.room, nothing(q)
    above = _place(scene.corners, scene.joints.above[j], scene.slips, j, 0.5)
    below = _place(scene.corners, scene.joints.below[j], scene.slips, j, -0.5)
    face, other = (above, below) if _is_round(above) else (below, above)
    x, y = _centre(face)
    for hollow in range(2):
        radius, most = face.record.inner if hollow == 1 else face.record.outer, 0
        there = slid & (radius > 0.0)
        if any_of(there):
            most = _outline(room, other)
            counts = where(there, found.force * 0.0 + float(most), 0.0)
            cut_p, cut_q = bits(there & _cuts_disc(p, x, y, radius)), bits(there & _cuts_disc(q, x, y, radius))
            cut_q &= bits(_differ(p, q))
            for k in range(WIDTH):
                if ((cut_p | cut_q) >> k) & 1:
                    own, count = one_lane(room, k), int(lane(counts, k))
                    if (cut_p >> k) & 1:
                        count = cut(own, count, _plane_of_lane(p, k))
                    if (cut_q >> k) & 1:
                        count = cut(own, count, _plane_of_lane(q, k))
                    most, counts = max(most, count), with_lane(counts, k, float(count))
            part, sign = _of_discs(scene.room, counts, most, x, y, radius, q), -1.0 if hollow == 1 else 1.0
            largest = found.largest if hollow == 1 else part.largest
            found = add(
                found, counts > 0.0, sign * part.area, sign * part.force, sign * part.first_x, sign * part.first_y
            )
            found = Bed(found.force, found.first_x, found.first_y, found.area, largest)
    return chosen(found.force > 0.0, found, nothing(p))


@leaf
def _with_triangles(bed, there, q, a, b, c):
    """As `_with_triangle`, of the lanes in a mask."""
    values = value(q, a[0], a[1]), value(q, b[0], b[1]), value(q, c[0], c[1])
    area, force, first_x, first_y = triangle((a[0], b[0], c[0]), (a[1], b[1], c[1]), values)
    largest = greater(bed.largest, greater(values[0], greater(values[1], values[2])))
    bed = add(bed, there, area, force, first_x, first_y)
    return Bed(bed.force, bed.first_x, bed.first_y, bed.area, where(there, largest, bed.largest))


@leaf
def _with_arcs(bed, there, radius, q, begin, end):
    """As `_with_arc`, of the lanes in a mask."""
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    length = square_root(dx * dx + dy * dy)
    there = there & (length > 0.0)
    out_x, out_y = dy / length, -dx / length
    off = lesser(greater(0.5 * ((begin[0] + end[0]) * out_x + (begin[1] + end[1]) * out_y), -radius), radius)
    slope = slope_of(q)
    tops = there & (slope > 0.0) & (radius * (q.along_x * out_x + q.along_y * out_y) >= off * slope)
    largest = where(tops, greater(bed.largest, q.at + radius * slope), bed.largest)
    bed = with_segment(bed, there, radius, q, out_x, out_y, off)
    return Bed(bed.force, bed.first_x, bed.first_y, bed.area, largest)


@kernel
def _of_discs(room, counts, most, x, y, radius, plane):
    """As `_of_disc`, of all lanes, where a polygon has `counts` corners, `most` at most; none: nothing."""
    q = Plane(value(plane, x, y), plane.along_x, plane.along_y)
    bed, zero = nothing(q), zero_like(x)
    one, there = zero + 1.0, counts > 0.0
    begun, first_cut, was_cut, holds = zero > 0.0, zero > 0.0, zero > 0.0, there
    first, last = (zero, zero), (zero, zero)
    for k in range(most):
        side, closes = counts > float(k), counts <= float(k + 1)
        ax, ay = room[2 * k] - x, room[2 * k + 1] - y
        after = k + 1 if k + 1 < most else 0
        after_x, after_y = where(closes, room[0], room[2 * after]), where(closes, room[1], room[2 * after + 1])
        dx, dy = after_x - x - ax, after_y - y - ay
        square = dx * dx + dy * dy
        side = side & (square != 0.0)
        across = ax * dy - ay * dx
        holds = holds & (opposite(side) | (across > 0.0))
        side = side & (across * across < NEARLY * radius * radius * square)
        if not any_of(side):
            continue
        off = across / square_root(square)
        middle = -(ax * dx + ay * dy) / square
        half = square_root((radius - off) * (radius + off) / square)
        enters, leaves = greater(middle - half, zero), lesser(middle + half, one)
        side = side & (enters < leaves)
        begin, end = (ax + enters * dx, ay + enters * dy), (ax + leaves * dx, ay + leaves * dy)
        starts, goes_on = side & opposite(begun), side & begun
        first = where(starts, begin[0], first[0]), where(starts, begin[1], first[1])
        first_cut = (starts & (enters > 0.0)) | (opposite(starts) & first_cut)
        if any_of(goes_on):
            bed = _with_triangles(bed, goes_on, q, first, last, begin)
            arcs = goes_on & (was_cut | (enters > 0.0))
            if any_of(arcs):
                bed = _with_arcs(bed, arcs, radius, q, last, begin)
        bed = _with_triangles(bed, side, q, first, begin, end)
        begun, last = begun | side, (where(side, end[0], last[0]), where(side, end[1], last[1]))
        was_cut = (side & (leaves < 1.0)) | (opposite(side) & was_cut)
    arcs = begun & (was_cut | first_cut)
    if any_of(arcs):
        bed = _with_arcs(bed, arcs, radius, q, last, first)
    full = holds & opposite(begun) & (counts > 2.0)
    if any_of(full):
        disc = whole_disc(radius, q)
        top = q.at + radius * slope_of(q)
        bed = chosen(full, Bed(disc.force, disc.first_x, disc.first_y, disc.area, top), bed)
    return Bed(bed.force, bed.first_x + x * bed.force, bed.first_y + y * bed.force, bed.area, bed.largest)


@leaf
def _of_lane(scene, k):
    """Room, which all lanes have in turn, and joints, corners and slips of one lane."""
    joints = _joints(one_lane(scene.joints.row, k), scene.m)
    slips = _memory(one_lane(scene.slips.row, k), scene.m)
    return numbers_of(scene.room), joints, one_lane(scene.corners, k), slips


# --- two polygons, or one on what has no end: their shared polygon is kept until the joint slides on


@kernel
def _share(room, joints, corners, slips, j, shared):
    """Fill in what the faces of joint j share."""
    above, below = _place(corners, joints.above[j], slips, j, 0.5), _place(corners, joints.below[j], slips, j, -0.5)
    count = _within(room, _outline(room, above), below)
    most = int(above.record.corners) + int(below.record.corners)
    found, outline = _shared(shared, 0), shared[_SHARED:]
    found.corners, found.p1, found.p2, found.p3 = most, slips.p1[j], slips.p2[j], slips.p3[j]
    for k in range(most):
        last = max(0, min(k, count - 1))
        outline[2 * k] = room[2 * last] if count > 0 else 0.0
        outline[2 * k + 1] = room[2 * last + 1] if count > 0 else 0.0
    found.area, found.x, found.y, found.xx, found.yy, found.xy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ax, ay = room[0], room[1]
    for k in range(2, count):
        bx, by, cx, cy = room[2 * k - 2], room[2 * k - 1], room[2 * k], room[2 * k + 1]
        area = 0.5 * ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay))
        sx, sy, twelfth = ax + bx + cx, ay + by + cy, area / 12.0
        found.area += area
        found.x += area / 3.0 * sx
        found.y += area / 3.0 * sy
        found.xx += twelfth * (sx * sx + (ax * ax + bx * bx + cx * cx))
        found.yy += twelfth * (sy * sy + (ay * ay + by * by + cy * cy))
        found.xy += twelfth * (sx * sy + (ax * ay + bx * by + cx * cy))


@by_width
def _renew(scene, j, place, stale):
    """Fill in what faces share that have slid on since: of those lanes in `stale`."""
    return _renew_lanes if isinstance(stale, MaskType) else _renew_one


def _renew_one(scene, j, place, stale):
    _share(scene.room, scene.joints, scene.corners, scene.slips, j, scene.shared[place:])


def _renew_lanes(scene, j, place, stale):
    those = bits(stale)
    for k in range(WIDTH):
        if (those >> k) & 1:
            _share(*_of_lane(scene, k), j, one_lane(scene.shared, k)[place:])


@leaf
def _polygon_bed_after_slip(scene, j, slid, count, p, q):
    place = index_of(scene.joints.above[j])
    row, slips = scene.shared[place:], scene.slips
    kept = _shared(row, 0)
    moved = (kept.p1 != slips.p1[j]) | (kept.p2 != slips.p2[j]) | (kept.p3 != slips.p3[j])
    stale = slid & (moved | (kept.corners == 0.0))
    if any_of(stale):
        _renew(scene, j, place, stale)
    force = q.at * kept.area + q.along_x * kept.x + q.along_y * kept.y
    first_x = q.at * kept.x + q.along_x * kept.xx + q.along_y * kept.xy
    first_y = q.at * kept.y + q.along_x * kept.xy + q.along_y * kept.yy
    full = Bed(force, first_x, first_y, kept.area, zero_like(force))
    bed = polygon_bed(row[_SHARED:], 0, count, full, p, q)
    return chosen(kept.area > 0.0, bed, nothing(p))


@leaf
def _moved_disc_bed(scene, j, p, q):
    """The bed of a disc or ring that has slid on what has no end, about half-way to where it was."""
    x, y = 0.5 * scene.slips.p1[j], 0.5 * scene.slips.p2[j]
    bed = round_bed(scene, j, Plane(value(p, x, y), p.along_x, p.along_y), Plane(value(q, x, y), q.along_x, q.along_y))
    return Bed(bed.force, bed.first_x + x * bed.force, bed.first_y + y * bed.force, bed.area, bed.largest)


@leaf
def _corners_of_faces(scene, j):
    """Numbers of corners of both faces of joint j; whether the lower one has no end."""
    above = _face(scene.corners[index_of(scene.joints.above[j]) :], 0)
    below = _face(scene.corners[index_of(scene.joints.below[j]) :], 0)
    return index_of(above.corners), index_of(below.corners), any_of(below.outer == math.inf)


@by_width
def goes_by_faces(scene, j, slid):
    """Whether the bed of joint j is that of what its faces share: in a run alone where it has `slid`.

    In lanes it does wherever it may slide, if they are polygons: both ways of some lanes would cost the others twice.
    """
    return _lanes_go_by_faces if isinstance(slid, MaskType) else lambda scene, j, slid: slid


def _lanes_go_by_faces(scene, j, slid):
    may_slide = scene.joints.friction[j] != math.inf
    if any_of(may_slide):
        a, b, endless = _corners_of_faces(scene, j)
        if a > 0 and (b > 0 or endless):
            return may_slide
    return slid


@leaf
def bed_after_slip(scene, j, slid, p, q):
    """The bed of joint j by what both faces share."""
    a, b, endless = _corners_of_faces(scene, j)
    if a > 0 and (b > 0 or endless):
        return _polygon_bed_after_slip(scene, j, slid, a + b, p, q)
    if endless:
        return _moved_disc_bed(scene, j, p, q)
    return _round_bed_after_slip(scene, j, slid, p, q)
