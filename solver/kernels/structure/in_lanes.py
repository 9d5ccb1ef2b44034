"""Runs of structures in eight lanes, each with its own parameters, motion, time and step.

All structures have the same number, order and kind of bodies, joints and ties. The equations and the step are those of
one structure (evaluate.py, attempt.py), over lanes; the queue is that of columns (batch/follow.py). A run ends at its
stop, or before if a block falls or nothing moves on a still base; on a still base a lane stops regularly to check that.
"""

import math
from typing import NamedTuple

from ..engine.control import is_too_short, shared
from ..engine.queue import control_steps, pass_queue, peak_over
from ..engine.samples import is_silent, no_samples, segment_from, unloaded
from ..layout.spaces import SLACK
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import WIDTH, any_of, bits, greater, lane, lesser, magnitude, square_root, where
from ..numba_ext.views import FieldTable, Record, Space, clear, copy, one_lane
from .attempt import attempt_5, evaluate_at, rate
from .bearing import raise_displacements
from .cracking import crack, crack_within
from .evaluate import moving, recall
from .layout import (
    BASE,
    CONTROL,
    COUNTS,
    EACH,
    MODEL,
    OF_BLOCK,
    OF_JOINT,
    PHASE,
    STAGES,
    WORK,
    Sizes,
    place_of_bonds,
    scene_over,
)
from .meeting import keep_slides
from .meeting_in_lanes import forget_gaps, limited, meet, until_closed, watch_gaps
from .stepping import (
    SHORTENINGS,
    STABLE,
    fallen,
    fraction_before_fall,
    horizontal,
    largest_motion,
    least_motion,
    moves,
    part_until_fall,
    relaxing,
)
from .watch import BETWEEN, BETWEEN_RATES, END, START, interpolate_body, row, seen

BETWEEN_LOOKS = 0.25  # s, between checks for rest on a still base
FELL, RESTS, STOPPED, STEP_TOO_SMALL = 1.0, 2.0, 3.0, -1.0  # outcomes of a run
PEAKS = FieldTable("u", "ux", "uy", "uz")  # of blocks, m; u: of the horizontal displacement in any direction
RUN = Record(
    *("start", "stop"),  # s, time interval of the run
    "first",  # index of the first sample of its record
    "count",  # number of samples
    "held",  # 1: samples are held, 0: joined by straight lines
    *("amplitude_x", "amplitude_y", "omega", "phase"),  # m/s2, rad/s, rad, of the harmonic part
)
OUTCOME = Record("ends", "time", "block", "steps", "rejected", "looks")  # time (s) and block (from 1) of a fall
LANE = Record(
    "run",  # index of the run, -1 without one
    *("t", "stop", "piece_end"),  # s; time, next stop, next sample
    "segment",  # index of the last sample, -1 before the first
    *("steps", "rejected", "looks"),
    "fresh",  # 1 while the rates at its time are missing
    "due",  # 1 if a check for rest is due at it
    "next_row",  # index of the next row of its run
)
NO_RUN = -1.0

ALL = Space(
    *Sizes._fields,
    model=MODEL,
    control=CONTROL,
    counts=COUNTS,
    peaks=(PEAKS, "n"),
    moved=(EACH, "b"),  # m, largest displacement of each bearing at the ends of steps; adjacent to the peaks
    gaps=(EACH, "pairs"),  # m, least gaps of neighbours; adjacent to these
    base=BASE,
    lane=LANE,
    work=WORK,
)

_all, _run, _outcome, _phase, _peaks = ALL.over, RUN.over, OUTCOME.over, PHASE.over, PEAKS.over
_RUN, _OUTCOME, _PEAK = RUN.beside, OUTCOME.beside, PEAKS.per_n
_OF_BLOCK, _OF_JOINT, _TX = len(OF_BLOCK), len(OF_JOINT), OF_JOINT.index("Tx")


