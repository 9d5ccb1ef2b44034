"""The friction needed to prevent sliding in a response; a joint without `friction` never slides.

N vanishes where a joint is about to open, and in flight the model still keeps the blocks in line: T / N has no meaning
there. So it counts only where N is more than a part of the weight that the joint carries at rest.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ...common.errors import NOT_NEGATIVE, InputError, check_number
from ...kernels.layout.spaces import COUNTS_FROM
from .model import Column
from .packing import FloatArray, carried_weights


class Sheared(Protocol):
    """The fields needed of a Response, whose module is above this one."""

    @property
    def column(self) -> Column: ...
    @property
    def time(self) -> FloatArray: ...
    @property
    def T(self) -> FloatArray: ...  # noqa: N802
    @property
    def N(self) -> FloatArray: ...  # noqa: N802


def friction_history(T: FloatArray, N: FloatArray, carried: FloatArray, part: float = COUNTS_FROM) -> FloatArray:
    """|T| / N where N > part * carried, else 0, (nt, n).

    T, N: forces of the joints, N (nt, n). carried: weight that each joint carries at rest, N (n,).

    Raises InputError unless part is from 0.001 to 1 and every joint carries something.
    """
    part = check_number("part", part, (1e-3, 1.0), "a part of the weight carried at rest, from 0.001 to 1")
    if not np.all(carried > 0.0):
        raise InputError("g = 0.0: must be positive for joints that carry a weight at rest")
    ratio: FloatArray = np.where(part * carried < N, np.abs(T) / np.maximum(N, part * carried), 0.0)
    return ratio


def friction_demand(response: Sheared, part: float = COUNTS_FROM) -> FloatArray:
    """Largest `friction_history` of each joint over the rows, (n,): least friction that prevents sliding.

    Raises InputError as `friction_history` does.
    """
    largest: FloatArray = np.max(_history(response, part), axis=0)
    return largest


def time_exceeded(response: Sheared, mu: float, part: float = COUNTS_FROM) -> FloatArray:
    """Time for which each joint needs more friction than mu, s (n,); the history is linear between rows.

    Raises InputError unless mu is zero or positive, and as `friction_history` does.
    """
    mu = check_number("mu", mu, NOT_NEGATIVE, "a coefficient of friction, zero or positive")
    over = _history(response, part) - mu
    first, last = over[:-1], over[1:]
    change = np.abs(last - first)
    crossing = np.divide(np.maximum(first, last), change, out=np.zeros_like(change), where=change > 0.0)
    share = np.where(np.minimum(first, last) > 0.0, 1.0, np.where(np.maximum(first, last) > 0.0, crossing, 0.0))
    exceeded: FloatArray = np.diff(response.time) @ share
    return exceeded


def _history(response: Sheared, part: float) -> FloatArray:
    return friction_history(response.T, response.N, carried_weights(response.column), part)
