"""The command line of the solver: its commands, and the error handling and exit codes of all commands."""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from .. import __version__
from ..common.digits import percent
from ..common.errors import InputError, InputWarning, SolverError, reading
from ..common.files import check_outputs, printable, with_point
from ..ground.motion import peaks_in_g
from ..kernels.machine.messages import MachineCodeError, announcing
from ..models.column.response import Response
from ..models.column.settings import FORMULATIONS, INTEGRATORS
from ..models.outputs import DIGITS, check_digits
from ..models.protocol import OUTPUT_STEP, SETTLE
from ..models.uncertainty import Spread
from . import structure
from .calibrate import add_calibrate_command
from .check import add_check_command
from .command_files import (
    PICTURES,
    add_force,
    add_space,
    add_spread,
    check_picture,
    check_suffix,
    loads_of,
    outputs_of_run,
    read_subject,
    refuse,
    spread_of,
    write_outputs,
)
from .export import add_export_command
from .gallery import add_gallery_command
from .motion_options import (
    FORMATS,
    add_file_options,
    add_motion_options,
    check_file_options,
    file_line,
    motion_of,
    read_with_options,
)
from .new import add_new_command
from .outcome import cracks, ensemble_lines, error_lines, verdict_line
from .progress import Line, simulated
from .reports import column_report, motion_report
from .risk import add_risk_command
from .schema import add_schema_command
from .static import add_static_commands
from .study import add_command as add_study

BASE_PEAKS = {"Fx": "kN", "Fz": "kN", "My": "kN m"}
PROGRAM = "python -m solver"
INTERRUPTED, CLOSED_PIPE = 130, 141  # exit codes, as of shells


class OneLineParser(argparse.ArgumentParser):
    """A parser that raises InputError for a wrong command line instead of printing the usage too."""

    def error(self, message: str) -> NoReturn:
        """Raise InputError."""
        option, invalid, text = message.partition(": invalid float value: ")
        hint = with_point(text.strip("'")) if invalid else ""
        raise InputError(f"{option}: {hint}" if hint else f"{message} (--help shows the options)")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line of `python -m solver`, and return the exit code."""
    parser = program_parser(PROGRAM, "Seismic response of a column of rigid blocks.")
    add_commands(parser.add_subparsers(metavar="COMMAND", required=True))
    return run_command(parser, arguments)


def program_parser(program: str, description: str) -> OneLineParser:
    """Return a parser that knows --version, for `run_command`."""
    parser = OneLineParser(prog=program, description=description)
    parser.add_argument("--version", action="version", version=f"multiblock-fmu {__version__}")
    return parser


def run_command(parser: argparse.ArgumentParser, arguments: Sequence[str] | None) -> int:
    """Parse the arguments, call `options.command(options)`, and return the exit code.

    The code is 2 for a user's mistake, and CLOSED_PIPE, silently, once the output is no longer read. An interrupt by
    the user ends the process at once, with 130.
    """
    if hasattr(sys.stdout, "reconfigure"):  # a file name may not be decodable as text
        sys.stdout.reconfigure(errors="backslashreplace")
    # the command prints warnings as it goes; errors end it with one line
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always", InputWarning)
            warnings.showwarning = _warnings_shower()
            options = _parsed(parser, arguments)
            with announcing(partial(print, flush=True)):
                options.command(options)
            sys.stdout.flush()
    except (InputError, SolverError, MachineCodeError, OSError) as error:
        if _is_closed_pipe(error):  # as after `| head`
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return CLOSED_PIPE
        print(f"{parser.prog}: {printable(str(error))}", file=sys.stderr)
        return 2
    except KeyboardInterrupt as stop:
        print(f"{parser.prog}: interrupted", *(f"; {words}" for words in stop.args), sep="", file=sys.stderr)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(INTERRUPTED)  # at once: finalization of Python takes half a second, and waits for threads
    return 0


def _is_closed_pipe(error: BaseException | None) -> bool:
    """Return True if an error comes from writing to a pipe that is no longer read."""
    while error is not None and not isinstance(error, BrokenPipeError):
        error = error.__cause__ or error.__context__
    return error is not None


def _warnings_shower() -> Callable[..., None]:
    """Return a function that prints each warning once, without its position in the code."""
    shown: set[str] = set()

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        if str(message) not in shown:
            shown.add(str(message))
            print(f"warning: {printable(str(message))}", file=sys.stderr)

    return show


def _parsed(parser: argparse.ArgumentParser, arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the arguments; a path after options still becomes MOTION, which argparse no longer expects there."""
    options, rest = parser.parse_known_args(arguments)
    names = getattr(options, "paths", ())
    values = [getattr(options, name) for name in names if getattr(options, name) is not None]
    late = [Path(text) for text in rest if not text.startswith("-")]
    if hasattr(options, "many") and len(late) == len(rest):  # name of an option that holds a list of paths
        setattr(options, options.many, [*getattr(options, options.many), *late])
        return options
    if len(late) < len(rest) or (len(values) + len(late) > len(names) and late):
        parser.error(f"unrecognized arguments: {' '.join(rest)}")
    if late:
        for name, value in zip(names, values + late, strict=True):
            setattr(options, name, value)
    return options


