"""Steps of structures whose neighbours meet: a pair touches or lets go between two steps, and a gap ends the step."""

import math

from ..numba_ext.jit import kernel, leaf, varied
from .attempt import attempt
from .contact import gap_of, is_near, stretches_in
from .kinematics import pose_body
from .layout import PHASE, has_extras
from .sides import SLACK
from .watch import BETWEEN, END, START, gaps_in_row, interpolate_body, row

_phase, _PER_BODY = PHASE.over, PHASE.per_n
CLOSED = 0.25 * SLACK  # m: the gap at which a step ends
MOST = 60  # iterations


@leaf
def _kept(scene, k):
    """What row k of a step remembers of pairs."""
    return stretches_in(scene, row(scene, k)[_PER_BODY * scene.n :])


@kernel
def _gap_in(scene, k, p):
    """Gap of pair p, m, by row k of a step."""
    phase = _phase(row(scene, k), scene.n)
    for body in (int(scene.extras.pairs.one[p]), int(scene.extras.pairs.other[p])):
        if body < scene.n:
            pose_body(scene, phase, body)
    return gap_of(scene, phase, scene.extras.pairs, p)


@varied
def meet(scene):
    """Let pairs touch or let go, as row START of a step says; whether any has changed."""
    return False


@meet.version(has_extras)
def _meet(scene):
    kept, phase, changed = _kept(scene, START), _phase(row(scene, START), scene.n), False
    for p in range(scene.extras.met):
        touches = kept.touches[p] != 0.0
        if touches or is_near(scene, phase, scene.extras.pairs, p):
            gap = _gap_in(scene, START, p)
            if touches and gap > SLACK:
                kept.touches[p], kept.z1[p], kept.z2[p], kept.z3[p] = 0.0, 0.0, 0.0, 0.0
                changed = True
            elif not touches and gap <= 0.5 * SLACK:
                kept.touches[p], changed = 1.0, True
    return changed


@varied
def until_closed(scene, shaking, segment, t, h):
    """The length, s, of the step of h that has just been made; a shorter one replaces it where a gap closes in it."""
    return h


@until_closed.version(has_extras)
def _until_closed(scene, shaking, segment, t, h):
    kept, phase, part = _kept(scene, START), _phase(row(scene, END), scene.n), 1.0
    for p in range(scene.extras.met):
        if kept.touches[p] == 0.0 and is_near(scene, phase, scene.extras.pairs, p):
            part = min(part, _closing(scene, h, p))
    if part < 1.0:
        h = part * h
        attempt(scene, shaking, segment, t, h)
    return h


@kernel
def _gap_at(scene, h, s, p):
    for body in (int(scene.extras.pairs.one[p]), int(scene.extras.pairs.other[p])):
        if body < scene.n:
            interpolate_body(scene, h, s, body)
    return _gap_in(scene, BETWEEN, p)


@kernel
def _closing(scene, h, p):
    """The part of the step after which the gap of pair p is closed; 1 if it is open at its end: by false position."""
    low, above, high, below = 0.0, _gap_in(scene, START, p), 1.0, _gap_in(scene, END, p)
    if below >= 0.0 or above <= 0.0:
        return 1.0
    for _ in range(MOST):
        s = low + (high - low) * above / (above - below)
        gap = _gap_at(scene, h, s, p)
        if abs(gap) <= CLOSED:
            return s
        if gap > 0.0:
            low, above, below = s, gap, 0.5 * below
        else:
            high, below, above = s, gap, 0.5 * above
    return high


@varied
def longest_touching(scene):
    """The longest step, in time constants of what neighbours bear that touch, s."""
    return math.inf


@longest_touching.version(has_extras)
def _longest_touching(scene):
    extras, longest = scene.extras, math.inf
    kept = _kept(scene, START)
    for p in range(extras.met):
        if kept.touches[p] != 0.0:
            longest = min(longest, extras.pairs.decay[p])
            if extras.hits.slides[p] != 0.0:
                longest = min(longest, extras.pairs.shear_damping[p])
    return longest


@leaf
def clear_gaps(scene):
    """Forget the least gaps: the peaks of a run that begins."""
    first, end = gaps_in_row(scene)
    for place in range(first, end):
        scene.peaks[place] = -math.inf
