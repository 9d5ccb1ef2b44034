"""Adaptive steps for one structure in space, with peaks and output rows.

A step ends at each sample of the record.
"""

import math

from ..engine.control import (
    INSTANT,
    LEAST_ERROR,
    SAFETY,
    SHRINK,
    STEPS_PER_PROBE,
    WAIT_OPEN,
    WAIT_SHORT,
    accepts_elastic,
    go_on,
    growth,
    is_too_short,
    may_be_elastic,
    shared,
    shorten,
)
from ..engine.queue import peak_over
from ..engine.samples import next_sample, segment_from
from ..layout.spaces import SLACK
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, greater, index_of, lesser, square_root, where, zero_like
from ..numba_ext.views import copy
from . import modal, stabilized
from .attempt import attempt, evaluate_at, rate, size_of, square_of
from .base import is_quiet
from .bearing import come_off, left_bearing, travel_left
from .bond import copy_bonds
from .contact import forget_directions, forget_known_gaps
from .cracking import crack_within
from .evaluate import energy, evaluate_state, moving, recall, show
from .extras import is_loaded, let_go
from .kinematics import tilt_left
from .layout import MEMORY, OK, PAUSED, PHASE, STAGES, STEP_TOO_SMALL
from .meeting import (
    keep_slides,
    longest_touching,
    meet,
    note_first,
    part_until_met,
    release_flying,
    release_pairs,
    toppled,
)
from .modal_layout import data_of
from .watch import BETWEEN, END, STAGE, START, clear_peaks, look, raise_peaks, row, seen, track_peaks, travel

_phase, _memory = PHASE.over, MEMORY.over
_PER_BODY, _PER_JOINT, _RATES = PHASE.per_n, MEMORY.per_n, PHASE.fields.index("vx")
STABLE = 2.5  # longest step over the time constant of sliding or yielding; beyond 3.3 only error control bounds it
# longest step times the fastest decay rate. At 7 the embedded error of order 5 does not see an unstable motion that
# grows twelvefold; steps beyond 5.6 are unstable, and their error is seen
SEEN = 6.0
POWERS, LEAST_DECAY = 12, 1e-9  # iterations; 1/s
PROBES = 8  # explicit steps after STEPS_PER_PROBE by modes
REACH = 33.0  # longest stable explicit step over the first step
EXPLICIT, BY_MODES, STABILIZED = 0, 1, 2  # methods of a step
STIFF = 2.5  # step of order 5 times the fastest rate from which stability bounds it
LEAST_REACH = 14.0  # least stabilized step times the fastest rate: shorter ones are no faster than order 5
FIRST_REACH = 28.0  # the same of the first stabilized step
SMALL = 0.01  # of the largest rate so far: below it the motion decays, and order 5 is used
LENGTHEN = 1.2  # largest growth of stabilized steps: at the stability limit errors rise at once
# steps of order 5 in a row, bounded by stability, before stabilized ones are tried; twice as many after a failed trial
WAIT_STABILIZED, MOST_PAUSE = 8, 64
BEYOND_FALL = 1e-4  # of a step: how much later than a fall is foreseen it ends
SHORTENINGS = 3  # of a step in which a block falls
STILL = 1e-8  # of gravity, and of the rate floor: smaller values are rest
ROUNDING = 5e-17  # rad, rad/s: no smaller error of a step is asked for; rounding makes some 1e-17


@kernel
def largest_motion(scene, phase):
    """Return the largest motion so far, rad and rad/s; displacements are divided by the extent of the structure."""
    control, per = scene.control, 1.0 / (scene.settings.extent * scene.settings.extent)
    place, rate = zero_like(per), zero_like(per)  # squares
    for i in range(scene.n):
        place = greater(place, per * square_of(phase.ux[i], phase.uy[i], phase.uz[i]))
        place = greater(place, 4.0 * square_of(phase.q1[i], phase.q2[i], phase.q3[i]))
        rate = greater(rate, per * square_of(phase.vx[i], phase.vy[i], phase.vz[i]))
        rate = greater(rate, square_of(phase.wx[i], phase.wy[i], phase.wz[i]))
    return greater(control.largest, square_root(place)), greater(control.largest_rate, square_root(rate))


