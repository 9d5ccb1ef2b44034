"""The reference study of a multidrum column again, and with what the page on it leaves out: round drums that slide."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from multiblock import Column, Results, Study, run_study
from solver.studies.statistics import Fragility, failed_of, fit_fragility

from ..case import Case, Outcome
from ..pictures import BLUE, RED, label, panels

STUDY = Path(__file__).parents[2] / "examples" / "studies" / "reference.toml"
SAMPLES = 20  # at each of the 20 points
FRICTION = 0.7
DIAMETER = 1.65  # m
LIMITS = {"0.15 D": 0.15 * DIAMETER, "0.35 D": 0.35 * DIAMETER, "overturned": None}
RESAMPLED = 40  # for the bounds


def round_and_sliding(column: Column) -> Column:
    """Return its drums as circles of their width, with the friction of stone; masses, centroids and moduli are kept."""
    blocks = []
    for block in column.blocks:
        joint = replace(block.joint, friction=FRICTION, width=None, depth=None)
        blocks.append(replace(block, section="circle", depth=block.width, joint=joint))
    return replace(column, name=f"{column.name}-round", blocks=tuple(blocks))


def variants(samples: int) -> dict[str, Study]:
    """Return the study as published on the page, and with round drums that slide; fewer samples."""
    study = Study.from_toml(STUDY).with_runs(samples)
    columns = tuple(round_and_sliding(column) for column in study.columns if isinstance(column, Column))
    slid = replace(study, name=f"{study.name}-round", columns=columns, keep=(*study.keep, "residual_slip"))
    return {"rectangles, stuck": study, f"round, friction {FRICTION}": slid}


def fragilities(results: Results) -> dict[str, Fragility]:
    """Return the lognormal fragilities over PGV (m/s), of each of LIMITS."""
    return {name: fit_fragility(results, "pgv", limit, resampled=RESAMPLED) for name, limit in LIMITS.items()}


def compute(data: Path | None) -> Outcome:
    """Compute both variants."""
    lines: list[str] = []
    numbers: dict[str, dict[str, Any]] = {}
    made: dict[str, tuple[Results, dict[str, Fragility]]] = {}
    for name, study in variants(SAMPLES).items():
        results = run_study(study)
        found = fragilities(results)
        made[name] = results, found
        numbers[name] = {limit: [fit.median, *fit.median_bounds, fit.deviation] for limit, fit in found.items()}
        lines.append(f"{name}: {len(results)} runs, {np.mean(results.overturned):.3f} overturned")
        for limit, (median, low, high, deviation) in numbers[name].items():
            lines.append(f"  {limit:10s} PGV {median:.2f} m/s ({low:.2f} to {high:.2f}), deviation {deviation:.2f}")
        if "residual_slip" in results:
            slip = np.nanmax(np.abs(results["residual_slip"][~results.overturned]), axis=1) / DIAMETER
            left = [float(np.nanquantile(slip, q)) for q in (0.5, 0.84, 0.99)]
            numbers[name]["residual"] = left
            lines.append(
                "  largest slip of a drum that remains, over D, of columns that stand (50, 84, 99 %): "
                + ", ".join(f"{value:.4f}" for value in left)
            )
    return Outcome(lines, numbers, draw(made))


def draw(made: dict[str, tuple[Results, dict[str, Fragility]]]) -> Figure:
    """Draw fragilities over PGV; share beyond 0.35 D over magnitude at the nearest distance."""
    figure, axes = panels(2)
    left, right = axes[0]
    grid = np.geomspace(0.1, 3.0, 100)
    for (name, (results, found)), colour in zip(made.items(), (BLUE, RED), strict=True):
        for (limit, fit), line in zip(found.items(), (":", "--", "-"), strict=True):
            left.plot(grid, fit.probability(grid), line, color=colour, linewidth=1.1, label=f"{name}: {limit}")
        magnitude, near = results["motion.magnitude"], results["motion.distance"] <= 5.0
        failed = failed_of(results, LIMITS["0.35 D"])
        levels = np.unique(magnitude)
        share = [np.mean(failed[near & (magnitude == level)]) for level in levels]
        right.plot(levels, share, "o-", color=colour, markersize=4, label=name)
    left.set_xscale("log")
    left.legend(fontsize=6)
    right.legend(fontsize=8)
    label(left, "PGV, m/s", "probability", "fragility")
    label(right, "magnitude", "share beyond 0.35 D", "5 km from the fault, with the noise")
    return figure


CASE = Case(
    name="study",
    title="the reference study again, and with round drums that slide",
    source="docs/reference-study.md, after Psycharis, Fragiadakis and Stefanou (2013)",
    model="13 blocks after the Pronaos of the Parthenon; motions drawn by magnitude and distance",
    fitted="nothing; lognormal curves are fitted to the runs",
    predicted="fragility over PGV, shares by magnitude, offsets that remain",
    compute=compute,
)
