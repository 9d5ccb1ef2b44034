"""A structure in space on a slab with isolators in two directions: error against the communication step.

    python examples/coupling/in_space.py

The reaction of a structure follows from its state alone, so that the slab's acceleration is (isolators + reaction) /
mass, without effective mass or loop. Isolators: linear, or a friction pendulum for any direction, whose friction is the
radial return of an elastic slip. The structure and the slab follow a + slope (t - t0) in each step.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np

from fmu_src import rules
from fmu_src.alternation import Alternation
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.model import Structure

TRILITH = Path(__file__).resolve().parent.parent / "structures" / "trilith.toml"
DURATION = 3.0  # s
LINEAR = {"stiffness": 5e5, "damping": 4e4, "friction": 0.0}  # N/m, N s/m
PENDULUM = {"stiffness": 2.2e5, "damping": 0.0, "friction": 0.05}  # weight over the radius of 2 m
YIELD = 1e-3  # m, elastic slip of the pendulum
REFERENCE = 0.0625e-3  # s, step of the run that others are held against


def ground(t: float) -> np.ndarray:
    """Acceleration of the ground in x and y, m/s2."""
    grows = min(1.0, t)
    return grows * np.array([3.0 * math.sin(9.0 * t), 1.5 * math.sin(7.0 * t)])


def couple(
    structure: Structure, model: np.ndarray, mass: float, isolator: dict[str, float], h: float, order: int
) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of the slab, and of the last block relative to it, every 0.02 s, m (rows, 2).

    mass: of the slab, kg. order: 1: held, 2: the line from the step before, 3: the parabola through two before. Raises
    SolverError where it diverges, and warns as the FMUs do.
    """
    body = DrivenStructure(structure, model, Chosen(1e-8))
    weight, n = structure.weight + mass * structure.g, structure.n
    places = slice(-6, -4)  # of the reaction in a row
    x, v, z = np.zeros(2), np.zeros(2), np.zeros(2)
    before: list[np.ndarray] = []
    watch, stable = Alternation(2), True
    slab, top = [], []
    every = round(0.02 / h)
    for k in range(round(DURATION / h)):
        t = k * h
        row = body.observe(t)
        if k % every == 0:
            slab.append(x.copy())
            top.append(np.array([row[n - 1], row[2 * n - 1]]))
        pull = -isolator["stiffness"] * x - isolator["damping"] * v - isolator["friction"] * weight * z
        a = (pull + row[places]) / mass
        slope = np.zeros(2)
        if order == 2 and before:
            slope = (a - before[-1]) / h
        elif order == 3 and len(before) > 1:  # the mean of the parabola's over the step, for its area
            slope = (11.0 * a - 16.0 * before[-1] + 5.0 * before[-2]) / (6.0 * h)
        before = [*before[-1:], a]
        if stable and (axis := watch.found(t, a.tolist())) >= 0:
            stable = False
            warnings.warn(rules.UNSTABLE % (f"base.a{'xy'[axis]}", a[axis], "m/s2", t), RuntimeWarning, stacklevel=2)
        middle = ground(t + 0.5 * h)
        moved = h * v + h * h * (0.5 * (a - middle) + h * slope / 6.0)
        x, v = x + moved, v + h * (a - middle + 0.5 * h * slope)
        z = z + moved / YIELD
        z /= max(1.0, float(np.hypot(*z)))
        body.drive(t, a[0], a[1], 0.0, slope[0], slope[1], 0.0)
        body.advance(t, h)
    return np.array(slab), np.array(top)


def main() -> None:
    """Print the table of docs/notes/coupling.md."""
    structure = Structure.from_toml(TRILITH)
    model = packed(structure)
    blocks = sum(block.mass for block in structure.blocks)
    print("| slab / structure | isolators | step, ms | held | line | parabola |\n|---|---|---|---|---|---|")
    for share, isolator in ((0.1, LINEAR), (1.0, LINEAR), (10.0, LINEAR), (1.0, PENDULUM)):
        mass = share * blocks
        reference = couple(structure, model, mass, isolator, REFERENCE, 2)
        for h in (4e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3):
            cells = []
            for order in (1, 2, 3):
                try:
                    found = couple(structure, model, mass, isolator, h, order)
                except ValueError:
                    cells.append("diverges")
                    continue
                apart = [np.max(np.abs(a - b)) / np.max(np.abs(b)) for a, b in zip(found, reference, strict=True)]
                cells.append("diverges" if not max(apart) < 1.0 else f"{apart[1]:.1e}, {apart[0]:.1e}")
            kind = "linear" if isolator is LINEAR else "pendulum"
            print(f"| {share:g} | {kind} | {1e3 * h:g} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
