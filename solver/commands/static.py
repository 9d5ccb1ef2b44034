"""The commands `modes` and `statics`: what a column is before anything shakes it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..column.rest import check_stable
from ..common.errors import reading
from ..common.files import check_outputs
from ..statics.capacity import capacity_curve, rest_of
from ..statics.modes import natural_modes
from .command_files import PICTURES, add_force, check_picture, check_suffix, read_column, write_outputs
from .progress import compile_kernels
from .reports import modes_report, statics_report


def add_static_commands(commands: argparse._SubParsersAction[Any]) -> None:
    """Add `modes` and `statics`."""
    modes = commands.add_parser("modes", help="natural frequencies, shapes and damping ratios of a column")
    modes.set_defaults(command=_modes)
    statics = commands.add_parser(
        "statics", help="stress at rest, when joints open, and the largest steady acceleration that a column balances"
    )
    statics.set_defaults(command=_statics)
    for parser, rows in ((modes, "a row for each mode"), (statics, "the curve of balance")):
        parser.add_argument("column", type=Path, metavar="COLUMN.toml", help="blocks, joints and solver settings")
        parser.add_argument("-o", "--output", type=Path, metavar="FILE.csv", help=f"write {rows}")
        parser.add_argument("--plot", type=Path, metavar="FILE.png", help=f"draw it ({', '.join(PICTURES)})")
        add_force(parser)


def _modes(options: argparse.Namespace) -> None:
    _check(options)
    column = read_column(options.column)
    compile_kernels()
    with reading(options.column):
        check_stable(column)
        modes = natural_modes(column)
    print(modes_report(modes))
    write_outputs(((options.output, modes.to_csv), (options.plot, modes.plot)))


def _statics(options: argparse.Namespace) -> None:
    _check(options)
    column = read_column(options.column)
    compile_kernels()
    with reading(options.column):
        curve = capacity_curve(column)
        rest = rest_of(column)
    print(statics_report(rest, curve))
    write_outputs(((options.output, curve.to_csv), (options.plot, curve.plot)))


def _check(options: argparse.Namespace) -> None:
    if options.output is not None:
        check_suffix(options.output, ".csv")
    check_picture(options.plot)
    check_outputs((options.output, options.plot), (options.column,), options.force)