class SpatialQueue(NamedTuple):
    """The queue: rows of `size` runs and of their outcomes, and the samples of all their records.

    Once the number at `flag` is not zero, no more runs are started and those under way are abandoned.
    """

    size: int
    models: object  # MODEL of each, without modes
    states: object  # initial states, replaced by the final ones
    runs: object  # records RUN
    outcomes: object  # records OUTCOME
    peaks: object  # tables PEAKS, each followed by displacements of bearings and least gaps
    times: object  # s
    ax: object  # m/s2
    ay: object
    az: object
    row_times: object  # s after the start of a run, at which displacements are stored
    rows: int  # number of them
    places: object  # m, horizontal displacement of each block, `rows` times for each run
    flag: object


class SpatialBatch(NamedTuple):
    """Eight structures over lanes, or the structure of one lane."""

    scene: object
    lane: object
    gaps: object
    row: object  # layout ALL
    sizes: Sizes
    queue: object


@leaf
def batch_over(sizes, buffer, queue):
    """Return the batch over a row of lanes, or over the row of one lane."""
    # rows of peaks and bonds
    seen = _all(buffer, sizes)
    peaks = seen.peaks.buffer[: _PEAK * sizes.n + sizes.b + sizes.pairs]
    bonded = seen.work.states[place_of_bonds(sizes) : sizes.stride]  # those of row START
    # of the base each lane has the line of its segment; no loads act
    of_base = seen.base, peaks, no_samples(queue.times)
    scene = scene_over(sizes, seen.model, seen.control, seen.counts, peaks, bonded, *of_base, seen.work)
    return SpatialBatch(scene, seen.lane, seen.gaps, buffer, sizes, queue)


@leaf
def single(batch, k):
    """Return the batch of lane k alone."""
    return batch_over(batch.sizes, one_lane(batch.row, k), batch.queue)


@leaf
def _run_of(batch, number):
    return _run(batch.queue.runs[_RUN * number :], 0)


@leaf
def _outcome_of(batch, number):
    return _outcome(batch.queue.outcomes[_OUTCOME * number :], 0)


# --- a run begins and ends


@leaf
def _silence(one):
    """Set the base motion of a lane to zero, without a next sample."""
    base = one.scene.base
    base.ax, base.ay, base.az, base.jx, base.jy, base.jz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    base.amplitude_x, base.amplitude_y = 0.0, 0.0
    one.lane.piece_end = math.inf


@leaf
def _record_of(queue, run):
    """Return the record of a run."""
    first = int(run.first)
    rows = queue.ax[first:], queue.ay[first:], queue.az[first:]
    return unloaded(queue.times[first:], int(run.count), *rows, 1.0, int(run.held))


@kernel
def follow_record(batch, one):
    """Set the base motion of a lane to that of its run on the current segment of the record."""
    base, own = one.scene.base, one.lane
    run = _run_of(batch, int(own.run))
    record = _record_of(batch.queue, run)
    k = int(own.segment)
    # the acceleration jumps at this sample: evaluate the rates again
    own.fresh = 1.0 if k <= 0 or run.held != 0.0 or is_silent(record, k) else own.fresh
    # before or after the record: regular stops after it, to check for rest
    if is_silent(record, k):
        _silence(one)
        if k < 0:
            own.piece_end = record.times[0]
        else:
            own.stop = min(run.stop, own.t + BETWEEN_LOOKS)
        return
    # a held sample or a straight line, and the harmonic
    begin, end = record.times[k], record.times[k + 1]
    per = 0.0 if run.held != 0.0 else 1.0 / (end - begin)
    base.t0, own.piece_end = begin, end
    base.ax, base.jx = record.ax[k], per * (record.ax[k + 1] - record.ax[k])
    base.ay, base.jy = record.ay[k], per * (record.ay[k + 1] - record.ay[k])
    base.az, base.jz = record.az[k], per * (record.az[k + 1] - record.az[k])
    base.amplitude_x, base.amplitude_y = run.amplitude_x, run.amplitude_y


