"""The intersection of a disc or ring with another one, or with a polygon, and its bed.

Two intersecting discs are each cut at their radical axis. So the bed is a sum over convex polygons, each clipped to a
disc; the pressure cuts them further. A ring is a disc less its bore.
"""

import math

from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import LanesType, any_of, greater, lesser, opposite, square_root, where, zero_like
from .bed import Bed, Plane, chosen, nothing, value
from .clipping import cut, put_square
from .disc import SHORT, slope_of, whole_disc, with_segment, with_triangle
from .edges import edge_integrals
from .placed_face import centre_of, is_round, placed, put_corners

BOX = 2.0  # half width of the square about a disc, over its radius
NEARLY = 1.0 - 1e-15  # squared distance of a chord from the centre, over the squared radius, from which there is none
NEAR = 1e-14  # distance of the centres of concentric discs, at most, over the radius
WITHIN = 1.0 + 1e-9  # factor on the radii of a ring that has a point of its edge


@leaf
def differ(p, q):
    """Return the mask of where two linear functions differ."""
    return (q.at != p.at) | (q.along_x != p.along_x) | (q.along_y != p.along_y)


@leaf
def cuts_disc(plane, x, y, radius):
    """Return the mask of where a linear function is zero or negative somewhere in the disc about (x, y)."""
    level, square = value(plane, x, y), plane.along_x * plane.along_x + plane.along_y * plane.along_y
    return opposite((level > 0.0) & (level * level >= radius * radius * square))


@leaf
def _pressed_in(room, count, x, y, radius, p, q):
    """Clip the polygon in the room to where p and q are positive, unless they are so in the whole disc.

    Return the number of its corners.
    """
    # each line that crosses the disc
    if cuts_disc(p, x, y, radius):
        count = cut(room, count, p)
    if differ(p, q) and cuts_disc(q, x, y, radius):
        count = cut(room, count, q)
    return count


@leaf
def _add_bed(bed, sign, part):
    """Return a bed plus sign times that of another part; the largest q grows only by an added part."""
    return Bed(
        bed.force + sign * part.force,
        bed.first_x + sign * part.first_x,
        bed.first_y + sign * part.first_y,
        bed.area + sign * part.area,
        max(bed.largest, part.largest) if sign > 0.0 else bed.largest,
    )


@leaf
def _with_arc(bed, there, radius, q, begin, end):
    """Add to a bed the circular segment between an arc, anticlockwise from `begin` to `end`, and its chord.

    there: mask of where. The disc is about the origin.
    """
    # normal of the chord, and its distance from the centre; points that differ by rounding alone have no arc
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    length = square_root(dx * dx + dy * dy)
    there = there & (length > SHORT * radius)
    if not any_of(there):
        return bed
    out_x, out_y = dy / length, -dx / length
    off = lesser(greater(0.5 * ((begin[0] + end[0]) * out_x + (begin[1] + end[1]) * out_y), -radius), radius)
    # the largest q if it is on the arc
    slope = slope_of(q)
    tops = there & (slope > 0.0) & (radius * (q.along_x * out_x + q.along_y * out_y) >= off * slope)
    largest = where(tops, greater(bed.largest, q.at + radius * slope), bed.largest)
    bed = with_segment(bed, there, radius, q, out_x, out_y, off)
    return Bed(bed.force, bed.first_x, bed.first_y, bed.area, largest)


@by_width
def _corner_after(room, count, most, k):
    """Return the corner after corner k of a polygon, in lanes each of `count` corners, of at most `most`."""
    return _after_in_lanes if isinstance(count, LanesType) else _after_in_one


def _after_in_lanes(room, count, most, k):
    after, closes = k + 1 if k + 1 < most else 0, count <= float(k + 1)
    return where(closes, room[0], room[2 * after]), where(closes, room[1], room[2 * after + 1])


def _after_in_one(room, count, most, k):
    after = k + 1 if k + 1 < most else 0
    return room[2 * after], room[2 * after + 1]


