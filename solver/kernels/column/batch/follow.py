"""Runs in eight lanes, each with its own column, motion, time and step; a lane whose run ends takes the next one.

Steps are those of integrators/dormand_prince.py, with a separate error control for every lane. Changes of regime are
not located: the error of a step across one exceeds its estimate, and the tolerance of a batch allows for that
(solver/models/column/lanes.py). The result of a lane does not depend on the others.
"""

import math

from ...engine.control import (
    is_too_short,
    most_work,
    shared,
)
from ...engine.queue import NO_RUN, control_steps, pass_queue, peak_over
from ...engine.samples import is_silent
from ...layout.spaces import (
    HAS_OVERTURNED,
    MODEL,
    OK,
    PHASE_FIELDS,
    RIGID_FIELDS,
    SLACK,
    STEP_TOO_SMALL,
)
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.lanes import (
    WIDTH,
    any_of,
    bits,
    greater,
    lane,
    lesser,
    magnitude,
    where,
    with_lane,
)
from ...numba_ext.views import clear, copy, lanes_of
from ..formulations.base_motion import ends_soon, enter, smooth_reach
from ..formulations.exact import exact_top_motion
from ..formulations.slips import begin_slips, phase_size, take_directions
from ..integrators import dormand_prince
from ..integrators.interpolation import interpolate_one, slips_of
from ..joint.sliding import can_slide
from ..stepping.advance import KINKS
from ..stepping.condition import FLIGHT_PART, fallen_joint, moment_of_overturning
from .evaluate import Batch, anchor_waves, evaluate_lanes, single
from .runs import (
    SLIP_FIELDS,
    SPACE,
    outcome_of,
    run_of,
    samples_of,
    slips_at,
    snapshot_of,
    start_at,
)
from .sliding import decide_slips, end_at_changes, slid_off, steps_to_stops

_PER_N, _BESIDE = SPACE.per_n, SPACE.beside
_MODEL_PER_N, _MODEL_BESIDE = MODEL.per_n, MODEL.beside


@leaf
def batch_over(space, buffer, queue):
    """Return the batch of columns that `space` describes, over a buffer of lanes (runs.py)."""
    return Batch(space.model, space.state, space.base, space.work, space.lane, lanes_of(buffer), queue)


# --- a run begins and ends


@kernel
def load(batch, k, number):
    """Load run number `number` into lane k; the accelerations at its start are computed by `start`."""
    # model of the column
    queue = batch.queue
    one = single(batch, k)
    n = one.n
    clear(one.row, _PER_N * n + _BESIDE)
    size = _MODEL_PER_N * n + _MODEL_BESIDE
    for i in range(size):
        one.model.row[i] = queue.models[size * number + i]
    # phase that the run starts from
    begins = start_at(queue, number, n)
    copy(one.work.start.row, begins, 4 * n)
    if can_slide(batch.model):
        begin_slips(one.model, one.work)
        slips = slips_at(queue, number, n)
        copy(one.work.start.slips, slips, SLIP_FIELDS * n)
        take_directions(one.work, one.work.start)
    # times and record
    run = run_of(queue, number)
    one.lane.run = number
    one.lane.t = run.start
    one.lane.stop = run.stop
    one.lane.first = run.first
    one.lane.count = run.count
    one.lane.scale = run.scale
    one.lane.next_row = run.row
    one.lane.fresh = 1.0
    # motion of the base
    one.base.piece_end = math.inf
    one.base.wave_amplitude = run.wave_amplitude
    one.base.wave_omega = run.wave_omega
    one.base.wave_phase = run.wave_phase
    follow_record(batch, one, run.start)
    # step control
    control, settings = one.state.control, one.model.settings
    control.next_step = settings.first_step
    control.previous_error = 1.0
    control.rotation_scale = max(settings.rotation_floor, run.rotation_scale)
    control.rate_scale = max(settings.rate_floor, run.rate_scale)
    # counts and peaks so far
    so_far = outcome_of(queue, number, n)
    one.lane.steps = so_far.record.steps
    one.lane.rejected = so_far.record.rejected
    one.lane.most_tried = so_far.record.steps + so_far.record.rejected + most_work(settings, run.stop - run.start)
    copy(one.state.peaks, so_far.peaks, n)


