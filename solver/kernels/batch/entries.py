"""The entries that Python calls for many runs."""

from ..numba_ext.jit import entry, leaf
from ..numba_ext.views import lanes_of, row_of
from .follow import batch_over, follow_queue
from .runs import RIMMED_SPACE, ROUND_SLIPPING_SPACE, ROUND_SPACE, SLIPPING_SPACE, SPACE, STRIPPED_SPACE, Queue

_space, _slipping = SPACE.over, SLIPPING_SPACE.over
_round, _round_slipping, _stripped = ROUND_SPACE.over, ROUND_SLIPPING_SPACE.over, STRIPPED_SPACE.over
_rimmed = RIMMED_SPACE.over


# Arguments of an entry: number of blocks, buffer of lanes, then those of `queue_of`; all but n and count are arrays.


@leaf
def queue_of(count, models, phases, slips, runs, outcomes, times, ax, az, row_times, snapshots, flag):
    runs_of = (row_of(models), row_of(phases), row_of(slips), row_of(runs), row_of(outcomes))
    records = (row_of(times), row_of(ax), row_of(az))
    return Queue(count, *runs_of, *records, row_of(row_times), row_times.size, row_of(snapshots), row_of(flag))


@entry
def run_lanes(n, buffer, *queue):
    """`follow_queue`: all runs of columns of n blocks, eight at a time."""
    follow_queue(batch_over(_space(lanes_of(buffer), n), buffer, queue_of(*queue)))


@entry
def run_round(n, buffer, *queue):
    """All runs of columns with round joints. A separate entry: users without them do not pay its compile time."""
    follow_queue(batch_over(_round(lanes_of(buffer), n), buffer, queue_of(*queue)))


@entry
def run_slipping(n, buffer, *queue):
    """All runs of columns with slips; a separate entry for the same reason."""
    follow_queue(batch_over(_slipping(lanes_of(buffer), n), buffer, queue_of(*queue)))


@entry
def run_round_slipping(n, buffer, *queue):
    """All runs of columns with round joints and slips; a separate entry for the same reason."""
    follow_queue(batch_over(_round_slipping(lanes_of(buffer), n), buffer, queue_of(*queue)))


@entry
def run_stripped(n, buffer, *queue):
    """All runs of columns with strips, with slips or without; a separate entry for the same reason."""
    follow_queue(batch_over(_stripped(lanes_of(buffer), n), buffer, queue_of(*queue)))


@entry
def run_rimmed(n, buffer, *queue):
    """Follow all runs of columns with rims, with slips or without; a separate entry for the same reason."""
    follow_queue(batch_over(_rimmed(lanes_of(buffer), n), buffer, queue_of(*queue)))