@kernel
def of_disc(room, count, most, x, y, radius, plane):
    """Return the bed of the intersection of the polygon in the room and a disc about (x, y).

    It is the sum over its sides, and arcs between them.

    Parameters
    ----------
    room : array
        The corners of the polygon, of each lane or alone.
    count : float or lanes
        Number of corners; without any the bed is empty.
    most : int
        The largest number of corners.
    x, y, radius : float or lanes
        Centre and radius of the disc, m.
    plane : Plane
        Damped penetration, m.
    """
    # q about the centre of the disc
    q = Plane(value(plane, x, y), plane.along_x, plane.along_y)
    bed, zero = nothing(q), zero_like(x)
    one, holds = zero + 1.0, count > 0.0
    begun, first, last = zero > 0.0, (zero, zero), (zero, zero)
    for k in range(most):
        # the side from the centre
        ax, ay = room[2 * k] - x, room[2 * k + 1] - y
        after_x, after_y = _corner_after(room, count, most, k)
        dx, dy = after_x - x - ax, after_y - y - ay
        square = dx * dx + dy * dy
        side = (count > float(k)) & (square != 0.0)
        across = ax * dy - ay * dx  # the length of the side times the distance of the centre to its left
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
        if not any_of(side):
            continue
        begin, end = (ax + enters * dx, ay + enters * dy), (ax + leaves * dx, ay + leaves * dy)
        # the first side, or an arc from the last one
        starts, goes_on = side & opposite(begun), side & begun
        first = where(starts, begin[0], first[0]), where(starts, begin[1], first[1])
        if any_of(goes_on):
            bed = with_triangle(bed, goes_on, q, first, last, begin)
            bed = _with_arc(bed, goes_on, radius, q, last, begin)
        bed = with_triangle(bed, side, q, first, begin, end)
        highest = greater(bed.largest, greater(value(q, begin[0], begin[1]), value(q, end[0], end[1])))
        largest = where(side, highest, bed.largest)
        bed = Bed(bed.force, bed.first_x, bed.first_y, bed.area, largest)
        begun, last = begun | side, (where(side, end[0], last[0]), where(side, end[1], last[1]))
    # the last arc
    if any_of(begun):
        bed = _with_arc(bed, begun, radius, q, last, first)
    # or the whole disc lies in the polygon
    full = holds & opposite(begun) & (count > 2.0)
    if any_of(full):
        disc = whole_disc(radius, q)
        top = q.at + radius * slope_of(q)
        bed = chosen(full, Bed(disc.force, disc.first_x, disc.first_y, disc.area, top), bed)
    return Bed(bed.force, bed.first_x + x * bed.force, bed.first_y + y * bed.force, bed.area, bed.largest)


@leaf
def _are_concentric(x, y, radius, other_x, other_y):
    dx, dy = other_x - x, other_y - y
    return dx * dx + dy * dy <= (NEAR * radius) * (NEAR * radius)


@kernel
def _put_own_side(room, x, y, radius, other_x, other_y, other):
    """Fill the room with a polygon that clips a disc to its side of the radical axis; return the number of its corners.

    All of this part lies in the other disc too. Of concentric discs the larger one has no part, and each of two equal
    ones is whole.
    """
    count = put_square(room, x, y, BOX * radius)
    # concentric discs have no radical axis
    if _are_concentric(x, y, radius, other_x, other_y):
        return 0 if radius > other else count
    dx, dy = other_x - x, other_y - y  # radical axis: equal distance^2 - radius^2
    more = (other - radius) * (other + radius) - dx * (x + other_x) - dy * (y + other_y)
    return cut(room, count, Plane(more, 2.0 * dx, 2.0 * dy))


@kernel
def _sides_in_disc(room, count, x, y, radius, p):
    """Integrate p^2 n along the sides of the polygon in the room within a disc about (x, y)."""
    along_x, along_y, moment = 0.0, 0.0, 0.0
    for k in range(count):
        after = k + 1 if k + 1 < count else 0
        # a side of the polygon, from the centre of the disc
        ax, ay = room[2 * k] - x, room[2 * k + 1] - y
        dx, dy = room[2 * after] - x - ax, room[2 * after + 1] - y - ay
        square, across = dx * dx + dy * dy, ax * dy - ay * dx
        # sides beyond the disc
        if not across * across < NEARLY * radius * radius * square:
            continue
        # the part of the side within the disc
        middle, half = -(ax * dx + ay * dy) / square, math.sqrt(radius * radius * square - across * across) / square
        enters, leaves = max(0.0, middle - half), min(1.0, middle + half)
        if enters < leaves:
            x0, y0, part = room[2 * k] + enters * dx, room[2 * k + 1] + enters * dy, leaves - enters
            side = edge_integrals(x0, y0, part * dx, part * dy, p)
            along_x, along_y, moment = along_x + side[0], along_y + side[1], moment + side[2]
    return along_x, along_y, moment


@leaf
def _along_arcs(p, bed, sides):
    """Integrate p^2 n along the arcs of a part of a disc, by the divergence theorem.

    bed: of that part without damping; sides: the integral along its straight sides.
    """
    turning = p.along_y * bed.first_x - p.along_x * bed.first_y
    along_x, along_y = 2.0 * p.along_x * bed.force - sides[0], 2.0 * p.along_y * bed.force - sides[1]
    return along_x, along_y, 2.0 * turning - sides[2]