@leaf
def follow_record(batch, one, t):
    """Set the base of a lane to the segment of its record at time t (s); outside it the harmonic part is zero."""
    samples = samples_of(batch.queue, one.lane)
    if samples.size > 0:
        # motion of the base on the segment that contains t
        enter(one.base, samples, t)
        # outside the record: free motion, with accelerations to be evaluated again
        if is_silent(samples, int(one.base.segment)):
            one.base.wave_amplitude = 0.0
            one.lane.fresh = 1.0


@kernel
def start(batch, fresh):
    """Compute accelerations and scales at the start of the lanes in the mask `fresh`. Returns 0: no run ends."""
    work, n = batch.work, batch.model.n
    between, begin = work.between, work.start
    # accelerations
    copy(between.row, begin.row, 4 * n)
    anchor_waves(batch.base, batch.lane.t)
    evaluate_lanes(batch, between, batch.lane.t)
    for i in range(2 * n):
        begin.accelerations[i] = where(fresh, between.accelerations[i], begin.accelerations[i])
    # sticking or sliding, and scales of errors
    decide_slips(batch, fresh)
    take_stock(batch, begin, fresh)
    # displacements and velocities of the tops, and their peaks
    tops = work.tops
    exact_top_motion(batch.model, begin, tops.between_ux, tops.between_rate)
    for i in range(n):
        tops.start_ux[i] = where(fresh, tops.between_ux[i], tops.start_ux[i])
        tops.start_rate[i] = where(fresh, tops.between_rate[i], tops.start_rate[i])
        batch.state.peaks[i] = greater(batch.state.peaks[i], magnitude(tops.start_ux[i]))
    return 0


@kernel
def finish(batch, k, code):
    """Store the outcome of the run in lane k and free the lane."""
    one = single(batch, k)
    n = one.n
    outcome = outcome_of(batch.queue, int(one.lane.run), n)
    # code, overturning and counts
    outcome.record.code = code
    outcome.record.time = one.state.control.overturn_time
    outcome.record.overturned = fallen_joint(one.model, one.work.start) if code == HAS_OVERTURNED else 0
    outcome.record.steps = one.lane.steps
    outcome.record.rejected = one.lane.rejected
    # peaks and phase
    copy(outcome.peaks, one.state.peaks, n)
    copy(outcome.phase, one.work.start.row, 4 * n)
    if can_slide(batch.model):
        slips = slips_at(batch.queue, int(one.lane.run), n)
        copy(slips, one.work.start.slips, SLIP_FIELDS * n)
    # the lane without a run
    one.lane.run = NO_RUN
    one.lane.count = 0.0
    one.base.piece_end = math.inf
    one.base.wave_amplitude = 0.0


# --- a step


@kernel
def take_stock(batch, phase, lanes):
    """Raise the scales of errors (rad, rad/s) of the lanes in the mask `lanes` by `phase`."""
    blocks, control = batch.model.blocks, batch.state.control
    turned, spun = control.rotation_scale, control.rate_scale
    for i in range(batch.model.n):
        # rotations, openings and slips as equivalent rotations
        turned = greater(turned, magnitude(phase.theta[i]))
        spun = greater(spun, magnitude(phase.theta_rate[i]))
        # openings as rotations of the block about its edge
        opening = phase.opening[i]
        parted = opening > 0.0
        if any_of(parted):
            per_half = 2.0 / blocks.width[i]
            turned = where(parted, greater(turned, FLIGHT_PART * opening * per_half), turned)
            spun = where(parted, greater(spun, magnitude(phase.opening_rate[i]) * per_half), spun)
        # slips as rotations of the whole column
        if can_slide(batch.model):
            per_slip = batch.model.settings.per_slip
            turned = greater(turned, magnitude(phase.slip[i] - blocks.offset[i]) * per_slip)
            spun = greater(spun, magnitude(phase.slip_rate[i]) * per_slip)
    # raise the scales in the selected lanes
    control.rotation_scale = where(lanes, turned, control.rotation_scale)
    control.rate_scale = where(lanes, spun, control.rate_scale)


