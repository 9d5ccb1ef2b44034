"""Distributions of random numbers, evaluated at the quantiles that a sampling method returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..common.errors import FINITE, POSITIVE, InputError, check_number, needing, shown
from ..common.ranges import check_choice, check_keys
from ..models.protocol import FloatArray

# keys of each distribution, in the order of its arguments; and those that cut its tails
_NEEDS = {
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
    "integers": ("low", "high"),
    "triangular": ("low", "mode", "high"),
    "normal": ("mean", "deviation"),
    "lognormal": ("median", "deviation"),
    "choice": ("values",),
}
_TAILS = ("low", "high")
_BESIDE = ("relative", "each")  # further keys of a random parameter
_CAN_BE_CUT = ("normal", "lognormal")
_POSITIVE = {("loguniform", "low"), ("lognormal", "median"), ("lognormal", "low"), ("normal", "deviation")}
_POSITIVE |= {("lognormal", "deviation"), ("lognormal", "high")}
KINDS = tuple(_NEEDS)


@dataclass(frozen=True)
class Distribution:
    """A distribution by name, and its numbers by key.

    The keys are: uniform, loguniform: low, high. integers: low, high, both included. triangular: low, mode, high.
    normal: mean, deviation. lognormal: median, deviation (of the logarithm). The last two may also have low and high,
    beyond which the tails are cut off. choice: values, equally likely. Raises InputError on a wrong number.
    """

    kind: str
    numbers: tuple[tuple[str, Any], ...]

    @classmethod
    def from_table(cls, key: str, table: Mapping[str, Any]) -> Distribution:
        """Read a table such as {distribution = "normal", mean = 1.0, ...}. Raises InputError that names the key."""
        kind = check_choice(f"{key}.distribution", table.get("distribution"), KINDS)
        allowed = _NEEDS[kind] + (_TAILS if kind in _CAN_BE_CUT else ())
        check_keys(f"{key}.", [name for name in table if name != "distribution"], allowed, f" of {kind}")
        for name in _NEEDS[kind]:
            if name not in table:
                raise InputError(f"{key}.{name}: missing, {kind} needs {', '.join(_NEEDS[kind])}")
        given = {name: _value(f"{key}.{name}", kind, name, table[name]) for name in allowed if name in table}
        if "low" in given and "high" in given:
            enough = given["low"] <= given["high"] if kind == "integers" else given["low"] < given["high"]
            if not enough:
                raise InputError(f"{key}.high = {given['high']}: must be more than low = {given['low']}")
        if "mode" in given and not given["low"] <= given["mode"] <= given["high"]:
            raise InputError(f"{key}.mode = {given['mode']}: must lie between low and high")
        return cls(kind, tuple(given.items()))

    def at(self, quantile: FloatArray) -> FloatArray:
        """Return the values at the quantiles (any shape), each between 0 and 1, both excluded."""
        return _AT[self.kind](quantile, **dict(self.numbers))

    def to_table(self) -> dict[str, Any]:
        """Return the table from which `from_table` builds this distribution."""
        plain = {key: list(value) if isinstance(value, tuple) else value for key, value in self.numbers}
        return {"distribution": self.kind, **plain}


def _value(key: str, kind: str, name: str, given: object) -> Any:
    if name == "values":
        if not isinstance(given, (list, tuple)) or not given:
            raise InputError(f"{key} = {shown(given)}: must be a list of numbers")
        return tuple(check_number(f"{key}[{k}]", item, FINITE, "a number") for k, item in enumerate(given, start=1))
    limits, meaning = (POSITIVE, "a positive number") if (kind, name) in _POSITIVE else (FINITE, "a number")
    value = check_number(key, given, limits, meaning)
    if kind == "integers" and value != round(value):
        raise InputError(f"{key} = {shown(given)}: must be a whole number")
    return value


def _normal(
    quantile: FloatArray, mean: float, deviation: float, low: float = -np.inf, high: float = np.inf
) -> FloatArray:
    with needing("studies", "scipy"):
        from scipy.special import log_ndtr, ndtr, ndtri, ndtri_exp
    first, last = (low - mean) / deviation, (high - mean) / deviation
    if first <= 0.0 <= last:
        inside = ndtri(ndtr(first) + quantile * (ndtr(last) - ndtr(first)))
    else:  # one tail, mirrored to the lower one, by logarithms: probabilities may be too small for a float
        sign = 1.0 if last < 0.0 else -1.0
        near, far = (log_ndtr(sign * end) for end in (first, last))
        inside = sign * ndtri_exp(np.logaddexp(near + np.log1p(-quantile), far + np.log(quantile)))
    return np.clip(mean + deviation * inside, low, high)


def _lognormal(
    quantile: FloatArray, median: float, deviation: float, low: float = 0.0, high: float = np.inf
) -> FloatArray:
    with np.errstate(divide="ignore", over="ignore"):  # a run with an infinite number fails
        ends = np.log(low), np.log(high)
        return np.exp(_normal(quantile, float(np.log(median)), deviation, *ends))


def _triangular(quantile: FloatArray, low: float, mode: float, high: float) -> FloatArray:
    width, rise, fall = high - low, mode - low, high - mode
    up, down = low + np.sqrt(quantile * width * rise), high - np.sqrt((1.0 - quantile) * width * fall)
    return np.where(quantile * width < rise, up, down)


def _whole(quantile: FloatArray, low: float, high: float) -> FloatArray:
    return np.minimum(low + np.floor(quantile * (high - low + 1.0)), high)


def _choice(quantile: FloatArray, values: tuple[float, ...]) -> FloatArray:
    return np.array(values)[np.minimum((quantile * len(values)).astype(np.int64), len(values) - 1)]


_AT: dict[str, Callable[..., FloatArray]] = {
    "uniform": lambda quantile, low, high: low + quantile * (high - low),
    "loguniform": lambda quantile, low, high: low * (high / low) ** quantile,
    "integers": _whole,
    "triangular": _triangular,
    "normal": _normal,
    "lognormal": _lognormal,
    "choice": _choice,
}


@dataclass(frozen=True)
class Random:
    """A random parameter: its distribution, whether it multiplies the present value, whether each block has its own."""

    distribution: Distribution
    relative: bool = False
    each: bool = False

    @classmethod
    def from_table(cls, key: str, table: object) -> Random:
        """Read a table such as {distribution = ..., relative = true, each = true}. Raises InputError."""
        if not isinstance(table, Mapping):
            raise InputError(f"{key} = {shown(table)}: must be a table with distribution and its numbers")
        for name in _BESIDE:
            if not isinstance(table.get(name, False), bool):
                raise InputError(f"{key}.{name} = {shown(table[name])}: must be true or false")
        numbers = {name: value for name, value in table.items() if name not in _BESIDE}
        return cls(Distribution.from_table(key, numbers), table.get("relative", False), table.get("each", False))

    def to_table(self) -> dict[str, Any]:
        """Return the table from which `from_table` builds this parameter."""
        return {**self.distribution.to_table(), "relative": self.relative, "each": self.each}
