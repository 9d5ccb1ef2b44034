"""The runs of a batch, and the space of eight runs in lanes."""

from typing import NamedTuple

from ...engine.samples import unloaded
from ...layout.spaces import (
    BASE,
    BLOCKS,
    MODEL,
    PHASE,
    PHASE_FIELDS,
    RIGID_FIELDS,
    STATE,
    STRIP_NUMBERS,
    WORK,
)
from ...numba_ext.jit import leaf
from ...numba_ext.views import FieldTable, Numbers, Record, Space
from ..joint.sliding import MARK
from ..sections.section import RIMMED, ROUND, STRIPPED

# one run, which may be under way: its record is `count` samples from number `first` on
RUN = Record(
    "origin",  # s, start of its motion, which snapshots are counted from
    "start",  # s, start and end of the interval that is to be followed
    "stop",
    "scale",
    "wave_amplitude",
    "wave_omega",
    "wave_phase",
    "first",
    "count",
    "row",  # first snapshot not yet taken
    "rotation_scale",  # rad and
    "rate_scale",  # rad/s, the largest so far
)
# outcome of a run: a code of spaces.py, time and joint of overturning (0: it did not), steps; peaks, initially those of
# the motion before; coordinates and rates at its end
OUTCOME = Space(
    record=Record("code", "time", "overturned", "steps", "rejected"), peaks=Numbers(per_n=1), phase=Numbers(per_n=4)
)
# numbers of a lane beside those of its column
LANE = Record(
    "run",  # number of the run, -1 without one
    "t",  # s
    "stop",
    "steps",
    "rejected",
    "most_tried",  # steps and rejected ones
    "first",  # sample of the record, and
    "count",  # number of them
    "scale",
    "next_row",  # first snapshot not yet taken
    "fresh",  # 1 while the accelerations at its time are missing
    "begin",  # s, of a piece of the motion made in steps of a fixed length,
    "end",
    "step",  # s,
    "pieces",  # number of them,
    "made",  # number of them already made
    "shear_margin",  # N, least margin of shear capacity of the joints that stick, at the start of a step
    "shear_margin_ahead",  # and at the end
)
SPACE = Space(model=MODEL, state=STATE, base=BASE, lane=LANE, work=WORK)
# space of columns that have slips (formulations/slips.py), which the compiler recognizes by an empty part
_marked = {name: Space(**part.parts, **{MARK: Numbers()}) for name, part in (("model", MODEL), ("work", WORK))}
SLIPPING_SPACE = Space(**{**SPACE.parts, **_marked})


def _knowing(space: Space, *names: str) -> Space:
    """Return a space for columns with joints other than rectangles, which the compiler recognizes by empty fields."""
    model = space.parts["model"]
    assert isinstance(model, Space)
    blocks = FieldTable(*BLOCKS.fields, strips=STRIP_NUMBERS, **dict.fromkeys(names, 0))  # type: ignore[arg-type]
    return Space(**{**space.parts, "model": Space(**{**model.parts, "blocks": blocks})})


ROUND_SPACE, ROUND_SLIPPING_SPACE = _knowing(SPACE, ROUND), _knowing(SLIPPING_SPACE, ROUND)
STRIPPED_SPACE = _knowing(SLIPPING_SPACE, ROUND, STRIPPED)
RIMMED_SPACE = _knowing(SLIPPING_SPACE, ROUND, STRIPPED, RIMMED)  # of any column
SLIP_FIELDS = PHASE_FIELDS - RIGID_FIELDS  # the second part of a phase


class Queue(NamedTuple):
    """Rows of `size` runs of columns of n blocks, and of their outcomes; the samples of all their records.

    Once the number at `flag` is not zero, no more runs are started and those under way are abandoned.
    """

    size: int
    models: object  # packed models, without modal data
    phases: object  # coordinates and rates to start from
    slips: object  # second parts of phases to start from, and as they are at the end; where columns have slips
    runs: object  # records RUN
    outcomes: object  # spaces OUTCOME
    times: object  # s
    ax: object  # m/s2
    az: object
    row_times: object  # s after the start, `rows` of them: when snapshots are taken
    rows: int
    snapshots: object  # phases, `rows` for each run
    flag: object


_run, _outcome, _phase = RUN.over, OUTCOME.over, PHASE.over
_RUN_SIZE, _OUTCOME_BESIDE, _OUTCOME_PER_N = RUN.beside, OUTCOME.beside, OUTCOME.per_n
_PHASE_PER_N, _START_PER_N = PHASE.per_n, OUTCOME.parts["phase"].per_n


@leaf
def run_of(queue, k):
    """Return the record of run k."""
    return _run(queue.runs[_RUN_SIZE * k :], 0)


@leaf
def start_at(queue, k, n):
    """Return the row of coordinates and rates that run k starts from."""
    return queue.phases[_START_PER_N * n * k :]


@leaf
def slips_at(queue, k, n):
    """Return the second part of the phase of run k."""
    return queue.slips[SLIP_FIELDS * n * k :]


@leaf
def outcome_of(queue, k, n):
    """Return the outcome of run k."""
    return _outcome(queue.outcomes[(_OUTCOME_PER_N * n + _OUTCOME_BESIDE) * k :], n)


@leaf
def snapshot_of(queue, k, row, n):
    """Return the phase of snapshot number `row` of run k."""
    return _phase(queue.snapshots[_PHASE_PER_N * n * (queue.rows * k + row) :], n)


@leaf
def samples_of(queue, lane):
    """Return the record that a lane follows."""
    first = int(lane.first)
    ax, az = queue.ax[first:], queue.az[first:]
    return unloaded(queue.times[first:], int(lane.count), ax, ax, az, lane.scale, 0)
