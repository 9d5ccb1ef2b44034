"""Steps of lanes in which pairs touch, lane by lane, or bonds break: meeting.py in lanes.

Where a gap closes or a bond starts to break in some lanes, the step is made again in all, shorter in these; the others
reproduce the same bits. A lane in which a pair touches or separates is evaluated again (`fresh`). The gaps at the end
of a step are in the output row of the end.
"""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import WIDTH, any_of, bits, lane, lesser, where, with_lane
from ..numba_ext.views import one_lane
from .attempt import attempt_5
from .contact import gap_of
from .contact_in_lanes import alone
from .cracking import until_broken
from .layout import APART, PHASE
from .meeting import changes, closing, gap_at, gap_in, kept_in, longest_touching, meet_pairs
from .watch import END, START, gaps_in_row, row, seen

_phase = PHASE.over


@kernel
def limited(scene, step, constants):
    """Return the step of each lane, s, limited to `constants` times the shortest time constant of pairs that touch."""
    return lesser(step, constants * longest_touching(scene))


@leaf
def _gaps(scene, k):
    """Return the gaps of lane k at the end of a step, m, at those of its output row."""
    return one_lane(seen(scene, 2)[gaps_in_row(scene)[0] :], k)


@kernel
def _closing_of_lane(scene, k, h):
    """Fill the gaps of lane k at the end of a step of h s; return its fraction after which the first gap closes."""
    # gaps at the end
    one, gaps, part = alone(scene, k), _gaps(scene, k), 1.0
    kept, phase = kept_in(one, START), _phase(row(one, END), one.n)
    for p in range(one.extras.met):
        # poses are those of the last evaluation, at the end
        gaps[p] = gap_of(one, phase, one.extras.pairs, p, kept.touches[p], 0.0)
    # the first to close
    for p in range(one.extras.met):
        if kept.touches[p] == APART:
            part = min(part, closing(one, h, p, gaps[p]))
    return part


@kernel
def until_closed(scene, t, step, good, parts):
    """Return the lengths, s, of the steps just made, shortened where a gap closes or a bond starts to break.

    good: mask of the lanes whose step has been accepted; parts: of the steps, to which they are shortened at least.
    """
    made = bits(good)
    # the first gap to close in each lane
    for k in range(WIDTH):
        if (made >> k) & 1:
            parts = with_lane(parts, k, min(lane(parts, k), _closing_of_lane(scene, k, lane(step, k))))
    parts = where(good, lesser(parts, until_broken(scene, step, good)), 1.0)
    # make the step again
    short = parts < 1.0
    if any_of(short):
        step = where(short, parts * step, step)
        attempt_5(scene, 0, t, step)
        # gaps at the new end
        again = bits(short)
        for k in range(WIDTH):
            if (again >> k) & 1:
                _closing_of_lane(scene, k, lane(step, k))
    return step


@kernel
def forget_gaps(scene, least):
    """Reset the least gaps of one lane, at the start of a run."""
    for p in range(scene.extras.met):
        least[p] = math.inf


@kernel
def watch_gaps(scene, least, step, good):
    """Lower the least gaps (`least`, m) by a step of the lanes in a mask.

    Return the bits of the lanes in which a pair touches or separates.
    """
    made, changed = bits(good), 0
    for k in range(WIDTH):
        if (made >> k) & 1:
            changed |= _watch_lane(scene, one_lane(least, k), k, lane(step, k)) << k
    return changed


@kernel
def _watch_lane(scene, least, k, h):
    """Lower the least gaps by the step of lane k, evaluated in the middle too; return 1 if a contact changes."""
    one, gaps, changed = alone(scene, k), _gaps(scene, k), 0
    kept = kept_in(one, START)
    for p in range(one.extras.met):
        # the gap at the end of the step
        touches, gap = kept.touches[p], gaps[p]
        least[p] = min(least[p], gap)
        if touches != 0.0:
            # the parabola through start, middle and end
            begin, middle = gap_in(one, START, p), gap_at(one, h, 0.5, p)
            bend, rise = begin + gap - 2.0 * middle, gap - begin
            if abs(rise) < 2.0 * bend:  # its vertex lies within the step
                least[p] = min(least[p], middle - rise * rise / (8.0 * bend))
        # the contact begins or ends
        changed |= 1 if changes(touches, gap) else 0
    return changed


@kernel
def meet(scene, least, fresh):
    """Update the contacts of pairs at the start of the steps of the lanes in the mask `fresh`."""
    begins = bits(fresh)
    for k in range(WIDTH):
        if (begins >> k) & 1:
            _meet_in(scene, one_lane(least, k), k)


@kernel
def _meet_in(scene, least, k):
    # contacts, then gaps at the start
    one = alone(scene, k)
    meet_pairs(one)
    for p in range(one.extras.met):
        least[p] = min(least[p], gap_in(one, START, p))
