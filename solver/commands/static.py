"""The commands `modes` and `statics`: properties of a column or structure at rest."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from ..common.errors import InputError, reading
from ..common.files import check_outputs
from ..common.plausible import warn_of
from ..models.column.modes import Modes, natural_modes
from ..models.column.rest import check_stable
from ..models.structure.model import Structure
from ..models.structure.modes import SpatialModes, modes_in_space
from ..models.structure.push import PushOver, push_over
from ..models.structure.rest import known_warnings_in_space
from ..statics.capacity import CapacityCurve, capacity_curve, curves_each_way, rest_of
from .command_files import (
    PICTURES,
    add_force,
    add_space,
    check_picture,
    check_suffix,
    loads_of,
    read_subject,
    refuse,
    write_outputs,
)
from .reports import modes_report, statics_report
from .static_reports import modes_in_space_report, push_line, push_over_report, rest_in_space_report

EVERY = 45  # degrees between the directions in which a structure is pushed


def add_static_commands(commands: argparse._SubParsersAction[Any]) -> None:
    """Add the commands `modes` and `statics`."""
    modes = commands.add_parser("modes", help="natural frequencies, shapes and damping ratios")
    modes.set_defaults(command=_modes)
    statics = commands.add_parser(
        "statics", help="stress at rest, when joints open, and the largest steady acceleration that it balances"
    )
    statics.set_defaults(command=_statics)
    for parser, rows in ((modes, "a row for each mode"), (statics, "the curve of balance")):
        parser.add_argument("column", type=Path, metavar="FILE.toml", help="a column, or a structure in space")
        parser.add_argument("-o", "--output", type=Path, metavar="FILE.csv", help=f"write {rows}")
        parser.add_argument("--plot", type=Path, metavar="FILE.png", help=f"draw it ({', '.join(PICTURES)})")
        add_space(parser)
        add_force(parser)
    # options of `statics` alone
    words = (
        f"of the push on a structure, degrees from x to y (default: every {EVERY}, and the least is written and drawn)"
    )
    statics.add_argument("--direction", type=float, metavar="DEG", help=words)
    words = "part of the push on a structure that acts upwards, over the horizontal one (default: 0)"
    statics.add_argument("--vertical", type=float, metavar="PART", help=words)
    words = "push by this load on a port, whose factor grows; may be given again"
    statics.add_argument("--pattern", action="append", metavar="PORT.Fx=N", help=words)


def _modes(options: argparse.Namespace) -> None:
    _check(options)
    subject: Any = read_subject(options.column, options.space)
    modes: Modes | SpatialModes
    if subject.kind.across:
        with reading(options.column):
            _check_weight(subject)
            modes = modes_in_space(subject)
        warn_of(known_warnings_in_space(subject))
        print(modes_in_space_report(modes))
    else:
        with reading(options.column):
            check_stable(subject)
            modes = natural_modes(subject)
        print(modes_report(modes))
    write_outputs(((options.output, modes.to_csv), (options.plot, modes.plot)))


def _check_weight(structure: Structure) -> None:
    """Raise InputError for a structure without weight that has joints which bear no tension."""
    for joint in structure.joints:
        holds = joint.bed.tensile_strength > 0.0 if joint.bearing is None else joint.bearing.holds
        if structure.g == 0.0 and not holds:
            raise InputError("g = 0.0: must be positive for joints that are in contact at rest")


def _statics(options: argparse.Namespace) -> None:
    _check(options)
    subject: Any = read_subject(options.column, options.space)
    curve: CapacityCurve | PushOver
    if subject.kind.across:
        curve = _pushed(subject, options)
    else:
        why = "is for structures in space, a column is pushed in its plane; --space pushes it in space"
        refuse(options, ("direction", "vertical"), why)
        with reading(options.column):
            pattern = _pattern(options)
            curves = curves_each_way(subject) if pattern is None else [capacity_curve(subject, pattern=pattern)]
            rest, curve = rest_of(subject), curves[0]
        print(statics_report(rest, *curves))
    write_outputs(((options.output, curve.to_csv), (options.plot, curve.plot)))


def _pushed(structure: Structure, options: argparse.Namespace) -> PushOver:
    """Print the push-over in every direction requested, and return that of the least push."""
    degrees = range(0, 360, EVERY) if options.direction is None else (options.direction,)
    pattern = _pattern(options)
    if pattern is not None:
        refuse(options, ("direction", "vertical"), "must be left out, --pattern says along what it is pushed")
        degrees = (0.0,)
    found = []
    with reading(options.column):
        for angle in degrees:
            found.append(push_over(structure, math.radians(angle), options.vertical or 0.0, pattern))
            if len(found) == 1:
                print(rest_in_space_report(found[0]), flush=True)
            print(push_line(found[-1]), flush=True)
    warn_of(known_warnings_in_space(structure))
    least = min(found, key=lambda one: one.largest_acceleration)
    print(push_over_report(least))
    return least


def _pattern(options: argparse.Namespace) -> dict[str, float] | None:
    """Return the loads of the push pattern by port and component, or None."""
    if not options.pattern:
        return None
    loads = loads_of(options.pattern)
    return {f"{port}.{name}": load for port, parts in loads.items() for name, load in parts.items()}


def _check(options: argparse.Namespace) -> None:
    check_suffix(options.output, ".csv")
    check_picture(options.plot)
    check_outputs((options.output, options.plot), (options.column,), options.force)
