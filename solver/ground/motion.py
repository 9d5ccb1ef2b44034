"""The motion of the base: a harmonic, samples, or a record."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..common.errors import FINITE, NOT_NEGATIVE, POSITIVE, InputError, InputWarning, check_number, reading, shown
from ..common.files import printable, whole_file
from ..common.frames import Frame, Framed
from ..common.notebook import NotebookRepr, counted, history
from ..common.plausible import MOST_INTENSE, warn_of
from ..common.ranges import has_masked
from ..common.text import lines_of
from .loads import Load
from .records import STANDARD_GRAVITY as STANDARD_GRAVITY
from .records import Record, peer, read_record
from .records.columns import LEAD, SLOPES, read_csv
from .records.record import FloatArray

# g; no record has more: 2.7 horizontally (Tsukidate, 2011), 3.9 vertically (Ichinoseki-West, 2008)
STRONGEST = {"ax": MOST_INTENSE["pga"], "ay": MOST_INTENSE["pga"], "az": 4.0}
ROUNDED = 1e-15  # of the sine of an angle of a radian
LARGEST = 1e6  # m/s2: a larger acceleration is a mistake of units, and no column can be followed under it
ACCELERATION = (-LARGEST, LARGEST), "a finite acceleration in m/s2, at most 1e6 either way"
MOST_CYCLES = 1e6  # limit for the search of the crests of a harmonic
DRAWN = 5000  # instants at which a harmonic is plotted
_NONE: FloatArray = np.zeros(0)
SAME_INSTANT = 1e-6  # of the shortest sampling interval: closer instants of two records differ by rounding only


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Framed, NotebookRepr):
    """The base acceleration over start <= t <= end; before and after, it is zero.

    ax(t) = samples + amplitude sin(2 pi frequency (t - start)), az(t) = samples. Between two samples the acceleration
    is linear, or with `hold` equal to the earlier one, as an FMU sees its input. The arrays are copied, read-only.

    Raises InputError on values that are not finite, accelerations beyond 1e6 m/s2, lengths that differ, times that do
    not increase.
    """

    time: FloatArray  # (m,) s, strictly increasing; time[0] is the start
    ax: FloatArray  # (m,) m/s2, horizontal, +x to the right
    az: FloatArray  # (m,) m/s2, vertical, +z up
    name: str = field(default="", kw_only=True)  # the file or formula, for titles
    duration: float  # s; linear: time[-1] - time[0], held: more, the last sample holds until the end
    hold: bool = False
    amplitude: float = 0.0  # m/s2, of the harmonic part of ax
    frequency: float = 0.0  # Hz, of the harmonic part; positive where an amplitude is not 0
    ay: FloatArray = field(default_factory=lambda: _NONE)  # (m,) m/s2, along y, for structures; zeros by default
    amplitude_y: float = 0.0  # m/s2, of the harmonic part of ay
    loads: Mapping[str, Load] = field(default_factory=dict, kw_only=True)  # on the ports, by name

    def __post_init__(self) -> None:
        # samples
        if self.ay is _NONE:
            object.__setattr__(self, "ay", np.zeros_like(self.ax, dtype=np.float64))
        for key, unit in (("time", "s"), ("ax", "m/s2"), ("ay", "m/s2"), ("az", "m/s2")):
            object.__setattr__(self, key, _checked_samples(key, getattr(self, key), unit))
        for key in ("ax", "ay", "az"):
            count = len(getattr(self, key))
            if count != len(self.time):
                raise InputError(f"{key}: {count} samples, must be {len(self.time)}, one for each time")
            k = int(np.argmax(np.abs(getattr(self, key))))
            check_number(f"{key}[{k}]", float(getattr(self, key)[k]), *ACCELERATION)
        # times
        if not self.hold and len(self.time) < 2:
            raise InputError("time: 1 sample, must be at least 2 unless samples are held")
        late = self.time[1:] <= self.time[:-1]
        if late.any():
            k = int(np.argmax(late))
            raise InputError(
                f"time[{k + 1}] = {self.time[k + 1]}: must be later than the sample before, {self.time[k]} s"
            )
        # hold and the harmonic part
        if not isinstance(self.hold, (bool, np.bool_)):
            raise InputError(f"hold = {shown(self.hold)}: must be True or False")
        check_number("amplitude", self.amplitude, *ACCELERATION)
        check_number("amplitude_y", self.amplitude_y, *ACCELERATION)
        if self.amplitude or self.amplitude_y:
            check_number("frequency", self.frequency, POSITIVE, "a positive frequency in Hz")
        else:
            check_number("frequency", self.frequency, NOT_NEGATIVE, "a frequency in Hz, zero or positive")
        # the duration: that of linear samples is given by their times
        check_number("duration", self.duration, POSITIVE, "a positive time in s")
        sampled = float(self.time[-1] - self.time[0])
        if self.hold and not self.duration > sampled:
            raise InputError(f"duration = {self.duration}: must be more than the {sampled} s from first to last sample")
        if not self.hold and not math.isclose(self.duration, sampled, rel_tol=1e-9):
            raise InputError(f"duration = {self.duration}: must be the {sampled} s from first to last sample")

    def _facts(self) -> tuple[str, ...]:
        harmonic = self.amplitude or self.amplitude_y
        kind = f"harmonic of {self.frequency:g} Hz" if harmonic else counted(len(self.time), "sample")
        return "of the base", f"{self.duration:.4g} s", f"PGA {peaks_in_g(self)}", kind, *["held"] * self.hold

    def _picture(self) -> str:
        if self.amplitude or self.amplitude_y:
            time = np.linspace(self.start, self.end, DRAWN)
            drawn = {"ax": self.acceleration(time)[0], "ay": self.across(time), "az": self.acceleration(time)[1]}
        else:
            time, drawn = self.time, {"ax": self.ax, "ay": self.ay, "az": self.az}
            if self.hold:  # steps
                time = np.repeat(np.append(time, self.end), 2)[1:-1]
                drawn = {name: np.repeat(values, 2) for name, values in drawn.items()}
        there = {name: values / STANDARD_GRAVITY for name, values in drawn.items() if name == "ax" or values.any()}
        return history(time, there, "acceleration (g)")

    def _frame(self) -> Frame:
        """Return the samples; of a harmonic only its start and its end."""
        columns = {"ax": self.ax, **({"ay": self.ay} if self.has_ay else {}), "az": self.az}
        beside = {"hold": int(self.hold), "amplitude": self.amplitude, "frequency": self.frequency}
        if self.amplitude_y:
            beside["amplitude_y"] = self.amplitude_y
        return Frame(("time", self.time), columns, {"time": "s"} | dict.fromkeys(columns, "m/s2"), beside)

    @property
    def start(self) -> float:
        """The first instant of the motion (s)."""
        return float(self.time[0])

    @property
    def end(self) -> float:
        """The last instant of the motion (s)."""
        return self.start + self.duration if self.hold else float(self.time[-1])

    @property
    def has_ay(self) -> bool:
        """True if the base accelerates along y as well."""
        return bool(self.amplitude_y) or bool(np.any(self.ay))

    @property
    def pga(self) -> float:
        """The largest |ax| (m/s2); see `peak`."""
        return self.peak("ax")

    def peak(self, component: str) -> float:
        """Return the largest magnitude of ax, ay or az over the samples and the crests of the harmonic (m/s2).

        Raises InputError if the harmonic has more than 1e6 cycles.
        """
        samples, amplitude = getattr(self, component), self.amplitude_of(component)
        if not amplitude:
            return float(np.max(np.abs(samples)))
        if self.frequency * self.duration > MOST_CYCLES:
            raise InputError(f"frequency: {self.frequency * self.duration:.4g} cycles, must be at most {MOST_CYCLES:g}")
        crests = self.start + np.arange(0.25, self.frequency * self.duration, 0.5) / self.frequency
        instants = np.concatenate([self.time, crests, [self.end]])
        return float(np.max(np.abs(self._at(instants, samples, amplitude))))

    def amplitude_of(self, component: str) -> float:
        """Return the amplitude of the harmonic part of ax, ay or az (m/s2)."""
        return {"ax": self.amplitude, "ay": self.amplitude_y, "az": 0.0}[component]

    def acceleration(self, t: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return (ax, az) at the instants t (any shape, s), m/s2, each of the shape of t."""
        return self._at(t, self.ax, self.amplitude), self._at(t, self.az)

    def across(self, t: ArrayLike) -> FloatArray:
        """Return ay at the instants t (any shape, s), m/s2, in the shape of t."""
        return self._at(t, self.ay, self.amplitude_y)

    def _at(self, t: ArrayLike, samples: FloatArray, amplitude: float | None = None) -> FloatArray:
        """Return samples at instants, with a harmonic of this amplitude; zero outside the motion."""
        t = np.asarray(t, dtype=np.float64)
        if self.hold:
            found = samples[np.maximum(np.searchsorted(self.time, t, side="right") - 1, 0)]
        else:
            found = np.interp(t, self.time, samples)
        if amplitude is not None:
            found = found + amplitude * np.sin(2.0 * np.pi * self.frequency * (t - self.start))
        return np.where((self.start <= t) & (t <= self.end), found, 0.0)

    def scaled(self, factor: float) -> Motion:
        """Return the motion with its accelerations multiplied by `factor`, its loads unchanged.

        Raises InputError if the factor is not finite or an acceleration exceeds 1e6 m/s2.
        """
        factor = check_number("factor", factor, FINITE, "a finite number")
        ax, az, amplitude = factor * self.ax, factor * self.az, factor * self.amplitude
        largest = max(np.abs(ax).max(), np.abs(az).max(), abs(amplitude))
        if self.has_ay or not largest <= LARGEST:  # the constructor raises the error
            ay, amplitude_y = factor * self.ay, factor * self.amplitude_y
            return replace(self, ax=ax, ay=ay, az=az, amplitude=amplitude, amplitude_y=amplitude_y)
        made = Motion.unchecked(self.time, ax, az, self.duration, self.hold, amplitude, self.frequency)
        return made.with_loads(self.loads).named(self.name)

    def named(self, name: str) -> Motion:
        """Return the motion with a name for titles; the samples are shared."""
        return Motion._made(vars(self) | {"name": name})

    def with_loads(self, loads: Mapping[str, Load]) -> Motion:
        """Return the motion with loads by the names of their ports (loads.py); the samples are shared."""
        return Motion._made(vars(self) | {"loads": dict(loads)})

    def scaled_to(self, pga: float) -> Motion:
        """Return the motion scaled so that `pga` (m/s2) is its largest |ax|; ay and az are scaled by the same factor.

        Raises InputError unless pga is positive and ax is not zero throughout.
        """
        pga = check_number("pga", pga, POSITIVE, "a positive acceleration in m/s2")
        if self.pga == 0.0:
            raise InputError(f"pga = {pga}: ax is zero throughout and cannot be scaled to it")
        return self.scaled(pga / self.pga)

    def with_vertical(self, vertical: Motion) -> Motion:
        """Return the motion with the ax of `vertical`, a record of one component, as its az.

        If the instants of the two differ, the motion has those of both, each component linear in between; every sample
        is kept to the last bit. Before its own start and beyond its own end a component is zero; it gets there within
        the shortest sampling interval.

        Raises InputError unless both are linear samples and this one has no az of its own.
        """
        for motion, name in ((self, "horizontal"), (vertical, "vertical")):
            if motion.hold or motion.amplitude or motion.amplitude_y:
                raise InputError(f"{name} motion: must be linear samples, neither held nor harmonic")
            if np.any(motion.az):
                raise InputError(f"{name} motion: has az beside ax, must be one component")
        if vertical.has_ay:
            raise InputError("vertical motion: has ay beside ax, must be one component")
        time, same = _instants_of_both(self.time, vertical.time)
        ax, az = _at_instants(time, self, same), _at_instants(time, vertical, same)
        ay = np.interp(time, self.time, self.ay, left=0.0, right=0.0)
        return Motion(time, ax, az, float(time[-1] - time[0]), ay=ay, name=self.name, loads=self.loads)

    def with_across(self, across: Motion) -> Motion:
        """Return the motion with the ax of `across`, a record of one component, as its ay; see `with_vertical`."""
        for motion, name in ((self, "first"), (across, "across")):
            if motion.has_ay:
                raise InputError(f"{name} motion: has ay already, must be without it")
        if np.any(across.az):
            raise InputError("across motion: has az beside ax, must be one component")
        level = replace(self, az=np.zeros_like(self.az)).with_vertical(across)
        upwards = np.interp(level.time, self.time, self.az, left=0.0, right=0.0)
        return replace(level, ay=level.az, az=upwards)

    def turned(self, angle: float) -> Motion:
        """Return the motion rotated in plan by an angle (rad) from x to y."""
        angle = check_number("angle", angle, FINITE, "an angle in rad")
        if angle == 0.0:
            return self
        # without the rounding of quarter turns, which would leave a component across the plane
        c, s = (
            0.0 if abs(part) < ROUNDED * max(1.0, abs(angle)) else part for part in (math.cos(angle), math.sin(angle))
        )
        return replace(
            self,
            ax=c * self.ax - s * self.ay,
            ay=s * self.ax + c * self.ay,
            amplitude=c * self.amplitude - s * self.amplitude_y,
            amplitude_y=s * self.amplitude + c * self.amplitude_y,
        )

    def mirrored(self) -> Motion:
        """Return the motion rotated by half a turn in plan: ax and ay change their signs, az does not."""
        made = replace(self, ax=-self.ax, amplitude=-self.amplitude)
        return replace(made, ay=-self.ay, amplitude_y=-self.amplitude_y) if self.has_ay else made

    def to_csv(self, path: str | os.PathLike[str], step: float | None = None, slopes: bool = False) -> None:
        """Write `time,base.ax,base.az` (s, m/s2) for `fmpy simulate --input-file`, every float64 in full.

        A motion with a second horizontal component has base.ay too, an input of structures.

        The file states neither `hold` nor that the base stops at the end (FMPy holds the last row).

        Parameters
        ----------
        path : path-like
            The file.
        step : float, optional
            The sampling interval (s), which must divide the duration: the motion is sampled at start + k step. By
            default the samples are written as they are.
        slopes : bool
            Whether to write the slopes base.jx, base.jz and, with base.ay, base.jy (m/s3) too, with which an FMU
            follows the straight lines between samples within its communication steps. FMPy interpolates between rows,
            so that an extra row just before each sample holds the slope of the interval before it; `from_csv` ignores
            both. The slopes of a held motion are zero, so that it stays held.

        Raises
        ------
        InputError
            If the step is wrong, or missing for a harmonic, or the file cannot be written.
        """
        if step is not None:
            time = self._grid(step)
        elif self.amplitude or self.amplitude_y:
            raise InputError("step: missing, must be the time in s at which a harmonic is sampled")
        else:
            time = self.time
        names, table = ["time", "base.ax", "base.az"], np.column_stack([time, *self.acceleration(time)])
        if self.has_ay:
            names, table = [*names, "base.ay"], np.column_stack([table, self.across(time)])
        if slopes:
            table = _with_slopes(table, self.hold)
            names += [SLOPES[name] for name in names[1:]]
        with reading(path), whole_file(path) as partial:
            np.savetxt(partial, table, fmt="%.17g", delimiter=",", header=",".join(names), comments="")

    def _grid(self, step: float) -> FloatArray:
        """Return the instants start + k step that `to_csv` writes."""
        meaning = f"a time in s that divides the duration, {self.duration} s"
        step = check_number("step", step, (1e-9 * self.duration, self.duration), meaning)
        intervals = round(self.duration / step)
        if not math.isclose(intervals * step, self.duration, rel_tol=1e-9):
            raise InputError(f"step = {step}: must be {meaning}")
        # a held sample lasts for a step: there is no sample at the end
        count = intervals if self.hold else intervals + 1
        time = self.start + step * np.arange(count, dtype=np.float64)
        time[-1] = min(time[-1], self.end)  # rounding must not exceed the end, after which the base is at rest
        return time

    @classmethod
    def unchecked(
        cls,
        time: FloatArray,
        ax: FloatArray,
        az: FloatArray,
        duration: float,
        hold: bool = False,
        amplitude: float = 0.0,
        frequency: float = 0.0,
    ) -> Motion:
        """Return a motion of values known to be valid: checks would take a study as long as their generation.

        The arrays are not copied and become read-only.

        Parameters
        ----------
        time : ndarray of shape (m,)
            The instants (s), increasing.
        ax, az : ndarray of shape (m,)
            The accelerations (m/s2), float64.
        duration : float
            The duration (s).
        hold : bool
            Whether samples are held rather than linear.
        amplitude, frequency : float
            The harmonic part of ax (m/s2, Hz).
        """
        samples = {"time": time, "ax": ax, "ay": np.zeros_like(ax), "az": az}
        for values in samples.values():
            values.setflags(write=False)
        harmonic = {"amplitude": amplitude, "amplitude_y": 0.0, "frequency": frequency}
        return cls._made({**samples, "duration": duration, "hold": hold, **harmonic, "loads": {}})

    @classmethod
    def _made(cls, values: Mapping[str, Any]) -> Motion:
        """Return a motion of these values, which are not checked."""
        made = object.__new__(cls)
        made.__dict__.update(values)
        return made

    @classmethod
    def harmonic(cls, amplitude: float, frequency: float, duration: float, direction: float = 0.0) -> Motion:
        """Return ax = amplitude sin(2 pi frequency t) over 0 <= t <= duration.

        `Motion.harmonic(0.05 * 9.80665, 1.0, 10.0)` is 0.05 g at 1 Hz for 10 s.

        Parameters
        ----------
        amplitude : float
            The amplitude (m/s2).
        frequency : float
            The frequency (Hz), positive.
        duration : float
            The duration (s), positive.
        direction : float
            The direction in plan (rad), from x to y.

        Raises
        ------
        InputError
            If a value is not finite, or frequency or duration is not positive.
        """
        frequency = check_number("frequency", frequency, POSITIVE, "a positive frequency in Hz")
        duration = check_number("duration", duration, POSITIVE, "a positive time in s")
        amplitude = check_number("amplitude", amplitude, *ACCELERATION)
        direction = check_number("direction", direction, FINITE, "an angle in rad")
        time, zero = np.array([0.0, duration], dtype=np.float64), np.zeros(2)
        name = f"a harmonic of {frequency:g} Hz"
        if direction == 0.0:
            return cls(time, zero, zero, duration, amplitude=amplitude, frequency=frequency, name=name)
        along, across = math.cos(direction) * amplitude, math.sin(direction) * amplitude
        return cls(time, zero, zero, duration, False, along, frequency, amplitude_y=across, name=name)

    @classmethod
    def from_samples(
        cls,
        dt: float,
        ax: ArrayLike,
        az: ArrayLike | None = None,
        hold: bool = False,
        ay: ArrayLike | None = None,
    ) -> Motion:
        """Return the motion of samples at k dt, for arrays of other programs, e.g. obspy or eqsig (docs/records.md).

        Linear, it lasts (m - 1) dt and needs 2 samples; held, m dt and 1 sample.

        Parameters
        ----------
        dt : float
            The sampling interval (s).
        ax : array-like of shape (m,)
            The horizontal acceleration (m/s2).
        az, ay : array-like of shape (m,), optional
            The vertical acceleration and the one along y (m/s2), zeros by default.
        hold : bool
            Whether samples are held rather than linear.

        Raises
        ------
        InputError
            As `Motion` does.
        """
        dt = check_number("dt", dt, POSITIVE, "a positive time in s")
        ax = _checked_samples("ax", ax, "m/s2")
        time = dt * np.arange(len(ax), dtype=np.float64)
        duration = dt * len(ax) if hold else float(time[-1])
        up, across = (
            np.zeros_like(ax) if given is None else _checked_samples(key, given, "m/s2")
            for key, given in (("az", az), ("ay", ay))
        )
        return cls(time, ax, up, duration, hold, ay=across)

    @classmethod
    def from_file(
        cls,
        path: str | os.PathLike[str],
        dt: float | None = None,
        units: str | None = None,
        channel: int | None = None,
    ) -> Motion:
        """Read a record in any of the known formats (docs/records.md), recognized by its content; piecewise linear.

        Parameters
        ----------
        path : path-like
            The file.
        dt : float, optional
            The sampling interval (s) of plain columns: with it every number is a sample, without it the first column is
            the time.
        units : {"g", "m/s2", "cm/s2"}, optional
            The unit of plain columns.
        channel : int, optional
            The channel, from 1, of a file that holds several.

        Raises
        ------
        InputError
            If the file is invalid: begins with `path`, with the line of the file if there is one.
        """
        record = read_record(path, dt, units, channel)
        with reading(path):
            return cls.from_record(record, Path(path).name)

    @classmethod
    def from_record(cls, record: Record, name: str = "", hold: bool = False) -> Motion:
        """Return the motion of a record; piecewise linear, or held.

        It warns (InputWarning) of a peak beyond 3 g, along z beyond 4 g, where the units are probably others, and of
        times that were shifted to begin at 0, and of a gap: a step of more than 20 times the median between samples
        that are not zero.

        Parameters
        ----------
        record : Record
            The content of a file.
        name : str
            The name for titles.
        hold : bool
            Whether samples are held, the last one as long as the one before.

        Raises
        ------
        InputError
            As `Motion` does.
        """
        time, ay = record.time, _NONE if record.ay is None else record.ay
        duration = float(time[-1] - time[0] + (time[-1] - time[-2] if hold else 0.0))
        motion = cls(time, record.ax, record.az, duration, hold, ay=ay, name=printable(name))
        lines = [*record.warnings]
        # the component that exceeds the strongest one on record most
        peaks = {key: float(np.max(np.abs(getattr(motion, key)))) / STANDARD_GRAVITY for key in STRONGEST}
        key = max(STRONGEST, key=lambda key: peaks[key] / STRONGEST[key])
        if peaks[key] > STRONGEST[key]:
            reach = f"ground motions reach {STRONGEST[key]:g} g: is it in other units (g, m/s2, cm/s2)?"
            lines.append(f"largest acceleration {peaks[key]:.4g} g, {reach}")
        for line in lines:
            warnings.warn(f"{motion.name or 'record'}: {line}", InputWarning, stacklevel=2)
        return motion

    @classmethod
    def from_csv(cls, path: str | os.PathLike[str], hold: bool = False) -> Motion:
        """Read the file that `fmpy simulate --input-file` takes: `time,base.ax,base.az` in s and m/s2.

        One of base.ax and base.az may be absent, meaning zeros. Times need not be uniform. With `hold`, the last sample
        lasts as long as the one before. Also accepted, though not by FMPy: names in another case (FMPy takes zeros for
        a name that it does not know), `;` or tabs between columns, blank lines at the end. `to_csv` writes what FMPy
        reads.

        Raises InputError that begins with `path` and, for a wrong row, its line number.
        """
        with reading(path):
            return cls.from_record(read_csv(lines_of(path)), Path(path).name, hold)

    @classmethod
    def from_at2(cls, path: str | os.PathLike[str]) -> Motion:
        """Read a horizontal PEER AT2 record, in units of g; piecewise linear, from t = 0.

        Raises InputError that begins with `path` if units, number of samples, step or a value is wrong.
        """
        with reading(path):
            return cls.from_record(peer.read(lines_of(path)), Path(path).name)


