"""Valid ranges of numbers and choices of words, by key, with the messages for invalid ones."""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Collection, Iterable, Mapping

from .errors import InputError, UnknownKeyError, check_number, shown

MAX_BLOCKS = 1000

# The range of each numeric key, in whichever table: far beyond any building, but so narrow that no quantity derived
# from it leaves the range of float64.
LENGTH = ((1e-6, 1e6), "a positive length in m, from 1e-6 to 1e6")
NUMBERS: dict[str, tuple[tuple[float, float], str]] = {
    "g": ((0.0, 1e6), "an acceleration in m/s2, zero or positive, at most 1e6"),
    **dict.fromkeys(("height", "width", "depth", "top_width", "top_depth"), LENGTH),
    **dict.fromkeys(("diameter", "top_diameter", "bore"), LENGTH),
    "above": ((0.0, 1e6), "a height in m, zero or positive, at most 1e6"),
    "mass": ((1e-9, 1e15), "a positive mass in kg, from 1e-9 to 1e15"),
    "density": ((1e-6, 1e9), "a positive density in kg/m3, from 1e-6 to 1e9"),
    "centroid": LENGTH,
    "inertia": ((1e-21, 1e27), "a positive moment of inertia in kg m2, from 1e-21 to 1e27"),
    "stiffness": ((1e-3, 1e20), "a positive Winkler modulus in N/m3, from 1e-3 to 1e20"),
    "damping": ((0.0, 1e6), "a time in s, zero or positive, at most 1e6"),
    "friction": (
        (1e-6, 1e3),
        "a positive coefficient of friction, from 1e-6 to 1e3; without it the joint never slides",
    ),
    "dowel": ((0.0, 1e15), "a force in N, zero or positive, at most 1e15"),
    "strength": ((1.0, 1e15), "a positive pressure in Pa, from 1 to 1e15"),
    "tensile_strength": ((0.0, 1e12), "a tension in Pa, zero or positive"),
    "cohesion": ((0.0, 1e12), "a shear stress in Pa, zero or positive"),
    "rim": (LENGTH[0], "a positive length in m, from 1e-6 to 1e6: the band along the edges in which faces touch"),
    "offset": ((-1e6, 1e6), "a length in m, positive to +x, at most 1e6 either way"),
    "inclination": ((-0.5, 0.5), "an angle in rad, clockwise, from -0.5 to 0.5"),
    "tilt": ((-0.5, 0.5), "an angle in rad, clockwise, from -0.5 to 0.5"),
    "step": ((1e-9, 1e6), "a positive time in s, from 1e-9 to 1e6"),
    "tolerance": ((1e-13, 0.1), "a number from 1e-13 to 0.1"),
}


def lengths_in(table: Mapping[str, tuple[tuple[float, float], str]]) -> frozenset[str]:
    """Return the keys of a table of ranges whose meaning is a quantity in m."""
    return frozenset(key for key, (_, meaning) in table.items() if re.search(r" in m(?![\w/])", meaning))


def check(key: str, value: object) -> float:
    """Return `value` as a float if it is in the range of the last part of `key`. Raises InputError otherwise."""
    limits, meaning = NUMBERS[key.rpartition(".")[2]]
    return check_number(key, value, limits, meaning)


def check_choice(key: str, value: object, known: Collection[str]) -> str:
    """Return `value` if it is one of the `known` names. Raises InputError otherwise."""
    if not isinstance(value, str) or value not in known:
        raise InputError(f"{key} = {shown(value)}: must be one of {listed(known, value)}")
    return value


def check_keys(prefix: str, table: Iterable[str], known: Collection[str], of: str = "") -> None:
    """Raise UnknownKeyError for the first key of a table that is not among the known ones.

    Parameters
    ----------
    prefix : str
        The begin of the message.
    table : iterable of str
        The keys.
    known : collection of str
        The valid keys.
    of : str
        The words after "unknown key", such as " of ...".
    """
    for key in table:
        if key not in known:
            written = repr(key).strip("'\"")  # a quoted key of TOML may hold anything, even a line break
            raise UnknownKeyError(f"{prefix}{written}: unknown key{of}, must be one of {listed(known, key)}")


def listed(known: Collection[str], value: object) -> str:
    """Return the known names as a list and, if one is similar to `value`, a suggestion."""
    return ", ".join(known) + suggestion(known, value)


def suggestion(known: Collection[str], value: object) -> str:
    """Return "; did you mean ...?" with the known name most similar to `value` in any case; "" if none is."""
    written = {name.lower(): name for name in known}
    near = difflib.get_close_matches(value.lower() if isinstance(value, str) else "", written, n=1, cutoff=0.5)
    return f"; did you mean {written[near[0]]}?" if near else ""


def has_masked(values: object) -> bool:
    """Return True if an array has masked elements; numpy.ma, which takes long to import, is there if one exists."""
    masked = sys.modules.get("numpy.ma")
    return masked is not None and isinstance(values, masked.MaskedArray) and bool(masked.is_masked(values))
