"""Adaptive steps of Dormand and Prince's order 5 (integrators/dormand_prince.py) for structures in space.

Quaternions are scaled to unit length, and elastic slips kept, at the end of each step. A step ends at each sample of
the record.
"""

import math

from ..integrators import dormand_prince as dp
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import packs, packs_of
from ..stepping.control import LEAST_ERROR, SAFETY, SHRINK, growth
from .base import acceleration, is_quiet, segment_after
from .evaluate import evaluate, show
from .layout import MEMORY, OK, PAUSED, PHASE, STAGES, STEP_TOO_SMALL, row_size
from .watch import BETWEEN, END, RATES, STAGE, START, look, raise_peaks, row, seen, track_peaks

_phase = PHASE.over
_PER_BODY, _PER_JOINT = PHASE.per_n, MEMORY.per_n
SLACK = 1e-9  # of a step: times closer than this are the same
LEAST_STEP = 1e-13  # of the time scale
STILL = 1e-8  # of gravity, and of the rates that errors are measured against: less is rest


@leaf
def _rate(scene, k):
    return row(scene, RATES + k)


@kernel
def _evaluate_at(scene, shaking, segment, y, f, t):
    scene.counts.evaluations += 1
    ax, ay, az = acceleration(shaking, segment, t)
    evaluate(scene, _phase(y, scene.n), _phase(f, scene.n), ax, ay, az)


@kernel
def _scale_quaternions(n, phase):
    for i in range(n):
        q0, q1, q2, q3 = phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
        per = 1.0 / math.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
        phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i] = per * q0, per * q1, per * q2, per * q3


@kernel
def _attempt(scene, shaking, segment, t, h):
    """One step of h seconds from the row START to END; returns the error in tolerances."""
    begin, middle, ending = row(scene, START), row(scene, STAGE), row(scene, END)
    count = packs(begin, _PER_BODY * scene.n)
    y, stage, end = packs_of(begin), packs_of(middle), packs_of(ending)
    f0, f1, f2 = packs_of(_rate(scene, 0)), packs_of(_rate(scene, 1)), packs_of(_rate(scene, 2))
    f3, f4, f5 = packs_of(_rate(scene, 3)), packs_of(_rate(scene, 4)), packs_of(_rate(scene, 5))
    last, error = packs_of(_rate(scene, STAGES - 1)), packs_of(row(scene, BETWEEN))
    for i in range(count):
        stage[i] = y[i] + h * (dp.A1_0 * f0[i])
    _evaluate_at(scene, shaking, segment, middle, _rate(scene, 1), t + dp.C1 * h)
    for i in range(count):
        stage[i] = y[i] + h * (dp.A2_0 * f0[i] + dp.A2_1 * f1[i])
    _evaluate_at(scene, shaking, segment, middle, _rate(scene, 2), t + dp.C2 * h)
    for i in range(count):
        stage[i] = y[i] + h * (dp.A3_0 * f0[i] + dp.A3_1 * f1[i] + dp.A3_2 * f2[i])
    _evaluate_at(scene, shaking, segment, middle, _rate(scene, 3), t + dp.C3 * h)
    for i in range(count):
        stage[i] = y[i] + h * (dp.A4_0 * f0[i] + dp.A4_1 * f1[i] + dp.A4_2 * f2[i] + dp.A4_3 * f3[i])
    _evaluate_at(scene, shaking, segment, middle, _rate(scene, 4), t + dp.C4 * h)
    for i in range(count):
        early = dp.A5_0 * f0[i] + dp.A5_1 * f1[i] + dp.A5_2 * f2[i]
        stage[i] = y[i] + h * (early + dp.A5_3 * f3[i] + dp.A5_4 * f4[i])
    _evaluate_at(scene, shaking, segment, middle, _rate(scene, 5), t + dp.C5 * h)
    for i in range(count):
        end[i] = y[i] + h * (dp.B_0 * f0[i] + dp.B_2 * f2[i] + dp.B_3 * f3[i] + dp.B_4 * f4[i] + dp.B_5 * f5[i])
    _scale_quaternions(scene.n, _phase(ending, scene.n))
    _evaluate_at(scene, shaking, segment, ending, _rate(scene, STAGES - 1), t + h)
    for i in range(count):
        early = dp.ERROR_0 * f0[i] + dp.ERROR_2 * f2[i] + dp.ERROR_3 * f3[i]
        error[i] = h * (early + dp.ERROR_4 * f4[i] + dp.ERROR_5 * f5[i] + dp.ERROR_LAST * last[i])
    return _error_in_tolerances(scene, _phase(row(scene, BETWEEN), scene.n))


