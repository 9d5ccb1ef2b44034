"""The table of checks: what the action asks of a column beside what is allowed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..column.column import Column
from ..column.friction import friction_history
from ..column.packing import carried_weights
from ..dynamics.response import Response
from ..dynamics.uncertainty import PERCENTILES, share_bounds
from ..runs.table import Table
from .limits import Limits
from .margin import Margin
from .scaling import statistic

FloatArray = NDArray[np.float64]

LASTING = 0.05  # s


@dataclass(frozen=True)
class Unit:
    """How a quantity is shown: the name of a unit, and what a value in SI is multiplied by."""

    name: str = ""
    factor: float = 1.0


MM, MPA, PERCENT, PLAIN = Unit("mm", 1e3), Unit("MPa", 1e-6), Unit("%", 100.0), Unit()
FACTOR = Unit("x")


def three_digits(value: float) -> str:
    """A number for the eye, without an exponent where it is large."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e7 else f"{value:.3g}"


@dataclass(frozen=True)
class Row:
    """One check. demand, capacity: SI; capacity NaN where nothing is compared, the note says why.

    values: of each motion, or empty. band: 16, 50 and 84 % points over the runs of the ensembles that stand, where
    they keep the quantity, else over the motions.
    """

    name: str
    demand: float
    capacity: float
    unit: Unit
    where: str = ""
    note: str = ""
    values: tuple[float, ...] = ()
    band: tuple[float, ...] = ()

    @property
    def ratio(self) -> float:
        """Demand over capacity: above 1 it fails; NaN where nothing is compared."""
        if self.capacity == 0.0:
            return 0.0 if self.demand == 0.0 else math.inf
        return self.demand / self.capacity

    @property
    def passes(self) -> bool | None:
        """Whether the demand is within the capacity; None where nothing is compared."""
        return None if math.isnan(self.ratio) else self.ratio <= 1.0

    @property
    def texts(self) -> tuple[str, str, str, str, str, str]:
        """Name, place, demand, capacity, ratio and outcome, for the eye."""
        return (
            self.name,
            self.where,
            self.shown(self.demand),
            "" if math.isnan(self.capacity) else self.shown(self.capacity),
            "" if not math.isfinite(self.ratio) else f"{self.ratio:.2f}",
            {True: "passes", False: "FAILS", None: "not compared"}[self.passes],
        )

    @property
    def remark(self) -> str:
        """The note, and the percentiles."""
        if not self.band:
            return self.note
        percent = ", ".join(map(str, PERCENTILES))
        values = ", ".join(three_digits(self.unit.factor * value) for value in self.band)
        return f"{self.note}; {percent} % points {values} {self.unit.name}".rstrip()

    @property
    def brief(self) -> str:
        """Demand and ratio for a table of variants; of a factor on the motion what the column bears."""
        if self.unit is FACTOR:
            return f"bears {self.shown(self.capacity)}"
        *_, demand, _, ratio, outcome = self.texts
        return demand if self.passes is None else f"{demand} ({ratio or outcome.lower()})"

    def shown(self, value: float) -> str:
        """A value of this row with its unit."""
        if math.isinf(value):
            return "falls"
        return f"{three_digits(self.unit.factor * value)} {self.unit.name}".rstrip()


def rows_of(
    column: Column,
    responses: Sequence[Response],
    table: Table,
    limits: Limits,
    margin: Margin | None,
    edge: float,
    names: Sequence[str],
) -> tuple[Row, ...]:
    """The rows, from the run of each motion, the table of all varied runs and the margin.

    edge: displacement of the top at which it balances without a push, m. A motion under which the column falls asks
    for an infinite displacement, pressure and slip. names: of the motions.
    """
    fell = np.array([response.verdict != "standing" for response in responses])

    def largest(values: Callable[[Response], ArrayLike]) -> FloatArray:
        found = np.array([values(response) for response in responses], dtype=np.float64)
        found[fell] = math.inf
        return found

    return (
        *_overturning(table, limits, margin, names),
        _displacement(responses, table, largest(lambda response: response.peak_ux[0]), limits, edge),
        _pressure(column, largest(lambda response: response.peaks["sigma_max"]), limits),
        *_sliding(column, responses, largest, limits),
        _opening(largest(lambda response: 1.0 - response.peaks["contact"]), limits, fell),
    )


