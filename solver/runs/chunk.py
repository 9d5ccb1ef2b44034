"""Chunks of runs: the unit of work of one thread or process, and the table rows that result."""

from __future__ import annotations

import math
import pickle
import time as clock
from collections import Counter
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.effort import too_many_steps
from ..common.errors import InputError, SolverError
from ..common.turns import lock_held, lock_released
from ..models.protocol import (
    LANES,
    OVERTURNED,
    SCALAR,
    UNDECIDED,
    FloatArray,
    Kind,
    Lanes,
    NoRestError,
    Run,
    RunPlan,
    code_of,
    output_times,
    table_entry,
)
from .table import Columns, Table

SLOW = "too many steps"  # why a run is not made in lanes
NO_REST = "no rest"  # the same
STOPPED_LANES = "could not go on in lanes"  # the same


@dataclass(frozen=True)
class Chunk:
    """A chunk of consecutive runs of columns or structures, with the results to keep."""

    first: int  # number of the first run
    runs: Sequence[Run]
    keep: tuple[str, ...]  # names of the results
    settle: float  # s: longest time for which a model is followed after the duration
    whole: tuple[int, ...] = ()  # indices in `runs` of those whose response is kept
    weight: float = 0.0  # estimated cost of the runs (Kind.work)
    checked: bool = False  # True if the models need no check
    refuses: bool = True  # whether a column without a rest is an error; else it falls at once, as a structure does

    @property
    def kind(self) -> Kind:
        """The kind of the first model, whose results all runs share."""
        return self.runs[0].model.kind


@dataclass
class Tally:
    """The record of how runs were made."""

    paths: Counter[str] = field(default_factory=Counter)  # runs by path, in lanes or scalar
    why_scalar: Counter[str] = field(default_factory=Counter)  # scalar runs by reason
    failures: dict[int, str] = field(default_factory=dict)  # messages by the number of the run
    no_response: dict[int, str] = field(default_factory=dict)  # messages by the number of a run without its response
    warnings: dict[int, str] = field(default_factory=dict)  # one of each run whose model has any
    seconds: float = 0.0  # of wall-clock time


Made = tuple[Table, Tally]


class Stopped(Exception):  # noqa: N818  nothing went wrong
    """The signal that the result of a chunk is no longer needed."""


def make_runs(chunk: Chunk, flag: FloatArray | None = None) -> Made:
    """Make the runs of a chunk in one thread; a flag (1,) that is set from outside stops them soon.

    Raises InputError as `_check` does, Stopped if the flag was set.
    """
    with lock_held():
        chunk.kind.load(chunk.runs[0].model, chunk.keep)
        begin = clock.perf_counter()
        table, tally = _made(chunk, np.zeros(1) if flag is None else flag)
        tally.seconds = clock.perf_counter() - begin
        return table, tally


def packed(chunk: Chunk) -> bytes:
    """Serialize a chunk for an executor; Dask alone would send each of its arrays separately, at ten times the cost."""
    return pickle.dumps(chunk, pickle.HIGHEST_PROTOCOL)


def make_packed(chunk: bytes) -> Made:
    """Make the runs of a chunk serialized by `packed`, as `make_runs`."""
    made: Chunk = pickle.loads(chunk)
    return make_runs(made)


def _made(chunk: Chunk, flag: FloatArray) -> Made:
    tally = Tally()
    no_rest = {} if chunk.checked else _check(chunk, tally)
    columns = _empty_columns(chunk)
    alone = _in_lanes(chunk, columns, no_rest, flag)

    def look(*_: object) -> None:
        if flag[0]:
            raise Stopped

    # the other runs, one after the other
    for place, why in sorted(alone.items()):
        look()
        with lock_released():
            failure = _alone(chunk, columns, place, no_rest, look)
        if failure:
            tally.failures[chunk.first + place] = failure
        tally.why_scalar[why] += 1
    tally.paths.update({SCALAR: len(alone), LANES: len(chunk.runs) - len(alone)})
    # responses to keep
    wanted = [place for place in chunk.whole if chunk.first + place not in tally.failures]
    responses: dict[int, Any] = {}
    for place in wanted:
        try:
            with lock_released():
                responses[chunk.first + place] = _response(chunk, place, look)
        except SolverError as error:  # lanes made the run, a run alone ends
            tally.no_response[chunk.first + place] = str(error)
    kept = chunk.kind.kept
    return Table(columns, None, responses, chunk.first, {name: kept[name].of for name in columns}, chunk.kind), tally


