"""The picture of a check over a range of friction."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ...plotting.style import BLUE, GREY, RED, plain, tidy
from ..friction import Envelope
from ..table import MM

MOST_LINES = 6  # pairs that are drawn


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