def add_commands(commands: argparse._SubParsersAction[OneLineParser]) -> None:
    """Add all commands but those of FMUs."""
    run = commands.add_parser("simulate", help="response of a column or structure to a base motion")
    run.set_defaults(command=_simulate, paths=("motion",))
    run.add_argument("column", type=Path, metavar="FILE.toml", help="a column, or a structure in space")
    add_motion_options(run)
    run.add_argument("--duration", type=float, metavar="S", help="s (default: that of the motion)")
    _add_run_options(run)
    add_force(run)

    # `record`
    record = commands.add_parser("record", help="how strong records are: peaks, Arias intensity, response spectrum")
    record.set_defaults(command=_record)
    record.add_argument("records", type=Path, nargs="+", metavar="FILE", help=FORMATS)
    add_file_options(record)
    record.add_argument("--plot", type=Path, metavar="FILE.png", help=f"draw them ({', '.join(PICTURES)})")
    add_force(record)

    # `convert`
    convert = commands.add_parser("convert", help="record -> the CSV that `fmpy simulate --input-file` takes")
    convert.set_defaults(command=_convert, paths=("motion", "output"))
    add_motion_options(convert)
    convert.add_argument(
        "output",
        type=Path,
        metavar="MOTION.csv",
        help="time, base.ax, base.az and base.ay, if there is one, and their slopes",
    )
    add_force(convert)
    add_export_command(commands)
    add_check_command(commands)
    add_gallery_command(commands)
    add_new_command(commands)
    add_schema_command(commands)
    add_static_commands(commands)
    add_calibrate_command(commands)
    add_study(commands)
    add_risk_command(commands)


def _add_run_options(run: argparse.ArgumentParser) -> None:
    """Add the options of `simulate`, by group."""
    accuracy = run.add_argument_group("accuracy (default: the column's)")
    accuracy.add_argument("--tolerance", type=float, help="error relative to the peak, unless the step is fixed")
    accuracy.add_argument("--formulation", help=" or ".join(FORMULATIONS))
    accuracy.add_argument("--integrator", help=" or ".join(INTEGRATORS))
    accuracy.add_argument("--step", type=float, metavar="S", help="s, of an integrator with a fixed step")
    words = "solve a structure that is a column in its plane as one, with joints rigid along themselves"
    way = accuracy.add_mutually_exclusive_group()
    way.add_argument("--plane", choices=("auto",), help=words)
    add_space(way)
    words = "a number (N, N m), or a CSV of time (s) and load, on a port; may be given again"
    loads = run.add_argument_group("loads")
    loads.add_argument("--load", action="append", default=[], metavar="PORT.Fx=LOAD", help=words)
    words = "rest under this load at the start, then let go; may be given again"
    loads.add_argument("--release", action="append", default=[], metavar="PORT.Fx=N", help=words)
    out = run.add_argument_group("output")
    out.add_argument("--output-step", type=float, metavar="S", help=f"s between two rows (default: {OUTPUT_STEP})")
    out.add_argument("-o", "--output", type=Path, metavar="FILE.csv", help="write the histories")
    words = f"significant ones of -o (default: {DIGITS}; 17: all)"
    out.add_argument("--digits", type=int, metavar="N", help=words)
    out.add_argument("--plot", type=Path, metavar="FILE.png", help=f"draw the histories ({', '.join(PICTURES)})")
    out.add_argument("--plot-column", type=Path, metavar="FILE.png", help="draw the deformed column at its peak")
    out.add_argument("--film", type=Path, metavar="FILE.gif", help="film the column (.gif; .mp4 where ffmpeg is)")
    out.add_argument("--view", type=Path, metavar="FILE.html", help="write a page that plays the blocks in a browser")
    words = f"s after the end in which to find out whether it falls (default: {SETTLE:g}; 0: none)"
    verdict = run.add_argument_group("verdict")
    verdict.add_argument("--settle", type=float, default=SETTLE, metavar="S", help=words)
    words = "s for which the run goes on after the first fall, in space (default: it ends there)"
    verdict.add_argument("--after-fall", type=float, metavar="S", help=words)
    trust = run.add_argument_group("trust")
    trust.add_argument("--no-check", action="store_true", help="do not repeat the run to estimate its error")
    trust.add_argument("--ensemble", type=int, default=0, metavar="RUNS", help="number of runs varied by the spread")
    add_spread(trust, Spread())