@leaf
def horizontal(phase, i):
    """Return the size of the horizontal displacement of block i, m, and its rate, m/s."""
    x, y = phase.ux[i], phase.uy[i]
    # radial velocity, and no division by zero
    size = square_root(x * x + y * y)
    return size, (x * phase.vx[i] + y * phase.vy[i]) / greater(size, 1e-300)


@kernel
def _take_stock(scene, phase):
    """Update the largest motion and forces so far by a phase that has just been evaluated."""
    control, found = scene.control, scene.resultants
    control.largest, control.largest_rate = largest_motion(scene, phase)
    for j in range(scene.m):
        control.largest_normal = max(control.largest_normal, found.normal[j])
        control.largest_shear = max(control.largest_shear, size_of(found.t1[j], found.t2[j], 0.0))


@leaf
def least_motion(settings):
    """Return the least motion (rad) and rate (rad/s) against which errors are measured: above what rounding makes."""
    least = ROUNDING / settings.step_tolerance
    return greater(settings.motion_floor, least), greater(settings.rate_floor, least)


@leaf
def _height_left(scene, phase, i):
    """Return how much further block i may sink, m, until it counts as fallen."""
    return phase.uz[i] + scene.bodies.drop[i]


@kernel
def fallen(scene, phase):
    """Return the number, from 1, of a block that has fallen; 0 if there is none.

    It lies far below its place as built, or is tilted by more than 90 degrees over its support, beyond which a joint
    has no meaning, or it has left a bearing at the last evaluation.
    """
    found = zero_like(phase.uz[0])
    # far below its place
    for k in range(scene.n):
        i = scene.n - 1 - k
        found = where(_height_left(scene, phase, i) > 0.0, found, i + 1.0)
    # tipped over its support
    for j in range(scene.m):
        upper, lower = index_of(scene.joints.upper[j]), index_of(scene.joints.lower[j])
        found = where(tilt_left(scene, phase, j) < 0.0, (upper if upper < scene.n else lower) + 1.0, found)
    return come_off(scene, found)


@leaf
def _crossed(before, after):
    """Return the fraction of a step at which a linear margin becomes zero; 1 if it does not, or began below."""
    return where((before > 0.0) & (after <= 0.0), before / (before - after), 1.0 + zero_like(before))


@kernel
def fraction_before_fall(scene, begin, end):
    """Return the fraction of a step, between two phases, after which a block has fallen.

    The margins of `fallen` are taken as linear over the step, which errs by the square of its length.
    """
    fraction = 1.0 + zero_like(end.uz[0])
    # the first margin that becomes zero, of heights, of tilts and of bearings
    for i in range(scene.n):
        fraction = lesser(fraction, _crossed(_height_left(scene, begin, i), _height_left(scene, end, i)))
    for j in range(scene.m):
        fraction = lesser(fraction, _crossed(tilt_left(scene, begin, j), tilt_left(scene, end, j)))
    for j in range(scene.m - scene.extras.b, scene.m):
        before = travel_left(scene, begin, j)
        fraction = lesser(fraction, _crossed(before, travel_left(scene, end, j)))
    return fraction


@kernel
def part_until_fall(scene, block):
    """Return the part of the step just made after which a block has fallen; 1 where none has, whose number is 0."""
    part = 1.0 + zero_like(block)
    if any_of(block > 0.0):
        begin, end = _phase(row(scene, START), scene.n), _phase(row(scene, END), scene.n)
        part = where(block > 0.0, lesser(part, fraction_before_fall(scene, begin, end) + BEYOND_FALL), part)
    return part


@kernel
def moves(scene, phase, rates):
    """Return True if a block moves or accelerates."""
    rate, force = STILL * scene.settings.rate_floor, STILL * scene.settings.gravity
    found = rate < 0.0
    # velocities and accelerations against the rate floor and gravity
    for i in range(scene.n):
        size = scene.bodies.size[i]
        found = found | (size_of(phase.vx[i], phase.vy[i], phase.vz[i]) > rate * size)
        found = found | (size_of(phase.wx[i], phase.wy[i], phase.wz[i]) > rate)
        found = found | (size_of(rates.vx[i], rates.vy[i], rates.vz[i]) > force)
        found = found | (size_of(rates.wx[i], rates.wy[i], rates.wz[i]) * size > force)
    return found


