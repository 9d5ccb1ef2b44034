"""The kinds of arguments of entries, which annotate them: how Python passes each in the buffer of a call.

A call passes one address: of a buffer with slots of eight bytes, one for each argument, two for `SizedReals`; where
kernels check their bounds (bounds.py), two for every array: its address and its size.
"""

import ctypes
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from .bounds import BOUNDS

_FLOAT, _WHOLE = np.dtype(np.float64), np.dtype(np.int64)
_first_byte, _address = ctypes.c_char.from_buffer, ctypes.addressof


class ArgumentKind:
    """A way to pass an argument: its letters for `struct`, and the values of its slots."""

    letters: ClassVar[str]

    @staticmethod
    def slots(value: Any) -> tuple[Any, ...]:
        """Return the values of the slots. Raises TypeError."""
        raise NotImplementedError


class _Int(ArgumentKind):
    """An int64."""

    letters = "q"

    @staticmethod
    def slots(value: Any) -> tuple[Any, ...]:
        """Return the number."""
        return (value,)


class _Real(ArgumentKind):
    """A float64."""

    letters = "d"

    @staticmethod
    def slots(value: Any) -> tuple[Any, ...]:
        """Return the number."""
        return (value,)


def address_of(array: Any, kind: np.dtype[Any] = _FLOAT) -> int:
    """Return the address of the first number of an array. Raises TypeError for another dtype, and for gaps.

    Nothing else checks the memory there: numbers of another type would be read as of this one.
    """
    # the identity is compared first: it is faster
    if array.dtype is not kind and array.dtype != kind:
        raise TypeError(f"an array of {array.dtype}: must be of {kind}")
    # a kernel addresses the numbers one after the other
    if not array.flags.c_contiguous:
        raise TypeError(f"an array of shape {array.shape} with gaps: must be contiguous")
    try:
        return _address(_first_byte(array))
    except (TypeError, ValueError):  # empty, or not to be written to
        return int(array.ctypes.data)


class _Reals(ArgumentKind):
    """The address of an array of float64."""

    letters = "qq" if BOUNDS else "q"

    @staticmethod
    def slots(value: Any) -> tuple[Any, ...]:
        """Return the address, and the size where bounds are checked. Raises TypeError."""
        return (address_of(value), value.size) if BOUNDS else (address_of(value),)


class _Ints(ArgumentKind):
    """The address of an array of int64."""

    letters = "qq" if BOUNDS else "q"

    @staticmethod
    def slots(value: Any) -> tuple[Any, ...]:
        """Return the address, and the size where bounds are checked. Raises TypeError."""
        return (address_of(value, _WHOLE), value.size) if BOUNDS else (address_of(value, _WHOLE),)


class _SizedReals(ArgumentKind):
    """The address of an array of float64, and its size."""

    letters = "qq"

    @staticmethod
    def slots(value: Any) -> tuple[Any, ...]:
        """Return the address and the size. Raises TypeError."""
        return address_of(value), value.size


if TYPE_CHECKING:  # kernels are typed by numba
    Int = Any
    Ints = Any
    Real = Any
    Reals = Any
    SizedReals = Any
else:
    Int, Ints, Real, Reals, SizedReals = _Int, _Ints, _Real, _Reals, _SizedReals
