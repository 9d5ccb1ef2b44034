"""The intersection of discs with other faces in lanes: with discs lane by lane, with polygons in all lanes at once."""

from ..numba_ext.jit import by_width, kernel
from ..numba_ext.lanes import (
    WIDTH,
    LanesType,
    any_of,
    bits,
    lane,
    where,
    with_lane,
)
from ..numba_ext.views import one_lane
from .bed import Bed, add, chosen, nothing, plane_of_lane
from .clipping import cut
from .placed_face import centre_of, corners_of_faces, is_round, placed, put_corners, rows_of_lane
from .shared_disc import cuts_disc, differ, disc_bed, largest_beside_bores, of_disc


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
            part, sign = of_disc(scene.room, counts, most, x, y, radius, q), -1.0 if hollow == 1 else 1.0
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