@kernel
def relaxing(scene):
    """Return the shortest time constant, s, of a joint that slides or a tie that yields at the start of a step."""
    n, m = scene.n, scene.m
    giving, shortest = rate(scene, 0)[_PER_BODY * n :], math.inf + zero_like(scene.settings.relaxation)
    slips = _memory(giving, m)
    # joints that slide or twist
    for j in range(m):
        slides = (slips.p1[j] != 0.0) | (slips.p2[j] != 0.0) | (slips.p3[j] != 0.0)
        shortest = where(slides, lesser(shortest, scene.joints.shear_damping[j]), shortest)
    # ties that yield
    for e in range(_PER_JOINT * m, _PER_JOINT * m + scene.k):
        shortest = where(giving[e] != 0.0, lesser(shortest, scene.settings.relaxation), shortest)
    return shortest


@kernel
def _serve_rows(scene, watch, segment, t, h):
    """Fill the output rows whose time lies within the step from t to t + h."""
    counts = scene.counts
    while counts.next_row < watch.size and watch.times[counts.next_row] <= t + h * (1.0 + SLACK):
        # the row at its fraction of the step, and the state behind it
        part = 1.0 if h == 0.0 else min(1.0, max(0.0, (watch.times[counts.next_row] - t) / h))
        into = watch.rows[counts.next_row * watch.wide :]
        look(scene, segment, t, h, part, into, True)
        if watch.wide > scene.visible:
            copy(into[scene.visible :], row(scene, BETWEEN), moving(scene))
            copy_bonds(scene, into[scene.visible + _PER_BODY * scene.n + scene.remembered :])
        counts.next_row += 1


@leaf
def end_after_fall(scene):
    """Return the time, s, from which on a structure that has fallen keeps its state."""
    if scene.counts.fallen == 0:
        return math.inf
    after = scene.settings.after_fall
    return scene.control.fall_time + after if after > 0.0 else -math.inf


@kernel
def _begin(scene, segment, t, phase):
    """Evaluate the phase from which the steps start; the first call sets scales and the first step."""
    control, counts, settings = scene.control, scene.counts, scene.settings
    # a state that has fallen, or is off a bearing by its forces, begins without the joints that have come apart
    if counts.started == 0 and settings.after_fall > 0.0:
        evaluate_at(scene, segment, row(scene, START), rate(scene, 0), t)
        block = max(int(fallen(scene, phase)), toppled(scene, phase))
        if block > 0:
            counts.fallen, control.fall_time = block, t
            release_pairs(scene, True)
        else:
            release_flying(scene, phase)
    meet(scene, t)
    evaluate_at(scene, segment, row(scene, START), rate(scene, 0), t)
    keep_slides(scene, True)
    # the first call of a run
    if counts.started == 0:
        counts.started = 1
        clear_peaks(scene)  # an output row may have been asked for under other inputs
        control.next_step, control.previous_error = settings.first_step, 1.0
        control.elastic_step = 10.0 * settings.first_step
        counts.stabilized_wait, counts.stabilized_pause = WAIT_STABILIZED, WAIT_STABILIZED
        place, speed = least_motion(settings)
        control.largest, control.largest_rate = max(control.largest, place), max(control.largest_rate, speed)
        _take_stock(scene, phase)
        for i in range(scene.n):
            scene.poses.farthest[i] = horizontal(phase, i)[0]
        for p in range(scene.extras.met):
            scene.extras.hits.met[p] = 0.0
        note_first(scene, t)
    # output row and peaks at the start
    show(scene, phase, seen(scene, 0), True)
    if t < end_after_fall(scene):
        raise_peaks(scene, seen(scene, 0))


@kernel
def _finish(scene, watch, segment, t, h, by_modes):
    """Complete a step: record peaks and rows, detect falls and cracks, and move its end to the start of the next."""
    # largest motion and falls
    phase = _phase(row(scene, END), scene.n)
    scene.counts.steps += 1
    keep_slides(scene, True)
    _take_stock(scene, phase)
    block = int(fallen(scene, phase))
    if block == 0 and scene.counts.fallen == 0 and scene.settings.after_fall > 0.0:
        block = toppled(scene, phase)
    falls = block > 0 and scene.counts.fallen == 0
    if falls:
        scene.counts.left = left_bearing(scene, block)
    # peaks, output rows, cracks
    begin = _phase(row(scene, START), scene.n)
    for i in range(scene.n):
        farthest = scene.poses.farthest
        farthest[i] = peak_over(farthest[i], *horizontal(begin, i), *horizontal(phase, i), h, True)
    track_peaks(scene, segment, t, h, by_modes)
    _serve_rows(scene, watch, segment, t, h)
    if crack_within(scene, h, True):
        evaluate_at(scene, segment, row(scene, END), rate(scene, STAGES - 1), t + h)
        keep_slides(scene, True)
    if falls:
        fraction = fraction_before_fall(scene, _phase(row(scene, START), scene.n), phase)
        scene.counts.fallen, scene.control.fall_time = block, t + fraction * h
    # the end becomes the start of the next step
    copy(row(scene, START), row(scene, END), moving(scene))
    copy(rate(scene, 0), rate(scene, STAGES - 1), moving(scene))


