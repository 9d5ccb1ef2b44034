"""The runs of the paper's model through eight lanes.

The sweeps go on until those of every lane have settled; a lane that has keeps its accelerations. All lanes step at
once, each by its own step, which divides the interval between two samples of its record, or all of its run.
"""

import math

from ..column.batch import runs
from ..column.batch.evaluate import anchor_far_waves, motion_of_lanes, single
from ..column.batch.follow import end_at_falls, finish, follow_record, load
from ..engine.queue import pass_queue, peak_over
from ..engine.samples import SAMPLE_SLACK
from ..layout.spaces import HAS_OVERTURNED, NOT_CONVERGED, OK
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import WIDTH, bits, greater, magnitude, where
from ..numba_ext.views import Space, copy, one_lane
from .equations import MAX_SWEEPS, MODEL, bear, has_settled, is_paper, sweep_once, sweep_rows, tilt
from .stepping import correct, in_equal_steps, predict

SPACE = Space(**runs.SPACE.parts | {"model": MODEL})
_space = SPACE.over


@single.version(lambda batch, k: is_paper(batch.types[0]))
def _single(batch, k):
    return _space(one_lane(batch.row, k), batch.model.n)


@kernel
def sweep_lanes(batch, phase, t, wanted):
    """Compute accelerations of the wanted lanes at a phase and at times t; return the mask of those that settled."""
    model, work, n = batch.model, batch.work, batch.model.n
    # resultants, constant during the sweeps
    motion = motion_of_lanes(batch, t)
    lift = model.settings.gravity + motion.az
    sweeps = sweep_rows(work.room.row, n)
    bear(model, phase, work.joints, work.hold, sweeps)
    found, before = phase.accelerations, work.between.row
    settled = ~wanted
    # sweeps of all lanes; settled lanes keep their accelerations
    for _ in range(MAX_SWEEPS):
        copy(before, found, 2 * n)
        now = has_settled(phase, sweep_once(model, phase, motion, work.joints, sweeps), lift, n)
        for i in range(2 * n):
            found[i] = where(settled, before[i], found[i])
        settled = settled | now
        if bits(~settled) == 0:
            break
    return settled & wanted


@leaf
def divide(one):
    """Divide the time of a lane until its base changes, or its run ends, into equal steps."""
    lanes, base = one.lane, one.base
    end = lanes.stop
    if base.piece_end < end - SAMPLE_SLACK * (base.piece_end - base.piece_begin):
        end = base.piece_end
    left = end - lanes.t
    pieces = in_equal_steps(left, one.model.settings.step)
    lanes.begin, lanes.end, lanes.step, lanes.pieces, lanes.made = lanes.t, end, left / pieces, pieces, 0.0


@kernel
def start_fixed(batch, fresh):
    """Compute accelerations and peaks at the start of the lanes in the mask `fresh`; return bits of runs that end."""
    work, n = batch.work, batch.model.n
    # accelerations at the start
    anchor_far_waves(batch.base, batch.lane.t)
    copy(work.end.row, work.start.row, 6 * n)
    settled = sweep_lanes(batch, work.end, batch.lane.t, fresh)
    for i in range(2 * n):
        work.start.accelerations[i] = where(fresh, work.end.accelerations[i], work.start.accelerations[i])
    for i in range(n):
        batch.state.peaks[i] = greater(batch.state.peaks[i], magnitude(work.start.theta[i]))
    # runs whose sweeps do not settle
    failed = bits(fresh & ~settled)
    for k in range(WIDTH):
        if (failed >> k) & 1:
            finish(batch, k, NOT_CONVERGED)
    return failed


@kernel
def fallen(model, phase):
    """Return the mask of lanes that have overturned, as `fallen` of batch/follow.py."""
    n = model.n
    beyond = phase.theta[n - 1] != phase.theta[n - 1]
    turn = tilt(model.blocks, phase.theta, 0, n)
    for i in range(n):
        below = tilt(model.blocks, phase.theta, i + 1, n)
        limit = model.blocks.fall_angle[i]
        beyond = beyond | (magnitude(turn) > limit) | (magnitude(turn - below) > limit)
        turn = below
    return beyond


@kernel
def step_fixed(batch):
    """Do one step of every lane that has a run; return the lanes whose run has ended as bits, as `step_on`.

    Bit WIDTH is set if a lane is marked as fresh.
    """
    work, lanes, n = batch.work, batch.lane, batch.model.n
    # end of the step; the last one of a segment ends exactly there
    busy, step = lanes.run >= 0.0, lanes.step
    made = lanes.made + 1.0
    last = made >= lanes.pieces
    t = where(last, lanes.end, lanes.begin + made * step)
    anchor_far_waves(batch.base, lanes.t)
    # central differences: eqs. 25 and 26
    predict(work, step)
    good = sweep_lanes(batch, work.end, t, busy)
    correct(work, step)
    # runs that overturn or fail within the step
    over = good & fallen(batch.model, work.end)
    fell, ended = bits(over), bits(busy & ~good)
    step = end_at_falls(batch, fell, step)
    # peaks, and the state at the end
    begin, end, peaks = work.start, work.end, batch.state.peaks
    for i in range(n):
        peaks[i] = peak_over(peaks[i], begin.theta[i], begin.theta_rate[i], end.theta[i], end.theta_rate[i], step, good)
    copy(begin.row, end.row, 6 * n)
    lanes.steps += where(good, 1.0, 0.0)
    lanes.made, lanes.t = made, t
    return _end_segments(batch, bits(busy & last), fell, ended)


@kernel
def _end_segments(batch, last, fell, failed):
    """Begin the next segment in the lanes at the end of theirs, finish runs that end; return bits as `step_fixed`."""
    ended = failed
    if last | fell | failed == 0:
        return ended
    for k in range(WIDTH):
        one = single(batch, k)
        # runs that end
        if (failed >> k) & 1:
            finish(batch, k, NOT_CONVERGED)
        elif (fell >> k) & 1:
            finish(batch, k, HAS_OVERTURNED)
            ended |= 1 << k
        elif (last >> k) & 1 and one.lane.end == one.lane.stop:
            finish(batch, k, OK)
            ended |= 1 << k
        # the next segment of the record
        elif (last >> k) & 1:
            follow_record(batch, one, one.lane.t)
            divide(one)
            if one.lane.fresh > 0.0:
                ended |= 1 << WIDTH
    return ended


@kernel
def load_fixed(batch, k, number):
    """Load a run into lane k, as `load` of batch/follow.py."""
    load(batch, k, number)
    one = single(batch, k)
    if one.base.wave_amplitude != 0.0:
        one.base.anchor = math.nan  # no anchor yet
    divide(one)


@kernel
def follow_fixed_steps(batch):
    """Pass the queue of runs through the lanes, as `follow_queue` of batch/follow.py."""
    pass_queue(batch, load_fixed, start_fixed, step_fixed)