@kernel
def fallen(model, phase):
    """Return the mask of the lanes in which a block or its joint has turned too far to come back, or slid off."""
    n = model.n
    beyond = phase.theta[n - 1] != phase.theta[n - 1]  # true only for values that are not numbers
    for i in range(n):
        # rotation of the block, and of the joint under it
        turn = phase.theta[i]
        joint = turn
        if i + 1 < n:
            joint = turn - phase.theta[i + 1]
        # beyond the angle of no return, or slid off
        limit = model.blocks.fall_angle[i]
        beyond = beyond | (magnitude(turn) > limit) | (magnitude(joint) > limit) | slid_off(model, phase, i)
    return beyond


@kernel
def end_at_falls(batch, fell, step):
    """Shorten the steps of the lanes in the bit mask `fell` to the instant of overturning. Returns the steps (s)."""
    # each lane that overturns, alone
    if fell != 0:
        for k in range(WIDTH):
            if (fell >> k) & 1:
                one = single(batch, k)
                # the lane alone, by bisection
                made = lane(step, k) * moment_of_overturning(one, lane(step, k))
                one.state.control.overturn_time = one.lane.t + made
                step = with_lane(step, k, made)
                copy(one.work.end.row, one.work.between.row, phase_size(one.work))
    return step


@kernel
def step_lengths(batch):
    """Return the next step of each lane (s); 0 for a lane without a run."""
    base, lanes, control = batch.base, batch.lane, batch.state.control
    left = lanes.stop - lanes.t
    step = control.next_step
    # at most one radian of the harmonic motion
    step = where(base.wave_amplitude != 0.0, lesser(step, 1.0 / base.wave_omega), step)
    # lanes near the end of their segment: how far the record is smooth
    near = bits((lanes.count > 0.0) & (base.piece_end - lanes.t < lesser(2.0 * step, left)))
    if near != 0:
        for k in range(WIDTH):
            if (near >> k) & 1:
                one = single(batch, k)
                samples, settings = samples_of(batch.queue, one.lane), one.model.settings
                # error of a velocity by a kink of the record, m/s, and the time up to a kink that exceeds it
                roughest = KINKS * settings.tolerance * one.state.control.rate_scale
                roughest *= one.model.blocks.centroid[one.n - 1]
                reach = smooth_reach(one.base, samples, one.lane.t, lane(step, k), lane(left, k), roughest)
                left = with_lane(left, k, reach)
    return where(lanes.run >= 0.0, shared(step, left), 0.0)


@kernel
def track_peaks(batch, step, good):
    """Raise the peaks of |u_x| (m) of the good lanes by their steps (s)."""
    tops, peaks = batch.work.tops, batch.state.peaks
    exact_top_motion(batch.model, batch.work.end, tops.end_ux, tops.end_rate)
    for i in range(batch.model.n):
        # peak of the top of block i; the end becomes the start of the next step
        d0, d1, v0, v1 = tops.start_ux[i], tops.end_ux[i], tops.start_rate[i], tops.end_rate[i]
        peaks[i] = peak_over(peaks[i], d0, v0, d1, v1, step, good)
        tops.start_ux[i] = where(good, d1, d0)
        tops.start_rate[i] = where(good, v1, v0)


