"""The intersection of discs with other faces in lanes: with discs lane by lane, with polygons in all lanes at once."""

from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import (
    WIDTH,
    LanesType,
    any_of,
    bits,
    greater,
    lane,
    lesser,
    opposite,
    square_root,
    where,
    with_lane,
    zero_like,
)
from ..numba_ext.views import one_lane
from .bed import Bed, Plane, add, chosen, nothing, plane_of_lane, triangle, value
from .clipping import cut
from .disc import slope_of, whole_disc, with_segment
from .placed_face import centre_of, corners_of_faces, is_round, placed, put_corners, rows_of_lane
from .shared_disc import NEARLY, cuts_disc, differ, disc_bed, largest_beside_bores


@by_width
def round_bed_after_slip(scene, j, section, slid, p, q):
    """Return the bed of a section of joint j, of which a face is round; in lanes only where `slid` holds."""
    return _of_lanes if isinstance(p.types[0], LanesType) else _of_one


def _of_one(scene, j, section, slid, p, q):
    return disc_bed(scene.room, scene.corners, scene.slips, j, section.above, section.below, p, q)


def _of_lanes(scene, j, section, slid, p, q):
    # a disc and a polygon
    a, b, _ = corners_of_faces(scene, section.above, section.below)
    if a > 0 or b > 0:
        return _disc_on_polygon(scene, j, section, slid, p, q)
    # two round faces, lane by lane
    found, those = nothing(q), bits(slid)
    for k in range(WIDTH):
        if (those >> k) & 1:
            one = rows_of_lane(scene, k)
            bed = disc_bed(*one, j, section.above, section.below, plane_of_lane(p, k), plane_of_lane(q, k))
            found = Bed(
                with_lane(found.force, k, bed.force),
                with_lane(found.first_x, k, bed.first_x),
                with_lane(found.first_y, k, bed.first_y),
                with_lane(found.area, k, bed.area),
                with_lane(found.largest, k, bed.largest),
            )
    return found


@kernel
def _disc_on_polygon(scene, j, section, slid, p, q):
    """Return the bed of the intersection of a disc, less its bore, and a polygon, with the bits of `disc_bed`.

    slid: mask of the lanes. The pressure cuts the polygon lane by lane; the sum over sides and arcs is over all lanes.
    """
    room, found = scene.room, nothing(q)
    # faces at their present places
    above = placed(scene.corners, section.above, scene.slips, j, 0.5)
    below = placed(scene.corners, section.below, scene.slips, j, -0.5)
    face, other = (above, below) if is_round(above) else (below, above)
    x, y = centre_of(face)
    for hollow in range(2):
        radius, most = face.record.inner if hollow == 1 else face.record.outer, 0
        there = slid & (radius > 0.0)
        if any_of(there):
            # the polygon, cut by the pressure
            most = put_corners(room, other)
            counts = where(there, found.force * 0.0 + float(most), 0.0)
            cut_p, cut_q = bits(there & cuts_disc(p, x, y, radius)), bits(there & cuts_disc(q, x, y, radius))
            cut_q &= bits(differ(p, q))
            for k in range(WIDTH):
                if ((cut_p | cut_q) >> k) & 1:
                    own, count = one_lane(room, k), int(lane(counts, k))
                    if (cut_p >> k) & 1:
                        count = cut(own, count, plane_of_lane(p, k))
                    if (cut_q >> k) & 1:
                        count = cut(own, count, plane_of_lane(q, k))
                    most, counts = max(most, count), with_lane(counts, k, float(count))
            # add the disc, subtract the bore
            part, sign = _of_discs(scene.room, counts, most, x, y, radius, q), -1.0 if hollow == 1 else 1.0
            largest = found.largest if hollow == 1 else part.largest
            if hollow == 1:
                largest = _beside_bores(
                    scene, j, section, there & (found.force + sign * part.force > 0.0), p, q, largest
                )
            found = add(
                found, counts > 0.0, sign * part.area, sign * part.force, sign * part.first_x, sign * part.first_y
            )
            found = Bed(found.force, found.first_x, found.first_y, found.area, largest)
    return chosen(found.force > 0.0, found, nothing(p))


