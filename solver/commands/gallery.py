"""The command `gallery`: which objects stand on which mounts under one action."""

from __future__ import annotations

import argparse
import shlex
import sys
import warnings
from collections.abc import Iterator
from dataclasses import astuple, fields
from functools import partial
from pathlib import Path
from typing import Any

from ..checks.action import OF_FLOORS
from ..checks.answer import components_sentence
from ..checks.limits import Plan
from ..checks.subject import subject_of
from ..common.errors import InputError, InputWarning, needing, reading
from ..common.files import printable, whole_file, write_table
from ..gallery.mounts import mounted, read_mounts
from ..gallery.objects import read_objects
from ..gallery.survey import Gallery, Outcome, common_action, survey
from .check import add_action, add_ensemble, files_of_action, level_of, motions_of
from .check_report import action_lines
from .command_files import spread_of, write_outputs
from .motion_options import floor_of
from .progress import PlainLine, RunsLine
from .reports import text_columns

VARIED = 7  # runs in addition to that as given: both fill the lanes
BESIDE = (
    "Joints are dry, on whole faces; a pedestal on bearings is fastened to its slab. Check in full what matters, by "
    "`multiblock check`."
)


def add_gallery_command(commands: argparse._SubParsersAction[Any]) -> None:
    """Add the command `gallery`."""
    parser = commands.add_parser("gallery", help="many objects, each on several mounts: which hold, by which margin")
    parser.set_defaults(command=_gallery, many="records")
    parser.add_argument("objects", type=Path, metavar="OBJECTS.csv", help="a row for each object")
    add_action(parser)
    words = "mounts to try, from the least to the most intervention"
    parser.add_argument("--mounts", type=Path, required=True, metavar="FILE.toml", help=words)
    add_ensemble(parser, VARIED, f"varied ones a motion, in addition to that as given (default: {VARIED})")
    words = "of OBJECTS.journal, .csv and .html (default: the current one); run again to go on"
    parser.add_argument("--output-folder", type=Path, default=Path(), metavar="FOLDER", help=words)
    words = "a line under the title of the page; more by repeating it"
    parser.add_argument("--note", action="append", default=[], metavar="TEXT", help=words)


def _gallery(options: argparse.Namespace) -> None:
    with needing("report", "jinja2", "matplotlib"):
        from ..checks.report.inputs import hashed, with_meshes
        from ..gallery.page import page_text
    if options.sa is not None:
        raise InputError("--sa: must be left out, first periods differ from object to object; --pga or --spectrum")
    journal = options.output_folder / f"{options.objects.stem}.journal"
    with reading(options.output_folder):
        options.output_folder.mkdir(parents=True, exist_ok=True)
    # objects on mounts, all of them before any run
    floor = floor_of(options)
    exhibits, mounts = read_objects(options.objects, floor[1] if floor else 0), read_mounts(options.mounts)
    plan = Plan(ensemble=options.ensemble, spread=spread_of(options), margin=not options.no_margin, joints=False)
    with reading(options.objects):
        for exhibit in exhibits:
            if floor:
                floor[0].checked(exhibit.floor, f"{exhibit.name}: floor")
            elif exhibit.floor:
                raise InputError(f"{exhibit.name}: floor = {exhibit.floor}: needs --building")
        subjects = [subject_of(mounted(exhibit, mount)) for exhibit in exhibits for mount in mounts]
    for model in (subject.model for subject in subjects[:: len(mounts)]):
        for line in model.kind.warnings(model):
            if ".damping" not in line:  # not given, but chosen
                print(f"warning: {printable(f'{model.name}: {line}')}", file=sys.stderr)
    warnings.filterwarnings("ignore", r"columns\[", InputWarning)  # the same, of the runs
    # the action on each floor
    ground = common_action(subjects, motions_of(options), level_of(options), floor[0] if floor else None)
    floors = sorted({exhibit.floor for exhibit in exhibits})
    actions = {number: ground.on_floor(floor[0], number) if floor else ground for number in floors}
    print(*action_lines(ground), sep="\n", flush=True)
    # runs, pair by pair
    with RunsLine() if sys.stderr.isatty() else PlainLine() as line:
        gallery = survey(exhibits, mounts, subjects, actions, plan, journal, line)
    floors_of = [f"Floors are those of {printable(floor[0].name)}. {OF_FLOORS}"] if floor else []
    remarks = [components_sentence(ground, True), *ground.cautions(), *floors_of, BESIDE]
    print(*_lines(gallery), *remarks, sep="\n")
    command, notes = printable(shlex.join(["multiblock", *sys.argv[1:]])), list(map(printable, options.note))
    meshes = [Path(exhibit.mesh) for exhibit in exhibits if exhibit.mesh]
    inputs = hashed(with_meshes([options.objects, options.mounts, *meshes, *files_of_action(options)]))
    values = {"action": ground, "command": command, "inputs": inputs, "notes": notes, "remarks": remarks}
    page = partial(_write_page, lambda: page_text(gallery, **values))
    write_outputs([(journal.with_suffix(".csv"), partial(_write_csv, gallery)), (journal.with_suffix(".html"), page)])


def _lines(gallery: Gallery) -> Iterator[str]:
    """Yield the table of all objects as aligned lines, then a line on each first fall."""
    rows = [["object", "first that holds", *(mount.name for mount in gallery.mounts)]]
    for k, (exhibit, outcomes) in enumerate(zip(gallery.exhibits, gallery.outcomes, strict=True)):
        rows.append([exhibit.name, gallery.first_mount(k), *(one.text for one in outcomes)])
    yield from text_columns(rows)
    for exhibit, outcomes in zip(gallery.exhibits, gallery.outcomes, strict=True):
        pairs = zip(gallery.mounts, outcomes, strict=True)
        if said := "; ".join(f"{mount.name}: {one.first}" for mount, one in pairs if one.first):
            yield f"first falls of {exhibit.name}: {said}"


def _write_csv(gallery: Gallery, path: Path) -> None:
    """Write one line for each pair, in SI units."""
    rows = [
        (exhibit.name, mount.name, outcome.holds, *astuple(outcome))
        for exhibit, outcomes in zip(gallery.exhibits, gallery.outcomes, strict=True)
        for mount, outcome in zip(gallery.mounts, outcomes, strict=True)
    ]
    write_table(path, ["object", "mount", "holds", *(item.name for item in fields(Outcome))], rows)


def _write_page(text: Any, path: Path) -> None:
    with whole_file(path) as beside:
        beside.write_text(text(), encoding="utf-8")
