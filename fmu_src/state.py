"""The whole state of an instance, as fmi2GetFMUstate takes it and as the bytes that outlive the process.

The arrays are copied as they are, whatever the solver keeps in them; the stamp tells whose they are.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.errors import InputError

FORMAT = "multiblock-fmu state 2"
_DIGEST = 64  # characters that the bytes begin with


class Stamp(NamedTuple):
    """Whose state it is: only the same column under the same code, with the same record, can go on from it."""

    column: str  # hash of the column that the FMU was built for
    code: str  # version of the project and hash of its sources


class Snapshot(NamedTuple):
    """Copies of all that an instance has behind it. Nothing may change them."""

    stamp: Stamp
    mode: str
    time: float  # s
    input_time: float  # s, from which the slopes of the inputs count
    shaken: bool  # whether the base has moved yet
    retune: bool  # whether a tunable parameter was set and has not acted yet
    inputs_stand: bool  # whether the inputs are those of the last step
    values: list[Any]  # of all variables, in the order of the table
    built_from: list[Any]  # parameters that the arrays follow from: a tunable one set since has not acted yet
    record: str  # hash of the record's samples, empty without one
    arrays: dict[str, NDArray[Any]]  # of the stepper; empty before there is one

    def check(self, stamp: Stamp) -> None:
        """Raise InputError, with the reason, if the state is not one of `stamp`."""
        if self.stamp.column != stamp.column:
            raise InputError("the state is that of another column")
        if self.stamp.code != stamp.code:
            raise InputError(f"the state was made by another version, {self.stamp.code}: must be {stamp.code}")


class Unreadable(NamedTuple):
    """What bytes turn into that are no state: the wrapper has no other way to hear of it in time."""

    reason: str


def to_bytes(snapshot: Snapshot) -> bytes:
    """Every bit of a snapshot, behind a checksum; the same snapshot gives the same bytes."""
    parts = snapshot._asdict()
    parts["arrays"] = {name: [array.dtype.str, array.tolist()] for name, array in snapshot.arrays.items()}
    content = json.dumps({"format": FORMAT, **parts}).encode()
    return hashlib.sha256(content).hexdigest().encode() + content


def from_bytes(data: bytes) -> Snapshot | Unreadable:
    """The snapshot that `to_bytes` was given."""
    content = data[_DIGEST:]
    if hashlib.sha256(content).hexdigest().encode() != data[:_DIGEST]:
        return Unreadable("the bytes are not those of a serialized state, or not all of them")
    parts = json.loads(content)
    made_by = parts.pop("format")
    if made_by != FORMAT:
        return Unreadable(f"the serialized state is of the format {made_by!r}: must be {FORMAT!r}")
    parts["stamp"] = Stamp(*parts["stamp"])
    parts["arrays"] = {name: np.array(numbers, dtype=kind) for name, (kind, numbers) in parts["arrays"].items()}
    return Snapshot(**parts)
