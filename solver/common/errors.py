"""Errors on the user's side, always said in one line."""

from __future__ import annotations

import math
import os
import reprlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from numbers import Integral, Real
from pathlib import Path

# Closed ranges of float64 for `check_number`.
POSITIVE = (sys.float_info.min, sys.float_info.max)
NOT_NEGATIVE = (0.0, sys.float_info.max)
FINITE = (-sys.float_info.max, sys.float_info.max)
LONGEST_WHOLE = 128  # bits of a whole number that is shown, 39 digits
LONGEST_QUOTE = 160  # letters of a message of another package


class InputError(ValueError):
    """A user's mistake: one line with the file (if any), the key, the value and what would be right."""


class InputWarning(UserWarning):
    """What is used as given and probably not meant, or is not to be relied on: one line that says why."""


class SolverError(ValueError):
    """The solver cannot go on, e.g. the step is too small: one line with the time and the reason."""


class TooMuchWorkError(SolverError):
    """A call or a run took more evaluations than any motion that can be followed: a shorter step does not help."""


def check_number(key: str, value: object, limits: tuple[float, float], meaning: str) -> float:
    """Return `value` as a float if it is a number within the closed range `limits`.

    `meaning` completes the sentence "must be ...". A bool is not a number, and neither nan nor inf is ever in range.

    Raises InputError.
    """
    low, high = limits
    number = math.nan
    if type(value) is float:  # most are, and asking what is a Real takes ten times as long
        number = value
    elif isinstance(value, Real) and not isinstance(value, bool):
        with suppress(OverflowError):  # an integer that no float64 can hold
            number = float(value)
    if not low <= number <= high:
        raise InputError(f"{key} = {shown(value)}: must be {meaning}")
    return number


def check_whole(key: str, value: object, least: int, most: float, meaning: str) -> int:
    """Return `value` if it is a whole number from `least` to `most`; `meaning` completes "must be ...".

    Raises InputError.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
        raise InputError(f"{key} = {shown(value)}: must be {meaning}")
    return int(value)


def shown(value: object) -> str:
    """Return a short repr of `value` for a one-line message; a number is shown as a user would write it."""
    if isinstance(value, Integral) and int(value).bit_length() > LONGEST_WHOLE:
        return f"a whole number of about {round(math.log10(2.0) * int(value).bit_length())} digits"
    try:
        return str(value) if isinstance(value, Real) else reprlib.repr(value)
    except ValueError:  # Python writes no whole number of more than 4300 digits, as in a list
        return f"a {type(value).__name__} of long numbers"


def shortened(error: BaseException) -> str:
    """Return the first line of what another package says, cut: it may quote a whole file."""
    text = str(error).partition("\n")[0]
    return text if len(text) <= LONGEST_QUOTE else f"{text[:LONGEST_QUOTE]} ..."


@contextmanager
def needing(extra: str, *packages: str) -> Iterator[None]:
    """Turn the absence of one of `packages` into an InputError that says how to install `extra`, which has them."""
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in packages:
            raise
        raise InputError(f"{package} is not installed: {_how_to_install(extra)}") from error


def _how_to_install(extra: str) -> str:
    """The command that installs it: in a checkout, or where the project has been installed without one."""
    root = Path(__file__).resolve().parents[2]
    if not (root / "pyproject.toml").is_file():
        return f'pip install "multiblock-fmu[{extra}]"'
    return f'pip install -e "{"." if root == Path.cwd() else root}[{extra}]"'


@contextmanager
def reading(path: str | os.PathLike[str]) -> Iterator[None]:
    """Turn whatever is wrong with a user's file, or with reaching it, into an InputError that begins with `path`."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text (byte {error.start}: {error.reason})") from error
    except ValueError as error:  # InputError, and what the parsers of the standard library raise
        raise InputError(f"{path}: {error}") from error
