"""What a disc or a ring shares with another one, or with a polygon.

Of two discs, each counts on its side of the line through both rims. So it is a sum of convex polygons, each as far as
it lies within a disc; pressure cuts them further. Rings count as a disc less its bore.
"""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import opposite
from .bed import Bed, Plane, nothing, triangle, value
from .clipping import cut, put_square
from .disc import slope_of, whole_disc, with_segment
from .edges import edge_integrals
from .placed_face import centre_of, is_round, placed, put_corners

BOX = 2.0  # radii, half the width of the square about a disc that another disc or a pressure cuts
NEARLY = 1.0 - 1e-15  # square of the distance of a chord from the centre, over that of the rim, that is taken as none
NOWHERE = (0.0, 0.0, 0.0)
NEAR = 1e-14  # of the radius: distance between the centres of discs that are taken as concentric


@leaf
def differ(p, q):
    """Whether two linear functions are not the same."""
    return (q.at != p.at) | (q.along_x != p.along_x) | (q.along_y != p.along_y)


@leaf
def cuts_disc(plane, x, y, radius):
    """Whether a linear function passes zero, or is negative, somewhere within a disc."""
    level, square = value(plane, x, y), plane.along_x * plane.along_x + plane.along_y * plane.along_y
    return opposite((level > 0.0) & (level * level >= radius * radius * square))


@leaf
def _pressed_in(room, count, x, y, radius, p, q):
    """Leave the part of a polygon where p and q are positive, as far as that lies within a disc."""
    if cuts_disc(p, x, y, radius):
        count = cut(room, count, p)
    if differ(p, q) and cuts_disc(q, x, y, radius):
        count = cut(room, count, q)
    return count


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


@leaf
def _are_concentric(x, y, radius, other_x, other_y):
    dx, dy = other_x - x, other_y - y
    return dx * dx + dy * dy <= (NEAR * radius) * (NEAR * radius)


@kernel
def _put_own_side(room, x, y, radius, other_x, other_y, other):
    """Put a polygon into the room that leaves the part of a disc on its side of the line through both rims.

    All of this part lies in the other disc too. Returns the number of corners: of concentric discs the larger one has
    no part, and each of two equal ones is whole.
    """
    count = put_square(room, x, y, BOX * radius)
    if _are_concentric(x, y, radius, other_x, other_y):
        return 0 if radius > other else count
    dx, dy = other_x - x, other_y - y  # distance^2 - radius^2 about the own centre less the same about the other one
    more = (other - radius) * (other + radius) - dx * (x + other_x) - dy * (y + other_y)
    return cut(room, count, Plane(more, 2.0 * dx, 2.0 * dy))


@kernel
def _sides_in_disc(room, count, x, y, radius, p, q):
    """Integrate p q n along the sides of the polygon in the room, as far as they lie within a disc."""
    along_x, along_y, moment = 0.0, 0.0, 0.0
    for k in range(count):
        after = k + 1 if k + 1 < count else 0
        ax, ay = room[2 * k] - x, room[2 * k + 1] - y
        dx, dy = room[2 * after] - x - ax, room[2 * after + 1] - y - ay
        square, across = dx * dx + dy * dy, ax * dy - ay * dx
        if not across * across < NEARLY * radius * radius * square:
            continue
        middle, half = -(ax * dx + ay * dy) / square, math.sqrt(radius * radius * square - across * across) / square
        enters, leaves = max(0.0, middle - half), min(1.0, middle + half)
        if enters < leaves:
            x0, y0, part = room[2 * k] + enters * dx, room[2 * k + 1] + enters * dy, leaves - enters
            side = edge_integrals(x0, y0, part * dx, part * dy, p, q)
            along_x, along_y, moment = along_x + side[0], along_y + side[1], moment + side[2]
    return along_x, along_y, moment


@leaf
def _along_arcs(p, bed, sides):
    """Integrate p q n along the arcs about a part of a disc, by the divergence theorem.

    bed: of that part; sides: the integral along its straight sides. An integral over its area of p times a slope of q
    is taken as that of q times the slope of p, which it is where both are in proportion.
    """
    turning = p.along_y * bed.first_x - p.along_x * bed.first_y
    along_x, along_y = 2.0 * p.along_x * bed.force - sides[0], 2.0 * p.along_y * bed.force - sides[1]
    return along_x, along_y, 2.0 * turning - sides[2]


