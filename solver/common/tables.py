"""Tables of TOML files: their keys, lists of them, and lists of numbers in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import InputError, check_number, shown
from .ranges import check_keys

PLACE = (-1e6, 1e6), "a length in m, at most 1e6 either way"


def check_table(prefix: str, table: object, known: Sequence[str]) -> None:
    """Raise InputError unless it is a table with none but these keys; prefix: its key and a dot, or nothing."""
    if not isinstance(table, Mapping):
        raise InputError(f"{prefix.rstrip('.')} = {shown(table)}: must be a table with the keys {', '.join(known)}")
    check_keys(prefix, table, known)


def tables_in(key: str, data: Mapping[str, Any], least: int = 1) -> list[Mapping[str, Any]]:
    """The tables of a key, whose last word is that in `data`; at least as many. Raises InputError."""
    tables = data.get(key.rpartition(".")[2], [])
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables) or len(tables) < least:
        raise InputError(f"{key}: must be one table [[{key}]] for each")
    return tables


def vector_of(
    key: str, value: object, count: int, limits: tuple[tuple[float, float], str] = PLACE, meaning: str = ""
) -> NDArray[np.float64]:
    """Numbers of a list, (count,); limits: of each, and what that is; meaning: of all. Raises InputError."""
    if not isinstance(value, (list, tuple, np.ndarray)) or len(value) != count:
        raise InputError(f"{key} = {shown(value)}: must be {meaning or f'a list of {count} numbers'}")
    return np.array([check_number(f"{key}[{k}]", part, *limits) for k, part in enumerate(value)])
