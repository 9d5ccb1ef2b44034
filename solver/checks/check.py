"""A check against a seismic action, from the motions to the answer in plain words."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from ..common.errors import InputError, check_type, shown
from ..common.files import write_table
from ..ground.building import Building
from ..ground.motion import bytes_beside_samples
from ..models.protocol import Model
from ..models.uncertainty import PERCENTILES
from ..runs.many import Callback, begin_phase
from ..runs.table import Table
from . import of_column, of_structure  # noqa: F401  # subjects that they register
from .action import ARTIFICIAL, Action, Level, Motions, action_on
from .answer import (
    FAILS,
    PASSES,
    answer,
    components_sentence,
    cracked_sentence,
    failed_names,
    falls_sentence,
    impacts_sentence,
    margin_sentence,
    outcome_of,
    verdict_sentence,
)
from .by_hand import ByHand
from .limits import Limits, Plan
from .margin import MOST_TRIALS, Margin, margin_of
from .other_joints import CHANGES, OtherJoints, joints_sentence, other_joints
from .runs import Sets, is_turned, own_runs, run_all, varied
from .scaling import LEAST_PART, check_periods
from .spectra import TargetSpectrum
from .subject import Pair, Subject, can_be_made, subject_of
from .table import Demands, Row, rows_of
from .verdicts import Verdicts, verdicts_of

TURNED = " turned by 180 degrees"
NO_FRICTION = "no joint has friction"
BANDS = tuple(f"p{percent}" for percent in PERCENTILES)

HISTORIES_GOVERN = (
    "Where they disagree, believe the time histories: by hand one body turns about one edge, under a spectrum."
)


@dataclass(frozen=True, eq=False, repr=False)
class Check:
    """A checked column or structure: rows of demand and capacity, margin, methods by hand, and all runs.

    Attributes
    ----------
    subject
        The model under check.
    action
        The motions as applied, and their target.
    plan
        The limits and options.
    rows
        The rows of demand and capacity.
    by_hand
        The methods by hand; None for a structure in space.
    margin
        The factors at which overturning begins; None if they were not computed.
    by_sign
        The responses of the model as given, (motions, signs): for each motion one for each sign that counts, the worse
        one first.
    runs
        The table of the varied runs: `plan.ensemble` for each motion, grouped by motion.
    verdicts
        The verdicts of both.
    others
        The outcomes with other moduli and dampings of the joints.
    both
        Whether the other direction is checked as well, in another `Check`.
    """

    subject: Subject
    action: Action
    plan: Plan
    rows: tuple[Row, ...]
    by_hand: ByHand | None
    margin: Margin | None
    by_sign: tuple[tuple[Any, ...], ...]
    runs: Table
    verdicts: Verdicts
    others: tuple[OtherJoints, ...] = ()
    both: bool = False

    def __repr__(self) -> str:
        return f"<Check of {self.name}, {len(self.action.motions)} motions. {self.answer} {self.verdict}>"

    @property
    def name(self) -> str:
        """The name of the column or structure."""
        return str(self.subject.model.name)

    @property
    def responses(self) -> tuple[Any, ...]:
        """The responses of the model as given, one for each motion: of both signs that of the worse verdict."""
        return tuple(runs[0] for runs in self.by_sign)

    @cached_property
    def demands(self) -> Demands:
        """The demands of the motions on the model as given."""
        return Demands(self.subject, self.by_sign)

    @cached_property
    def own_names(self) -> tuple[str, ...]:
        """The names of the motions, with a note where `responses` has the one that is turned by 180 degrees."""
        pairs = zip(self.action.motions, self.responses, strict=True)
        return tuple(one.name + TURNED * is_turned(run, one.motion) for one, run in pairs)

    @property
    def displacement(self) -> Row:
        """The row of the displacement."""
        return next(row for row in self.rows if row.name.startswith("displacement"))

    @property
    def period(self) -> float:
        """The period of the first mode about rest (s)."""
        return self.subject.period

    @property
    def all_rows(self) -> tuple[Row, ...]:
        """The rows, followed by those of the methods by hand."""
        return (*self.rows, *(self.by_hand.rows if self.by_hand else ()))

    @property
    def passes(self) -> bool:
        """True if no compared row fails and none is undecided."""
        return outcome_of(self.rows) == PASSES

    @property
    def answer(self) -> str:
        """The sentences that say whether it passes, which rows fail, and which mortar joints break through."""
        return answer(self.rows) + cracked_sentence(self.subject.bonds, self.by_sign)

    @property
    def fallen(self) -> tuple[int, int, int]:
        """The numbers of varied runs that fall, that are undecided, and of all varied runs."""
        return self.verdicts.fallen, self.verdicts.undecided, len(self.verdicts.varied)

    @property
    def governing(self) -> int:
        """The index of the governing motion.

        It is the one under which the model falls first, or has the least margin, or moves most.
        """
        return self._governing[0]

    @property
    def governing_sentence(self) -> str:
        """The sentence that names the governing run, and says why its displacement is not the demand of the table."""
        place, why = self._governing
        word, name = self.subject.model.kind.word, self.own_names[place]
        row = self.displacement
        value, counts = row.shown(row.values[place]), row.shown(row.demand)
        said = f"The run of the {word} as described under {name}: {why}."
        if value == counts:
            return said
        return f"{said} Its displacement is {value}; the demand of the table, {counts}, is the {self.action.statistic}."

    @property
    def _governing(self) -> tuple[int, str]:
        fell = [response.overturn_time if response.overturned else np.inf for response in self.responses]
        if np.isfinite(fell).any():
            return int(np.argmin(fell)), "under this motion it falls first"
        if self.margin is not None and not self.margin.is_open:
            return self.margin.place, "as the motions grow, the first run that falls is under this one"
        moved = [self.subject.moved(response) for response in self.responses]
        return int(np.argmax(moved)), "this motion moves it most"

    @property
    def verdict(self) -> str:
        """The sentences on the model as given, and on the share of the varied models that falls."""
        return verdict_sentence(self.subject.model.kind.word, self.verdicts)

    @property
    def falls_sentence(self) -> str:
        """The sentence on when the model as given falls, and what of it; "" if it does not."""
        return falls_sentence(self.subject.model.kind.word, self.own_names, self.responses)

    @property
    def impacts_sentence(self) -> str:
        """The sentence on the neighbours that hit each other as given; "" without neighbours."""
        names = [scaled.name for scaled in self.action.motions]
        return impacts_sentence(names, self.by_sign) if self.subject.neighbours else ""

    @property
    def margin_sentence(self) -> str:
        """The sentence on the margin to overturning."""
        return margin_sentence(self.margin, bool(self.verdicts.undecided or self.verdicts.own_undecided))

    @property
    def remarks(self) -> tuple[str, ...]:
        """The sentences on the components that act, cautions about the action, and points left to another check."""
        longest = self.by_hand.mechanism.period if self.by_hand else 0.0
        components = components_sentence(self.action, self.subject.model.kind.across, self._has_space)
        return (components, *self.action.cautions(longest), *self.subject.deferred_points(self.both))

    @cached_property
    def _has_space(self) -> bool:
        """False of a column that cannot be solved in space."""
        column = self.subject.planar
        return column is None or can_be_made(column.in_space)

    @cached_property
    def of_joints(self) -> tuple[str, ...]:
        """The sentences on the sensitivity to modulus and damping, and on the restitution of the model."""
        said = (joints_sentence(self.rows, self.others),) if self.subject.joints.names else ()
        return (*said, *filter(None, [self.subject.restitution]))

    @property
    def agreement(self) -> tuple[str, ...]:
        """The lines that compare each method by hand with the time histories."""
        stands = not self.verdicts.falls_by_motion.any()
        lines = []
        for row in self.by_hand.rows if self.by_hand else ():
            if row.passes is None:
                continue
            # sliding is compared with the slip, other methods with the falls
            other, found = stands, "no run falls" if stands else "runs fall"
            if row.name.startswith("sliding"):
                slips = [one for one in self.rows if one.name == "slip"]
                if not slips:
                    continue
                if slips[0].of_fall:
                    lines.append(f"{row.name}: {_passes(row)}, time histories: {found}; sliding is not compared")
                    continue
                other, found = bool(slips[0].passes), f"slip {slips[0].ratio:.2f} of the limit"
            word = "agrees" if row.passes is other else "disagrees"
            lines.append(f"{row.name}: {_passes(row)}, time histories: {found}; {word}")
        if any(line.endswith("disagrees") for line in lines):
            lines.append(HISTORIES_GOVERN)
        return tuple(lines)

    @cached_property
    def fingerprint(self) -> str:
        """The SHA-256 of the column or structure, the motions as applied, and the plan."""
        digest = hashlib.sha256(self.subject.digest())
        digest.update(json.dumps(asdict(self.plan), sort_keys=True).encode())
        digest.update(motion_digest(self.action))
        return digest.hexdigest()

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write one line for each row of the table and of the methods by hand, in SI units. Raises OSError."""
        write_checks(path, (self,))


