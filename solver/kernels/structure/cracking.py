"""Bonds break between two steps: a step ends where one begins to, and where a crack ceases to grow (bond.py).

So the law is smooth within a step, and what a bond has been through is known from the ends of steps.
"""

import math

from ..numba_ext.jit import kernel, leaf, varied
from ..output.peaks import MARGIN, MOST_TRIALS, apart, nearer, vertex
from ..output.peaks import NEAR as NEARLY
from .bed import value
from .bond import bond_left, let_bonds_go, put_bond, tip_of
from .evaluate import recall
from .joint import load_joint, penetration, penetration_rate
from .kinematics import pose_body, relative_motion
from .layout import MOST_BONDED, PHASE, has_extras
from .overlap import cut
from .watch import BETWEEN, load_joint_between, pose_joint_between, row

_phase = PHASE.over
NEAR = 1e-9  # of the penetrations of a bond: a corner that is as near to its strength has reached it
LEAST = 1e-9  # of the section: what is left of a bond and is smaller has broken
HALVINGS = 40  # of a step, to where a bond breaks
LEAST_PART = 1e-6  # of a step that ends there
# how far the front of a crack turns between two cuts, over the root of the tolerance, rad: what they leave of the bond
# beside its true bound goes with the square
TURN, MOST_CUTS = 1.0, 256
PROMISE = 0.01  # of how near to breaking a bond may have come, from one trial to the next


@kernel
def _strain_of(scene, e, tip):
    """The least of a bond's tip over its corners, and the largest size, m."""
    left, corners = bond_left(scene, e)
    least, largest = math.inf, 0.0
    for k in range(int(left.corners)):
        here = value(tip, corners[2 * k], corners[2 * k + 1])
        least, largest = min(least, here), max(largest, abs(here))
    return least, largest


@leaf
def _reach(scene, e):
    """What a bond may be stretched by, m; without strength a part of the settlement."""
    settings, bonds = scene.settings, scene.extras.bonds
    least = settings.motion_floor * settings.extent
    return max(least, bonds.strength[e] / scene.joints.stiffness[int(bonds.joint[e])])


@kernel
def _spare(scene, h, s, e):
    """How far bond e is from breaking at fraction s of a step: a part, below zero beyond; of a crack that grows 1.

    Below zero too where that has ceased to grow.
    """
    bonds, sound, phase = scene.extras.bonds, scene.extras.sound, _phase(row(scene, BETWEEN), scene.n)
    j = int(bonds.joint[e])
    load_joint_between(scene, phase, h, s, j)
    motion, along = relative_motion(scene, phase, j), sound.spare[e]
    tip = tip_of(scene, e, penetration(scene, j, motion))
    if sound.held[e] != 0.0:
        least, largest = _strain_of(scene, e, tip)
        return min(along, (least + NEAR * largest) / _reach(scene, e))
    return min(along, 1.0 if _grows(scene, e, tip, penetration_rate(scene, j, motion)) else -1.0)


@kernel
def _grows(scene, e, tip, pace):
    """Whether the front of a crack, where the tip is zero within what is left of a bond, moves on anywhere."""
    left, corners = bond_left(scene, e)
    count = int(left.corners)
    x0, y0 = corners[2 * count - 2], corners[2 * count - 1]
    before, grows = value(tip, x0, y0), False
    for k in range(count):
        x1, y1 = corners[2 * k], corners[2 * k + 1]
        here = value(tip, x1, y1)
        if (before > 0.0) != (here > 0.0):
            part = before / (before - here)
            grows = grows or value(pace, x0 + part * (x1 - x0), y0 + part * (y1 - y0)) < 0.0
        x0, y0, before = x1, y1, here
    return grows


@varied
def until_broken(scene, h, part):
    """The part of a step of h s, at most `part`, after which no bond has begun to break."""
    return part


@until_broken.version(has_extras)
def _until_broken(scene, h, part):
    for e in range(scene.extras.glued):
        if bond_left(scene, e)[0].corners != 0.0:
            low, high = _breaking(scene, h, part, e)
            for _ in range(HALVINGS):
                if high == math.inf:
                    break
                half = 0.5 * (low + high)
                if _spare(scene, h, half, e) > 0.0:
                    low = half
                else:
                    high = half
            part = min(part, max(high, LEAST_PART))
    return part


@kernel
def _breaking(scene, h, part, e):
    """Fractions of a step before and after bond e begins to break; the latter infinite where it does not.

    It is seen in the middle, at the end and, by parabolas, where it may come nearest to breaking between.
    """
    begins, middle, ends = _spare(scene, h, 0.0, e), _spare(scene, h, 0.5 * part, e), _spare(scene, h, part, e)
    if not middle > 0.0:
        return 0.0, 0.5 * part
    if not ends > 0.0:
        return 0.5 * part, part
    bend, rise = begins - 2.0 * middle + ends, ends - begins
    if abs(rise) < NEARLY * bend:
        known, trials = (0.0, -begins, 0.5, -middle, 1.0, -ends), 0
        s, height = vertex(*known)
        while height > -MARGIN * bend and trials < MOST_TRIALS and 0.0 < s < 1.0:
            found = _spare(scene, h, part * s, e)
            if not found > 0.0:
                return part * (known[0] if s < known[2] else known[2]), part * s
            trials += 1
            known = nearer(known, s, -found)
            s, height = vertex(*known)
            s = apart(known, s)
            bend = PROMISE * bend
    return part, math.inf