@kernel
def take_snapshots(batch, k, step):
    """Store the column in lane k at the requested times within its step (s)."""
    queue = batch.queue
    one = single(batch, k)
    n, number = one.n, int(one.lane.run)
    # rows that lie in the step
    origin = run_of(queue, number).origin
    row = int(one.lane.next_row)
    while row < queue.rows and origin + queue.row_times[row] <= one.lane.t + step * (1.0 + SLACK):
        # interpolate coordinates and rates, then slips
        snapshot = snapshot_of(queue, number, row, n)
        fraction = min(1.0, max(0.0, (origin + queue.row_times[row] - one.lane.t) / step))
        for i in range(2 * n):
            snapshot.coordinates[i], snapshot.rates[i] = interpolate_one(one.work, i, step, fraction)
        first, behind = slips_of(one.work)
        for i in range(first, behind):
            snapshot.coordinates[i], snapshot.rates[i] = interpolate_one(one.work, i, step, fraction)
        row += 1
    one.lane.next_row = row


@kernel
def step_on(batch):
    """Make one step of every lane that has a run. Returns the bit mask of the lanes whose run has ended.

    Its bit number WIDTH is set if the motion of some base has ended: its accelerations jump.
    """
    work, lanes, control = batch.work, batch.lane, batch.state.control
    n = batch.model.n
    # attempt a step in every lane
    step = steps_to_stops(batch, step_lengths(batch))
    busy = step > 0.0
    anchor_waves(batch.base, lanes.t)
    error = dormand_prince.attempt(batch, lanes.t, step)
    # accept or reject, and end steps at changes of sliding
    good = busy & control_steps(control, step, error)
    lanes.steps += where(good, 1.0, 0.0)
    lanes.rejected += where(busy & (error > 1.0), 1.0, 0.0)
    step, changed = end_at_changes(batch, step, good)
    take_stock(batch, work.end, good)
    # lanes that overturn
    over = good & fallen(batch.model, work.end)
    fell, ended = bits(over), bits(over)
    step = end_at_falls(batch, fell, step)
    # snapshots and peaks
    if batch.queue.rows > 0:
        moved = bits(good)
        for k in range(WIDTH):
            if (moved >> k) & 1:
                take_snapshots(batch, k, lane(step, k))
    track_peaks(batch, step, good)
    # the ends become the starts of the next steps
    for i in range((PHASE_FIELDS if can_slide(batch.model) else RIGID_FIELDS) * n):
        work.start.row[i] = where(good, work.end.row[i], work.start.row[i])
    at_stop = good & (step == lanes.stop - lanes.t)
    lanes.t = where(at_stop, lanes.stop, where(good, lanes.t + step, lanes.t))
    # lanes that enter the next segment of their record
    passed = bits((lanes.count > 0.0) & ends_soon(batch.base, lanes.t))
    if passed != 0:
        for k in range(WIDTH):
            if (passed >> k) & 1:
                one = single(batch, k)
                follow_record(batch, one, one.lane.t)
                if one.lane.fresh > 0.0:
                    ended |= 1 << WIDTH
    decide_slips(batch, changed)
    # finish runs that overturn, end or fail
    stuck = busy & is_too_short(control.next_step, batch.model.settings.first_step, lanes.t)
    stuck = stuck | (busy & (lanes.steps + lanes.rejected > lanes.most_tried))  # made alone, the run reports the reason
    if fell != 0:
        for k in range(WIDTH):
            if (fell >> k) & 1:
                finish(batch, k, HAS_OVERTURNED)
    if any_of(at_stop | stuck):
        ended |= bits(at_stop | stuck)
        done, failed = bits(at_stop), bits(stuck)
        for k in range(WIDTH):
            if single(batch, k).lane.run < 0.0:
                continue
            if (done >> k) & 1:
                finish(batch, k, OK)
            elif (failed >> k) & 1:
                finish(batch, k, STEP_TOO_SMALL)
    return ended


@kernel
def follow_queue(batch):
    """Follow all runs of the queue of a batch in its eight lanes."""
    pass_queue(batch, load, start, step_on)