def write_checks(path: str | os.PathLike[str], checks: Sequence[Check]) -> None:
    """Write the tables of checks under the same motions, several with the name of the model before each row.

    Raises OSError.
    """
    names = [scaled.name for scaled in checks[0].action.motions]
    of_model = ["model"] if len(checks) > 1 else []
    rows = [
        (
            *(check.name for _ in of_model),
            *(row.name, row.where, row.demand, row.capacity, row.ratio, row.passes, row.note),
            *(row.band or ("",) * len(BANDS)),
            *row.values,
        )
        for check in checks
        for row in check.all_rows
    ]
    head = [*of_model, "check", "where", "demand", "capacity", "ratio", "passes", "note", *BANDS]
    write_table(path, [*head, *names], rows)


def motion_digest(action: Action) -> bytes:
    """Return the bytes of the motions as applied, with their names."""
    parts = []
    for scaled in action.motions:
        motion = scaled.motion
        parts.append(scaled.name.encode())
        parts += [values.tobytes() for values in (motion.time, motion.ax, motion.ay, motion.az)]
        parts.append(bytes_beside_samples(motion))
    return b"".join(parts)


def _passes(row: Row) -> str:
    return "passes" if row.passes else "fails"


def check_limits(limits: Limits, subjects: Sequence[Subject]) -> None:
    """Raise InputError for a limit, other than by default, that no row of any subject is compared with."""
    rubs = limits.friction is not None
    # limit -> whether a subject has a row with it; why there is none
    compared: dict[str, tuple[Callable[[Subject], object], str]] = {
        "displacement": (lambda subject: subject.edge > 0.0, "in space a displacement has no limit"),
        "overlap": (lambda subject: subject.model.kind.across, "in the plane no blocks overlap"),
        "hits": (lambda subject: subject.neighbours, "nothing has neighbours"),
        "opening": (lambda subject: subject.joints.names, "there are no joints"),
        "strength_factor": (lambda subject: not np.isnan(subject.joints.strength).all(), "no joint has a strength"),
        "slip": (lambda subject: _slides(subject) or (rubs and not subject.model.kind.across), NO_FRICTION),
        "residual": (_slides, NO_FRICTION),
        "friction": (lambda subject: np.isnan(subject.joints.friction).any(), "all joints have friction"),
    }
    for item in fields(limits):
        if item.name in compared and getattr(limits, item.name) != item.default:
            uses, why = compared[item.name]
            if not any(uses(subject) for subject in subjects):
                raise InputError(f"limits.{item.name}: must be left out, {why}")