@leaf
def _size(x, y, z):
    return math.sqrt(x * x + y * y + z * z)


@kernel
def _error_in_tolerances(scene, error):
    """Largest error of a place or rate over the allowed one: the tolerance times the largest motion so far, in rad.

    Displacements of a body count over its size.
    """
    place, rate = 0.0, 0.0
    for i in range(scene.n):
        per = 1.0 / scene.bodies.size[i]
        parts = (
            per * _size(error.ux[i], error.uy[i], error.uz[i]),
            2.0 * (abs(error.q0[i]) + _size(error.q1[i], error.q2[i], error.q3[i])),
            per * _size(error.vx[i], error.vy[i], error.vz[i]),
            _size(error.wx[i], error.wy[i], error.wz[i]),
        )
        # NaN stays
        place = place if parts[0] <= place else parts[0]
        place = place if parts[1] <= place else parts[1]
        rate = rate if parts[2] <= rate else parts[2]
        rate = rate if parts[3] <= rate else parts[3]
    control, tolerance = scene.control, scene.settings.tolerance
    place, rate = place / (tolerance * control.largest), rate / (tolerance * control.largest_rate)
    return rate if not place > rate else place


@kernel
def _take_stock(scene, phase):
    """Note the largest motion so far, rad and rad/s; displacements count over the extent of the structure."""
    control, per = scene.control, 1.0 / scene.settings.extent
    place, rate = control.largest, control.largest_rate
    for i in range(scene.n):
        place = max(place, per * _size(phase.ux[i], phase.uy[i], phase.uz[i]))
        place = max(place, 2.0 * _size(phase.q1[i], phase.q2[i], phase.q3[i]))
        rate = max(rate, per * _size(phase.vx[i], phase.vy[i], phase.vz[i]))
        rate = max(rate, _size(phase.wx[i], phase.wy[i], phase.wz[i]))
    control.largest, control.largest_rate = place, rate


@kernel
def note(scene):
    """Note the elastic slips, and the lengths of ties, of the phase just evaluated, for `remember`."""
    kept, found = scene.kept, scene.resultants
    for j in range(scene.m):
        kept.p1[j], kept.p2[j], kept.p3[j] = found.p1[j], found.p2[j], found.p3[j]
    for e in range(scene.k):
        scene.kept_plastic[e] = scene.pulls.plastic[e]


@kernel
def remember(scene):
    """Go on from what was noted; whether any joint has slid."""
    memory, kept = scene.memory, scene.kept
    slides = False
    for place in range(_PER_JOINT * scene.m):
        slides = slides or memory.row[place] != kept.row[place]
        memory.row[place] = kept.row[place]
    for e in range(scene.k):
        scene.plastic[e] = scene.kept_plastic[e]
    return slides


@kernel
def _fallen(scene, phase):
    """Number, from 1, of a block that lies far below its place as built; 0 if there is none."""
    for i in range(scene.n):
        if not phase.uz[i] > -scene.bodies.drop[i]:
            return i + 1
    return 0


@kernel
def _rests(scene, phase, rates):
    """Whether nothing moves, nor begins to."""
    rate, force = STILL * scene.settings.rate_floor, STILL * scene.settings.gravity
    for i in range(scene.n):
        moves = _size(phase.vx[i], phase.vy[i], phase.vz[i]) > rate * scene.bodies.size[i]
        moves = moves or _size(phase.wx[i], phase.wy[i], phase.wz[i]) > rate
        starts = _size(rates.vx[i], rates.vy[i], rates.vz[i]) > force
        starts = starts or _size(rates.wx[i], rates.wy[i], rates.wz[i]) * scene.bodies.size[i] > force
        if moves or starts:
            return False
    return True


@leaf
def _shared(step, left):
    """The next step where `left` s remain: two equal ones rather than one and a very short one."""
    if step * (1.0 + SLACK) >= left:
        return left
    return 0.5 * left if 2.0 * step > left else step


