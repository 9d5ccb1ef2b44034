"""A joint that bears tension and cohesion until it breaks, as of mortar (theory.md section 18).

What is left of its bond is a convex polygon within the section, which only shrinks. There the bed bears pressure and
tension alike, stiffness times q; beside it the joint is as dry as any. The bond ends where stiffness times p, which has
no damping in it, is below minus its strength; along the joint the limit of friction is raised by cohesion times its
area.

In a step the polygon is that at its beginning. Held, it bears whatever tension comes, so that the step is smooth, and
ends where the bond begins to break (cracking.py). Else the evaluation cuts it by where p is.
"""

import math

from ..numba_ext.jit import kernel, leaf, varied, varied_leaf
from ..numba_ext.views import copy
from .bed import Bed, Plane, add, nothing, triangle, value, whole
from .layout import BONDED, OF_POLYGON, acts_alone, has_extras
from .overlap import cut
from .polygon import polygon_bed

_bonded = BONDED.over
_BONDED, _EACH = BONDED.beside, OF_POLYGON.size(1)
NEARLY = 1.0 - 1e-12  # of the section: a bond that is larger is whole


@leaf
def bond_left(scene, e):
    """What is left of bond e: its record, and its corners as a row."""
    there = scene.extras.bonded[_EACH * e :]
    return _bonded(there, 0), there[_BONDED:]


@leaf
def tip_of(scene, e, p):
    """Zero where bond e breaks, positive where it holds, m, by the penetration."""
    bonds = scene.extras.bonds
    return Plane(p.at + bonds.strength[e] / scene.joints.stiffness[int(bonds.joint[e])], p.along_x, p.along_y)


@kernel
def put_bond(scene, e):
    """Put what is left of bond e into the room; returns the number of its corners."""
    left, corners = bond_left(scene, e)
    count = int(left.corners)
    for k in range(2 * count):
        scene.room[k] = corners[k]
    return count


@kernel
def _all_of(room, count, q):
    """The bed of a whole polygon, in tension too."""
    bed = nothing(q)
    x0, y0 = room[0], room[1]
    for k in range(2, count):
        x1, y1, x2, y2 = room[2 * k - 2], room[2 * k - 1], room[2 * k], room[2 * k + 1]
        values = value(q, x0, y0), value(q, x1, y1), value(q, x2, y2)
        bed = add(bed, True, *triangle((x0, x1, x2), (y0, y1, y2), values))
    return bed


@kernel
def with_bond(scene, e, p, q, bed):
    """A bed of a dry joint with the part of bond e that is not pressed."""
    sound = scene.extras.sound
    count = put_bond(scene, e)
    if count > 0 and sound.held[e] == 0.0:
        count = cut(scene.room, count, tip_of(scene, e, p))
    sound.area[e], sound.spare[e] = 0.0, math.inf
    if count < 3:
        return bed
    own, j = _all_of(scene.room, count, q), int(scene.extras.bonds.joint[e])
    if own.area > NEARLY * scene.joints.area[j]:
        own = whole(scene.joints, j, q, bed.largest)
    dry = polygon_bed(scene.room, 0, count, own, p, q)
    sound.area[e] = own.area
    force, first_x, first_y = own.force - dry.force, own.first_x - dry.first_x, own.first_y - dry.first_y
    area = own.area + (bed.area - dry.area)
    return Bed(bed.force + force, bed.first_x + first_x, bed.first_y + first_y, area, bed.largest)


@varied_leaf
def raised_by_bond(scene, j, normal, limit, couple):
    """The limits of friction of joint j, N and N m, with what its bond bears beside."""
    return limit, couple


@raised_by_bond.version(acts_alone)
def _raised_by_bond(scene, j, normal, limit, couple):
    if scene.joints.bond[j] == 0.0:
        return limit, couple
    e, joints = int(scene.joints.bond[j]) - 1, scene.joints
    area = scene.extras.sound.area[e]
    if area == 0.0:
        return limit, couple
    bears = joints.friction[j] * normal + joints.dowel[j] + scene.extras.bonds.cohesion[e] * area
    return bears, bears * joints.arm[j]


@varied_leaf
def with_strength(scene, j, pressure):
    """The least pressure on joint j in full contact, Pa, over that at which it opens or its whole bond breaks."""
    return pressure


@with_strength.version(acts_alone)
def _with_strength(scene, j, pressure):
    if scene.joints.bond[j] != 0.0:
        e = int(scene.joints.bond[j]) - 1
        if scene.extras.sound.area[e] == scene.joints.area[j]:
            pressure += scene.extras.bonds.strength[e]
    return pressure


@varied_leaf
def limits_with_bond(scene, j, normal, limit, couple, stretch, twist):
    """The limits of friction of joint j, N and N m; a bond lets nothing slide before it breaks.

    stretch, twist: m and rad, what the joint is displaced and twisted by.
    """
    return limit, couple


@limits_with_bond.version(acts_alone)
def _limits_with_bond(scene, j, normal, limit, couple, stretch, twist):
    """How far the bond is from breaking along the joint is kept."""
    if scene.joints.bond[j] == 0.0:
        return limit, couple
    e, joints = int(scene.joints.bond[j]) - 1, scene.joints
    if scene.extras.sound.area[e] == 0.0:
        return limit, couple
    bears, _ = raised_by_bond(scene, j, normal, limit, couple)
    borne = max(joints.shear[j] * math.sqrt(stretch), joints.twist[j] / joints.arm[j] * abs(twist))
    scene.extras.sound.spare[e] = 1.0 - borne / bears if bears > 0.0 else -1.0
    return math.inf, math.inf


@varied
def show_bonds(scene, shown):
    """Fill in what an output row has of bonds."""
    return


@show_bonds.version(has_extras)
def _show_bonds(scene, shown):
    for e in range(scene.extras.glued):
        shown[e] = scene.extras.sound.area[e] / scene.joints.area[int(scene.extras.bonds.joint[e])]


@varied
def let_bonds_go(scene):
    """Hold no bond as it was: each ends where its strength does."""
    return


@let_bonds_go.version(has_extras)
def _let_bonds_go(scene):
    for e in range(scene.extras.glued):
        scene.extras.sound.held[e] = 0.0


@varied
def copy_bonds(scene, behind):
    """Copy what is left of bonds to where a state has it, behind what moves or is remembered."""
    return


@copy_bonds.version(has_extras)
def _copy_bonds(scene, behind):
    copy(behind, scene.extras.bonded, _EACH * scene.extras.glued)