def bytes_beside_samples(motion: Motion) -> bytes:
    """Return the bytes of all that a motion has beside its samples and loads, for fingerprints."""
    numbers = (motion.duration, motion.amplitude, motion.amplitude_y, motion.frequency)
    return repr((bool(motion.hold), *map(float, numbers))).encode()


def check_strength(motion: Motion) -> bool:
    """Warn (InputWarning) of a motion that is stronger than any on record; return True if it is."""
    for name, most in STRONGEST.items():
        largest = (float(np.max(np.abs(getattr(motion, name)))) + abs(motion.amplitude_of(name))) / STANDARD_GRAVITY
        if largest > most:
            units = "accelerations are in m/s2, a record in other units has to say so"
            warn_of([f"motion.{name}: reaches {largest:.4g} g, should be {most:g} g at most; {units}"])
            return True
    return False


def check_loads(motion: Motion, duration: float) -> bool:
    """Warn (InputWarning) of a load outside a run of this duration (s); return True if there is one."""
    begin, end = motion.start, motion.start + duration
    for port, load in motion.loads.items():
        first, last = load.time[[0, -1]].tolist()
        if (last <= begin or end <= first) and np.any(load.values):
            span = f"is from {first:g} to {last:g} s, the run from {begin:g} to {end:g} s"
            warn_of([f"loads[{port}]: {span}: it has no effect, its times should be those of the motion"])
            return True
    return False


