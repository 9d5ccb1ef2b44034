"""Steps end where a gap closes or a bond breaks: pairs touch or let go between two steps, and bonds break there."""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import lesser, where, zero_like
from .attempt import attempt
from .contact import gap_of, is_near, stretches_in
from .cracking import crack, until_broken
from .kinematics import pose_two
from .layout import PHASE
from .sides import SLACK
from .watch import END, START, gaps_in_row, pose_between, row

_phase, _PER_BODY = PHASE.over, PHASE.per_n
CLOSED = 0.25 * SLACK  # m: the gap at which a step ends
MOST = 60  # iterations


@leaf
def kept_in(scene, k):
    """What row k of a step remembers of pairs."""
    return stretches_in(scene, row(scene, k)[_PER_BODY * scene.n :])


@kernel
def gap_in(scene, k, p):
    """Gap of pair p, m, by row k of a step."""
    phase = _phase(row(scene, k), scene.n)
    pose_two(scene, phase, int(scene.extras.pairs.one[p]), int(scene.extras.pairs.other[p]))
    return gap_of(scene, phase, scene.extras.pairs, p)


@kernel
def meet(scene):
    """Let pairs touch or let go, and bonds break, as row START of a step says; whether forces have changed by it."""
    broke = crack(scene, row(scene, START), True)
    return meet_pairs(scene) or broke


@leaf
def changes(touches, gap):
    """Whether a pair that touches (1) or does not (0) lets go, or touches, at a gap, m."""
    return gap > SLACK if touches != 0.0 else gap <= 0.5 * SLACK


@kernel
def meet_pairs(scene):
    """`meet` of one structure, or of one of those in lanes."""
    kept, phase, changed = kept_in(scene, START), _phase(row(scene, START), scene.n), False
    for p in range(scene.extras.met):
        touches = kept.touches[p]
        near = touches != 0.0 or is_near(scene, phase, scene.extras.pairs, p)
        if near and changes(touches, gap_in(scene, START, p)):
            kept.touches[p], kept.z1[p], kept.z2[p], kept.z3[p] = 1.0 - touches, 0.0, 0.0, 0.0
            changed = True
    return changed


@kernel
def until_closed(scene, shaking, segment, t, h):
    """The length, s, of the step of h that has just been made.

    A shorter one replaces it where a gap closes in it or a bond begins to break.
    """
    kept, phase, part = kept_in(scene, START), _phase(row(scene, END), scene.n), 1.0
    for p in range(scene.extras.met):
        if kept.touches[p] == 0.0 and is_near(scene, phase, scene.extras.pairs, p):
            part = min(part, closing(scene, h, p, gap_in(scene, END, p)))
    part = min(part, until_broken(scene, h, True))
    if part < 1.0:
        h = part * h
        attempt(scene, shaking, segment, t, h)
    return h


@kernel
def gap_at(scene, h, s, p):
    """Gap of pair p, m, at fraction s of a step of h s."""
    pairs = scene.extras.pairs
    return gap_of(scene, pose_between(scene, h, s, int(pairs.one[p]), int(pairs.other[p])), pairs, p)


@kernel
def closing(scene, h, p, below):
    """The part of the step after which the gap of pair p, `below` at its end, is closed; 1 if it is open there.

    By false position.
    """
    if below >= 0.0:
        return 1.0
    low, above, high = 0.0, gap_in(scene, START, p), 1.0
    if above <= 0.0:
        gap_in(scene, END, p)  # so that its bodies are as they end
        return 1.0
    for _ in range(MOST):
        s = low + (high - low) * above / (above - below)
        gap = gap_at(scene, h, s, p)
        if abs(gap) <= CLOSED:
            return s
        if gap > 0.0:
            low, above, below = s, gap, 0.5 * below
        else:
            high, below, above = s, gap, 0.5 * above
    return high


@kernel
def longest_touching(scene):
    """The longest step, in time constants of what neighbours bear that touch, s."""
    return longest_by(scene, scene.extras.hits.slides)


@kernel
def longest_by(scene, slides):
    """`longest_touching`; slides: 1 of each pair whose friction gives way."""
    pairs, longest, kept = scene.extras.pairs, math.inf + zero_like(scene.settings.tolerance), kept_in(scene, START)
    for p in range(scene.extras.met):
        touches = kept.touches[p] != 0.0
        longest = where(touches, lesser(longest, pairs.decay[p]), longest)
        longest = where(touches & (slides[p] != 0.0), lesser(longest, pairs.shear_damping[p]), longest)
    return longest


@leaf
def clear_gaps(scene):
    """Forget the least gaps: the peaks of a run that begins."""
    first, end = gaps_in_row(scene)
    for place in range(first, end):
        scene.peaks[place] = -math.inf
