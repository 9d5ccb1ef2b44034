"""The command `check`: whether a column or structure stands under an action, its margin, and which measure helps."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

from ..checks.action import ARTIFICIAL, Action, Level, action_on
from ..checks.check import Check, check_limits, checked, write_checks
from ..checks.friction import Envelope, friction_values, with_friction
from ..checks.limits import UNCERTAIN, Limits, Plan
from ..checks.risk import risk_of
from ..checks.scaling import LEAST_PART
from ..checks.subject import Subject, subject_of
from ..checks.variants import directions
from ..common.errors import InputError, needing, reading
from ..common.files import check_outputs, printable
from ..common.plausible import MOST_SPECTRAL
from ..common.ranges import listed
from ..ground.building import Building
from ..ground.motion import Motion
from ..models.column.model import Column
from ..models.structure.model import Structure
from ..studies.risk import RISK_NOTE, Hazard, risk_text
from .check_report import action_lines, check_lines, friction_lines, variants_lines
from .code_spectra import CODES, add_code_options, below_of, target_of
from .command_files import add_force, add_space, add_spread, check_suffix, read_subject, spread_of, write_outputs
from .motion_options import (
    FORMATS,
    add_building_options,
    add_file_options,
    add_other_channels,
    check_file_options,
    check_other_channels,
    floor_of,
    of_ground,
    recorded,
)
from .progress import PlainLine, RunsLine


def add_check_command(commands: argparse._SubParsersAction[Any]) -> None:
    """Add the command `check`."""
    parser = commands.add_parser("check", help="does it stand, by how much: demand beside capacity, margin, report")
    parser.set_defaults(command=_check, many="records")
    parser.add_argument("column", type=Path, metavar="FILE.toml", help="a column, or a structure in space")
    add_action(parser)
    # in space, in the plane, or in both directions
    way = parser.add_mutually_exclusive_group()
    add_space(way)
    words = "check a column in its plane, under one horizontal component, not in space"
    way.add_argument("--plane", action="store_true", help=words)
    words = "check twice: a column in its plane along its width, then along its depth, under one component each; a "
    words += "structure under the motions, then turned by a quarter"
    way.add_argument("--both", action="store_true", help=words)
    _add_plan(parser)
    words = "another file, checked beside; may be repeated"
    parser.add_argument("--variant", type=Path, action="append", default=[], metavar="FILE.toml", help=words)
    words = "of the site, as `risk` reads it: adds how likely it overturns in 50 years, from the runs of the check"
    parser.add_argument("--hazard", type=Path, metavar="FILE.csv", help=words)
    words = "check at each of these values of the friction of all joints, as 0.2:0.8:0.1; both bounds decide"
    parser.add_argument("--friction", metavar="FROM:TO:STEP", help=words)
    # output
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.csv", help="write the tables, with each motion")
    parser.add_argument("--report", type=Path, metavar="FILE.html", help="write a report with pictures, to be printed")
    words = "a line under the title of the report, for instance project, author and date; more by repeating it"
    parser.add_argument("--note", action="append", default=[], metavar="TEXT", help=words)
    add_force(parser)


def add_action(parser: argparse.ArgumentParser) -> None:
    """Add the records, their components, and the options that scale or replace them, for `motions_of`, `level_of`."""
    parser.add_argument("records", type=Path, nargs="*", metavar="RECORD", help=FORMATS)
    parser.add_argument("--vertical", type=Path, nargs="+", metavar="FILE", help="vertical components, in that order")
    words = "the other horizontal ones, of a structure in space"
    parser.add_argument("--across", type=Path, nargs="+", metavar="FILE", help=words)
    add_file_options(parser)
    add_other_channels(parser)
    add_building_options(parser)
    action = parser.add_argument_group("the action; without any the records are taken as they are")
    one = action.add_mutually_exclusive_group()
    mean = "of two components the geometric mean"
    words = f"largest horizontal acceleration of each record, g; {mean}"
    one.add_argument("--pga", type=float, metavar="G", help=words)
    words = f"spectral acceleration of each at the first period, g; {mean}"
    one.add_argument("--sa", type=float, metavar="G", help=words)
    words = f"{', '.join(CODES)}, or a table FILE.csv of period,g or period,m/s2"
    one.add_argument("--spectrum", metavar="NAME", help=words)
    # options of the target and of made motions
    words = "spectrum of the ground, where --spectrum is the table of a floor: as --spectrum; warns where that has less"
    action.add_argument("--below", metavar="NAME", help=words)
    action.add_argument("--vertical-pga", type=float, metavar="G", help="with --pga: of the vertical components, g")
    add_code_options(action)
    words = "range in which spectra follow the target"
    action.add_argument("--periods", type=float, nargs=2, metavar=("S", "S"), help=words)
    words = f"least part of the target that spectra keep (default: {LEAST_PART:g})"
    action.add_argument("--least", type=float, default=LEAST_PART, metavar="PART", help=words)
    words = f"motions made where no record is given (default: {ARTIFICIAL})"
    action.add_argument("--artificial", type=int, default=ARTIFICIAL, metavar="N", help=words)
    action.add_argument("--force-scale", action="store_true", help="apply factors on records beyond 0.01 to 100 too")
    action.add_argument("--artificial-vertical", action="store_true", help="with vertical components, by the codes")
    action.add_argument("--seed", type=int, default=0, metavar="N", help="of the first of them (default: 0)")


def _add_plan(parser: argparse.ArgumentParser) -> None:
    usual = Plan()
    plan = parser.add_argument_group("what is compared")
    keys = ", ".join(f"{item.name} {item.default if item.default is not None else 'none'}" for item in fields(Limits))
    words = f"a limit; may be repeated (defaults: {keys})"
    plan.add_argument("--limit", action="append", default=[], metavar="KEY=VALUE", help=words)
    words = f"varied runs per motion (default: {usual.ensemble}); 2 of forty blocks take minutes with --no-margin"
    add_ensemble(plan, usual.ensemble, words)
    # parts of the check that may be skipped
    words = "do not repeat the runs with other moduli and dampings of the joints"
    plan.add_argument("--no-joints", action="store_true", help=words)
    factor = usual.confidence_factor
    words = f"of the Circolare (default: {factor:g})"
    plan.add_argument("--confidence-factor", type=float, default=factor, metavar="FC", help=words)


def add_ensemble(plan: argparse._ActionsContainer, size: int, words: str) -> None:
    """Add the options of the varied runs and of the margin, for `spread_of`."""
    plan.add_argument("--ensemble", type=int, default=size, metavar="RUNS", help=words)
    add_spread(plan, UNCERTAIN)
    plan.add_argument("--no-margin", action="store_true", help="do not look for the factor at which it begins to fall")


def _check(options: argparse.Namespace) -> None:
    if options.output is not None:
        check_suffix(options.output, ".csv")
    if options.report is not None:
        check_suffix(options.report, ".html", ".htm")
        with needing("report", "jinja2", "matplotlib"):
            import jinja2  # noqa: F401
            import matplotlib  # noqa: F401
    elif options.note:
        raise InputError("--note: is for the report, must be given with --report FILE.html")
    frictions = [] if options.friction is None else friction_values(options.friction)
    if frictions and (options.both or options.variant):
        raise InputError(f"--friction {options.friction}: must be left out with --both and --variant")
    # models, each under a name of its own
    inputs = [options.column, *options.variant, *files_of_action(options), *filter(None, [options.hazard])]
    check_outputs((options.output, options.report), inputs, options.force)
    models = [(path, _model(path, options)) for path in (options.column, *options.variant)]
    models = _told_apart(models)
    if options.both:
        models.insert(1, (options.column, _across(*models[0])))
    if frictions:
        with reading(options.column):
            models = [(options.column, with_friction(models[0][1], value)) for value in frictions]
    # action on the model and its variants
    plan = _plan(options)
    hazard = None if options.hazard is None else Hazard.from_csv(options.hazard)
    level = level_of(options)
    motions, floor = motions_of(options), floor_of(options)
    subjects = [(path, _subject(path, model, plan)) for path, model in models]
    check_limits(plan.limits, [subject for _, subject in subjects])
    with reading(options.column):
        variants = [subject for _, subject in subjects[1:]]
        ground = action_on(subjects[0][1], motions, level, variants, floor[0] if floor and floor[1] else None)
    action = _on_floor(ground, floor)
    print(*action_lines(action), sep="\n", flush=True)
    # run the checks; print each report as soon as it is complete
    checks: list[Check] = []
    for path, subject in subjects:
        both = options.both and len(checks) < 2
        if both and checks:  # its second direction: the ground is turned, or in the plane the building
            turned = subject.model.kind.across
            acting = _on_floor(ground.turned() if turned else ground, floor, across=not turned)
            print(f"{subject.model.name}:", *action_lines(acting), sep="\n", flush=True)
        else:
            acting = action
        checks.append(replace(_checked(path, subject, acting, plan), both=both))
        if both or (len(checks) == 1 and not frictions):
            print(*check_lines(checks[-1]), sep="\n", flush=True)
    if options.both:
        print(*(f"{one.name}: {one.answer}" for one in checks[:2]), sep="\n")
    envelope = Envelope(frictions, tuple(checks)) if frictions else None
    if envelope:  # the governing value is reported in full
        checks.insert(0, checks.pop(envelope.worst))
        print(*check_lines(checks[0]), *friction_lines(envelope), sep="\n")
    elif len(checks) > 1:
        print(*variants_lines(checks), sep="\n")
    risk = _risk(directions(checks), hazard)
    print(*risk, sep="\n")
    report = partial(_write_report, checks, options.note, inputs, risk, envelope)
    write_outputs([(options.output, partial(write_checks, checks=checks)), (options.report, report)])


def _risk(checks: Sequence[Check], hazard: Hazard | None) -> list[str]:
    """Return the lines on the risk in each direction, none without a hazard, or why none follows from the runs."""
    if hazard is None:
        return []
    lines, note = [], []
    for check in checks:
        of = f" of {check.name}" if check.both else ""
        try:
            lines += risk_text(f"risk{of}, hazard {hazard}", risk_of(check, hazard)).splitlines()
            note = [RISK_NOTE]
        except InputError as error:
            lines.append(f"risk{of}: {error}")
    return lines + note


def _on_floor(action: Action, floor: tuple[Building, int] | None, across: bool = False) -> Action:
    """Return the action on a floor, if there is one; `across`: along y of the building."""
    if floor is None:
        return action
    building, number = floor
    return action.on_floor(building.across() if across else building, number)


def _write_report(
    checks: list[Check], notes: list[str], inputs: list[Path], risk: list[str], envelope: Envelope | None, path: Path
) -> None:
    from ..checks.report.html import write_report

    command = shlex.join(["multiblock", *sys.argv[1:]])
    write_report(checks, path, printable(command), [printable(note) for note in notes], inputs, risk, envelope)


def _model(path: Path, options: argparse.Namespace) -> Any:
    """Read the file; move a column to space if it may roll there or two components act, unless --plane is given."""
    model: Any = read_subject(path, options.space)
    two = bool(options.across) or (options.spectrum is not None and not options.records)
    rolls = model.rolls_in_space
    if model.kind.across or options.plane or not (rolls or (two and not options.both)):
        return model
    try:
        with reading(path):
            found = model.in_space()
    except InputError as why:
        if options.across:
            raise
        print(printable(f"{why}; checked in its plane"))
        return model
    why_there = "its contacts are round and may roll" if rolls else "two horizontal components act"
    name = printable(str(path))
    print(f"{name}: {why_there}, so it is checked in space; --plane keeps it in its plane")
    return found


def _told_apart(models: list[tuple[Path, Any]]) -> list[tuple[Path, Any]]:
    """Rename models that share a name after their files, or by numbers where the file names are ambiguous."""
    names, found = [model.name for _, model in models], []
    stems = [re.sub(r"[^\w-]", "-", path.stem) for path, _ in models]
    for number, ((path, model), stem) in enumerate(zip(models, stems, strict=True), start=1):
        apart = stem if stems.count(stem) == 1 and stem.strip("-") == stem else f"{model.name} {number}"
        found.append((path, replace(model, name=apart) if names.count(model.name) > 1 else model))
    return found


def _across(path: Path, model: Any) -> Any:
    """Return the column in the other direction, or the structure, for which motions are turned. Raises InputError."""
    if model.kind.across and not model.is_stack:
        return replace(model, name=f"{model.name} across")
    if model.is_alike_across:
        raise InputError(
            f"--both: must be left out, {path} is the same in both directions, or is checked in space; "
            "without --both a code spectrum acts with two components together"
        )
    with reading(path):
        return model.across()


def _subject(path: Path, model: Column | Structure, plan: Plan) -> Subject:
    with reading(path):
        model.kind.check(model, from_rest=True)
        found = subject_of(model, plan.confidence_factor)
        column = read_subject(path) if model.kind.across else None
        return replace(found, column=column if isinstance(column, Column) else None)


def _checked(path: Path, subject: Subject, action: Action, plan: Plan) -> Check:
    with reading(path), RunsLine() if sys.stderr.isatty() else PlainLine() as line:
        try:
            return checked(subject, action, plan, line)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                "no run of this check is kept; --ensemble, --no-margin, --no-joints shorten it"
            ) from None


def _plan(options: argparse.Namespace) -> Plan:
    known = {item.name for item in fields(Limits)}
    # limits from KEY=VALUE
    limits: dict[str, float] = {}
    for text in options.limit:
        key, _, value = text.partition("=")
        if key not in known:
            raise InputError(f"--limit {text}: must be KEY=VALUE with one of {listed(sorted(known), key)}")
        try:
            limits[key] = float(value)
        except ValueError:
            raise InputError(f"--limit {text}: must be {key}= and a number") from None
    return Plan(
        Limits(**limits),
        options.ensemble,
        spread_of(options),
        not options.no_margin,
        options.confidence_factor,
        not options.no_joints,
    )


def level_of(options: argparse.Namespace) -> Level:
    """Return the level to which motions are scaled. Raises InputError."""
    return Level(
        target=target_of(options),
        below=below_of(options),
        pga=of_ground("--pga", options.pga),
        vertical_pga=of_ground("--vertical-pga", options.vertical_pga),
        sa=of_ground("--sa", options.sa, 0.5 * MOST_SPECTRAL),
        periods=None if options.periods is None else (options.periods[0], options.periods[1]),
        least=options.least,
        artificial=options.artificial,
        vertical=options.artificial_vertical,
        seed=options.seed,
        force_scale=options.force_scale,
    )


def files_of_action(options: argparse.Namespace) -> list[Path]:
    """Return the files of records, components, building and spectra."""
    components = (*(options.vertical or ()), *(options.across or ()))
    tables = [Path(name) for name in (options.spectrum, options.below) if name not in (None, *CODES)]
    return [*options.records, *components, *filter(None, [options.building]), *tables]


def motions_of(options: argparse.Namespace) -> Mapping[str, Motion]:
    """Read the records, each with its other components, and return them by file name."""
    beside = {key: getattr(options, key) or [] for key in ("across", "vertical")}
    for key, files in beside.items():
        if files and len(files) != len(options.records):
            count = len(options.records)
            raise InputError(f"--{key}: {len(files)} files, must be {count}, one for each record")
    paths = [*options.records, *beside["across"], *beside["vertical"]]
    if paths:
        check_file_options(paths, options)
    # read the files and merge the components of each record
    found: dict[str, Motion] = {}
    check_other_channels(options)
    for k, path in enumerate(options.records):
        if path in options.records[:k]:
            raise InputError(f"{path}: is given twice, must be given once")
        motion, lines = recorded(options, path, *(files[k] if files else None for files in beside.values()))
        print(*lines, sep="\n")
        name = printable(path.stem)
        found[name if name not in found else printable(str(path))] = motion
    return found