def _simulate(options: argparse.Namespace) -> None:
    # obstacles to an output are reported before the run, not after it
    outputs = outputs_of_run(options)
    digits = DIGITS if options.digits is None else check_digits("--digits", options.digits)
    if options.digits is not None and options.output is None:
        raise InputError(f"--digits {digits}: must be left out, or -o FILE.csv given")
    spread = spread_of(options)
    if not options.ensemble and spread != Spread():
        raise InputError("--spread, --spread-seed: must be left out, or --ensemble given")
    subject: Any = read_subject(options.column, options.space or options.after_fall is not None)
    if subject.kind.across:
        keys = ("formulation", "integrator", "step")
        refuse(options, keys, "must be left out, structures in space have none")
    elif options.plane is not None:
        raise InputError(f"--plane {options.plane}: must be left out, a column is solved in its plane")
    # motion, model and report
    motion, lines = motion_of(options)
    if options.plane == "auto":
        subject = subject.kind.equivalent_model(subject, motion)
    in_space = subject.kind.across
    report_of, summary_of = (structure.report, structure.summary) if in_space else (column_report, _summary)
    print(*lines, report_of(subject, motion), sep="\n", flush=True)
    # options of the run
    names = ("formulation", "integrator", "step", "tolerance", "output_step", "settle", "ensemble", "after_fall")
    given = {name: getattr(options, name) for name in names}
    if options.load or options.release:
        given |= {"loads": loads_of(options.load), "release": loads_of(options.release)}
    given |= {"check": not options.no_check, "spread": spread}
    # run, summary and files
    try:
        response = simulated(subject, motion, options.duration, **given)
        print(summary_of(response))
        writers: tuple[Callable[[Path], object], ...] = (
            lambda path: response.to_csv(path, digits),
            response.plot,
            response.plot_model,
            partial(_film, response),
            response.view,
        )
        write_outputs(zip(outputs, writers, strict=True))
    except MemoryError:
        raise SolverError("not enough memory for the response: a larger --output-step may help") from None


def _film(response: Any, path: Path) -> None:
    """Write a film of a response, with a progress line on a terminal."""
    with Line(unit="picture") as line:
        response.film(path, callback=line.show if sys.stderr.isatty() else None)


def _record(options: argparse.Namespace) -> None:
    check_picture(options.plot)
    check_outputs((options.plot,), options.records, options.force)
    check_file_options(options.records, options)
    motions = {}
    for path in options.records:
        record, motion = read_with_options(path, options, options.channel)
        motions[path.name if path.name not in motions else str(path)] = motion
        print(file_line(path, record))
        with reading(path):
            print(motion_report(motion))
    if options.plot is not None:
        from ..plotting.record_plots import plot_records

        write_outputs([(options.plot, partial(plot_records, motions))])


def _convert(options: argparse.Namespace) -> None:
    check_suffix(options.output, ".csv")
    inputs = options.motion, options.vertical, options.across, options.building
    check_outputs((options.output,), inputs, options.force)
    motion, lines = motion_of(options)
    motion.to_csv(options.output, slopes=True)
    print("\n".join(lines), end="\n" if lines else "")
    size = f"{len(motion.time)} samples, {motion.duration:g} s"
    print(f"{options.output}: {size}, largest acceleration {peaks_in_g(motion)}")


def _summary(response: Response) -> str:
    """Return the results of a run as text for the terminal."""
    column, stats = response.model, response.stats
    lines = [
        f"{column.name}: {column.settings.formulation} formulation, {column.settings.integrator} integrator",
        "block  peak |ux| (mm)",
        *(f"{i:5d}  {1e3 * peak:14.5g}" for i, peak in enumerate(response.peak_top_ux, start=1)),
    ]
    if "N" in response.peaks:
        lines += _peaks(response)
    # slip and cracks
    if column.slides:
        left = ", ".join(f"{1e3 * slip:.5g}" for slip in response.slip[-1])
        lines.append(f"slip of each block at the end (mm): {left}; friction took {stats['friction_work']:.4g} J")
    bonds = range(1, column.n + 1) if column.is_brittle else ()
    lines += cracks([f"joint {i}" for i in bonds], response.peaks.get("bond"))
    # verdict and accuracy
    lines.append(verdict_line(response))
    lines += error_lines(response, "ux")
    if response.ensemble is not None:
        lines += ensemble_lines(response.ensemble, range(1, column.n + 1), "ux")
    regimes = ("full_contact", "rocking", "flight")
    lines.append("time in " + ", ".join(f"{name.replace('_', ' ')} {percent(stats[name])}" for name in regimes))
    lines.append(f"{stats['steps']} steps in {stats['wall_time']:.2f} s")
    return "\n".join(lines)


def _peaks(response: Response) -> list[str]:
    """Return a table of the peak forces on joints and base."""
    peaks = response.peaks
    columns = {"N": 1e-3, "My": 1e-3, "Tx": 1e-3, "sigma_max": 1e-6, "contact": 1.0, "friction": 1.0}
    rows = zip(*(scale * peaks[name] for name, scale in columns.items()), strict=True)
    base = ", ".join(f"|{name}| {1e-3 * peaks[f'base_{name}'][0]:.5g} {unit}" for name, unit in BASE_PEAKS.items())
    return [
        "joint  peak N (kN)  |My| (kN m)  |Tx| (kN)  pressure (MPa)  least contact     |T| / N",
        *(
            f"{i:5d}  {n:11.5g}  {m:11.5g}  {t:9.5g}  {sigma:14.5g}  {contact:13.5g}  {friction:10.4g}"
            for i, (n, m, t, sigma, contact, friction) in enumerate(rows, start=1)
        ),
        f"peaks of the base reaction: {base}",
    ]
