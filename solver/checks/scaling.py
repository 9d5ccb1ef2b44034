"""Motions scaled to an action: to a peak, to the spectral acceleration at one period, to a spectrum over periods.

Of two horizontal components the geometric mean counts, and both get the same factor: EN 1998-1, 3.2.2.1(3), describes
both by one spectrum, so that neither is the main one, and their ratio and phase are part of the record.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common.errors import POSITIVE, InputError, check_number
from ..ground.intensity import Component, components, peak, spectrum
from ..ground.motion import Motion
from .spectra import DAMPING, FloatArray, Spectral, TargetSpectrum

FEWEST, MEAN_FROM = 3, 7  # motions: EN 1998-1, 4.3.3.4.3(3)
LEAST_PART = 0.9  # of the target, that the mean spectrum keeps: EN 1998-1, 3.2.3.1.2(4)
MOST_RAISED = 1.15  # factor on artificial motions; those of the spectra of codes need 1.07, one alone
PERIODS_OF_FIT = 40
USUAL_FACTOR, MOST_FACTOR = (
    10.0,
    100.0,
)  # on records, and their inverses: the first is said, the other refused
VERTICAL_RANGE = (0.05, 1.0)  # s, of the fit of vertical components: plateau and next branch of the codes


def horizontal_psa(motion: Motion, periods: FloatArray, damping: float = DAMPING) -> FloatArray:
    """Pseudo-acceleration, m/s2, at periods, s (p,), of a motion that is not zero: of two components their mean."""
    found = [spectrum(motion, periods, damping, component).psa for component in _horizontal(motion)]
    return np.sqrt(found[0] * found[1]) if len(found) > 1 else found[0]


def horizontal_pga(motion: Motion) -> float:
    """Largest horizontal acceleration, m/s2; of two components the geometric mean of both."""
    found = [peak(motion, component) for component in _horizontal(motion)]
    return math.sqrt(found[0] * found[1]) if len(found) > 1 else found[0]


def _horizontal(motion: Motion) -> list[Component]:
    """Horizontal components that are not zero throughout; without any ax."""
    there = components(motion) if motion.has_ay else []
    return [component for component in there if component != "az"] or ["ax"]


class ScaledMotion(NamedTuple):
    """A motion as it is applied, and the factors that it was scaled by."""

    name: str
    motion: Motion
    factor: float = 1.0
    vertical_factor: float = 1.0


@dataclass(frozen=True, eq=False)
class MotionSpectra:
    """The spectrum of several motions taken as one: the mean of seven and more, the largest of fewer."""

    motions: tuple[Motion, ...]

    def psa(self, period: ArrayLike, damping: float = DAMPING) -> FloatArray:
        """Horizontal pseudo-acceleration, m/s2, at periods, s, of any shape; that of the ground at 0."""
        period = np.asarray(period, dtype=np.float64)
        each = np.repeat([[horizontal_pga(motion)] for motion in self.motions], period.size, axis=1)
        moving = period.ravel() > 0.0
        for k, motion in enumerate(self.motions if moving.any() else ()):
            each[k, moving] = horizontal_psa(motion, period.ravel()[moving], damping)
        return statistic(each).reshape(period.shape)


def statistic(values: ArrayLike) -> FloatArray:
    """The value that counts of several motions, along the first axis: the mean of seven and more, else the largest.

    EN 1998-1, 4.3.3.4.3(3). An infinite value, of a column that falls, makes a mean infinite.
    """
    values = np.asarray(values, dtype=np.float64)
    return np.asarray(np.mean(values, axis=0) if len(values) >= MEAN_FROM else np.max(values, axis=0))


def check_factors(scaled: Sequence[ScaledMotion], force: bool) -> None:
    """Raise InputError for a factor that no record bears, unless `force`: its noise would decide."""
    for one in scaled:
        factor = _farthest(one)
        if not force and not 1.0 / MOST_FACTOR <= abs(factor) <= MOST_FACTOR:
            raise InputError(
                f"{one.name}: a factor of {factor:.3g}, must be {1.0 / MOST_FACTOR:g} to {MOST_FACTOR:g}: choose "
                "another record, or check its units; --force-scale, force_scale, applies it"
            )


def factor_lines(scaled: Sequence[ScaledMotion]) -> list[str]:
    """Return a line that names the motions whose factors are beyond those that guides accept; mostly none."""
    far = [one for one in scaled if not 1.0 / USUAL_FACTOR <= abs(_farthest(one)) <= USUAL_FACTOR]
    if not far:
        return []
    named = ", ".join(f"{one.name} ({_farthest(one):.3g})" for one in far[:4]) + (", ..." if len(far) > 4 else "")
    return [
        f"Factors beyond {1.0 / USUAL_FACTOR:g} to {USUAL_FACTOR:g} on {len(far)} of {len(scaled)} motions: {named}. "
        "Records scaled that far are of another kind of earthquake, or noise; guides accept 0.25 to 4."
    ]


def _farthest(scaled: ScaledMotion) -> float:
    """Return the factor of a motion, horizontal or vertical, that is farther from 1."""
    there = [scaled.factor, scaled.vertical_factor] if np.any(scaled.motion.az) else [scaled.factor]
    return max(there, key=lambda factor: abs(math.log(abs(factor) or 1e-300)))


def applied(name: str, motion: Motion, factor: float, vertical_factor: float | None = None) -> ScaledMotion:
    """The motion with its components times factors; None: the vertical one goes along."""
    vertical = factor if vertical_factor is None else vertical_factor
    scaled = motion.scaled(factor)
    if vertical != factor:
        scaled = replace(scaled, az=vertical * motion.az)
    return ScaledMotion(name, scaled, factor, vertical)


def scaled_to_pga(motions: Mapping[str, Motion], pga: float, vertical_pga: float | None = None) -> list[ScaledMotion]:
    """Each motion to the same largest horizontal acceleration, m/s2; the vertical goes along, or has its own.

    Raises InputError for a motion that is zero.
    """
    pga = check_number("pga", pga, POSITIVE, "an acceleration in m/s2")
    found = []
    for name, motion in motions.items():
        largest = float(np.max(np.abs(motion.az)))
        vertical = vertical_pga / largest if vertical_pga is not None and largest else None
        found.append(applied(name, motion, pga / _nonzero(name, horizontal_pga(motion)), vertical))
    return found


def scaled_to_sa(motions: Mapping[str, Motion], period: float, sa: float) -> list[ScaledMotion]:
    """Each motion to the same spectral acceleration sa, m/s2, of 5 % damping at one period, s; vertical goes along."""
    sa = check_number("sa", sa, POSITIVE, "an acceleration in m/s2")
    return [
        applied(name, motion, sa / _nonzero(name, float(horizontal_psa(motion, np.array([period]))[0])))
        for name, motion in motions.items()
    ]


@dataclass(frozen=True, eq=False)
class Fit:
    """Motions, their horizontal or vertical spectra, and the target for these over a range of periods, s."""

    motions: Mapping[str, Motion]
    target: Spectral
    range: tuple[float, float]
    upright: bool = False

    @cached_property
    def periods(self) -> FloatArray:
        """Periods at which spectra are compared, s."""
        return np.geomspace(*self.range, PERIODS_OF_FIT)

    @cached_property
    def ratios(self) -> FloatArray:
        """Response over target of each motion, (motions, periods)."""
        found = [
            spectrum(motion, self.periods, component="az").psa if self.upright else horizontal_psa(motion, self.periods)
            for motion in self.motions.values()
        ]
        return np.array(found) / self.target.psa(self.periods)

    def factors(self, least: float) -> list[float]:
        """A factor for each motion.

        First each to a geometric mean of 1 over the target; then all by one more, so that the mean of their spectra is
        nowhere below `least` times the target. It does not make them smaller.
        """
        own = np.exp(-np.mean(np.log(self.ratios), axis=1))
        common = self.common(least, own)
        return [float(common * factor) for factor in own]

    def common(self, least: float, own: FloatArray | float = 1.0) -> float:
        """The factor, not below 1, by which the mean of the spectra times `own` is nowhere below `least`."""
        return max(1.0, least / float(np.min(self.mean(own))))

    def mean(self, own: FloatArray | float = 1.0) -> FloatArray:
        """Mean over the motions of response times `own` over target (periods,)."""
        return np.mean(self.ratios * np.reshape(own, (-1, 1)), axis=0)


def scaled_to_spectrum(
    motions: Mapping[str, Motion], target: TargetSpectrum, periods: Sequence[float], least: float = LEAST_PART
) -> list[ScaledMotion]:
    """Motions whose spectra follow a target over a range of periods, s; vertical components follow the vertical one.

    least: part of the target below which the mean of their spectra must not be (`Fit.factors`); 0: no such rule.
    Raises InputError.
    """
    shortest, longest = check_periods(periods)
    least = check_least(least)
    for name, motion in motions.items():
        _nonzero(name, horizontal_pga(motion))
    factors = Fit(motions, target, (shortest, longest)).factors(least)
    upright = {name: motion for name, motion in motions.items() if np.any(motion.az)}
    vertical: dict[str, float] = {}
    if target.vertical is not None and upright:
        fit = Fit(upright, target.vertical, VERTICAL_RANGE, upright=True)
        vertical = dict(zip(upright, fit.factors(least), strict=True))
    return [
        applied(name, motion, factor, vertical.get(name))
        for (name, motion), factor in zip(motions.items(), factors, strict=True)
    ]


def raised_to_spectrum(
    motions: Mapping[str, Motion], target: TargetSpectrum, periods: Sequence[float], least: float = LEAST_PART
) -> list[ScaledMotion]:
    """Artificial motions, all by one factor so that the mean of their spectra is nowhere below `least` of the target.

    Vertical components have a factor of their own. Raises InputError where it takes more than MOST_RAISED: where the
    target is too rough for them.
    """
    span, least = check_periods(periods), check_least(least)
    factor, vertical = _raise(Fit(motions, target, span), target.name, least), None
    if target.vertical is not None and all(np.any(motion.az) for motion in motions.values()):
        vertical = _raise(Fit(motions, target.vertical, VERTICAL_RANGE, upright=True), f"vertical {target.name}", least)
    return [applied(name, motion, factor, vertical) for name, motion in motions.items()]


def _raise(fit: Fit, name: str, least: float) -> float:
    common, mean = fit.common(least), fit.mean()
    if not common <= MOST_RAISED:
        k = int(np.argmin(mean))
        raise InputError(
            f"{name}: artificial motions reach {mean[k]:.2g} of it at {fit.periods[k]:.3g} s, must be {least:g}: "
            "records, another range of periods (periods) or a smoother spectrum may help"
        )
    return common


def check_periods(periods: Sequence[float]) -> tuple[float, float]:
    """A range of periods, s. Raises InputError."""
    shortest, longest = (check_number("periods", t, (1e-3, 100.0), "periods in s, up to 100") for t in periods)
    if not shortest < longest:
        raise InputError(f"periods = {shortest:g} {longest:g}: must be the shorter first")
    return shortest, longest


def check_least(least: float) -> float:
    """A part of the target. Raises InputError."""
    return check_number("least", least, (0.0, 1.0), "a part of the target from 0 to 1")


def _nonzero(name: str, size: float) -> float:
    if not size > 0.0:
        raise InputError(f"{name}: the motion is zero throughout and cannot be scaled")
    return size
