"""Two blocks, one on the other, that rock in the same sense and in opposite ones, against two rigid blocks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from multiblock import Block, Column, Joint, Motion, simulate
from solver.models.column.packing import InitialState

from ..case import Case, Outcome
from ..pictures import BLUE, GREEN, GREY, RED, label, panels
from ..rigid_block import FloatArray
from ..two_blocks import G, Pair, Slab

DENSITY, DEPTH = 2500.0, 1.0  # kg/m3, m
LOWER, UPPER = Slab(1.2, 4.0, 1.2 * 4.0 * DENSITY), Slab(0.9, 2.4, 0.9 * 2.4 * DENSITY)
PATTERNS = {"the same sense": (1, 1), "opposite senses": (1, -1)}
TILTS = 0.35, 0.3  # of the slenderness angles: of the lower block, and of the upper one on it
MODULI = (1e9, 1e10, 1e11)  # N/m3
ROW = 1e-3  # s


def column(stiffness: float) -> Column:
    """Return both blocks, undamped."""
    law = Joint(stiffness, 0.0)
    return Column("two", tuple(Block(slab.height, slab.width, DEPTH, slab.mass, law) for slab in (UPPER, LOWER)))


def tilts() -> tuple[float, float]:
    """Return the tilts of the lower block, and of the upper one relative to it, rad."""
    lower, upper = (
        part * math.atan(slab.width / slab.height) for part, slab in zip(TILTS, (LOWER, UPPER), strict=True)
    )
    return lower, upper


def released(stiffness: float, pair: Pair, length: float) -> tuple[FloatArray, FloatArray]:
    """Return the times and rotations, the lower block first, from rest; each edge is pressed in as its load
    asks for.
    """
    tilt, relative = tilts()
    lower = pair.sides[0] * tilt
    opening = []
    for slab, angle, load in ((UPPER, relative, UPPER.mass * G), (LOWER, tilt, (UPPER.mass + LOWER.mass) * G)):
        pressed = math.sqrt(2.0 * load * math.tan(angle) / (stiffness * DEPTH))
        opening.append(0.5 * slab.width * math.sin(angle) - pressed)
    start = InitialState(rotation=[lower + pair.sides[1] * relative, lower], opening=opening)
    still = Motion.from_samples(length, [0.0, 0.0])
    found = simulate(column(stiffness), still, initial=start, output_step=ROW, settle=0.0, tolerance=1e-7)
    return found.time, found.ry[:, ::-1]


def landing(time: FloatArray, angles: FloatArray, pair: Pair) -> float:
    """Return the time at which one of both rotations changes its sign, s."""
    left = np.minimum(pair.sides[0] * angles[:, 0], pair.sides[1] * (angles[:, 1] - angles[:, 0]))
    k = int(np.flatnonzero(left < 0.0)[0])
    return float(time[k - 1] + (time[k] - time[k - 1]) * left[k - 1] / (left[k - 1] - left[k]))


def compute(data: Path | None) -> Outcome:
    """Compute histories until a corner lands, and when it does."""
    lines, numbers, drawn = [], {}, {}
    for name, sides in PATTERNS.items():
        pair = Pair(LOWER, UPPER, sides)
        time, rigid = pair.released(*tilts())
        lines.append(
            f"{name}: a corner lands at {time[-1]:.4f} s; here, over that; largest deviation before, of the peak"
        )
        rows = []
        for stiffness in MODULI:
            t, angles = released(stiffness, pair, 1.2 * float(time[-1]))
            lands = landing(t, angles, pair)
            early = t < min(lands, float(time[-1]))
            known = np.column_stack([np.interp(t[early], time, rigid[:, i]) for i in range(2)])
            apart = float(np.max(np.abs(angles[early] - known)) / np.max(np.abs(rigid)))
            rows.append([lands / float(time[-1]), apart])
            lines.append(f"  k = {stiffness:.0e} N/m3: {rows[-1][0]:.4f}, {apart:.4f}")
            drawn[name, stiffness] = t, angles
        numbers[name] = {"landing": float(time[-1]), "moduli": list(MODULI), "ratio and deviation": rows}
        drawn[name, math.inf] = time, rigid
    return Outcome(lines, numbers, draw(drawn))


def draw(drawn: dict[tuple[str, float], tuple[FloatArray, FloatArray]]) -> Figure:
    """Draw the rotations of both blocks in both patterns."""
    figure, axes = panels(2)
    for name, axis in zip(PATTERNS, axes[0], strict=True):
        for stiffness, colour in zip(MODULI, (RED, GREEN, BLUE), strict=True):
            t, angles = drawn[name, stiffness]
            axis.plot(t, angles[:, 0], "--", color=colour, linewidth=1.0)
            axis.plot(t, angles[:, 1], color=colour, linewidth=1.0, label=f"k = {stiffness:.0e} N/m3")
        t, angles = drawn[name, math.inf]
        axis.plot(t, angles, color=GREY, linewidth=3.0, alpha=0.5, zorder=0)
        axis.axvline(t[-1], color=GREY, linewidth=0.8)
        axis.legend(fontsize=8)
        label(axis, "s", "rotation, rad", f"{name}; dashed: lower block, wide: rigid")
    return figure


CASE = Case(
    name="two-blocks",
    title="two blocks that rock in the same sense and in opposite ones, against rigid ones",
    source="patterns of Spanos, Roussis and Politopoulos (2001), Soil Dynamics and Earthquake Engineering 21; "
    "Lagrange's equations here",
    model="two blocks of 4 m x 1.2 m and 2.4 m x 0.9 m, undamped",
    fitted="nothing",
    predicted="both rotations from rest until a corner lands, and when",
    compute=compute,
)
