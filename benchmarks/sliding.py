"""Work-precision of scenes with joints that slide, against friction that is regularized less and less.

The reference has another formulation, another integrator and no decisions (regularized.py). Its error is proportional
to the width over which friction rises, so that two widths give the limit. The difference of the reference and the
solver's `auto` at its tightest is printed too; smaller errors mean nothing. Cost is counted in evaluations.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from solver import Block, Column, Joint, Motion, SolverError, simulate

from .competitors import grid, tolerances
from .regularized import Array, solve
from .scenes import DAMPING, HEIGHT, MASS, SIDE, STIFFNESS, G, Scene

OWN_TOLERANCE = 1e-11
WIDTHS = (1e-8, 1e-9)  # m/s, over which friction rises: the limit is extrapolated from them
TOLERANCE = 1e-12  # of the reference's integrator
PER_WIDTH = 1e-2  # s/m, tolerance over width where the regularized friction is a competitor itself
AUTO, OTHER = "auto", "regularized friction, LSODA (scipy)"
TABLE = tolerances(-2, -8, per_decade=1)


def two_blocks(damping: float) -> Column:
    """Return two blocks that rock and slide."""
    top = Block(1.2, 0.8, 0.8, 1800.0, Joint(4e8, damping, friction=0.25))
    low = Block(1.5, 1.0, 1.0, 3500.0, Joint(6e8, damping, friction=0.3))
    return Column("two", (top, low))


@cache
def scenes() -> tuple[Scene, ...]:
    """Return blocks that only slide, blocks that rock and slide, damped or not, and slender blocks that do both."""
    flat = Column("flat", (Block(0.5, 2.0, 1.0, 2000.0, Joint(5e8, DAMPING, friction=0.3)),))
    joint = Joint(STIFFNESS, DAMPING, friction=0.1)
    # the lower blocks reach out, so that no rim cuts a contact off
    widening = tuple(Block(HEIGHT / 3.0, SIDE + 0.14 * k, SIDE, MASS / 3.0, joint) for k in range(3))
    rocking = Motion.harmonic(4.5, 2.0, 1.0)
    return (
        Scene("flat", "a flat block, friction 0.3, 0.5 g 1 Hz", flat, Motion.harmonic(0.5 * G, 1.0, 3.0), 3.0),
        Scene("two", "two blocks, 0.46 g 2 Hz", two_blocks(DAMPING), rocking, 1.0),
        Scene("two-undamped", "two blocks, undamped, 0.46 g 2 Hz", two_blocks(0.0), rocking, 1.0),
        Scene("slender", "three slender blocks, friction 0.1, 0.15 g 2 Hz", Column("slender", widening),
              Motion.harmonic(0.15 * G, 2.0, 1.0), 1.0),
    )  # fmt: skip


def limit(scene: Scene, times: Array) -> tuple[Array, Array]:
    """Return the displacements of the tops and slips, m, as the width of the friction goes to zero."""
    wide, narrow = (solve(scene, times, width, TOLERANCE) for width in WIDTHS)
    part = WIDTHS[1] / (WIDTHS[0] - WIDTHS[1])
    return narrow.ux + part * (narrow.ux - wide.ux), narrow.slip + part * (narrow.slip - wide.slip)


def error(found: tuple[Array, Array], wanted: tuple[Array, Array]) -> float:
    """Return the larger of the largest errors of displacements and slips, each relative to its peak."""
    pairs = zip(found, wanted, strict=True)
    return float(max(np.max(np.abs(one - other)) / np.max(np.abs(other)) for one, other in pairs))


def measure(scene: Scene, widths: tuple[float, ...], wanted: tuple[float, ...]) -> dict[str, Any]:
    """Run the scene at all tolerances and widths: error and evaluations of each."""
    times = grid(scene.duration)

    def own(tolerance: float) -> Any:
        return simulate(scene.column, scene.motion, scene.duration, tolerance=tolerance, settle=0.0)

    reference, closest = limit(scene, times), own(OWN_TOLERANCE)
    points: dict[str, list[dict[str, Any]]] = {AUTO: [], OTHER: []}
    for tolerance in wanted:
        try:
            response = own(tolerance)
        except SolverError as failure:
            points[AUTO].append({"value": tolerance, "failure": str(failure)})
            continue
        off = error((response.ux, response.slip), reference)
        points[AUTO].append({"value": tolerance, "error": off, "evaluations": response.stats["evaluations"]})
    for width in widths:
        run = solve(scene, times, width, max(TOLERANCE, PER_WIDTH * width))
        off = error((run.ux, run.slip), reference)
        points[OTHER].append({"value": width, "error": off, "evaluations": run.evaluations})
    return {
        "title": scene.title,
        "window": scene.duration,
        "peak_slip": float(np.max(np.abs(closest.slip))),
        "events": closest.stats["events"],
        "disagreement": error((closest.ux, closest.slip), reference),
        "regimes": {key: closest.stats[key] for key in ("full_contact", "rocking", "flight")},
        "points": points,
    }


def measured(quick: bool) -> Iterator[dict[str, Any]]:
    """Measure every scene; a quick run takes the first two and fewer points."""
    some = TABLE[1:4] if quick else tolerances(-1, -10)
    for scene in scenes()[:2] if quick else scenes():
        yield measure(scene, tolerances(-2, -4 if quick else -8, per_decade=1), some)


def of_table(row: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the points of `auto` at whole powers of ten."""
    return [point for point in row["points"][AUTO] if point["value"] in TABLE]


def summary(row: dict[str, Any]) -> str:
    """Return one scene in one line: the errors of `auto` in tolerances."""
    parts = [
        "gave up" if "failure" in point else f"{point['value']:.0e}: {point['error'] / point['value']:.2g}"
        for point in of_table(row)
    ]
    return f"{row['title']}: references differ by {row['disagreement']:.1e}; error in tolerances {', '.join(parts)}"
