"""What is kept of a run: the peaks of the displacements, and snapshots at the times that are asked for."""

from .dynamics import base_acceleration, reach_of, scratch_offset, top_motion
from .interpolation import interpolate_acceleration, interpolate_one, interpolate_phase, refine, turning_point
from .jit import kernel, leaf
from .layout import (
    BASE_AX,
    BASE_AZ,
    EXACT,
    FORMULATION,
    N_BLOCKS,
    NEXT_ROW,
    PHASE_BETWEEN,
    PHASE_END,
    PHASE_START,
    SLACK,
    SNAPSHOT_AX,
    SNAPSHOT_AZ,
    STATE_HEADER,
    TOP_BETWEEN,
    TOP_END,
    TOP_START,
)


@kernel
def track_peaks(model, state, inputs, work, counters, t, h):
    """Raise the peaks of |u_x| by the step just made from t to t + h, turning points inside it included."""
    n = int(model[N_BLOCKS])
    fields = scratch_offset(n)
    start, end, between = 6 * n * PHASE_START, 6 * n * PHASE_END, 6 * n * PHASE_BETWEEN
    peaks = STATE_HEADER + 6 * n
    # nobody can have moved by more than this in the step: leave it there unless it reaches a peak
    reach = 0.0
    passed = False
    for i in range(n - 1, -1, -1):
        reach += reach_of(model, work, end, i) + h * reach_of(model, work, end + 2 * n, i)
        passed = passed or reach > state[peaks + i]
    if not passed:
        return
    first, last, middle = fields + TOP_START * n, fields + TOP_END * n, fields + TOP_BETWEEN * n
    top_motion(model, work, start, work, first)
    top_motion(model, work, end, work, last)
    for i in range(n):
        d0, d1 = work[first + i], work[last + i]
        v0, v1 = work[first + n + i], work[last + n + i]
        state[peaks + i] = max(state[peaks + i], abs(d1))
        # beyond its ends the step can only add a turning point, and no more than a quarter of speed times step
        if v0 * v1 < 0.0 and max(abs(d0), abs(d1)) + h * min(abs(v0), abs(v1)) > state[peaks + i]:
            refine(model, inputs, work, counters, t, h)
            interpolate_phase(work, 2 * n, h, turning_point(d0, v0, d1, v1, h))
            top_motion(model, work, between, work, middle)
            state[peaks + i] = max(state[peaks + i], abs(work[middle + i]))


@leaf
def row_due(counters, times, t, h):
    """Whether a snapshot falls into the step from t to t + h."""
    return counters[NEXT_ROW] < times.size and times[counters[NEXT_ROW]] <= t + h * (1.0 + SLACK)


@kernel
def take_snapshots(model, inputs, work, counters, t, h, times, snapshots):
    """Keep the column as it is at those of `times` that fall into the step from t to t + h."""
    size = 2 * int(model[N_BLOCKS])
    guess = model[FORMULATION] != EXACT  # accelerations are worked out when the row is; the sweeps want a first guess
    while row_due(counters, times, t, h):
        r = counters[NEXT_ROW]
        fraction = min(1.0, max(0.0, (times[r] - t) / h))
        refine(model, inputs, work, counters, t, h)
        for i in range(size):
            snapshots[r, i], snapshots[r, size + i] = interpolate_one(work, size, i, h, fraction)
            if guess:
                snapshots[r, 2 * size + i] = interpolate_acceleration(work, size, i, fraction)
        base_ax, base_az = base_acceleration(inputs, t + fraction * h)
        snapshots[r, 3 * size + SNAPSHOT_AX] = base_ax
        snapshots[r, 3 * size + SNAPSHOT_AZ] = base_az
        counters[NEXT_ROW] += 1


@kernel
def take_held_snapshots(model, state, counters, t, h, times, snapshots):
    """The same for a column whose state does not change from t to t + h."""
    n = int(model[N_BLOCKS])
    while row_due(counters, times, t, h):
        r = counters[NEXT_ROW]
        for i in range(6 * n):
            snapshots[r, i] = state[STATE_HEADER + i]
        snapshots[r, 6 * n + SNAPSHOT_AX] = state[BASE_AX]
        snapshots[r, 6 * n + SNAPSHOT_AZ] = state[BASE_AZ]
        counters[NEXT_ROW] += 1
