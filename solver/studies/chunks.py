"""The work of a worker: runs of a study by their numbers, and the rows of their results. It keeps nothing."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..column.column import Column
from ..column.rest import check_stable
from ..common.errors import InputError
from ..common.turns import my_turn
from ..runs.batch_in_space import RunInSpace, load_lanes
from ..runs.chunk import Chunk, Run, load_kernels, make_runs
from ..runs.lane_policy import kind_of
from ..runs.many_in_space import guessed_cost_in_space, made_runs, worth_lanes
from ..runs.single_run import SETTLE
from .definition import Planned, Study

TRIED = 10  # runs, of which one may have values that cannot be


class Made(NamedTuple):
    """Rows [number, values of what is varied, measures, outputs, why it failed], and how long they took, s."""

    rows: list[list[Any]]
    seconds: float


def make(study: Study, numbers: Sequence[int]) -> Made:
    """Make the runs of these numbers, in one thread. The result of a run does not depend on the others."""
    with my_turn():
        if isinstance(study.columns[0], Column):
            load_kernels(kind_of(study.columns[0]))
        elif _worth_lanes(study):
            load_lanes()
        begin = clock.perf_counter()
        return Made(_rows(study, numbers), clock.perf_counter() - begin)


def _rows(study: Study, numbers: Sequence[int]) -> list[list[Any]]:
    ready: list[tuple[int, Planned]] = []
    rows: list[list[Any]] = []
    for number in numbers:
        try:
            planned = study.run(number)
            if isinstance(planned.run, Run):
                check_stable(planned.run.column)
        except InputError as error:  # of values that were drawn: the other runs go on
            given = list(study.values(number).values())
            rows.append([number, given, [None] * len(study.measured), None, str(error)])
            continue
        ready.append((number, planned))
    if study.in_space:
        rows += _rows_in_space(study, ready)
    elif ready:
        runs = [planned.run for _, planned in ready if isinstance(planned.run, Run)]
        table, tally = make_runs(Chunk(0, runs, study.keep, SETTLE, checked=True))
        outputs = {name: table[name].tolist() for name in study.keep}
        for place, (number, (_, values, measures)) in enumerate(ready):
            found = {name: _own(column[place], runs[place].column.n) for name, column in outputs.items()}
            failure = tally.failures.get(place, "")
            rows.append([number, list(values.values()), list(measures.values()), found, failure])
    rows.sort(key=lambda row: row[0])
    return rows


def _worth_lanes(study: Study) -> bool:
    """Whether structures are made eight at once; the same for all chunks."""
    for number in range(min(study.runs, TRIED)):
        try:
            run = study.run(number).run
        except InputError:
            continue
        if isinstance(run, RunInSpace):
            return worth_lanes(study.runs * guessed_cost_in_space(run), study.keep)
    return False


def _rows_in_space(study: Study, ready: Sequence[tuple[int, Planned]]) -> list[list[Any]]:
    """The rows of runs of structures."""
    runs = [planned.run for _, planned in ready if isinstance(planned.run, RunInSpace)]
    made = made_runs(runs, study.keep, SETTLE, _worth_lanes(study))
    rows: list[list[Any]] = []
    for (number, (_, values, measures)), found in zip(ready, made, strict=True):
        given, measured = list(values.values()), list(measures.values())
        if isinstance(found, InputError):
            rows.append([number, given, [None] * len(study.measured), None, str(found)])
        elif isinstance(found, str):
            rows.append([number, given, measured, None, found])
        else:
            kept = {name: np.asarray(found[name]).tolist() for name in study.keep}
            rows.append([number, given, measured, kept, ""])
    return rows


def _own(value: Any, blocks: int) -> Any:
    """The results of a run, without entries for blocks that its column does not have."""
    return value[:blocks] if isinstance(value, list) else value
