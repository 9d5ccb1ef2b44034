"""The effect of size on the displacement of a rocking block, where it is far from overturning."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from multiblock import Block, Column, Joint, Motion, simulate_many, wavelets

from ..case import Case, Outcome
from ..pictures import BLUE, GREY, RED, label, panels
from ..rigid_block import Flags, FloatArray

G = 9.80665  # m/s2
ALPHA, DENSITY = 0.15, 2700.0  # rad, kg/m3
HEIGHTS = (2.0, 4.0, 8.0, 16.0, 32.0)  # m
STIFFNESS, DAMPING = 5e9, 2e-3  # N/m3, s: the same for all
SEEDS = 100
AMPLITUDE, FREQUENCY, DURATION = 3.0 * ALPHA * G, 4.0, 15.0  # m/s2, Hz, s: of filtered noise
FAR = 0.3  # of the width, at which the top is over the edge: below it a block is far from overturning
REFERENCE = HEIGHTS.index(16.0)


def block(height: float) -> Column:
    """Return a block of slenderness ALPHA."""
    width = height * math.tan(ALPHA)
    return Column("block", (Block(height, width, width, DENSITY * height * width**2, Joint(STIFFNESS, DAMPING)),))


def motions() -> list[Motion]:
    """Return noise through the ground, one motion for each seed."""
    return [wavelets.filtered_noise(AMPLITUDE, FREQUENCY, DURATION, seed) for seed in range(SEEDS)]


def compared(peak: FloatArray, fallen: Flags, heights: FloatArray) -> list[dict[str, Any]]:
    """Return the peaks of each size over those of REFERENCE under the same motion; peak, fallen: (sizes, motions)."""
    far = ~fallen & (peak < FAR * heights[:, None] * math.tan(ALPHA))
    rows = []
    for k, height in enumerate(heights):
        both = far[k] & far[REFERENCE]
        ratio = peak[k, both] / peak[REFERENCE, both]
        share = np.quantile(ratio, (0.16, 0.5, 0.84)).tolist() if both.any() else [math.nan] * 3
        rows.append(
            {
                "height": float(height),
                "fallen": float(np.mean(fallen[k])),
                "far": int(both.sum()),
                "median_peak": float(np.median(peak[k, ~fallen[k]])) if np.any(~fallen[k]) else math.nan,
                "ratio": share,
            }
        )
    return rows


def compute(data: Path | None) -> Outcome:
    """Run the same motions for all sizes."""
    shaking = motions()
    tables = [simulate_many(block(height), shaking, tolerance=1e-4) for height in HEIGHTS]
    peak = np.array([table["peak_top_ux"][:, 0] for table in tables])
    fallen = np.array([table["verdict"] == "overturned" for table in tables], dtype=bool)
    rows = compared(peak, fallen, np.array(HEIGHTS))
    lines = [f"{SEEDS} motions, PGA {AMPLITUDE / G:.2f} g; ratio: peak over that of the block of 16 m, same motion,"]
    lines.append(f"  where both stay below {FAR} of their width (16, 50, 84 %):")
    for row in rows:
        low, middle, high = row["ratio"]
        lines.append(
            f"  {row['height']:4.0f} m: {100 * row['fallen']:3.0f} % fall, "
            f"median peak {1e3 * row['median_peak']:5.0f} mm, "
            f"ratio {low:.2f} {middle:.2f} {high:.2f} ({row['far']} motions)"
        )
    return Outcome(lines, {"rows": rows}, draw(peak, fallen, rows))


def draw(peak: FloatArray, fallen: Flags, rows: list[dict[str, Any]]) -> Figure:
    """Draw the peaks over size, and their ratio to those of one size."""
    figure, axes = panels(2)
    left, right = axes[0]
    for k, height in enumerate(HEIGHTS):
        stands = ~fallen[k]
        left.plot(np.full(stands.sum(), height), peak[k, stands], ".", color=BLUE, markersize=3, alpha=0.5)
    left.plot(HEIGHTS, [height * math.tan(ALPHA) for height in HEIGHTS], color=RED, label="the width")
    left.plot(HEIGHTS, [row["median_peak"] for row in rows], "o-", color=GREY, label="median of those that stand")
    left.set_xscale("log", base=2)
    left.set_yscale("log")
    left.legend(fontsize=8)
    label(left, "height, m", "peak displacement of the top, m", f"blocks of alpha = {ALPHA}")
    ratio = np.array([row["ratio"] for row in rows])
    error = np.abs(ratio[:, [0, 2]] - ratio[:, [1]]).T
    right.errorbar(HEIGHTS, ratio[:, 1], error, fmt="o-", color=BLUE, markersize=4)
    right.axhline(1.0, color=GREY, linewidth=0.8)
    right.set_xscale("log", base=2)
    for axis in (left, right):
        axis.set_xticks(HEIGHTS, [f"{height:g}" for height in HEIGHTS])
    label(right, "height, m", "peak over that of 16 m", "16, 50, 84 %; both below 0.3 of the width")
    return figure


CASE = Case(
    name="size",
    title="displacement away from overturning against size",
    source="the claim: Reggiani Manzo and Vassiliou (2019), Earthquake Engineering and Structural Dynamics 48",
    model="one block, alpha 0.15, 2 to 32 m high, one stone and one joint; filtered noise of 0.45 g",
    fitted="nothing",
    predicted="peak displacement of the top under the same motions",
    compute=compute,
)
