"""Loads on the ports of a structure or column: forces and couples over time, along the axes of the base.

The contract, for every kind of model that has ports:

File. `[[port]]` has `name`, `block` (the name of one) and `at` (m, from the centroid of the block along its axes as
built; the centroid by default). Names are unique, and have none of `[ ] . = , "`.

Load. Samples (time, values) of six components, Fx Fy Fz (N) and Mx My Mz (N m), at the point, linear between samples.
The load is zero before its first and after its last sample, and so may jump at both. Its time is that of the motion of
the base; samples before the motion begins are ignored.

`simulate(..., loads=...)`: port -> `Load`, or component -> a number (constant from the start of the run to its end) or
(times, values). `release`: port -> component -> number: at the start of the run the model rests under these loads,
which are then removed. A load ends with the run: the verdict is that of the model without it.

Merging. The kernels have one grid of times: the instants of the motion and of all loads (`on_one_grid`). Samples of the
base are interpolated on that grid, linearly or held; a load has a value and a slope on each of its intervals.
`Motion.with_loads` attaches loads to a motion; a scaled motion has the same loads.

FMU. Inputs `port[k].Fx` ... `port[k].Mz` and `port[k].dFx` ... their slopes within a communication step; outputs
`port[k].x` ... `port[k].az`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..common.errors import POSITIVE, InputError, check_number, reading, shown
from ..common.ranges import check_choice
from ..common.tables import numbers_of
from ..common.text import lines_of
from ..common.text_tables import table_of, unit_in
from .records.record import FloatArray
from .records.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from .motion import Motion

COMPONENTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
IN_PLANE = ("Fx", "Fz", "My")  # components of a column in its plane
ACROSS = ("Fy", "Mx", "Mz")  # components that move a structure out of the plane x, z
LARGEST = 1e15
FORCE = (-LARGEST, LARGEST), "a finite force in N, or couple in N m"
SAME_INSTANT = 1e-6  # of the shortest interval: instants closer than this differ by rounding only
MOST_SAMPLES = 10**7

Given = Mapping[str, Any]  # by component, or a Load


@dataclass(frozen=True, eq=False)
class Load:
    """Forces and couples at a point over time.

    Attributes
    ----------
    time : ndarray of shape (m,)
        The instants (s), increasing.
    values : ndarray of shape (m, 6)
        The components (N, N m), in the order of COMPONENTS.

    Raises
    ------
    InputError
        If values are not finite or times do not increase.
    """

    time: FloatArray
    values: FloatArray

    def __post_init__(self) -> None:
        time, values = (_numbers(key, getattr(self, key)) for key in ("time", "values"))
        if time.ndim != 1 or len(time) < 2 or values.shape != (len(time), len(COMPONENTS)):
            raise InputError("load: must be 2 times at least, and 6 components for each")
        late = np.flatnonzero(np.diff(time) <= 0.0)
        if late.size:
            k = int(late[0]) + 1
            raise InputError(f"load: time[{k}] = {time[k]}: must be later than the sample before, {time[k - 1]} s")
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "values", values)

    @classmethod
    def of(cls, time: ArrayLike, **components: ArrayLike) -> Load:
        """Return the load with samples by component, as `Load.of([0, 1], Fx=[0, 1e4])`.

        Parameters
        ----------
        time : array-like of shape (m,)
            The instants (s), increasing.
        **components : array-like of shape (m,)
            The samples (N, N m) of any of COMPONENTS; the other components are zero.

        Raises
        ------
        InputError
            If a component is unknown or has another number of samples.
        """
        instants = _numbers("time", time)
        values = np.zeros((len(instants), len(COMPONENTS)))
        for name, given in components.items():
            check_choice("component", name, COMPONENTS)
            samples = _numbers(name, given)
            if samples.shape != instants.shape:
                raise InputError(f"{name}: {samples.size} samples, must be {len(instants)}, one for each time")
            values[:, COMPONENTS.index(name)] = samples
        return cls(instants, values)

    @classmethod
    def formula(cls, duration: float, step: float, start: float = 0.0, **components: Callable[[float], float]) -> Load:
        """Sample functions of time (s), as `Load.formula(2.0, 1e-3, Fx=lambda t: 1e4 * sin(9 * t))`.

        The interpolation error of a sine of the angular frequency w is at most (w step)^2 / 8 of its amplitude.

        Parameters
        ----------
        duration : float
            The duration (s).
        step : float
            The largest sampling interval (s).
        start : float
            The first instant (s).
        **components : callable
            Functions of time for any of COMPONENTS, in N or N m.

        Raises
        ------
        InputError
            If the duration or the step is out of range.
        """
        check_number("duration", duration, POSITIVE, "a positive time in s")
        time = _instants(start, duration, step)
        return cls.of(time, **{name: [function(t) for t in time.tolist()] for name, function in components.items()})

    @classmethod
    def from_motion(cls, motion: Motion, step: float | None = None, **factors: float) -> Load:
        """Return the ax of a motion (m/s2) times factors as a load, so that wavelets and harmonics serve as loads.

        Parameters
        ----------
        motion : Motion
            The motion.
        step : float, optional
            The sampling interval (s), required if the motion is harmonic or held.
        **factors : float
            The factor of each component (kg, kg m), as Fx=5000.0.

        Raises
        ------
        InputError
            If the step is missing or out of range, or a component is unknown.
        """
        if motion.amplitude or motion.hold:
            if step is None:
                raise InputError("step: missing, must be the time in s at which a harmonic or held motion is sampled")
            time = _instants(motion.start, motion.duration, step)
        else:
            time = motion.time
        ax = motion.acceleration(time)[0]
        return cls.of(time, **{name: factor * ax for name, factor in factors.items()})

    def scaled(self, factor: float) -> Load:
        """Return the load times a factor."""
        return Load(self.time, factor * self.values)

    @property
    def is_in_plane(self) -> bool:
        """True if Fy, Mx and Mz are zero: nothing moves out of the plane x, z if the port lies in it."""
        return not any(np.any(self.values[:, COMPONENTS.index(name)]) for name in ACROSS)


def _instants(start: float, duration: float, step: float) -> FloatArray:
    """Return evenly spaced instants (s), at most `step` apart. Raises InputError if the step is out of range."""
    check_number("step", step, (duration / MOST_SAMPLES, duration), "a time in s, at most the duration")
    return start + np.linspace(0.0, duration, math.ceil(duration / step - 1e-9) + 1)


def loads_from(given: Mapping[str, Load | Given], start: float, duration: float) -> dict[str, Load]:
    """Convert the argument `loads` of `simulate` to loads by port; constants last `duration` s from `start`.

    Raises InputError for unknown components, wrong samples, or components with different times.
    """
    if not isinstance(given, Mapping):
        raise InputError(f"loads = {shown(given)}: must be ports with loads, as {{'roof': {{'Fx': 1000.0}}}}")
    return {port: _load_from(f"loads[{port}]", load, start, duration) for port, load in given.items()}


def _load_from(key: str, given: Load | Given, start: float, duration: float) -> Load:
    if isinstance(given, Load):
        return given
    if not isinstance(given, Mapping) or not given:
        raise InputError(f"{key} = {shown(given)}: must be a Load, or components {', '.join(COMPONENTS)}")
    # collect (component, times, samples)
    parts: list[tuple[str, ArrayLike, ArrayLike]] = []
    for name, value in given.items():
        check_choice(f"{key}", name, COMPONENTS)
        if isinstance(value, (list, tuple)) and len(value) == 2:
            parts.append((name, value[0], value[1]))
        else:
            force = check_number(f"{key}.{name}", value, *FORCE)
            parts.append((name, np.array([start, start + duration]), np.full(2, force)))
    try:
        loads = [Load.of(time, **{name: values}) for name, time, values in parts]
    except InputError as error:
        raise InputError(f"{key}: {error}") from None
    if all(np.array_equal(load.time, loads[0].time) for load in loads):
        return Load(loads[0].time, np.sum([load.values for load in loads], axis=0))
    raise InputError(f"{key}: its components have other times, must be those of one Load, or numbers for all")


def static_loads(key: str, given: Mapping[str, Given], ports: Sequence[str]) -> FloatArray:
    """Convert constant loads by port and component to an array (6, ports).

    Parameters
    ----------
    key : str
        The key for messages.
    given : mapping
        Port -> component -> number (N, N m).
    ports : sequence of str
        The names of the ports.

    Raises
    ------
    InputError
        If a port or component is unknown, or a number is out of range.
    """
    found = np.zeros((len(COMPONENTS), len(ports)))
    if not isinstance(given, Mapping):
        raise InputError(f"{key} = {shown(given)}: must be ports with components, as {{'roof': {{'Fx': 1000.0}}}}")
    for port, components in given.items():
        p = place_of(key, port, ports)
        if not isinstance(components, Mapping):
            raise InputError(f"{key}[{port}] = {shown(components)}: must be components {', '.join(COMPONENTS)}")
        for name, value in components.items():
            check_choice(f"{key}[{port}]", name, COMPONENTS)
            found[COMPONENTS.index(name), p] = check_number(f"{key}[{port}].{name}", value, *FORCE)
    return found


def check_loads_in_plane(loads: Mapping[str, Load]) -> None:
    """Raise InputError for loads that move a column out of its plane."""
    for port, load in loads.items():
        if not load.is_in_plane:
            raise InputError(f"loads[{port}]: a column in its plane has {', '.join(IN_PLANE)} only (--space has all)")


def pattern_of(pattern: Mapping[str, float], ports: Sequence[str]) -> FloatArray:
    """Convert the loads of a push, by port.component as in {"roof.Fx": 1000.0}, to an array (6, ports).

    Raises InputError if a port or component is unknown, or all loads are zero.
    """
    if not isinstance(pattern, Mapping):
        raise InputError(f"pattern = {shown(pattern)}: must be loads on ports, as {{'roof.Fx': 1000.0}}")
    given: dict[str, dict[str, float]] = {}
    for name, value in pattern.items():
        port, _, component = str(name).rpartition(".")
        given.setdefault(port, {})[component] = value
    found = static_loads("pattern", given, ports)
    if not np.any(found):
        raise InputError("pattern: must have a load that is not zero")
    return found


def push_unit(by_loads: bool) -> tuple[float, str]:
    """Return the unit in which a push by loads, or by an acceleration of the base, is shown: its size and its name."""
    return (1.0, "times the pattern") if by_loads else (STANDARD_GRAVITY, "g")


def place_of(key: str, port: object, ports: Sequence[str]) -> int:
    """Return the index of a port by its name. Raises InputError, with `key`, if there is no such port."""
    if not ports:
        raise InputError(f"{key}[{port}]: there are no ports, must be a table [[port]] for it")
    check_choice(key, port, ports)
    return list(ports).index(str(port))


def on_one_grid(
    samples: Sequence[FloatArray], hold: bool, loads: Mapping[str, Load], ports: Sequence[str]
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Interpolate the motion of the base and all loads on one grid of times.

    Parameters
    ----------
    samples : sequence of ndarray
        The times (s), ax, ay and az (m/s2) of the base, each (m,).
    hold : bool
        Whether the accelerations are held between samples rather than linear.
    loads : mapping of str to Load
        The loads by port.
    ports : sequence of str
        The names of the ports.

    Returns
    -------
    time : ndarray of shape (k,)
        The grid (s), which may extend beyond the end of the base motion.
    ax, ay, az : ndarray
        The accelerations (m/s2) at the instants within the base motion.
    loads : ndarray of shape (2 * 6 * ports * (k - 1),)
        For each interval the values of all loads, then their slopes.

    Raises
    ------
    InputError
        If a port is unknown.
    """
    own, *accelerations = samples
    # merge the instants of the loads, without those that coincide with others but for rounding
    others = np.unique(np.concatenate([load.time for load in loads.values()]))
    shortest = min(float(np.min(np.diff(part))) for part in (own, others) if len(part) > 1)
    same = SAME_INSTANT * max(shortest, SAME_INSTANT)
    others = others[others > own[0] + same]
    others = others[np.diff(others, prepend=-math.inf) > same]
    nearest = np.minimum(np.searchsorted(own, others), len(own) - 1)
    near = np.minimum(np.abs(own[nearest] - others), np.abs(own[np.maximum(nearest - 1, 0)] - others))
    time = np.union1d(own, others[near > same])
    # accelerations on the grid
    within = time[: np.searchsorted(time, own[-1]) + 1]
    latest = np.searchsorted(own, within, side="right") - 1
    ax, ay, az = (a[latest] if hold else np.interp(within, own, a) for a in accelerations)
    # value and slope of each load on each interval in which it acts
    found = np.zeros((len(time) - 1, 2, len(COMPONENTS), len(ports)))
    middle, lengths = 0.5 * (time[1:] + time[:-1]), np.diff(time)
    for port, load in loads.items():
        p = place_of("loads", port, ports)
        acts = (load.time[0] < middle) & (middle < load.time[-1])
        values = np.column_stack([np.interp(time, load.time, value) for value in load.values.T])
        found[acts, 0, :, p] = values[:-1][acts]
        found[acts, 1, :, p] = (np.diff(values, axis=0) / lengths[:, None])[acts]
    return time, ax, ay, az, found.ravel()