def _slides(subject: Subject) -> bool:
    """Return True if a joint with friction has a width to compare its slip with: bearings have none."""
    joints = subject.joints
    return bool((~np.isnan(joints.friction) & ~np.isnan(joints.width)).any())


def checked(subject: Subject, action: Action, plan: Plan, callback: Callback | None = None) -> Check:
    """Check a subject under motions that are already scaled, as for variants.

    `callback` is that of `simulate_many`, for each set of runs. Raises InputError and SolverError as `check` does.
    """
    if callback is not None:
        callback = Sets(callback, 1 + plan.margin * MOST_TRIALS + plan.joints * len(CHANGES))
    by_sign, ensembles, runs, verdicts = _made(subject, action, plan, callback)
    # margin: the runs at factor 1 are known, the others are made by bisection, all with the settings of the varied ones
    margin = None
    if plan.margin:
        pairs = zip(by_sign, ensembles, strict=True)
        all_of = [[*((subject.to_vary(run), run.motion) for run in signs), *ensemble] for signs, ensemble in pairs]
        margin = margin_of(subject, all_of, verdicts.falls_by_motion, callback)
    rows = rows_of(subject, by_sign, runs, plan.limits, margin, verdicts)
    others: tuple[OtherJoints, ...] = ()
    if plan.joints:

        def outcome_and_note(changed: Subject) -> tuple[str, str]:
            found, _, table, fell = _made(changed, action, plan, callback, "runs with other joints")
            changed_rows = rows_of(changed, found, table, plan.limits, None, fell)
            note = f"{fell.fallen} of {len(fell.varied)} varied ones fall"
            if not fell.fallen and outcome_of(changed_rows) == FAILS:
                note += f"; by {'; '.join(failed_names(changed_rows))}"
            return outcome_of(changed_rows), note

        others = other_joints(subject.model, plan.confidence_factor, outcome_and_note)
    # methods by hand
    hand = subject.by_hand(action, plan.limits)
    return Check(subject, action, plan, rows, hand, margin, by_sign, runs, verdicts, others)


