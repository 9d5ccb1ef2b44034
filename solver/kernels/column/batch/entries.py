"""Entries that Python calls for many runs, one for each kind of lanes, compiled where it is needed."""

from ...machine.entry import entry
from ...machine.kinds import Int, Reals, SizedReals
from ...numba_ext.views import lanes_of
from .follow import batch_over, follow_queue
from .runs import (
    RIMMED_SPACE,
    ROUND_SLIPPING_SPACE,
    ROUND_SPACE,
    SLIPPING_SPACE,
    SPACE,
    STRIPPED_SPACE,
    Queue,
)


def lanes_entry(name, group, module, space, follow):
    """Return the entry that follows all runs of columns of n blocks, eight at a time, over a space of names.

    follow: a kernel, `follow_queue` or another.
    """
    over = space.over

    def run_in_lanes(
        n: Int, buffer: Reals, count: Int, models: Reals, phases: Reals, slips: Reals, runs: Reals, outcomes: Reals,
        times: Reals, ax: Reals, az: Reals, row_times: SizedReals, snapshots: Reals, flag: Reals,
    ):  # fmt: skip
        """Follow all runs; buffer: eight numbers for each of a lane."""
        # queue of the runs, and the batch over the buffer
        of_runs, record = (models, phases, slips, runs, outcomes), (times, ax, az)
        queue = Queue(count, *of_runs, *record, row_times.row, row_times.size, snapshots, flag)
        follow(batch_over(over(lanes_of(buffer), n), buffer, queue))

    # machine code finds the entry by this name
    run_in_lanes.__name__ = name
    return entry(group, module)(run_in_lanes)


run_lanes = lanes_entry("run_lanes", "lanes", __name__, SPACE, follow_queue)
run_round = lanes_entry("run_round", "lanes_round", __name__, ROUND_SPACE, follow_queue)
run_slipping = lanes_entry("run_slipping", "lanes_slipping", __name__, SLIPPING_SPACE, follow_queue)
run_round_slipping = lanes_entry(
    "run_round_slipping", "lanes_round_slipping", __name__, ROUND_SLIPPING_SPACE, follow_queue
)
run_stripped = lanes_entry("run_stripped", "lanes_strips", __name__, STRIPPED_SPACE, follow_queue)
run_rimmed = lanes_entry("run_rimmed", "lanes_rims", __name__, RIMMED_SPACE, follow_queue)
