"""A check as text for the terminal: the motions, the tables, the answer in a few sentences."""

from __future__ import annotations

from collections.abc import Sequence

from ..checks.action import Action, motion_rows
from ..checks.by_hand import NOT_IN_SPACE
from ..checks.check import Check
from ..checks.friction import Envelope
from ..checks.table import Row
from ..checks.variants import brief_rows, compared, differences
from .reports import text_columns

HEADINGS = ("check", "where", "demand", "capacity", "ratio", "")


def action_lines(action: Action) -> list[str]:
    """Return the lines on the target and on each motion with its factors."""
    lines = [f"action: {action.target.name}" if action.target else "action: no target spectrum"]
    lines.append(f"motions: {action.how}; counted: {action.statistic}")
    if action.fit is not None and action.periods is not None:
        (least, most), (low, high) = action.fit, action.periods
        lines.append(f"fit: mean of their spectra {least:.2f} to {most:.2f} of the target, {low:.3g} to {high:.3g} s")
    return [*lines, *text_columns(motion_rows(action), range(1, 9))]


def check_lines(check: Check) -> list[str]:
    """Return the tables with their notes, the disagreement of methods, and the sentences of the answer."""
    lines = [f"{check.name}, first period {check.period:.3g} s", *_table(check.rows)]
    lines += ["by hand:", *_table(check.by_hand.rows), *check.agreement] if check.by_hand else [NOT_IN_SPACE]
    events = (line for line in (check.falls_sentence, check.impacts_sentence) if line)
    said = (check.answer, check.verdict, *events, check.margin_sentence, *check.of_joints, *check.remarks)
    return [*lines, *said, f"inputs {check.fingerprint[:16]}"]


def variants_lines(checks: Sequence[Check]) -> list[str]:
    """Return a table of the demands and ratios of all checks, one column for each; the first is the original."""
    rows = [["", *(check.name for check in checks)], *brief_rows(checks)]
    lines = text_columns(rows, range(1, 1 + len(checks)))
    return [f"{compared(checks)}, demand and its ratio to the capacity:", *lines, *differences(checks)]


def friction_lines(envelope: Envelope) -> list[str]:
    """Return the tables of a check over a range of friction, by value and by pair of neighbours, and its answer."""
    lines = [line for rows in envelope.tables for line in text_columns(rows)]
    return [*lines, envelope.answer, *envelope.remarks]


def _table(rows: Sequence[Row]) -> list[str]:
    """Return the rows as aligned lines, followed by their notes."""
    lines = text_columns([HEADINGS, *(row.texts for row in rows)], range(2, 5))
    return [*lines, *(f"  {row.name}: {row.remark}" for row in rows)]
