"""Error against time for every competitor in every scene, and the fastest at equal error."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from .competitors import COMPILED, CONTEXT, UX_ONLY, Competitor
from .references import Reference
from .scenes import harmonic

EQUAL_ERRORS = (1e-3, 1e-5, 1e-7)  # of the peak
SLOWEST = 5.0  # s; if one value of the knob takes longer, tighter ones are left out
MANY_BLOCKS = 50  # from this number on every other value of the knob is left out
WARM_UP = 11  # output times

Points = list[dict[str, Any]]  # value, error, seconds, evaluations, runs; or value, failure


def envelope(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the (error, cost) that no other point beats in both, from large errors and small costs on."""
    best: list[tuple[float, float]] = []
    for error, cost in sorted((point for point in points if point[0] > 0.0), key=lambda p: (p[1], p[0])):
        if not best or error < best[-1][0]:
            best.append((error, cost))
    return best


def cost_at(points: Iterable[tuple[float, float]], error: float) -> float | None:
    """Return the cost at an error on the lower envelope, linear in the logarithms; None where no point is that
    accurate.

    An error larger than any on the envelope costs what the cheapest point does.
    """
    front = envelope(points)
    if not front or error < front[-1][0]:
        return None
    if error >= front[0][0]:
        return front[0][1]
    k = next(k for k, point in enumerate(front) if point[0] <= error)
    (e0, c0), (e1, c1) = front[k - 1], front[k]
    return c0 * (c1 / c0) ** (math.log(e0 / error) / math.log(e0 / e1))


def sweep(competitor: Competitor, reference: Reference, budget: float) -> Points:
    """Run every value of the knob. Any failure is listed."""
    points: Points = []
    try:  # compiles
        competitor.solve(reference.scene, reference.times[:WARM_UP], competitor.values[-1], 0.0)
    except Exception as failure:
        return [{"value": competitor.values[-1], "failure": describe(failure)}]
    for value in competitor.values[:: 2 if reference.scene.column.n >= MANY_BLOCKS else 1]:
        try:
            result = competitor.solve(reference.scene, reference.times, value, budget)
            error = reference.error(result.ux)
        except Exception as failure:
            points.append({"value": value, "failure": describe(failure)})
            continue
        points.append(
            {
                "value": value,
                "error": error,
                "seconds": result.seconds,
                "evaluations": result.evaluations,
                "runs": result.runs,
            }
        )
        if result.seconds > SLOWEST:
            break
    return points


def again(competitor: Competitor, reference: Reference, points: Points, budget: float) -> None:
    """Time every point once more, later, and keep the shorter time: a disturbance affects consecutive runs."""
    for point in points:
        if "error" in point and point["seconds"] < budget:
            result = competitor.solve(reference.scene, reference.times, point["value"], budget)
            point["seconds"] = min(point["seconds"], result.seconds)
            point["runs"] += result.runs


def describe(failure: Exception) -> str:
    """Return an exception in one line."""
    return f"{type(failure).__name__}: {failure}".splitlines()[0][:200]


def pairs(points: Points, cost: str) -> list[tuple[float, float]]:
    """Return (error, cost) of the points that have them."""
    return [(point["error"], point[cost]) for point in points if "error" in point]


def equal_error(points: dict[str, Points], compiled: Sequence[str]) -> list[dict[str, Any]]:
    """Compare `auto`, with all peaks and with those of ux only, with the best compiled competitor, at EQUAL_ERRORS."""
    rows: list[dict[str, Any]] = []
    for error in EQUAL_ERRORS:
        own, ux_only = (cost_at(pairs(points.get(name, []), "seconds"), error) for name in ("auto", UX_ONLY))
        costs = {name: cost_at(pairs(points[name], "seconds"), error) for name in compiled}
        reached = {name: cost for name, cost in costs.items() if cost is not None}
        best = min(reached, key=lambda name: reached[name], default=None)
        rows.append(
            {
                "error": error,
                "auto_seconds": own,
                "ux_only_seconds": ux_only,
                "auto_evaluations": cost_at(pairs(points["auto"], "evaluations"), error),
                "best": best,
                "best_seconds": reached[best] if best else None,
                "best_evaluations": cost_at(pairs(points[best], "evaluations"), error) if best else None,
                "speed_up": reached[best] / own if best and own else None,
                "ux_only_speed_up": reached[best] / ux_only if best and ux_only else None,
            }
        )
    return rows


def measure(reference: Reference, competitors: Sequence[Competitor], budget: float) -> dict[str, Any]:
    """Make all measurements of a scene; the budget is the time in s to spend on repeats of one point.

    Interpreted competitors, which are slow, take part in the harmonic scenes only.
    """
    taking_part = [c for c in competitors if c.kind != CONTEXT or reference.scene in harmonic()]
    points = {competitor.name: sweep(competitor, reference, 0.5 * budget) for competitor in taking_part}
    for competitor in taking_part:
        again(competitor, reference, points[competitor.name], 0.5 * budget)
    return {
        "points": points,
        "equal_error": equal_error(points, [c.name for c in competitors if c.kind == COMPILED]),
    }