def _overturning(table: Table, limits: Limits, margin: Margin | None, names: Sequence[str]) -> list[Row]:
    verdicts = table["verdict"]
    size, fallen = len(verdicts), int(np.sum(verdicts == "overturned"))
    open_ones = int(np.sum(verdicts == "undecided"))
    low, _ = share_bounds(fallen, size)
    _, high = share_bounds(fallen + open_ones, size)
    note = f"{fallen} of {size} runs fall" + (f", {open_ones} undecided" if open_ones else "")
    share = (fallen + open_ones) / size
    note += f"; {low:.1%} to {high:.1%} at 95 % confidence"
    rows = [Row("overturning", share, limits.share, PERCENT, note=note)]
    if margin is not None:
        note = f"no run falls up to {margin.stands:.3g} times the motion, the most looked at"
        if not margin.is_open:
            note = f"the first run falls between {margin.stands:.3g} and {margin.falls:.3g} times {names[margin.place]}"
        rows.append(Row("overturning, margin", 1.0, margin.stands, FACTOR, note=note))
    return rows


def _displacement(responses: Sequence[Response], table: Table, values: FloatArray, limits: Limits, edge: float) -> Row:
    stands = table["verdict"] == "standing"
    tops = table["peak_ux"][stands, 0]
    band = tuple(np.percentile(tops, PERCENTILES).tolist()) if tops.size else ()
    note = f"{limits.displacement:g} of the {edge:.4g} m at which it balances on its edge"
    demand = float(statistic(values))
    return Row(
        "displacement of the top", demand, limits.displacement * edge, MM, "top", note, tuple(values.tolist()), band
    )


def _pressure(column: Column, values: FloatArray, limits: Limits) -> Row:
    strength = np.array([block.joint.strength or math.nan for block in column.blocks]) / limits.strength_factor
    demand = statistic(values)
    known = ~np.isnan(strength)
    if known.any():
        i = int(np.flatnonzero(known)[np.argmax((demand / strength)[known])])
        note = f"strength over {limits.strength_factor:g}"
    else:
        i, note = int(np.argmax(demand)), "no joint has a strength"
    return _of_joint("pressure at the edge", i, demand, float(strength[i]), MPA, note, values)


def _sliding(
    column: Column,
    responses: Sequence[Response],
    largest: Callable[[Callable[[Response], ArrayLike]], FloatArray],
    limits: Limits,
) -> list[Row]:
    rows: list[Row] = []
    slides = np.array([block.joint.friction is not None for block in column.blocks])
    if slides.any():
        width = np.array([contact.width for contact in column.contacts])
        for name, part, values in (
            ("slip", limits.slip, largest(lambda run: np.max(np.abs(run.slip - run.slip[0]), axis=0))),
            ("slip that is left", limits.residual, largest(lambda run: np.abs(run.slip[-1] - run.slip[0]))),
        ):
            demand = statistic(values)
            i = int(np.flatnonzero(slides)[np.argmax((demand / width)[slides])])
            note = f"{part:g} of the width of the joint"
            rows.append(_of_joint(name, i, demand, part * float(width[i]), MM, note, values))
    if not slides.all():
        values = largest(lambda response: np.where(slides, 0.0, lasting_friction(response)))
        demand = statistic(values)
        i = int(np.argmax(demand))
        given = math.nan if limits.friction is None else limits.friction
        note = f"|T| / N that is exceeded for {LASTING:g} s in all; this joint cannot slide in the model"
        if limits.friction is None:
            note = f"no friction is given; {note}"
        rows.append(_of_joint("friction asked for", i, demand, given, PLAIN, note, values))
    return rows


def lasting_friction(response: Response) -> FloatArray:
    """|T| / N of each joint that is exceeded for LASTING s in all, (n,): peaks of impacts are shorter and move nothing.

    0.05 s of 0.3 more than there is move a joint by 4 mm.
    """
    ratio = friction_history(response.T, response.N, carried_weights(response.column))
    rows = max(1, round(LASTING * (len(response.time) - 1) / float(response.time[-1] - response.time[0])))
    found: FloatArray = np.sort(ratio, axis=0)[-min(rows, len(ratio))]
    return found


def _opening(values: FloatArray, limits: Limits, fell: NDArray[np.bool_]) -> Row:
    values[fell] = 1.0
    demand = statistic(values)
    i = int(np.argmax(demand))
    capacity, note = limits.opening, "part of the width"
    if capacity is None:
        capacity, note = math.nan, "a rocking joint opens, no limit is given; part of the width"
    return _of_joint("opening", i, demand, capacity, PERCENT, note, values)


def _of_joint(name: str, i: int, demand: FloatArray, capacity: float, unit: Unit, note: str, values: FloatArray) -> Row:
    """A row of the joint in place i; values (motions, joints)."""
    own = values[:, i]
    band = tuple(np.percentile(own, PERCENTILES).tolist()) if np.isfinite(own).all() else ()
    return Row(name, float(demand[i]), capacity, unit, f"joint {i + 1}", note, tuple(own.tolist()), band)
