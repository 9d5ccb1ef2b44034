"""Many runs: any mixture of columns and motions, in threads or in any executor, in one table."""

from __future__ import annotations

import itertools
import math
import sys
import time as clock
import warnings
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, ThreadPoolExecutor
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

import numpy as np

from ..common.errors import (
    POSITIVE,
    InputError,
    InputWarning,
    SolverError,
    check_number,
    check_type,
    check_whole,
    shown,
)
from ..common.executors import TRIES, cores, error_text, sent_out, workers_of
from ..ground.motion import Motion, check_loads, check_strength
from ..models.protocol import SETTLE, SETTLING, Kind, Model, Run, Work
from .chunk import Chunk, Made, make_packed, make_runs, packed
from .pace import Pace
from .table import Table, joined

FIRST_COST = 2e-5  # s per block and second of motion in lanes, before any run is measured
MOST_SAMPLES = 2**20  # of the records of a chunk, so that memory does not grow with the number of runs
_ENDED = object()

Callback = Callable[[int, int | None], object]


def begin_phase(callback: Callback | None, phase: str) -> None:
    """Tell a callback that has a method `begin` which runs come next, in a few words."""
    begin = getattr(callback, "begin", None)
    if begin is not None:
        begin(phase)


class ExecutorError(SolverError):
    """A failure of an executor; `finished` has tables of the runs that were made, of consecutive runs each."""

    finished: Sequence[Table] = ()


def simulate_many(
    columns: Model | Iterable[Model],
    motions: Motion | Iterable[Motion],
    *,
    duration: float | Iterable[float | None] | None = None,
    tolerance: float | Iterable[float | None] | None = None,
    keep: Sequence[str] | None = None,
    executor: Any = None,
    threads: int | None = None,
    settle: float = SETTLE,
    responses: Collection[int] = (),
    callback: Callback | None = None,
) -> Table:
    """Run column k under motion k, each from rest, and return a table with a row for each run; or structures in space.

    `columns`, `motions`, `duration` and `tolerance` are one for all runs, or one for each run, and may differ in
    everything. Iterables are read as needed, so that memory does not grow with the number of runs, but for the table.
    The options are in the groups of `simulate`, and one of their own:

    Accuracy. tolerance: relative to the peak; None: that of the column.

    Output. keep: results that the table holds; None: the largest displacements and the verdict. responses: numbers of
    runs of which the whole Response is kept, in `table.responses`; each is a run alone, and if that cannot be finished
    `table.stats["no_response"]` has the reason. callback: called as callback(runs made, runs in all or None) as they
    end; an exception that it raises ends `simulate_many`.

    Verdict. settle: as in `simulate`.

    Work. executor: anything with `submit`, such as a process pool or a client of Dask; None: threads of this
    process. threads: number of these; None: one for each core.

    The numbers are the same, bit for bit, for any threads, workers and order. A run that the solver cannot finish is
    "undecided", its numbers are NaN and `table.stats["failures"]` has the reason; so has that of a structure without a
    rest, which is "overturned" at once. A column without a rest is refused.

    Parameters
    ----------
    columns : Column or Structure, or iterable of them
        Models.
    motions : Motion, or iterable of Motion
        Base motions.
    duration : float, or iterable of float, optional
        Length of the run, s. None: that of the motion.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        If a value is wrong.
    ExecutorError
        If the executor fails.

    Warns
    -----
    InputWarning
        As `simulate`, once for all runs.
    """
    summary = Summary()
    parts: list[Table] = []
    try:
        for part in parts_of_many(
            columns,
            motions,
            duration=duration,
            tolerance=tolerance,
            keep=keep,
            executor=executor,
            threads=threads,
            settle=settle,
            responses=responses,
            callback=callback,
            summary=summary,
        ):
            parts.append(part)
    except ExecutorError as lost:
        lost.finished = parts
        raise
    return collected(parts, summary)


def collected(parts: Iterable[Table], summary: Summary) -> Table:
    """Return the table of all runs, in their order, from the parts of `parts_of_many`."""
    table = joined(sorted(parts, key=lambda part: part.first))
    table.stats = summary.as_dict()
    return table


