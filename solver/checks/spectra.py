"""The elastic spectra of codes, and spectra from tables: pseudo-acceleration over period and damping.

EN 1998-1:2004, 3.2.2.2 and 3.2.2.3, with the recommended values of its tables 3.2 to 3.4; NTC 2018 (D.M. 17/01/2018),
3.2.3.2.1 and 3.2.3.2.2. Both have one shape, between the corner periods TB, TC and TD.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.errors import InputError, check_number, reading, shown
from ..common.files import MB, printable
from ..common.ranges import check_choice
from ..common.text import lines_of
from ..common.text_tables import TextTable, table_of
from ..ground.motion import STANDARD_GRAVITY

FloatArray = NDArray[np.float64]

DAMPING = 0.05  # damping ratio of the spectra of codes
LEAST_ETA = 0.55
SOILS = ("A", "B", "C", "D", "E")
# S, TB s, TC s, TD s by type and ground: EN 1998-1, tables 3.2 and 3.3
_EUROCODE = {
    (1, "A"): (1.0, 0.15, 0.4, 2.0),
    (1, "B"): (1.2, 0.15, 0.5, 2.0),
    (1, "C"): (1.15, 0.20, 0.6, 2.0),
    (1, "D"): (1.35, 0.20, 0.8, 2.0),
    (1, "E"): (1.4, 0.15, 0.5, 2.0),
    (2, "A"): (1.0, 0.05, 0.25, 1.2),
    (2, "B"): (1.35, 0.05, 0.25, 1.2),
    (2, "C"): (1.5, 0.10, 0.25, 1.2),
    (2, "D"): (1.8, 0.10, 0.30, 1.2),
    (2, "E"): (1.6, 0.05, 0.25, 1.2),
}
_VERTICAL_PART = {1: 0.9, 2: 0.45}  # avg / ag: table 3.4
_VERTICAL_CORNERS = (0.05, 0.15, 1.0)  # s, of both codes
# NTC 2018, table 3.2.IV: least, constant and slope of SS in F0 ag / g, most; factor and exponent of CC in TC*
_NTC = {
    "A": ((1.0, 1.0, 0.0, 1.0), (1.0, 0.0)),
    "B": ((1.0, 1.4, -0.4, 1.2), (1.1, -0.2)),
    "C": ((1.0, 1.7, -0.6, 1.5), (1.05, -0.33)),
    "D": ((0.9, 2.4, -1.5, 1.8), (1.25, -0.5)),
    "E": ((1.0, 2.0, -1.1, 1.6), (1.15, -0.4)),
}
_NTC_TOPOGRAPHY = {"T1": 1.0, "T2": 1.2, "T3": 1.2, "T4": 1.4}  # table 3.2.V, at the top of the slope
LIMITS_OF_AG = (1e-3, 100.0)  # m/s2
MOST_TABLE = MB
SAME_PERIOD = 1e-6  # relative tolerance of periods, for rounding
MOST_PSA = 10.0 * STANDARD_GRAVITY  # largest value of a table; more is a mistake of units
UNITS = {"g": STANDARD_GRAVITY, "m/s2": 1.0}


class Spectral(Protocol):
    """A spectrum of pseudo-acceleration: of a code, or of motions."""

    def psa(self, period: ArrayLike, damping: float = DAMPING) -> FloatArray:
        """Return the pseudo-acceleration (m/s2) at periods (s) and a damping ratio; at period 0 that of the ground."""
        ...


def damping_factor(damping: float) -> float:
    """Return the factor eta on a spectrum of 5 %, for a damping ratio: EN 1998-1 (3.6), NTC 2018 (3.2.4)."""
    return max(math.sqrt(10.0 / (5.0 + 100.0 * damping)), LEAST_ETA)


@dataclass(frozen=True)
class CornerSpectrum:
    """A spectrum with corner periods: EN 1998-1 (3.2) to (3.5), NTC 2018 (3.2.2) and (3.2.10).

    Beyond 4 s, where EN 1998-1 ends, the displacement stays constant.
    """

    pga: float  # m/s2, at period 0, on the ground there
    amplification: float  # ratio of the plateau to pga at 5 % damping
    tb: float  # s
    tc: float  # s
    td: float  # s

    def psa(self, period: ArrayLike, damping: float = DAMPING) -> FloatArray:
        """Return the pseudo-acceleration (m/s2) at periods (s)."""
        t = np.asarray(period, dtype=np.float64)
        top = damping_factor(damping) * self.amplification
        beyond = np.maximum(t, self.tc)
        falling = self.tc / beyond * np.minimum(1.0, self.td / beyond)
        return self.pga * np.where(t < self.tb, 1.0 + t / self.tb * (top - 1.0), top * falling)


@dataclass(frozen=True, eq=False)
class TableSpectrum:
    """A spectrum of 5 % damping from a table, interpolated in logarithms.

    Before the first period it is linear from the peak of the ground, if the table has it, else constant; beyond the
    last it falls with the square of the period. Other damping ratios use the factor of the codes (`damping_factor`).
    """

    period: FloatArray  # (m,) s, increasing, above 0
    values: FloatArray  # (m,) m/s2
    pga: float | None = None  # m/s2, at period 0

    def psa(self, period: ArrayLike, damping: float = DAMPING) -> FloatArray:
        """Return the pseudo-acceleration (m/s2) at periods (s)."""
        given = np.asarray(period, dtype=np.float64)
        t = np.maximum(given, self.period[0])
        within = np.exp(np.interp(np.log(t), np.log(self.period), np.log(self.values)))
        beyond: FloatArray = np.minimum(1.0, self.period[-1] / t) ** 2
        found = damping_factor(damping) * within * beyond
        if self.pga is None:
            return found
        # linear down to the PGA, which does not depend on damping
        part = np.minimum(given / self.period[0], 1.0)
        return np.where(part < 1.0, (1.0 - part) * self.pga + part * found, found)

    def outside(self, shortest: float, longest: float) -> list[str]:
        """Return a line for each end at which a use from `shortest` to `longest` (s) leaves the table."""
        lines, (first, last) = [], (float(self.period[0]), float(self.period[-1]))
        if shortest < first * (1.0 - SAME_PERIOD) and self.pga is None:
            value = float(self.values[0]) / STANDARD_GRAVITY
            lines.append(
                f"the table begins at {first:.4g} s and is read from {shortest:.3g} s: its first value, {value:.4g} g, "
                "is kept down to period 0; add a row for period 0, the PGA"
            )
        if longest > last * (1.0 + SAME_PERIOD):
            value = float(self.psa(longest)) / STANDARD_GRAVITY
            lines.append(
                f"the table ends at {last:.4g} s and is read to {longest:.3g} s, where 1/T^2 makes it {value:.4g} g; "
                "codes have more up to TD"
            )
        return lines


@dataclass(frozen=True, eq=False)
class TargetSpectrum:
    """The target of a check: a horizontal spectrum, and a vertical one if the source has it."""

    name: str
    horizontal: Spectral
    vertical: Spectral | None = None

    def psa(self, period: ArrayLike, damping: float = DAMPING) -> FloatArray:
        """Return the horizontal pseudo-acceleration (m/s2) at periods (s)."""
        return self.horizontal.psa(period, damping)

    @property
    def longest(self) -> float:
        """The longest period of a table (s); infinite for a code."""
        if not isinstance(self.horizontal, TableSpectrum):
            return math.inf
        return float(self.horizontal.period[-1]) * (1.0 + SAME_PERIOD)

    def outside(self, shortest: float, longest: float) -> list[str]:
        """Return a line for each end at which a use from `shortest` to `longest` (s) leaves a table."""
        return self.horizontal.outside(shortest, longest) if isinstance(self.horizontal, TableSpectrum) else []


def eurocode8(ag: float, soil: str, kind: int = 1) -> TargetSpectrum:
    """Return the elastic spectrum of EN 1998-1:2004, with its recommended values.

    Parameters
    ----------
    ag : float
        Design ground acceleration on ground A (m/s2), the importance factor included.
    soil : str
        Ground type, A to E.
    kind : int
        Type of the spectrum, 1 or 2.

    Returns
    -------
    TargetSpectrum
        The horizontal and the vertical spectrum.

    Raises
    ------
    InputError
        If a value is out of range.
    """
    ag = _acceleration(ag)
    if kind not in _VERTICAL_PART:
        raise InputError(f"type = {shown(kind)}: must be 1 or 2")
    check_choice("soil", soil, SOILS)
    factor, *corners = _EUROCODE[kind, soil]
    name = f"EN 1998-1 type {kind}, ground {soil}, ag {ag / STANDARD_GRAVITY:.4g} g"
    return _of_code(name, CornerSpectrum(factor * ag, 2.5, *corners), _VERTICAL_PART[kind] * ag, 3.0)


def ntc2018(ag: float, f0: float, tc_star: float, soil: str, topography: str = "T1") -> TargetSpectrum:
    """Return the elastic spectrum of NTC 2018 for a site and a limit state.

    Parameters
    ----------
    ag : float
        Design ground acceleration on rock (m/s2), of the annexes.
    f0 : float
        Largest amplification F0, of the annexes.
    tc_star : float
        Period TC* (s), of the annexes.
    soil : str
        Soil category, A to E.
    topography : str
        Topographic category, T1 to T4.

    Returns
    -------
    TargetSpectrum
        The horizontal and the vertical spectrum.

    Raises
    ------
    InputError
        If a value is out of range.
    """
    ag = _acceleration(ag)
    f0 = check_number("F0", f0, (1.0, 10.0), "an amplification from 1 to 10; NTC 2018 has 2.2 and more")
    tc_star = check_number("TC", tc_star, (0.01, 5.0), "TC* in s, from 0.01 to 5")
    check_choice("soil", soil, SOILS)
    check_choice("topography", topography, _NTC_TOPOGRAPHY)
    (least, constant, slope, most), (factor, power) = _NTC[soil]
    in_g, slope_factor = ag / STANDARD_GRAVITY, _NTC_TOPOGRAPHY[topography]
    # S = SS ST and TC = CC TC*
    ground = min(max(constant + slope * f0 * in_g, least), most)
    tc = factor * tc_star**power * tc_star
    vertical = 1.35 * math.sqrt(in_g) * ag * slope_factor  # ag Fv / F0, (3.2.11)
    name = f"NTC 2018, soil {soil}, topography {topography}, ag {in_g:.4g} g, F0 {f0:g}, TC* {tc_star:g} s"
    horizontal = CornerSpectrum(ground * slope_factor * ag, f0, tc / 3.0, tc, 4.0 * in_g + 1.6)
    return _of_code(name, horizontal, vertical, f0)


def _of_code(name: str, horizontal: CornerSpectrum, vertical_pga: float, amplification: float) -> TargetSpectrum:
    """Return the target of a code, whose vertical spectrum has this peak (m/s2) and plateau over the peak."""
    return TargetSpectrum(name, horizontal, CornerSpectrum(vertical_pga, amplification, *_VERTICAL_CORNERS))


def spectrum_from_csv(path: str | os.PathLike[str]) -> TargetSpectrum:
    """Read a spectrum of 5 % damping from a CSV table; its first line is `period,g` or `period,m/s2`.

    Periods (s) increase; the first may be 0, with the peak of the ground. Raises InputError that begins with `path`.
    """
    with reading(path):
        table = table_of(lines_of(path, MOST_TABLE))
        header = [name.lower() for name in table.names]
        if len(header) != 2 or header[0] != "period" or header[1] not in UNITS:
            raise InputError(f"line 1: must be period,g or period,m/s2, not {shown(table.title[:80])}")
        spectrum = _spectrum_of(table, UNITS[header[1]])
    return TargetSpectrum(printable(os.fspath(path)), spectrum)


def _spectrum_of(table: TextTable, unit: float) -> TableSpectrum:
    """Return the spectrum of a table of periods (s) and values in `unit` (m/s2). Raises InputError."""
    found: list[tuple[float, float]] = []
    for line, row, (period, value) in zip(table.lines, table.rows, table.numbers().tolist(), strict=True):
        if not (period >= 0.0 and value > 0.0):
            raise InputError(f"line {line}: {shown(','.join(row))}, must be a period, 0 or more, and a positive value")
        if not unit * value <= MOST_PSA:
            raise InputError(f"line {line}: {shown(','.join(row))}, must be at most {MOST_PSA / STANDARD_GRAVITY:g} g")
        if found and not found[-1][0] < period:
            raise InputError(f"line {line}: period {period:g} s, must be above the one before, {found[-1][0]:g} s")
        found.append((period, unit * value))
    pga = found.pop(0)[1] if found and found[0][0] == 0.0 else None
    if len(found) < 2:
        raise InputError("must have at least two periods above 0")
    periods, values = np.array(found).T
    return TableSpectrum(periods, values, pga)


def _acceleration(ag: float) -> float:
    return check_number("ag", ag, LIMITS_OF_AG, "an acceleration in m/s2, from 0.001 to 100")
