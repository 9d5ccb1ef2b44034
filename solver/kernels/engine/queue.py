"""The queue of runs that pass through eight lanes, their error control, and peaks between the ends of a step."""

from ..layout.spaces import (
    SLACK,
)
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import (
    WIDTH,
    any_of,
    greater,
    lane,
    lesser,
    magnitude,
    splat,
    square_root,
    where,
)
from .control import (
    GROW,
    LEAST_ERROR,
    SAFETY,
    SHRINK,
)

NO_RUN = -1.0


@kernel
def control_steps(control, step, error):
    """Set the next steps (s) by the errors in tolerances; return the mask of lanes whose step is accurate enough.

    As stepping/control.py, with exponents that can be computed with roots: 5/8 and 5/16 over the order.
    """
    good = error <= 1.0
    # roots of the last two errors
    least = greater(error, LEAST_ERROR)
    fourth = square_root(square_root(least))
    previous = square_root(square_root(square_root(square_root(control.previous_error))))
    grow = lesser(greater(SAFETY * previous / square_root(fourth), SHRINK), GROW)
    shrink = where(error < 1e300, greater(SAFETY / fourth, SHRINK), SHRINK)
    # longer steps after accepted ones, shorter steps after rejected ones
    proposed = step * grow
    whole = step >= control.next_step * (1.0 - SLACK)
    longer = where(grow < 1.0, proposed, greater(proposed, control.next_step))
    control.next_step = where(good, longer, step * shrink)
    control.previous_error = where(good, where(whole, least, control.previous_error), 1.0)
    return good


@leaf
def peak_over(peak, d0, v0, d1, v1, step, good):
    """Return the peak of |d| (m) after a step (s) of the good lanes, turning points included.

    d0, v0, d1, v1: displacements (m) and velocities (m/s) at start and end.
    """
    # at the end of the step
    most = greater(peak, magnitude(d1))
    turns = good & (v0 * v1 < 0.0)
    if any_of(turns):
        # the cubic through both ends: its velocity is v0 + 2 b s + 3 c s^2
        rise = (d1 - d0) / step
        b = 3.0 * rise - 2.0 * v0 - v1
        c = v0 + v1 - 2.0 * rise
        root = square_root(greater(b * b - 3.0 * c * v0, 0.0))
        below = where(b > 0.0, -(b + root), root - b)
        s = v0 / below
        s = where((s >= 0.0) & (s <= 1.0), s, below / (3.0 * c))
        s = lesser(greater(s, 0.0), 1.0)
        turned = d0 + step * (s * (v0 + s * (b + s * c)))
        most = where(turns, greater(most, magnitude(turned)), most)
    return where(good, most, peak)


@leaf
def pass_queue(batch, load_run, start_lanes, step_lanes):
    """Follow all runs of the queue by functions that take the place of `load`, `start` and `step_on`.

    Always inlined: a call would pass the addresses of the functions, and numba does not cache code with addresses.
    """
    queue = batch.queue
    batch.lane.run = splat(NO_RUN)
    waiting, running = 0, 0
    while (waiting < queue.size or running > 0) and queue.flag[0] == 0.0:
        # load waiting runs into free lanes
        for k in range(WIDTH):
            if waiting < queue.size and lane(batch.lane.run, k) < 0.0:
                load_run(batch, k, waiting)
                waiting += 1
                running += 1
        # start these, and step until a run ends
        fresh = (batch.lane.fresh > 0.0) & (batch.lane.run >= 0.0)
        batch.lane.fresh = 0.0
        ended = start_lanes(batch, fresh)
        while ended == 0 and queue.flag[0] == 0.0:
            ended = step_lanes(batch)
        for k in range(WIDTH):
            running -= (ended >> k) & 1
