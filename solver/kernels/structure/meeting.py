"""Steps end where a gap closes or a bond breaks: pairs touch or separate, and bonds break, between two steps."""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import lesser, where, zero_like
from ..numba_ext.views import copy
from .attempt import rate
from .bearing import travel_left
from .bodies import path_through
from .contact import (
    DEEP,
    SHALLOW,
    begins_by,
    forget_directions,
    forget_known_gaps,
    gap_of,
    gap_of_spheres,
    gap_or_bound,
    is_near,
    keep_gap,
    may_be_least,
    stretches_in,
)
from .cracking import crack, until_broken
from .evaluate import moving
from .joint import bed_of_joint, penetration
from .kinematics import dot, pose_two, relative_motion, tilt_square
from .layout import APART, JOINED, PHASE, POINT
from .sides import SLACK
from .watch import BETWEEN, END, START, pose_between, row, way_of

_phase, _PER_BODY = PHASE.over, PHASE.per_n
INSIDE = 0.125 * SLACK  # m: overlap at which a step ends, where a flat contact exerts its whole damped force
MOST = 60  # most iterations
MOST_LOOKS = 10000.0  # most instants of a step at which a pair is looked at
# of a step: least part up to a gap that closes. The distance of drums jumps where their axes become parallel enough for
# sides, and a shorter step might not reach beyond
LEAST_PART = 1e-6
SHORTLY = 1e-6  # s: difference by which the rate of a gap is found
# after a fall a joint ends at a squared sine of half its tilt, 45 degrees, or a displacement over the size of its block
MOST_TILT, LEAST_ARM = 0.1464, 0.1
DEEPEST = 0.02  # of the size of a block: an overlap with the ground beyond the depth of the edge of a joint


@leaf
def kept_in(scene, k):
    """Return the table of pair stretches in row k of a step."""
    return stretches_in(scene, row(scene, k)[_PER_BODY * scene.n :])


@leaf
def _place(scene, k, p):
    """Place both bodies of pair p by row k of a step; return the phase."""
    phase = _phase(row(scene, k), scene.n)
    pose_two(scene, phase, int(scene.extras.pairs.one[p]), int(scene.extras.pairs.other[p]))
    return phase


@kernel
def gap_in(scene, k, p):
    """Return the gap of pair p, m, in row k of a step."""
    return gap_of(scene, _place(scene, k, p), scene.extras.pairs, p, kept_in(scene, START).touches[p], 0.0)


@kernel
def _gap_or_bound(scene, k, p):
    """Return the gap of pair p, m, in row k of a step, or a lower bound by which it is open."""
    return gap_or_bound(scene, _place(scene, k, p), p, kept_in(scene, START).touches[p], SLACK, 0.0)


@kernel
def meet(scene, t):
    """Update the contacts of pairs and break bonds by row START of a step, at time t, s; return True if any changed."""
    broke, changed = crack(scene, row(scene, START), True), meet_pairs(scene)
    if changed:
        note_first(scene, t)
    return changed or broke


@kernel
def note_first(scene, t):
    """Store when pairs first begin to touch, and the rate of their gaps then, by row START and its rates."""
    kept, hits = kept_in(scene, START), scene.extras.hits
    begin, later, rates = row(scene, START), row(scene, BETWEEN), rate(scene, 0)
    # shortly afterwards
    for k in range(_PER_BODY * scene.n):
        later[k] = begin[k] + SHORTLY * rates[k]
    for p in range(scene.extras.met):
        if kept.touches[p] > APART and hits.met[p] == 0.0:
            hits.met[p], hits.first[p] = 1.0, t
            hits.closing[p] = (gap_in(scene, BETWEEN, p) - gap_in(scene, START, p)) / SHORTLY


@kernel
def release_pairs(scene, ends):
    """Return True if the joints of a pair have come apart; `ends`: let them end, and the pair meet.

    Bodies without a joint that have passed into each other meet only once they are apart again.
    """
    kept, phase, found = kept_in(scene, START), _phase(row(scene, START), scene.n), False
    for p in range(scene.extras.met):
        if kept.touches[p] == JOINED and _is_apart(scene, phase, p):
            if _joint_between(scene, p) < 0 and _bodies_gap(scene, phase, p) < 0.0:
                continue
            found = True
            if ends:
                kept.touches[p] = APART
    return found


@kernel
def toppled(scene, phase):
    """Return the number, from 1, of a block in a run that goes on after a fall that has toppled; 0 if there is none.

    Its joint with the base is tilted beyond its end, and another part of it than its foot reaches into the ground.
    """
    for p in range(scene.extras.met):
        block = int(scene.extras.pairs.one[p])
        if _is_tilted(scene, phase, p):
            overlap = -_bodies_gap(scene, phase, p)
            if overlap > DEEPEST * scene.bodies.size[block] + _edge_depth(scene, phase, p):
                return block + 1
    return 0


