"""Old names of results: each still works in this version, with a warning that gives the new name.

`Alias` is an old attribute, `Renamed` a mapping with old keys; `aliases_of` lists the old attributes of a class, from
which the site makes its table of names. Names in files (CSV, FMUs, studies) do not change.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from operator import attrgetter
from typing import Any, TypeVar

Value = TypeVar("Value")


class Alias:
    """An attribute under its old name; `get` returns the old value of an object, by default that of `new`."""

    def __init__(self, new: str, get: Callable[[Any], Any] | None = None) -> None:
        self.new, self._get = new, get or attrgetter(new)
        self.__doc__ = f"The old name of `{new}`."

    def __set_name__(self, owner: type, name: str) -> None:
        self.old = name

    def __get__(self, instance: Any, owner: Any = None) -> Any:
        if instance is None:
            return self
        warn_of_old(type(instance).__name__, self.old, self.new)
        return self._get(instance)


class Renamed(dict[str, Value]):
    """A dictionary whose old keys still work.

    Parameters
    ----------
    values : mapping
        The values by their new keys.
    old : mapping of str to str
        The new keys by the old ones.
    name : str
        The name of the dictionary in the warning.
    """

    def __init__(self, values: Mapping[str, Value], old: Mapping[str, str], name: str) -> None:
        super().__init__(values)
        self._old, self._name = dict(old), name

    def __missing__(self, key: str) -> Value:
        new = self._old.get(key)
        if new is None or new not in self.keys():
            raise KeyError(key)
        warn_of_old(self._name, key, new)
        return self[new]

    def __contains__(self, key: object) -> bool:
        return key in self.keys() or self._old.get(str(key)) in self.keys()

    def get(self, key: str, default: Any = None) -> Any:
        """Return the value of a new or an old key, or `default`."""
        try:
            return self[key]
        except KeyError:
            return default


def warn_of_old(of: str, old: str, new: str, level: int = 3) -> None:
    """Warn (DeprecationWarning) of an old name; `level` is that of the caller, as in `warnings.warn`."""
    warnings.warn(f"{of}: {old} is an old name, use {new}", DeprecationWarning, stacklevel=level)


def aliases_of(owner: type) -> Mapping[str, str]:
    """Return the new names of the attributes of a class by their old names."""
    found = ((name, value) for kind in reversed(owner.__mro__) for name, value in vars(kind).items())
    return {name: value.new for name, value in found if isinstance(value, Alias)}