def peaks_in_g(motion: Motion) -> str:
    """Return the largest acceleration of each component that is not zero, with its axis unless that is x alone."""
    peaks = {name: motion.peak(f"a{name}") / STANDARD_GRAVITY for name in "xyz"}
    there = {name: value for name, value in peaks.items() if value} or {"x": 0.0}
    return ", ".join(f"{value:.4g} g" + f" along {name}" * (list(there) != ["x"]) for name, value in there.items())


def check_in_plane(motion: Motion) -> None:
    """Raise InputError for a motion that leaves the plane of a column."""
    if motion.has_ay:
        raise InputError(
            "ay: a column moves in its plane, must be zero; --space, column.in_space(), solves it in space"
        )


def _with_slopes(table: FloatArray, hold: bool) -> FloatArray:
    """Return rows of time, accelerations and slopes, with an extra row just before the end of each interval."""
    between = np.diff(table[:, :1], axis=0)
    slopes = np.zeros((len(table), table.shape[1] - 1))
    if not hold:
        slopes[:-1] = np.diff(table[:, 1:], axis=0) / between
    rows = np.repeat(np.hstack([table, slopes]), 2, axis=0)[:-1]
    lead = (1.0 - LEAD) * between
    rows[1::2, :1] += lead
    rows[1::2, 1 : table.shape[1]] += slopes[:-1] * lead
    return rows