@kernel
def fastest_decay(scene):
    """Return the decay rate, 1/s, of the most damped motion of the joints at START, by power iteration."""
    first, end = _RATES * scene.n, _PER_BODY * scene.n
    begin, way, moved = row(scene, START), row(scene, BETWEEN), row(scene, STAGE)
    still, found, little = rate(scene, 1), rate(scene, 2), modal.small_rate(scene)
    # accelerations without a perturbation
    evaluate_state(scene, begin, still, 0.0, 0.0, 0.0)
    copy(moved, begin, moving(scene))
    fastest = 0.0
    for k in range(first, end):
        way[k] = 1.0 / (1.0 + k % 7) if k % 2 == 0 else -1.0
    # power iteration: accelerations by a small change of velocities
    for _ in range(POWERS):
        for k in range(first, end):
            moved[k] = begin[k] + little * way[k]
        evaluate_state(scene, moved, found, 0.0, 0.0, 0.0)
        fastest = 0.0
        for k in range(first, end):
            way[k] = (still[k] - found[k]) / little
            fastest = max(fastest, abs(way[k]))
        for k in range(first, end):
            way[k] /= max(fastest, LEAST_DECAY)
    scene.counts.evaluations += 1 + POWERS
    return max(fastest, LEAST_DECAY)


@kernel
def _plan(scene, segment, left, quiet):
    """Return the next step, s, its method, and the fastest rate that the step has to follow, 1/s.

    left: s, time to the end of the piece; quiet: True if nothing moves the base or acts on a block.
    """
    control, counts, settings = scene.control, scene.counts, scene.settings
    most = 1.0 / scene.base.omega if scene.base.omega != 0.0 else math.inf
    if settings.has_modes != 0.0:
        # a step by modes
        longest = data_of(scene).limits.longest
        loaded = is_loaded(scene, segment)  # modal steps do not include loads
        if not loaded and may_be_elastic(counts, control, longest, left, modal.cost_of(scene)):
            if modal.suits(scene, segment):
                return shared(min(control.elastic_step, longest, most), left), BY_MODES, 0.0
            counts.elastic_wait = WAIT_OPEN
        modal.forget(scene)
    if control.decay == 0.0:
        control.decay = fastest_decay(scene)
    # the longest step of order 5, and the fastest rate that it follows
    longest = min(SEEN / control.decay, STABLE * longest_touching(scene))
    if settings.gives_way != 0.0:
        longest = min(longest, STABLE * relaxing(scene))
    fastest = SEEN / longest
    # a stabilized step, or one of the explicit method
    if _is_stiff(scene, fastest, min(most, left)) and not (quiet and _dies_out(scene)):
        step = min(_stabilized_step(scene, fastest), most, stabilized.LONGEST_REACH / fastest)
        return shared(step, left), STABILIZED, fastest
    return shared(min(control.next_step, most, longest), left), EXPLICIT, fastest


@kernel
def _dies_out(scene):
    """Return True if the rates at the start of a step are small beside the largest so far.

    Slow vibrations of little damping may grow in long stabilized steps as far as errors are allowed, and never rest.
    """
    n, phase, least = scene.n, _phase(row(scene, START), scene.n), SMALL * scene.control.largest_rate
    found = 0.0
    for i in range(n):
        size = scene.bodies.size[i]
        found = max(found, size_of(phase.vx[i], phase.vy[i], phase.vz[i]) / size)
        found = max(found, size_of(phase.wx[i], phase.wy[i], phase.wz[i]))
    return found < least


