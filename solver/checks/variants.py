"""The comparison of a variant with the checked model, in a sentence: better, worse, or not to be distinguished."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.errors import InputError
from ..models.uncertainty import CONFIDENCE
from .check import Check
from .spectra import FloatArray
from .subject import OF_BEARINGS
from .table import BEARING, MM, MRAD, PERCENT, Unit
from .verdicts import falls

POINTS = Unit("percentage points", PERCENT.factor)
MOST_NAMED = 4  # largest number of changes that are listed
SAME = "cannot be distinguished"
STRIPS = 10_000  # of the sum over a quarter turn: Student's quantile to 1e-6


def directions(checks: Sequence[Check]) -> Sequence[Check]:
    """Return the checks of the first model: of both directions, if they were asked for, else one."""
    return checks[: 2 if checks[0].both else 1]


def compared(checks: Sequence[Check]) -> str:
    """Return what a table of several checks compares: variants, the two directions, or these and variants."""
    if not checks[0].both:
        return "variants under the same motions"
    more = " and variants, under the motions of the first" if len(checks) > 2 else ""
    return f"the two directions{more}"


def brief_rows(checks: Sequence[Check]) -> list[list[str]]:
    """Return a row for each demand: its name, and the demand and ratio of each check as text."""
    briefs = [{row.name: row.brief for row in reversed(check.rows)} for check in checks]  # the first of a name
    names = dict.fromkeys(row.name for check in checks for row in check.rows)
    return [[name, *(brief.get(name, "") for brief in briefs)] for name in names]


def differences(checks: Sequence[Check]) -> list[str]:
    """Return the sentences that compare all checks with the first, each with the falls and hits as given."""
    said = ((difference(checks[0], one), one.falls_sentence, one.impacts_sentence) for one in checks[1:])
    return [" ".join(filter(None, sentences)) for sentences in said]


def difference(first: Check, other: Check) -> str:
    """Return the sentence that compares `other` with `first` under the same motions: falls, and displacements.

    Runs form pairs: of one motion and the same random numbers. If the models differ in their numbers of joints, pairs
    share the motion alone: the factor on it is drawn after those of the joints, so that all have other numbers. Runs
    under one motion are alike, so the mean of its pairs counts as one trial; with a single motion each pair is a trial.
    Pairs of which one run falls do not count for the displacements.
    """
    pairs = _moved(first), _moved(other)
    of = "motions" if len(pairs[0]) > 1 else "runs"
    fell = [np.isinf(moved) for moved in pairs]
    found = []
    # falls: difference of the shares, in percentage points
    if np.any(fell):
        more = pairs_of(fell[1].astype(float), fell[0].astype(float))
        found.append(_bounded(_falls(fell[1], fell[0], float(np.mean(more))), more, POINTS, of))
    # displacements of the pairs in which both stand
    stand = ~(fell[0] | fell[1])
    if any(check.subject.bearings[0] for check in (first, other)):  # sliding on bearings is no damage
        apart = pairs_of(*(np.where(stand[:, :1], _tilt(check), math.nan) for check in (other, first)))
        found += [_said("its blocks tilt by {}", apart, MRAD, "motions")] if apart.size else []
    elif stand.any():
        moved = pairs_of(*(np.where(stand, values, math.nan) for values in reversed(pairs)))
        found.append(_said("it moves {}", moved, MM, of))
    # one sentence of all parts
    words = {word for _, word in found} - {SAME}
    word = " in one and ".join(sorted(words)) + (" in the other" if len(words) > 1 else "") if words else SAME
    parts = "; ".join(f"{text}: {one}" if len(found) > 1 else text for text, one in found)
    what = described(first.subject.model, other.subject.model)
    name = f"{other.name} ({what})" if what else other.name
    return f"{name} against {first.name}: {word}. {parts[0].upper()}{parts[1:]}.{_asked(other)}"


def described(first: Any, other: Any) -> str:
    """Return the numbers in which two models differ, as text; "" if unknown.

    Equal changes of several blocks are listed once.
    """
    try:
        before, after = _flat("", first.to_dict()), _flat("", other.to_dict())
    except InputError:
        return ""
    if first.n != other.n:
        return f"{other.n} blocks in place of {first.n}"
    changes: dict[str, list[str]] = {}
    for key in dict.fromkeys((*before, *after)):
        old, new = before.get(key, "none"), after.get(key, "none")
        if old != new and key != "name":
            changes.setdefault(f"{re.sub(r'[0-9]+', '', key)} {old} to {new}", []).append(key)
    said = [
        keys[0] + change[change.index(" ") :] if len(keys) == 1 else f"{change.replace('[]', '')}, {len(keys)} times"
        for change, keys in changes.items()
    ]
    return "; ".join(said[:MOST_NAMED]) + (f"; {len(said) - MOST_NAMED} more" if len(said) > MOST_NAMED else "")


def _flat(key: str, value: Any) -> dict[str, str]:
    """Return the values of nested tables as texts, by keys such as block[1].joint.damping."""
    if isinstance(value, Mapping):
        return {name: text for k, v in value.items() for name, text in _flat(f"{key}.{k}".lstrip("."), v).items()}
    if isinstance(value, (list, tuple)):
        return {name: text for k, v in enumerate(value, 1) for name, text in _flat(f"{key}[{k}]", v).items()}
    return {key: f"{value:.4g}" if isinstance(value, float) else str(value)}


def _tilt(check: Check) -> FloatArray:
    """Return the largest rotation of a block about a horizontal axis (rad), (motions, 1)."""
    return check.demands.most(lambda run: [np.max(np.hypot(run.peaks["rx"], run.peaks["ry"]))])


def _asked(check: Check) -> str:
    """Return the sentence on the displacement demand of the bearings, over all runs that stand; "" without bearings.

    In each run the largest counts of those bearings whose capacity is that of the row in the table.
    """
    names, capacity = check.subject.bearings
    row = next((row for row in check.rows if row.name == BEARING), None)
    if row is None:
        return ""
    # largest demand of each run that stands
    asked = np.where(capacity == row.capacity, 1.0, 0.0) * _of_bearings(check)
    moved = np.where(_fell(check), math.nan, np.max(asked, axis=2))
    stand = int(np.sum(~np.isnan(moved)))
    if not stand:
        return f" What displacement its bearings are asked for is not known: all of its {moved.size} runs fall."
    # mean over the runs, its bounds, and the largest
    trials = pairs_of(moved, np.zeros_like(moved))
    runs = f"{stand} runs" if stand == moved.size else f"the {stand} of {moved.size} runs that stand"
    said = f" Over {runs} its bearings are asked for"
    said += f" {MM.factor * np.mean(trials):.3g} mm in the mean"
    if len(trials) > 1:
        low, high = mean_bounds(trials)
        of = "motions" if len(moved) > 1 else "runs"
        said += f" ({MM.factor * low:.3g} to {MM.factor * high:.3g} mm at {100.0 * CONFIDENCE:g} % confidence"
        said += f", {len(trials)} {of})"
    most = np.unravel_index(np.nanargmax(moved), moved.shape)
    where = names[int(np.argmax(asked[most]))]
    said += f" and for {MM.factor * moved[most]:.3g} mm at most ({where})"
    return f"{said}; they allow {MM.factor * row.capacity:.3g} mm."


def _of_bearings(check: Check) -> FloatArray:
    """Return the largest displacement of each bearing (m), (motions, runs, bearings); the run as given first."""
    own = check.demands.most(lambda run: run.peaks["d"])[:, None]
    return np.concatenate([own, check.runs[OF_BEARINGS].reshape(len(own), -1, own.shape[2])], axis=1)


def _fell(check: Check) -> NDArray[np.bool_]:
    """Return True for each run that falls, (motions, runs); the run as given first."""
    own = falls(check.verdicts.own)[:, None]
    return np.concatenate([own, falls(check.verdicts.varied).reshape(len(own), -1)], axis=1)


def _moved(check: Check) -> FloatArray:
    """Return the displacement of each run (m), (motions, runs), inf where it falls; the run as given first."""
    varied = np.where(falls(check.verdicts.varied), math.inf, check.subject.tops(check.runs))
    own = check.displacement.values
    return np.column_stack([own, varied.reshape(len(own), -1)])


def pairs_of(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the differences `one` less `other` of each trial, (trials,), from values of paired runs (motions, runs).

    A trial is the mean over the pairs of a motion; with one motion each pair is one. Pairs with NaN are left out.
    """
    apart = one - other
    if len(apart) == 1:
        return apart[~np.isnan(apart)]
    return np.array([np.mean(row[~np.isnan(row)]) for row in apart if not np.isnan(row).all()])


