"""The spectra of codes on the command line: a row for each code, from which its options follow."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any, NamedTuple

from ..checks.spectra import SOILS, TargetSpectrum, eurocode8, ntc2018, spectrum_from_csv
from ..common.errors import InputError, check_number
from ..common.ranges import suggestion
from ..ground.motion import STANDARD_GRAVITY
from .motion_options import warn_of_ground


class Option(NamedTuple):
    """An option of a code, and the argument of the spectrum's function that it sets."""

    name: str
    type: Callable[[str], Any]
    metavar: str
    help: str
    argument: str = ""  # if it has another name
    factor: float = 1.0  # to SI
    limits: tuple[tuple[float, float], str] | None = None  # in the option's own unit, and what it must be


class Code(NamedTuple):
    """The spectrum of a code: its function, required options, and options with defaults (`more`)."""

    spectrum: Callable[..., TargetSpectrum]
    needed: tuple[Option, ...]
    more: tuple[Option, ...] = ()


AG = Option(
    "ag",
    float,
    "G",
    "design acceleration on rock, importance included, g",
    factor=STANDARD_GRAVITY,
    limits=((1e-3, 10.0), "an acceleration in g, from 0.001 to 10"),
)
SOIL = Option("soil", str, "CLASS", ", ".join(SOILS))
CODES = {
    "ec8": Code(eurocode8, (AG, SOIL), (Option("type", int, "N", "1 or 2 (default: 1)", "kind"),)),
    "ntc2018": Code(
        ntc2018,
        (AG, SOIL, Option("f0", float, "F0", "F0"), Option("tc", float, "S", "TC*, s", "tc_star")),
        (Option("topography", str, "CLASS", "T1 to T4 (default: T1)"),),
    ),
}


def add_code_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of all codes."""
    for option, codes in _options().items():
        of = "" if len(codes) == len(CODES) else f"of {', '.join(codes)}: "
        group.add_argument(f"--{option.name}", type=option.type, metavar=option.metavar, help=of + option.help)


def _options() -> dict[Option, list[str]]:
    """Return every option with the codes that have it."""
    found: dict[Option, list[str]] = {}
    for name, code in CODES.items():
        for option in (*code.needed, *code.more):
            found.setdefault(option, []).append(name)
    return found


def below_of(options: argparse.Namespace) -> TargetSpectrum | None:
    """Return the spectrum of --below, None without. Raises InputError."""
    if options.below is None:
        return None
    if options.spectrum in (None, *CODES):
        raise InputError("--below: is for a table of a floor, must be given with --spectrum FILE.csv")
    return _spectrum(options, options.below, "--below")


def target_of(options: argparse.Namespace) -> TargetSpectrum | None:
    """Return the spectrum of --spectrum, from the options of its code or a table; None without. Raises InputError."""
    return _spectrum(options, options.spectrum, "--spectrum", options.below in CODES)


def _spectrum(
    options: argparse.Namespace, name: str | None, option_of: str, is_below: bool = False
) -> TargetSpectrum | None:
    """Return the spectrum that an option names; `is_below`: the options of codes are those of --below."""
    code = CODES.get(name or "")
    if name is not None and not code and not name.lower().endswith(".csv"):
        raise InputError(f"{option_of} {name}: must be {', '.join(CODES)} or a table FILE.csv{suggestion(CODES, name)}")
    given = {}
    for option, codes in _options().items():
        value = getattr(options, option.name)
        if value is None and code and option in code.needed:
            raise InputError(f"--{option.name}: must be given with {option_of} {name}")
        if value is not None and name not in codes and not is_below:
            raise InputError(f"--{option.name} {value}: is for --spectrum {' or '.join(codes)}")
        if value is not None and option.limits is not None:
            check_number(f"--{option.name}", value, *option.limits)
        if option is AG and value is not None and not is_below:
            warn_of_ground("--ag", value)
        if value is not None and not is_below:
            given[option.argument or option.name] = value * option.factor if option.factor != 1.0 else value
    if code:
        return code.spectrum(**given)
    return None if name is None else spectrum_from_csv(name)