@leaf
def _is_stiff(scene, fastest, most):
    """Return True if a stabilized step is worth a trial: stability, not accuracy, bounds the steps of order 5.

    fastest: 1/s, the rate that bounds steps of order 5; most: s, of a step.
    """
    waits = scene.settings.stabilizes == 0.0 or scene.counts.stabilized_wait > 0
    return not waits and most * fastest >= LEAST_REACH


@leaf
def _stabilized_step(scene, fastest):
    """Return the proposed stabilized step, s, or that of a trial while steps of order 5 are made."""
    step = scene.control.stabilized_step
    return step if step > 0.0 else FIRST_REACH / fastest


@leaf
def _error_of(scene, segment, t, h, method, fastest):
    """Make a stabilized or an explicit step of h s from row START to row END; return its error in tolerances."""
    if method == STABILIZED:
        return stabilized.attempt_stabilized(scene, segment, t, h, stabilized.stages_of(h * fastest))
    return attempt(scene, segment, t, h)


@kernel
def _makes_stabilized(scene, segment, t, h, fastest):
    """Try a stabilized step of h s; return True if it is accurate enough. Set the length of the next one either way.

    fastest: 1/s, the rate that it has to be stable for. A trial that fails leaves the steps of order 5 as they were.
    """
    control, counts = scene.control, scene.counts
    error = stabilized.attempt_stabilized(scene, segment, t, h, stabilized.stages_of(h * fastest))
    per_order = 1.0 / (stabilized.ORDER + 1)
    if error <= 1.0:
        # accepted: the next one may be longer
        counts.stabilized_steps += 1
        counts.stabilized_pause = WAIT_STABILIZED
        _count_general_step(scene)
        error = max(error, LEAST_ERROR)
        factor = min(LENGTHEN, growth(control.previous_error, error, per_order))
        step, control.previous_error = h * factor, error
        control.stabilized_step = step if factor < 1.0 else max(step, _stabilized_step(scene, fastest))
    else:
        # rejected: a failed trial, or a shorter step
        counts.rejected += 1
        if control.stabilized_step == 0.0:
            counts.stabilized_pause = min(MOST_PAUSE, 2 * counts.stabilized_pause)
            counts.stabilized_wait = counts.stabilized_pause
            return False
        factor = max(SHRINK, SAFETY * error**-per_order) if math.isfinite(error) else SHRINK
        control.stabilized_step, control.previous_error = h * factor, 1.0
    if control.stabilized_step * fastest < LEAST_REACH:
        # the motion is no longer slow beside the joints: steps of order 5 follow it
        control.stabilized_step, control.previous_error = 0.0, 1.0
        counts.stabilized_wait = counts.stabilized_pause
        control.next_step = min(control.next_step, STIFF / fastest)
    return error <= 1.0


@kernel
def _count_modal_step(scene):
    """Count a step by modes; after many that are no longer than explicit ones may be, request a comparison."""
    control, counts = scene.control, scene.counts
    counts.in_a_row += 1
    if counts.in_a_row >= STEPS_PER_PROBE:
        counts.in_a_row = 0
        if control.elastic_step < modal.cost_of(scene) * REACH * scene.settings.first_step:
            counts.elastic_wait, counts.probing = PROBES, 1


@kernel
def _count_general_step(scene):
    """Shorten the wait for modes by one step; after a comparison, continue with explicit steps if they were longer."""
    control, counts = scene.control, scene.counts
    if counts.elastic_wait == 0:
        return
    counts.elastic_wait -= 1
    if counts.elastic_wait == 0 and counts.probing == 1:
        counts.probing = 0
        least = modal.cost_of(scene) * control.next_step
        if control.elastic_step < least:
            counts.elastic_wait, control.elastic_step = WAIT_SHORT, least


@kernel
def _makes(scene, segment, t, h, method, fastest):
    """Try a step of h s; return True if it is accurate enough. Set the length of the next one either way.

    method: EXPLICIT, BY_MODES or STABILIZED; fastest: 1/s, the rate that stabilized steps have to be stable for.
    """
    control, counts = scene.control, scene.counts
    # other methods
    if method == STABILIZED:
        return _makes_stabilized(scene, segment, t, h, fastest)
    if method == BY_MODES:
        code, error = modal.attempt(scene, segment, t, h)
        accepted = accepts_elastic(counts, control, h, code, error, modal.cost_of(scene))
        if accepted:
            _count_modal_step(scene)
        return accepted
    # an explicit step
    error, per_order = attempt(scene, segment, t, h), 1.0 / scene.settings.order
    if not error <= 1.0:
        counts.rejected += 1
        shorten(control, h, error, per_order)
        return False
    _count_general_step(scene)
    counts.stabilized_wait = max(0, counts.stabilized_wait - 1) if h * fastest >= STIFF else counts.stabilized_pause
    go_on(control, h, error, per_order)
    return True


