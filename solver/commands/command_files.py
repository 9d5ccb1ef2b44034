"""What commands share: options, and files that are checked before any computation."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..common.errors import InputError, needing, reading
from ..common.files import check_outputs, printable, toml_of
from ..ground.loads import loads_by_port
from ..models.column.model import Column
from ..models.structure.hull_tables import in_folder
from ..models.structure.model import Structure
from ..models.uncertainty import Spread
from ..studies.subjects import subject_from

PICTURES = (".png", ".pdf", ".svg")


def add_space(parser: argparse._ActionsContainer) -> None:
    """Add --space, for `read_subject`."""
    parser.add_argument("--space", action="store_true", help="solve a column as a structure in space")


def add_spread(parser: argparse._ActionsContainer, usual: Spread) -> None:
    """Add --spread and --spread-seed, with these defaults, for `spread_of`."""
    sizes = usual.stiffness, usual.damping, usual.motion
    words = "relative sizes of the varied data (default: {:g} {:g} {:g})".format(*sizes)
    names = ("STIFFNESS", "DAMPING", "MOTION")
    parser.add_argument("--spread", type=float, nargs=3, default=sizes, metavar=names, help=words)
    words = f"of the varied data (default: {usual.seed})"
    parser.add_argument("--spread-seed", type=int, default=usual.seed, metavar="N", help=words)


def spread_of(options: argparse.Namespace) -> Spread:
    """Return the spread of the varied runs."""
    stiffness, damping, motion = options.spread
    return Spread(stiffness, damping, motion, options.spread_seed)


def read_subject(path: Path, space: bool = False) -> Column | Structure:
    """Read the file of a column or structure; `space`: a column as its stack in space. Raises InputError."""
    check_suffix(path, ".toml")
    with reading(path):
        return subject_from(in_folder(toml_of(path), path.parent), space)


def loads_of(texts: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Parse PORT.COMPONENT=LOAD into loads by port and component. Raises InputError.

    A load is a number or the name of a file.
    """
    given: dict[str, Any] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (equals and value):
            raise InputError(f"{text}: must be PORT.COMPONENT=LOAD, as roof.Fx=1000 or roof.Fx=push.csv")
        if name in given:
            raise InputError(f"{text}: {name} is given twice, must be given once")
        given[name] = value
        with suppress(ValueError):
            given[name] = float(value)
    return loads_by_port(given)


def read_column(path: Path) -> Column:
    """Read a column file. Raises InputError."""
    found = read_subject(path)
    if isinstance(found, Structure):
        raise InputError(f"{path}: is a structure in space, must be a column")
    return found


def check_picture(path: Path | None) -> None:
    """Raise InputError if a requested picture cannot be drawn."""
    if path is not None:
        check_suffix(path, *PICTURES)
        with needing("plot", "matplotlib"):
            import matplotlib  # noqa: F401


def outputs_of_run(options: argparse.Namespace) -> tuple[Path | None, ...]:
    """Return the output files of `simulate`, None for one not requested, after checking them. Raises InputError."""
    check_suffix(options.output, ".csv")
    check_picture(options.plot)
    check_picture(options.plot_column)
    if options.film is not None:
        with needing("plot", "matplotlib"):
            from ..plotting.film import check_film
        check_film(options.film)
    check_suffix(options.view, ".html")
    outputs = (options.output, options.plot, options.plot_column, options.film, options.view)
    inputs = options.column, options.motion, options.vertical, options.across, options.building
    check_outputs(outputs, (*inputs, *_files_of_loads(options.load)), options.force)
    return outputs


def _files_of_loads(texts: Iterable[str]) -> list[Path]:
    """Return the paths of the loads PORT.COMPONENT=LOAD that are files."""
    return [path for path in (Path(text.partition("=")[2]) for text in texts) if path.is_file()]


def refuse(options: argparse.Namespace, keys: Iterable[str], why: str, value: bool = False) -> None:
    """Raise InputError for the first of the options that is given; `value`: the message has its value too."""
    for key in keys:
        if (given := getattr(options, key)) is not None:
            raise InputError(f"--{key.replace('_', '-')}{f' {given}' if value else ''}: {why}")


def add_force(parser: argparse.ArgumentParser) -> None:
    """Add --force, which permits what `files.check_outputs` refuses."""
    parser.add_argument("--force", action="store_true", help="overwrite files that are there")


def write_outputs(outputs: Iterable[tuple[Path | None, Callable[[Path], object]]]) -> None:
    """Write the requested files, and print their names. Raises InputError that begins with the path."""
    for path, write in outputs:
        if path is not None:
            with reading(path):
                write(path)
            print(printable(str(path)))


def check_suffix(path: Path | None, *known: str) -> None:
    """Raise InputError unless the file name, if given, ends in one of these suffixes, ignoring case."""
    if path is not None and path.suffix.lower() not in known:
        raise InputError(f"{path}: must end in {' or '.join(known)}")
