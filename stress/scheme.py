"""The paper's scheme, central differences with Gauss-Seidel sweeps: its stability limit and the cost of its sweeps."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from solver import Block, Column, InputError, Joint, Motion, Settings, SolverError
from solver.kernels.layout import spaces as at
from solver.models.column.packing import settlements
from solver.models.column.stepper import Stepper
from solver.models.paper.kind import longest_stable_step

ROOT = Path(__file__).resolve().parent.parent
HEIGHT, WIDTH, MASS = 14.07, 1.56, 81000.0  # of the Column of Phocas
STIFFNESS = 533 * 9.80665e6  # N/m3
STEPS = 200
GROWN = 1e3  # times the first disturbance: growth that counts as divergence
FINER = 0.005  # of the step: accuracy of the limit found
LONGEST = 1.5  # times the computed limit: range of the search
TOLERANCES = (math.inf, 1e-2, 1e-4, 1e-6, 1e-9)  # of the sweeps; the first one stops after one sweep
SCENES = ((0.02, 2.0, 2.0), (0.05, 2.0, 2.0))  # g, Hz, s: short enough to predict the motion of the undamped column


def shaft(n: int, stiffness: float, damping: float, step: float = 1e-4) -> Column:
    """Return the shaft of Phocas in n equal drums, set up as in the paper."""
    block = Block(HEIGHT / n, WIDTH, WIDTH, MASS / n, Joint(stiffness, damping))
    return Column("shaft", (block,) * n, Settings("paper", step=step))


def grows(column: Column, step: float) -> tuple[bool, float]:
    """Return True if a small disturbance of rest grows in STEPS steps, and the sweeps made per evaluation."""
    stepper = Stepper(column)
    stepper.model.settings.step = step  # past the check of the step, which is what this function tests
    n = column.n
    rng = np.random.default_rng(n)
    coordinates = stepper.arrays.state[at.CONTROL.beside :][: 2 * n]
    rest = coordinates.copy()
    size = 1e-7 * float(np.min(settlements(column)))
    coordinates += size * rng.uniform(-1.0, 1.0, 2 * n)
    try:
        stepper.advance(0.0, STEPS * step)
    except SolverError:
        return True, math.nan
    away = np.max(np.abs(coordinates - rest))
    return bool(away > GROWN * size), float(stepper.counts.sweeps / stepper.counts.evaluations)


def limit_found(column: Column, limit: float) -> float:
    """Return the step at which the scheme begins to diverge, in parts of `limit`; inf if that is beyond LONGEST."""
    low, high = 0.5, LONGEST
    if grows(column, low * limit)[0]:
        return 0.0
    if not grows(column, high * limit)[0]:
        return math.inf
    while high - low > FINER:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(column, middle * limit)[0] else (middle, high)
    return high


def refused_beyond(column: Column, limit: float) -> bool:
    """Return True if a step just within the limit is accepted, and one just beyond refused with the limit in the
    message.
    """
    Stepper(column.with_settings(step=0.999 * limit))
    try:
        Stepper(column.with_settings(step=1.001 * limit))
    except InputError as error:
        return f"{limit:.4g} s" in str(error)
    return False


def stability_map(
    blocks: tuple[int, ...], stiffnesses: tuple[float, ...], dampings: tuple[float, ...]
) -> list[dict[str, Any]]:
    """Limit computed and found for every combination."""
    rows = []
    for damping in dampings:
        for stiffness in stiffnesses:
            for n in blocks:
                column = shaft(n, stiffness, damping, 1e-9)
                row: dict[str, Any] = {"n": n, "stiffness": stiffness, "damping": damping}
                try:
                    limit = longest_stable_step(column)
                    _, sweeps = grows(column, 0.5 * limit)
                    row |= {"limit": limit, "found": limit_found(column, limit), "sweeps": sweeps}
                    row["refused"] = refused_beyond(column, limit)
                except InputError:  # shorter than any step allowed
                    row["failure"] = f"{limit:.2g}; refused"
                except SolverError as error:
                    row["failure"] = str(error)
                rows.append(row)
    return rows


def sweep_costs() -> list[dict[str, Any]]:
    """Return the error of the top displacement against the tolerance of the sweeps.

    That tolerance is a constant of the kernels: each one is compiled in a copy of the solver.
    """
    exact, *others = (_swept(tolerance) for tolerance in (None, *TOLERANCES))
    rows = []
    for k, (amplitude, frequency, duration) in enumerate(SCENES):
        reference = np.array(exact[k]["ux"])
        for tolerance, scenes in zip((exact[k]["tolerance"], *TOLERANCES), (exact, *others), strict=True):
            error = float(np.max(np.abs(np.array(scenes[k]["ux"]) - reference)) / np.max(np.abs(reference)))
            rows.append({"amplitude": amplitude, "frequency": frequency, "duration": duration, "tolerance": tolerance,
                         "sweeps": scenes[k]["sweeps"], "error": error})  # fmt: skip
    return rows


def _swept(tolerance: float | None) -> list[dict[str, Any]]:
    """Return the result of `sweep` in a process of its own."""
    with tempfile.TemporaryDirectory(prefix="stress_") as folder:
        for name in ("solver", "stress"):
            shutil.copytree(ROOT / name, Path(folder) / name, ignore=shutil.ignore_patterns("__pycache__"))
        equations = Path(folder) / "solver" / "kernels" / "paper" / "equations.py"
        text = equations.read_text(encoding="utf-8")
        own = re.search(r"^SWEEP_TOLERANCE = (\S+)", text, re.MULTILINE)
        assert own is not None
        if tolerance is not None:
            equations.write_text(text.replace(own[0], f"SWEEP_TOLERANCE = {tolerance!r}"), encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-m", "stress.in_process", "sweep"],
            cwd=folder,
            env=os.environ | {"MULTIBLOCK_CACHE_DIR": str(Path(folder) / "cache")},
            capture_output=True,
            text=True,
            check=True,
        )
    scenes: list[dict[str, Any]] = json.loads(done.stdout)
    return scenes


def sweep() -> list[dict[str, Any]]:
    """Return top displacement and sweeps an evaluation of every scene, with the tolerance that the kernels have."""
    from solver.kernels.paper import equations as paper

    found = []
    for amplitude, frequency, duration in SCENES:
        stepper = Stepper(shaft(3, STIFFNESS, 0.0))
        motion = Motion.harmonic(amplitude * 9.80665, frequency, duration)
        phases = at.phases_in(stepper.run(motion, duration, np.linspace(0.0, duration, 401)))
        ux = phases[:, 0].tolist()  # the first coordinate of this formulation is that of the top
        sweeps = int(stepper.counts.sweeps) / int(stepper.counts.evaluations)
        found.append({"ux": ux, "sweeps": sweeps, "tolerance": paper.SWEEP_TOLERANCE})
    return found


def run(short: bool = False) -> dict[str, Any]:
    """Return the map and the cost of the sweeps."""
    if short:
        return {"map": stability_map((1, 3), (1e8, 1e10), (0.0, 1e-3))}
    stiffnesses = tuple(10.0**k for k in range(6, 15, 2))
    return {"map": stability_map((1, 2, 3, 5, 10, 20, 50, 100, 200), stiffnesses, (0.0, 1e-3)), "sweeps": sweep_costs()}
