"""The command `study` with its actions run, show and plot."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import active_children, get_context
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np

from ..common.digits import percent
from ..common.errors import InputError, reading
from ..common.executors import end_with_parent
from ..common.files import check_outputs
from ..runs.pace import CHUNK_SECONDS, FILLED, LONGER
from ..studies.contents import FAILED
from ..studies.definition import Study
from ..studies.execution import run_study
from ..studies.journal import SUFFIX
from ..studies.results import UNITS, Results, results_of
from ..studies.statistics import failures_of, fit_fragility, ida_curves, influences, measure_in, undecided_text
from .command_files import add_force, check_picture, write_outputs
from .progress import PlainLine, RunsLine
from .reports import text_columns

# s, after Ctrl-C: the pool would wait for ever for a worker that ended within a result
LEAVES_AFTER = 2.0
MOST_PAIRS = 5  # pairs of neighbours that a summary lists


def add_command(commands: Any) -> None:
    """Add the command `study`."""
    parser = commands.add_parser("study", help="many runs by a plan: IDA, fragility, spectra, Monte Carlo")
    actions = parser.add_subparsers(metavar="ACTION", required=True)
    run = actions.add_parser("run", help="make the runs that are not finished yet")
    run.set_defaults(command=_run)
    add_study_options(run)
    where = run.add_mutually_exclusive_group()
    where.add_argument("--threads", type=int, metavar="N", help="threads of this process (default: one a core)")
    where.add_argument("--processes", type=int, metavar="N", help="processes of this machine")
    where.add_argument("--dask", metavar="ADDRESS", help="scheduler, tcp://HOST:PORT; or local, to try")
    run.add_argument("--samples", type=int, metavar="N", help="of the random parameters, in place of the file's")
    words = f"s of work at once ({CHUNK_SECONDS:g}), of fewer than {FILLED} runs up to {LONGER:g} times as long"
    run.add_argument("--chunk", type=float, default=CHUNK_SECONDS, metavar="S", help=words)
    # `show` and `plot`
    show = actions.add_parser("show", help="print what came out, also while it runs")
    show.set_defaults(command=_show)
    add_study_options(show)
    show.add_argument("--rows", type=int, default=10, metavar="N", help="runs to print (default: 10)")
    plot = actions.add_parser("plot", help="draw what came out")
    plot.set_defaults(command=_plot)
    add_study_options(plot)
    plot.add_argument("-o", "--output", type=Path, metavar="FILE.png", help="default: NAME.png beside the results")
    add_force(plot)


def add_study_options(parser: argparse.ArgumentParser, help: str = f"the study, or its results, NAME{SUFFIX}") -> None:
    """Add a study, and the options that say where its results are, for `results_from`."""
    parser.add_argument("study", type=Path, metavar="STUDY.toml", help=help)
    parser.add_argument(
        "--quick", action="store_true", help="some 200 runs of it, to try: a study NAME-quick of its own"
    )
    parser.add_argument(
        "--output-folder", type=Path, default=Path(), metavar="FOLDER", help="of the results (default: the current one)"
    )


def _run(options: argparse.Namespace) -> None:
    study = _study(options)
    if options.samples is not None:
        study = study.with_runs(options.samples)
    for key in ("threads", "processes"):
        value = getattr(options, key)
        if value is not None and value < 1:
            raise InputError(f"--{key} {value}: must be 1 or more")
    if not options.chunk > 0.0:
        raise InputError(f"--chunk {options.chunk}: must be a positive time in s")
    folder: Path = options.output_folder
    with reading(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with _executor(options) as executor, RunsLine() if sys.stderr.isatty() else PlainLine() as line:
        try:
            results = run_study(
                study, folder, executor=executor, threads=options.threads, callback=line, chunk_seconds=options.chunk
            )
        except KeyboardInterrupt:
            path = folder / f"{study.name}{SUFFIX}"
            raise KeyboardInterrupt(f"finished runs are kept in {path}, the same command makes the others") from None
    print(summary(results))
    for suffix in (SUFFIX, ".csv", *([".nc"] if Results.can_write_netcdf() else [])):
        print(folder / f"{study.name}{suffix}")


def _show(options: argparse.Namespace) -> None:
    results = results_from(options)
    print(summary(results))
    count = min(options.rows, len(results))
    if count < len(results):
        print(f"the first {count} of {len(results)} runs:")
    names = [name for name in results if name not in ("column", "motion", "failure") and results[name].ndim == 1]
    names.append("largest")
    heads = [f"{name} ({_unit(name)[0]})" if _unit(name)[0] else name for name in names]
    rows = [heads] + [[_cell(results, name, k) for name in names] for k in range(count)]
    print(*text_columns(rows, range(len(names))), sep="\n")


def _cell(results: Results, name: str, row: int) -> str:
    value = results.largest[row] if name == "largest" else results[name][row]
    return f"{_unit(name)[1] * value:.6g}" if isinstance(value, float) else str(value)


def _unit(name: str) -> tuple[str, float]:
    """Return the unit in which a column is shown, and the factor to it: lengths in mm, as in the curves."""
    unit = "m" if name == "largest" else UNITS.get(name, "")
    return ("mm", 1e3) if unit == "m" else (unit, 1.0)


def _plot(options: argparse.Namespace) -> None:
    results = results_from(options)
    folder = options.study.parent if options.study.suffix == SUFFIX else options.output_folder
    path = options.output or folder / f"{results.study['name']}.png"  # a default path may be overwritten
    check_outputs((options.output,), (options.study,), options.force)
    check_picture(path)
    from ..studies.pictures import draw

    write_outputs([(path, partial(draw, results))])


def _study(options: argparse.Namespace) -> Study:
    study = Study.from_toml(options.study)
    return study.quick() if options.quick else study


def results_from(options: argparse.Namespace) -> Results:
    """Return the results of the study on the command line. Raises InputError."""
    if options.study.suffix == SUFFIX:
        return results_of(options.study)
    study = _study(options)
    return results_of(options.output_folder / f"{study.name}{SUFFIX}", study)


@contextmanager
def _executor(options: argparse.Namespace) -> Iterator[Any]:
    if options.dask is not None:
        from ..studies.cluster import Cluster

        with Cluster(options.dask) as cluster:
            yield cluster
    elif options.processes is not None:
        # spawned: a forked process would inherit the threads of the compiled code in an unknown state
        pool, patience = ProcessPoolExecutor(options.processes, get_context("spawn"), end_with_parent), None
        try:
            yield pool
        except KeyboardInterrupt:
            patience = LEAVES_AFTER
            for worker in active_children():  # in any state
                worker.terminate()
            raise
        finally:
            shutdown = Thread(target=pool.shutdown, kwargs={"cancel_futures": True}, daemon=True)
            shutdown.start()
            shutdown.join(patience)
    else:
        yield None


def summary(results: Results) -> str:
    """Return the results of the runs as lines of text."""
    study = results.study
    fell, failed = int(np.sum(results.overturned)), int(np.sum(results["verdict"] == FAILED))
    undecided = int(np.sum(results["verdict"] == "undecided"))
    lines = [
        f"{study['name']}: {study['kind']}, {len(results)} of {results.head['runs']} runs, seed {study['seed']}",
        f"{fell} overturned, {undecided} undecided, {failed} that could not be made",
    ]
    if undecided:
        lines.append(f"{undecided_text(undecided)}; shares and curves take them as standing")
    if fell and "overturn_time" in results and np.isfinite(results["overturn_time"]).any():
        k = int(np.nanargmin(results["overturn_time"]))
        lines.append(f"first fall: at {results['overturn_time'][k]:.4g} s in run {results['run'][k]}")
    if "least_gap" in results:
        pairs = np.sum(results["least_gap"].reshape(len(results), -1) < 0.0, axis=0)
        hits = [f"pair {k + 1} in {pairs[k]} runs" for k in np.argsort(-pairs, kind="stable")[:MOST_PAIRS] if pairs[k]]
        lines.append(f"neighbours that hit: {', '.join(hits) or 'none'}")
    if failed:
        k = int(np.flatnonzero(results["verdict"] == FAILED)[0])
        lines.append(f"run {results['run'][k]}: {results['failure'][k]}")
    if failed == len(results):
        return "\n".join(lines)
    # IDA curves
    if study["kind"] == "ida":
        curves = ida_curves(results)
        measure = measure_in(results, curves.name)
        unit = f" ({measure.unit})" if measure else ""
        lines.append(f"{curves.name}{unit}: largest displacement (mm) at 16 %, 50 %, 84 %; overturned, undecided")
        for level, points, fell_there, unknown in zip(
            curves.levels, curves.percentiles.T, curves.overturned, curves.undecided, strict=True
        ):
            shown = "  ".join(f"{1e3 * point:10.4g}" for point in points)
            lines.append(f"{level:10.4g}  {shown}  {percent(fell_there):>7s}  {percent(unknown):>7s}")
    # fragility curves
    if study["kind"] == "fragility":
        for failure in failures_of(results):
            try:
                found = fit_fragility(results, limit=failure.limit, chosen=failure.chosen)
            except InputError as error:
                lines.append(f"{failure.name}: {error}")
                continue
            how = failure.name if failure.limit == "hit" else found.how
            unit = f" {found.measure.unit}" if found.measure else ""
            lines.append(
                f"{how}: median {found.name} {found.median:.4g}{unit} ({found.median_bounds[0]:.4g} to "
                f"{found.median_bounds[1]:.4g}), deviation of the logarithm {found.deviation:.3g} "
                f"({found.deviation_bounds[0]:.3g} to {found.deviation_bounds[1]:.3g}), at 95 % confidence; "
                f"{found.failed} of {found.runs} runs failed, {found.undecided} undecided"
            )
    # influence of the random parameters
    if study["random"] and len(results) > 20:
        for item in influences(results)[:10]:
            lines.append(f"{item.name}: rank correlation {item.rank:+.2f} with the largest displacement")
    return "\n".join(lines)
