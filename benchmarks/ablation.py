"""Time and error of the solver with and without each of its short cuts."""

from __future__ import annotations

from typing import Any

from solver.models.column.settings import SKIPS

from .competitors import own
from .references import Reference
from .work_precision import WARM_UP, describe

TOLERANCE = 1e-5  # the default of a column

# name: arguments of `simulate` that turn the short cut off
ABLATIONS: dict[str, dict[str, Any]] = {name: {"without": (name,)} for name in SKIPS}
ABLATIONS["all of these"] = {"without": SKIPS}


def measure(reference: Reference, budget: float) -> list[dict[str, Any]]:
    """Measure one row with all short cuts, named `as it is`, and one without each."""
    rows = []
    for name, arguments in {"as it is": {}, **ABLATIONS}.items():
        row: dict[str, Any] = {"scene": reference.scene.title, "without": name}
        try:
            solve = own(**arguments)
            solve(reference.scene, reference.times[:WARM_UP], TOLERANCE, 0.0)  # compiles
            result = solve(reference.scene, reference.times, TOLERANCE, budget)
            row |= {
                "seconds": result.seconds,
                "evaluations": result.evaluations,
                "error": reference.error(result.ux),
            }
        except Exception as failure:  # listed, whatever it is
            row["failure"] = describe(failure)
        rows.append(row)
    return rows
