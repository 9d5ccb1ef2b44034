"""The bond of a joint that bears tension and cohesion until it breaks, as of mortar (theory.md section 18).

The bonded area is a convex polygon within the section, which only shrinks. On it the bed bears pressure and tension,
stiffness times q; outside it the joint is dry. The bond breaks where stiffness times p, without damping, is below minus
its strength; along the joint cohesion times the bonded area raises the limit of friction.

Within a step the polygon is that at its start. While the bond is held, it bears any tension, so that the step is
smooth, and the step ends where the bond starts to break (cracking.py). Otherwise the evaluation cuts it by p.
"""

import math

from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import (
    WIDTH,
    MaskType,
    any_of,
    bits,
    greater,
    index_of,
    lane,
    lesser,
    magnitude,
    most_of,
    square_root,
    where,
    with_lane,
    zero_like,
)
from ..numba_ext.views import copy, one_lane
from .bed import Bed, Plane, chosen, nothing, plane_of_lane, triangle, value, whole
from .clipping import cut
from .layout import BONDED, MOST_BONDED, OF_POLYGON
from .polygon import polygon_bed
from .section import bearing_area

_bonded = BONDED.over
_BONDED, _EACH = BONDED.beside, OF_POLYGON.size(1)
NEARLY = 1.0 - 1e-12  # fraction of the section above which a bond is whole


@leaf
def bond_left(scene, e):
    """Return the record and the row of corners of the polygon of bond e."""
    there = scene.extras.bonded[_EACH * e :]
    return _bonded(there, 0), there[_BONDED:]


@leaf
def joint_of(scene, e):
    """Return the index of the joint of bond e."""
    return index_of(scene.extras.bonds.joint[e])


@leaf
def tip_of(scene, e, p):
    """Return the crack function of bond e, m, from the penetration p: zero where it breaks, positive where it holds."""
    reach = scene.extras.bonds.strength[e] / scene.joints.stiffness[joint_of(scene, e)]
    return Plane(p.at + reach, p.along_x, p.along_y)


# --- the polygon in the room; of lanes each repeats its last corner up to the largest number of them


@leaf
def _repeat_last(room, counts):
    x, y = room[0], room[1]
    for k in range(most_of(counts)):
        # beyond its own number a lane repeats its last corner
        there = counts > k
        x, y = where(there, room[2 * k], x), where(there, room[2 * k + 1], y)
        room[2 * k], room[2 * k + 1] = x, y


@kernel
def put_bond(scene, e):
    """Copy the polygon of bond e into the room; return the number of its corners, at most MOST_BONDED."""
    left, corners = bond_left(scene, e)
    counts = lesser(left.corners, zero_like(left.corners) + MOST_BONDED)
    for k in range(2 * most_of(counts)):
        scene.room[k] = corners[k]
    # in lanes with fewer corners the last one is repeated
    _repeat_last(scene.room, counts)
    return counts


@by_width
def cut_bond(scene, counts, those, tip, most):
    """Remove the part of the polygon where `tip` is negative, where `those` holds; return the number of its corners.

    If more than `most` corners are left, those that enclose the least area are dropped.
    """
    return _cut_lanes if isinstance(those, MaskType) else _cut_one


def _cut_one(scene, counts, those, tip, most):
    return float(_drop_corners(scene.room, cut(scene.room, int(counts), tip), most)) if those else counts


def _cut_lanes(scene, counts, those, tip, most):
    which = bits(those)
    for k in range(WIDTH):
        if (which >> k) & 1:
            # cut the polygon of this lane alone
            own = one_lane(scene.room, k)
            count = cut(own, int(lane(counts, k)), plane_of_lane(tip, k))
            counts = with_lane(counts, k, float(_drop_corners(own, count, most)))
    _repeat_last(scene.room, counts)
    return counts


@leaf
def _doubled_area(room, a, b, c):
    """Return twice the area of the triangle of three corners in the room."""
    x, y = room[2 * a], room[2 * a + 1]
    return abs((room[2 * b] - x) * (room[2 * c + 1] - y) - (room[2 * c] - x) * (room[2 * b + 1] - y))


@kernel
def _drop_corners(room, count, most):
    """Drop the corners that enclose the least area until at most `most` are left; return their number."""
    while count > most:
        least, gone = math.inf, 0
        # the corner whose triangle with its neighbours is smallest
        for k in range(count):
            size = _doubled_area(room, (k + count - 1) % count, k, (k + 1) % count)
            if size < least:
                least, gone = size, k
        # close the gap
        for k in range(2 * gone, 2 * count - 2):
            room[k] = room[k + 2]
        count -= 1
    return count


@kernel
def store_bond(scene, e, counts, those):
    """Store the polygon in the room as that of bond e, where `those` holds."""
    left, corners = bond_left(scene, e)
    # corners of the selected lanes, then their number
    for k in range(2 * most_of(counts)):
        corners[k] = where(those, scene.room[k], corners[k])
    left.corners = where(those, counts, left.corners)