def _check(chunk: Chunk, tally: Tally) -> dict[int, str]:
    """Check the models, note their warnings, and return the messages of those without a rest, by the id of the model.

    Raises InputError for a column without a rest if the chunk refuses it, or a model whose results are kept but not
    computed.
    """
    lines: dict[int, str] = {}  # a warning, or "", by the id of the model
    no_rest: dict[int, str] = {}
    for place, run in enumerate(chunk.runs):
        key, kind = id(run.model), run.model.kind
        if key not in lines:
            try:
                kind.check(run.model, from_rest=True)
                kind.check_kept(run.model, chunk.keep)
            except InputError as error:
                if not isinstance(error, NoRestError) or (chunk.refuses and not kind.across):
                    raise InputError(f"columns[{chunk.first + place}]: {error}") from None
                no_rest[key] = str(error)
            lines[key] = next(reversed(kind.warnings(run.model)), "")
        if lines[key]:
            tally.warnings[chunk.first + place] = lines[key]
    return no_rest


def _empty_columns(chunk: Chunk) -> Columns:
    """Return columns for all the runs of a chunk, filled with the values of a failed run."""
    count, sizes = len(chunk.runs), [run.model.sizes for run in {id(run.model): run for run in chunk.runs}.values()]
    columns: Columns = {}
    for name in chunk.keep:
        kept = chunk.kind.kept[name]
        shape = (count, max(size[kept.of] for size in sizes)) if kept.kind is None else (count,)
        columns[name] = np.zeros(shape, dtype=kept.kind or np.float64)
        if columns[name].dtype.kind == "f":
            columns[name][:] = math.nan
    for name, word in (("verdict", UNDECIDED), ("path", SCALAR)):
        if name in columns:
            columns[name][:] = code_of(name, word)
    return columns


def _in_lanes(chunk: Chunk, columns: Columns, no_rest: Mapping[int, str], flag: FloatArray) -> dict[int, str]:
    """Make the runs that lanes can make into the columns; return the reasons why others cannot, by index.

    The path of a run depends on the run alone, not on the other runs of the chunk. `no_rest` is that of `_check`.
    """
    alone: dict[int, str] = {}
    groups: dict[tuple[Kind, Hashable, Hashable], list[int]] = {}
    known: dict[int, Lanes] = {}  # of the same model
    # group the runs that share compiled code and lanes
    for place, (model, motion, duration) in enumerate(chunk.runs):
        if id(model) in no_rest:
            alone[place] = NO_REST
            continue
        kind: Kind = model.kind
        if id(model) not in known:
            known[id(model)] = kind.lanes(model, chunk.keep)
        lanes = known[id(model)]
        why_not, share = kind.under(model, motion)
        shaken = motion.amplitude or motion.amplitude_y
        omega = 2.0 * math.pi * motion.frequency if shaken else 0.0
        why_not = SLOW if too_many_steps(duration, lanes.first_step, omega) else lanes.why_not or why_not
        if why_not:
            alone[place] = why_not
        else:
            groups.setdefault((kind, lanes.share, share), []).append(place)
    # run the groups
    for (kind, *_), places in groups.items():
        runs = [chunk.runs[place] for place in places]
        made, finished = kind.follow(runs, chunk.keep, chunk.settle, flag)
        if flag[0]:
            raise Stopped
        ended = np.flatnonzero(finished).tolist()  # the others are repeated alone, and keep no number of lanes
        for name in columns.keys() & made.keys():
            _write(columns[name], [places[k] for k in ended], made[name][ended])
        alone |= {place: STOPPED_LANES for place, whole in zip(places, finished, strict=True) if not whole}
    return alone


def _response(chunk: Chunk, place: int, look: Callable[..., object]) -> Any:
    """Return the response of a run, with the rows of `simulate`."""
    model, motion, duration = chunk.runs[place]
    plan = RunPlan(motion, duration, output_times(motion, duration), None, chunk.settle, look)
    return model.kind.single_run(model, plan)[0]


def _alone(chunk: Chunk, columns: Columns, place: int, no_rest: Mapping[int, str], look: Callable[..., object]) -> str:
    """Make one run alone, write it into the columns, and return the error message or an empty string."""
    run = chunk.runs[place]
    failure = ""
    try:
        if id(run.model) in no_rest:
            raise NoRestError(no_rest[id(run.model)])
        values = run.model.kind.alone(run, chunk.keep, chunk.settle, look)
    except NoRestError as error:  # it falls at once
        failure = str(error)
        values = {"verdict": OVERTURNED, "overturn_time": run.motion.start, "settled_for": 0.0, "path": SCALAR}
    except SolverError as error:
        return str(error)
    for name in columns.keys() & values.keys():
        _write(columns[name], place, table_entry(name, values[name]))
    return failure


def _write(column: NDArray[Any], places: int | list[int], values: Any) -> None:
    """Write the values of one or several runs; a 2D column is as wide as its largest model, NaN beyond the others."""
    if column.ndim == 2:
        column[places, : np.atleast_1d(values).shape[-1]] = values
    else:
        column[places] = values
