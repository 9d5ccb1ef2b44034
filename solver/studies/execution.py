"""Execution of a study, chunk by chunk, on an executor; each chunk is on disk before more are requested."""

from __future__ import annotations

import itertools
import math
import os
import time as clock
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..common.errors import InputError, SolverError, check_type, reading
from ..common.executors import TRIES, cores, error_text, sent_out, workers_of
from ..common.plausible import warn_of_first
from ..ground.motion import check_loads, check_strength
from ..runs.many import estimated_cost
from ..runs.pace import CHUNK_SECONDS, Pace
from . import chunks
from .definition import Study, versions
from .journal import SUFFIX, Journal
from .results import Results
from .subjects import sizes_of, subject_from

UNKNOWN_COST = 0.02  # s, assumed duration of a run if the first one cannot be built
SAVE_EVERY = 60.0  # s, least time between two updates of the tables
SAVE_PART = 0.05  # largest part of the time that is spent on updates

Callback = Callable[[int, int], object]


class StudyError(SolverError):
    """The error that the executor is gone, or that work fails on it; finished runs are kept."""


def run_study(
    study: Study,
    folder: str | os.PathLike[str] | None = None,
    *,
    executor: Any = None,
    threads: int | None = None,
    callback: Callback | None = None,
    chunk_seconds: float = CHUNK_SECONDS,
) -> Results:
    """Run the unfinished runs of a study, and return the results of all.

    The numbers are the same, bit for bit, for any executor, workers and order. An interruption of the process at any
    moment loses no finished run. Warns (InputWarning) of the first column that is probably not as meant, before
    anything is varied.

    Parameters
    ----------
    study : Study
        The study.
    folder : str or path, optional
        Folder of NAME.journal, to which each run is added as it ends, and of NAME.csv and NAME.nc, which are written
        from it (NAME.nc with the extra `studies`). None: nothing is written.
    executor : executor, optional
        See executors.py. None: threads of this process.
    threads : int, optional
        Number of these threads, by default that of the cores.
    callback : callable, optional
        Called as callback(finished runs, all runs).
    chunk_seconds : float
        Intended duration of a chunk on a worker (s); one of fewer than 64 runs takes up to 5 times that.

    Returns
    -------
    Results
        All finished runs.

    Raises
    ------
    InputError
        If a value is wrong, or the journal cannot be used.
    StudyError
        If the executor fails; call the function again to continue.
    """
    check_type("study", study, Study)
    check_type("callback", callback, Callable, None)
    # warn of unlikely columns, records and loads
    warn_of_first(subject.kind.warnings(subject) for subject in study.columns)
    if study.measure is not None:
        study.measure.warn_of_largest("intensity", study.usual_intensity)
    for number, shaking in enumerate(study.motions):
        if shaking.record is not None and study.measure is None and "scale" not in shaking.numbers:
            check_strength(shaking.record)
        if shaking.loads:
            with suppress(InputError):  # of a run that fails
                _, motion, duration = study.run(number * math.prod(study.shape[2:])).run
                check_loads(motion, duration)
    # without a folder the results stay in memory
    if folder is None:
        made = _made(study, set(), executor, threads, callback, chunk_seconds)
        return Results(head_of(study), itertools.chain.from_iterable(made))
    with reading("folder: must be left out, a journal cannot be read without its models"):
        subject_from(study.columns[0].to_dict())  # all are of one kind
    # add each chunk to the journal; update the tables from time to time
    with Journal(Path(folder) / f"{study.name}{SUFFIX}", head_of(study), (".csv", ".nc")) as journal:
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
    """Return the first line of the journal of a study."""
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
    """Write the tables next to a journal, and return its results."""
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
    """Yield the rows of the runs that are not in `finished`, chunk by chunk; `finished` is not changed.

    The arguments are those of `run_study`.
    """
    # runs that are left
    left = [number for number in range(study.runs) if number not in finished]
    left.sort(key=lambda number: number % study.samples)  # sample by sample: an interrupted study covers the grid
    done = study.runs - len(left)
    if callback is not None:
        callback(done, study.runs)
    if not left:
        return
    # simulate, in threads of this process without an executor
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
    """Yield chunks of run numbers, each as large as `pace` decides."""
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
    """Return the estimated duration of a run (s), from the run of this number."""
    try:
        return estimated_cost(study.run(number).run, study.keep)
    except InputError:
        return UNKNOWN_COST


def _dispatched(
    study: Study, left: Sequence[int], executor: Any, workers: int, chunk_seconds: float
) -> Iterator[list[list[Any]]]:
    """Yield the rows of each chunk as it comes back from an executor."""
    # a cluster keeps the study for all chunks; other executors get it with each
    sent = executor.carry(study) if hasattr(executor, "carry") else study
    pace = Pace(len(left), workers, _guess(study, left[0]), chunk_seconds)

    def check_executor() -> None:
        """Raise StudyError if the executor, such as that of cluster.py, is lost."""
        lost = executor.lost() if hasattr(executor, "lost") else ""
        if lost:
            raise StudyError(f"{lost}; finished runs are kept, run the study again to go on")

    def failed(numbers: list[int], tries: int, error: BaseException) -> None:
        if isinstance(error, InputError):
            raise error
        check_executor()
        if tries >= TRIES:
            raise StudyError(
                f"runs {numbers[0]} to {numbers[-1]}: {error_text(error)}; finished runs are kept"
            ) from error

    for numbers, made in sent_out(
        _portions(left, pace),
        lambda numbers: executor.submit(chunks.make, sent, numbers),
        workers,
        failed=failed,
        error=lambda message: StudyError(f"{message}; finished runs are kept"),
        idle=check_executor,
    ):
        pace.update_cost(len(numbers), len(numbers), made.seconds)
        yield made.rows