@kernel
def _of_one_disc(room, x, y, radius, other_x, other_y, other, first, p, q):
    """Return the bed of the part of a disc on its side of the radical axis.

    first: True of the disc that counts if both are equal and concentric.
    """
    # equal concentric discs count once
    if radius == other and not first and _are_concentric(x, y, radius, other_x, other_y):
        return nothing(q)
    # the part of the disc on its side, clipped to where it is pressed
    count = _put_own_side(room, x, y, radius, other_x, other_y, other)
    count = _pressed_in(room, count, x, y, radius, p, q)
    return of_disc(room, float(count), count, x, y, radius, q)


@kernel
def _of_faces(room, above, below, outer_a, outer_b, p, q):
    """Return the bed of the intersection of two faces, one of them round.

    outer_a, outer_b: radii of the discs, m, of round faces.
    """
    if is_round(above) and is_round(below):
        # two discs, each on its side of the radical axis
        (ax, ay), (bx, by) = centre_of(above), centre_of(below)
        bed = _of_one_disc(room, ax, ay, outer_a, bx, by, outer_b, True, p, q)
        return _add_bed(bed, 1.0, _of_one_disc(room, bx, by, outer_b, ax, ay, outer_a, False, p, q))
    # a disc and a polygon
    face, other, radius = (above, below, outer_a) if is_round(above) else (below, above, outer_b)
    x, y = centre_of(face)
    count = _pressed_in(room, put_corners(room, other), x, y, radius, p, q)
    return of_disc(room, float(count), count, x, y, radius, q)


# --- the largest pressure over a bore


@leaf
def _is_on_ring(face, x, y):
    """Return True if a point lies on a ring or disc, or on its edge."""
    cx, cy = centre_of(face)
    square = (x - cx) * (x - cx) + (y - cy) * (y - cy)
    outer, inner = WITHIN * face.record.outer, face.record.inner
    return square <= outer * outer and square * (WITHIN * WITHIN) >= inner * inner


@leaf
def _is_on(room, count, face, x, y):
    """Return True if a point lies on a face; of a polygon with the corners in the room."""
    if is_round(face):
        return _is_on_ring(face, x, y)
    for k in range(count):
        after = k + 1 if k + 1 < count else 0
        ax, ay = room[2 * k] - x, room[2 * k + 1] - y
        bx, by = room[2 * after] - x, room[2 * after + 1] - y
        if ax * by - ay * bx < 0.0:
            return False
    return True


@leaf
def _or_there(largest, ring, p, q, x, y):
    """Return the larger one of `largest` and of q at a point on a ring; infinity if q is larger where p is negative."""
    there = value(q, x, y)
    if not there > largest or not _is_on_ring(ring, x, y):
        return largest
    return there if value(p, x, y) >= 0.0 else math.inf


@kernel
def _largest_on_side(largest, ring, radius, p, q, x, y, dx, dy):
    """Return `largest`, or q where a side from (x, y) along (dx, dy) crosses a circle of a ring, if it is larger."""
    cx, cy = centre_of(ring)
    square, middle = dx * dx + dy * dy, (cx - x) * dx + (cy - y) * dy
    left = middle * middle - square * ((x - cx) * (x - cx) + (y - cy) * (y - cy) - radius * radius)
    if square > 0.0 and left >= 0.0:
        for way in (-1.0, 1.0):
            part = (middle + way * math.sqrt(left)) / square
            if 0.0 <= part <= 1.0:
                largest = _or_there(largest, ring, p, q, x + part * dx, y + part * dy)
    return largest


@kernel
def _largest_at_crossings(largest, ring, other, radius, other_radius, p, q):
    """Return `largest`, or q where circles of two rings cross on both of them, if it is larger."""
    (ax, ay), (bx, by) = centre_of(ring), centre_of(other)
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    if radius > 0.0 and other_radius > 0.0 and square > 0.0:
        # along the line of centres, and across it
        part = 0.5 * (square + (radius - other_radius) * (radius + other_radius)) / square
        left = radius * radius / square - part * part
        if left >= 0.0:
            for way in (-1.0, 1.0):
                across = way * math.sqrt(left)
                x, y = ax + part * dx - across * dy, ay + part * dy + across * dx
                if _is_on_ring(other, x, y):
                    largest = _or_there(largest, ring, p, q, x, y)
    return largest


