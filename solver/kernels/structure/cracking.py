"""Bonds break between two steps: a step ends where one starts to break, and where a crack stops growing (bond.py).

So the law is smooth within a step, and the history of a bond is known from the ends of steps. Kernels serve one
structure, or eight in lanes, of which a mask selects some.
"""

import math

from ..engine.peaks import MARGIN, MOST_TRIALS, apart, nearer, vertex
from ..engine.peaks import NEAR as NEARLY
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import (
    any_of,
    greater,
    index_of,
    lesser,
    magnitude,
    most_of,
    nearest,
    opposite,
    square_root,
    where,
    zero_like,
)
from .bed import value
from .bond import bond_left, cut_bond, joint_of, let_bonds_go, put_bond, store_bond, tip_of
from .evaluate import recall
from .joint import load_joint, penetration, penetration_rate
from .kinematics import pose_two, relative_motion
from .layout import MEMORY, MOST_BONDED, PHASE
from .watch import END, load_joint_between, pose_between, row

_phase, _PER_BODY, _PER_JOINT = PHASE.over, PHASE.per_n, MEMORY.per_n
NEAR = 1e-9  # of the largest crack function: a corner this near to its strength has reached it
LEAST = 1e-9  # of the section: a smaller bond has broken
HALVINGS = 40  # bisections of a step, to the instant at which a bond breaks
LEAST_PART = 1e-6  # least fraction of a step that ends where a bond breaks
# rotation of a crack front between two cuts, over the root of the tolerance, rad: the excess area that they leave is
# quadratic in it
TURN, MOST_CUTS = 1.0, 256
PROMISE = 0.01  # factor on the accepted margin from one trial to the next


@leaf
def _none(those):
    """Return a mask of the same kind that holds nowhere."""
    return those & opposite(those)


@kernel
def _strain_of(scene, count, tip):
    """Return the minimum of a bond's crack function over the corners in the room, and its largest |value|, m."""
    least, largest = math.inf + zero_like(tip.at), zero_like(tip.at)
    for k in range(count):
        # value at a corner
        here = value(tip, scene.room[2 * k], scene.room[2 * k + 1])
        least, largest = lesser(least, here), greater(largest, magnitude(here))
    return least, largest


@leaf
def _reach(scene, e):
    """Return the stretch at which bond e breaks, m, or a fraction of the settlement if that is larger."""
    settings, bonds = scene.settings, scene.extras.bonds
    least = settings.motion_floor * settings.extent
    return greater(least, bonds.strength[e] / scene.joints.stiffness[joint_of(scene, e)])


@leaf
def _strength_left(scene, e, least, largest):
    """Return the margin of bond e before its crack function vanishes, as a fraction of the stretch at which it breaks.

    least, largest: minimum and largest size of the crack function over its corners, m.
    """
    return (least + NEAR * largest) / _reach(scene, e)


@kernel
def _grows(scene, count, tip, pace, near):
    """Return the mask of where a crack front advances: the crack function vanishes within the bond and decreases there.

    tip: crack function, m; pace: its rate, m/s; near: value that counts as zero, as where a step starts, m; the bond is
    the polygon of `count` corners in the room.
    """
    room, last = scene.room, max(0, count - 1)  # 0 corners of a broken bond
    # the crack function along the outline
    x0, y0 = room[2 * last], room[2 * last + 1]
    before = value(tip, x0, y0) - near
    grows = _none(before < 0.0)
    for k in range(count):
        x1, y1 = room[2 * k], room[2 * k + 1]
        here = value(tip, x1, y1) - near
        # points at which the front meets the outline
        crosses = (before > 0.0) ^ (here > 0.0)
        if any_of(crosses):
            part = before / (before - here)
            grows = grows | (crosses & (value(pace, x0 + part * (x1 - x0), y0 + part * (y1 - y0)) < 0.0))
        x0, y0, before = x1, y1, here
    return grows


@kernel
def _bond_margin(scene, phase, e):
    """Return the margin of bond e before it breaks, as a fraction; its joint has just been loaded by `phase`.

    It is 1 while its crack grows, and negative beyond breaking or after the crack has stopped.
    """
    sound, j = scene.extras.sound, joint_of(scene, e)
    # crack function on the polygon at the start of the step
    motion = relative_motion(scene, phase, j)
    tip, count = tip_of(scene, e, penetration(scene, j, motion)), most_of(put_bond(scene, e))
    # margin of a held bond in tension
    least, largest = _strain_of(scene, count, tip)
    margin, held = _strength_left(scene, e, least, largest), sound.held[e] != 0.0
    # a bond in which a crack grows
    if any_of(opposite(held)):
        grows = _grows(scene, count, tip, penetration_rate(scene, j, motion), NEAR * largest)
        margin = where(held, margin, where(grows, 1.0, -1.0))
    return lesser(sound.margin[e], margin)