def parts_of_many(
    columns: Model | Iterable[Model],
    motions: Motion | Iterable[Motion],
    *,
    duration: float | Iterable[float | None] | None = None,
    tolerance: float | Iterable[float | None] | None = None,
    keep: Sequence[str] | None = None,
    executor: Any = None,
    threads: int | None = None,
    settle: float = SETTLE,
    responses: Collection[int] = (),
    callback: Callback | None = None,
    summary: Summary | None = None,
    refuses: bool = True,
) -> Iterator[Table]:
    """Yield tables of consecutive runs as they end, in any order; `first` is the number of the first run of each.

    Parameters
    ----------
    columns, motions, duration, tolerance, keep, executor, threads, settle, responses, callback
        As in `simulate_many`.
    summary : Summary, optional
        Updated as the runs end.
    refuses : bool
        Whether a column without a rest is an error; else it falls at once, as a structure does.

    Raises
    ------
    InputError
        If a value is wrong.
    ExecutorError
        If the executor fails.
    """
    check_type("callback", callback, Callable, None)
    settle, whole = _checked(settle, threads, responses)
    first, columns = _first_of(columns)
    kind: Kind | None = getattr(first, "kind", None)
    keys = () if kind is None else kind.keys_of(kind.usually_kept if keep is None else keep)
    # chunks of about equal cost
    total, runs = _runs(columns, motions, duration, tolerance)
    if total is not None and whole and max(whole) >= total:
        raise InputError(f"responses: {max(whole)}: must be numbers of runs, of which there are {total}, from 0")
    summary = Summary() if summary is None else summary
    workers = (threads or cores()) if executor is None else workers_of(executor)
    pace = Pace(total, workers, FIRST_COST)
    chunks = _chunks(runs, pace, keys, settle, whole, refuses)
    if executor is not None:
        made = _made(chunks, lambda chunk: executor.submit(make_packed, packed(chunk)), pace, workers)
        yield from _noted(made, summary, total, callback)
        return
    # threads of this process; the flag stops them if the caller ends early
    flag = np.zeros(1)
    pool = ThreadPoolExecutor(workers, thread_name_prefix="runs")
    try:
        made = _made(chunks, lambda chunk: pool.submit(make_runs, chunk, flag), pace, workers)
        yield from _noted(made, summary, total, callback)
    finally:
        flag[0] = 1.0
        pool.shutdown(wait=True, cancel_futures=True)


# --- arguments


def _first_of(columns: Any) -> tuple[Any, Any]:
    """Return the first model and all models; an iterable that can be read only once starts with the first again."""
    if not isinstance(columns, Iterable):
        return columns, columns
    left = iter(columns)
    first = next(left, None)
    return first, columns if left is not columns else itertools.chain(() if first is None else (first,), left)


def _checked(settle: float, threads: int | None, responses: Any) -> tuple[float, frozenset[int]]:
    """Return the settling time, s, and the numbers of the runs whose responses are kept. Raises InputError."""
    if threads is not None:
        check_whole("threads", threads, 1, math.inf, "a number of threads, at least 1")
    if not isinstance(responses, Collection) or isinstance(responses, (str, bytes)):
        raise InputError(f"responses = {shown(responses)}: must be a list of numbers of runs")
    whole = frozenset(check_whole("responses", number, 0, math.inf, "numbers of runs, from 0") for number in responses)
    return check_number("settle", settle, *SETTLING), whole


def _runs(columns: Any, motions: Any, durations: Any, tolerances: Any) -> tuple[int | None, Iterator[Any]]:
    """Return the number of runs, None if unknown, and an iterator over them. Raises InputError if lengths differ."""
    given = {"columns": columns, "motions": motions, "duration": durations, "tolerance": tolerances}
    several = {key: value for key, value in given.items() if _is_several(key, value)}
    lengths = {key: len(value) for key, value in several.items() if hasattr(value, "__len__")}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{count} {key}" for key, count in lengths.items())
        raise InputError(f"{listed}: must be as many of each, or a single one for all runs")
    total = next(iter(lengths.values()), None) if several else 1
    return total, _iterated(given, several)


def _is_several(key: str, value: Any) -> bool:
    single = hasattr(value, "kind") if key == "columns" else isinstance(value, (Motion, Real))
    if value is None or single:
        if value is None and key in ("columns", "motions"):
            raise InputError(f"{key} = None: must be one for all runs, or one for each")
        return False
    if not isinstance(value, Iterable):
        raise InputError(f"{key} = {shown(value)}: must be one for all runs, or one for each")
    return True


def _iterated(given: dict[str, Any], several: dict[str, Any]) -> Iterator[Run]:
    sources = [iter(several[key]) if key in several else itertools.repeat(given[key]) for key in given]
    last: tuple[Any, Any] = (None, None)  # model and tolerance as given
    kind: Kind | None = None  # of the first
    strong, shaken, late = False, None, False
    rows = itertools.zip_longest(*sources, fillvalue=_ENDED) if several else [tuple(given.values())]
    for k, values in enumerate(rows):
        ended = [key for key, value in zip(given, values, strict=True) if value is _ENDED]
        longer = [key for key in several if key not in ended]
        if ended and longer:
            raise InputError(f"{ended[0]}: ends after {k}, {longer[0]} does not: must be as many of each")
        if ended:
            return
        # a model with its tolerance is validated once for consecutive runs
        column, motion, duration, tolerance = values
        if last[0] is not column or last[1] != tolerance:
            last = column, tolerance
            made, kind = _with_tolerance(k, column, tolerance, kind)
        if not isinstance(motion, Motion):
            raise InputError(f"motions[{k}] = {shown(motion)}: must be a Motion")
        if kind is not None:
            kind.check_motion(motion)
        if motion is not shaken and not strong:
            shaken, strong = motion, check_strength(motion)
        span = motion.duration if duration is None else duration
        span = check_number(f"duration[{k}]", span, POSITIVE, "a positive time in s")
        late = late or check_loads(motion, span)
        yield Run(made, motion, span)