def _instants_of_both(one: FloatArray, other: FloatArray) -> tuple[FloatArray, float]:
    """Return the instants of two records, and the time (s) within which two instants count as one.

    Where the next instant before the start or after the end of a record is farther away than the shortest sampling
    interval, one at that interval is added.
    """
    shortest = float(min(np.min(np.diff(one)), np.min(np.diff(other))))
    same = SAME_INSTANT * shortest

    def merged(*parts: FloatArray) -> FloatArray:
        instants = np.unique(np.concatenate(parts))
        return instants[np.diff(instants, prepend=-math.inf) > same]

    time = merged(one, other)
    gaps = np.flatnonzero(np.diff(time) > shortest + same)
    starts, ends = (np.searchsorted(time, [one[k] - same, other[k] - same]) for k in (0, -1))
    after, before = time[np.intersect1d(gaps, ends)], time[np.intersect1d(gaps + 1, starts)]
    return merged(time, after + shortest, before - shortest), same


def _at_instants(time: FloatArray, motion: Motion, same: float) -> FloatArray:
    """Return ax at instants; within `same` (s) of an instant of the motion its sample, to the last bit."""
    values = np.interp(time, motion.time, motion.ax, left=0.0, right=0.0)
    after = np.minimum(np.searchsorted(motion.time, time), len(motion.time) - 1)
    for nearest in (after, np.maximum(after - 1, 0)):
        own = np.abs(motion.time[nearest] - time) <= same
        values[own] = motion.ax[nearest[own]]
    return values


def _checked_samples(key: str, values: ArrayLike, unit: str) -> FloatArray:
    """Return a read-only float64 copy of `values` if it is a list of finite numbers. Raises InputError otherwise."""
    if has_masked(values):
        raise InputError(f"{key}: has gaps (masked values), must be numbers in {unit} throughout")
    try:
        given = np.asarray(values)
    except ValueError:  # ragged
        given = np.array(None)
    if given.ndim != 1 or given.size == 0 or given.dtype.kind not in "iuf":
        raise InputError(f"{key}: must be a one-dimensional array of numbers in {unit}, at least one")
    samples = np.array(given, dtype=np.float64)
    finite = np.isfinite(samples)
    if not finite.all():
        k = int(np.argmin(finite))
        raise InputError(f"{key}[{k}] = {samples[k]}: must be a finite number in {unit}")
    samples.setflags(write=False)
    return samples