@kernel
def _serve_rows(scene, shaking, watch, segment, t, h):
    """Take the output rows whose time lies within the step from t to t + h."""
    counts, size = scene.counts, row_size(scene.n, scene.m, scene.k)
    while counts.next_row < watch.size and watch.times[counts.next_row] <= t + h * (1.0 + SLACK):
        part = 1.0 if h == 0.0 else min(1.0, max(0.0, (watch.times[counts.next_row] - t) / h))
        look(scene, shaking, segment, t, h, part, watch.rows[counts.next_row * size :])
        counts.next_row += 1


@kernel
def _begin(scene, shaking, segment, t, phase):
    """Evaluate the phase from which the steps go on; the first call sets scales and the first step."""
    control, counts, settings = scene.control, scene.counts, scene.settings
    _evaluate_at(scene, shaking, segment, row(scene, START), _rate(scene, 0), t)
    if counts.started == 0:
        counts.started = 1
        control.next_step, control.previous_error = settings.first_step, 1.0
        control.largest = max(control.largest, settings.motion_floor)
        control.largest_rate = max(control.largest_rate, settings.rate_floor)
        _take_stock(scene, phase)
    show(scene, phase, seen(scene, 0))
    raise_peaks(scene, seen(scene, 0))


@kernel
def _finish(scene, shaking, watch, segment, t, h):
    """Go on from the end of a step: peaks, rows, slips, fall."""
    n = scene.n
    end, begin = row(scene, END), row(scene, START)
    phase = _phase(end, n)
    scene.counts.steps += 1
    _take_stock(scene, phase)
    note(scene)
    track_peaks(scene, shaking, segment, t, h)
    _serve_rows(scene, shaking, watch, segment, t, h)
    fallen = _fallen(scene, phase)
    if fallen > 0:
        scene.counts.fallen, scene.control.fall_time = fallen, t + h
    slides = remember(scene)
    for i in range(_PER_BODY * n):
        begin[i] = end[i]
        _rate(scene, 0)[i] = _rate(scene, STAGES - 1)[i]
    if slides:  # the direction of the force may have turned
        _evaluate_at(scene, shaking, segment, begin, _rate(scene, 0), t + h)


@kernel
def advance(scene, shaking, watch, phase, t, stop, most):
    """Take the structure from t to `stop`, s, in at most `most` steps; it is at `control.reached`. Returns a code.

    phase: that at t, replaced by the one reached. A structure that has fallen keeps its state.
    """
    control, counts = scene.control, scene.counts
    begin = row(scene, START)
    for i in range(_PER_BODY * scene.n):
        begin[i] = phase[i]
    segment = segment_after(shaking, t)
    _begin(scene, shaking, segment, t, _phase(begin, scene.n))
    code, made = OK, 0
    while t < stop and counts.fallen == 0:
        if made == most:
            code = PAUSED
            break
        made += 1
        if is_quiet(shaking, segment) and _rests(scene, _phase(begin, scene.n), _phase(_rate(scene, 0), scene.n)):
            counts.resting = 1
            t = stop
            break
        end = stop
        if segment + 1 < shaking.size and shaking.times[segment + 1] < stop:
            end = shaking.times[segment + 1]
        most_step = control.next_step
        if shaking.base.omega != 0.0:
            most_step = min(most_step, 1.0 / shaking.base.omega)
        h = _shared(most_step, end - t)
        error = _attempt(scene, shaking, segment, t, h)
        if not error <= 1.0:
            counts.rejected += 1
            factor = max(SHRINK, SAFETY * error**-0.2) if math.isfinite(error) else SHRINK
            control.next_step, control.previous_error = h * factor, 1.0
            if control.next_step < LEAST_STEP * max(scene.settings.first_step, abs(t)):
                code = STEP_TOO_SMALL
                break
            continue
        error = max(error, LEAST_ERROR)
        factor = growth(control.previous_error, error, 1.0 / dp.ORDER)
        if h >= control.next_step * (1.0 - SLACK):
            control.previous_error = error
        control.next_step = h * factor if factor < 1.0 else max(h * factor, control.next_step)
        _finish(scene, shaking, watch, segment, t, h)
        t = end if h == end - t else t + h
        if t == end and end < stop:
            segment = segment_after(shaking, t)
            _evaluate_at(scene, shaking, segment, begin, _rate(scene, 0), t)
            show(scene, _phase(begin, scene.n), seen(scene, 0))
            raise_peaks(scene, seen(scene, 0))
    control.reached = t
    for i in range(_PER_BODY * scene.n):
        phase[i] = begin[i]
    return code
