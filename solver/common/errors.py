"""User errors, each reported in one line."""

from __future__ import annotations

import math
import os
import reprlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from numbers import Integral, Real
from pathlib import Path
from typing import Any

# Closed ranges of float64 for `check_number`.
POSITIVE = (sys.float_info.min, sys.float_info.max)
NOT_NEGATIVE = (0.0, sys.float_info.max)
FINITE = (-sys.float_info.max, sys.float_info.max)
LONGEST_WHOLE = 128  # bits of the largest integer that is shown in full, 39 digits
LONGEST_QUOTE = 160  # characters quoted of another package's message


class InputError(ValueError):
    """A user's mistake: one line with the file (if any), the key, the value and the valid values."""


class UnknownKeyError(InputError):
    """A key that a table cannot have, or a name of what a model does not have."""


class InputWarning(UserWarning):
    """A value that is used as given but is probably unintended or unreliable: one line that gives the reason."""


class SolverError(ValueError):
    """A failure of the solver, such as a step that is too small: one line with the time and the reason."""


class TooMuchWorkError(SolverError):
    """An excess of evaluations, beyond any motion that can be followed; a shorter step does not help."""


def check_number(key: str, value: object, limits: tuple[float, float], meaning: str) -> float:
    """Return `value` as a float if it is a number within the closed range `limits`.

    A bool is not a number, and neither NaN nor inf is ever in range.

    Parameters
    ----------
    key : str
        The key for the message.
    value : object
        The value to check.
    limits : tuple of float
        The least and the largest valid number.
    meaning : str
        The end of the message "must be ...".

    Raises
    ------
    InputError
        If `value` is not a number in the range.
    """
    low, high = limits
    number = math.nan
    if type(value) is float:  # the fast path: isinstance(value, Real) takes ten times as long
        number = value
    elif isinstance(value, Real) and not isinstance(value, bool):
        with suppress(OverflowError):  # an integer that no float64 can hold
            number = float(value)
    if not low <= number <= high:
        raise InputError(f"{key} = {shown(value)}: must be {meaning}")
    return number


def check_type(key: str, value: object, *types: Any) -> None:
    """Raise InputError unless `value` is an instance of one of `types`, classes or None."""
    classes = tuple(type(None) if one is None else one for one in types)
    if not isinstance(value, classes):
        names = " or ".join("None" if one is None else one.__name__ for one in types)
        raise InputError(f"{key} = {shown(value)}: must be of type {names}")


def whole(value: object) -> object:
    """Return a float without a fraction as an int, for `check_whole`; any other value as it is."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def check_whole(key: str, value: object, least: int, most: float, meaning: str) -> int:
    """Return `value` as an int if it is an integer in a range.

    Parameters
    ----------
    key : str
        The key for the message.
    value : object
        The value to check; a bool is refused.
    least, most : int, float
        The least and the largest valid integer; `most` may be inf.
    meaning : str
        The end of the message "must be ...".

    Raises
    ------
    InputError
        If `value` is not an integer in the range.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
        raise InputError(f"{key} = {shown(value)}: must be {meaning}")
    return int(value)


def shown(value: object) -> str:
    """Return a short repr of `value` for a one-line message; a number as a user would write it."""
    if isinstance(value, Integral) and int(value).bit_length() > LONGEST_WHOLE:
        return f"a whole number of about {round(math.log10(2.0) * int(value).bit_length())} digits"
    try:
        return str(value) if isinstance(value, Real) else reprlib.repr(value)
    except ValueError:  # Python writes no whole number of more than 4300 digits, as in a list
        return f"a {type(value).__name__} of long numbers"


def shortened(error: BaseException) -> str:
    """Return the first line of another package's message, truncated: it may quote a whole file."""
    text = str(error).partition("\n")[0]
    return text if len(text) <= LONGEST_QUOTE else f"{text[:LONGEST_QUOTE]} ..."


@contextmanager
def needing(extra: str, *packages: str) -> Iterator[None]:
    """Convert the ModuleNotFoundError of one of `packages` to an InputError with the command that installs `extra`."""
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in packages:
            raise
        raise InputError(f"{package} is not installed: {_how_to_install(extra)}") from error


def _how_to_install(extra: str) -> str:
    """Return the command that installs an extra: editable in a checkout, from the index otherwise."""
    root = Path(__file__).resolve().parents[2]
    if not (root / "pyproject.toml").is_file():
        return f'pip install "multiblock-fmu[{extra}]"'
    return f'pip install -e "{"." if root == Path.cwd() else root}[{extra}]"'


@contextmanager
def reading(path: str | os.PathLike[str]) -> Iterator[None]:
    """Convert any error of a user's file, or of access to it, to an InputError that begins with `path`."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text (byte {error.start}: {error.reason})") from error
    except ValueError as error:  # InputError, and what the parsers of the standard library raise
        raise InputError(f"{path}: {error}") from error
