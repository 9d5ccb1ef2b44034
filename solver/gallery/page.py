"""The page of a gallery: one table, one picture, and a section for each object, in one HTML file."""

from __future__ import annotations

import math
from importlib.resources import files
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..checks.report.pictures import embedded
from ..checks.report.rendering import rendered
from ..common.digits import percent, three_digits
from ..plotting.style import FEW_COLOURS, GREY, RED, plain, tidy
from .survey import Gallery

MARKS = "os^Dv<>ph*"
TALL, ROW = 1.6, 0.4  # in, height of the picture without its rows, and of a row
SPREAD = 0.8  # of a row, covered by its marks


def has_margin(gallery: Gallery) -> bool:
    """Return True if the margins were computed."""
    return not math.isnan(gallery.outcomes[0][0].stands)


def picture(gallery: Gallery) -> Figure:
    """Draw the margin of each object on each mount, or the share of the runs that stand."""
    count, mounts = len(gallery.exhibits), gallery.mounts
    figure = Figure(figsize=(8.0, TALL + ROW * count), layout="constrained")
    axes = figure.subplots()
    margins = has_margin(gallery)
    for k, mount in enumerate(mounts):
        shown = [row[k].stands if margins else 1.0 - row[k].fallen / row[k].runs for row in gallery.outcomes]
        level = np.arange(count) + SPREAD * ((k + 0.5) / len(mounts) - 0.5)  # apart, to see each
        style: dict[str, Any] = {
            "color": FEW_COLOURS[k % len(FEW_COLOURS)],
            "marker": MARKS[k % len(MARKS)],
            "markersize": 5,
        }
        axes.plot(shown, level, linestyle="", label=plain(mount.name), **style)
    axes.set_yticks(range(count), [plain(one.name) for one in gallery.exhibits])
    axes.invert_yaxis()
    axes.axvline(1.0, color=RED if margins else GREY, linewidth=1.0)
    axes.set_xlabel("margin: factor on the motions up to which no run falls" if margins else "share that stands")
    tidy(axes)
    figure.legend(loc="outside upper center", ncols=min(len(mounts), 6), frameon=False)
    return figure


def page_text(gallery: Gallery, **values: Any) -> str:
    """Return the HTML text; `values` are `action` (of the ground), `command`, `inputs`, `notes` and `remarks`."""
    firsts = [gallery.first_mount(number) for number in range(len(gallery.exhibits))]
    tools: dict[str, Any] = {"percent": percent, "three_digits": three_digits, "picture": embedded(picture(gallery))}
    tools |= {"has_margin": has_margin(gallery), "fingerprint": gallery.fingerprint}
    return rendered(files(__package__) / "page.html", gallery=gallery, firsts=firsts, **tools, **values)