@kernel
def _edge_depth(scene, phase, p):
    """Return the largest penetration of the joints between the bodies of pair p, m."""
    pose_two(scene, phase, int(scene.extras.pairs.one[p]), int(scene.extras.pairs.other[p]))
    depth = 0.0
    for j in range(scene.m):
        if _connects(scene, j, p):
            pressed = penetration(scene, j, relative_motion(scene, phase, j))
            depth = max(depth, bed_of_joint(scene, j, pressed, pressed).largest)
    return depth


@kernel
def release_flying(scene, phase):
    """Let the joints with the base end of blocks that are in the air, tilted beyond the end of these joints."""
    for p in range(scene.extras.met):
        if _is_tilted(scene, phase, p) and _bodies_gap(scene, phase, p) > SLACK:
            kept_in(scene, START).touches[p] = APART


@kernel
def _is_tilted(scene, phase, p):
    """Return True if pair p is one with the ground, and a joint of it with the base is tilted beyond its end."""
    if kept_in(scene, START).touches[p] != JOINED or int(scene.extras.pairs.other[p]) != scene.n:
        return False
    joint = _joint_between(scene, p)
    return joint >= 0 and tilt_square(scene, phase, joint) > MOST_TILT


@leaf
def _connects(scene, j, p):
    """Return True if joint j is between the bodies of pair p."""
    one, other = scene.extras.pairs.one[p], scene.extras.pairs.other[p]
    a, b = scene.joints.upper[j], scene.joints.lower[j]
    return (a == one and b == other) or (a == other and b == one)


@kernel
def _joint_between(scene, p):
    """Return the index of a joint between the bodies of pair p; -1 if there is none."""
    for j in range(scene.m):
        if _connects(scene, j, p):
            return j
    return -1


@kernel
def _bodies_gap(scene, phase, p):
    """Return the gap of the bodies of pair p, m, whether joints connect them or not."""
    pairs = scene.extras.pairs
    pose_two(scene, phase, int(pairs.one[p]), int(pairs.other[p]))
    return gap_of(scene, phase, pairs, p, APART, 0.0)


@kernel
def _is_apart(scene, phase, p):
    """Return True if all joints between the bodies of pair p have come apart."""
    pose_two(scene, phase, int(scene.extras.pairs.one[p]), int(scene.extras.pairs.other[p]))
    joints, apart = scene.joints, True
    for j in range(scene.m):
        if _connects(scene, j, p):
            # tilted far, displaced by more than the arm of the section, or a bearing by more than its capacity
            gap = relative_motion(scene, phase, j).gap
            far = dot(gap, gap) > max(joints.arm[j], LEAST_ARM * scene.bodies.size[int(joints.upper[j])]) ** 2
            if joints.section[j] == POINT:
                far = travel_left(scene, phase, j) < 0.0
            apart = apart and (far or tilt_square(scene, phase, j) > MOST_TILT)
    return apart


@kernel
def presume_pairs(scene, state):
    """Let all pairs that are near by a state without rates touch: those with an open gap exert nothing."""
    phase, kept = _phase(state, scene.n), stretches_in(scene, state[_PER_BODY * scene.n :])
    for p in range(scene.extras.met):
        if kept.touches[p] == APART and is_near(scene, phase, scene.extras.pairs, p):
            pose_two(scene, phase, int(scene.extras.pairs.one[p]), int(scene.extras.pairs.other[p]))
            kept.touches[p] = begins_by(scene, phase, scene.extras.pairs, p, DEEP)


@kernel
def settle_pairs(scene, state):
    """Update the contacts of pairs by a state without rates; return True if any changed."""
    if scene.extras.met == 0:
        return False
    begin = row(scene, START)
    copy(begin, state, moving(scene))
    forget_known_gaps(scene)
    forget_directions(scene)
    changed = meet_pairs(scene)
    copy(state, begin, moving(scene))
    return changed


@leaf
def changes(touches, gap):
    """Return True if a pair separates or starts to touch at a gap, m; touches: how it touches."""
    return gap > SLACK if touches != APART else gap <= 0.5 * SLACK


@leaf
def _may_meet(scene, phase, p, touches):
    """Return True if pair p is apart and its gap may be closed."""
    return touches == APART and may_be_least(scene, p, SLACK) and is_near(scene, phase, scene.extras.pairs, p)


