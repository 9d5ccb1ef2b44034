"""The motion of a floor of a building, from that of the ground and the modes of the building.

Along each horizontal axis, theory in docs/floor.md: a_floor = a_ground + sum over modes of x (acceleration relative to
the ground), with x = participation times shape at the floor. What the modes leave out moves with the ground.

The modes are those of a table, or of a bending and a shear beam side by side with evenly spread mass: Miranda and
Taghavi (2005), Approximate floor acceleration demands in multistory buildings I, J. Struct. Eng. ASCE 131 (2), 203-211.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..common.errors import InputError, check_number, check_type, check_whole, reading, shown
from ..common.files import toml_of
from ..common.ranges import LENGTH, check_keys
from ..common.tables import tables_in, vector_of
from . import oscillator
from .intensity import MOST_LINES, divided, lines_of
from .motion import Motion
from .records.record import FloatArray

PERIOD = (1e-3, 100.0), "a period in s, from 0.001 to 100"
DAMPING = (0.0, 0.99), "a part of critical, from 0 to 0.99"
ALPHA = (0.0, 500.0), "a number from 0, bending alone, to 500, shear alone"
FACTOR = (-1e3, 1e3), "a number, participation times shape"
MOST_STOREYS = 500
MOST_MODES = 10  # of a beam
RIGID = 0.02  # s: modes of shorter periods move with the ground
PER_PERIOD = 20  # samples of a floor per period of its shortest mode; straight lines cut its crests by 1.2 % at most
FADED, LONGEST_TAIL = 0.01, 60.0  # the motion goes on until all modes have decayed to that part, at most that long (s)
DROP = 1e-3  # of an interval: the time in which the ground stops at its end
USUAL_DAMPING = 0.05
OF_BEAM = ("name", "height", "storeys", "period", "period_y", "damping", "alpha", "alpha_y")
BEAM_NEEDS = ("storeys", "period", "alpha")
OF_MODES, OF_MODE = ("name", "mode"), ("period", "damping", "x", "y")


@dataclass(frozen=True)
class BuildingMode:
    """A mode of a building along one horizontal axis."""

    period: float  # s
    damping: float  # of critical
    factors: tuple[float, ...]  # participation times shape, at each floor from the first above the ground to the top


@dataclass(frozen=True)
class Building:
    """The modes of a building along x and along y, by `from_toml`, `from_dict` or `beam`."""

    name: str
    along_x: tuple[BuildingMode, ...]
    along_y: tuple[BuildingMode, ...]
    height: float | None = None  # m, of storeys of equal height

    @property
    def storeys(self) -> int:
        """The number of storeys: of floors above the ground."""
        return len(self.along_x[0].factors)

    @property
    def periods(self) -> tuple[float, float]:
        """The first periods along x and y (s)."""
        first, second = (max(mode.period for mode in modes) for modes in (self.along_x, self.along_y))
        return first, second

    def across(self) -> Building:
        """Return the building with its axes x and y exchanged, NAME across."""
        return replace(self, name=f"{self.name} across", along_x=self.along_y, along_y=self.along_x)

    def words(self, floor: int) -> str:
        """Return a floor in words, with the first period. Raises InputError if there is no such floor."""
        of = f"floor {self.checked(floor)} of {self.storeys} of {self.name}"
        if self.height is not None:
            of += f", {floor / self.storeys * self.height:.3g} m above the ground"
        first, second = (f"{period:.3g} s" for period in self.periods)
        return f"{of}, first period {first}" + ("" if first == second else f" along x, {second} along y")

    def checked(self, floor: object, key: str = "floor") -> int:
        """Return the number of a floor, 0 for the ground. Raises InputError, with `key`, if there is no such floor."""
        words = f"a whole number from 0, the ground, to {self.storeys}, the top of {self.name}"
        return check_whole(key, floor, 0, self.storeys, words)

    def to_dict(self) -> dict[str, Any]:
        """Return all data on which results depend."""
        return asdict(self)

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Building:
        """Read the file of a building (docs/floor.md). Raises InputError that begins with `path`."""
        with reading(path):
            return cls.from_dict(toml_of(path), Path(path).stem)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], name: str = "the building") -> Building:
        """Build it from the mapping that a TOML file holds, by default named `name`. Raises InputError."""
        check_keys("", data, ("building",))
        table = data.get("building")
        if not isinstance(table, Mapping):
            raise InputError("building: missing, must be a table [building]")
        name = table.get("name", name)
        if not isinstance(name, str) or not name.isprintable() or not name:
            raise InputError(f"building.name = {shown(name)}: must be a text")
        if "mode" in table:
            check_keys("building.", table, OF_MODES, " of a building by modes")
            return _by_modes(name, tables_in("building.mode", table))
        check_keys("building.", table, OF_BEAM)
        for key in BEAM_NEEDS:
            if key not in table:
                raise InputError(f"building.{key}: missing, must be given, or a table [[building.mode]] for each mode")
        return cls.beam(**{**table, "name": name})

    @classmethod
    def beam(
        cls,
        storeys: int,
        period: float,
        alpha: float,
        *,
        period_y: float | None = None,
        alpha_y: float | None = None,
        damping: float = USUAL_DAMPING,
        height: float | None = None,
        name: str = "the building",
    ) -> Building:
        """Return a building as a bending and a shear beam side by side, with storeys of equal height and mass.

        Parameters
        ----------
        storeys : int
            The number of storeys.
        period : float
            The first period along x (s).
        alpha : float
            The height times the root of the shear stiffness over the bending stiffness.
        period_y, alpha_y : float, optional
            The same along y; by default as along x.
        damping : float
            The damping ratio of all modes.
        height : float, optional
            The height (m), with which messages say how high a floor is.
        name : str
            The name.

        Raises
        ------
        InputError
            If a value is wrong.
        """
        words = f"a whole number from 1 to {MOST_STOREYS}"
        storeys = check_whole("building.storeys", storeys, 1, MOST_STOREYS, words)
        damping = check_number("building.damping", damping, *DAMPING)
        if height is not None:
            height = check_number("building.height", height, *LENGTH)
        along = []
        for suffix, first, part in (("", period, alpha), ("_y", period_y, alpha_y)):
            first = check_number(f"building.period{suffix}", period if first is None else first, *PERIOD)
            part = check_number(f"building.alpha{suffix}", alpha if part is None else part, *ALPHA)
            along.append(_beam_modes(storeys, first, part, damping))
        return cls(name, along[0], along[1], height)


def floor_motion(motion: Motion, building: Building, floor: int) -> Motion:
    """Return the motion of a floor of a building, from that of the ground.

    The modal equations are solved exactly for straight lines between samples, a harmonic as 400 lines a cycle. Vertical
    accelerations are those of the ground; the building does not twist. Modes below 0.02 s move with the ground. The
    floor has at least 20 samples per period of the shortest other mode, and moves on until these have decayed to 1 %,
    at most 60 s.

    Parameters
    ----------
    motion : Motion
        The motion of the ground, not held between samples.
    building : Building
        The building.
    floor : int
        The floor; 0 is the ground.

    Returns
    -------
    Motion
        The accelerations of the floor, absolute.

    Raises
    ------
    InputError
        If there is no such floor, the motion is held, or needs too many samples.
    """
    check_type("motion", motion, Motion)
    check_type("building", building, Building)
    floor = building.checked(floor)
    axes = {"ax": building.along_x} | ({"ay": building.along_y} if motion.has_ay else {})
    moving = {key: [mode for mode in modes if mode.period >= RIGID] for key, modes in axes.items()}
    together = [mode for modes in moving.values() for mode in modes]
    if floor == 0 or not together:
        return motion
    if motion.hold:
        raise InputError("motion: must be of straight lines between samples for a floor, they are held")
    # the ground as it moves, then at rest for the tail, with enough samples
    decay = min(2.0 * math.pi * mode.damping / mode.period for mode in together)
    tail = LONGEST_TAIL if decay == 0.0 else min(LONGEST_TAIL, -math.log(FADED) / decay)
    step = min(mode.period for mode in together) / PER_PERIOD
    time, steps, ground = _divided(*_with_tail(*_sampled(motion), tail, step), step)
    # along each axis: the ground, and the relative accelerations of the modes
    for row, modes in zip(ground, moving.values(), strict=False):
        relative = np.zeros_like(row)
        for mode in modes:
            omega = 2.0 * math.pi / mode.period
            u, v = oscillator.response(steps, row[:-1], row[1:], np.array([omega]), mode.damping)
            absolute = -omega * (omega * u[:, 0] + 2.0 * mode.damping * v[:, 0])
            relative += mode.factors[floor - 1] * (absolute - row)
        row += relative
    ax, ay, az = ground
    duration = float(time[-1] - time[0])
    made = replace(motion, amplitude=0.0, amplitude_y=0.0, frequency=0.0)
    name = f"{motion.name or 'the motion'} on floor {floor} of {building.name}"
    return replace(made, time=time, ax=ax, ay=ay, az=az, duration=duration, name=name)


def _sampled(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return the instants, and the rows ax, ay, az; of a harmonic as many as `lines_of` has."""
    if not (motion.amplitude or motion.amplitude_y):
        return motion.time, np.stack([motion.ax, motion.ay, motion.az])
    time = lines_of(motion, "ax" if motion.amplitude else "ay").time
    wave = np.sin(2.0 * np.pi * motion.frequency * (time - motion.start))
    flat = [np.interp(time, motion.time, samples) for samples in (motion.ax, motion.ay, motion.az)]
    return time, np.stack(flat) + np.outer([motion.amplitude, motion.amplitude_y, 0.0], wave)