def _made(
    subject: Subject, action: Action, plan: Plan, callback: Callback | None, phase: str = "varied runs"
) -> tuple[tuple[tuple[Any, ...], ...], list[list[Pair]], Table, Verdicts]:
    """Simulate the subject and its varied models.

    Returns the responses as given, by sign, the varied pairs of each motion, their table, and the verdicts of both.
    """
    begin_phase(callback, phase)
    by_sign = own_runs(subject, [scaled.motion for scaled in action.motions])
    ensembles = [
        varied(subject, signs[0], scaled, plan, place)
        for place, (scaled, signs) in enumerate(zip(action.motions, by_sign, strict=True))
    ]
    runs = run_all(subject, [pair for ensemble in ensembles for pair in ensemble], True, callback)
    names = [scaled.name for scaled in action.motions]
    verdicts = Verdicts(names, np.array([signs[0].verdict for signs in by_sign]), verdicts_of(runs))
    return by_sign, ensembles, runs, verdicts


def check(
    column: Model,
    motions: Motions = (),
    *,
    target: TargetSpectrum | None = None,
    pga: float | None = None,
    vertical_pga: float | None = None,
    sa: float | None = None,
    periods: Sequence[float] | None = None,
    least: float = LEAST_PART,
    artificial: int = ARTIFICIAL,
    vertical: bool = False,
    seed: int = 0,
    force_scale: bool = False,
    plan: Plan | None = None,
    below: TargetSpectrum | None = None,
    building: Building | None = None,
    floor: int = 0,
    callback: Callback | None = None,
) -> Check:
    """Check a column, or a structure in space, against a seismic action.

    The answer says whether it stands, by which margin, and which other demands exceed their limits.

    Parameters
    ----------
    column : Column or Structure
        The model.
    motions : mapping, or iterable of Motion or paths
        The motions by name, motions, or paths of records. If there are none, `artificial` motions that follow `target`.
        Of two horizontal components the geometric mean is scaled (scaling.py).
    target : TargetSpectrum, optional
        The spectrum to which the motions are scaled (checks/spectra.py). At most one of `target`, `pga` and `sa` is
        allowed; without any, the motions are applied as given.
    pga : float, optional
        Largest horizontal acceleration (m/s2) to which each motion is scaled; of two components the geometric mean.
    vertical_pga : float, optional
        Largest vertical acceleration (m/s2), with `pga`.
    sa : float, optional
        Spectral acceleration (m/s2) of 5 % damping at the first period to which each motion is scaled.
    periods : sequence of float, optional
        Range (s) in which the spectra follow the target. By default from 0.2 of the first period to the period at 0.4
        of the displacement on the edge (C8.7.1.10; for a structure that of a rigid block whose centroid is as high),
        at most 4 s and at least twice the first period.
    least : float
        Least ratio of the mean spectrum to the target.
    artificial : int
        Number of artificial motions. For a structure they have both horizontal components.
    vertical : bool
        Whether the artificial motions also follow the vertical spectrum of the target.
    seed : int
        Seed of the first artificial motion.
    force_scale : bool
        Whether factors on records beyond 0.01 to 100 are applied too.
    plan : Plan, optional
        Limits, ensembles and margin (limits.py).
    below : TargetSpectrum, optional
        The spectrum of the ground, if `target` is that of a floor: a remark says where the floor has less.
    building : Building, optional
        The building on whose `floor` it stands. Motions, their scaling and `target` are then those of the ground.
    floor : int
        The floor, 0 for the ground.
    callback : Callback, optional
        As in `simulate_many`, for each set of runs.

    Returns
    -------
    Check
        The answer, the rows, the margin and all runs.

    Raises
    ------
    InputError
        If a value is wrong.
    SolverError
        If the column does not stand at rest or a run cannot be finished.
    """
    for key, spectrum in (("target", target), ("below", below)):
        check_type(key, spectrum, TargetSpectrum, None)
    check_type("building", building, Building, None)
    check_type("plan", plan, Plan, None)
    span = None if periods is None else check_periods(periods)
    level = Level(target, pga, vertical_pga, sa, span, least, artificial, vertical, seed, force_scale, below)
    plan = Plan() if plan is None else plan
    subject = subject_of(column, plan.confidence_factor)
    check_limits(plan.limits, [subject])
    if building is None and floor:
        raise InputError(f"floor = {shown(floor)}: must be given with a building")
    action = action_on(subject, motions, level, building=building if floor else None)
    return checked(subject, action if building is None else action.on_floor(building, floor), plan, callback)
