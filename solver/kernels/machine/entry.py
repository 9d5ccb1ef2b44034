"""Entries: functions of the kernels that Python calls, run from machine code."""

import ctypes
import struct
from collections.abc import Callable
from functools import cached_property
from typing import Any

from .kinds import ArgumentKind, Int, Real
from .library import NAMES, load

ENTRIES: dict[tuple[str, str], "Entry"] = {}  # by group and name


class Entry:
    """A kernel that Python calls. Its arguments are annotated with their kinds; it returns an int, a float or nothing.

    `function` is for the process that compiles it, `group` the piece of machine code that contains it (groups.py).
    `kinds` has the kind of each argument by name, `result` is `Int`, `Real` or None, `slots` the layout of the buffer
    of a call.
    """

    def __init__(self, function: Callable[..., Any], group: str, module: str) -> None:
        self.function, self.group = function, group
        self.__name__, self.__doc__, self.__module__ = function.__name__, function.__doc__, module
        annotations = dict(function.__annotations__)
        self.result: ArgumentKind | None = annotations.pop("return", None)
        self.kinds: dict[str, ArgumentKind] = annotations
        code = function.__code__
        given = code.co_varnames[: code.co_argcount]
        if tuple(annotations) != given or self.result not in (None, Int, Real):
            raise TypeError(f"{module}.{self.__name__}: each argument needs a kind, the result Int, Real or None")
        self._passed = tuple(kind.slots for kind in annotations.values())
        self.slots = struct.Struct("=" + "".join(kind.letters for kind in annotations.values()))

    @cached_property
    def machine_code(self) -> Callable[[int], int]:
        """The function in the machine code, which takes the address of a buffer."""
        return load(self.group)[self.__name__]

    def __call__(self, *arguments: Any) -> Any:
        """Run the kernel. Raises TypeError for arguments of another kind."""
        return Call(self, arguments)()

    def __reduce__(self) -> Any:
        """Pickle the entry by its name."""
        return _entry_named, (self.__module__, self.__name__, self.group)


def _entry_named(module: str, name: str, group: str) -> Entry:
    __import__(module)
    return ENTRIES[group, name]


class Call:
    """A call of an entry that can be repeated: the buffer of its arguments, and the arrays that it points to."""

    __slots__ = ("_address", "_arguments", "_run", "buffer", "entry")

    def __init__(self, entry: Entry, arguments: tuple[Any, ...]) -> None:
        passed = entry._passed
        if len(arguments) != len(passed):
            raise TypeError(f"{entry.__name__}: takes {len(passed)} arguments, got {len(arguments)}")
        slots: list[Any] = []
        for slots_of, argument in zip(passed, arguments, strict=True):
            slots += slots_of(argument)
        self.buffer = ctypes.create_string_buffer(entry.slots.size)
        try:
            entry.slots.pack_into(self.buffer, 0, *slots)
        except struct.error as error:
            raise TypeError(f"{entry.__name__}: {error}") from None
        self.entry, self._arguments, self._run = entry, arguments, entry.machine_code
        self._address = ctypes.addressof(self.buffer)

    def __call__(self) -> Any:
        """Run the kernel with the arguments in the buffer."""
        found, result = self._run(self._address), self.entry.result
        if result is Int:
            return found
        # a float is returned by its bits
        return None if result is None else struct.unpack("=d", struct.pack("=q", found))[0]


def offset(entry: Entry, name: str) -> int:
    """Return the offset (bytes) of an argument in the buffer of a call, at which it may be overwritten."""
    before = list(entry.kinds.values())[: list(entry.kinds).index(name)]
    return 8 * sum(len(kind.letters) for kind in before)


def entry(group: str, module: str = "") -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator of entries of a group; module: the one that a function makes them for."""

    def decorate(function: Callable[..., Any]) -> Entry:
        made = Entry(function, group, module or function.__module__)
        ENTRIES[group, made.__name__] = made
        NAMES[group].append(made.__name__)
        return made

    return decorate


def entries_of(group: str) -> list[Entry]:
    """Return the entries of a group whose module has been imported."""
    return [made for (of, _), made in ENTRIES.items() if of == group]
