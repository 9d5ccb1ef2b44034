"""Peaks of all outputs, including those between the output rows.

A step is sampled at its ends and half-way, where its method may have evaluated it. Parabolas through the three samples
show whether any quantity may exceed its peak within the step; mostly none does. Otherwise the step is evaluated at the
ends of its pieces. A polynomial through all of them gives the extremes of quantities that are smooth within the step;
if it is not accurate enough, parabolic interpolation repeats until the predicted gain is below a part of the tolerance.

In columns whose joints can slide all steps are examined.
"""

from ...engine.bracket import bracket, narrowed, trial_within
from ...engine.peaks import MARGIN, MOST_TRIALS, NEAR, apart, nearer, vertex
from ...layout.spaces import (
    COUNTS_FROM,
    OK,
    OUTPUTS,
    PEAKS,
    PIECES,
    ROW,
    SPOTS,
    STATE,
)
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import clear, copy
from ..formulations.base_motion import moved_and_loaded
from ..formulations.bonds import keep_bonds
from ..formulations.dispatch import base_as_shown
from ..formulations.loads import ports_of, scratch_of_ports
from ..formulations.outputs import show, show_ports
from ..formulations.slips import evaluate_after_jump, phase_size
from ..integrators.interpolation import interpolate_phase, refine
from ..integrators.stage import stage
from ..joint.sliding import can_slide

_peaks, _row = PEAKS.over, ROW.over
_PER_N, _BESIDE, _SEEN = PEAKS.per_n, PEAKS.beside, len(SPOTS.fields)
_STATE_PER_N, _STATE_BESIDE = STATE.per_n, STATE.beside
_OF_JOINTS = OUTPUTS.per_n
_CONTACT = OUTPUTS.fields.index("contact")
_FRICTION = (PEAKS.per_n - 1, PEAKS.beside)  # first place: per n, and beside

MIDDLE = PIECES // 2
PROMISE = 0.1  # of the tolerance: a peak whose predicted rise is smaller has been found
QUIET = 1e-3  # of the largest peak in the column: smaller peaks are searched to a tolerance relative to this
SURE = 3.0  # of that tolerance: largest highest term with which a polynomial is accepted


@kernel
def clear_peaks(column):
    """Set all peaks to zero, including those of the ports."""
    n, state = column.model.n, column.state
    clear(state.peaks, _PER_N * n + _BESIDE)
    clear(state.buffer[_STATE_PER_N * n + _STATE_BESIDE :], _SEEN * ports_of(column))


@kernel
def begin_extremes(column, motion, evaluated):
    """Sample the start of a step that does not continue the last one, and raise the peaks by it.

    Parameters
    ----------
    column : Column
        The column, with the phase in `work.start`.
    motion : Motion
        The motion of the base.
    evaluated : bool
        True if `work.joints` belongs to the start.
    """
    model, work = column.model, column.work
    n, carried = model.n, 0.0
    for i in range(n):
        # N below which friction is not evaluated: a part of the carried weight
        carried += model.settings.gravity * model.blocks.mass[i]
        work.counts_from[i] = COUNTS_FROM * carried
    end = _seen(work, PIECES)  # as if a step had ended there
    # outputs at the start
    if evaluated:
        _show(column, work.start, work.joints, motion, end)
    else:
        copy(work.between.row, work.start.row, phase_size(work))
        _see(column, motion, end)
    _raise_peaks(column, end)
    _allow(column)


@kernel
def track_extremes(column, t, h):
    """Raise the peaks by the step just made from t to t + h (s); `work.joints` holds the resultants of its end."""
    work = column.work
    n = column.model.n
    # samples at start, end and middle
    begin, end = _seen(work, 0), _seen(work, PIECES)
    for j in range(_PER_N * n + _BESIDE):
        begin[j] = end[j]
    _show(column, work.end, work.joints, base_as_shown(column, t + h), end)
    roughly = _see_middle(column, t, h)
    # mostly no quantity can exceed its peak within
    if not _raise_by_end(column) and not _examines_all(column):
        return
    # samples at the ends of the pieces, and the extremes between them
    for k in range(1, PIECES):
        if k != MIDDLE or roughly:
            _see_within(column, t, h, k / PIECES, _seen(work, k))
        _raise_peaks(column, _seen(work, k))
    _find_tops(column, t, h)
    _allow(column)


# --- within a step