@leaf
def _margin_between(scene, h, s, e):
    """Return `_bond_margin` at fraction s of a step."""
    return _bond_margin(scene, load_joint_between(scene, h, s, joint_of(scene, e)), e)


@kernel
def until_broken(scene, h, those):
    """Return the fraction of the step of h s just made after which the first bond starts to break; 1 if none does.

    The resultants and the force on the base are left as at the end of the step.
    """
    extras, part = scene.extras, zero_like(h) + 1.0
    if extras.glued == 0:
        return part
    # force and moment on the base, which the search overwrites
    phase, poses, n = _phase(row(scene, END), scene.n), scene.poses, scene.n
    force, moment = (poses.fx[n], poses.fy[n], poses.fz[n]), (poses.mx[n], poses.my[n], poses.mz[n])
    # margins at the end of the step
    for e in range(extras.glued):
        _pose_ends(scene, phase, e)
        extras.sound.ends[e] = _bond_margin(scene, phase, e)
    # the first bond to break
    for e in range(extras.glued):
        there = those & (bond_left(scene, e)[0].corners != 0.0)
        if any_of(there):
            part = lesser(_breaking(scene, h, e, there), part)
    # restore the forces at the end
    if not any_of(part < 1.0):
        for e in range(extras.glued):
            _pose_ends(scene, phase, e)
            _load(scene, row(scene, END), e)
        poses.fx[n], poses.fy[n], poses.fz[n] = force
        poses.mx[n], poses.my[n], poses.mz[n] = moment
    return part


@leaf
def _pose_ends(scene, phase, e):
    j = joint_of(scene, e)
    pose_two(scene, phase, index_of(scene.joints.upper[j]), index_of(scene.joints.lower[j]))


@kernel
def _load(scene, state, e):
    """Load the joint of bond e, whose bodies have been placed, with the memory of `state`."""
    j, remembered = joint_of(scene, e), state[_PER_BODY * scene.n :]
    if any_of(scene.settings.gives_way != 0.0):
        # slips of this joint
        for place in range(j, _PER_JOINT * scene.m, scene.m):
            scene.memory[place] = remembered[place]
    load_joint(scene, _phase(state, scene.n), j)


@kernel
def _breaking(scene, h, e, there):
    """Return the fraction of a step after which bond e starts to break; 1 where it does not or `there` is False.

    The margin is evaluated in the middle, at the end and, by parabolas, at its minimum between.
    """
    begins, ends = scene.extras.sound.begins[e], scene.extras.sound.ends[e]
    zero = zero_like(h)
    # a bracket from the values at the start, in the middle and at the end
    middle = _margin_between(scene, h, zero + 0.5, e)
    early, late = there & opposite(middle > 0.0), there & opposite(ends > 0.0)
    low, high = where(early, 0.0, zero + 0.5), where(early, 0.5, where(late, 1.0, zero + math.inf))
    bend, rise = begins - 2.0 * middle + ends, ends - begins
    # parabolas where the minimum may be negative
    seeks = there & opposite(early | late) & (magnitude(rise) < NEARLY * bend)
    if any_of(seeks):
        known = zero, -begins, zero + 0.5, -middle, zero + 1.0, -ends
        s, height = vertex(*known)
        for _ in range(MOST_TRIALS):
            seeks = seeks & (height > -MARGIN * bend) & (s > 0.0) & (s < 1.0)
            if not any_of(seeks):
                break
            found = _margin_between(scene, h, where(seeks, s, 0.5), e)
            # a negative value ends the search, and brackets the instant
            breaks = seeks & opposite(found > 0.0)
            low = where(breaks, where(s < known[2], known[0], known[2]), low)
            high = where(breaks, s, high)
            seeks = seeks & (found > 0.0)
            known = nearer(known, s, -found)
            s, height = vertex(*known)
            s, bend = apart(known, s), PROMISE * bend
    # bisection
    for _ in range(HALVINGS):
        breaks = high < math.inf
        if not any_of(breaks):
            break
        half = where(breaks, 0.5 * (low + high), 0.5)
        holds = _margin_between(scene, h, half, e) > 0.0
        low, high = where(breaks & holds, half, low), where(breaks & opposite(holds), half, high)
    return lesser(greater(high, LEAST_PART), 1.0)


@leaf
def _tip_between(scene, h, s, e):
    """Return the crack function of bond e at fraction s of a step, m."""
    j = joint_of(scene, e)
    phase = pose_between(scene, h, s, index_of(scene.joints.upper[j]), index_of(scene.joints.lower[j]))
    return tip_of(scene, e, penetration(scene, j, relative_motion(scene, phase, j)))


