"""A check against a seismic action, from the motions to the answer in plain words."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..common.files import write_table
from ..models.protocol import Model
from ..models.uncertainty import PERCENTILES
from ..runs.many import Callback
from ..runs.table import Table
from ..statics.rocking import restitution_sentence
from . import of_column, of_structure  # noqa: F401  # subjects that they register
from .action import ARTIFICIAL, Action, Level, Motions, action_on
from .answer import PASSES, answer, components_sentence, cracked_sentence, margin_sentence, outcome_of, verdict_sentence
from .by_hand import ByHand
from .limits import Plan
from .margin import Margin, margin_of
from .other_joints import OtherJoints, joints_sentence, other_joints
from .runs import as_given, own_runs, run_all, varied
from .scaling import LEAST_PART
from .spectra import TargetSpectrum
from .subject import Pair, Subject, subject_of
from .table import Row, rows_of
from .verdicts import Verdicts, verdicts_of

BANDS = tuple(f"p{percent}" for percent in PERCENTILES)

HISTORIES_GOVERN = (
    "Where they disagree, believe the time histories: by hand one body turns about one edge, under a spectrum."
)


@dataclass(frozen=True, eq=False, repr=False)
class Check:
    """A checked column or structure: rows of demand and capacity, margin, methods by hand, every run behind them.

    responses: of itself, one for each motion. runs: table of the varied ones, `plan.ensemble` for each motion, one
    motion after the other. by_hand: None of a structure in space. others: outcomes with other moduli and dampings of
    the joints. both: the other direction is checked beside it.
    """

    subject: Subject
    action: Action
    plan: Plan
    rows: tuple[Row, ...]
    by_hand: ByHand | None
    margin: Margin | None
    responses: tuple[Any, ...]
    runs: Table
    verdicts: Verdicts
    others: tuple[OtherJoints, ...] = ()
    both: bool = False

    def __repr__(self) -> str:
        return f"<Check of {self.name}, {len(self.action.motions)} motions. {self.answer} {self.verdict}>"

    @property
    def name(self) -> str:
        """Name of the column or structure."""
        return str(self.subject.model.name)

    @property
    def period(self) -> float:
        """Of the first mode about rest, s."""
        return self.subject.period

    @property
    def all_rows(self) -> tuple[Row, ...]:
        """The rows, and those of the methods by hand."""
        return (*self.rows, *(self.by_hand.rows if self.by_hand else ()))

    @property
    def passes(self) -> bool:
        """Whether no row that is compared fails, and none is undecided."""
        return outcome_of(self.rows) == PASSES

    @property
    def answer(self) -> str:
        """Whether it passes, fails or is undecided, by which rows, and which joints of mortar break through."""
        return answer(self.rows) + cracked_sentence(self.subject.bonds, self.responses)

    @property
    def fallen(self) -> tuple[int, int, int]:
        """How many of the varied runs fall, how many are undecided, and how many there are."""
        return self.verdicts.fallen, self.verdicts.undecided, len(self.verdicts.varied)

    @property
    def governing(self) -> int:
        """Place of the motion that is worst: it falls first, or has the least margin, or moves the top most."""
        return self._governing[0]

    @property
    def governing_sentence(self) -> str:
        """Which run that is, and why it is not the demand of the table."""
        place, why = self._governing
        word, name = self.subject.model.kind.word, self.action.motions[place].name
        row = next(row for row in self.rows if row.name.startswith("displacement"))
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
        """What it does as given, and the share of varied ones that falls, in plain sentences."""
        return verdict_sentence(self.subject.model.kind.word, self.verdicts)

    @property
    def margin_sentence(self) -> str:
        """How far it is from falling, in one plain sentence."""
        return margin_sentence(self.margin, bool(self.verdicts.undecided or self.verdicts.own_undecided))

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on the components that act, cautions about the action, and what is left to another check."""
        longest = self.by_hand.mechanism.period() if self.by_hand else 0.0
        components = components_sentence(self.action, self.subject.model.kind.across)
        return (components, *self.action.cautions(longest), *self.subject.left_to_others(self.both))

    @cached_property
    def of_joints(self) -> tuple[str, ...]:
        """Whether the answer hangs on modulus or damping, and the restitution of the model, in sentences."""
        column = self.subject.planar
        said = (joints_sentence(self.rows, self.others),) if self.subject.joints.names else ()
        return (*said, restitution_sentence(column)) if column is not None else said

    @property
    def agreement(self) -> tuple[str, ...]:
        """Agreement of the methods by hand with the time histories, a line for each."""
        stands = not self.verdicts.any_falls
        lines = []
        for row in self.by_hand.rows if self.by_hand else ():
            if row.passes is None:
                continue
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
        """SHA-256 of the column or structure, the motions as applied, and the plan."""
        digest = hashlib.sha256(self.subject.digest())
        digest.update(json.dumps(asdict(self.plan), sort_keys=True).encode())
        for scaled in self.action.motions:
            digest.update(scaled.name.encode())
            motion = scaled.motion
            for values in (motion.time, motion.ax, motion.ay, motion.az):
                digest.update(values.tobytes())
            harmonic = (motion.amplitude, motion.amplitude_y, motion.frequency)
            digest.update(repr((motion.hold, motion.duration, *harmonic)).encode())
        return digest.hexdigest()

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a line for each row of the table and of the methods by hand, in SI. Raises OSError."""
        names = [scaled.name for scaled in self.action.motions]
        rows = [
            (
                *(row.name, row.where, row.demand, row.capacity, row.ratio, row.passes, row.note),
                *(row.band or ("",) * len(BANDS)),
                *row.values,
            )
            for row in self.all_rows
        ]
        head = ["check", "where", "demand", "capacity", "ratio", "passes", "note", *BANDS]
        write_table(path, [*head, *names], rows)


def _passes(row: Row) -> str:
    return "passes" if row.passes else "fails"


def checked(subject: Subject, action: Action, plan: Plan, callback: Callback | None = None) -> Check:
    """The check of a subject under motions that are already scaled, as for variants. Raises as `check` does."""
    responses, ensembles, runs, verdicts = _made(subject, action, plan, callback)
    margin = None
    if plan.margin:
        all_of = [[as_given(subject, run), *ensemble] for run, ensemble in zip(responses, ensembles, strict=True)]
        margin = margin_of(subject, all_of, verdicts.under_which_it_falls, callback)
    rows = rows_of(subject, responses, runs, plan.limits, margin, verdicts)
    others: tuple[OtherJoints, ...] = ()
    if plan.joints:

        def outcome_and_note(changed: Subject) -> tuple[str, str]:
            found, _, table, fell = _made(changed, action, plan, callback)
            note = f"{fell.fallen} of {len(fell.varied)} varied ones fall"
            return outcome_of(rows_of(changed, found, table, plan.limits, None, fell)), note

        others = other_joints(subject.model, plan.confidence_factor, outcome_and_note)
    hand = subject.by_hand(action, plan.limits)
    return Check(subject, action, plan, rows, hand, margin, responses, runs, verdicts, others)


def _made(
    subject: Subject, action: Action, plan: Plan, callback: Callback | None
) -> tuple[tuple[Any, ...], list[list[Pair]], Table, Verdicts]:
    """Return the runs of the subject, the varied pairs of each motion, their table, and the verdicts of both."""
    responses = own_runs(subject, [scaled.motion for scaled in action.motions])
    ensembles = [
        varied(subject, run, scaled, plan, place)
        for place, (scaled, run) in enumerate(zip(action.motions, responses, strict=True))
    ]
    runs = run_all(subject, [pair for ensemble in ensembles for pair in ensemble], True, callback)
    names = [scaled.name for scaled in action.motions]
    verdicts = Verdicts(names, np.array([run.verdict for run in responses]), verdicts_of(runs))
    return responses, ensembles, runs, verdicts


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
    callback: Callback | None = None,
) -> Check:
    """Check a column, or a structure in space, against an action: does it stand, by how much, what else is asked of it.

    motions: by name, or in a row, or paths of records; without any, `artificial` ones that follow the target, with
    `vertical` its vertical spectrum too, and of a structure along both horizontal directions. Of two horizontal
    components the geometric mean is scaled (scaling.py).
    target (checks/spectra.py), pga (m/s2, and vertical_pga of the vertical components), sa (m/s2, of 5 % damping at the
    first period): at most one, to which the motions are scaled; without any they are taken as given.
    periods: range in s in which spectra follow the target; None: from 0.2 of the first period to the period at 0.4 of
    the displacement on the edge (C8.7.1.10; of a structure that of a rigid block as high), at most 4 s and at least
    twice the first period. least: part of the target below which the mean spectrum must not be. plan: limits,
    ensembles, margin (limits.py); None: its defaults.
    force_scale: apply factors on records beyond 0.01 to 100 too.
    callback: as in `simulate_many`, for each set of runs.

    Raises InputError for a wrong value, SolverError if the column does not stand at rest or a run cannot be finished.
    """
    span = None if periods is None else (float(periods[0]), float(periods[1]))
    level = Level(target, pga, vertical_pga, sa, span, least, artificial, vertical, seed, force_scale)
    plan = Plan() if plan is None else plan
    subject = subject_of(column, plan.confidence_factor)
    return checked(subject, action_on(subject, motions, level), plan, callback)
