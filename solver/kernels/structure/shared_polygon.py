"""The intersection of two polygons, or of one and an unbounded face, cached until the joint slides on."""

from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import WIDTH, MaskType, any_of, bits, greater, lesser, magnitude, where, zero_like
from ..numba_ext.views import one_lane
from .bed import Bed, Plane, chosen, nothing, value
from .clipping import cut
from .edges import edge_integrals
from .layout import OF_BOTH, OF_LOWER, OF_UPPER, PER_CORNER, SHARED
from .placed_face import placed, put_corners, rows_of_lane
from .polygon import polygon_bed

_shared, _SHARED = SHARED.over, SHARED.beside
SAME_EDGE = 1e-12  # distance of coincident edges, at most, over the length of one
NEARLY_ALONG = 0.01  # rad: directions this near to that of an edge of both faces


@kernel
def _put_planes(planes, corners, count):
    """Fill `planes` with a linear function for each edge, positive inside, whose slope is the length of the edge."""
    x0, y0 = corners[0], corners[1]
    for k in range(count):
        after = k + 1 if k + 1 < count else 0
        # edge from corner k to the next one
        x1, y1 = corners[2 * after], corners[2 * after + 1]
        planes[3 * k], planes[3 * k + 1], planes[3 * k + 2] = (y1 - y0) * x0 - (x1 - x0) * y0, y0 - y1, x1 - x0
        x0, y0 = x1, y1


@leaf
def _plane(planes, k):
    return Plane(planes[3 * k], planes[3 * k + 1], planes[3 * k + 2])


@kernel
def _is_on_edge(planes, count, x, y):
    """Return True if a point within a polygon lies on one of its edges."""
    for k in range(count):
        plane = _plane(planes, k)
        # the distance from the edge times its length
        square = plane.along_x * plane.along_x + plane.along_y * plane.along_y
        if value(plane, x, y) <= SAME_EDGE * square:
            return True
    return False


@kernel
def _find_owners(shared, most, count, planes, lower):
    """Fill in which face each edge of the intersection belongs to, by the midpoint of the edge.

    most: corners of both faces; count: corners of the intersection; lower: edges of the lower face, whose planes come
    first.
    """
    outline, owners = shared[_SHARED:], shared[_SHARED + 2 * most :]
    x0, y0 = outline[2 * most - 2], outline[2 * most - 1]
    for k in range(most):
        owners[k] = OF_UPPER
        if k < count:
            # midpoint of the edge
            x1, y1 = outline[2 * k], outline[2 * k + 1]
            x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
            if _is_on_edge(planes, lower, x, y):
                owners[k] = OF_BOTH if _is_on_edge(planes[3 * lower :], most - lower, x, y) else OF_LOWER
            x0, y0 = x1, y1


@kernel
def _share(room, corners, slips, j, at_above, at_below, shared):
    """Fill `shared` with the intersection of two faces of joint j; at_above, at_below: their indices in `corners`."""
    above, below = placed(corners, at_above, slips, j, 0.5), placed(corners, at_below, slips, j, -0.5)
    # corners of both faces, and rows behind the record
    lower, upper = int(below.record.corners), int(above.record.corners)
    most = upper + lower
    found, outline, planes = _shared(shared, 0), shared[_SHARED:], shared[_SHARED + 3 * most :]
    # planes of the edges of both faces
    _put_planes(planes, room, put_corners(room, below))
    count = put_corners(room, above)
    if lower > 0:
        _put_planes(planes[3 * lower :], room, count)
    # clip the upper face to the lower one
    for k in range(lower):  # no edge, if it is unbounded
        count = cut(room, count, _plane(planes, k))
    found.corners, found.p1, found.p2, found.p3 = most, slips.p1[j], slips.p2[j], slips.p3[j]
    # corners, the last one repeated
    for k in range(most):
        last = max(0, min(k, count - 1))
        outline[2 * k] = room[2 * last] if count > 0 else 0.0
        outline[2 * k + 1] = room[2 * last + 1] if count > 0 else 0.0
    # integrals over a fan of triangles
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
    if lower > 0:
        _find_owners(shared, most, count, planes, lower)


@by_width
def _renew(scene, j, section, stale):
    """Update the intersection of the faces of a section of joint j, in lanes where `stale` holds."""
    return _renew_lanes if isinstance(stale, MaskType) else _renew_one