@leaf
def _tip_between(scene, h, s, e):
    """The tip of bond e at fraction s of a step."""
    j, phase = int(scene.extras.bonds.joint[e]), _phase(row(scene, BETWEEN), scene.n)
    pose_joint_between(scene, phase, h, s, j)
    return tip_of(scene, e, penetration(scene, j, relative_motion(scene, phase, j)))


@leaf
def _doubled(room, a, b, c):
    """Twice the area of a triangle of three corners."""
    x, y = room[2 * a], room[2 * a + 1]
    return abs((room[2 * b] - x) * (room[2 * c + 1] - y) - (room[2 * c] - x) * (room[2 * b + 1] - y))


@kernel
def _fewer(room, count):
    """Leave out the corners that hold least until there is room for the others; returns their number."""
    while count > MOST_BONDED:
        least, gone = math.inf, 0
        for k in range(count):
            size = _doubled(room, (k + count - 1) % count, k, (k + 1) % count)
            if size < least:
                least, gone = size, k
        for k in range(2 * gone, 2 * count - 2):
            room[k] = room[k + 2]
        count -= 1
    return count


@leaf
def _store(scene, e, count):
    """Leave what is in the room of bond e."""
    left, corners = bond_left(scene, e)
    for k in range(2 * count):
        corners[k] = scene.room[k]
    left.corners = float(count)


@varied
def crack_within(scene, h):
    """Let bonds break by what a front that turns has passed within a step of h s; whether one has."""
    return False


@crack_within.version(has_extras)
def _crack_within(scene, h):
    passed, allowed = False, TURN * math.sqrt(scene.settings.tolerance)
    for e in range(scene.extras.glued):
        if bond_left(scene, e)[0].corners == 0.0 or scene.extras.sound.held[e] != 0.0:
            continue
        a, b = _tip_between(scene, h, 0.0, e), _tip_between(scene, h, 1.0, e)
        sine = a.along_x * b.along_y - a.along_y * b.along_x
        turn = abs(math.atan2(sine, a.along_x * b.along_x + a.along_y * b.along_y))
        cuts = int(min(MOST_CUTS, turn / allowed))
        count = put_bond(scene, e)
        for k in range(cuts):
            tip = _tip_between(scene, h, (k + 1.0) / (cuts + 1.0), e)
            count = _fewer(scene.room, cut(scene.room, count, tip))
        if cuts > 0:
            _store(scene, e, count)
            passed = True
    return passed


@kernel
def crack(scene, state):
    """Let bonds break as a state says, and hold those that no crack grows in; whether one broke whole."""
    broke, phase = False, _phase(state, scene.n)
    if scene.settings.gives_way != 0.0:
        recall(scene, state)
    for e in range(scene.extras.glued):
        if bond_left(scene, e)[0].corners != 0.0:
            broke = _crack(scene, phase, e) or broke
    return broke


@kernel
def _crack(scene, phase, e):
    sound, j = scene.extras.sound, int(scene.extras.bonds.joint[e])
    for body in (int(scene.joints.upper[j]), int(scene.joints.lower[j])):
        if body < scene.n:
            pose_body(scene, phase, body)
    sound.held[e] = 0.0
    load_joint(scene, phase, j)
    left, corners = bond_left(scene, e)
    if not sound.spare[e] > 0.0 or not sound.area[e] > LEAST * scene.joints.area[j]:
        left.corners, sound.area[e] = 0.0, 0.0
        return True
    motion = relative_motion(scene, phase, j)
    tip = tip_of(scene, e, penetration(scene, j, motion))
    pace = penetration_rate(scene, j, motion)
    _store(scene, e, _fewer(scene.room, cut(scene.room, put_bond(scene, e), tip)))
    count = int(left.corners)
    _, largest = _strain_of(scene, e, tip)
    sound.held[e] = 1.0
    for k in range(count):
        x, y = corners[2 * k], corners[2 * k + 1]
        if value(tip, x, y) <= NEAR * largest and value(pace, x, y) < 0.0:
            sound.held[e] = 0.0
    return False


@varied
def settle_bonds(scene, state):
    """Let bonds break as the state says that has just been evaluated; whether it has to be evaluated again."""
    return False


@settle_bonds.version(has_extras)
def _settle_bonds(scene, state):
    crack(scene, state)
    let_bonds_go(scene)
    return scene.extras.glued > 0
