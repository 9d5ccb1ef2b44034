"""The table of checks: the demands of the action on a subject, and their capacities."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.digits import percent, three_digits
from ..models.protocol import OVERTURNED
from ..models.uncertainty import PERCENTILES
from ..runs.table import Table
from .limits import Limits
from .margin import Margin
from .scaling import statistic
from .spectra import FloatArray
from .subject import OF_BEARINGS, Subject
from .verdicts import UNFINISHED, Verdicts, bounds_of, falls

LASTING = 0.05  # s, total time for which a friction demand must be exceeded


@dataclass(frozen=True)
class Unit:
    """A unit in which a quantity is shown: its name, and the factor on a value in SI units."""

    name: str = ""
    factor: float = 1.0


MM, MPA, KN, PERCENT = Unit("mm", 1e3), Unit("MPa", 1e-6), Unit("kN", 1e-3), Unit("%", 100.0)
FACTOR, PLAIN, MRAD = Unit("x"), Unit(), Unit("mrad", 1e3)
BEARING = "displacement of a bearing"


@dataclass(frozen=True)
class Row:
    """A row of the table: one demand and its capacity."""

    name: str
    demand: float  # in SI units
    capacity: float  # in SI units; NaN if nothing is compared, and the note says why
    unit: Unit  # in which both are shown
    where: str = ""  # the joint, block or other part that governs
    note: str = ""
    values: tuple[float, ...] = ()  # the demand of each motion, or empty
    # 16, 50 and 84 % points over the varied runs that do not fall, if these keep the quantity, else over the motions
    band: tuple[float, ...] = ()
    undecided: bool = False  # it neither passes nor fails, since runs did not end

    @property
    def ratio(self) -> float:
        """The ratio of demand to capacity; above 1 the row fails; NaN if nothing is compared."""
        if self.capacity == 0.0:
            return 0.0 if self.demand == 0.0 else math.inf
        return self.demand / self.capacity

    @property
    def passes(self) -> bool | None:
        """True if the demand is within the capacity; None if nothing is compared."""
        return None if math.isnan(self.ratio) else self.ratio <= 1.0

    @property
    def of_fall(self) -> bool:
        """True if the demand is unknown because the model falls, as the rows of overturning say."""
        return math.isinf(self.demand)

    @property
    def texts(self) -> tuple[str, str, str, str, str, str]:
        """The name, place, demand, capacity, ratio and outcome as texts."""
        return (
            self.name,
            self.where,
            self.shown(self.demand),
            "" if math.isnan(self.capacity) else self.shown(self.capacity),
            "" if not math.isfinite(self.ratio) else f"{self.ratio:.2f}",
            self.outcome,
        )

    @property
    def outcome(self) -> str:
        """The outcome in a word or two."""
        if self.undecided:
            return "undecided"
        if self.of_fall and self.passes is False:
            return "falls"
        return {True: "passes", False: "FAILS", None: "not compared"}[self.passes]

    @property
    def remark(self) -> str:
        """The note, followed by the percentiles."""
        if not self.band:
            return self.note
        points = ", ".join(map(str, PERCENTILES))
        values = ", ".join(three_digits(self.unit.factor * value) for value in self.band)
        return f"{self.note}; {points} % points {values} {self.unit.name}".rstrip()

    @property
    def brief(self) -> str:
        """The demand and the ratio, for a table of variants; for a factor on the motion its capacity."""
        if self.unit is FACTOR:
            return f"bears {self.shown(self.demand if math.isnan(self.capacity) else self.capacity)}"
        *_, demand, _, ratio, outcome = self.texts
        return demand if self.passes is None or self.of_fall else f"{demand} ({ratio or outcome.lower()})"

    def shown(self, value: float) -> str:
        """Return a value of this row with its unit, or "falls" if it is infinite."""
        if math.isinf(value):
            return "falls"
        return f"{three_digits(self.unit.factor * value)} {self.unit.name}".rstrip()


def rows_of(
    subject: Subject,
    by_sign: Sequence[Sequence[Any]],
    table: Table,
    limits: Limits,
    margin: Margin | None,
    verdicts: Verdicts,
) -> tuple[Row, ...]:
    """Return the rows of the table of checks; `table` is that of all varied runs.

    `by_sign` has the responses of the model as given, (motions, signs): for each motion one for each sign that counts.
    A motion under which the subject falls has infinite demands of displacement, pressure, slip and force.
    """
    demands = Demands(subject, by_sign)
    return (
        *overturning(verdicts, limits, margin, table.stats["failures"]),
        _displacement(demands, table, verdicts, limits),
        *(_of_joints(demands, limits) if subject.joints.names else ()),
        *_cracks(demands),
        *_hits(demands, table, verdicts, limits),
        *_overlap(demands, limits),
        *_ties(demands),
        *_bearings(demands, table, verdicts),
    )


@dataclass(frozen=True, eq=False)
class Demands:
    """The demands of the motions on a subject: of both signs of a motion, if they count, the worse for each value."""

    subject: Subject
    by_sign: Sequence[Sequence[Any]]  # responses, (motions, signs)

    @property
    def fell(self) -> NDArray[np.bool_]:
        """True for each motion under which the subject falls, (motions,)."""
        found: NDArray[np.bool_] = np.any(falls([[run.verdict for run in runs] for runs in self.by_sign]), axis=1)
        return found

    def most(self, values: Callable[[Any], ArrayLike]) -> FloatArray:
        """Return the largest over the signs of one or several values of the responses, (motions, ...)."""
        return np.max(np.array([[values(run) for run in runs] for runs in self.by_sign], dtype=np.float64), axis=1)

    def largest(self, values: Callable[[Any], ArrayLike]) -> FloatArray:
        """Return the values of `most`; infinite where the subject falls."""
        found = self.most(values)
        found[self.fell] = math.inf
        return found

    def of_joint(self, name: str, i: int, capacity: float, unit: Unit, note: str, values: FloatArray) -> Row:
        """Return a row for the joint of index i, from the `values` of all joints (motions, joints)."""
        return _of_part(name, self.subject.joints.names[i], capacity, unit, note, values[:, i])


def _of_part(name: str, where: str, capacity: float, unit: Unit, note: str, values: FloatArray) -> Row:
    """Return a row for a joint or tie, from the `values` of each motion (motions,)."""
    band = tuple(np.percentile(values, PERCENTILES).tolist()) if np.isfinite(values).all() else ()
    return Row(name, float(statistic(values)), capacity, unit, where, note, tuple(values.tolist()), band)


def _worst(demand: FloatArray, capacity: FloatArray) -> int:
    """Return the index of the largest ratio of demand to capacity, or of the largest demand if no capacity is known."""
    known = np.flatnonzero(~np.isnan(capacity))
    return int(known[np.argmax((demand / capacity)[known])]) if known.size else int(np.argmax(demand))


def overturning(verdicts: Verdicts, limits: Limits, margin: Margin | None, failures: Mapping[int, str]) -> list[Row]:
    """Return the rows of overturning: as given, share of varied runs, undecided runs, and margin if it was computed.

    `failures` has the reasons why runs could not be made, by their number.
    """
    size, count = len(verdicts.varied), len(verdicts.names)
    low, high = verdicts.bounds
    no_rest = [reason for k, reason in failures.items() if verdicts.varied[k] == OVERTURNED]
    unfinished = int(np.sum(verdicts.varied == UNFINISHED))
    own = len(verdicts.own_falls)
    # the model as given
    note = f"motions of {count} under which it falls with the data as given"
    rows = [Row("overturning, as given", own, 0.0, PLAIN, note=f"{note}: {', '.join(verdicts.own_falls) or 'none'}")]
    # the varied runs
    note = f"{verdicts.fallen} of {size} runs fall"
    note += f", {len(no_rest)} of them under their weight alone ({no_rest[0]})" if no_rest else ""
    note += f", {unfinished} of them could not be finished" if unfinished else ""
    note += f"; {percent(low)} to {percent(high)} at 95 % confidence" + (", motions counted" if count > 1 else "")
    rows.append(Row("overturning", verdicts.fallen / size, limits.share, PERCENT, note=note))
    # undecided runs, as given or varied
    left = verdicts.own_undecided
    if left or verdicts.undecided:
        note = f"{verdicts.undecided} of {size} runs neither fall nor come to rest in the time that they are followed"
        note += f"; as given: {', '.join(left)}" if left else ""
        matters = bool(left) or verdicts.fallen + verdicts.undecided > limits.share * size
        rows.append(Row("undecided", verdicts.undecided / size, math.nan, PERCENT, note=note, undecided=matters))
    # margin: the largest factor at which no run falls
    if margin is not None:
        note = f"no run falls up to {three_digits(margin.stands)} times the motion, the most looked at"
        if not margin.is_open:
            note = f"the first run falls between {three_digits(margin.stands)} and {three_digits(margin.falls)} times "
            note += verdicts.names[margin.place]
        if not own and 0.0 < verdicts.fallen / size <= limits.share:
            note = f"the share that may fall allows these falls, so it is not compared; {note}"
            rows.append(Row("overturning, margin", margin.stands, math.nan, FACTOR, note=note))
        else:
            rows.append(Row("overturning, margin", 1.0, margin.stands, FACTOR, note=note))
    return rows


def _displacement(demands: Demands, table: Table, verdicts: Verdicts, limits: Limits) -> Row:
    subject, edge = demands.subject, demands.subject.edge
    tops = subject.tops(table)[~falls(verdicts.varied)]
    band = tuple(np.percentile(tops, PERCENTILES).tolist()) if tops.size else ()
    values = demands.largest(subject.moved)
    name, where = "displacement of the top", "top"
    note = f"{limits.displacement:g} of the {three_digits(edge)} m at which it balances on its edge"
    if math.isnan(edge):
        name, where = "displacement", "any block"
        note = "at which it balances is not known in space: the margin says how far it is from falling"
    capacity = limits.displacement * edge
    return Row(name, float(statistic(values)), capacity, MM, where, note, tuple(values.tolist()), band)


def _of_joints(demands: Demands, limits: Limits) -> list[Row]:
    return [_pressure(demands, limits), *_sliding(demands, limits), _opening(demands, limits)]


def _pressure(demands: Demands, limits: Limits) -> Row:
    strength = demands.subject.joints.strength / limits.strength_factor
    values = demands.largest(lambda response: response.peaks["sigma_max"])
    i = _worst(statistic(values), strength)
    note = "no joint has a strength" if np.isnan(strength).all() else f"strength over {limits.strength_factor:g}"
    return demands.of_joint("pressure at the edge", i, float(strength[i]), MPA, note, values)


def _sliding(demands: Demands, limits: Limits) -> list[Row]:
    rows: list[Row] = []
    subject, joints = demands.subject, demands.subject.joints
    slides = ~np.isnan(joints.friction)
    # slip of the joints with friction
    if (slides & ~np.isnan(joints.width)).any():
        width = np.where(slides, joints.width, math.nan)
        for name, part, values in (
            ("slip", limits.slip, demands.largest(lambda run: np.max(np.abs(run.slip - run.slip[0]), axis=0))),
            ("slip that is left", limits.residual, demands.largest(lambda run: np.abs(run.slip[-1] - run.slip[0]))),
        ):
            i = _worst(statistic(values), width)
            note = f"{part:g} of the width of the joint"
            rows.append(demands.of_joint(name, i, part * float(width[i]), MM, note, values))
    # friction demand of the joints without friction
    if not slides.all():
        values = demands.largest(lambda run: np.where(slides, 0.0, lasting(subject.shear_ratio(run), run.time)))
        i = int(np.argmax(statistic(values)))
        given = math.nan if limits.friction is None else limits.friction
        note = f"|T| / N that is exceeded for {LASTING:g} s in all; this joint cannot slide in the model"
        if limits.friction is None:
            note = f"no friction is given; {note}"
        rows.append(demands.of_joint("friction asked for", i, given, PLAIN, note, values))
    return rows


def lasting(ratio: FloatArray, time: FloatArray) -> FloatArray:
    """Return the ratio `|T| / N` that is exceeded for LASTING s in all, (joints,).

    Peaks of impacts are shorter and move nothing: 0.05 s of an excess of 0.3 moves a joint by 4 mm. `ratio` is (rows,
    joints), `time` (rows,) in s.
    """
    rows = max(1, round(LASTING * (len(time) - 1) / float(time[-1] - time[0])))
    return np.sort(ratio, axis=0)[-min(rows, len(ratio))]


def _opening(demands: Demands, limits: Limits) -> Row:
    values = demands.largest(lambda response: 1.0 - response.peaks["contact"])
    values[demands.fell] = 1.0
    i = int(np.argmax(statistic(values)))
    part = "part of the width" if not demands.subject.model.kind.across else "part of the area"
    capacity, note = limits.opening, part
    if capacity is None:
        capacity, note = math.nan, f"a rocking joint opens, no limit is given; {part}"
    return demands.of_joint("opening", i, capacity, PERCENT, note, values)


def _overlap(demands: Demands, limits: Limits) -> list[Row]:
    """Return the row of the deepest overlap of blocks that do not meet in the model; empty if there is none."""
    by_sign = [[demands.subject.overlap(run) for run in runs] for runs in demands.by_sign]
    known = [[found for found in each if found is not None] for each in by_sign]
    if not any(known):
        return []
    deepest = max((found for each in known for found in each), key=lambda found: found.depth)
    note = f"the deepest under any motion; these blocks do not meet in the model: {deepest.why}"
    values = tuple(max((found.depth for found in each), default=0.0) for each in known)
    where = ", ".join(deepest.between)
    note = note if where else "blocks that do not meet in the model do not overlap"
    return [Row("overlap of blocks", deepest.depth, limits.overlap, MM, where, note, values)]


def _hits(demands: Demands, table: Table, verdicts: Verdicts, limits: Limits) -> list[Row]:
    """Return the rows of neighbours: share of runs with a hit; least gap and largest force as given."""
    names = demands.subject.neighbours
    if not names:
        return []
    every = gaps_of(demands.by_sign, table)
    hit, known = np.any(every < 0.0, axis=1), are_known(every)
    low, high = bounds_of(hit, hit | ~known, len(verdicts.names))
    note = f"in {int(np.sum(hit))} of {int(np.sum(known))} runs, as given and varied"
    note += "" if known.all() else f", without {int(np.sum(~known))} that have no gaps"
    note += f"; {percent(low)} to {percent(high)} at 95 % confidence"
    note += ", motions counted" if len(verdicts.names) > 1 else ""
    note += "" if limits.hits is not None else "; no limit is given"
    capacity = math.nan if limits.hits is None else limits.hits
    share = Row("hits its neighbour", float(np.mean(hit[known])), capacity, PERCENT, note=note)
    gaps = -demands.most(lambda run: -run.peaks["gap"])
    values, i = np.min(gaps, axis=1), int(np.argmin(np.min(gaps, axis=0)))
    note = "the least under any motion as given: what is left, or below 0 how deep they press on each other"
    left = Row("gap that is left", float(np.min(gaps)), math.nan, MM, names[i], note, tuple(values.tolist()))
    # largest force as given
    forces = demands.most(lambda run: run.peaks["hit"])
    values, i = np.max(forces, axis=1), int(np.argmax(np.max(forces, axis=0)))
    note = "the largest under any motion as given; it grows with the stiffness of the contact"
    force = Row("force between neighbours", float(np.max(forces)), math.nan, KN, names[i], note, tuple(values.tolist()))
    return [share, left, force]


def gaps_of(by_sign: Sequence[Sequence[Any]], table: Table) -> FloatArray:
    """Return the least gap of each pair in each run (m), (runs, pairs): the runs as given, then those of the table."""
    return np.vstack([*(run.peaks["gap"] for runs in by_sign for run in runs), table["least_gap"]])


def are_known(gaps: FloatArray) -> NDArray[np.bool_]:
    """Return True for each run with gaps: runs that could not be finished, or had no rest, have none, (runs,)."""
    return np.asarray(~np.isnan(gaps).all(axis=1))


def _cracks(demands: Demands) -> list[Row]:
    """Return the row of the mortar joint with the largest broken part; empty if no joint bears tension."""
    names = demands.subject.bonds
    if not names:
        return []
    values = demands.largest(lambda run: 1.0 - run.peaks["bond"])
    i = int(np.argmax(statistic(values)))
    note = "part of the area that has broken and bears no tension any more; nothing is compared"
    broken = tuple(values[:, i].tolist())
    return [Row("joint that cracks", float(statistic(values)[i]), math.nan, PERCENT, names[i], note, broken)]


def _ties(demands: Demands) -> list[Row]:
    """Return the row of the tie that is nearest to its yield; empty without ties."""
    yields = demands.subject.yields
    if not yields.size:
        return []
    values = demands.largest(lambda run: run.peaks["tie"])
    i = _worst(statistic(values), yields)
    note = "no tie has a yield" if np.isnan(yields).all() else "the force at which it yields: at 1 it has yielded"
    return [_of_part("force of a tie", f"tie {i + 1}", float(yields[i]), KN, note, values[:, i])]


def _bearings(demands: Demands, table: Table, verdicts: Verdicts) -> list[Row]:
    """Return the row of the bearing with the largest ratio of displacement to capacity; empty without bearings."""
    names, capacity = demands.subject.bearings
    if not names:
        return []
    values = demands.largest(lambda run: run.peaks["d"])
    i = _worst(statistic(values), capacity)
    stand = table[OF_BEARINGS][~falls(verdicts.varied), i]
    band = tuple(np.percentile(stand, PERCENTILES).tolist()) if stand.size else ()
    note = "the displacement beyond which what it carries has come off it"
    note += f"; at most {MM.factor * np.max(stand):.3g} mm in {stand.size} varied runs that stand" if stand.size else ""
    row = _of_part(BEARING, names[i], float(capacity[i]), MM, note, values[:, i])
    return [replace(row, band=band)]