def _with_tail(time: FloatArray, rows: FloatArray, tail: float, step: float) -> tuple[FloatArray, FloatArray]:
    """Return instants and rows with a ground at rest after the end, which it reaches within `DROP`."""
    end, last = float(time[-1]), float(time[-1] - time[-2])
    drop = [end + DROP * min(step, last)] if np.any(rows[:, -1]) else []
    after = [*drop, end + tail]
    return np.append(time, after), np.hstack([rows, np.zeros((3, len(after)))])


def _divided(time: FloatArray, rows: FloatArray, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Divide intervals longer than `step`; return the instants, the intervals, and the rows on the straight lines."""
    intervals = np.diff(time)
    wanted = np.maximum(1.0, np.ceil(intervals / step - 1e-9))
    if np.sum(wanted) > MOST_LINES:
        raise InputError(
            f"motion: {np.sum(wanted):.3g} samples on the floor, must be at most {MOST_LINES:.0e}: shorten the motion, "
            f"or leave out modes below {PER_PERIOD * step * np.sum(wanted) / MOST_LINES:.2g} s"
        )
    parts = wanted.astype(np.int64)
    line, within = divided(parts)
    fine = np.append(time[line] + within * intervals[line], time[-1])
    values = np.hstack([rows[:, line] + within * np.diff(rows)[:, line], rows[:, -1:]])
    return fine, (intervals / parts)[line], values


def _by_modes(name: str, tables: Sequence[Mapping[str, Any]]) -> Building:
    """Return the building of tables [[building.mode]]."""
    found: dict[str, list[BuildingMode]] = {"x": [], "y": []}
    lists = [table[axis] for table in tables for axis in found if axis in table]
    storeys = len(lists[0]) if lists and isinstance(lists[0], list) else 1
    words = "a list of numbers, participation times shape at each floor from the first above the ground, equally "
    words += f"long in all modes, of 1 to {MOST_STOREYS}"
    for k, table in enumerate(tables, start=1):
        key = f"building.mode[{k}]"
        check_keys(f"{key}.", table, OF_MODE)
        period = check_number(f"{key}.period", table.get("period"), *PERIOD)
        damping = check_number(f"{key}.damping", table.get("damping", USUAL_DAMPING), *DAMPING)
        if not {"x", "y"} & table.keys():
            raise InputError(f"{key}.x: missing, must be participation times shape at each floor, or y along y")
        for axis in [axis for axis in found if axis in table]:
            count = min(max(storeys, 1), MOST_STOREYS)
            factors = vector_of(f"{key}.{axis}", table[axis], count, FACTOR, words)
            found[axis].append(BuildingMode(period, damping, tuple(factors.tolist())))
    if not found["x"]:
        raise InputError("building.mode[1].x: missing, must be given for one mode at least")
    return Building(name, tuple(found["x"]), tuple(found["y"] or found["x"]))


def _beam_modes(storeys: int, period: float, alpha: float, damping: float) -> tuple[BuildingMode, ...]:
    """Return the modes of a beam at its floors, as many as storeys, at most `MOST_MODES`."""
    gammas = _roots(alpha, min(storeys, MOST_MODES))
    pace = gammas * np.hypot(gammas, alpha)  # the frequencies, in an arbitrary unit
    heights = np.arange(1, storeys + 1) / storeys
    periods = (period * (pace[0] / pace)).tolist()
    return tuple(
        BuildingMode(each, damping, tuple(_factors(alpha, gamma, heights).tolist()))
        for each, gamma in zip(periods, gammas.tolist(), strict=True)
    )


def _roots(alpha: float, count: int) -> FloatArray:
    """Return the first roots of the characteristic equation of a beam, by bisection.

    With b^2 = g^2 + alpha^2: 2 + (2 + alpha^4 / (g b)^2) cos g cosh b + alpha^2 / (g b) sin g sinh b = 0, here times
    (g b)^2 / cosh b. One root lies between each two multiples of pi, where the cosine gives the sign.
    """
    numbers = np.arange(count)
    sign = np.where(numbers % 2 == 0, 1.0, -1.0)
    low, high = np.maximum(np.pi * numbers, 0.1), np.pi * (numbers + 1.0)
    for _ in range(60):
        g = 0.5 * (low + high)
        b = np.hypot(g, alpha)
        value = 2.0 * (g * b) ** 2 / np.cosh(b) + (2.0 * (g * b) ** 2 + alpha**4) * np.cos(g)
        value += alpha**2 * g * b * np.sin(g) * np.tanh(b)
        before = sign * value > 0.0
        low, high = np.where(before, g, low), np.where(before, high, g)
    return 0.5 * (low + high)


def _factors(alpha: float, g: float, heights: FloatArray) -> FloatArray:
    """Return participation times shape of a mode at heights from 0 to 1.

    The shape sin(g z) - g/b sinh(b z) - eta cos(g z) + eta cosh(b z), with eta = (g^2 sin g + g b sinh b) / (g^2 cos g
    + b^2 cosh b), is a sum of four c exp(rate z + shift), in which nothing large cancels; its integrals are closed.
    """
    b = math.hypot(alpha, g)
    beyond = g**2 * math.sin(g) - g**3 / b * math.cos(g) - g * b * math.exp(-b)
    beyond /= g**2 * math.cos(g) + b**2 * math.cosh(b)  # eta - g/b
    eta = g / b + beyond
    rate = np.array([1j * g, -1j * g, b, -b])
    shift = np.array([0.0, 0.0, -b, 0.0])
    c = np.array([-0.5j - 0.5 * eta, 0.5j - 0.5 * eta, 0.5 * beyond * math.exp(b), 0.5 * (eta + g / b)])
    # participation: the integral of the shape over that of its square
    area = np.sum(c * _integral(rate, shift)).real
    square = np.sum(np.outer(c, c) * _integral(np.add.outer(rate, rate), np.add.outer(shift, shift))).real
    shape = (c @ np.exp(np.outer(rate, heights) + shift[:, None])).real
    return area / square * shape


def _integral(rate: Any, shift: Any) -> Any:
    """Return the integrals of exp(rate z + shift) over z from 0 to 1."""
    still = rate == 0.0
    over = np.where(still, 1.0, rate)
    return np.where(still, np.exp(shift), (np.exp(shift + rate) - np.exp(shift)) / over)
