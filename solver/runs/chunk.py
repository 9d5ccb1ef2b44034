"""The work that one thread or process does of many runs, and the rows of the table that result."""

from __future__ import annotations

import gc
import math
import pickle
import time as clock
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from multiprocessing import parent_process
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..column.block import Block, Joint
from ..column.column import Column
from ..column.packing import FloatArray, IntArray
from ..column.rest import check_stable, warnings_of
from ..column.settings import Settings
from ..common.errors import InputError, SolverError
from ..common.turns import my_turn, others_turn
from ..dynamics.kinematics import Chain, chain_of
from ..dynamics.response import Response
from ..dynamics.verdict import OVERTURNED, UNDECIDED
from ..ground.motion import Motion
from .batch import KINDS, BatchResult, follow_in_lanes
from .lane_policy import HELD, kind_of, why_not_in_lanes
from .outputs import KEPT, WATCHED, WATCHED_ALL, WATCHED_OF_BASE
from .settling import outcomes_of
from .single_run import Callback, Plan, outcome, output_times, single_run
from .table import WORDS, Columns, Table

SCALAR, LANES = "scalar", "lanes"
LEFT = ("residual_ux", "residual_theta", "residual_slip", "energy")  # results from the phase at the end


class Run(NamedTuple):
    """One run, from rest."""

    column: Column
    motion: Motion
    duration: float  # s


@dataclass(frozen=True)
class Chunk:
    """Neighbouring runs, the results to keep of them, and the places of runs whose whole response is kept."""

    first: int
    runs: Sequence[Run]
    keep: tuple[str, ...]
    settle: float  # s, the longest that a column is followed after the duration
    whole: tuple[int, ...] = ()
    weight: float = 0.0  # rough cost of the runs; 1: one block for a second in lanes
    checked: bool = False  # whether all columns have been checked to be able to stand


@dataclass
class Tally:
    """How runs were made: by which path, why not in lanes; errors of those that failed; s of the clock."""

    paths: Counter[str] = field(default_factory=Counter)
    why_scalar: Counter[str] = field(default_factory=Counter)
    failures: dict[int, str] = field(default_factory=dict)
    warnings: dict[int, str] = field(default_factory=dict)
    seconds: float = 0.0


Made = tuple[Table, Tally]


def why_alone(column: Column, keep: Collection[str]) -> str:
    """Why runs of a column are not made in lanes; empty where they are, unless the motion has HELD samples."""
    return why_not_in_lanes(column) or ("" if WATCHED_ALL.isdisjoint(keep) else "peaks of more than ux")


class Stopped(Exception):  # noqa: N818  nothing went wrong
    """The chunk is no longer wanted."""


def make_runs(chunk: Chunk, flag: FloatArray | None = None) -> Made:
    """Make the runs of a chunk, in one thread. Raises InputError, and Stopped soon after flag[0] is not zero."""
    with my_turn():
        load_kernels(kind_of(chunk.runs[0].column))
        begin = clock.perf_counter()
        table, tally = _made(chunk, np.zeros(1) if flag is None else flag)
        tally.seconds = clock.perf_counter() - begin
        return table, tally


def packed(chunk: Chunk) -> bytes:
    """The chunk for an executor to send. Dask alone would send every array of it separately, at ten times the cost."""
    return pickle.dumps(chunk, pickle.HIGHEST_PROTOCOL)


def make_packed(chunk: bytes) -> Made:
    """As `make_runs`, of a result of `packed`."""
    made: Chunk = pickle.loads(chunk)
    return make_runs(made)


def _made(chunk: Chunk, flag: FloatArray) -> Made:
    tally = Tally()
    if not chunk.checked:
        check_columns(chunk, tally)
    columns = empty_columns(chunk)
    alone = _in_lanes(chunk, columns, tally, flag)

    def look(*_: object) -> None:
        if flag[0]:
            raise Stopped

    for place, why in sorted(alone.items()):
        look()
        with others_turn():
            failure = _alone(chunk.runs[place], chunk, columns, place, look)
        if failure:
            tally.failures[chunk.first + place] = failure
        tally.why_scalar[why] += 1
    tally.paths.update({SCALAR: len(alone), LANES: len(chunk.runs) - len(alone)})
    wanted = [place for place in chunk.whole if chunk.first + place not in tally.failures]
    with others_turn():
        responses = {chunk.first + place: _response(chunk.runs[place], chunk.settle, look) for place in wanted}
    return Table(columns, responses=responses, first=chunk.first), tally


