"""Intensity measures of a base motion: peaks, Arias intensity, significant duration, response spectrum, RotD."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..common.errors import POSITIVE, InputError, check_number, check_type, shown
from ..common.frames import Frame, Framed
from ..common.ranges import check_choice
from ..common.tables import numbers_of
from . import oscillator
from .motion import STANDARD_GRAVITY, Motion
from .records.record import FloatArray

Component = Literal["ax", "ay", "az"]

NAMES: dict[Component, str] = {"ax": "horizontal", "ay": "across", "az": "vertical"}
DAMPING = 0.05  # of critical, of the customary spectrum
DAMPINGS = (0.0, 0.999), "a part of critical, at least 0 and less than 1"
PERIODS = np.geomspace(0.05, 10.0, 120)  # s
PER_PERIOD = 10  # least samples per period of an oscillator; cubic interpolation between them has an error of 1e-4
PER_CYCLE = 400  # line segments per cycle of a harmonic
MOST_LINES = 1_000_000  # ten minutes at 1 kHz, and more
AT_ONCE = 4_000_000  # numbers in a history of all oscillators integrated at once
ANGLES = np.deg2rad(np.arange(180.0))  # of the orientations of RotD: Boore (2010), Bull. Seism. Soc. Am. 100 (4)
UNEVEN = 1e9  # ratio of the longest to the shortest segment beyond which the short ones are lost in rounding


@dataclass(frozen=True, eq=False)
class Lines:
    """One component of a motion as line segments; zero before and after."""

    time: FloatArray  # (m + 1,) s
    before: FloatArray  # (m,) m/s2, at the start of each segment
    after: FloatArray  # (m,) m/s2, at the end of each segment

    @cached_property
    def steps(self) -> FloatArray:
        """The durations of the segments (s)."""
        return self.time[1:] - self.time[:-1]

    @cached_property
    def velocity(self) -> FloatArray:
        """The velocity at the instants, from rest (m/s)."""
        return _running(self.steps * (self.before + self.after) / 2.0)


@dataclass(frozen=True, eq=False)
class BaseHistories:
    """The motion of the base, integrated from rest without baseline correction, so that a baseline error shows."""

    time: FloatArray  # (m + 1,) s
    velocity: FloatArray  # (m + 1,) m/s
    displacement: FloatArray  # (m + 1,) m
    husid: FloatArray  # (m + 1,) m/s, Arias intensity up to each instant


@dataclass(frozen=True)
class Intensity:
    """The intensity measures of one component; velocity and displacement without baseline correction."""

    pga: float  # m/s2
    pgv: float  # m/s
    pgd: float  # m
    final_velocity: float  # m/s, at the end: shows how far pgv and pgd can be trusted
    final_displacement: float  # m
    arias: float  # m/s
    start: float  # s, time at which 5 % of the Arias intensity is reached
    end: float  # s, time at which 95 % of it is reached

    @property
    def significant_duration(self) -> float:
        """The time from 5 to 95 % of the Arias intensity (s)."""
        return self.end - self.start


@dataclass(frozen=True, eq=False)
class Spectrum(Framed):
    """The response spectrum: the largest response of oscillators, including the free vibration after the motion."""

    period: FloatArray  # (p,) s
    sd: FloatArray  # (p,) m, relative displacement
    damping: float  # of critical

    def _frame(self) -> Frame:
        columns = {"sd": self.sd, "psv": self.psv, "psa": self.psa}
        units = {"period": "s", "sd": "m", "psv": "m/s", "psa": "m/s2"}
        return Frame(("period", self.period), columns, units, {"damping": self.damping})

    @property
    def psv(self) -> FloatArray:
        """The pseudo-velocity (m/s)."""
        return 2.0 * np.pi / self.period * self.sd

    @property
    def psa(self) -> FloatArray:
        """The pseudo-acceleration (m/s2)."""
        return (2.0 * np.pi / self.period) ** 2 * self.sd


def components(motion: Motion) -> list[Component]:
    """Return the components that are not zero throughout. Raises InputError if all are."""
    there = [component for component in NAMES if motion.amplitude_of(component) or np.any(getattr(motion, component))]
    if not there:
        raise InputError("the motion is zero throughout, must be an acceleration")
    return there


def is_measurable(motion: Motion) -> bool:
    """Return True if the harmonic of a motion has few enough cycles to be approximated by line segments."""
    return motion.frequency * motion.duration * PER_CYCLE <= MOST_LINES


def lines_of(motion: Motion, component: Component = "ax") -> Lines:
    """Convert a component to line segments: samples exactly, a harmonic by 400 per cycle.

    Raises InputError if the harmonic has too many cycles, or the component is unknown.
    """
    check_type("motion", motion, Motion)
    samples: FloatArray = getattr(motion, check_choice("component", component, NAMES))
    if motion.hold:
        time, before, after = np.append(motion.time, motion.end), samples, samples
    else:
        time, before, after = motion.time, samples[:-1], samples[1:]
    amplitude = motion.amplitude_of(component)
    if amplitude or (component != "az" and (motion.amplitude or motion.amplitude_y)):
        if not is_measurable(motion):
            cycles, most = motion.frequency * motion.duration, MOST_LINES // PER_CYCLE
            raise InputError(f"frequency: {cycles:.4g} cycles, must be at most {most} to be measured")
        parts = np.ceil(PER_CYCLE * motion.frequency * np.diff(time)).astype(np.int64)
        line, within = divided(parts)
        rise, step = (after - before)[line], np.diff(time)[line]
        # add the harmonic at the new instants
        fine = np.append(time[line] + within * step, time[-1])
        wave = amplitude * np.sin(2.0 * np.pi * motion.frequency * (fine - motion.start))
        flat = before[line] + within * rise
        before, after = flat + wave[:-1], flat + rise / parts[line] + wave[1:]
        time = fine
    return Lines(time, before, after)


def divided(parts: NDArray[np.int64]) -> tuple[NDArray[np.int64], FloatArray]:
    """Divide each segment in so many parts; return the segment of each part, and its position from 0 to 1 in it."""
    line = np.repeat(np.arange(len(parts)), parts)
    return line, (np.arange(len(line)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[line]


def histories(motion: Motion, component: Component = "ax") -> BaseHistories:
    """Compute velocity, displacement and Arias intensity over time; exact for samples."""
    lines = lines_of(motion, component)
    h, a, b, velocity = lines.steps, lines.before, lines.after, lines.velocity
    displacement = _running(h * velocity[:-1] + h * h * (2.0 * a + b) / 6.0)
    husid = np.pi / (2.0 * STANDARD_GRAVITY) * _running(h * (a * a + a * b + b * b) / 3.0)
    return BaseHistories(lines.time, velocity, displacement, husid)


def pgv(motion: Motion, component: Component = "ax") -> float:
    """Return the peak ground velocity of a component (m/s), without the other measures of `intensity`."""
    lines = lines_of(motion, component)
    return oscillator.peak(lines.steps, lines.velocity, lines.before, lines.after)


def intensity(motion: Motion, component: Component = "ax") -> Intensity:
    """Compute the intensity measures of a component. Raises InputError if it is zero throughout."""
    lines, base = lines_of(motion, component), histories(motion, component)
    h, u = lines.steps, base.displacement
    arias = float(base.husid[-1])
    if not arias > 0.0:
        raise InputError(f"{component}: is zero throughout, must be an acceleration")
    start, end = (_time_of(base.husid, lines, part * arias) for part in (0.05, 0.95))  # of the significant duration
    return Intensity(
        pga=motion.peak(component),
        pgv=oscillator.peak(h, base.velocity, lines.before, lines.after),
        pgd=oscillator.peak(h, u, base.velocity[:-1], base.velocity[1:]),
        final_velocity=float(base.velocity[-1]),
        final_displacement=float(u[-1]),
        arias=arias,
        start=start,
        end=end,
    )


def _time_of(husid: FloatArray, lines: Lines, wanted: float) -> float:
    """Return the time (s) at which the Arias intensity reaches a positive value; exact within the segment, a cubic."""
    k = int(np.searchsorted(husid, wanted)) - 1
    most = max(abs(float(lines.before[k])), abs(float(lines.after[k])))
    a, b, h = float(lines.before[k]) / most, float(lines.after[k]) / most, float(lines.steps[k])
    # with x the acceleration at that time, h (x^3 - a^3) / (3 (b - a)) is the integral of its square up to there
    squares = (wanted - float(husid[k])) * 2.0 * STANDARD_GRAVITY / (np.pi * h * most**2)
    x = float(np.cbrt(a**3 + 3.0 * (b - a) * squares))
    return float(lines.time[k]) + h * min(1.0, 3.0 * squares / (x * x + x * a + a * a))


def spectrum(
    motion: Motion,
    periods: Sequence[float] | FloatArray | None = None,
    damping: float = DAMPING,
    component: Component = "ax",
) -> Spectrum:
    """Compute the response spectrum of a component.

    It is exact for the motion as line segments from sample to sample; between two instants, at least ten per period,
    the peak is that of a cubic.

    Parameters
    ----------
    motion : Motion
        The motion of the base.
    periods : array-like of shape (p,), optional
        The periods (s); 120 from 0.05 to 10 s by default.
    damping : float
        The damping ratio, at least 0 and less than 1.
    component : {"ax", "ay", "az"}
        The component.

    Raises
    ------
    InputError
        If a period is not positive, the damping is out of range, or the samples are too far apart, or too uneven, for
        the shortest period.
    """
    period = _periods(periods)
    sd = np.zeros(len(period))
    for chosen, steps, ((u, v),) in _oscillations(motion, period, damping, (component,)):
        free = oscillator.free_peak(u[-1], v[-1], 2.0 * np.pi / period[chosen], damping)
        sd[chosen] = np.maximum(oscillator.peaks(steps, u, v[:-1], v[1:]), free)
    return Spectrum(period, sd, damping)


def rotd(
    motion: Motion,
    percentile: float,
    periods: Sequence[float] | FloatArray | None = None,
    damping: float = DAMPING,
) -> Spectrum:
    """Compute the spectrum RotD of two horizontal components: a percentile of the spectra over all orientations.

    Parameters
    ----------
    motion : Motion
        The motion of the base.
    percentile : float
        50 for RotD50, 100 for RotD100.
    periods, damping
        As of `spectrum`, whose errors are raised.
    """
    percentile = check_number("percentile", percentile, (0.0, 100.0), "a percentile, from 0 to 100")
    period = _periods(periods)
    sd = np.zeros(len(period))
    for chosen, steps, both in _oscillations(motion, period, damping, ("ax", "ay")):
        for column, k in enumerate(chosen):
            (u, v), (across, v_across) = ((u[:, column], v[:, column]) for u, v in both)
            largest = []
            for angles in np.array_split(ANGLES, min(len(ANGLES), 1 + len(ANGLES) * len(u) // AT_ONCE)):
                turned, speed = (
                    np.outer(x, np.cos(angles)) + np.outer(y, np.sin(angles)) for x, y in ((u, across), (v, v_across))
                )
                free = oscillator.free_peak(turned[-1], speed[-1], 2.0 * np.pi / period[k], damping)
                largest.append(np.maximum(oscillator.peaks(steps, turned, speed[:-1], speed[1:]), free))
            sd[k] = np.percentile(np.concatenate(largest), percentile)
    return Spectrum(period, sd, damping)


def _periods(given: Sequence[float] | FloatArray | None) -> FloatArray:
    """Return periods as an array, by default PERIODS. Raises InputError unless they are a list of numbers."""
    meaning = "a list of positive times in s, at least one"
    periods = numbers_of("periods", PERIODS if given is None else given, 1, meaning)
    if not periods.size:
        raise InputError(f"periods = {shown(given)}: must be {meaning}")
    return periods


def _oscillations(
    motion: Motion, period: FloatArray, damping: float, components: Sequence[Component]
) -> Iterator[tuple[NDArray[np.int64], FloatArray, list[tuple[FloatArray, FloatArray]]]]:
    """Yield the indices of some oscillators, the intervals, and for each component u and v, (instants, oscillators).

    Raises InputError as `spectrum`.
    """
    for t in period.tolist():
        check_number("period", t, POSITIVE, "a positive time in s")
    damping = check_number("damping", damping, *DAMPINGS)
    every = [lines_of(motion, component) for component in components]
    lines = every[0]
    longest, shortest = float(np.max(lines.steps)), float(np.min(lines.steps))
    # the number of parts of each segment, a power of 2, so that a period has at least PER_PERIOD instants
    wanted = np.maximum(1.0, 2.0 ** np.ceil(np.log2(PER_PERIOD * longest / period)))
    if np.max(wanted) * len(lines.steps) > MOST_LINES or longest > UNEVEN * shortest:
        raise InputError(
            f"time: samples {shortest:.4g} to {longest:.4g} s apart, must be closer and more even for a spectrum from "
            f"{np.min(period):.4g} s on"
        )
    # make durations equal that differ only by rounding, so that few distinct values remain
    parts, unit = wanted.astype(np.int64), 1e-9 * longest
    even = np.maximum(np.round(lines.steps / unit), 1.0) * unit
    for chosen in _together(parts, len(lines.steps)):
        count = int(parts[chosen[0]])
        steps = np.repeat(even / count, count)
        found = []
        for one in every:
            rise = (one.after - one.before) / count
            before = (one.before[:, None] + rise[:, None] * np.arange(count)).ravel()
            after = before + np.repeat(rise, count)
            found.append(oscillator.response(steps, before, after, 2.0 * np.pi / period[chosen], damping))
        yield chosen, steps, found


def _together(parts: NDArray[np.int64], lines: int) -> Iterator[NDArray[np.int64]]:
    """Yield the indices of oscillators with the same division of the segments, in groups that fit into memory."""
    for count in np.unique(parts):
        same = np.flatnonzero(parts == count)
        yield from np.array_split(same, -(-len(same) * count * lines // AT_ONCE))


def _running(parts: FloatArray) -> FloatArray:
    """Return the cumulative sums, from 0."""
    return np.append(0.0, np.cumsum(parts))
