"""A check over a range of friction: sliding decides at its lower end, rocking at its upper one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.digits import three_digits
from ..common.errors import InputError
from .answer import FAILS, PASSES, UNDECIDED, outcome_of
from .check import Check
from .spectra import FloatArray
from .table import MM, are_known, gaps_of
from .verdicts import falls

MOST_VALUES, MOST_PAIRS = 50, 20  # values of friction; pairs of neighbours that are listed
OF_VALUES = (
    "friction",
    "outcome",
    "runs that fall",
    "first fall as given",
    "displacement (mm)",
    "slip as given",
    "hits",
)
OF_PAIRS = ("neighbours", "least gap (mm)", "at friction", "runs that hit", "first contact as given (s)")
STILL = "No vertical motion acts; it unloads the joints, which then slide earlier: --vertical, --artificial-vertical."


def friction_values(text: str) -> list[float]:
    """Return the values of FROM:TO:STEP, both bounds included. Raises InputError."""
    wrong = f"--friction {text}: must be FROM:TO:STEP as 0.2:0.8:0.1, at most {MOST_VALUES} values, from 0.01 to 2"
    try:
        low, high, step = map(float, text.split(":"))
    except ValueError:
        raise InputError(wrong) from None
    if not (0.01 <= low <= high <= 2.0 and step > 0.0 and (high - low) / step < MOST_VALUES):
        raise InputError(wrong)
    values = [round(low + k * step, 10) for k in range(int((high - low) / step + 1e-9) + 1)]
    values = values if high - values[-1] < 1e-9 else [*values, high]
    if len(values) > MOST_VALUES:
        raise InputError(wrong)
    return values


def with_friction(model: Any, value: float) -> Any:
    """Return the model with this friction in all joints, but not of bearings and neighbours."""
    return replace(model.kind.with_numbers(model, {"joint.friction": (value, False)}), name=f"{model.name} {value:g}")


@dataclass(frozen=True, eq=False)
class Envelope:
    """The checks of a model at several values of friction, and the envelope of their runs, as given and varied."""

    values: Sequence[float]
    checks: Sequence[Check]

    @cached_property
    def moved(self) -> FloatArray:
        """The largest displacement of the runs that stand at each value (m), NaN if all fall."""
        found = []
        for check in self.checks:
            own = [check.subject.moved(run) for signs in check.by_sign for run in signs if not run.overturned]
            varied = check.subject.tops(check.runs)[~falls(check.verdicts.varied)]
            found.append(max([*own, *varied.tolist()], default=np.nan))
        return np.array(found)

    @cached_property
    def gaps(self) -> list[FloatArray]:
        """The least gap of each finished run at each value (m), (runs, pairs); below 0 a pair has hit."""
        names = self.checks[0].subject.neighbours
        if not names:
            return [np.empty((len(check.runs), 0)) for check in self.checks]
        every = (gaps_of(check.by_sign, check.runs) for check in self.checks)
        return [gaps[are_known(gaps)] for gaps in every]

    @property
    def least_gaps(self) -> FloatArray:
        """The least gap of each pair at each value (m), (values, pairs)."""
        return np.array([np.min(gaps, axis=0) for gaps in self.gaps])

    @property
    def hits(self) -> NDArray[np.int64]:
        """The number of runs in which each pair hits at each value, (values, pairs)."""
        return np.array([np.sum(gaps < 0.0, axis=0) for gaps in self.gaps])

    @property
    def worst(self) -> int:
        """The index of the governing value: by outcome, falls, margin, displacement."""
        ranks = [
            (
                (PASSES, UNDECIDED, FAILS).index(outcome_of(one.rows)),
                one.verdicts.fallen,
                -one.margin.stands if one.margin else 0.0,
                np.nan_to_num(moved, nan=np.inf),
            )
            for one, moved in zip(self.checks, self.moved, strict=True)
        ]
        return ranks.index(max(ranks))

    @property
    def answer(self) -> str:
        """The sentence that says at which values the check fails or is undecided."""
        said = []
        for word in (FAILS, UNDECIDED):
            at = [
                f"{value:g}"
                for value, one in zip(self.values, self.checks, strict=True)
                if outcome_of(one.rows) == word
            ]
            said += [f"{word} at friction {', '.join(at)}"] if at else []
        low, high = self.values[0], self.values[-1]
        return f"{'; '.join(said) or PASSES}, of {len(self.values)} values of friction from {low:g} to {high:g}."

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The cells of the table of the values, under `OF_VALUES`."""
        found: list[tuple[str, ...]] = []
        for value, one, moved, gaps in zip(self.values, self.checks, self.moved, self.gaps, strict=True):
            fell = [(run.overturn_time, run.what_fell) for run in one.responses if run.overturned]
            first = "{1} at {0:.4g} s".format(*min(fell)) if fell else ""
            slip = next((row.shown(row.demand) for row in one.rows if row.name == "slip"), "")
            largest = "" if np.isnan(moved) else three_digits(MM.factor * moved)
            hits = f"{int(np.sum(np.any(gaps < 0.0, axis=1)))} of {len(gaps)} runs" if gaps.size else ""
            fallen, _, count = one.fallen
            found.append((f"{value:g}", outcome_of(one.rows), f"{fallen} of {count}", first, largest, slip, hits))
        return found

    @property
    def pairs(self) -> list[tuple[str, ...]]:
        """The cells of the table of the pairs of neighbours that come nearest, under `OF_PAIRS`."""
        found: list[tuple[str, ...]] = []
        least, hits = self.least_gaps, self.hits
        names = self.checks[0].subject.neighbours
        own = [run for check in self.checks for signs in check.by_sign for run in signs]
        impacts = [one for run in own for one in run.impacts] if names else []
        for k in np.argsort(np.min(least, axis=0), kind="stable")[:MOST_PAIRS] if names else ():
            at = int(np.argmin(least[:, k]))
            first = min((one.first for one in impacts if one.between == names[k] and one.first >= 0.0), default=np.nan)
            by = ", ".join(
                f"{count} at {value:g}" for count, value in zip(hits[:, k], self.values, strict=True) if count
            )
            gap = three_digits(MM.factor * least[at, k])
            found.append(
                (names[k], gap, f"{self.values[at]:g}", by or "none", "" if np.isnan(first) else f"{first:.4g}")
            )
        return found

    @property
    def tables(self) -> list[list[tuple[str, ...]]]:
        """The tables of the values and, if there are any, of the pairs of neighbours; the headings are first."""
        pairs = self.pairs
        return [[OF_VALUES, *self.rows], *([[OF_PAIRS, *pairs]] if pairs else [])]

    @property
    def remarks(self) -> tuple[str, ...]:
        """The sentences on what the values apply to, and on a missing vertical motion."""
        upright = any(np.any(scaled.motion.az) for scaled in self.checks[0].action.motions)
        said = (
            "The friction is that of all joints; neighbours and bearings keep theirs. Displacements, hits and gaps are "
        )
        return f"{said}the envelope of the runs as given and varied.", *(() if upright else (STILL,))