@lru_cache(maxsize=len(KINDS))
def load_kernels(name: str) -> None:
    """Load the kernels of a kind of lanes into this process, which takes as long as thousands of runs.

    Called before the clock starts, so compile time is not counted.
    """
    kind = KINDS[name]
    joint = Joint(1e9, 1e-3, friction=1.0 if kind.slips else None)
    if kind.section == "strips":
        joint = replace(joint, section="strips", strips=(1.0,))
    block = Block(1.0, 1.0, 1.0, 1e3, joint, section="circle" if kind.section == "circle" else "rectangle")
    solver = ("paper", "central-difference") if kind.fixed_step else ("exact", "auto")
    column = Column("block", (block,), Settings(*solver))
    gentle, strong = (Motion.harmonic(amplitude, 1.0, 1e-3) for amplitude in (1e-3, 100.0))
    follow_in_lanes([column, column], [gentle, strong], [1e-3, 1e-3])
    if parent_process() is not None:  # a worker of ours, not a user's process
        gc.freeze()  # compiled code stays: repeated garbage collection of it took 4 % of the time


def check_columns(chunk: Chunk, tally: Tally) -> None:
    """Note warnings. Raises InputError for a column that cannot stand, or whose peaks are kept but not computed."""
    seen: set[int] = set()
    asked = [name for name in chunk.keep if name in WATCHED_ALL]
    for place, run in enumerate(chunk.runs):
        if id(run.column) in seen:
            continue
        seen.add(id(run.column))
        try:
            check_stable(run.column)
            if asked and "peaks" in run.column.settings.without:
                raise InputError(f'solver.without has "peaks", must not where {asked[0]} is kept')
        except InputError as error:
            raise InputError(f"columns[{chunk.first + place}]: {error}") from None
        for line in warnings_of(run.column):
            tally.warnings[chunk.first + place] = line


def empty_columns(chunk: Chunk) -> Columns:
    """Columns for all the runs of a chunk, with the values of a run that failed."""
    count, most = len(chunk.runs), max(run.column.n for run in chunk.runs)
    columns: Columns = {}
    for name in chunk.keep:
        kind = KEPT[name].kind
        shape = (count, most) if kind is None else (count,)
        columns[name] = np.zeros(shape, dtype=kind or np.float64)
        if columns[name].dtype.kind == "f":
            columns[name][:] = math.nan
    for name, word in (("verdict", UNDECIDED), ("path", SCALAR)):
        if name in columns:
            columns[name][:] = WORDS[name].index(word)
    return columns


# --- in lanes


def _in_lanes(chunk: Chunk, columns: Columns, tally: Tally, flag: FloatArray) -> dict[int, str]:
    """Make the runs that lanes can make into the columns. Returns the places of the others, and the reasons."""
    alone: dict[int, str] = {}
    groups: dict[tuple[int, str], list[int]] = {}
    known: dict[int, str] = {}  # of the same column
    for place, (column, motion, _) in enumerate(chunk.runs):
        if id(column) not in known:
            known[id(column)] = why_alone(column, chunk.keep)
        why = known[id(column)] or (HELD if motion.hold else "")
        if why:
            alone[place] = why
        else:
            groups.setdefault((column.n, kind_of(column)), []).append(place)
    for places in groups.values():
        runs = [chunk.runs[place] for place in places]
        batch = follow_in_lanes(
            [run.column for run in runs], [run.motion for run in runs], [run.duration for run in runs], flag=flag
        )
        if flag[0]:
            raise Stopped
        _fill(columns, np.array(places), runs, batch, chunk.settle, flag)
        if flag[0]:
            raise Stopped
        alone |= {
            place: "could not go on in lanes" for place, made in zip(places, batch.finished, strict=True) if not made
        }
    return alone


