"""The action of a check: the motions, as given, scaled or artificial, and the spectrum that they represent."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ..common.digits import three_digits
from ..common.errors import InputError, check_type, shown
from ..common.files import printable
from ..ground.building import RIGID, Building, floor_motion
from ..ground.intensity import Component, pgv
from ..ground.motion import STANDARD_GRAVITY, Motion, check_in_plane
from . import scaling
from .artificial import SHORTEST, artificial_motions, with_component
from .scaling import Fit, MotionSpectra, ScaledMotion
from .spectra import Spectral, TargetSpectrum
from .subject import Subject

ARTIFICIAL = 7  # number of artificial motions: the least for which the mean counts
SHORTEST_PART, LONGEST_PART = 0.2, 2.0  # range over the first period: EN 1998-1, 3.2.3.1.2(4)
LONGEST_PERIOD = 4.0  # s, the end of the spectra of codes
OF_FLOORS = (
    "Factors and target are those of the ground; the building stays elastic, does not twist, and moves up and down "
    "with the ground."
)

Motions = Mapping[str, Motion] | Iterable[Motion | str | os.PathLike[str]]


@dataclass(frozen=True, eq=False, repr=False)
class Action:
    """The action on a subject: the motions as applied, and the spectrum that they represent."""

    motions: tuple[ScaledMotion, ...]
    how: str  # how they were scaled, in words
    target: TargetSpectrum | None = None
    periods: tuple[float, float] | None = None  # s, range in which the spectra of the ground follow the target
    ground: tuple[ScaledMotion, ...] = ()  # the motions of the ground, if those as applied are of a floor
    where: str = ""  # the floor and its building, in words
    shortfall: str = ""  # the sentence on a target of a floor that is below the ground's where a block rocks

    @cached_property
    def spectrum(self) -> Spectral:
        """The target spectrum; that of the motions if there is no target, or they are of a floor."""
        return (None if self.ground else self.target) or MotionSpectra(tuple(scaled.motion for scaled in self.motions))

    @cached_property
    def fit(self) -> tuple[float, float] | None:
        """The least and the largest ratio of the mean spectrum to the target over `periods`; None without a target."""
        if self.target is None or self.periods is None:
            return None
        mean = Fit({one.name: one.motion for one in self.ground or self.motions}, self.target, self.periods).mean()
        return float(np.min(mean)), float(np.max(mean))

    def on_floor(self, building: Building, floor: int) -> Action:
        """Return the action on a floor of a building, whose ground has the present motions. Raises InputError."""
        where = building.words(floor)
        moved = tuple(one._replace(motion=floor_motion(one.motion, building, floor)) for one in self.motions)
        ground = self.motions if floor else ()
        return replace(self, motions=moved, how=f"{self.how}; on {where}", ground=ground, where=where)

    def turned(self) -> Action:
        """Return the action with all motions rotated by a quarter turn about the vertical, from x to y."""
        made = []
        for scaled in self.motions:
            motion = replace(scaled.motion, ax=-scaled.motion.ay, ay=scaled.motion.ax)
            motion = replace(motion, amplitude=-motion.amplitude_y, amplitude_y=motion.amplitude)
            made.append(scaled._replace(motion=motion))
        return replace(self, motions=tuple(made), how=f"{self.how}, turned by a quarter")

    def cautions(self, longest: float = 0.0) -> list[str]:
        """Return a line for each use of the target beyond its table, for factors too large and for peaks too small.

        `longest` is the longest period (s) at which the methods by hand read the target.
        """
        lines = [*scaling.factor_lines(self.motions), *filter(None, [self.shortfall])]
        if self.ground:
            lines.append(f"It stands on {self.where}. {OF_FLOORS}")
        if self.target is None or self.periods is None:
            return lines
        # the mean peak of the ground
        peaks = [scaling.horizontal_pga(one.motion) for one in self.ground or self.motions]
        ratio = float(np.mean(peaks)) / float(self.target.psa(0.0))
        if ratio < 1.0:
            lines.append(
                f"The mean peak acceleration is {ratio:.3g} of the target's at period 0; EN 1998-1, 3.2.3.1.2(4)b, "
                "asks for 1 at least: a range of shorter periods (periods) or other records may help."
            )
        found = self.target.outside(0.0, max(self.periods[1], 0.0 if self.ground else longest))
        return [*(f"{self.target.name}: {line}." for line in found), *lines]

    @property
    def statistic(self) -> str:
        """The statistic that counts over several motions (mean or largest), in words."""
        count = len(self.motions)
        if count >= scaling.MEAN_FROM:
            return f"mean of {count} motions"
        few = "" if count >= scaling.FEWEST else f"; codes ask for at least {scaling.FEWEST}"
        return f"largest of {count} motions{few}" if count > 1 else f"one motion{few}"


def motion_rows(action: Action) -> list[tuple[str, ...]]:
    """Return the table of the motions as applied, as texts: the headings, then factors and peaks of each."""
    across = any(scaled.motion.has_ay for scaled in action.motions)
    along: tuple[Component, ...] = ("ax", "ay") if across else ("ax",)
    beside = ("across (g)", "across (m/s)") if across else ()
    rows = [("motion", "factor", "factor, vertical", "PGA (g)", *beside[:1], "vertical (g)", "PGV (m/s)", *beside[1:])]
    for name, motion, factor, upright in action.motions:
        rise = float(np.max(np.abs(motion.az))) / STANDARD_GRAVITY
        vertical = three_digits(upright) if rise else ""
        peaks = [three_digits(motion.peak(component) / STANDARD_GRAVITY) for component in along]
        speeds = [three_digits(pgv(motion, component)) for component in along]
        rows.append((name, three_digits(factor), vertical, *peaks, three_digits(rise), *speeds))
    return rows


@dataclass(frozen=True)
class Level:
    """The level to which motions are scaled: at most one of target, pga and sa. Raises InputError as `check` does."""

    target: TargetSpectrum | None
    pga: float | None  # m/s2
    vertical_pga: float | None  # m/s2
    sa: float | None  # m/s2, at the first period
    periods: tuple[float, float] | None  # s
    least: float  # least ratio of the mean spectrum to the target
    artificial: int  # number of artificial motions if none is given
    vertical: bool  # whether the artificial motions have vertical components
    seed: int
    force_scale: bool = False  # whether factors beyond 0.01 to 100 are allowed
    below: TargetSpectrum | None = None  # the spectrum of the ground, if the target is that of a floor

    def __post_init__(self) -> None:
        if sum(value is not None for value in (self.target, self.pga, self.sa)) > 1:
            raise InputError("target, pga, sa: must be one of them, motions cannot be scaled to several")
        if self.vertical_pga is not None and self.pga is None:
            raise InputError("vertical_pga: must be left out without pga")
        if self.below is not None and self.target is None:
            raise InputError("below: must be left out without a target spectrum, that of the floor")
        if self.periods is not None and self.target is None:
            raise InputError("periods: must be left out without a target spectrum")


def action_on(
    subject: Subject,
    motions: Motions,
    level: Level,
    variants: Sequence[Subject] = (),
    building: Building | None = None,
) -> Action:
    """Scale the motions to a level, or make artificial ones if none is given.

    Under the same motions stand `variants`, which follow a target up to the periods of their bearings too, and in their
    plane take motions with one horizontal component only. The range of a target also covers the first periods of a
    `building` whose ground is moved. Raises InputError as `check` does.
    """
    given, own = _named(motions), subject.period
    of_artificial = {"artificial": level.artificial != ARTIFICIAL, "vertical": level.vertical, "seed": level.seed != 0}
    if given and any(of_artificial.values()):
        names = ", ".join(name for name, is_given in of_artificial.items() if is_given)
        raise InputError(f"{names}: of artificial motions, must be left out where records are given")
    if level.least != scaling.LEAST_PART and not (given and level.target is not None):
        raise InputError("least: must be left out without records that are scaled to a target spectrum")
    if not subject.model.kind.across:
        for motion in given.values():
            check_in_plane(motion)
    # artificial motions have both horizontal components if the first model is in space
    across = any(motion.has_ay for motion in given.values()) if given else subject.model.kind.across
    for one in variants:
        if across and not one.model.kind.across:
            raise InputError(
                f"variant {one.model.name}: moves in its plane, but the motions have two horizontal components: must "
                "be in space, or all models in their plane under one component (--plane)"
            )
    # a target: its spectrum decides the factors
    if level.target is not None:
        found = _following(level.target, given, level, subject, usual_periods([subject], building, variants))
        if level.below is not None:
            found = replace(found, shortfall=shortfall(level.target, level.below, subject.longest))
        return found
    if not given:
        raise InputError("motions: none given, must be records, or a target spectrum that artificial ones follow")
    # else one peak or spectral acceleration, or the motions as given
    two = any(len(scaling.horizontal_of(motion)) > 1 for motion in given.values())
    if level.pga is not None:
        scaled = scaling.scaled_to_pga(given, level.pga, level.vertical_pga)
        what = "geometric mean of its largest horizontal accelerations" if two else "largest horizontal acceleration"
        how = f"each to a {what} of {level.pga / STANDARD_GRAVITY:.4g} g"
    elif level.sa is not None:
        scaled = scaling.scaled_to_sa(given, own, level.sa)
        what = "geometric mean of its horizontal spectral accelerations" if two else "spectral acceleration"
        how = f"each to a {what} of {level.sa / STANDARD_GRAVITY:.4g} g at the first period, {own:.4g} s"
    else:
        scaled, how = [ScaledMotion(*pair) for pair in given.items()], "as given"
    if scaled:
        scaling.check_factors(scaled, level.force_scale)
    return Action(tuple(scaled), how)


def shortfall(floor: TargetSpectrum, ground: TargetSpectrum, period: float) -> str:
    """Return the sentence on a spectrum of a floor with less than the ground's at the rocking period (s); "" if not."""
    if not math.isfinite(period) or period > min(floor.longest, ground.longest):
        return ""
    here, below = (float(one.psa(period)) / STANDARD_GRAVITY for one in (floor, ground))
    if here >= below:
        return ""
    return (
        f"{floor.name} has {here:.3g} g at the rocking period, {period:.3g} s, less than the {below:.3g} g of the "
        "ground: a floor follows the ground at long periods; raise the table, or give the building (--building)."
    )