def loads_by_port(given: Mapping[str, Any], folder: str | os.PathLike[str] = ".") -> dict[str, dict[str, Any]]:
    """Convert loads by PORT.COMPONENT, numbers or files in a folder (`load_from_file`), to loads by port and component.

    Raises InputError if a name is not PORT.COMPONENT, or a file is invalid.
    """
    found: dict[str, dict[str, Any]] = {}
    for name, value in given.items():
        port, dot, component = name.rpartition(".")
        if not (dot and port):
            raise InputError(f"{name}: must be PORT.COMPONENT, as roof.Fx")
        load = load_from_file(Path(folder) / value) if isinstance(value, str) else value
        found.setdefault(port, {})[component] = load
    return found


def load_from_file(path: str | os.PathLike[str]) -> tuple[FloatArray, FloatArray]:
    """Read the times (s) and values of a file of two columns, with or without a header.

    Raises InputError that begins with `path` if the file is invalid.
    """
    with reading(path):
        lines = lines_of(path)
        found = table_of(lines, () if lines[0].strip()[:1].isalpha() else ("time", "load"))
        if len(found.names) != 2 or len(found.rows) < 2:
            raise InputError("must have two columns, time (s) and load (N, N m), and two rows at least")
        for name, units in zip(found.names, (("s",), ("n", "n m", "nm")), strict=True):
            if unit_in(name) not in (None, *units):
                raise InputError(f"line 1: {shown(name)}: must be times in s and loads in N or N m")
        table = found.numbers()
        return table[:, 0], table[:, 1]


def _numbers(key: str, given: ArrayLike) -> FloatArray:
    found = numbers_of(key, given)
    if not np.all(np.abs(found) <= LARGEST):
        raise InputError(f"{key}: must be finite numbers, at most {LARGEST:g}")
    found.setflags(write=False)
    return found