def _fill(
    columns: Columns, places: IntArray, runs: Sequence[Run], batch: BatchResult, settle: float, flag: FloatArray
) -> None:
    """Write the results of runs with equal numbers of blocks, in lanes of one kind, into the columns."""
    n = runs[0].column.n
    wanted = [name for name in LEFT if name in columns]
    if KINDS[kind_of(runs[0].column)].slips:
        chain = None
        chains = [chain_of(run.column) for run in runs]
        left = {name: np.array([*map(partial(_at_the_end, name), chains, batch.ends)]) for name in wanted}
    else:
        chain = Chain.of_many(batch.models, n)
        left = {name: np.array(_at_the_end(name, chain, batch.ends)) for name in wanted}
    for values in left.values():
        values[batch.overturned_joint > 0] = math.nan
    words, times, joints = _verdicts(runs, batch, chain, settle, flag)
    made: Columns = {
        **left,
        "peak_ux": batch.peak_ux,
        "verdict": words,
        "overturn_time": times,
        "overturned_joint": joints,
        "steps": batch.steps,
        "evaluations": batch.evaluations,
        "path": np.full(len(runs), WORDS["path"].index(LANES)),
    }
    for name, values in columns.items():
        if values.ndim == 2:
            values[places, :n] = made[name]
        else:
            values[places] = made[name]


def _verdicts(
    runs: Sequence[Run], batch: BatchResult, chain: Chain | None, settle: float, flag: FloatArray
) -> tuple[IntArray, FloatArray, IntArray]:
    """Numbers of the words, times of overturning (NaN: it stands) and joints; undecided runs are followed further.

    chain: None for columns that have slips, which are followed one by one.
    """
    joints, times, code = batch.overturned_joint.copy(), batch.overturn_time.copy(), WORDS["verdict"].index
    words = np.full(len(runs), code(OVERTURNED))  # or not finished: such runs are made again alone
    ended = np.flatnonzero(batch.finished & (joints == 0))
    stops = np.array([run.motion.start + run.duration for run in runs])
    if chain is not None and ended.size:
        columns = [runs[k].column for k in ended.tolist()]
        found = outcomes_of(columns, chain.some(ended), batch.ends[ended], stops[ended], settle, flag)
        words[ended], times[ended], joints[ended] = found
    elif chain is None:
        for k in ended.tolist():
            if flag[0]:
                break
            word, times[k], joints[k] = outcome(runs[k].column, batch.ends[k], float(stops[k]), settle)
            words[k] = code(word)
    return words, times, joints


# --- one by one


def _response(run: Run, settle: float, look: Callback) -> Response:
    """The whole response of a run, with the rows of `simulate`."""
    times = output_times(run.motion, run.duration)
    return single_run(run.column, Plan(run.motion, run.duration, times, None, settle, look))[0]


def _alone(run: Run, chunk: Chunk, columns: Columns, place: int, look: Callback) -> str:
    """Make one run alone and write it into the columns. Returns the error, or an empty text."""
    end = np.array([run.motion.start + run.duration])
    column = run.column
    if WATCHED_ALL.isdisjoint(chunk.keep):
        column = column.with_settings(without=(*column.settings.without, "peaks"))  # but those of ux
    try:
        response, phases = single_run(column, Plan(run.motion, run.duration, end, None, chunk.settle, look))
    except SolverError as failure:
        return str(failure)
    stands = not response.overturn_time <= end[0]
    for name, values in columns.items():
        values[place, ...] = _padded(_value(name, run.column, response, phases[0], stands), values[place])
    return ""


def _padded(value: Any, like: NDArray[Any]) -> Any:
    if np.ndim(value) == 0 or len(value) == len(like):
        return value
    return np.concatenate([value, np.full(len(like) - len(value), math.nan)])


def _value(name: str, column: Column, response: Response, phase: FloatArray, stands: bool) -> Any:
    """The result of this name of a run that ends with this phase, (4 n,); stands: whether it stands then."""
    if name == "path":
        return WORDS[name].index(SCALAR)
    if name == "verdict":
        return WORDS[name].index(response.verdict)
    if name in ("steps", "evaluations"):
        return response.stats[name]
    if name in WATCHED:
        return response.peaks[WATCHED[name]]
    if name in WATCHED_OF_BASE:
        return response.peaks[WATCHED_OF_BASE[name]][0]
    if name in LEFT:
        return _at_the_end(name, chain_of(column), phase) if stands else math.nan
    return getattr(response, name)


def _at_the_end(name: str, chain: Chain, phase: FloatArray) -> Any:
    """One of LEFT, of a column with this phase, or of many with a phase each."""
    if name == "energy":
        return chain.energies(phase)
    if name == "residual_ux":
        return chain.top_displacements(phase)
    places = chain.places(phase)
    return places.theta if name == "residual_theta" else np.broadcast_to(places.slip - chain.offset, places.theta.shape)