def _with_tolerance(k: int, model: Any, tolerance: Any, kind: Kind | None) -> tuple[Any, Kind]:
    """Return the model with a tolerance (None keeps its own), and its kind, which must be that of the first model."""
    own: Kind | None = getattr(model, "kind", None)
    if own is None or own.word != (kind or own).word:
        word = "a model" if kind is None else f"a {kind.word}, as the first one"
        raise InputError(f"columns[{k}] = {shown(model)}: must be {word}")
    if tolerance is None:
        return model, own
    try:
        return model.with_settings(tolerance=tolerance), own
    except InputError as error:
        raise InputError(f"tolerance[{k}]: {error}") from None


# --- chunks


def estimated_cost(run: Run, keep: tuple[str, ...]) -> float:
    """Estimate the cost of a run, s, before any is measured."""
    work: Work = run.model.kind.work(run.model, keep)
    return FIRST_COST * work.of(run.duration)


def _chunks(
    runs: Iterator[Run], pace: Pace, keep: tuple[str, ...], settle: float, whole: frozenset[int], refuses: bool
) -> Iterator[Chunk]:
    first, samples, weight = 0, 0, 0.0
    taken: list[Run] = []
    records: set[int] = set()
    model: Any = None
    work = Work(0.0, 0.0)

    def chunk() -> Chunk:
        places = tuple(k for k in range(len(taken)) if first + k in whole)
        return Chunk(first, taken, keep, settle, places, weight, refuses=refuses)

    # a chunk ends at its cost, or at the most samples of its records
    for run in runs:
        taken.append(run)
        if run.model is not model:
            model, work = run.model, run.model.kind.work(run.model, keep)
        weight += work.of(run.duration)
        if id(run.motion) not in records:
            records.add(id(run.motion))
            samples += len(run.motion.time)
        if pace.enough(len(taken), weight) or samples >= MOST_SAMPLES:
            yield chunk()
            first += len(taken)
            pace.sent(len(taken))
            taken, weight, samples, records = [], 0.0, 0, set()
    if taken:
        yield chunk()


def _made(chunks: Iterator[Chunk], submit: Callable[[Chunk], Any], pace: Pace, workers: int) -> Iterator[Made]:
    """Yield table and tally of each chunk as it ends. Raises what a chunk raises."""
    for chunk, made in sent_out(chunks, submit, workers, failed=_failed, error=ExecutorError):
        pace.update_cost(len(chunk.runs), chunk.weight, made[1].seconds)
        yield made


def _failed(chunk: Chunk, tries: int, error: BaseException) -> None:
    """Raise the error, unless the chunk may be tried again because its worker or the connection to it was lost."""
    if isinstance(error, (InputError, SolverError)):
        raise error
    if tries >= TRIES or not isinstance(error, (BrokenExecutor, CancelledError, OSError)):
        raise ExecutorError(f"runs from number {chunk.first}: {error_text(error)}") from error


# --- results


@dataclass
class Summary:
    """The contents of `Table.stats`: runs by path, reasons for scalar runs, failures and wall-clock time, s."""

    runs: int = 0
    chunks: int = 0
    paths: Counter[str] = field(default_factory=Counter)
    why_scalar: Counter[str] = field(default_factory=Counter)
    failures: dict[int, str] = field(default_factory=dict)
    no_response: dict[int, str] = field(default_factory=dict)
    warned: int = 0
    begin: float = field(default_factory=clock.perf_counter)

    def add(self, table: Table, made: Any) -> None:
        """Add the tally of a chunk."""
        self.runs += len(table)
        self.chunks += 1
        self.paths.update(made.paths)
        self.why_scalar.update(made.why_scalar)
        for number, failure in made.failures.items():
            self.failures[number] = sys.intern(failure)  # mostly a few texts, of many runs
        self.no_response.update(made.no_response)
        if made.warnings and not self.warned:
            number, line = next(iter(made.warnings.items()))
            warnings.warn(f"columns[{number}]: {line}", InputWarning, stacklevel=2)
        self.warned += len(made.warnings)

    def as_dict(self) -> dict[str, Any]:
        """Return the dictionary of `Table.stats`."""
        return {
            "runs": self.runs,
            "lanes": self.paths["lanes"],
            "scalar": self.paths["scalar"],
            "why_scalar": dict(self.why_scalar),
            "failed": len(self.failures),
            "failures": dict(sorted(self.failures.items())),
            "no_response": dict(sorted(self.no_response.items())),
            "doubtful_columns": self.warned,
            "chunks": self.chunks,
            "wall_time": clock.perf_counter() - self.begin,
        }


def _noted(made: Iterator[Made], summary: Summary, total: int | None, callback: Callback | None) -> Iterator[Table]:
    for table, tally in made:
        summary.add(table, tally)
        if callback is not None:
            callback(summary.runs, total)
        yield table
