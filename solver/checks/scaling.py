"""Motions scaled to an action: to a peak, to the spectral acceleration at one period, to a spectrum over periods.

Of two horizontal components the geometric mean counts, and both get the same factor: EN 1998-1, 3.2.2.1(3), describes
both by one spectrum, so that neither is the main one, and their ratio and phase are part of the record.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common.errors import POSITIVE, InputError, check_number
from ..common.tables import vector_of
from ..ground.intensity import Component, components, spectrum
from ..ground.motion import Motion
from .spectra import DAMPING, FloatArray, Spectral, TargetSpectrum

FEWEST, MEAN_FROM = 3, 7  # least numbers of motions, and of those whose mean counts: EN 1998-1, 4.3.3.4.3(3)
LEAST_PART = 0.9  # least ratio of the mean spectrum to the target: EN 1998-1, 3.2.3.1.2(4)
MOST_RAISED = 1.2  # largest factor on artificial motions; for spectra of codes a single motion needs 1.16
PERIODS_OF_FIT, FINER = 40, 5  # periods of the means of single motions; intervals between two of them for the least
# on records, and their inverses: beyond the first a caution, beyond the second an error
USUAL_FACTOR, MOST_FACTOR = 10.0, 100.0
VERTICAL_RANGE = (0.05, 1.0)  # s, range of the fit of vertical components: plateau and next branch of the codes


def horizontal_psa(motion: Motion, periods: FloatArray, damping: float = DAMPING) -> FloatArray:
    """Return the horizontal pseudo-acceleration (m/s2) of a motion that is not zero at periods (s), (p,).

    Of two components it is the geometric mean.
    """
    return horizontal(motion, lambda component: spectrum(motion, periods, damping, component).psa)


def horizontal_pga(motion: Motion) -> float:
    """Return the largest horizontal acceleration (m/s2); of two components the geometric mean."""
    return float(horizontal(motion, motion.peak))


def horizontal(motion: Motion, value: Callable[[Component], ArrayLike]) -> FloatArray:
    """Return a value of the horizontal components that are not zero; of two the geometric mean."""
    found = [np.asarray(value(component), dtype=np.float64) for component in horizontal_of(motion)]
    return np.sqrt(found[0] * found[1]) if len(found) > 1 else found[0]


def horizontal_of(motion: Motion) -> list[Component]:
    """Return the horizontal components that are not zero throughout; ["ax"] if there are none."""
    there = components(motion) if motion.has_ay else []
    return [component for component in there if component != "az"] or ["ax"]


class ScaledMotion(NamedTuple):
    """A motion as applied, and the factors by which it was scaled."""

    name: str
    motion: Motion
    factor: float = 1.0
    vertical_factor: float = 1.0


@dataclass(frozen=True, eq=False)
class MotionSpectra:
    """The joint spectrum of several motions: the mean of seven and more, the largest of fewer."""

    motions: tuple[Motion, ...]

    def psa(self, period: ArrayLike, damping: float = DAMPING) -> FloatArray:
        """Return the horizontal pseudo-acceleration (m/s2) at periods (s) of any shape; the peak of the ground at 0."""
        period = np.asarray(period, dtype=np.float64)
        each = np.repeat([[horizontal_pga(motion)] for motion in self.motions], period.size, axis=1)
        moving = period.ravel() > 0.0
        for k, motion in enumerate(self.motions if moving.any() else ()):
            each[k, moving] = horizontal_psa(motion, period.ravel()[moving], damping)
        return statistic(each).reshape(period.shape)


def statistic(values: ArrayLike) -> FloatArray:
    """Return the statistic over several motions, along the first axis: mean of seven and more, else largest.

    EN 1998-1, 4.3.3.4.3(3). An infinite value, of a column that falls, makes a mean infinite.
    """
    values = np.asarray(values, dtype=np.float64)
    return np.asarray(np.mean(values, axis=0) if len(values) >= MEAN_FROM else np.max(values, axis=0))


def check_factors(scaled: Sequence[ScaledMotion], force: bool) -> None:
    """Raise InputError for a factor beyond 0.01 to 100, at which noise decides, unless `force`."""
    for one in scaled:
        factor = _farthest(one)
        if not force and not 1.0 / MOST_FACTOR <= abs(factor) <= MOST_FACTOR:
            raise InputError(
                f"{one.name}: a factor of {factor:.3g}, must be {1.0 / MOST_FACTOR:g} to {MOST_FACTOR:g}: choose "
                "another record, or check its units; --force-scale, force_scale, applies it"
            )


def factor_lines(scaled: Sequence[ScaledMotion]) -> list[str]:
    """Return a line that names the motions with factors beyond 0.1 to 10; empty if there are none."""
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
    """Scale a motion: `factor` is that on the horizontal components, `vertical_factor` by default the same."""
    vertical = factor if vertical_factor is None else vertical_factor
    scaled = motion.scaled(factor)
    if vertical != factor:
        scaled = replace(scaled, az=vertical * motion.az)
    return ScaledMotion(name, scaled, factor, vertical)


def scaled_to_pga(motions: Mapping[str, Motion], pga: float, vertical_pga: float | None = None) -> list[ScaledMotion]:
    """Scale each motion to the same largest horizontal acceleration `pga` (m/s2), of two components the geometric mean.

    `vertical_pga` is the largest vertical acceleration (m/s2); by default the vertical component gets the factor of the
    horizontal ones. Raises InputError if a motion is zero or lacks the vertical component to be scaled, or a value is
    not positive.
    """
    pga = check_number("pga", pga, POSITIVE, "a positive acceleration in m/s2")
    if vertical_pga is not None:
        check_number("vertical_pga", vertical_pga, POSITIVE, "a positive acceleration in m/s2")
    found = []
    for name, motion in motions.items():
        largest = float(np.max(np.abs(motion.az)))
        if vertical_pga is not None and not largest:
            raise InputError(f"vertical_pga: must be left out, {name} has no vertical component")
        vertical = None if vertical_pga is None else vertical_pga / largest
        found.append(applied(name, motion, pga / _nonzero(name, horizontal_pga(motion)), vertical))
    return found


def scaled_to_sa(motions: Mapping[str, Motion], period: float, sa: float) -> list[ScaledMotion]:
    """Scale each motion to the same spectral acceleration `sa` (m/s2) of 5 % damping at one period (s).

    The vertical component gets the same factor. Raises InputError if a motion is zero, or `sa` is not positive.
    """
    sa = check_number("sa", sa, POSITIVE, "a positive acceleration in m/s2")
    return [
        applied(name, motion, sa / _nonzero(name, float(horizontal_psa(motion, np.array([period]))[0])))
        for name, motion in motions.items()
    ]


@dataclass(frozen=True, eq=False)
class Fit:
    """The motions, their horizontal or vertical spectra, and the target of these over a range of periods (s)."""

    motions: Mapping[str, Motion]
    target: Spectral
    range: tuple[float, float]
    upright: bool = False

    @cached_property
    def periods(self) -> FloatArray:
        """The periods at which spectra are compared (s)."""
        return np.geomspace(*self.range, FINER * (PERIODS_OF_FIT - 1) + 1)

    @cached_property
    def ratios(self) -> FloatArray:
        """The ratios of response to target of each motion, (motions, periods)."""
        found = [
            spectrum(motion, self.periods, component="az").psa if self.upright else horizontal_psa(motion, self.periods)
            for motion in self.motions.values()
        ]
        return np.array(found) / self.target.psa(self.periods)

    def factors(self, least: float) -> list[float]:
        """Return a factor for each motion.

        First each motion is scaled to a geometric mean ratio of 1; then all by one common factor, not below 1, so that
        the mean of their spectra is nowhere below `least` times the target.
        """
        own = np.exp(-np.mean(np.log(self.ratios[:, ::FINER]), axis=1))
        common = self.common(least, own)
        return [float(common * factor) for factor in own]

    def common(self, least: float, own: FloatArray | float = 1.0) -> float:
        """Return the least factor, 1 or more, at which the mean of the spectra times `own` is at least `least`."""
        return max(1.0, least / float(np.min(self.mean(own))))

    def mean(self, own: FloatArray | float = 1.0) -> FloatArray:
        """Return the mean over the motions of the ratios times `own`, (periods,)."""
        return np.mean(self.ratios * np.reshape(own, (-1, 1)), axis=0)


def scaled_to_spectrum(
    motions: Mapping[str, Motion], target: TargetSpectrum, periods: Sequence[float], least: float = LEAST_PART
) -> list[ScaledMotion]:
    """Scale motions so that their spectra follow a target over a range of periods (s), shortest and longest.

    Vertical components follow the vertical spectrum of the target, if it has one. `least` is the least ratio of the
    mean spectrum to the target (`Fit.factors`), 0 for no such rule. Raises InputError if a motion is zero, or a value
    is out of range.
    """
    shortest, longest = check_periods(periods)
    least = check_least(least)
    for name, motion in motions.items():
        _nonzero(name, horizontal_pga(motion))
    factors = Fit(motions, target, (shortest, longest)).factors(least)
    # vertical components have their own factors, if the target has a vertical spectrum
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
    """Scale artificial motions by one factor so that their mean spectrum is nowhere below `least` of the target.

    `periods` are the shortest and the longest (s); vertical components have a common factor of their own. Raises
    InputError if the factor would exceed MOST_RAISED, where the target is too rough to be fitted.
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
    """Return a range of periods (s) as two floats. Raises InputError."""
    limits, meaning = ((1e-3, 100.0), "a period in s, up to 100"), "two periods in s, the shorter first"
    shortest, longest = vector_of("periods", periods, 2, limits, meaning).tolist()
    if not shortest < longest:
        raise InputError(f"periods = {shortest:g} {longest:g}: must be the shorter first")
    return shortest, longest


def check_least(least: float) -> float:
    """Return a ratio to the target, 0 to 1, as a float. Raises InputError."""
    return check_number("least", least, (0.0, 1.0), "a part of the target from 0 to 1")


def _nonzero(name: str, size: float) -> float:
    if not size > 0.0:
        raise InputError(f"{name}: the motion is zero throughout and cannot be scaled")
    return size
