"""The least pulse that overturns the column of seven drums, by its length: here and in three other programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from multiblock import Column, simulate_many

from ..case import Case, Outcome
from ..pictures import BLUE, GREEN, GREY, INK, RED, label, panels
from ..rigid_block import FloatArray
from ..rims import label_of
from .codes import column, on_its_edges, on_planar_rims, pulse

SOURCE = (
    "github.com/thlgrs/HybriDFEM at 2f6dc19, "
    "Legacy/Examples/Nonlinear_Dynamic/Dimitri_Column/Dimitri_Column_EqInertia/Plt_FailureDomain.py"
)
LENGTHS = (0.1, 0.2, 0.3, 0.32, 0.34, 0.36, 0.4, 0.5, 0.6, 0.8, 1.0)  # s, of the pulse's first part
OTHERS = {  # g at LENGTHS, of SOURCE; nan: not there
    "UDEC": (3.6, 1.46, 0.87, 0.80, 0.46, math.nan, 0.31, 0.27, 0.25, 0.22, 0.20),
    "LMGC90": (4.3, 1.48, 0.88, 0.82, 0.44, 0.38, 0.30, 0.25, 0.24, 0.22, 0.21),
    "HybriDFEM": (4.16, 1.46, 0.88, 0.81, 0.39, 0.34, 0.29, 0.25, 0.23, 0.22, 0.21),
}
LIMIT = 0.19  # g, by limit analysis, of SOURCE
STIFFNESS = 5e10  # N/m3
LEAST, RATIO, IMPULSE = 0.18, 1.03, 0.5  # g; of each amplitude to the one before; g s: the largest times its length
TOLERANCE = 1e-4
AFTER = 3.0  # s that are followed after the pulse, before the verdict is sought


def columns(rims: Sequence[float] = ()) -> dict[str, Column]:
    """Return the models here, by name."""
    rimmed = {label_of(share): on_planar_rims(column(STIFFNESS, 0.0), share) for share in rims}
    return {
        "rectangles, eta = 1 ms": column(STIFFNESS, 1e-3),
        "edges alone, eta = 1 ms": on_its_edges(column(STIFFNESS, 1e-3)),
        "edges alone, eta = 0.1 ms": on_its_edges(column(STIFFNESS, 1e-4)),
        **rimmed,
    }


def amplitudes(length: float) -> FloatArray:
    """Return the amplitudes tried with a pulse of this length (s), g."""
    count = 1 + math.floor(math.log(IMPULSE / length / LEAST) / math.log(RATIO))
    return LEAST * RATIO ** np.arange(count, dtype=np.float64)


def limits(whole: Column, length: float) -> tuple[float, float]:
    """Return the least amplitude that overturns the column, and the largest under which it stands, g.

    nan: none of those tried.
    """
    tried = amplitudes(length)
    motions = [pulse(amplitude, length) for amplitude in tried]
    table = simulate_many(whole, motions, duration=3.0 * length + AFTER, tolerance=TOLERANCE, keep=("verdict",))
    fallen, standing = (tried[table["verdict"] == verdict].tolist() for verdict in ("overturned", "standing"))
    return min(fallen, default=math.nan), max(standing, default=math.nan)


def compute(data: Path | None, rims: Sequence[float] = ()) -> Outcome:
    """Compute all models at all lengths, beside the others."""
    found = {name: [limits(whole, length) for length in LENGTHS] for name, whole in columns(rims).items()}
    lines = ["least amplitude that overturns, g; in brackets the largest that stands, where it is larger:"]
    lines.append(f"  {'length, s':26s} " + " ".join(f"{length:12g}" for length in LENGTHS))
    for name, values in OTHERS.items():
        lines.append(f"  {name:26s} " + " ".join(f"{value:12.2f}" for value in values))
    for name, pairs in found.items():
        cells = [f"{low:.2f} ({high:.2f})" if high > low else f"{low:.2f}" for low, high in pairs]
        lines.append(f"  {name:26s} " + " ".join(f"{cell:>12s}" for cell in cells))
    numbers: dict[str, Any] = {"lengths": list(LENGTHS), "least that overturns, largest that stands": found}
    return Outcome(lines, numbers, draw(found))


def draw(found: dict[str, list[tuple[float, float]]]) -> Figure:
    """Draw the least amplitudes over the length."""
    figure, axes = panels(1, width=7.2)
    axis = axes[0, 0]
    for (name, values), marker in zip(OTHERS.items(), "^xs", strict=True):
        axis.plot(LENGTHS, values, marker, color=GREY, markerfacecolor="none", label=name)
    for (name, pairs), colour in zip(found.items(), (BLUE, GREEN, RED), strict=False):
        axis.plot(LENGTHS, [low for low, _ in pairs], ".-", color=colour, linewidth=1.2, label=f"here, {name}")
    axis.axhline(LIMIT, color=INK, linestyle=":", linewidth=1.0, label="limit analysis")
    axis.set_yscale("log")
    axis.set_yticks([0.2, 0.5, 1.0, 2.0, 4.0], ["0.2", "0.5", "1", "2", "4"])
    axis.minorticks_off()
    axis.legend(fontsize=8)
    label(axis, "length of the pulse's first part, s", "its amplitude, g", "least pulse that overturns seven drums")
    return figure


CASE = Case(
    name="failure-amplitudes",
    title="the least pulse that overturns a column of seven drums, in four programs",
    source=SOURCE,
    model="the column of `codes`, k = 5e10 N/m3, joints of the whole width and bearing at their edges alone",
    fitted="nothing",
    predicted="the least amplitude of a pulse that overturns, by its length",
    compute=compute,
    takes_rims=True,
)
