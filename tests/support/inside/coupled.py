"""Partners of the coupling example, alone and under the column. The modules of the example must be in reach."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np


def _cases(folder: str) -> dict[str, Path]:
    return {name: Path(folder) / f"{name}.fmu" for name in ("column", "isolator", "soil")}


def _seen(case: Any, ways: list[tuple[float, str]]) -> list[list[float]]:
    """Return for each way (communication step, kind) two errors, the work given and taken."""
    found = []
    for h, way in ways:
        run = case.couple(h, way)
        found.append([*case.errors(run), run["work_given"], run["work_taken"]])
    return found


def on_linear_isolators(folder: str, eta: float, mass: float, ways: list[tuple[float, str]]) -> list[Any]:
    """Return the predictable window, agreement of the references, and what is seen in each way, at a slab of mass *
    Meff.
    """
    from accuracy import Case, harmonic, linear

    case = Case(_cases(folder), eta, "linear", linear(mass), harmonic("0.2 g 2 Hz", 0.8))
    return [case.window, case.agreement, _seen(case, ways)]


def on_every_partner(folder: str, ways: list[tuple[float, str]]) -> dict[str, list[list[float]]]:
    """Return the outputs of each partner of the example."""
    from accuracy import PARTNERS, Case, harmonic

    fmus = _cases(folder)
    motion = harmonic("0.1 g 1 Hz", 0.8)
    return {name: _seen(Case(fmus, 1e-3, *partner, motion), ways) for name, partner in PARTNERS.items()}


def slab(fmu: str) -> list[float]:
    """Return the displacement of a slab alone at every millisecond until 4 s, under sin 5 t."""
    from master import Fmu

    part = Fmu(fmu, mass=1e4, stiffness=1e4 * 40.0, damping=1e4 * 1.0)
    h, x = 1e-3, []
    for k in range(4000):
        now, then = (float(np.sin(5.0 * j * h)) for j in (k, k + 1))
        part.set(**{"ground.ax": now, "ground.jx": (then - now) / h})
        part.step(k * h, h)
        x += part.get("x")
    return x


def foundation(fmu: str) -> list[list[float]]:
    """Rest of a foundation alone under 1e6 N, N and N m in turn."""
    from master import Fmu

    ends = []
    for port in ("R0x", "R0z", "R0m"):
        part = Fmu(fmu)
        part.set(**{f"column.{port}": 1e6})
        for k in range(2000):
            part.step(k * 1e-3, 1e-3)
        ends.append(part.get("x", "uz", "base.theta"))
        part.close()
    return ends


def kept_state(fmu: str) -> dict[str, Any]:
    """Return True if a partner goes on from its state, and what it says to a step back and to no number."""
    from master import Fmu

    part = Fmu(fmu)

    def drive(first: int, last: int) -> list[float]:
        for k in range(first, last):
            part.set(**{"ground.ax": math.sin(0.1 * k), "column.R0x": 1e4 * math.cos(0.2 * k)})
            part.step(k * 1e-3, 1e-3)
        return list(part.get("x", "v", "base.ax", "base.jx", "work"))

    drive(0, 50)
    saved = part.slave.serializeFMUstate(part.slave.getFMUState())
    first = drive(50, 100)
    part.slave.setFMUState(part.slave.deSerializeFMUstate(saved))
    found: dict[str, Any] = {"same": drive(50, 100) == first, "moved": first[0] != 0.0}
    for name, ax, h in (("backwards", 0.0, -1e-3), ("no number", math.nan, 1e-3)):
        part.set(**{"ground.ax": ax})
        try:
            part.step(0.1, h)
        except Exception as error:
            found[name] = str(error)
    part.close()
    return found


def same(first: str, second: str, partner: str, parameters: dict[str, Any]) -> tuple[bool, float]:
    """Return True if the partner of one folder moves bit for bit as that of another under one column; and how far."""
    from master import Fmu, couple

    def ground(t: float) -> float:
        return float(np.sin(2.0 * np.pi * t))

    found = []
    for folder in (first, second):
        partner_fmu = Fmu(f"{folder}/{partner}.fmu", **parameters)
        run = couple(
            Fmu(f"{first}/column.fmu", **{"base.drive": "acceleration"}),
            partner_fmu,
            ground,
            1e-3,
            0.5,
            watch_partner=("x", "v", "base.ax"),
        )
        found.append([run["block[1].ux"].tolist(), run["x"].tolist(), run["base.ax"].tolist(), run["work_given"]])
    return found[0] == found[1], max(map(abs, found[0][1]))


def refused(fmu: str, parameters: dict[str, Any]) -> str:
    """Return the error of FMPy when a partner is set up with these values."""
    from master import Fmu

    try:
        Fmu(fmu, **parameters)
    except Exception as error:
        return str(error)
    return ""


def ground(fmu: str, step: float, given: float, count: int) -> list[list[float]]:
    """Return the acceleration and slope of the ground at every step; `given` is its parameter `step`."""
    from master import Fmu

    part = Fmu(fmu, step=given)
    rows = []
    for k in range(count):
        rows.append(part.get("ground.ax", "ground.jx"))
        part.step(k * step, step)
    part.close()
    return rows
