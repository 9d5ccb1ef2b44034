"""The command `export`: a run as files for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..common.errors import InputError
from ..common.files import check_outputs
from .command_files import add_force, add_space, read_subject, write_outputs
from .motion_options import add_motion_options, motion_of
from .progress import simulated

KINDS = {".glb": "to_gltf", ".html": "view", ".csv": "to_csv", "": "to_vtk"}  # by suffix; none: a folder


def add_export_command(commands: Any) -> None:
    """Add the command `export`."""
    words = "a run as .glb (Blender), a folder for ParaView, .html or .csv"
    export = commands.add_parser("export", help=words)
    export.set_defaults(command=_export, paths=("motion", "output"))
    export.add_argument("column", type=Path, metavar="FILE.toml", help="a column, or a structure in space")
    add_motion_options(export)
    words = "FILE.glb: blocks and their motion; FOLDER: blocks.pvd and joints.pvd; .html: as of simulate --view; .csv"
    export.add_argument("output", type=Path, metavar="OUTPUT", help=words)
    export.add_argument("--duration", type=float, metavar="S", help="s (default: that of the motion)")
    add_space(export)
    add_force(export)


def _export(options: argparse.Namespace) -> None:
    kind = options.output.suffix.lower()
    if kind not in KINDS and options.output.is_dir():
        kind = ""
    if kind not in KINDS:
        raise InputError(f"{options.output}: must end in .glb, .html or .csv, or be a folder")
    if kind:
        inputs = options.column, options.motion, options.vertical, options.across, options.building
        check_outputs((options.output,), inputs, options.force)
    elif options.output.exists() and not options.force:
        raise InputError(f"{options.output}: is there already, --force overwrites files in it")
    subject: Any = read_subject(options.column, options.space)
    motion, lines = motion_of(options)
    if lines:
        print(*lines, sep="\n", flush=True)
    response = simulated(subject, motion, options.duration, check=False)
    write_outputs([(options.output, getattr(response, KINDS[kind]))])
