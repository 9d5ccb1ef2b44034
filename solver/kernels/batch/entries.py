"""The entries that Python calls for many runs."""

from ..jit import entry, leaf
from ..views import row_of
from .follow import batch_over, follow_queue, round_batch_over, round_slipping_batch_over, slipping_batch_over
from .runs import Queue
from .swept import follow_swept


@leaf
def _queue_of(count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag):
    return Queue(
        count,
        row_of(models),
        row_of(phases),
        row_of(slips),
        row_of(runs),
        row_of(outcomes),
        row_of(times),
        row_of(ax),
        row_of(az),
        row_of(row_times),
        row_times.size,
        row_of(snapshots),
        row_of(flag),
    )


@entry
def run_lanes(n, buffer, count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag):
    """`follow_queue`: all runs of columns of n blocks, eight at a time. All but n and count are arrays."""
    queue = _queue_of(count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag)
    follow_queue(batch_over(n, buffer, queue))


@entry
def run_round(n, buffer, count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag):
    """The same of columns with round joints. An entry of its own: who has no such columns does not wait for it."""
    queue = _queue_of(count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag)
    follow_queue(round_batch_over(n, buffer, queue))


@entry
def run_slipping(n, buffer, count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag):
    """The same of columns with slips, likewise."""
    queue = _queue_of(count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag)
    follow_queue(slipping_batch_over(n, buffer, queue))


@entry
def run_round_slipping(
    n, buffer, count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag
):
    """The same of columns with both, likewise."""
    queue = _queue_of(count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag)
    follow_queue(round_slipping_batch_over(n, buffer, queue))


@entry
def run_swept(n, buffer, count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag):
    """`follow_swept`, the same of the first-order formulation; no snapshots."""
    queue = _queue_of(count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag)
    follow_swept(n, buffer, queue)