def _said(what: str, trials: FloatArray, unit: Unit, of: str) -> tuple[str, str]:
    """Return the mean difference with its bounds as text, and which model is better; less is better."""
    mean = float(np.mean(trials))
    shown = what.format(f"{unit.factor * abs(mean):.3g} {unit.name} {'less' if mean < 0.0 else 'more'}")
    return _bounded(shown, trials, unit, of)


def _falls(other: NDArray[np.bool_], first: NDArray[np.bool_], more: float) -> str:
    """Return the text on how many percentage points more or fewer runs fall, with the counts."""
    counts = f"{int(np.sum(other))} of {other.size} instead of {int(np.sum(first))}"
    if more == 0.0:
        return f"as many runs fall: {counts}"
    points = f"{POINTS.factor * abs(more):.3g} {POINTS.name}"
    return f"{points} {'fewer' if more < 0.0 else 'more'} runs fall: {counts}"


def _bounded(shown: str, trials: FloatArray, unit: Unit, of: str) -> tuple[str, str]:
    """Return the text with the bounds of the mean difference, and which model is better; less is better."""
    if len(trials) < 2:
        return f"{shown}, of one pair alone", SAME
    low, high = mean_bounds(trials)
    bounds = f"{unit.factor * low:+.3g} to {unit.factor * high:+.3g} {unit.name} at {100.0 * CONFIDENCE:g} % confidence"
    if low == high != 0.0:  # no spread, from which no bounds follow
        bounds = "no bounds, all differ by the same"
    word = "better" if high < 0.0 else "worse" if low > 0.0 else SAME
    return f"{shown} ({bounds}, {len(trials)} {of})", word


def mean_bounds(trials: FloatArray) -> tuple[float, float]:
    """Return Student's confidence bounds on the mean of trials, (trials,), at least two."""
    free = len(trials) - 1
    mean, apart = float(np.mean(trials)), student(free) * float(np.std(trials, ddof=1)) / math.sqrt(len(trials))
    return mean - apart, mean + apart


@lru_cache
def student(free: int) -> float:
    """Return the two-sided quantile of Student's distribution at `CONFIDENCE`, for `free` degrees of freedom.

    It is sqrt(free) tan(angle), by a sum over the angle, whose density is cos(angle)^(free - 1).
    """
    width = 0.5 * math.pi / STRIPS
    share = np.cumsum(np.cos(width * (np.arange(STRIPS) + 0.5)) ** (free - 1))
    angle = np.interp(CONFIDENCE * share[-1], share, width * np.arange(1, STRIPS + 1))
    return math.sqrt(free) * math.tan(float(angle))