@kernel
def _whole_bed(room, count, q):
    """Return the bed of the whole polygon in the room, tension included."""
    bed = nothing(q)
    x0, y0 = room[0], room[1]
    # a fan of triangles from the first corner
    for k in range(2, count):
        x1, y1, x2, y2 = room[2 * k - 2], room[2 * k - 1], room[2 * k], room[2 * k + 1]
        values = value(q, x0, y0), value(q, x1, y1), value(q, x2, y2)
        area, force, first_x, first_y = triangle((x0, x1, x2), (y0, y1, y2), values)
        bed = Bed(bed.force + force, bed.first_x + first_x, bed.first_y + first_y, bed.area + area, bed.largest)
    return bed


@kernel
def with_bond(scene, e, p, q, bed):
    """Return the bed of a dry joint plus that of the unpressed part of bond e.

    p, q: penetration and damped penetration, m. The bonded area (m2) is stored in `sound`.
    """
    room, sound, j = scene.room, scene.extras.sound, joint_of(scene, e)
    # the polygon at the start of the step, cut by p where the bond is not held
    counts = put_bond(scene, e)
    breaks = (counts > 0.0) & (sound.held[e] == 0.0)
    if any_of(breaks):
        counts = cut_bond(scene, counts, breaks, tip_of(scene, e, p), MOST_BONDED + 1)
    there, zero = counts >= 3.0, zero_like(counts)
    sound.area[e], sound.margin[e] = zero, zero + math.inf
    if not any_of(there):
        return bed
    # the whole bond; one that fills the section is summed in closed form
    count = most_of(counts)
    own = _whole_bed(room, count, q)
    full = own.area > NEARLY * scene.joints.area[j]
    if any_of(full):
        own = chosen(full, whole(*bearing_area(scene, j), q, bed.largest), own)
    # subtract the pressed part of the bond, which the dry bed contains
    dry = polygon_bed(room, count, own, p, q)
    sound.area[e] = where(there, own.area, 0.0)
    force, first_x, first_y = own.force - dry.force, own.first_x - dry.first_x, own.first_y - dry.first_y
    area = own.area + (bed.area - dry.area)
    mortar = Bed(bed.force + force, bed.first_x + first_x, bed.first_y + first_y, area, bed.largest)
    return chosen(there, mortar, bed)


@leaf
def raised_by_bond(scene, j, normal, limit, couple):
    """Return the friction limits of joint j (N, N m), raised by dowel and cohesion where its bond holds.

    limit, couple: the limits of the dry joint; normal: N.
    """
    joints, e = scene.joints, index_of(scene.joints.bond[j]) - 1
    if e < 0:
        return limit, couple
    # friction, dowel and cohesion
    area = scene.extras.sound.area[e]
    bears = joints.friction[j] * normal + joints.dowel[j] + scene.extras.bonds.cohesion[e] * area
    there = area > 0.0
    return where(there, bears, limit), where(there, bears * joints.arm[j], couple)


@leaf
def with_strength(scene, j, pressure):
    """Return `pressure`, the least on joint j in full contact (Pa), plus the strength of an unbroken bond."""
    if scene.joints.bond[j] != 0.0:
        # only an unbroken bond bears tension everywhere
        e = int(scene.joints.bond[j]) - 1
        if scene.extras.sound.area[e] == scene.joints.area[j]:
            pressure += scene.extras.bonds.strength[e]
    return pressure


@leaf
def limits_with_bond(scene, j, normal, limit, couple, stretch, twist):
    """Return the friction limits of joint j (N, N m); where its bond holds they are infinite, since nothing slides.

    Parameters
    ----------
    normal, limit, couple : float or lanes
        Normal force, N, and limits of the dry joint, N and N m.
    stretch, twist : float or lanes
        Square of the displacement along the joint, m2, and its twist, rad.

    The margin of the bond along the joint, as a fraction, is stored in `sound.margin`: 1 unloaded, 0 where it breaks.
    """
    joints, sound, e = scene.joints, scene.extras.sound, index_of(scene.joints.bond[j]) - 1
    if e < 0:
        return limit, couple
    there = sound.area[e] > 0.0
    # load along the joint over the raised limits
    bears, _ = raised_by_bond(scene, j, normal, limit, couple)
    borne = greater(joints.shear[j] * square_root(stretch), joints.twist[j] / joints.arm[j] * magnitude(twist))
    sound.margin[e] = where(there, where(bears > 0.0, 1.0 - borne / bears, -1.0), sound.margin[e])
    return where(there, math.inf, limit), where(there, math.inf, couple)


@kernel
def show_bonds(scene, shown):
    """Fill `shown` with the bonded fraction of the section of each bond."""
    for e in range(scene.extras.glued):
        shown[e] = scene.extras.sound.area[e] / scene.joints.area[int(scene.extras.bonds.joint[e])]


@kernel
def let_bonds_go(scene):
    """Mark all bonds as not held, so that each evaluation cuts them by their strength."""
    for e in range(scene.extras.glued):
        scene.extras.sound.held[e] = 0.0


@kernel
def copy_bonds(scene, behind):
    """Copy the polygons of all bonds into `behind`, the end of a state after phase and memory."""
    copy(behind, scene.extras.bonded, _EACH * scene.extras.glued)
