"""Runs of a study, chunk by chunk, wherever an executor takes them; each is on disk before more are asked for."""

from __future__ import annotations

import itertools
import os
import time as clock
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from ..common.errors import InputError, SolverError, reading
from ..common.executors import TRIES, cores, said, sent_out, workers_of
from ..common.plausible import warn_of_first
from ..ground.plausible import check_strength
from ..runs.many import guessed_cost
from ..runs.pace import CHUNK_SECONDS, Pace
from . import chunks
from .definition import Study, versions
from .journal import SUFFIX, Journal
from .results import Results
from .subjects import sizes_of, subject_from

UNKNOWN_COST = 0.02  # s of a run, where the first one cannot be made
SAVE_EVERY = 60.0  # s between two NetCDF files
SAVE_PART = 0.05  # of the time, at most, for writing these

Callback = Callable[[int, int], object]


class StudyError(SolverError):
    """The executor is gone, or work fails on it; what was finished is kept."""


def run_study(
    study: Study,
    folder: str | os.PathLike[str] | None = None,
    *,
    executor: Any = None,
    threads: int | None = None,
    callback: Callback | None = None,
    chunk_seconds: float = CHUNK_SECONDS,
) -> Results:
    """Make those runs of a study that are not finished yet, and return all.

    folder: NAME.journal there takes each run as it ends, NAME.csv and NAME.nc are written from it, the latter where
    the extra `studies` is installed; None: nothing is written. executor: see executors.py; None: threads of this
    process, `threads` of them or as many as it has cores. callback: called as callback(runs finished, runs in all).
    chunk_seconds: s, how long a worker is to be busy with what it is sent.

    The numbers are the same, bit for bit, whatever the executor, its workers and the order. Warns (InputWarning) of
    the first column in which something is probably not meant, as given before anything is varied. Raises InputError,
    StudyError where the executor fails: call it again to go on. An interruption of the process at any moment loses no
    finished run.
    """
    warn_of_first(subject.kind.warnings(subject) for subject in study.columns)
    for shaking in study.motions:
        if shaking.record is not None and study.measure is None and "scale" not in shaking.numbers:
            check_strength(shaking.record)
    if folder is None:
        made = _made(study, set(), executor, threads, callback, chunk_seconds)
        return Results(head_of(study), itertools.chain.from_iterable(made))
    with reading("folder: must be left out, a journal cannot be read without its models"):
        subject_from(study.columns[0].to_dict())  # all are of one kind
    with Journal(Path(folder) / f"{study.name}{SUFFIX}", head_of(study)) as journal:
        saved, took = clock.monotonic(), 0.0
        for rows in _made(study, journal.finished, executor, threads, callback, chunk_seconds):
            journal.add(rows)
            begin = clock.monotonic()
            if begin - saved > max(SAVE_EVERY, took / SAVE_PART):
                _saved(journal.path)
                saved = clock.monotonic()
                took = saved - begin
        return _saved(journal.path)


def head_of(study: Study) -> dict[str, Any]:
    """The first line of a journal."""
    return {
        "study": study.to_dict(),
        "fingerprint": study.fingerprint,
        "versions": versions(),
        "runs": study.runs,
        "varied": list(study.varied),
        "measured": list(study.measured),
        "blocks": study.blocks,
        **({"sizes": sizes_of(study.columns)} if study.in_space else {}),
    }


def _saved(journal: Path) -> Results:
    """Write the tables beside a journal; returns what is in them."""
    results = Results.from_journal(journal)
    results.to_csv(journal.with_suffix(".csv"))
    if Results.can_write_netcdf():
        results.to_netcdf(journal.with_suffix(".nc"))
    return results


def _made(
    study: Study,
    finished: set[int],
    executor: Any,
    threads: int | None,
    callback: Callback | None,
    chunk_seconds: float,
) -> Iterator[list[list[Any]]]:
    """Rows of the runs that are not among `finished`, chunk by chunk as they end; `finished` is not changed."""
    left = [number for number in range(study.runs) if number not in finished]
    left.sort(key=lambda number: number % study.samples)  # sample by sample: one that is cut short has all of the grid
    done = study.runs - len(left)
    if callback is not None:
        callback(done, study.runs)
    if not left:
        return
    own = executor is None
    workers = (threads or cores()) if own else workers_of(executor)
    executor = ThreadPoolExecutor(workers, thread_name_prefix="runs") if own else executor
    try:
        for rows in _dispatched(study, left, executor, workers, chunk_seconds):
            done += len(rows)
            yield rows
            if callback is not None:
                callback(done, study.runs)
    finally:
        if own:
            executor.shutdown(wait=False, cancel_futures=True)


def _portions(left: Sequence[int], pace: Pace) -> Iterator[list[int]]:
    """Numbers of runs, as many at once as `pace` has enough of."""
    portion: list[int] = []
    for number in left:
        portion.append(number)
        if pace.enough(len(portion), len(portion)):
            pace.sent(len(portion))
            yield portion
            portion = []
    if portion:
        yield portion


def _guess(study: Study, number: int) -> float:
    """Estimated duration of a run, s, from the run of this number."""
    try:
        return guessed_cost(study.run(number).run, study.keep)
    except InputError:
        return UNKNOWN_COST


def _dispatched(
    study: Study, left: Sequence[int], executor: Any, workers: int, chunk_seconds: float
) -> Iterator[list[list[Any]]]:
    """Rows of one chunk after the other as they come back from an executor."""
    # what a cluster keeps for all chunks to come; others are sent the study with each
    sent = executor.carry(study) if hasattr(executor, "carry") else study
    pace = Pace(len(left), workers, _guess(study, left[0]), chunk_seconds)

    def check_executor() -> None:
        """Raise StudyError if the executor, one as of cluster.py, says that it is lost."""
        lost = executor.lost() if hasattr(executor, "lost") else ""
        if lost:
            raise StudyError(f"{lost}; finished runs are kept, run the study again to go on")

    def failed(numbers: list[int], tries: int, error: BaseException) -> None:
        if isinstance(error, InputError):
            raise error
        check_executor()
        if tries >= TRIES:
            raise StudyError(f"runs {numbers[0]} to {numbers[-1]}: {said(error)}; finished runs are kept") from error

    for numbers, made in sent_out(
        _portions(left, pace),
        lambda numbers: executor.submit(chunks.make, sent, numbers),
        workers,
        failed=failed,
        error=lambda message: StudyError(f"{message}; finished runs are kept"),
        idle=check_executor,
    ):
        pace.learn(len(numbers), len(numbers), made.seconds)
        yield made.rows
