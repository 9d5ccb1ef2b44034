"""The runs of a gallery: each object on each mount, pair by pair in a journal, so that an interruption loses little."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace

import numpy as np

from ..checks.action import Action, Level, Motions, action_on, usual_periods
from ..checks.check import motion_digest
from ..checks.limits import Plan
from ..checks.margin import margin_of
from ..checks.runs import run_all, varied
from ..checks.subject import OF_BEARINGS, Subject
from ..checks.verdicts import bounds_of, falls, verdicts_of
from ..common.digits import three_digits
from ..common.executors import cores
from ..common.notebook import counted
from ..ground.building import Building
from ..models.protocol import OVERTURNED, UNDECIDED
from ..runs.many import Callback
from ..studies.definition import versions
from ..studies.journal import Journal, read_journal
from .mounts import Mount
from .objects import Exhibit


@dataclass(frozen=True)
class Outcome:
    """The runs of an object on a mount, as given and varied, under all motions."""

    fallen: int
    undecided: int
    runs: int
    low: float  # bounds of the share that falls, at 95 % confidence
    high: float
    stands: float  # margin: factors on the motions at which none and at which some run falls; NaN if not computed
    falls: float
    moved: float  # m, largest displacement of the runs that stand; NaN if all fall
    bearing: float  # the same of the bearings; NaN without bearings too
    capacity: float  # m, of the bearings
    first: str  # the first fall: what, when, under which motion; "" without

    @property
    def holds(self) -> bool:
        """True if every run stands."""
        return not (self.fallen or self.undecided)

    @property
    def text(self) -> str:
        """The outcome and the margin, in a few words."""
        word = f"{self.fallen} fall" if self.fallen else f"{self.undecided} undecided" if self.undecided else "holds"
        return word if math.isnan(self.stands) else f"{word}, {self.margin}"

    @property
    def margin(self) -> str:
        """The largest factor on the motions at which no run falls, as text."""
        if math.isnan(self.stands):
            return "not computed"
        return f"{'over ' if math.isinf(self.falls) else ''}{three_digits(self.stands)}"


@dataclass(frozen=True, eq=False)
class Gallery:
    """The objects, the mounts, and the outcomes of the pairs, (objects, mounts)."""

    exhibits: Sequence[Exhibit]
    mounts: Sequence[Mount]
    outcomes: Sequence[Sequence[Outcome]]
    fingerprint: str  # SHA-256 of models, motions and plan
    kept: int  # pairs that an earlier run had made

    def first_mount(self, number: int) -> str:
        """Return the name of the first mount that holds the object of this index; "none" if none does."""
        pairs = zip(self.mounts, self.outcomes[number], strict=True)
        return next((mount.name for mount, outcome in pairs if outcome.holds), "none")


def common_action(subjects: Sequence[Subject], motions: Motions, level: Level, building: Building | None) -> Action:
    """Return one action for all subjects, as `action_on`; spectra follow a target over the periods of all of them."""
    if level.target is not None and level.periods is None:
        level = replace(level, periods=usual_periods(subjects, building))
    return action_on(subjects[0], motions, level)


def survey(
    exhibits: Sequence[Exhibit],
    mounts: Sequence[Mount],
    subjects: Sequence[Subject],
    actions: Mapping[int, Action],
    plan: Plan,
    journal: str | os.PathLike[str],
    callback: Callback | None = None,
) -> Gallery:
    """Run all pairs that the journal does not have, and return the outcomes of all.

    Each pair, which `subjects` have object by object, is added to the journal as it ends. `actions` are those on each
    floor. `callback` is called as callback(runs made, all runs), without the runs of the margins. Raises InputError if
    the journal is of another gallery, SolverError if a run cannot be made.
    """
    floors = [exhibit.floor for exhibit in exhibits for _ in mounts]
    digest = hashlib.sha256(json.dumps([asdict(plan), floors], sort_keys=True).encode())
    digest.update(b"".join([*(one.digest() for one in subjects), *map(motion_digest, actions.values())]))
    fingerprint = digest.hexdigest()
    head = {"study": {"name": "gallery"}, "fingerprint": fingerprint, "versions": versions()}
    each = (1 + plan.ensemble) * len(next(iter(actions.values())).motions)
    pool = ThreadPoolExecutor(cores(), thread_name_prefix="pairs")
    try:
        with Journal(journal, head, (".csv", ".html")) as kept:
            left = [number for number in range(len(subjects)) if number not in kept.finished]
            made = pool.map(lambda k: outcome_of(subjects[k], actions[floors[k]], plan), left)
            for done in range(len(subjects) - len(left), len(subjects) + 1):
                if callback is not None:
                    callback(each * done, each * len(subjects))
                if done < len(subjects):
                    number = left[done - len(subjects)]
                    kept.add([[number, list(asdict(next(made)).values())]])
    finally:
        pool.shutdown(cancel_futures=True)
    found = [Outcome(*values) for _, values in sorted(read_journal(journal)[1])]
    rows = [found[k : k + len(mounts)] for k in range(0, len(found), len(mounts))]
    return Gallery(exhibits, mounts, rows, fingerprint, len(subjects) - len(left))


def outcome_of(subject: Subject, action: Action, plan: Plan) -> Outcome:
    """Return the outcome of a pair: the runs of a check, all in lanes, on one thread."""
    motions = action.motions
    ensembles = [
        [(subject.model, scaled.motion), *varied(subject, None, scaled, plan, place)]
        for place, scaled in enumerate(motions)
    ]
    table = run_all(subject, [pair for pairs in ensembles for pair in pairs], True, None, threads=1)
    verdicts = verdicts_of(table)
    fell, left = falls(verdicts), verdicts == UNDECIDED
    stands = fails = math.nan
    if plan.margin:
        margin = margin_of(subject, ensembles, np.any(fell.reshape(len(motions), -1), axis=1), threads=1)
        stands, fails = margin.stands, margin.falls
    # the first fall
    first, time = "", np.where(verdicts == OVERTURNED, table["overturn_time"], math.inf)
    if np.isfinite(time).any():
        k = int(np.argmin(time))
        block = int(table["fallen"][k])  # 0: the run has no rest from which it could begin
        what = subject.model.names[block - 1] if block else "all of it, under its weight alone,"
        first = f"{what} at {time[k]:.4g} s under {motions[k // (1 + plan.ensemble)].name}"
    elif np.any(fell):
        first = f"none, but {counted(int(np.sum(fell)), 'run')} could not be finished"
    # displacements of the runs that stand
    none = math.nan if np.all(fell) else 0.0
    moved, bearing, capacity = float(np.max(subject.tops(table), where=~fell, initial=none)), math.nan, math.nan
    if subject.bearings[0]:
        bearing = float(np.max(np.max(table[OF_BEARINGS], axis=1), where=~fell, initial=none))
        capacity = float(np.min(subject.bearings[1]))
    counts, bounds = (int(np.sum(fell)), int(np.sum(left)), fell.size), bounds_of(fell, fell | left, len(motions))
    return Outcome(*counts, *bounds, stands, fails, moved, bearing, capacity, first)
