"""The work of a worker: runs of a study by their numbers, and the rows of their results. It keeps nothing."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..column.column import Column
from ..column.rest import check_stable
from ..common.errors import InputError
from ..common.turns import my_turn, others_turn
from ..runs.chunk import Chunk, Run, load_kernels, make_runs
from ..runs.lane_policy import kind_of
from ..runs.many_in_space import RunInSpace, kept_value, made_alone
from ..runs.single_run import SETTLE
from .definition import Planned, Study


class Made(NamedTuple):
    """Rows [number, values of what is varied, measures, outputs, why it failed], and how long they took, s."""

    rows: list[list[Any]]
    seconds: float


def make(study: Study, numbers: Sequence[int]) -> Made:
    """Make the runs of these numbers, in one thread. The result of a run does not depend on the others."""
    with my_turn():
        if isinstance(study.columns[0], Column):
            load_kernels(kind_of(study.columns[0]))
        begin = clock.perf_counter()
        return Made(_rows(study, numbers), clock.perf_counter() - begin)


def _rows(study: Study, numbers: Sequence[int]) -> list[list[Any]]:
    ready: list[tuple[int, Planned]] = []
    rows: list[list[Any]] = []
    for number in numbers:
        try:
            planned = study.run(number)
            if isinstance(planned.run, RunInSpace):
                with others_turn():
                    rows.append(_row_in_space(study, number, planned, planned.run))
                continue
            check_stable(planned.run.column)
        except InputError as error:  # of values that were drawn: the other runs go on
            given = list(study.values(number).values())
            rows.append([number, given, [None] * len(study.measured), None, str(error)])
            continue
        ready.append((number, planned))
    if ready:
        runs = [planned.run for _, planned in ready if isinstance(planned.run, Run)]
        table, tally = make_runs(Chunk(0, runs, study.keep, SETTLE, checked=True))
        outputs = {name: table[name].tolist() for name in study.keep}
        for place, (number, (_, values, measures)) in enumerate(ready):
            found = {name: _own(column[place], runs[place].column.n) for name, column in outputs.items()}
            failure = tally.failures.get(place, "")
            rows.append([number, list(values.values()), list(measures.values()), found, failure])
    rows.sort(key=lambda row: row[0])
    return rows


def _row_in_space(study: Study, number: int, planned: Planned, run: RunInSpace) -> list[Any]:
    """The row of a run of a structure. Raises InputError if it has no stable rest."""
    made = made_alone(run, study.keep, SETTLE)
    given, measures = list(planned.values.values()), list(planned.measures.values())
    if isinstance(made, str):
        return [number, given, measures, None, made]
    return [number, given, measures, {name: np.asarray(kept_value(name, made)).tolist() for name in study.keep}, ""]


def _own(value: Any, blocks: int) -> Any:
    """The results of a run, without entries for blocks that its column does not have."""
    return value[:blocks] if isinstance(value, list) else value
