"""The pictures of a check, as PNG inside HTML: the column, the spectra, a range of friction."""

from __future__ import annotations

import base64
import io

import numpy as np
from matplotlib.figure import Figure

from ...ground.motion import STANDARD_GRAVITY
from ...models.column.model import Column
from ...plotting.drawings import DisplacementHistories, corners_of, draw_column, number_joints, rule_heights
from ...plotting.style import BLUE, GREY, RED, plain, tidy
from ..check import Check
from ..friction import Envelope
from ..scaling import MEAN_FROM, horizontal_psa
from ..table import MM

DPI = 140
MOST_LINES = 6  # pairs of neighbours that are drawn
PERIODS = np.geomspace(0.04, 4.0, 100)  # s
LABELS = {0.05: "0.05", 0.1: "0.1", 0.2: "0.2", 0.5: "0.5", 1.0: "1", 2.0: "2", 4.0: "4"}


def embedded(figure: Figure, tight: bool = False) -> str:
    """Return a data URL that contains the picture as PNG.

    With `tight` the margin around the picture is cropped.
    """
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=DPI, format="png", bbox_inches="tight" if tight else None)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def column_picture(column: Column) -> Figure:
    """Draw the column as built, with its heights and the numbers of its joints."""
    figure = Figure(figsize=(2.6, 4.6), layout="constrained")
    axes = figure.add_subplot()
    zero = np.zeros((1, column.n))
    places = DisplacementHistories(column, zero, zero, zero)
    draw_column(axes, places, 0, 1.0)
    corners, height = corners_of(places, 0, 1.0), sum(block.height for block in column.blocks)
    (left, _), (right, _) = np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))
    number_joints(axes, corners)
    rule_heights(axes, height, left - 0.2 * height)
    axes.set(xlim=(left - 0.22 * height, right + 0.18 * height), ylim=(-0.03 * height, 1.05 * height))
    return figure


def spectra_picture(check: Check) -> Figure:
    """Draw the spectra of the motions as applied, their mean, and the target with the range of the fit."""
    action = check.action
    figure = Figure(figsize=(7.0, 3.5), layout="constrained")
    axes = figure.add_subplot()
    if action.periods is not None:
        axes.axvspan(*action.periods, color="0.95", label="range of the fit")
    # one line per motion, then mean and target
    found = [horizontal_psa(scaled.motion, PERIODS) / STANDARD_GRAVITY for scaled in action.motions]
    if len(found) == 1:
        axes.plot(PERIODS, found[0], color="black", linewidth=1.8, label=plain(action.motions[0].name))
    else:
        labels = [f"each of {len(found)} motions", *[None] * (len(found) - 1)]
        for values, label in zip(found, labels, strict=True):
            axes.plot(PERIODS, values, color="0.65", linewidth=0.8, label=label)
        which = "mean, which counts" if len(found) >= MEAN_FROM else "mean"
        axes.plot(PERIODS, np.mean(found, axis=0), color="black", linewidth=1.8, label=which)
    if action.ground:
        ground = [horizontal_psa(scaled.motion, PERIODS) / STANDARD_GRAVITY for scaled in action.ground]
        axes.plot(PERIODS, np.mean(ground, axis=0), color=BLUE, linestyle="-.", linewidth=1.4, label="ground, mean")
    if action.target is not None:
        target = action.target.psa(PERIODS) / STANDARD_GRAVITY
        axes.plot(PERIODS, target, color=RED, linestyle="--", linewidth=1.6, label="target")
    if check.period >= PERIODS[0]:
        axes.axvline(check.period, color="0.5", linestyle=":", linewidth=1.0)
        axes.text(
            check.period, 0.99, " $T_1$", transform=axes.get_xaxis_transform(), va="top", fontsize=8, color="0.35"
        )
    axes.set(xscale="log", xlabel="period (s)", ylabel="pseudo-acceleration (g), 5 % damping", ylim=(0.0, None))
    axes.set_xlim(PERIODS[0], PERIODS[-1])
    axes.set_xticks(list(LABELS), labels=list(LABELS.values()))
    axes.minorticks_off()
    axes.grid(color="0.9", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside right upper", fontsize=7, frameon=False)
    return figure


def friction_picture(envelope: Envelope) -> Figure:
    """Draw displacement and share of falls over the friction, and beside them the least gaps of the nearest pairs."""
    names, values = envelope.checks[0].subject.neighbours, envelope.values
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    first, *others = figure.subplots(1, 2 if names else 1, squeeze=False)[0]
    first.plot(values, MM.factor * envelope.moved, "o-", color=BLUE)
    first.set_xlabel("friction")
    first.set_ylabel("largest displacement (mm)", color=BLUE)
    first.margins(y=0.1)
    first.set_ylim(bottom=0.0)
    tidy(first)
    share = first.twinx()
    share.plot(
        values, [100.0 * one.verdicts.fallen / len(one.verdicts.varied) for one in envelope.checks], "s--", color=RED
    )
    share.set_ylabel("varied runs that fall (%)", color=RED)
    share.set_ylim(-2.0, 102.0)
    for axes in others:
        least = MM.factor * envelope.least_gaps
        for k in np.argsort(np.min(least, axis=0), kind="stable")[:MOST_LINES]:
            axes.plot(values, least[:, k], "o-", label=plain(names[k]))
        axes.axhline(0.0, color=GREY, linewidth=1.0)
        axes.set(xlabel="friction", ylabel="least gap (mm)")
        axes.legend(fontsize=7, frameon=False)
        tidy(axes)
    return figure
