"""The answer of a check in plain sentences, composed from its rows and verdicts only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..common.digits import percent, three_digits
from .action import Action
from .margin import Margin
from .scaling import horizontal_of
from .table import Row
from .verdicts import Verdicts

PASSES, FAILS, UNDECIDED = "PASSES", "FAILS", "UNDECIDED"
MOST_NAMED = 3  # largest number of motions listed by name


def outcome_of(rows: Sequence[Row]) -> str:
    """Return PASSES, FAILS or UNDECIDED: FAILS if any row fails, else UNDECIDED if any row is undecided."""
    if any(row.passes is False for row in rows):
        return FAILS
    return UNDECIDED if any(row.undecided for row in rows) else PASSES


def failed_names(rows: Sequence[Row]) -> list[str]:
    """Return the names of the rows that fail; those of unknown demand because of a fall only if no other row fails."""
    failed = [row for row in rows if row.passes is False]
    return [row.name for row in failed if not row.of_fall] or [row.name for row in failed]


def answer(rows: Sequence[Row]) -> str:
    """Return the sentence that says whether the check passes, and which rows fail."""
    outcome = outcome_of(rows)
    if outcome == PASSES:
        return f"{PASSES}: no row of the table fails."
    if outcome == FAILS:
        return f"{FAILS} by: {'; '.join(failed_names(rows))}."
    return f"{UNDECIDED}: no row of the table fails, but some runs neither fell nor came to rest."


def cracked_sentence(names: Sequence[str], by_sign: Sequence[Sequence[Any]]) -> str:
    """Return the sentence on the mortar joints that break through under some motion, or "" if there are none.

    `names` are those of the mortar joints, `by_sign` the responses of the model as given, (motions, signs).
    """
    if not names:
        return ""
    broken = np.array([np.any([run.peaks["bond"] <= 0.0 for run in runs], axis=0) for runs in by_sign])
    said = [
        f"{name} (under {np.sum(broken[:, i])} of {len(by_sign)} motions)"
        for i, name in enumerate(names)
        if broken[:, i].any()
    ]
    if not said:
        return " No joint of mortar breaks through."
    return f" Its mortar breaks through as given: {', '.join(said)}; it is not compared, the joint is dry from then on."


def components_sentence(action: Action, across: bool, has_space: bool = True) -> str:
    """Return the sentence on the number of components of motion that act.

    The model can move along both horizontal directions (`across`), and can be solved in space (`has_space`).
    """
    two = sum(len(horizontal_of(scaled.motion)) > 1 for scaled in action.motions)
    upright = any(np.any(scaled.motion.az) for scaled in action.motions)
    other = " and a vertical one" if upright else ""
    if two == len(action.motions):
        return f"Two horizontal components{other} act together."
    if two:
        return f"Two horizontal components{other} act together under {two} of {len(action.motions)} motions, else one."
    there = "give the second ones (--across)" if across else "without --plane a code spectrum brings both, and --across"
    there += "" if across else " gives a record its second one"
    if not has_space:
        there = "a column like this cannot be solved in space"
    return f"One horizontal component{other} acts; codes ask for two together, which overturn more: {there}."


def verdict_sentence(word: str, found: Verdicts) -> str:
    """Return the sentences on the model as given, and on the share of the varied models that falls.

    `word` names the model: column or structure.
    """
    count, fell, left = len(found.names), found.own_falls, found.own_undecided
    said = [f"falls under {_named(fell, count)}"] if fell else []
    said += [f"is undecided under {_named(left, count)}"] if left else []
    said = said or [f"stands under {f'all {count} motions' if count > 1 else 'the motion'}"]
    return f"As given the {word} {' and '.join(said)}. {_varied(word, found)}"


def falls_sentence(word: str, names: Sequence[str], runs: Sequence[Any]) -> str:
    """Return the sentence on when and where the model as given falls, under the first motions that do it; or "".

    `names` and `runs` are those of the motions, and the responses of the model as given to them.
    """
    fell = []
    for name, run in zip(names, runs, strict=True):
        if run.overturned:
            hits = f"; before it {run.hits_before_fall} hit each other" if run.hits_before_fall else ""
            fell.append(f"at {run.overturn_time:.4g} s under {name} ({run.what_fell}{hits})")
    if not fell:
        return ""
    more = f", and under {len(fell) - MOST_NAMED} more" if len(fell) > MOST_NAMED else ""
    return f"The {word} as given falls {', '.join(fell[:MOST_NAMED])}{more}."


def impacts_sentence(names: Sequence[str], by_sign: Sequence[Sequence[Any]]) -> str:
    """Return the sentence on the neighbours that hit each other as given.

    `names` are those of the motions, `by_sign` the responses of the model as given, (motions, signs).
    """
    hits: dict[str, list[tuple[float, str]]] = {}
    for name, runs in zip(names, by_sign, strict=True):
        # the hardest hit of each pair, of both signs of the motion
        hardest: dict[str, tuple[float, str]] = {}
        for one in (one for run in runs for one in run.impacts if one.gap < 0.0):
            first = "shorter than a row" if np.isnan(one.first) else f"first contact at {one.first:.4g} s"
            hit = one.force, f"{three_digits(1e-3 * one.force)} kN under {name}, {first}"
            hardest[one.between] = max(hit, hardest.get(one.between, hit))
        for between, hit in hardest.items():
            hits.setdefault(between, []).append(hit)
    if not hits:
        return "As given no neighbours hit each other."
    worst = sorted(hits.items(), key=lambda item: max(item[1]), reverse=True)
    said = [
        f"{between} under {len(found)} of {len(by_sign)} motions ({max(found)[1]})"
        for between, found in worst[:MOST_NAMED]
    ]
    more = f", and {len(hits) - MOST_NAMED} more pairs" if len(hits) > MOST_NAMED else ""
    return f"As given these neighbours hit each other: {', '.join(said)}{more}."


def _named(names: Sequence[str], count: int) -> str:
    if len(names) <= MOST_NAMED:
        return " and ".join(names)
    return f"{len(names)} of {count} motions"


def _varied(word: str, found: Verdicts) -> str:
    (low, high), size, count = found.bounds, len(found.varied), len(found.names)
    of = f"such {word}s would fall in such shaking."
    under = f", under {count} motions" if count > 1 else ""
    open_ones = f" and {found.undecided} may fall" if found.undecided else ""
    fell = f"{found.fallen} of {size} varied {word}s fell" if found.fallen else f"None of {size} varied {word}s fell"
    share = f"at most {percent(high)}" if low == 0.0 else f"{percent(low)} to {percent(high)}"
    return f"{fell}{open_ones}{under}: with 95 % confidence {share} of {of}"


def margin_sentence(margin: Margin | None, any_undecided: bool) -> str:
    """Return the sentence on the margin of the model as given and varied, with a caution if any run is undecided."""
    if margin is None:
        return "How much more shaking it bears was not looked for."
    least = margin.stands
    if margin.is_open:
        said = f"Even {three_digits(least)} times this shaking overturned none of them."
    elif least >= 1.0:
        said = f"The shaking can grow to about {three_digits(least)} times before the first of them falls."
    elif least > 0.0:
        said = f"With the shaking reduced to about {three_digits(least)} of this none of them falls."
    else:
        said = "Some fall even under a small part of this shaking."
    return f"{said} Undecided ones do not count as fallen there." if any_undecided else said
