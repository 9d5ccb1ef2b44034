"""Tables of TOML files: checks of keys, arrays of tables, and vectors of numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import InputError, check_number, shown
from .ranges import check_keys, has_masked

PLACE = (-1e6, 1e6), "a length in m, at most 1e6 either way"


def check_table(prefix: str, table: object, known: Sequence[str]) -> None:
    """Raise InputError unless `table` is a mapping with known keys only.

    Parameters
    ----------
    prefix : str
        The key of the table and a dot, or "".
    table : object
        The table.
    known : sequence of str
        The valid keys.
    """
    if not isinstance(table, Mapping):
        raise InputError(f"{prefix.rstrip('.')} = {shown(table)}: must be a table with the keys {', '.join(known)}")
    check_keys(prefix, table, known)


def tables_in(key: str, data: Mapping[str, Any], least: int = 1) -> list[Mapping[str, Any]]:
    """Return the array of tables of a key.

    Parameters
    ----------
    key : str
        The full key; its last part is the one in `data`.
    data : mapping
        The table that holds the array.
    least : int
        The least number of tables.

    Raises
    ------
    InputError
        If there are fewer tables, or other values.
    """
    tables = data.get(key.rpartition(".")[2], [])
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables) or len(tables) < least:
        raise InputError(f"{key}: must be one table [[{key}]] for each")
    return tables


def numbers_of(
    key: str, value: object, ndim: int | None = None, meaning: str = "a list of numbers"
) -> NDArray[np.float64]:
    """Convert a value to a new array of numbers, of `ndim` axes if that is given. Raises InputError."""
    if has_masked(value):
        raise InputError(f"{key}: has gaps (masked values), must be numbers throughout")
    try:
        found = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        found = None
    if found is None or ndim not in (None, found.ndim):
        raise InputError(f"{key} = {shown(value)}: must be {'numbers' if ndim is None else meaning}")
    return found


def vector_of(
    key: str, value: object, count: int, limits: tuple[tuple[float, float], str] = PLACE, meaning: str = ""
) -> NDArray[np.float64]:
    """Convert a list to a vector of numbers.

    Parameters
    ----------
    key : str
        The key for the message.
    value : object
        The list.
    count : int
        The required length.
    limits : tuple
        The range of each number, and its meaning for the message.
    meaning : str
        The meaning of the whole list for the message.

    Returns
    -------
    ndarray of shape (count,)

    Raises
    ------
    InputError
        If it is not a list of `count` numbers in range.
    """
    if not isinstance(value, (list, tuple, np.ndarray)) or len(value) != count:
        raise InputError(f"{key} = {shown(value)}: must be {meaning or f'a list of {count} numbers'}")
    return np.array([check_number(f"{key}[{k}]", part, *limits) for k, part in enumerate(value)])
