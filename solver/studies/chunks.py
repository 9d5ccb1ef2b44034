"""The work of a worker: the runs of a study with given numbers, and the rows of their results. It keeps no state."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import Any, NamedTuple

from ..common.errors import InputError
from ..common.turns import lock_held
from ..models.protocol import OVERTURNED, SETTLE, NoRestError
from ..runs.chunk import Chunk, make_runs
from .definition import Planned, Study


class Made(NamedTuple):
    """The rows [number, varied values, measures, outputs, failure] of runs, and the time that they took (s)."""

    rows: list[list[Any]]
    seconds: float


def make(study: Study, numbers: Sequence[int]) -> Made:
    """Simulate the runs of these numbers, from 0, in one thread; the result of a run does not depend on the others."""
    with lock_held():
        study.columns[0].kind.load(study.columns[0], study.keep)
        begin = clock.perf_counter()
        return Made(_rows(study, numbers), clock.perf_counter() - begin)


def _rows(study: Study, numbers: Sequence[int]) -> list[list[Any]]:
    # build the models and motions; a run with invalid values becomes a failed row
    ready: list[tuple[int, Planned]] = []
    rows: list[list[Any]] = []
    for number in numbers:
        try:
            planned = study.run(number)
            kind = planned.run.model.kind
            try:
                kind.check(planned.run.model, from_rest=True)
            except NoRestError:
                if not kind.across:  # a structure falls as its run begins
                    raise
        except InputError as error:  # caused by drawn values: the other runs go on
            given = list(study.values(number).values())
            rows.append([number, given, [None] * len(study.measured), None, str(error)])
            continue
        ready.append((number, planned))
    if ready:
        # simulate the others together
        runs = [planned.run for _, planned in ready]
        table, tally = make_runs(Chunk(0, runs, study.keep, SETTLE, checked=True))
        outputs = {name: table.by_key(name).tolist() for name in study.keep}
        kept = study.columns[0].kind.kept
        for place, (number, (run, values, measures)) in enumerate(ready):
            sizes = run.model.sizes
            found = {
                # the entries of a list for parts that the model has
                name: column[place] if kept[name].kind is not None else column[place][: sizes[kept[name].of]]
                for name, column in outputs.items()
            }
            failure = tally.failures.get(place, "")
            ended = not failure or found["verdict"] == OVERTURNED  # a structure without a rest has fallen
            rows.append([number, list(values.values()), list(measures.values()), found if ended else None, failure])
    rows.sort(key=lambda row: row[0])
    return rows