@leaf
def _largest(peaks, first, end):
    """Return the largest of peaks[first:end], by four maxima: a chain of one would wait for each before the next."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    for j in range(first, end - 3, 4):
        a, b, c, d = max(a, peaks[j]), max(b, peaks[j + 1]), max(c, peaks[j + 2]), max(d, peaks[j + 3])
    for j in range(end - (end - first) % 4, end):
        a = max(a, peaks[j])
    return max(a, b, c, d)


@kernel
def _allow(column):
    """Set the amount by which each quantity may exceed its peak without a search."""
    n, peaks, allowed = column.model.n, column.state.peaks, column.work.allowed
    part = PROMISE * column.model.settings.tolerance
    for field in range(_PER_N):
        first = field * n if field < _OF_JOINTS else field * n + _BESIDE
        # largest peak of the field
        largest = _largest(peaks, first, first + n)
        # of each quantity, relative to its peak and to the largest one in the column
        for j in range(first, first + n):
            allowed[j] = part * max(peaks[j], QUIET * largest)
    # quantities without index: each by itself
    for j in range(_OF_JOINTS * n, _OF_JOINTS * n + _BESIDE):
        allowed[j] = part * peaks[j]


@kernel
def _show(column, phase, resultants, motion, seen):
    """Fill `seen` with all outputs but u_x of an evaluated phase, in the order of PEAKS."""
    n, from_ = column.model.n, column.work.counts_from
    show(column, phase, resultants, motion, _row(seen, n))
    visible = _peaks(seen, n)
    for i in range(n):
        # |T| / N, and the part of the width out of contact
        normal = visible.joints.N[i]
        visible.friction[i] = abs(visible.joints.T[i]) / normal if normal > from_[i] else 0.0
        visible.joints.contact[i] = 1.0 - visible.joints.contact[i]
    if ports_of(column) > 0:
        _raise_port_peaks(column, phase, motion)


@kernel
def _raise_port_peaks(column, phase, motion):
    """Raise the peaks of the ports, behind the state, by their motion in an evaluated phase."""
    n = column.model.n
    # outputs of the ports into a scratch row
    peaks, scratch = column.state.buffer[_STATE_PER_N * n + _STATE_BESIDE :], scratch_of_ports(column)
    show_ports(column, phase, motion, scratch)
    for j in range(_SEEN * ports_of(column)):
        peaks[j] = max(peaks[j], abs(scratch[j]))


@leaf
def _examines_all(column):
    """Return True if every step is examined, since quantities that the row does not show may exceed their peaks."""
    return can_slide(column.model) or ports_of(column) > 0


@kernel
def _see(column, motion, seen):
    """Evaluate `work.between` on a base and fill `seen` with its outputs; leave `seen` unchanged if that fails."""
    between, joints = column.work.between, column.work.joints
    if evaluate_after_jump(column, between, motion) == OK:
        _show(column, between, joints, motion, seen)


@kernel
def _see_within(column, t, h, s, seen):
    """Fill `seen` with the outputs at fraction s of the step from t to t + h."""
    work = column.work
    # phase within the step, and outputs under base motion and loads of that instant
    interpolate_phase(work, h, s)
    copy(work.between.sliding, work.end.sliding, int(work.slips.count))  # the joints slide as during the step
    keep_bonds(work, work.between)
    _see(column, moved_and_loaded(column, t + s * h), seen)


@kernel
def _raise_peaks(column, seen):
    """Raise the peaks by the values in `seen`."""
    n, peaks = column.model.n, column.state.peaks
    for j in range(n, _PER_N * n + _BESIDE):  # u_x on a rotating base counts relative to it
        peaks[j] = max(peaks[j], abs(seen[j]))


@kernel
def _look(column, t, h, s):
    """Raise the peaks by the outputs at fraction s of the step; return these."""
    trial = _seen(column.work, PIECES + 1)
    _see_within(column, t, h, s, trial)
    _raise_peaks(column, trial)
    return trial


@leaf
def _seen(work, k):
    """Return the row of outputs at the end of piece k of the step, PEAKS; two more rows are for trials and marks."""
    return work.seen[k * (_PER_N * work.n + _BESIDE) :]


@kernel
def _see_middle(column, t, h):
    """Sample the middle of the step; return True if it is approximate, as the method or `refine` has evaluated it."""
    work, middle = column.work, _seen(column.work, MIDDLE)
    refines, known = work.interpolation.wants_bump != 0.0, work.interpolation.knows_middle != 0.0
    refine(column, t, h)
    # a middle that is not evaluated: interpolate it
    if can_slide(column.model) or not (refines or known):
        _see_within(column, t, h, MIDDLE / PIECES, middle)
        return False
    # outputs of the phase evaluated by the method or by `refine`
    motion = base_as_shown(column, t + h * (MIDDLE / PIECES))
    if known:
        _show(column, stage(work, 1), work.joints_halfway, motion, middle)
    else:
        _show(column, work.between, work.joints, motion, middle)
    return True


@kernel
def _raise_by_end(column):
    """Raise the peaks by the end of the step; return True if any quantity may exceed its peak within.

    Loops without branches: a processor takes eight quantities at a time.
    """
    work, peaks = column.work, column.state.peaks
    n, from_ = column.model.n, work.counts_from
    first, middle, last = _seen(work, 0), _seen(work, MIDDLE), _seen(work, PIECES)
    found = 0
    for j in range(n, _PER_N * n + _BESIDE):
        # parabola through the three samples, the middle one taken positive
        f_0, f_1, f_2 = first[j], middle[j], last[j]
        sign = -1.0 if f_1 < 0.0 else 1.0
        bend, rise = sign * (2.0 * f_1 - f_0 - f_2), f_2 - f_0
        peaks[j] = max(peaks[j], abs(f_2))
        beyond = abs(f_1) + MARGIN * bend - (peaks[j] + work.allowed[j])
        turns = min(NEAR * bend - abs(rise), rise * rise + 8.0 * bend * beyond)
        found += 1 if turns > 0.0 else 0
    first, middle, last = _peaks(first, n).joints, _peaks(middle, n).joints, _peaks(last, n).joints
    peaks, allowed = _peaks(peaks, n).friction, _peaks(work.allowed, n).friction
    for i in range(n):  # T / N is not a parabola where it begins to count
        f_0, f_1, f_2 = first.N[i] - from_[i], middle.N[i] - from_[i], last.N[i] - from_[i]
        along = max(abs(first.T[i]), abs(middle.T[i]), abs(last.T[i]))
        most = (peaks[i] + allowed[i]) * from_[i]
        found += 1 if min(f_0 * f_1, f_1 * f_2) < 0.0 and along > most else 0
    return found > 0


@leaf
def _mark_tops(seen, peaks, allowed, first, size, marks):
    """Fill `marks`, positive where a parabola through three neighbours of the samples in a step may exceed a peak.

    Inside, it exceeds the largest of them by a quarter of their range at most. One loop without a branch: a processor
    takes eight quantities at a time.
    """
    for j in range(first, size):
        f_0, f_1, f_2, f_3 = seen[j], seen[size + j], seen[2 * size + j], seen[3 * size + j]
        f_4 = seen[4 * size + j]
        a, b, c, d = f_1 - f_0, f_2 - f_1, f_3 - f_2, f_4 - f_3
        # slope at an end of a parabola: three times the near difference less the far one
        turns = min((3.0 * a - b) * (3.0 * b - a), (3.0 * b - c) * (3.0 * c - b), (3.0 * c - d) * (3.0 * d - c))
        least, most = min(f_0, f_1, f_2, f_3, f_4), max(f_0, f_1, f_2, f_3, f_4)
        beyond = max(most, -least) + 0.25 * (most - least) - (peaks[j] + allowed[j])
        marks[j] = beyond if turns < 0.0 else -1.0


@leaf
def _top(f_0, f_1, f_2, f_3, f_4, near):
    """Return (place, height, highest term) of the top next to `near` of the quartic through values at 0, 1 ... 4."""
    rise, fall = f_3 - f_1, f_4 - f_0
    sides, ends = f_1 + f_3, f_0 + f_4
    # coefficients about the middle
    c1, c2 = (8.0 * rise - fall) / 12.0, (16.0 * sides - ends - 30.0 * f_2) / 24.0
    c3, c4 = (fall - 2.0 * rise) / 12.0, (ends - 4.0 * sides + 6.0 * f_2) / 24.0
    x = near - 2.0
    # Newton's method for the zero of the slope
    for _ in range(3):
        bend = 2.0 * c2 + x * (6.0 * c3 + x * 12.0 * c4)
        if not bend < 0.0:
            break
        x = min(2.0, max(-2.0, x - (c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4))) / bend))
    # value there, and its quartic term
    height = f_2 + x * (c1 + x * (c2 + x * (c3 + x * c4)))
    far = -2.0 if x > 0.0 else 2.0  # the end that the cubic does not use
    return x + 2.0, height, c4 * (x + far) * (x + 1.0) * x * (x - 1.0)


@kernel
def _climb(column, t, h, j, sign, known, s, height):
    """Search the extreme of quantity j in a step, expected at its fraction s with the value `height`.

    known: three fractions of the step in ascending order, each with the value there; the second value is the largest.
    """
    work, peaks = column.work, column.state.peaks
    # a few trials by parabolas
    for _ in range(MOST_TRIALS):
        a, _, _, _, c, _ = known
        # stop where the predicted gain is below the allowed one
        if not height > peaks[j] + work.allowed[j]:
            return
        s = apart(known, s)
        if not a < s < c:
            return
        # evaluate, and predict the next top
        f_s = sign * _look(column, t, h, s)[j]
        known = nearer(known, s, f_s)
        s, height = vertex(*known)


@kernel
def _find_top(column, t, h, j, size):
    """Raise the peak of quantity j by its highest top within the step."""
    n, seen, peaks, allowed = column.model.n, column.work.seen, column.state.peaks, column.work.allowed[j]
    # highest top of the parabolas through three neighbours
    best, place, at, way = 0.0, 0.0, 0, 1.0
    for k in range(1, PIECES):
        sign = -1.0 if seen[k * size + j] < 0.0 else 1.0
        f_a, f_b, f_c = sign * seen[(k - 1) * size + j], sign * seen[k * size + j], sign * seen[(k + 1) * size + j]
        x, height = vertex(k - 1.0, f_a, k, f_b, k + 1.0, f_c)
        if height > best:
            best, place, at, way = height, x, k, sign
    if not best > peaks[j] + allowed:
        return
    # accept the top of the quartic if its highest term is small
    f_0, f_1, f_2, f_3, f_4 = seen[j], seen[size + j], seen[2 * size + j], seen[3 * size + j], seen[4 * size + j]
    f = (way * f_0, way * f_1, way * f_2, way * f_3, way * f_4)
    x, height, term = _top(*f, place)
    if not abs(x - at) < 1.0:
        x, height = place, best
    elif abs(term) <= SURE * allowed:
        peaks[j] = max(peaks[j], min(height, 1.0) if j // n == _CONTACT else height)
        return
    # else evaluate near the top of the parabola
    known = ((at - 1) / PIECES, f[at - 1], at / PIECES, f[at], (at + 1) / PIECES, f[at + 1])
    _climb(column, t, h, j, way, known, x / PIECES, height)


@kernel
def _cross(column, t, h, i, weight, lo, f_lo, hi, f_hi):
    """Evaluate where N of joint i crosses `weight` (N) in a piece of the step: there T / N begins to count."""
    n = column.model.n
    enough = column.model.settings.tolerance * weight
    way = 1.0 if f_lo > 0.0 else -1.0
    # bracketed root of N - weight
    known = bracket(lo, hi, way * f_lo, way * f_hi)
    for _ in range(2 * MOST_TRIALS):
        s = trial_within(known)
        f_s = _peaks(_look(column, t, h, s), n).joints.N[i] - weight
        # N is just above the weight
        if 0.0 <= f_s <= enough:
            return
        known = narrowed(known, s, way * f_s)


@kernel
def _find_tops(column, t, h):
    """Raise the peaks by the extremes between the samples in `work.seen`."""
    model, work, peaks = column.model, column.work, column.state.peaks
    n, seen = model.n, work.seen
    size = _PER_N * n + _BESIDE
    first = _FRICTION[0] * n + _FRICTION[1]
    # tops of all quantities that may exceed their peaks
    marks = _seen(work, PIECES + 2)
    _mark_tops(seen, peaks, work.allowed, n, size, marks)
    for j in range(n, size):
        if marks[j] > 0.0:
            _find_top(column, t, h, j, size)
    for i in range(n):
        # friction ratio at the instants from which on it counts
        weight = work.counts_from[i]
        for k in range(PIECES):
            here, there = _peaks(_seen(work, k), n).joints, _peaks(_seen(work, k + 1), n).joints
            f_lo, f_hi = here.N[i] - weight, there.N[i] - weight
            # the ratio may exceed its peak in this piece
            along = max(abs(here.T[i]), abs(there.T[i]))
            if f_lo * f_hi < 0.0 and along > (peaks[first + i] + work.allowed[first + i]) * weight:
                _cross(column, t, h, i, weight, k / PIECES, f_lo, (k + 1) / PIECES, f_hi)
