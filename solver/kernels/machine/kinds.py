"""The kinds of arguments of entries, which annotate them: how Python passes each in the buffer of a call.

A call passes one address: of a buffer with slots of eight bytes, one for each argument, two for `SizedReals`; where
kernels check their bounds (bounds.py), two for every array: its address and its size.
"""

import ctypes
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .bounds import BOUNDS

_FLOAT, _WHOLE = np.dtype(np.float64), np.dtype(np.int64)
_first_byte, _address = ctypes.c_char.from_buffer, ctypes.addressof


class ArgumentKind(NamedTuple):
    """A way to pass an argument: its letters for `struct`, and a function that returns the values of its slots."""

    name: str  # kinds may be passed alike
    letters: str
    slots: Callable[[Any], tuple[Any, ...]]  # raises TypeError


def _number(value: Any) -> tuple[Any, ...]:
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


def _sized(array: Any) -> tuple[Any, ...]:
    return address_of(array), array.size


def _sized_whole(array: Any) -> tuple[Any, ...]:
    return address_of(array, _WHOLE), array.size


def _without_size(array: Any) -> tuple[Any, ...]:
    return (address_of(array),)


def _whole_without_size(array: Any) -> tuple[Any, ...]:
    return (address_of(array, _WHOLE),)


if TYPE_CHECKING:  # kernels are typed by numba
    Int = Any
    Ints = Any
    Real = Any
    Reals = Any
    SizedReals = Any
else:
    letters, reals, ints = ("qq", _sized, _sized_whole) if BOUNDS else ("q", _without_size, _whole_without_size)
    Int, Real = ArgumentKind("an int64", "q", _number), ArgumentKind("a float64", "d", _number)
    Ints, Reals = ArgumentKind("int64s", letters, ints), ArgumentKind("float64s", letters, reals)
    SizedReals = ArgumentKind("float64s and their number", "qq", _sized)
