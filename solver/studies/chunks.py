"""The work of a worker: runs of a study by their numbers, and the rows of their results. It keeps nothing."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import Any, NamedTuple

from ..column.rest import check_stable
from ..common.errors import InputError
from ..common.turns import my_turn
from ..runs.chunk import Chunk, load_kernels, make_runs
from ..runs.lane_policy import kind_of
from ..runs.single_run import SETTLE
from .definition import Planned, Study


class Made(NamedTuple):
    """Rows [number, values of what is varied, measures, outputs, why it failed], and how long they took, s."""

    rows: list[list[Any]]
    seconds: float


def make(study: Study, numbers: Sequence[int]) -> Made:
    """Make the runs of these numbers, in one thread. The result of a run does not depend on the others."""
    with my_turn():
        load_kernels(kind_of(study.columns[0]))
        begin = clock.perf_counter()
        return Made(_rows(study, numbers), clock.perf_counter() - begin)


def _rows(study: Study, numbers: Sequence[int]) -> list[list[Any]]:
    ready: list[tuple[int, Planned]] = []
    rows: list[list[Any]] = []
    for number in numbers:
        try:
            planned = study.run(number)
            check_stable(planned.run.column)
        except InputError as error:  # of values that were drawn: the other runs go on
            given = list(study.values(number).values())
            rows.append([number, given, [None] * len(study.measured), None, str(error)])
            continue
        ready.append((number, planned))
    if ready:
        table, tally = make_runs(Chunk(0, [planned.run for _, planned in ready], study.keep, SETTLE, checked=True))
        outputs = {name: table[name].tolist() for name in study.keep}
        for place, (number, (run, values, measures)) in enumerate(ready):
            found = {name: _own(column[place], run.column.n) for name, column in outputs.items()}
            failure = tally.failures.get(place, "")
            rows.append([number, list(values.values()), list(measures.values()), found, failure])
    rows.sort(key=lambda row: row[0])
    return rows


def _own(value: Any, blocks: int) -> Any:
    """The results of a run, without entries for blocks that its column does not have."""
    return value[:blocks] if isinstance(value, list) else value