def usual_periods(
    subjects: Sequence[Subject], building: Building | None, variants: Sequence[Subject] = ()
) -> tuple[float, float]:
    """Return the range (s) in which spectra follow a target by default, up to where spectra of codes end.

    `variants` extend it by the periods of their bearings alone.
    """
    firsts = [one.period for one in subjects]
    firsts += [period for period in (building.periods if building else ()) if period >= RIGID]
    bearings = (one.isolated for one in (*subjects, *variants))
    longest = max(LONGEST_PART * max(firsts), *(one.longest for one in subjects), *bearings)
    return max(SHORTEST, SHORTEST_PART * min(firsts)), min(longest, LONGEST_PERIOD)


def _following(
    target: TargetSpectrum, given: Mapping[str, Motion], level: Level, subject: Subject, usual: tuple[float, float]
) -> Action:
    """Return an action whose spectra follow the target: the given motions scaled, or artificial ones.

    The range of periods (s) is by default `usual`, up to LONGEST_PART of the first period at least.
    """
    low, high = level.periods or (usual[0], max(LONGEST_PART * subject.period, usual[1]))
    if high > target.longest:
        raise InputError(
            f"{target.name}: the table ends at {target.longest:.4g} s, the check needs it to {high:.4g} s: must be as "
            f"long, or --periods {low:.3g} {target.longest:.3g}, periods, must leave out what is beyond"
        )
    if given:
        scaled = scaling.scaled_to_spectrum(given, target, (low, high), level.least)
        scaling.check_factors(scaled, level.force_scale)
        how = f"each to a mean of 1 over the target from {low:.3g} to {high:.3g} s, all so that their mean is no "
        return Action(tuple(scaled), f"{how}less than {level.least:g} of it", target, (low, high))
    # no records: artificial motions, with the components that the model and the level need
    made = artificial_motions(target, level.artificial, level.seed)
    if subject.model.kind.across:
        made = with_component("across", made, target, level.seed)
    if level.vertical:
        if target.vertical is None:
            raise InputError(f"vertical: {target.name} has no vertical spectrum, must be left out")
        made = with_component("vertical", made, target.vertical, level.seed)
    low = max(low, SHORTEST)
    raised = scaling.raised_to_spectrum(made, target, (low, high), level.least)
    how = f"artificial motions made to follow the target from {low:.3g} to {high:.3g} s, seeds from {level.seed}"
    return Action(tuple(raised), how, target, (low, high))


def _named(motions: Motions) -> dict[str, Motion]:
    if isinstance(motions, Mapping):
        found = dict(motions)
    else:
        check_type("motions", motions, Iterable)
        found = {}
        for number, given in enumerate(motions, start=1):
            name = f"motion {number}" if isinstance(given, Motion) else printable(Path(given).stem)
            found[name if name not in found else f"{name} {number}"] = (
                given if isinstance(given, Motion) else Motion.from_file(given)
            )
    for name, motion in found.items():
        if not isinstance(motion, Motion):
            raise InputError(f"{name} = {shown(motion)}: must be a Motion or the path of a record")
    return found