@kernel
def _meet_anew(scene, segment, t):
    """Update contacts, bonds and, after a fall, joints at the start of a step; return True if forces have changed."""
    released = scene.counts.fallen != 0 and release_pairs(scene, False)
    if released:
        # the energy that the end of joints takes
        begin = row(scene, START)
        evaluate_at(scene, segment, begin, rate(scene, 0), t)
        scene.control.released -= energy(scene, _phase(begin, scene.n))
        # and that with which the bodies of those joints begin to press on each other
        release_pairs(scene, True)
        meet(scene, t)
        evaluate_at(scene, segment, begin, rate(scene, 0), t)
        scene.control.released += energy(scene, _phase(begin, scene.n))
        return True
    return meet(scene, t)


@kernel
def advance(scene, watch, state, t, stop, most):
    """Advance the structure from t to `stop`, s, in at most `most` steps, to `control.reached`; return a code.

    Parameters
    ----------
    scene : Scene
        The structure, under its base motion and loads.
    watch : SpatialWatch
        Output rows to fill.
    state : row
        State at t, replaced by the one reached. A structure that has fallen keeps its state.
    t, stop : float
        Time interval, s.
    most : int
        Largest number of steps.

    Returns
    -------
    int
        OK, PAUSED after `most` steps, or STEP_TOO_SMALL.
    """
    control, counts = scene.control, scene.counts
    begin = row(scene, START)
    # the state at t
    recall(scene, state)
    forget_known_gaps(scene)
    forget_directions(scene)
    modal.prepare(scene)
    modal.forget(scene)
    copy(begin, state, moving(scene))
    segment = segment_from(scene.samples, t)
    _begin(scene, segment, t, _phase(begin, scene.n))
    # nothing moves in an instant
    if stop - t <= INSTANT * scene.settings.first_step:
        t = stop
    code, made = OK, 0
    while t < stop and t < end_after_fall(scene):
        if made == most:
            code = PAUSED
            break
        made += 1
        # a structure at rest stays at rest
        quiet = is_quiet(scene, segment) and not is_loaded(scene, segment)
        if quiet and not moves(scene, _phase(begin, scene.n), _phase(rate(scene, 0), scene.n)):
            counts.resting = 1
            t = stop
            break
        # a step, at most to the next sample
        end = next_sample(scene.samples, segment, min(stop, end_after_fall(scene)))
        h, method, fastest = _plan(scene, segment, end - t, quiet)
        if not _makes(scene, segment, t, h, method, fastest):
            if is_too_short(control.next_step, scene.settings.first_step, t):
                code = STEP_TOO_SMALL
                break
            continue
        # complete the step
        travel(scene, h)
        if method != BY_MODES:  # steps by modes keep all contacts
            ends = counts.fallen == 0
            # again where a block falls, as its margin is not linear over the step
            for _ in range(SHORTENINGS):
                block = fallen(scene, _phase(row(scene, END), scene.n)) if ends else 0.0
                part = part_until_met(scene, h, part_until_fall(scene, block))
                if part < 1.0:
                    h = part * h
                    forget_known_gaps(scene)
                    _error_of(scene, segment, t, h, method, fastest)
                if block == 0.0:
                    break
        _finish(scene, watch, segment, t, h, method == BY_MODES)
        t = end if h == end - t else t + h
        # evaluate again where forces or the segment change
        begins_anew = _meet_anew(scene, segment, t)
        if t == end and end < stop:
            segment, begins_anew = segment_from(scene.samples, t), True
        if begins_anew:
            modal.forget(scene)
            evaluate_at(scene, segment, begin, rate(scene, 0), t)
            keep_slides(scene, True)
            show(scene, _phase(begin, scene.n), seen(scene, 0), True)
            raise_peaks(scene, seen(scene, 0))
    # the state reached
    let_go(scene)
    control.reached = t
    copy(state, begin, moving(scene))
    return code