@kernel
def load(batch, k, number):
    """Load run `number` into lane k; the rates at its start are still to be evaluated."""
    one, queue = single(batch, k), batch.queue
    seen, count = _all(one.row, batch.sizes), batch.sizes.state
    size = seen.model.total
    # model and state
    clear(one.row, seen.total)
    copy(one.row, queue.models[size * number :], size)
    copy(row(one.scene, START), queue.states[count * number :], count)
    copy(row(one.scene, END), row(one.scene, START), count)
    recall(one.scene, row(one.scene, START))
    forget_gaps(one.scene, one.gaps)
    # step control
    run, control, settings, own = _run_of(batch, number), one.scene.control, one.scene.settings, one.lane
    control.next_step, control.previous_error = settings.first_step, 1.0
    control.largest, control.largest_rate = least_motion(settings)
    own.run, own.t, own.stop = number, run.start, run.stop
    own.fresh, own.due = 1.0, 0.0
    # base motion
    one.scene.base.omega, one.scene.base.phase = run.omega, run.phase
    own.segment = segment_from(_record_of(batch.queue, run), run.start)
    follow_record(batch, one)
    own.fresh = 1.0


@kernel
def keep_places(one, end, step):
    """Store the displacements at the row times up to `end` (s), within a step of a lane; step 0: those of its start."""
    queue, own, n = one.queue, one.lane, one.sizes.n
    number = int(own.run)
    begin = _run_of(one, number).start
    while own.next_row < queue.rows and begin + queue.row_times[int(own.next_row)] <= end:
        # fraction of the step
        part = 0.0
        if step > 0.0:
            part = min(1.0, max(0.0, (begin + queue.row_times[int(own.next_row)] - own.t) / step))
        into = queue.places[(queue.rows * number + int(own.next_row)) * n :]
        for i in range(n):
            interpolate_body(one.scene, step, part, i)
            between = _phase(row(one.scene, BETWEEN), n)
            into[i] = math.hypot(between.ux[i], between.uy[i])
        own.next_row += 1.0


@kernel
def finish(batch, k, ends, time, block):
    """Store the outcome, the peaks and the state of the run in lane k, and free the lane.

    ends: how it ends; time, block: of a fall, s and number from 1.
    """
    one, queue, n = single(batch, k), batch.queue, batch.sizes.n
    # outcome
    number, count = int(one.lane.run), batch.sizes.state
    outcome = _outcome_of(batch, number)
    outcome.ends, outcome.time, outcome.block = ends, time, block
    outcome.steps, outcome.rejected, outcome.looks = one.lane.steps, one.lane.rejected, one.lane.looks
    # peaks and state
    found = _PEAK * n + batch.sizes.b + batch.sizes.pairs
    copy(queue.peaks[found * number :], one.scene.peaks, found)
    copy(queue.states[count * number :], row(one.scene, START), count)
    # what is left of the rows: nothing moves any more
    keep_places(one, math.inf, 0.0)
    one.lane.run, one.lane.piece_end = NO_RUN, math.inf


@kernel
def start(batch, fresh):
    """Evaluate the rates at the start of the lanes in the mask `fresh`, and check runs that are due for rest.

    Return the bits of the lanes whose run ends.
    """
    scene, lanes = batch.scene, batch.lane
    # rates, after bonds and pairs have changed
    begin, found = row(scene, START), row(scene, BETWEEN_RATES)
    crack(scene, begin, fresh)
    meet(scene, batch.gaps, fresh)
    evaluate_at(scene, 0, begin, found, lanes.t)
    _store_rates(batch, found, fresh)
    # peaks at this instant
    lanes.looks += where(fresh, 1.0, 0.0)
    _take_stock(batch, begin, fresh)
    phase = _phase(begin, scene.n)
    for i in range(scene.n):
        _raise_block_peaks(scene, phase, i, fresh)
    raise_displacements(scene, scene.peaks[_PEAK * scene.n :], fresh)
    # runs at a stop
    due = bits(fresh & (lanes.due > 0.0))
    ended = 0
    if due != 0:
        rests = bits(moves(scene, phase, _phase(found, scene.n))) ^ ((1 << WIDTH) - 1)
        for k in range(WIDTH):
            if (due >> k) & 1:
                ended |= _stop_or_go_on(batch, k, (rests >> k) & 1) << k
    return ended


