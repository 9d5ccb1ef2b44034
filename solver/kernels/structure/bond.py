"""A joint that bears tension and cohesion until it breaks, as of mortar (theory.md section 18).

What is left of its bond is a convex polygon within the section, which only shrinks. There the bed bears pressure and
tension alike, stiffness times q; beside it the joint is as dry as any. The bond ends where stiffness times p, which has
no damping in it, is below minus its strength; along the joint the limit of friction is raised by cohesion times its
area.

In a step the polygon is that at its beginning. Held, it bears whatever tension comes, so that the step is smooth, and
ends where the bond begins to break (cracking.py). Else the evaluation cuts it by where p is.
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
NEARLY = 1.0 - 1e-12  # of the section: a bond that is larger is whole


@leaf
def bond_left(scene, e):
    """What is left of bond e: its record, and its corners as a row."""
    there = scene.extras.bonded[_EACH * e :]
    return _bonded(there, 0), there[_BONDED:]


@leaf
def joint_of(scene, e):
    """Number of the joint of bond e."""
    return index_of(scene.extras.bonds.joint[e])


@leaf
def tip_of(scene, e, p):
    """Zero where bond e breaks, positive where it holds, m, by the penetration."""
    reach = scene.extras.bonds.strength[e] / scene.joints.stiffness[joint_of(scene, e)]
    return Plane(p.at + reach, p.along_x, p.along_y)


# --- the polygon in the room; of lanes each repeats its last corner up to the largest number of them


@leaf
def _repeat_last(room, counts):
    x, y = room[0], room[1]
    for k in range(most_of(counts)):
        there = counts > k
        x, y = where(there, room[2 * k], x), where(there, room[2 * k + 1], y)
        room[2 * k], room[2 * k + 1] = x, y


@kernel
def put_bond(scene, e):
    """Put what is left of bond e into the room; returns the number of its corners, which is one that has room."""
    left, corners = bond_left(scene, e)
    counts = lesser(left.corners, zero_like(left.corners) + MOST_BONDED)
    for k in range(2 * most_of(counts)):
        scene.room[k] = corners[k]
    _repeat_last(scene.room, counts)
    return counts


@by_width
def cut_bond(scene, counts, those, tip, most):
    """Cut the polygon, where `those` holds, by where a plane is negative; returns the number of its corners.

    Of more than `most` corners those go that hold least.
    """
    return _cut_lanes if isinstance(those, MaskType) else _cut_one


def _cut_one(scene, counts, those, tip, most):
    return float(_fewer(scene.room, cut(scene.room, int(counts), tip), most)) if those else counts


def _cut_lanes(scene, counts, those, tip, most):
    which = bits(those)
    for k in range(WIDTH):
        if (which >> k) & 1:
            own = one_lane(scene.room, k)
            count = cut(own, int(lane(counts, k)), plane_of_lane(tip, k))
            counts = with_lane(counts, k, float(_fewer(own, count, most)))
    _repeat_last(scene.room, counts)
    return counts


@leaf
def _doubled(room, a, b, c):
    """Twice the area of a triangle of three corners."""
    x, y = room[2 * a], room[2 * a + 1]
    return abs((room[2 * b] - x) * (room[2 * c + 1] - y) - (room[2 * c] - x) * (room[2 * b + 1] - y))


@kernel
def _fewer(room, count, most):
    """Leave out the corners that hold least until there is room for the others; returns their number."""
    while count > most:
        least, gone = math.inf, 0
        for k in range(count):
            size = _doubled(room, (k + count - 1) % count, k, (k + 1) % count)
            if size < least:
                least, gone = size, k
        for k in range(2 * gone, 2 * count - 2):
            room[k] = room[k + 2]
        count -= 1
    return count


@kernel
def store_bond(scene, e, counts, those):
    """Let the polygon in the room be what is left of bond e, where `those` holds."""
    left, corners = bond_left(scene, e)
    for k in range(2 * most_of(counts)):
        corners[k] = where(those, scene.room[k], corners[k])
    left.corners = where(those, counts, left.corners)


@kernel
def _all_of(room, count, q):
    """The bed of a whole polygon, in tension too."""
    bed = nothing(q)
    x0, y0 = room[0], room[1]
    for k in range(2, count):
        x1, y1, x2, y2 = room[2 * k - 2], room[2 * k - 1], room[2 * k], room[2 * k + 1]
        values = value(q, x0, y0), value(q, x1, y1), value(q, x2, y2)
        area, force, first_x, first_y = triangle((x0, x1, x2), (y0, y1, y2), values)
        bed = Bed(bed.force + force, bed.first_x + first_x, bed.first_y + first_y, bed.area + area, bed.largest)
    return bed


@kernel
def with_bond(scene, e, p, q, bed):
    """A bed of a dry joint with the part of bond e that is not pressed."""
    room, sound, j = scene.room, scene.extras.sound, joint_of(scene, e)
    counts = put_bond(scene, e)
    breaks = (counts > 0.0) & (sound.held[e] == 0.0)
    if any_of(breaks):
        counts = cut_bond(scene, counts, breaks, tip_of(scene, e, p), MOST_BONDED + 1)
    there, zero = counts >= 3.0, zero_like(counts)
    sound.area[e], sound.spare[e] = zero, zero + math.inf
    if not any_of(there):
        return bed
    count = most_of(counts)
    own = _all_of(room, count, q)
    full = own.area > NEARLY * scene.joints.area[j]
    if any_of(full):
        own = chosen(full, whole(*bearing_area(scene, j), q, bed.largest), own)
    dry = polygon_bed(room, count, own, p, q)
    sound.area[e] = where(there, own.area, 0.0)
    force, first_x, first_y = own.force - dry.force, own.first_x - dry.first_x, own.first_y - dry.first_y
    area = own.area + (bed.area - dry.area)
    mortar = Bed(bed.force + force, bed.first_x + first_x, bed.first_y + first_y, area, bed.largest)
    return chosen(there, mortar, bed)


@leaf
def raised_by_bond(scene, j, normal, limit, couple):
    """The limits of friction of joint j, N and N m, with what its bond bears beside."""
    joints, e = scene.joints, index_of(scene.joints.bond[j]) - 1
    if e < 0:
        return limit, couple
    area = scene.extras.sound.area[e]
    bears = joints.friction[j] * normal + joints.dowel[j] + scene.extras.bonds.cohesion[e] * area
    there = area > 0.0
    return where(there, bears, limit), where(there, bears * joints.arm[j], couple)


@leaf
def with_strength(scene, j, pressure):
    """The least pressure on joint j in full contact, Pa, over that at which it opens or its whole bond breaks."""
    if scene.joints.bond[j] != 0.0:
        e = int(scene.joints.bond[j]) - 1
        if scene.extras.sound.area[e] == scene.joints.area[j]:
            pressure += scene.extras.bonds.strength[e]
    return pressure


@leaf
def limits_with_bond(scene, j, normal, limit, couple, stretch, twist):
    """The limits of friction of joint j, N and N m; a bond lets nothing slide before it breaks.

    stretch, twist: m and rad, what the joint is displaced and twisted by. How far the bond is from breaking along the
    joint is kept.
    """
    joints, sound, e = scene.joints, scene.extras.sound, index_of(scene.joints.bond[j]) - 1
    if e < 0:
        return limit, couple
    there = sound.area[e] > 0.0
    bears, _ = raised_by_bond(scene, j, normal, limit, couple)
    borne = greater(joints.shear[j] * square_root(stretch), joints.twist[j] / joints.arm[j] * magnitude(twist))
    sound.spare[e] = where(there, where(bears > 0.0, 1.0 - borne / bears, -1.0), sound.spare[e])
    return where(there, math.inf, limit), where(there, math.inf, couple)


@kernel
def show_bonds(scene, shown):
    """Fill in what an output row has of bonds."""
    for e in range(scene.extras.glued):
        shown[e] = scene.extras.sound.area[e] / scene.joints.area[int(scene.extras.bonds.joint[e])]


@kernel
def let_bonds_go(scene):
    """Hold no bond as it was: each ends where its strength does."""
    for e in range(scene.extras.glued):
        scene.extras.sound.held[e] = 0.0


@kernel
def copy_bonds(scene, behind):
    """Copy what is left of bonds to where a state has it, behind what moves or is remembered."""
    copy(behind, scene.extras.bonded, _EACH * scene.extras.glued)