@kernel
def crack_within(scene, h, those):
    """Cut bonds along the rotating crack fronts of a step of h s; return the mask of where one was cut."""
    passed, allowed = _none(those), TURN * square_root(scene.settings.tolerance)
    for e in range(scene.extras.glued):
        # bonds that a crack grows in
        growing = those & (bond_left(scene, e)[0].corners != 0.0) & (scene.extras.sound.held[e] == 0.0)
        if any_of(growing):
            passed = passed | _cut_along(scene, h, e, growing, allowed)
    return passed


@kernel
def _cut_along(scene, h, e, growing, allowed):
    """Cut bond e at instants of a step between which its crack front rotates by at most `allowed` rad.

    Return the mask of where it was cut.
    """
    # crack function at start and end of the step
    a, b = _tip_between(scene, h, zero_like(h), e), _tip_between(scene, h, zero_like(h) + 1.0, e)
    # rotation of the front, and the number of cuts
    sine, cosine = a.along_x * b.along_y - a.along_y * b.along_x, a.along_x * b.along_x + a.along_y * b.along_y
    below = square_root(sine * sine + cosine * cosine) + cosine
    turn = where(below > 0.0, 2.0 * magnitude(sine) / below, 0.0)  # twice the tangent of half the angle: no less
    cuts = where(growing, nearest(lesser(turn / allowed - 0.5, MOST_CUTS)), 0.0)
    passed = cuts > 0.0
    if any_of(passed):
        # equally spaced instants
        counts = put_bond(scene, e)
        for k in range(most_of(cuts)):
            tip = _tip_between(scene, h, (k + 1.0) / (cuts + 1.0), e)
            counts = cut_bond(scene, counts, cuts > k, tip, MOST_BONDED)
        store_bond(scene, e, counts, passed)
    return passed


@kernel
def crack(scene, state, those):
    """Update all bonds by a state: cut those that break, hold the others; return the mask of where one broke whole."""
    broke, phase = _none(those), _phase(state, scene.n)
    for e in range(scene.extras.glued):
        # lanes in which the joint still has a bond
        there = those & (bond_left(scene, e)[0].corners != 0.0)
        if any_of(there):
            scene.extras.sound.held[e] = where(there, 0.0, scene.extras.sound.held[e])
            # evaluate the joint with its bond free to break
            _pose_ends(scene, phase, e)
            _load(scene, state, e)
            broke = broke | _crack_bond(scene, phase, e, there)
    return broke


@kernel
def _crack_bond(scene, phase, e, there):
    """Update bond e by the last evaluation of its joint: break, cut or hold it; return where it broke whole."""
    sound, j, left = scene.extras.sound, joint_of(scene, e), bond_left(scene, e)[0]
    # broken along the joint, or nothing left
    holds = (sound.margin[e] > 0.0) & (sound.area[e] > LEAST * scene.joints.area[j])
    broke = there & opposite(holds)
    left.corners = where(broke, 0.0, left.corners)
    sound.area[e] = where(broke, 0.0, sound.area[e])
    there = there & holds
    if not any_of(there):
        return broke
    # cut the part beyond its strength
    motion = relative_motion(scene, phase, j)
    tip, pace = tip_of(scene, e, penetration(scene, j, motion)), penetration_rate(scene, j, motion)
    counts = put_bond(scene, e)
    least, largest = _strain_of(scene, most_of(counts), tip)
    cuts = there & opposite(least > 0.0)
    if any_of(cuts):
        counts = cut_bond(scene, counts, cuts, tip, MOST_BONDED)
        store_bond(scene, e, counts, cuts)
        least, largest = _strain_of(scene, most_of(counts), tip)
    # the crack grows where a corner on its front opens further
    grows = _none(there)
    for k in range(most_of(counts)):
        x, y = scene.room[2 * k], scene.room[2 * k + 1]
        grows = grows | ((value(tip, x, y) <= NEAR * largest) & (value(pace, x, y) < 0.0))
    # margin at the start of the step
    margin = lesser(sound.margin[e], where(grows, 1.0, _strength_left(scene, e, least, largest)))
    sound.held[e] = where(there, where(grows, 0.0, 1.0), sound.held[e])
    sound.begins[e] = where(there, margin, sound.begins[e])
    return broke


@kernel
def settle_bonds(scene, state):
    """Update all bonds by the state just evaluated; return True if it has to be evaluated again."""
    # by the memory of the state, without holding any bond
    recall(scene, state)
    crack(scene, state, True)
    let_bonds_go(scene)
    return scene.extras.glued > 0