@kernel
def _beside_bores(scene, j, section, those, p, q, outside):
    """Return the largest q of a ring and a polygon in the lanes of a mask, as `largest_beside_bores`."""
    largest, which = outside, bits(those)
    for k in range(WIDTH):
        if (which >> k) & 1:
            room, corners, slips = rows_of_lane(scene, k)
            above, below = placed(corners, section.above, slips, j, 0.5), placed(corners, section.below, slips, j, -0.5)
            planes = plane_of_lane(p, k), plane_of_lane(q, k)
            one = largest_beside_bores(room, above, below, *planes, lane(outside, k))
            largest = with_lane(largest, k, one)
    return largest


@leaf
def _with_triangles(bed, there, q, a, b, c):
    """Add a triangle to a bed in the lanes of a mask, as `_with_triangle` of shared_disc.py."""
    values = value(q, a[0], a[1]), value(q, b[0], b[1]), value(q, c[0], c[1])
    area, force, first_x, first_y = triangle((a[0], b[0], c[0]), (a[1], b[1], c[1]), values)
    largest = greater(bed.largest, greater(values[0], greater(values[1], values[2])))
    bed = add(bed, there, area, force, first_x, first_y)
    return Bed(bed.force, bed.first_x, bed.first_y, bed.area, where(there, largest, bed.largest))


@leaf
def _with_arcs(bed, there, radius, q, begin, end):
    """Add an arc's segment to a bed in the lanes of a mask, as `_with_arc` of shared_disc.py."""
    # normal of the chord, and its distance from the centre
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    length = square_root(dx * dx + dy * dy)
    there = there & (length > 0.0)
    out_x, out_y = dy / length, -dx / length
    off = lesser(greater(0.5 * ((begin[0] + end[0]) * out_x + (begin[1] + end[1]) * out_y), -radius), radius)
    # the largest q if it is on the arc
    slope = slope_of(q)
    tops = there & (slope > 0.0) & (radius * (q.along_x * out_x + q.along_y * out_y) >= off * slope)
    largest = where(tops, greater(bed.largest, q.at + radius * slope), bed.largest)
    bed = with_segment(bed, there, radius, q, out_x, out_y, off)
    return Bed(bed.force, bed.first_x, bed.first_y, bed.area, largest)


@kernel
def _of_discs(room, counts, most, x, y, radius, plane):
    """Return the bed of the intersection of polygons and discs in all lanes, as `_of_disc` of shared_disc.py.

    counts: corners of the polygon of each lane, at most `most`; a lane with 0 has an empty bed.
    """
    # q about the centre of the disc
    q = Plane(value(plane, x, y), plane.along_x, plane.along_y)
    bed, zero = nothing(q), zero_like(x)
    one, there = zero + 1.0, counts > 0.0
    begun, first_cut, was_cut, holds = zero > 0.0, zero > 0.0, zero > 0.0, there
    first, last = (zero, zero), (zero, zero)
    for k in range(most):
        # the side from the centre
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
        # the part of the side within the disc
        off = across / square_root(square)
        middle = -(ax * dx + ay * dy) / square
        half = square_root((radius - off) * (radius + off) / square)
        enters, leaves = greater(middle - half, zero), lesser(middle + half, one)
        side = side & (enters < leaves)
        begin, end = (ax + enters * dx, ay + enters * dy), (ax + leaves * dx, ay + leaves * dy)
        # the first side of a lane, or an arc from the last one
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
    # the last arc
    arcs = begun & (was_cut | first_cut)
    if any_of(arcs):
        bed = _with_arcs(bed, arcs, radius, q, last, first)
    # discs that lie in the polygon
    full = holds & opposite(begun) & (counts > 2.0)
    if any_of(full):
        disc = whole_disc(radius, q)
        top = q.at + radius * slope_of(q)
        bed = chosen(full, Bed(disc.force, disc.first_x, disc.first_y, disc.area, top), bed)
    return Bed(bed.force, bed.first_x + x * bed.force, bed.first_y + y * bed.force, bed.area, bed.largest)
