"""Steps of lanes in which neighbours meet, lane by lane, or bonds break: as meeting.py.

Where a gap closes or a bond begins to break in some lanes, the step is made again by all, in these with a shorter
length; the others find the same bits. A lane in which a pair touches or lets go is evaluated again (`fresh`). The gap
of each pair at the end of a step stands where an output row has it.
"""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import WIDTH, any_of, bits, lane, lesser, splat, where, with_lane
from ..numba_ext.views import one_lane
from .attempt import attempt_5
from .contact import gap_of
from .contact_in_lanes import alone
from .cracking import until_broken
from .layout import PHASE
from .meeting import changes, closing, gap_at, gap_in, kept_in, longest_by, meet_pairs
from .watch import END, START, gaps_in_row, row, seen

_phase = PHASE.over


@kernel
def limited(scene, step, constants):
    """A step of each lane, s, at most this number of time constants of what neighbours bear that touch."""
    return lesser(step, constants * longest_by(scene, _of_pairs(scene, 0)))


@leaf
def _of_pairs(scene, k):
    """Room for a number of each pair, where output row k has the gaps: in row 0 what slides at the start of a step."""
    return seen(scene, k)[gaps_in_row(scene)[0] :]


@leaf
def _gaps(scene, k):
    """Gaps of lane k at the end of a step, m."""
    return one_lane(_of_pairs(scene, 2), k)


@kernel
def keep_slides(scene, lanes):
    """Keep which pairs slide by the last evaluation, of the lanes in a mask: other lanes may ask for more of them."""
    kept, slides = _of_pairs(scene, 0), scene.extras.hits.slides
    for p in range(scene.extras.met):
        kept[p] = where(lanes, slides[p], kept[p])


@kernel
def _closing_in(scene, k, h):
    """Take the gaps of lane k at the end of a step of h s; the part of it after which the first one closes."""
    one, gaps, part = alone(scene, k), _gaps(scene, k), 1.0
    kept, phase = kept_in(one, START), _phase(row(one, END), one.n)
    for p in range(one.extras.met):
        gaps[p] = gap_of(one, phase, one.extras.pairs, p)  # bodies are as they have been evaluated last, at the end
    for p in range(one.extras.met):
        if kept.touches[p] == 0.0:
            part = min(part, closing(one, h, p, gaps[p]))
    return part


@kernel
def until_closed(scene, shaking, t, step, good):
    """The steps, s, of the lanes in the mask `good` that have just been made.

    Shortened where a gap closes or a bond begins to break.
    """
    made, parts = bits(good), splat(1.0)
    for k in range(WIDTH):
        if (made >> k) & 1:
            parts = with_lane(parts, k, _closing_in(scene, k, lane(step, k)))
    parts = where(good, lesser(parts, until_broken(scene, step, good)), 1.0)
    short = parts < 1.0
    if any_of(short):
        step = where(short, parts * step, step)
        attempt_5(scene, shaking, 0, t, step)
        again = bits(short)
        for k in range(WIDTH):
            if (again >> k) & 1:
                _closing_in(scene, k, lane(step, k))
    return step


@kernel
def forget_gaps(scene, least):
    """The least gaps of a run that begins in one lane."""
    for p in range(scene.extras.met):
        least[p] = math.inf


@kernel
def watch_gaps(scene, least, step, good):
    """Lower the least gaps by a step of the lanes in a mask; the bits of lanes in which a pair touches or lets go then.

    least: as many as there are pairs, m.
    """
    made, changed = bits(good), 0
    for k in range(WIDTH):
        if (made >> k) & 1:
            changed |= _watch_lane(scene, one_lane(least, k), k, lane(step, k)) << k
    return changed


@kernel
def _watch_lane(scene, least, k, h):
    """As `watch_gaps`, of lane k; a pair that touches is looked at half-way too."""
    one, gaps, changed = alone(scene, k), _gaps(scene, k), 0
    kept = kept_in(one, START)
    for p in range(one.extras.met):
        touches, gap = kept.touches[p], gaps[p]
        least[p] = min(least[p], gap)
        if touches != 0.0:
            begin, middle = gap_in(one, START, p), gap_at(one, h, 0.5, p)
            bend, rise = begin + gap - 2.0 * middle, gap - begin
            if abs(rise) < 2.0 * bend:  # the parabola through the three has its vertex within
                least[p] = min(least[p], middle - rise * rise / (8.0 * bend))
        changed |= 1 if changes(touches, gap) else 0
    return changed


@kernel
def meet(scene, least, fresh):
    """Let pairs touch or let go at the start of the steps of the lanes in a mask."""
    begins = bits(fresh)
    for k in range(WIDTH):
        if (begins >> k) & 1:
            _meet_in(scene, one_lane(least, k), k)


@kernel
def _meet_in(scene, least, k):
    one = alone(scene, k)
    meet_pairs(one)
    for p in range(one.extras.met):
        least[p] = min(least[p], gap_in(one, START, p))
