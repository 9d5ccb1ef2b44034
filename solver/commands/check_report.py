"""A check as text for the terminal: the motions, the tables, the answer in a few sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..checks.action import Action
from ..checks.by_hand import NOT_IN_SPACE
from ..checks.check import Check
from ..checks.friction import OF_PAIRS, OF_VALUES, Envelope
from ..checks.table import Row
from ..checks.variants import compared, differences
from ..ground.intensity import pgv
from ..ground.motion import STANDARD_GRAVITY

HEADINGS = ("check", "where", "demand", "capacity", "ratio", "")


def action_lines(action: Action) -> list[str]:
    """Return the lines on the target and on each motion with its factors."""
    lines = [f"action: {action.target.name}" if action.target else "action: no target spectrum"]
    lines.append(f"motions: {action.how}; counted: {action.statistic}")
    if action.fit is not None and action.periods is not None:
        (least, most), (low, high) = action.fit, action.periods
        lines.append(f"fit: mean of their spectra {least:.2f} to {most:.2f} of the target, {low:.3g} to {high:.3g} s")
    # table of the motions
    width = max(len(scaled.name) for scaled in action.motions)
    across = any(scaled.motion.has_ay for scaled in action.motions)
    other = "  across (g)" if across else ""
    fast = "  across (m/s)" if across else ""
    lines.append(f"{'motion':{width}s}  factor  vertical  PGA (g){other}  vertical (g)  PGV (m/s){fast}")
    for scaled in action.motions:
        vertical = float(np.max(np.abs(scaled.motion.az)))
        upright = f"{scaled.vertical_factor:8.3g}" if vertical else " " * 8
        pga, rise = scaled.motion.pga / STANDARD_GRAVITY, vertical / STANDARD_GRAVITY
        other = f"  {scaled.motion.peak('ay') / STANDARD_GRAVITY:10.3g}" if across else ""
        fast = f"  {pgv(scaled.motion, 'ay'):12.3g}" if across else ""
        lines.append(
            f"{scaled.name:{width}s}  {scaled.factor:6.3g}  {upright}  {pga:7.3g}{other}  {rise:12.3g}  "
            f"{pgv(scaled.motion):9.3g}{fast}"
        )
    return lines


def check_lines(check: Check) -> list[str]:
    """Return the tables with their notes, the disagreement of methods, and the sentences of the answer."""
    lines = [f"{check.name}, first period {check.period:.3g} s", *_table(check.rows)]
    lines += ["by hand:", *_table(check.by_hand.rows), *check.agreement] if check.by_hand else [NOT_IN_SPACE]
    events = (line for line in (check.falls_sentence, check.impacts_sentence) if line)
    said = (check.answer, check.verdict, *events, check.margin_sentence, *check.of_joints, *check.remarks)
    return [*lines, *said, f"inputs {check.fingerprint[:16]}"]


def variants_lines(checks: Sequence[Check]) -> list[str]:
    """Return a table of the demands and ratios of all checks, one column for each; the first is the original."""
    width = max(22, *(len(check.name) for check in checks))
    lines = [f"{compared(checks)}, demand and its ratio to the capacity:"]
    lines.append(f"{'':26s}" + "".join(f"  {check.name:>{width}s}" for check in checks))
    names = list(dict.fromkeys(row.name for check in checks for row in check.rows))
    for name in names:
        cells = []
        for check in checks:
            row = next((row for row in check.rows if row.name == name), None)
            cells.append("" if row is None else row.brief)
        lines.append(f"{name:26s}" + "".join(f"  {cell:>{width}s}" for cell in cells))
    return [*lines, *differences(checks)]


def friction_lines(envelope: Envelope) -> list[str]:
    """Return the tables of a check over a range of friction, by value and by pair of neighbours, and its answer."""
    tables = ((OF_VALUES, envelope.rows), (OF_PAIRS, envelope.pairs))
    lines = [line for head, rows in tables if rows for line in text_columns([head, *rows])]
    return [*lines, envelope.answer, *envelope.remarks]


def text_columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows of cells as lines, aligned on the left."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def _table(rows: Sequence[Row]) -> list[str]:
    """Return the rows as aligned lines, followed by their notes."""
    cells = [HEADINGS, *(row.texts for row in rows)]
    widths = [max(len(line[k]) for line in cells) for k in range(len(HEADINGS))]
    lines = [
        "  ".join(f"{text:{'>' if 2 <= j <= 4 else '<'}{widths[j]}s}" for j, text in enumerate(line)).rstrip()
        for line in cells
    ]
    return [*lines, *(f"  {row.name}: {row.remark}" for row in rows)]
