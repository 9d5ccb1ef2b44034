"""The polygon that two polygons share, or one and what has no end: it is kept until the joint slides on."""

from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import WIDTH, MaskType, any_of, bits, index_of, zero_like
from ..numba_ext.views import one_lane
from .bed import Bed, Plane, chosen, nothing
from .clipping import cut
from .layout import SHARED
from .placed_face import corner_of, placed, put_corners, rows_of_lane
from .polygon import polygon_bed

_shared, _SHARED = SHARED.over, SHARED.beside


@kernel
def _within(room, count, face):
    """Leave what a polygon shares with a face that is another polygon; one that has no end leaves it whole."""
    for k in range(int(face.record.corners)):
        x0, y0 = corner_of(face, k)
        x1, y1 = corner_of(face, k + 1)
        count = cut(room, count, Plane((y1 - y0) * x0 - (x1 - x0) * y0, y0 - y1, x1 - x0))
    return count


@kernel
def _share(room, joints, corners, slips, j, shared):
    """Fill in what the faces of joint j share."""
    above, below = placed(corners, joints.above[j], slips, j, 0.5), placed(corners, joints.below[j], slips, j, -0.5)
    count = _within(room, put_corners(room, above), below)
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
            _share(*rows_of_lane(scene, k), j, one_lane(scene.shared, k)[place:])


@leaf
def polygon_bed_after_slip(scene, j, slid, count, p, q):
    """The bed of joint j, whose faces have `count` corners together; slid: whether it has, or which lanes of it."""
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