@kernel
def meet_pairs(scene):
    """Update the contacts of pairs by row START, of one structure or of one lane; return True if any changed."""
    kept, phase, changed = kept_in(scene, START), _phase(row(scene, START), scene.n), False
    for p in range(scene.extras.met):
        touches = kept.touches[p]
        # pairs far apart need no distance
        near = touches > APART or _may_meet(scene, phase, p, touches)
        if near and changes(touches, _gap_or_bound(scene, START, p)):
            # contact changes, and starts without stretch
            begins = begins_by(scene, phase, scene.extras.pairs, p, SHALLOW) if touches == APART else APART
            kept.touches[p], kept.z1[p], kept.z2[p], kept.z3[p] = begins, 0.0, 0.0, 0.0
            changed = True
    return changed


@kernel
def part_until_met(scene, h, part):
    """Return the part of the step of h s just made until a gap closes or a bond starts to break, at most `part`."""
    kept, phase = kept_in(scene, START), _phase(row(scene, END), scene.n)
    # the first gap to close
    for p in range(scene.extras.met):
        if kept.touches[p] == APART and may_be_least(scene, p, SLACK):
            if is_near(scene, phase, scene.extras.pairs, p):
                gap = _gap_or_bound(scene, END, p)
                keep_gap(scene, p, gap)
            else:
                gap = gap_of_spheres(scene, phase, scene.extras.pairs, p)
            part = min(part, closing(scene, h, p, gap))
    # the first bond to break
    return min(part, until_broken(scene, h, True))


@kernel
def gap_at(scene, h, s, p):
    """Return the gap of pair p, m, at fraction s of a step of h s."""
    pairs, touches = scene.extras.pairs, kept_in(scene, START).touches[p]
    return gap_of(scene, pose_between(scene, h, s, int(pairs.one[p]), int(pairs.other[p])), pairs, p, touches, 0.0)


@kernel
def _passed(scene, h, p, gap):
    """Return a fraction of the step at which the bodies of pair p overlap, and their gap, m; 1 and `gap` if none.

    Bodies that are apart at the end may have passed through each other on a path as long as they are thick. gap: at
    the end, or a lower bound of it, m.
    """
    pairs = scene.extras.pairs
    one, other = int(pairs.one[p]), int(pairs.other[p])
    path = way_of(scene, h, one) + way_of(scene, h, other)
    if not path > gap:
        return 1.0, gap
    # instants between which they move about half of that; `path` is twice the way
    count = int(min(path / path_through(scene, pairs, p), MOST_LOOKS)) + 1
    for k in range(1, count):
        phase = pose_between(scene, h, k / count, one, other)
        if is_near(scene, phase, pairs, p):
            found = gap_of(scene, phase, pairs, p, APART, 0.0)
            if found < 0.0:
                return k / count, found
    if count > 1:
        _place(scene, END, p)  # restores the pose of its bodies at the end
    return 1.0, gap


@kernel
def closing(scene, h, p, below):
    """Return the fraction of the step after which the gap of pair p closes, by false position; 1 if it stays open.

    below: the gap at the end of the step, or a lower bound of it, m.
    """
    # open at the end, and before
    low, high = 0.0, 1.0
    if below >= -INSIDE:
        high, below = _passed(scene, h, p, below)
        if below >= -INSIDE:
            return 1.0
    # already closed at the start
    above = gap_in(scene, START, p)
    if above <= 0.0:
        gap_in(scene, END, p)  # restores the pose of its bodies at the end
        return 1.0
    # false position of the gap plus that overlap; the value at the end that stays is halved
    above, below = above + INSIDE, below + INSIDE
    for _ in range(MOST):
        s = low + (high - low) * above / (above - below)
        left = gap_at(scene, h, s, p) + INSIDE
        if abs(left) <= 0.5 * INSIDE:
            return s
        if left > 0.0:
            low, above, below = s, left, 0.5 * below
        else:
            high, below, above = s, left, 0.5 * above
    return max(high, LEAST_PART)


@kernel
def keep_slides(scene, lanes):
    """Store which pairs slide at the last evaluation, in the lanes of a mask: output rows and peaks evaluate, too."""
    hits = scene.extras.hits
    for p in range(scene.extras.met):
        hits.slid[p] = where(lanes, hits.slides[p], hits.slid[p])


@kernel
def longest_touching(scene):
    """Return the shortest time constant, s, of the contacts of pairs that touch, which bounds the step."""
    # over the pairs that touch at START
    pairs, hits = scene.extras.pairs, scene.extras.hits
    longest, kept = math.inf + zero_like(scene.settings.tolerance), kept_in(scene, START)
    for p in range(scene.extras.met):
        # damping across the contact, and of friction that slides
        touches = kept.touches[p] > APART
        longest = where(touches, lesser(longest, pairs.decay[p]), longest)
        longest = where(touches & (hits.slid[p] != 0.0), lesser(longest, pairs.shear_damping[p]), longest)
    return longest