@kernel
def largest_beside_bores(room, above, below, p, q, outside):
    """Return the largest q (m) over the intersection of two faces with a bore, at most that without bores, `outside`.

    A linear function is largest at the top of an outer circle, at a corner or where two edges cross: at a bore alone it
    grows along the edge. Where q is uniform, or larger beyond the line p = 0, the answer is `outside`.
    """
    ring, other = (above, below) if is_round(above) else (below, above)
    count, largest, slope = 0 if is_round(other) else put_corners(room, other), 0.0, slope_of(q)
    if not slope > 0.0:
        return outside
    # tops of the outer circles
    for k in range(2):
        face = ring if k == 0 else other
        if is_round(face):
            x, y = centre_of(face)
            x, y = x + face.record.outer * q.along_x / slope, y + face.record.outer * q.along_y / slope
            if _is_on(room, count, other, x, y):
                largest = _or_there(largest, ring, p, q, x, y)
    # where circles cross
    radii = ring.record.outer, ring.record.inner
    if is_round(other):
        for radius in radii:
            largest = _largest_at_crossings(largest, ring, other, radius, other.record.outer, p, q)
            largest = _largest_at_crossings(largest, ring, other, radius, other.record.inner, p, q)
    # or corners of a polygon, and where its sides cross circles
    for i in range(count):
        after = i + 1 if i + 1 < count else 0
        x, y = room[2 * i], room[2 * i + 1]
        dx, dy = room[2 * after] - x, room[2 * after + 1] - y
        largest = _or_there(largest, ring, p, q, x, y)
        for radius in radii:
            largest = _largest_on_side(largest, ring, radius, p, q, x, y, dx, dy)
    return min(largest, outside) if largest > 0.0 else outside


@kernel
def disc_bed(room, corners, slips, j, at_above, at_below, p, q):
    """Return the bed of two faces of joint j, one of them round; at_above, at_below: their indices in `corners`."""
    above, below = placed(corners, at_above, slips, j, 0.5), placed(corners, at_below, slips, j, -0.5)
    bed = nothing(q)
    for k in range(4):  # outer discs and bores
        # inclusion and exclusion: positive for two discs or two bores, negative for a disc and a bore
        hollow_a, hollow_b = k & 1, k >> 1
        a = above.record.inner if hollow_a == 1 else above.record.outer
        b = below.record.inner if hollow_b == 1 else below.record.outer
        if (hollow_a == 1 and a == 0.0) or (hollow_b == 1 and b == 0.0):
            continue
        sign = 1.0 if hollow_a == hollow_b else -1.0
        # add or subtract the bed
        bed = _add_bed(bed, sign, _of_faces(room, above, below, a, b, p, q))
    if not bed.force > 0.0:
        return nothing(q)
    # the point with the largest q may lie in a bore
    if above.record.inner > 0.0 or below.record.inner > 0.0:
        largest = largest_beside_bores(room, above, below, p, q, bed.largest)
        bed = Bed(bed.force, bed.first_x, bed.first_y, bed.area, largest)
    return bed


@kernel
def _edges_of_lower(room, above, below, outer_a, outer_b, p, way):
    """Integrate p^2 n along the boundary of the intersection of two faces, where it is an edge of the lower one.

    outer_a, outer_b: radii of the discs, m, of round faces; way: direction of motion of the upper block.
    """
    bx, by = centre_of(below)
    # the lower face is a disc: arcs
    if is_round(below):
        if is_round(above):
            ax, ay = centre_of(above)
            count = _put_own_side(room, bx, by, outer_b, ax, ay, outer_a)
            if outer_a == outer_b and _are_concentric(bx, by, outer_b, ax, ay):  # half of the rim, by the motion
                count = cut(room, count, Plane(-(way[0] * bx + way[1] * by), way[0], way[1]))
        else:
            count = put_corners(room, above)
        count = _pressed_in(room, count, bx, by, outer_b, p, p)
        bed = of_disc(room, float(count), count, bx, by, outer_b, p)
        return _along_arcs(p, bed, _sides_in_disc(room, count, bx, by, outer_b, p))
    # the lower face is a polygon: its sides in the disc
    x, y = centre_of(above)
    count = _pressed_in(room, put_corners(room, below), x, y, outer_a, p, p)
    return _sides_in_disc(room, count, x, y, outer_a, p)


@kernel
def disc_edges_of_lower(room, corners, slips, j, at_above, at_below, p, way):
    """Integrate p^2 n along the edges of the lower face that bound the intersection of two faces of joint j.

    As `polygon_edges_of_lower`, where a face is round.
    """
    above, below = placed(corners, at_above, slips, j, 0.5), placed(corners, at_below, slips, j, -0.5)
    along_x, along_y, moment = 0.0, 0.0, 0.0
    for k in range(4):  # outer discs and bores
        # inclusion and exclusion: positive for two discs or two bores, negative for a disc and a bore
        hollow_a, hollow_b = k & 1, k >> 1
        a = above.record.inner if hollow_a == 1 else above.record.outer
        b = below.record.inner if hollow_b == 1 else below.record.outer
        if (hollow_a == 1 and a == 0.0) or (hollow_b == 1 and b == 0.0):
            continue
        sign = 1.0 if hollow_a == hollow_b else -1.0
        # add or subtract the integrals
        part = _edges_of_lower(room, above, below, a, b, p, way)
        along_x, along_y, moment = along_x + sign * part[0], along_y + sign * part[1], moment + sign * part[2]
    return along_x, along_y, moment
