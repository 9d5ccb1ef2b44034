"""The dependencies of outputs on variables in initialization."""

from __future__ import annotations

from typing import Any

from support.instance import Instance


def followers(*fmus: str) -> dict[str, list[str]]:
    """Return input or parameter -> the outputs that change when it alone is changed in initialization mode.

    fmus: the first one of the exact formulation, others of the paper's.
    """
    found: dict[str, set[str]] = {}
    for fmu in fmus:
        variables = Instance(fmu).variables
        outputs = [name for name, item in variables.items() if item.causality == "output"]
        rotations = {"base.theta": 1e-3, "base.omega": 2e-3, "base.alpha": 0.1}
        paper = fmu != fmus[0]
        start: dict[str, Any] = {"base.ax": 0.4, "base.az": 0.3} | ({} if paper else rotations)
        column = Instance(fmu, start, initialize=False)
        column.fmi.setupExperiment()
        column.fmi.enterInitializationMode()
        before = column.get(*outputs)
        for name, item in variables.items():
            if item.causality == "output" or item.type == "String" or (paper and name in rotations):
                continue
            key = name.rpartition(".")[2]
            general = ("friction", "offset", "inclination", "tilt")
            if key == "dowel" or (key in general and paper):  # not allowed alone, or absent there
                continue
            (value,) = column.get(name)
            given = {"centroid": 2.0, "inertia": 1e5, "offset": 0.01, "inclination": 1e-3, "tilt": 1e-3}.get(key)
            if key == "rim":
                given = 0.1
            if key == "damping":  # more would make the fixed step of the paper unstable
                given = value + 1e-4
            column.set({name: given or (1.01 * value if value else 1.0)})
            found.setdefault(name, set()).update(
                output
                for output, a, b in zip(outputs, before, column.get(*outputs), strict=True)
                if abs(a - b) > 1e-9 * float(variables[output].nominal or 1.0)
            )
            column.set({name: value} | start)
    return {name: sorted(names) for name, names in found.items()}
