"""The entry that Python calls for many runs."""

from ..jit import entry
from ..views import row_of
from .follow import follow_queue
from .runs import Queue


@entry
def run_lanes(n, buffer, count, models, phases, runs, outcomes, times, ax, az, row_times, snapshots, flag):
    """`follow_queue`: all runs of columns of n blocks, eight at a time. All but n and count are arrays."""
    queue = Queue(
        count,
        row_of(models),
        row_of(phases),
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
    follow_queue(n, buffer, queue)
