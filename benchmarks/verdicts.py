"""Verdicts at every tolerance against the verdict of both references."""

from __future__ import annotations

from typing import Any

from solver import SolverError, simulate

from .competitors import MeasurementError, tolerances
from .references import reference
from .scenes import Scene

TOLERANCES = tolerances(-3, -8, per_decade=1)


def measure(scene: Scene) -> dict[str, Any]:
    """Measure the references' times of overturning, s, and those at every tolerance; NaN for standing."""
    try:
        known = reference(scene)
        expected = known.overturns
    except MeasurementError as failure:
        return {"scene": scene.title, "failure": str(failure)}
    times: dict[str, float | str] = {}
    wrong = []
    for tolerance in TOLERANCES:
        key = f"{tolerance:.0e}"
        try:
            response = simulate(
                scene.column, scene.motion, scene.duration, integrator="auto", tolerance=tolerance, settle=0.0
            )
        except SolverError as error:
            times[key] = str(error)
            wrong.append(key)
            continue
        times[key] = response.overturn_time
        if response.overturned != expected:
            wrong.append(key)
    return {
        "scene": scene.title,
        "duration": scene.duration,
        "overturns": expected,
        "reference_times": known.overturn_times,
        "times": times,
        "wrong": wrong,
    }