@kernel
def _stop_or_go_on(batch, k, rests):
    """Decide at a stop whether the run in lane k ends: return 1 if it does, else 0 and set the next stop."""
    # at rest, or at the end of the run
    own, stop = single(batch, k).lane, _run_of(batch, int(single(batch, k).lane.run)).stop
    own.due = 0.0
    if rests or own.t >= stop:
        finish(batch, k, RESTS if rests else STOPPED, own.t, 0.0)
        return 1
    own.stop = min(stop, own.t + BETWEEN_LOOKS)
    return 0


# --- a step


@leaf
def _store_rates(batch, found, lanes):
    """Store rates, shear and tie forces of the last evaluation in the lanes of a mask: forces may have a kink next."""
    scene = batch.scene
    n, m = scene.n, scene.m
    kept, forces = rate(scene, 0), seen(scene, 0)
    # rates
    for i in range(moving(scene)):
        kept[i] = where(lanes, found[i], kept[i])
    # shear forces of joints and forces of ties
    along, ties = forces[_OF_BLOCK * n + _TX * m :], forces[_OF_BLOCK * n + _OF_JOINT * m :]
    for j in range(m):
        along[j] = where(lanes, -scene.resultants.t1[j], along[j])
        along[m + j] = where(lanes, -scene.resultants.t2[j], along[m + j])
    for e in range(scene.k):
        ties[e] = where(lanes, scene.pulls.force[e], ties[e])
    keep_slides(scene, lanes)


@leaf
def _take_stock(batch, state, lanes):
    control = batch.scene.control
    place, speed = largest_motion(batch.scene, _phase(state, batch.scene.n))
    control.largest = where(lanes, place, control.largest)
    control.largest_rate = where(lanes, speed, control.largest_rate)


@leaf
def _raise_block_peaks(scene, phase, i, lanes):
    """Raise the peaks of block i in the lanes of a mask by its present displacement."""
    peaks = _peaks(scene.peaks, scene.n)
    x, y, z = phase.ux[i], phase.uy[i], phase.uz[i]
    # horizontal displacement and its components, m
    peaks.u[i] = where(lanes, greater(peaks.u[i], square_root(x * x + y * y)), peaks.u[i])
    peaks.ux[i] = where(lanes, greater(peaks.ux[i], magnitude(x)), peaks.ux[i])
    peaks.uy[i] = where(lanes, greater(peaks.uy[i], magnitude(y)), peaks.uy[i])
    peaks.uz[i] = where(lanes, greater(peaks.uz[i], magnitude(z)), peaks.uz[i])


@kernel
def track_peaks(batch, step, good):
    """Raise the peaks of the lanes in the mask `good` by their step, turning points within it included."""
    scene = batch.scene
    n, peaks = scene.n, _peaks(scene.peaks, scene.n)
    begin, end = _phase(row(scene, START), n), _phase(row(scene, END), n)
    for i in range(n):
        # horizontal distance, m, and its rate, m/s
        (d0, v0), (d1, v1) = horizontal(begin, i), horizontal(end, i)
        peaks.u[i] = peak_over(peaks.u[i], d0, v0, d1, v1, step, good)
        # displacement along each axis
        peaks.ux[i] = peak_over(peaks.ux[i], begin.ux[i], begin.vx[i], end.ux[i], end.vx[i], step, good)
        peaks.uy[i] = peak_over(peaks.uy[i], begin.uy[i], begin.vy[i], end.uy[i], end.vy[i], step, good)
        peaks.uz[i] = peak_over(peaks.uz[i], begin.uz[i], begin.vz[i], end.uz[i], end.vz[i], step, good)


@leaf
def step_lengths(batch):
    """Return the next step of each lane, s, and the time to its next stop or sample; the step is 0 without a run."""
    scene, lanes, base = batch.scene, batch.lane, batch.scene.base
    # time to the next stop or sample, s
    left = lesser(lanes.stop, lanes.piece_end) - lanes.t
    step = scene.control.next_step
    # limits: the harmonic, sliding and yielding, contact
    shakes = (base.amplitude_x != 0.0) | (base.amplitude_y != 0.0)
    step = where(shakes, lesser(step, 1.0 / base.omega), step)
    if any_of(scene.settings.gives_way != 0.0):
        step = lesser(step, STABLE * relaxing(scene))
    step = limited(scene, step, STABLE)
    return where(lanes.run >= 0.0, shared(step, left), 0.0), left