def _renew_one(scene, j, section, stale):
    shared = scene.shared[PER_CORNER * section.above :]
    _share(scene.room, scene.corners, scene.slips, j, section.above, section.below, shared)


def _renew_lanes(scene, j, section, stale):
    those = bits(stale)
    for k in range(WIDTH):
        # the intersection of one lane
        if (those >> k) & 1:
            shared = one_lane(scene.shared, k)[PER_CORNER * section.above :]
            _share(*rows_of_lane(scene, k), j, section.above, section.below, shared)


@leaf
def _shared_row(scene, j, section, those):
    """Return the row of the intersection of the faces of a section of joint j, up to date in the lanes of `those`."""
    row, slips = scene.shared[PER_CORNER * section.above :], scene.slips
    kept = _shared(row, 0)
    # lanes whose slips or twist have changed
    moved = (kept.p1 != slips.p1[j]) | (kept.p2 != slips.p2[j]) | (kept.p3 != slips.p3[j])
    stale = those & (moved | (kept.corners == 0.0))
    if any_of(stale):
        _renew(scene, j, section, stale)
    return row


@leaf
def polygon_bed_after_slip(scene, j, section, slid, count, p, q):
    """Return the bed of a section of joint j by the intersection of its faces, which have `count` corners together.

    slid: mask of the lanes that have.
    """
    row = _shared_row(scene, j, section, slid)
    kept = _shared(row, 0)
    # full contact
    force = q.at * kept.area + q.along_x * kept.x + q.along_y * kept.y
    first_x = q.at * kept.x + q.along_x * kept.xx + q.along_y * kept.xy
    first_y = q.at * kept.y + q.along_x * kept.xy + q.along_y * kept.yy
    full = Bed(force, first_x, first_y, kept.area, zero_like(force))
    bed = polygon_bed(row[_SHARED:], count, full, p, q)
    return chosen(kept.area > 0.0, bed, nothing(p))


@leaf
def _part_of_lower(dx, dy, x, y):
    """Return the part of an edge dx, dy of both faces that belongs to the lower one as the upper one moves by x, y.

    It is 1 outwards and 0 inwards. Along the edge it is continuous: with a jump there the push across would change its
    sign at every step of a joint that slides along its edges.
    """
    most = NEARLY_ALONG * (magnitude(dx) + magnitude(dy)) * (magnitude(x) + magnitude(y))
    outwards = where(most > 0.0, (dy * x - dx * y) / where(most > 0.0, most, 1.0), 0.0)
    return 0.5 + 0.5 * lesser(greater(outwards, -1.0), 1.0)


@kernel
def polygon_edges_of_lower(scene, j, section, those, count, p, way):
    """Integrate p^2 n along the edges of the lower face that bound the intersection of two polygons.

    If edges of both faces coincide, the edge belongs to the lower face where the upper one moves outwards, half of it
    where that moves along the edge.

    Parameters
    ----------
    section : Section
        Section of joint j.
    those : mask
        Lanes that need the integral.
    count : int
        Corners of both faces together.
    p : Plane
        Penetration, m.
    way : tuple
        Direction of motion of the upper block, m, m and rad.

    Returns
    -------
    along_x, along_y, moment : float or lanes
        Integral of p^2 n, m3, and its moment, m4.
    """
    row, zero = _shared_row(scene, j, section, those), zero_like(p.at)
    outline, owners = row[_SHARED:], row[_SHARED + 2 * count :]
    along_x, along_y, moment = zero, zero, zero
    # from the last corner around
    x0, y0 = outline[2 * count - 2], outline[2 * count - 1]
    for k in range(count):
        x1, y1 = outline[2 * k], outline[2 * k + 1]
        owner = owners[k]
        if any_of(owner >= OF_BOTH):
            # an edge that may belong to the lower face
            dx, dy = x1 - x0, y1 - y0
            edge_x, edge_y, edge_moment, x, y = edge_integrals(x0, y0, dx, dy, p)
            part = where(owner == OF_LOWER, 1.0, 0.0)
            both = owner == OF_BOTH
            if any_of(both):
                part = where(both, _part_of_lower(dx, dy, way[0] - way[2] * y, way[1] + way[2] * x), part)
            along_x += part * edge_x
            along_y += part * edge_y
            moment += part * edge_moment
        x0, y0 = x1, y1
    return along_x, along_y, moment
