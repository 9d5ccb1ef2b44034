"""Base motions of a study: records and formulas, a table each, whose numbers a study may vary, and their measures."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..common.digits import percent
from ..common.errors import FINITE, NOT_NEGATIVE, POSITIVE, InputError, check_number, check_whole, shown, whole
from ..common.plausible import MOST_INTENSE, MOST_SPECTRAL, warn_of
from ..common.ranges import check_choice, check_keys
from ..ground import wavelets
from ..ground.building import Building, floor_motion
from ..ground.intensity import DAMPINGS, Component, pgv, rotd, spectrum
from ..ground.loads import loads_by_port, loads_from
from ..ground.motion import STANDARD_GRAVITY, Motion
from ..ground.records import format_of, has_channels
from ..ground.records.columns import PLAIN
from . import near_fault

LEAN_IN = 5.0  # s, duration of the tilting before the motion begins
PER_LEAN = 200  # number of its samples
OTHER_SEED = 2**31  # offset of the seed of a component across: half of all seeds
ACROSS = "across"  # for noise: ratio of the second component to the first; for a record: its file


@dataclass(frozen=True)
class Formula:
    """A motion by numbers."""

    needs: tuple[str, ...]  # numbers that are required
    makes: Callable[..., Motion]  # from the numbers
    optional: tuple[str, ...] = ()  # numbers that may be left out
    amplitude: str = "amplitude"  # the number that sets its size; "": its size is fixed


def _noise(amplitude: float, frequency: float, duration: float, seed: int, across: float = 0.0) -> Motion:
    """Return filtered noise, with a second horizontal component if `across` is not 0.

    `across` is the ratio of the peaks of the second, independent component and the first.
    """
    motion = wavelets.filtered_noise(amplitude, frequency, duration, seed)
    if across == 0.0:
        return motion
    part = check_number(f"motion.{ACROSS}", across, NOT_NEGATIVE, "a part of the first component, zero or positive")
    other = (seed + OTHER_SEED) % (2 * OTHER_SEED)
    return motion.with_across(wavelets.filtered_noise(part * amplitude, frequency, duration, other))


_NEAR_FAULT = Formula(("magnitude", "distance", "seed"), near_fault.motion, near_fault.OPTIONAL, amplitude="")
FORMULAS = {
    "harmonic": Formula(("frequency", "duration"), Motion.harmonic),
    "ricker": Formula(("frequency",), wavelets.ricker),
    "one-sine": Formula(("frequency",), wavelets.one_sine),
    "one-cosine": Formula(("frequency",), wavelets.one_cosine),
    "mavroeidis-papageorgiou": Formula(
        ("frequency", "cycles"),
        lambda velocity, frequency, cycles, phase=0.0: wavelets.mavroeidis_papageorgiou(
            velocity, frequency, cycles, math.radians(phase)
        ),
        ("phase",),
        amplitude="velocity",
    ),
    "noise": Formula(("frequency", "duration", "seed"), _noise, (ACROSS,)),
    "near-fault": _NEAR_FAULT,
    "near-fault-1981": replace(_NEAR_FAULT, makes=partial(near_fault.motion, velocity=near_fault.pgv_of_all)),
}
OF_MOTION = "motion."  # prefix of the names of their numbers in a study
WHOLE = ("seed",)
COMPONENTS = ("record", "vertical", "across")  # of a record: its files
_OF_RECORDS = (*COMPONENTS, "dt", "units", "channel", "vertical_channel", "across_channel")
ON_FLOOR = ("building", "floor")  # of every motion: that of a floor of a building, whose file is named
# numbers of every motion: factor; tilt of the base (rad, clockwise positive); for structures also the direction in plan
# (rad, from x to y) and a factor on the loads on their ports
LOAD_SCALE, DIRECTION = "load_scale", "direction"
BESIDE = ("scale", "tilt", DIRECTION, LOAD_SCALE)
OF_SPACE = (ACROSS, DIRECTION)  # numbers of a motion that leaves the plane of a column
IN_PLANE = "a column moves in its plane; structure = FILE, in place of column, solves it in space"
SPECTRAL = {"sa": "Sa", "rotd50": "RotD50", "rotd100": "RotD100"}  # of a period and damping, and their labels
MEASURES = ("pga", "pgv", *SPECTRAL)
# a measure as text, such as PGA (g) or sa(0.5): the name, period and damping of sa, and the unit if it is given
MEASURE_TEXT = re.compile(
    r"(pga|pgv|(?:sa|rotd50|rotd100)\s*\(\s*([\d.]+)(?:\s*s)?(?:\s*,\s*([\d.]+))?\s*\))(?:\s*[(\[](.*)[)\]])?"
)


@dataclass(frozen=True)
class Measure:
    """A measure of intensity: pga in g, pgv in m/s, or sa, the pseudo-acceleration in g at a period in s."""

    name: str
    period: float = 0.0
    damping: float = 0.05

    def of(self, motion: Motion, component: Component = "ax") -> float:
        """Return its value for a horizontal component of a motion; RotD is always that of both components."""
        if self.name == "pga":
            return motion.peak(component) / STANDARD_GRAVITY
        if self.name == "pgv":
            return pgv(motion, component)
        of = (self.period,), self.damping
        found = spectrum(motion, *of, component) if self.name == "sa" else rotd(motion, float(self.name[4:]), *of)
        return float(found.psa[0]) / STANDARD_GRAVITY

    @property
    def unit(self) -> str:
        """The unit as text."""
        return "m/s" if self.name == "pgv" else "g"

    def warn_of_largest(self, key: str, value: float, part: float = 1.0) -> None:
        """Warn (InputWarning) of an intensity beyond a part of the largest one on record; `key` begins the line."""
        most, unit = part * MOST_INTENSE.get(self.name, MOST_SPECTRAL), self.unit
        if value > most:
            warn_of([f"{key}: reaches {value:.4g} {unit}, should be {most:g} {unit} at most; {self.name} is in {unit}"])

    @property
    def label(self) -> str:
        """The name as text, with period and damping."""
        if self.name not in SPECTRAL:
            return self.name.upper()
        return f"{SPECTRAL[self.name]}({self.period:g} s, {percent(self.damping)})"

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Measure:
        """Read a table such as {measure = "sa", period = 0.5, damping = 0.05}. Raises InputError."""
        name = check_choice("intensity.measure", table.get("measure"), MEASURES)
        known = ("measure", "period", "damping") if name in SPECTRAL else ("measure",)
        check_keys("intensity.", table, known, f" of {name}")
        if name not in SPECTRAL:
            return cls(name)
        period = check_number("intensity.period", table.get("period"), POSITIVE, "a positive time in s")
        damping = check_number("intensity.damping", table.get("damping", 0.05), *DAMPINGS)
        return cls(name, period, damping)

    @classmethod
    def from_text(cls, key: str, text: str) -> Measure:
        """Read pga, pgv, sa(PERIOD) or sa(PERIOD, DAMPING), with or without its unit. Raises InputError."""
        found = MEASURE_TEXT.fullmatch(text.strip().lower())
        if found is None:
            raise InputError(f"{key} = {text!r}: must be pga, pgv, sa(PERIOD), rotd50(PERIOD) or rotd100(PERIOD)")
        name, period, damping, unit = found.groups()
        numbers = {"period": period, "damping": damping}
        try:
            given = {number: float(value) for number, value in numbers.items() if value}
        except ValueError:
            raise InputError(f"{key} = {text!r}: must have a period in s, as sa(0.5)") from None
        measure = cls.from_table({"measure": name.partition("(")[0].strip(), **given})
        if unit not in (None, measure.unit):
            raise InputError(f"{key} = {text!r}: must be in {measure.unit}")
        return measure

    def to_table(self) -> dict[str, Any]:
        """Return the table from which `from_table` builds this measure."""
        beside = {"period": self.period, "damping": self.damping} if self.name in SPECTRAL else {}
        return {"measure": self.name, **beside}


@dataclass(frozen=True, eq=False)
class Shaking:
    """A base motion of a study: a record, or a formula with its numbers.

    Attributes
    ----------
    name
        Name in pictures and tables.
    formula
        One of FORMULAS, "" for a record.
    numbers
        Numbers of the formula, and those of BESIDE.
    record
        The record, None for a formula.
    loads
        Loads on ports of structures, as in `simulate`.
    building, floor
        The building and the floor on which the model stands; None and 0 on the ground.
    """

    name: str
    formula: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict)
    record: Motion | None = None
    loads: Mapping[str, Any] = field(default_factory=dict)
    building: Building | None = None
    floor: int = 0

    @classmethod
    def from_table(cls, key: str, table: Mapping[str, Any], folder: Path) -> Shaking:
        """Read a table: {record = "file.AT2", ...}, its path relative to `folder`, or {formula = "ricker", ...}.

        Raises InputError that begins with `key`, or with the path of a record.
        """
        if ("record" in table) == ("formula" in table):
            raise InputError(f"{key}: must have exactly one of record, a file, and formula, of {', '.join(FORMULAS)}")
        name, formula = table.get("name"), table.get("formula", "")
        if "formula" in table:
            check_choice(f"{key}.formula", formula, FORMULAS)
        if name is not None and not isinstance(name, str):
            raise InputError(f"{key}.name = {shown(name)}: must be a text")
        # keys, numbers, record and loads
        numbers = cls.numbers_of(formula)
        known = ("name", "load", *ON_FLOOR, *(("formula",) if formula else _OF_RECORDS), *numbers)
        check_keys(f"{key}.", table, known)
        given = {
            item: check_number(f"{key}.{item}", table[item], FINITE, "a number") for item in numbers & table.keys()
        }
        for item in given.keys() & WHOLE:
            _seed(f"{key}.{item}", given[item])
        record = None if formula else _record(key, table, folder)
        shown_as = formula or Path(str(table["record"])).stem
        loads = table.get("load", {})
        if not isinstance(loads, Mapping):
            raise InputError(f'{key}.load = {shown(loads)}: must be a table, as {{ "roof.Fx" = 1000.0 }}')
        shown_as = shown_as if name is None else name
        return cls(shown_as, formula, given, record, loads_by_port(loads, folder), *_on_floor(key, table, folder))

    def check_in_plane(self, key: str) -> None:
        """Raise InputError, with `key`, for a motion that leaves the plane of a column."""
        for name in OF_SPACE:
            if name in self.numbers:
                raise InputError(f"{key}.{name}: must be left out, {IN_PLANE}")
        if self.record is not None and self.record.has_ay:
            raise InputError(f"{key}: ay: {IN_PLANE}")

    def with_loads(self, motion: Motion, before: Motion, duration: float, factor: float | None) -> Motion:
        """Return the motion with the loads of this table and of its record, times a factor.

        Parameters
        ----------
        motion : Motion
            The motion as run.
        before : Motion
            The motion before it was scaled, whose loads are kept.
        duration : float
            Duration of the run (s), over which constant loads last.
        factor : float, optional
            Factor on the loads.

        Raises
        ------
        InputError
            If there is a factor but no loads.
        """
        loads = {**before.loads, **loads_from(self.loads, motion.start, duration)}
        if factor is not None and not loads:
            raise InputError(f"motion.{LOAD_SCALE}: {self.name} has no loads, must have a table load")
        scale = 1.0 if factor is None else factor
        return motion.with_loads({port: load.scaled(scale) for port, load in loads.items()}) if loads else motion

    @property
    def amplitude(self) -> str:
        """The number of its formula that sets its size; "" for a record and where the size is fixed."""
        return FORMULAS[self.formula].amplitude if self.formula else ""

    @staticmethod
    def numbers_of(formula: str) -> set[str]:
        """Return the names of the numbers that a study may set or vary."""
        if not formula:
            return set(BESIDE)
        found = FORMULAS[formula]
        return {*found.needs, *found.optional, *BESIDE} | ({found.amplitude} if found.amplitude else set())

    def base(self, values: Mapping[str, float], unit: bool) -> Motion:
        """Return the motion with further numbers, before it is scaled or tilted.

        Parameters
        ----------
        values : mapping
            Numbers in addition to the ones of the table.
        unit : bool
            Whether the motion will be scaled to an intensity, so that its amplitude may be left out.

        Raises
        ------
        InputError
            If a number is missing or wrong.
        """
        if self.record is not None:
            return self.record
        formula = FORMULAS[self.formula]
        numbers: dict[str, Any] = {**self.numbers, **values}
        if formula.amplitude and unit:
            numbers.setdefault(formula.amplitude, 1.0)
        # check the numbers, then build the motion
        needed = (formula.amplitude, *formula.needs) if formula.amplitude else formula.needs
        for name in needed:
            if name not in numbers:
                raise InputError(f"motion.{name}: missing, {self.formula} needs {', '.join(needed)}")
        for name in WHOLE:
            if name in numbers:
                numbers[name] = _seed(f"motion.{name}", numbers[name])
        return formula.makes(**{name: numbers[name] for name in (*needed, *formula.optional) if name in numbers})

    def of_floor(self, ground: Motion) -> Motion:
        """Return the motion of the floor on which the model stands, from that of the ground. Raises InputError."""
        return ground if self.building is None else floor_motion(ground, self.building, self.floor)

    def to_table(self) -> dict[str, Any]:
        """Return the values that distinguish this motion from others, for fingerprints and captions."""
        found = {"name": self.name, "formula": self.formula, **self.numbers}
        if self.building is not None:
            found |= {"building": self.building.to_dict(), "floor": self.floor}
        loads = loads_from(self.loads, 0.0, 1.0)
        if self.record is not None:
            loads = {**self.record.loads, **loads}
        listed = {port: [load.time.tolist(), load.values.tolist()] for port, load in loads.items()}
        return {**found, "loads": listed} if listed else found


def _seed(key: str, value: float) -> int:
    """Return the seed of a formula. Raises InputError unless it is a whole number."""
    return check_whole(key, whole(value), *wavelets.SEEDS)


def _record(key: str, table: Mapping[str, Any], folder: Path) -> Motion:
    """Return the motion of the files in a table. Raises InputError."""
    for name in COMPONENTS:
        if name in table and not isinstance(table[name], str):
            raise InputError(f"{key}.{name} = {shown(table[name])}: must be the path of a file")
    paths = {name: folder / table[name] for name in COMPONENTS if name in table}
    # dt and units are those of plain columns; without any, the first file refuses them
    plain = [name for name, path in paths.items() if format_of(path) == PLAIN] or [*paths]

    def read(name: str, path: Path, channel: Any) -> Motion:
        dt, units = (table.get(item) if name in plain else None for item in ("dt", "units"))
        return Motion.from_file(path, dt, units, channel)

    channels = {name: table.get("channel" if name == "record" else f"{name}_channel") for name in paths}
    return read_components(paths, channels, {name: f"{key}.{name}" for name in paths}, "_", read)


def read_components(
    paths: Mapping[str, Path],
    channels: Mapping[str, Any],
    keys: Mapping[str, str],
    mark: str,
    read: Callable[[str, Path, Any], Motion],
) -> Motion:
    """Return the motion of a record and its other components, all by name: those of COMPONENTS in `paths`.

    `read` takes a name, the path and the channel: by default that of the record, where a file has several. Raises
    InputError if two components are one channel, with their `keys`; that of a channel is such a key, `mark`, "channel".
    """
    taken: dict[tuple[Path, int], str] = {}

    def component(name: str) -> Motion:
        path, channel = paths[name], channels[name]
        if channel is None and channels["record"] is not None and has_channels(path):
            channel = channels["record"]
        if isinstance(channel, int):
            other, key = taken.setdefault((path.resolve(), channel), name), keys[name]
            if other != name:
                where = f"is channel {channel} of {path}, as {keys[other]}"
                raise InputError(f"{key}: {where}, must be another one: {key}{mark}channel")
        return read(name, path, channel)

    motion = component("record")
    if "across" in paths:
        motion = motion.with_across(component("across"))
    return motion.with_vertical(component("vertical")) if "vertical" in paths else motion


def _on_floor(key: str, table: Mapping[str, Any], folder: Path) -> tuple[Building | None, int]:
    """Return the building and the floor that a table names; None and 0 for the ground. Raises InputError."""
    missing = [name for name in ON_FLOOR if name not in table]
    if len(missing) == len(ON_FLOOR):
        return None, 0
    if missing:
        raise InputError(f"{key}.{missing[0]}: missing, building and floor must be given together")
    path = table["building"]
    if not isinstance(path, str):
        raise InputError(f"{key}.building = {shown(path)}: must be the path of a file")
    building = Building.from_toml(folder / path)
    return building, building.checked(table["floor"], f"{key}.floor")


def tilted(motion: Motion, angle: float, g: float = STANDARD_GRAVITY) -> Motion:
    """Return the motion on a base that leans clockwise by `angle` (rad), as gravity acts on a column on it.

    The base leans over smoothly in the 5 s before the motion. In a frame that leans by psi, gravity is rotated by psi:
    a base acceleration of -g sin(psi) along and -g (1 - cos(psi)) across, by the gravity `g` of the model (m/s2).
    Raises InputError for held samples.
    """
    if angle == 0.0:
        return motion
    angle = check_number("motion.tilt", angle, (-1.5, 1.5), "an angle in rad, from -1.5 to 1.5")
    if motion.hold or motion.amplitude or motion.amplitude_y:
        raise InputError("motion.tilt: is for motions of samples, neither held nor harmonic")
    # lean over with half a cosine, then add the constant acceleration
    part = np.arange(PER_LEAN) / PER_LEAN
    rise = 0.5 * (1.0 - np.cos(np.pi * part))
    ax, az = -g * math.sin(angle), -g * (1.0 - math.cos(angle))
    time = np.concatenate([motion.start - LEAN_IN * (1.0 - part), motion.time])
    return Motion(
        time,
        np.concatenate([ax * rise, motion.ax + ax]),
        np.concatenate([az * rise, motion.az + az]),
        float(time[-1] - time[0]),
        ay=np.concatenate([np.zeros(PER_LEAN), motion.ay]),
    )