@kernel
def _of_one_disc(room, x, y, radius, other_x, other_y, other, first, p, q):
    """The bed of the part of a disc on its side of the line through both rims, and p q n along its arcs.

    first: it is the one of the two that counts where they are equal and concentric.
    """
    if radius == other and not first and _are_concentric(x, y, radius, other_x, other_y):
        return nothing(q), NOWHERE
    count = _put_own_side(room, x, y, radius, other_x, other_y, other)
    count = _pressed_in(room, count, x, y, radius, p, q)
    bed = _of_disc(room, count, x, y, radius, q)
    return bed, NOWHERE if first else _along_arcs(p, bed, _sides_in_disc(room, count, x, y, radius, p, q))


@kernel
def _of_faces(room, above, below, outer_a, outer_b, p, q):
    """The bed of what two faces share, of which one is round; outer: radii of the discs that count, of round faces.

    Of two round ones also the integral of p q n along the edges of the lower one.
    """
    if is_round(above) and is_round(below):
        (ax, ay), (bx, by) = centre_of(above), centre_of(below)
        bed, _ = _of_one_disc(room, ax, ay, outer_a, bx, by, outer_b, True, p, q)
        part, edges = _of_one_disc(room, bx, by, outer_b, ax, ay, outer_a, False, p, q)
        return _with(bed, 1.0, part), edges
    face, other, radius = (above, below, outer_a) if is_round(above) else (below, above, outer_b)
    x, y = centre_of(face)
    count = _pressed_in(room, put_corners(room, other), x, y, radius, p, q)
    return _of_disc(room, count, x, y, radius, q), NOWHERE


@kernel
def disc_bed(room, corners, slips, j, at_above, at_below, p, q):
    """Return the bed of two faces of joint j, which lie at these places of the corners.

    Of two round faces also the integral of p q n along the edges of the lower one.
    """
    above, below = placed(corners, at_above, slips, j, 0.5), placed(corners, at_below, slips, j, -0.5)
    bed, along_x, along_y, moment = nothing(q), 0.0, 0.0, 0.0
    for k in range(4):  # outer discs, less bores
        hollow_a, hollow_b = k & 1, k >> 1
        a = above.record.inner if hollow_a == 1 else above.record.outer
        b = below.record.inner if hollow_b == 1 else below.record.outer
        if (hollow_a == 1 and a == 0.0) or (hollow_b == 1 and b == 0.0):
            continue
        sign = 1.0 if hollow_a == hollow_b else -1.0
        part, edges = _of_faces(room, above, below, a, b, p, q)
        bed = _with(bed, sign, part)
        along_x, along_y, moment = along_x + sign * edges[0], along_y + sign * edges[1], moment + sign * edges[2]
    return bed if bed.force > 0.0 else nothing(q), (along_x, along_y, moment)


@kernel
def _edges_of_lower(room, above, below, outer_a, outer_b, p, q, way):
    """Integrate p q n along the boundary of what two faces share, as far as it is an edge of the lower face."""
    bx, by = centre_of(below)
    if is_round(below):
        if is_round(above):
            ax, ay = centre_of(above)
            count = _put_own_side(room, bx, by, outer_b, ax, ay, outer_a)
            if outer_a == outer_b and _are_concentric(bx, by, outer_b, ax, ay):  # half of it by the way
                count = cut(room, count, Plane(-(way[0] * bx + way[1] * by), way[0], way[1]))
        else:
            count = put_corners(room, above)
        count = _pressed_in(room, count, bx, by, outer_b, p, q)
        bed = _of_disc(room, count, bx, by, outer_b, q)
        return _along_arcs(p, bed, _sides_in_disc(room, count, bx, by, outer_b, p, q))
    x, y = centre_of(above)
    count = _pressed_in(room, put_corners(room, below), x, y, outer_a, p, q)
    return _sides_in_disc(room, count, x, y, outer_a, p, q)


@kernel
def disc_edges_of_lower(room, corners, slips, j, at_above, at_below, p, q, way):
    """Integrate p q n along the edges of the lower face that bound what two faces of joint j share.

    As `polygon_edges_of_lower`, where a face is round.
    """
    above, below = placed(corners, at_above, slips, j, 0.5), placed(corners, at_below, slips, j, -0.5)
    along_x, along_y, moment = 0.0, 0.0, 0.0
    for k in range(4):  # outer discs, less bores
        hollow_a, hollow_b = k & 1, k >> 1
        a = above.record.inner if hollow_a == 1 else above.record.outer
        b = below.record.inner if hollow_b == 1 else below.record.outer
        if (hollow_a == 1 and a == 0.0) or (hollow_b == 1 and b == 0.0):
            continue
        sign = 1.0 if hollow_a == hollow_b else -1.0
        part = _edges_of_lower(room, above, below, a, b, p, q, way)
        along_x, along_y, moment = along_x + sign * part[0], along_y + sign * part[1], moment + sign * part[2]
    return along_x, along_y, moment