@kernel
def step_on(batch):
    """Make one step of every lane that has a run; return the bits of the lanes whose run has ended, and one more bit.

    That bit, WIDTH, is set if rates or a check for rest are due.
    """
    scene, lanes = batch.scene, batch.lane
    # a step, accepted or rejected in each lane
    step, left = step_lengths(batch)
    busy = step > 0.0
    error = attempt_5(scene, 0, lanes.t, step)
    good = busy & control_steps(scene.control, step, error)
    lanes.steps += where(good, 1.0, 0.0)
    lanes.rejected += where(busy & (error > 1.0), 1.0, 0.0)
    # shorten it where a gap closes, a bond breaks or a block falls
    falling = good
    for _ in range(SHORTENINGS):
        block = where(falling, fallen(scene, _phase(row(scene, END), scene.n)), 0.0)
        step = until_closed(scene, lanes.t, step, falling, part_until_fall(scene, block))
        # only where a block falls again, so that no run depends on the others
        falling = block > 0.0
        if not any_of(falling):
            break
    # peaks, gaps, falls, cracks
    phase = _phase(row(scene, END), scene.n)
    track_peaks(batch, step, good)
    changed = watch_gaps(scene, batch.gaps, step, good)
    raise_displacements(scene, scene.peaks[_PEAK * scene.n :], good)
    _take_stock(batch, row(scene, END), good)
    block = where(good, fallen(scene, phase), 0.0)
    fell_at = lanes.t + step
    if any_of(block > 0.0):
        fell_at = lanes.t + fraction_before_fall(scene, _phase(row(scene, START), scene.n), phase) * step
    if batch.queue.rows > 0:
        taken = bits(good)
        for k in range(WIDTH):
            if (taken >> k) & 1:
                own = single(batch, k)
                keep_places(own, own.lane.t + lane(step, k) * (1.0 + SLACK), lane(step, k))
    passed = crack_within(scene, step, good)
    # the end of the step becomes the start of the next
    begin, end = row(scene, START), row(scene, END)
    for i in range(moving(scene)):
        begin[i] = where(good, end[i], begin[i])
    _store_rates(batch, rate(scene, STAGES - 1), good)
    changed |= bits(passed | crack(scene, begin, good))
    # time
    reached = good & (step == left)
    there = lesser(lanes.stop, lanes.piece_end)
    lanes.t = where(reached, there, where(good, lanes.t + step, lanes.t))
    stuck = busy & is_too_short(scene.control.next_step, scene.settings.first_step, lanes.t)
    over = block > 0.0
    if changed == 0 and not any_of(reached | over | stuck):
        return 0
    # lanes to be evaluated again
    ended = 0
    for k in range(WIDTH):
        if (changed >> k) & 1:
            single(batch, k).lane.fresh = 1.0
            ended |= 1 << WIDTH
    for k in range(WIDTH):
        # lanes that end, stop or reach a sample
        one = single(batch, k)
        if lane(block, k) > 0.0:
            finish(batch, k, FELL, lane(fell_at, k), lane(block, k))
            ended |= 1 << k
        elif (bits(stuck) >> k) & 1:
            finish(batch, k, STEP_TOO_SMALL, one.lane.t, 0.0)
            ended |= 1 << k
        elif (bits(reached) >> k) & 1:
            if one.lane.t >= one.lane.stop:
                one.lane.fresh, one.lane.due = 1.0, 1.0
                if one.lane.t >= _run_of(batch, int(one.lane.run)).stop:
                    _silence(one)
            else:
                one.lane.segment += 1.0
                follow_record(batch, one)
            if one.lane.fresh > 0.0:
                ended |= 1 << WIDTH
    return ended


@kernel
def follow_queue(batch):
    """Run all runs of the queue in the eight lanes."""
    pass_queue(batch, load, start, step_on)
