"""The complete state of an instance, for fmi2GetFMUstate and as bytes that outlive the process.

The arrays are copied unchanged, whatever the solver stores in them; the stamp identifies their FMU.
"""

from __future__ import annotations

import hashlib
import json
import math
from enum import StrEnum
from typing import Any, NamedTuple, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from solver.common.errors import InputError

from .state_ranges import MOST_TIME, Ranges
from .variables import RECORD_PGA, Variable

FORMAT = "multiblock-fmu state 3"
KINDS = ("<f8", "<i8")  # of arrays
# kind of variable -> types of its values; integers within those of C
TYPES = {"Real": (float, int), "Integer": (int,), "Enumeration": (int,), "Boolean": (bool,), "String": (str,)}
INTEGERS = 2**31
_DIGEST = 64  # characters of the checksum before the content


class Mode(StrEnum):
    """The phase of life of an instance."""

    INSTANTIATED = "instantiated"
    INITIALIZATION = "initialization"
    STEPPING = "stepping"
    TERMINATED = "terminated"


class Stamp(NamedTuple):
    """The owner of a state: only the same column under the same code, with the same record, can continue from it."""

    column: str  # hash of the column or structure that the FMU was built for
    code: str  # version of the project and hash of its sources


class Snapshot(NamedTuple):
    """A copy of the state of an instance, which must not be modified."""

    stamp: Stamp
    mode: str
    time: float  # s
    input_time: float  # s, from which the slopes of the inputs count
    shaken: bool  # True if the base has moved
    retune: bool  # True if a tunable parameter was set and not yet applied
    inputs_stand: bool  # True if the inputs are those of the last step
    tolerance_set: bool  # True if the master set the solver's tolerance
    values: list[Any]  # of all variables, in the order of the table
    built_from: list[Any]  # parameters of the arrays, without a tunable one not yet applied
    record: str  # hash of the record's samples, empty without one
    arrays: dict[str, NDArray[Any]]  # of the stepper; empty before there is one

    def copy_to(self, stepper: Any) -> None:
        """Copy the arrays to those of a stepper."""
        for name, array in self.arrays.items():
            getattr(stepper.arrays, name)[:] = array

    def check(self, stamp: Stamp) -> None:
        """Raise InputError, with the reason, if the state does not belong to `stamp`."""
        if self.stamp.column != stamp.column:
            raise InputError("the state is that of another column or structure")
        if self.stamp.code != stamp.code:
            raise InputError(f"the state was made by another version, {self.stamp.code}: must be {stamp.code}")

    def check_contents(
        self,
        table: list[Variable],
        arrays: dict[str, NDArray[Any]],
        ranges: Ranges | None,
        segment: int | None,
        samples: int,
    ) -> None:
        """Raise ValueError, with the reason, unless an instance can be in this state; bytes can hold anything.

        `arrays` are those of the stepper, empty without one, with the `ranges` of their numbers. `segment` is the index
        in `base` of the number of a sample of the record, which has `samples` of them.
        """
        _check_values(self.values, table)
        for value, variable in zip(self.values, table, strict=True):
            stepped_with = variable.causality == "input" and self.inputs_stand
            kept = variable.causality == "output" and not arrays  # otherwise it is computed again
            seen = stepped_with or kept or variable.name == RECORD_PGA.name
            if seen and isinstance(value, float) and not math.isfinite(value):
                raise InputError(f"{variable.name} = {value}: must be a finite number")
        _check_values(self.built_from, table[len(table) - len(self.built_from) :])
        kinds = {name: (array.dtype, array.shape) for name, array in self.arrays.items()}
        if kinds != {name: (array.dtype, array.shape) for name, array in arrays.items()}:
            raise InputError("its arrays are not those of this FMU")
        if self.mode == Mode.STEPPING and not arrays:
            raise InputError("it has no motion")
        if ranges is None:
            return
        for name, array in self.arrays.items():
            ranges.check(name, array, self.inputs_stand)
        if segment is not None and self.arrays["base"][segment] > samples:
            raise InputError("its sample is beyond the end of the record")


def _check_values(values: list[Any], table: list[Variable]) -> None:
    """Raise InputError unless the values fit the variables, and pass through the wrapper."""
    if len(values) != len(table):
        raise InputError(f"{len(values)} variables: must be {len(table)}")
    for value, variable in zip(values, table, strict=True):
        if type(value) not in TYPES[variable.kind] or (type(value) is int and not -INTEGERS <= value < INTEGERS):
            raise InputError(f"{variable.name} = {value!r:.50}: must be a {variable.kind}")
        if isinstance(value, str):
            value.encode()  # to the UTF-8 of the interface: a UnicodeError is a ValueError


class Unreadable(NamedTuple):
    """A placeholder for bytes that are no state: the wrapper has no other way to report them in time."""

    reason: str


def to_bytes(snapshot: Snapshot | Unreadable) -> bytes:
    """Serialize every bit of a snapshot, preceded by a checksum; the same snapshot gives the same bytes.

    The result is empty for `Unreadable`. Never raises: the wrapper would follow a null pointer.
    """
    try:
        parts = snapshot._asdict()
        parts["arrays"] = {name: [array.dtype.str, array.tolist()] for name, array in parts["arrays"].items()}
        content = json.dumps({"format": FORMAT, **parts}).encode()
        return hashlib.sha256(content).hexdigest().encode() + content
    except Exception:  # native/guard.c makes an Error of the empty bytes
        return b""


def from_bytes(data: bytes) -> Snapshot | Unreadable:
    """Return the snapshot serialized by `to_bytes`, or `Unreadable`.

    Never raises: an exception would damage the wrapper's Python state.
    """
    try:
        content = data[_DIGEST:]
        if hashlib.sha256(content).hexdigest().encode() != data[:_DIGEST]:
            return Unreadable("the bytes are not those of a serialized state, or not all of them")
        parts = json.loads(content)
        made_by = parts.pop("format")
        if made_by != FORMAT:
            return Unreadable(f"the serialized state is of the format {made_by!r}: must be {FORMAT!r}")
        parts["stamp"] = Stamp(*parts["stamp"])
        parts["arrays"] = {name: _array(*array) for name, array in parts["arrays"].items()}
        return _checked(Snapshot(**parts))
    except Exception as error:  # any JSON may stand in the place of a state, at any depth
        return Unreadable(f"the bytes hold no state: {error!r:.200}")


def _array(kind: str, numbers: list[float]) -> NDArray[Any]:
    """Return one array of the stepper. Raises ValueError."""
    if kind not in KINDS or not isinstance(numbers, list) or not {*map(type, numbers)} <= {int, float}:
        raise ValueError(f"an array of the kind {kind!r:.20}")
    return np.array(numbers, dtype=kind)


def _checked(snapshot: Snapshot) -> Snapshot:
    """Return the snapshot, after checking the types of its fields. Raises ValueError."""
    for name, kind in get_type_hints(Snapshot).items():
        if name not in ("stamp", "arrays") and type(getattr(snapshot, name)) is not (get_origin(kind) or kind):
            raise ValueError(f"{name} is of another kind")
    if snapshot.mode not in set(Mode) or not all(isinstance(part, str) for part in snapshot.stamp):
        raise ValueError("mode or stamp are none")
    if not (abs(snapshot.time) <= MOST_TIME and abs(snapshot.input_time) <= MOST_TIME):
        raise ValueError("a time that is out of range")
    return snapshot
