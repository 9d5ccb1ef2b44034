"""The base motion on the command line: a record, a pair of records or a wavelet, and its strength."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..common.errors import POSITIVE, InputError, check_number, reading
from ..common.files import printable
from ..common.plausible import MOST_SHAKEN, warn_of
from ..ground.building import Building, floor_motion
from ..ground.motion import STANDARD_GRAVITY, Motion, peaks_in_g
from ..ground.records import NAMES, Record, format_of, read_record
from ..ground.records.columns import PLAIN
from ..ground.records.units import KNOWN
from ..studies.motions import FORMULAS, read_components
from .command_files import refuse

FORMATS = f"record: {', '.join(NAMES)}, plain columns"


WAVELETS = ("ricker", "one-sine", "one-cosine", "mavroeidis-papageorgiou", "noise")  # of studies/motions.py, FORMULAS
_OPTIONS = {"duration": "length"}  # arguments of formulas with another option name: --duration is that of the run
_OF_WAVELETS = ("frequency", "cycles", "phase", "length", "seed")
_OF_RECORDS = ("vertical", "across", "dt", "units", "channel", "vertical_channel", "across_channel")


def add_file_options(parser: argparse._ActionsContainer) -> None:
    """Add the options for files that do not state their sampling interval, unit or channel."""
    parser.add_argument("--dt", type=float, metavar="S", help="s between the samples of plain columns without times")
    parser.add_argument("--units", metavar="UNIT", help=f"of plain columns: {KNOWN}")
    parser.add_argument("--channel", type=int, metavar="N", help="which of several in one file, from 1")


def add_other_channels(parser: argparse._ActionsContainer) -> None:
    """Add --vertical-channel and --across-channel."""
    for key in ("vertical", "across"):
        words = f"the same, of --{key} (default: --channel)"
        parser.add_argument(f"--{key}-channel", type=int, metavar="N", help=words)


def add_motion_options(parser: argparse.ArgumentParser) -> None:
    """Add the record, the options that go with it and those that replace it."""
    parser.add_argument("motion", type=Path, nargs="?", metavar="MOTION", help=FORMATS)
    records = parser.add_argument_group("records")
    records.add_argument("--vertical", type=Path, metavar="FILE", help="the vertical component that goes with it")
    records.add_argument(
        "--across", type=Path, metavar="FILE", help="the other horizontal one, of a structure in space"
    )
    add_other_channels(records)
    add_file_options(records)
    strength = parser.add_argument_group("strength").add_mutually_exclusive_group()
    strength.add_argument("--scale", type=float, help="factor on the base acceleration")
    words = "largest acceleration of the first component, g; the others are scaled alike"
    strength.add_argument("--pga", type=float, metavar="G", help=words)
    # wavelets
    group = parser.add_argument_group("in place of a record")
    group.add_argument("--wavelet", metavar="NAME", help=", ".join(WAVELETS))
    group.add_argument("--frequency", type=float, metavar="HZ", help="Hz; of noise: of the ground it is filtered by")
    group.add_argument("--cycles", type=float, metavar="N", help="under the bell of mavroeidis-papageorgiou")
    group.add_argument("--phase", type=float, metavar="DEG", help="degrees, of mavroeidis-papageorgiou (default: 0)")
    group.add_argument("--length", type=float, metavar="S", help="s, of noise")
    group.add_argument("--seed", type=int, metavar="N", help="of noise")
    add_building_options(parser)


def add_building_options(parser: argparse.ArgumentParser) -> None:
    """Add --building and --floor, for `floor_of`."""
    group = parser.add_argument_group("on a floor")
    group.add_argument("--building", type=Path, metavar="FILE.toml", help="the building that the ground moves")
    group.add_argument("--floor", type=int, metavar="N", help="the floor on which it stands; 0: the ground")


def floor_of(options: argparse.Namespace) -> tuple[Building, int] | None:
    """Return the building of --building and the number of --floor; None without both. Raises InputError."""
    if options.building is None:
        refuse(options, ("floor",), "is for --building", value=True)
        return None
    if options.floor is None:
        raise InputError("--floor: must be given with --building")
    building = Building.from_toml(options.building)
    return building, building.checked(options.floor, "--floor")


def motion_of(options: argparse.Namespace) -> tuple[Motion, list[str]]:
    """Return the requested motion, and a line on each file that was read. Raises InputError."""
    if options.wavelet is None:
        refuse(options, _OF_WAVELETS, "is for --wavelet", value=True)
        if options.motion is None:
            raise InputError("MOTION: must be given, a record or --wavelet")
        check_file_options([path for path in (options.motion, options.vertical, options.across) if path], options)
        check_other_channels(options)
        motion, lines = recorded(options, options.motion, options.across, options.vertical)
    else:
        refuse(options, _OF_RECORDS, "is for records, not for --wavelet", value=True)
        if options.motion is not None:
            raise InputError(f"{options.motion}: must be left out, or --wavelet")
        motion, lines = _wavelet(options), []
    if (pga := of_ground("--pga", options.pga)) is not None:
        motion = motion.scaled_to(pga)
    elif options.scale is not None:
        motion = motion.scaled(options.scale)
    on = floor_of(options)
    if on is None:
        return motion, lines
    return floor_motion(motion, *on), [
        *lines,
        printable(f"{on[0].words(on[1])}; PGA of the ground {peaks_in_g(motion)}"),
    ]


def of_ground(key: str, value: float | None, most: float = MOST_SHAKEN) -> float | None:
    """Return an acceleration of the ground or of its spectrum, given in g, in m/s2; None without.

    Warns as `warn_of_ground`. Raises InputError unless it is positive.
    """
    if value is None:
        return None
    found = STANDARD_GRAVITY * check_number(key, value, POSITIVE, "a positive number in g")
    warn_of_ground(key, value, most)
    return found


def warn_of_ground(key: str, value: float, most: float = MOST_SHAKEN) -> None:
    """Warn (InputWarning) of an acceleration beyond `most`, both in g, as if it were in m/s2."""
    if value > most:
        as_meant = f"{value:g} m/s2 is {value / STANDARD_GRAVITY:.3g} g"
        warn_of([f"{key} = {value:g}: is in g, should be {most:g} at most; {as_meant}"])


def read_with_options(path: Path, options: argparse.Namespace, channel: int | None) -> tuple[Record, Motion]:
    """Return the record and the motion of a file, with --dt and --units for plain columns only. Raises InputError."""
    plain = format_of(path) == PLAIN
    record = read_record(path, options.dt if plain else None, options.units if plain else None, channel)
    with reading(path):
        return record, Motion.from_record(record, path.name)


def check_file_options(paths: list[Path], options: argparse.Namespace) -> None:
    """Raise InputError if --dt or --units are given and apply to none of the files."""
    for key in ("dt", "units"):
        if getattr(options, key) is not None and all(format_of(path) != PLAIN for path in paths):
            raise InputError(f"--{key}: must be left out, {paths[0]} is {format_of(paths[0])} and says all itself")


def file_line(path: Path, record: Record) -> str:
    """Return a line on a file as it was read: format, samples, title, notes."""
    step = f"{len(record.time)} samples, {record.time[-1] - record.time[0]:g} s"
    parts = [f"{path}: {record.format}, {step}", *filter(None, [record.title[:80]]), *record.notes]
    return printable("; ".join(parts))


def check_other_channels(options: argparse.Namespace) -> None:
    """Raise InputError if --vertical-channel or --across-channel is given without its files."""
    for key in ("vertical", "across"):
        if not getattr(options, key):
            refuse(options, (f"{key}_channel",), f"is for --{key}", value=True)


def recorded(
    options: argparse.Namespace, record: Path, across: Path | None, vertical: Path | None
) -> tuple[Motion, list[str]]:
    """Return the motion of a record with its other components, and a line on each file. Raises InputError."""
    files = {"record": record, "across": across, "vertical": vertical}
    channels = {"record": options.channel, "across": options.across_channel, "vertical": options.vertical_channel}
    keys = {"record": str(record), "across": "--across", "vertical": "--vertical"}
    lines: list[str] = []

    def read(name: str, path: Path, channel: int | None) -> Motion:
        found, motion = read_with_options(path, options, channel)
        lines.append(file_line(path, found) if name == "record" else f"{name} {file_line(path, found)}")
        return motion

    paths = {name: path for name, path in files.items() if path is not None}
    return read_components(paths, channels, keys, "-", read), lines


def _wavelet(options: argparse.Namespace) -> Motion:
    name = options.wavelet
    if name not in WAVELETS:
        raise InputError(f"--wavelet {name}: must be {', '.join(WAVELETS)}")
    if options.pga is None or options.scale is not None:
        raise InputError("--pga: must be given with --wavelet, the largest acceleration in g")
    formula = FORMULAS[name]
    option_of = {number: _OPTIONS.get(number, number) for number in (*formula.needs, *formula.optional)}
    for number in formula.needs:
        if getattr(options, option_of[number]) is None:
            raise InputError(f"--{option_of[number]}: must be given with --wavelet {name}")
    others = tuple(key for key in _OF_WAVELETS if key not in option_of.values())
    refuse(options, others, f"is not for --wavelet {name}", value=True)
    given = {number: getattr(options, option) for number, option in option_of.items()}
    numbers = {number: value for number, value in given.items() if value is not None}
    return formula.makes(**{formula.amplitude: 1.0}, **numbers)  # of unit amplitude, scaled to --pga later
