"""A structure in space on a slab with isolators in two directions: error against the communication step.

    python examples/coupling/in_space.py

The structure is given force and mass of the slab, the slab the reaction, once a step: both find the acceleration
(isolators + reaction) / mass, for the reaction follows from the state alone, and follow a + slope (t - t0) in the step.
Isolators: linear, or a friction pendulum for any direction: a spring in series with a slider, the force of which is
exact along a straight path. The path of a step is known, a curve of the third degree; it is taken in chords.
"""

from __future__ import annotations

import math
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from fmu_src import rules
from fmu_src.alternation import Alternation
from solver.kernels.layout.spaces import HORIZONTAL, SLOPE_HELD, SLOPE_LINE, SLOPE_PARABOLA
from solver.kernels.structure.layout import PHASE
from solver.models.outputs import places_of
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.model import Structure
from solver.models.structure.outputs import OUTPUTS
from solver.models.structure.rest import rest_of
from solver.models.structure.stepper import SpatialStepper

TRILITH = Path(__file__).resolve().parent.parent / "structures" / "trilith.toml"
DURATION = 3.0  # s
LINEAR = {"stiffness": 5e5, "damping": 4e4, "friction": 0.0}  # N/m, N s/m
PENDULUM = {"stiffness": 2.2e5, "damping": 0.0, "friction": 0.05}  # weight over the radius of 2 m
YIELD = 1e-3  # m, elastic slip of the pendulum
CHORDS = 4  # of the path of a step
EVERY = 0.02  # s, between rows
TOLERANCE = 1e-8
CLOSE = {"rtol": 1e-9, "atol": 1e-11}


def ground(t: float) -> np.ndarray:
    """Return the acceleration of the ground in x and y, m/s2."""
    grows = min(1.0, t)
    return grows * np.array([3.0 * math.sin(9.0 * t), 1.5 * math.sin(7.0 * t)])


def ground_over(t: float, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return acceleration and slope that move over a step as the parabola through its start, middle and end does."""
    first, middle, last = (ground(t + part * h) for part in (0.0, 0.5, 1.0))
    return (2.0 * first + 2.0 * middle - last) / 3.0, (last - first) / h


def held() -> Structure:
    """Return the trilith with joints that do not slide, so that its phase is all of its state."""
    data = tomllib.loads(TRILITH.read_text(encoding="utf-8"))
    del data["joints"]["friction"]
    return Structure.from_dict(data)


def slide(z: tuple[float, float], x: float, y: float) -> tuple[float, float]:
    """Return the stretch of the spring, in parts of that at which it slides, after a straight path (x, y) in such
    parts.

    It goes with the path up to the circle of radius 1, then along it towards the path: the tangent of half the angle
    between both falls by exp(-path).
    """
    path = math.hypot(x, y)
    if path == 0.0:
        return z
    x, y = x / path, y / path
    along, across = z[0] * x + z[1] * y, z[1] * x - z[0] * y
    free = math.sqrt(max(0.0, 1.0 - across * across)) - along  # as far as the circle
    if path <= free:
        return z[0] + path * x, z[1] + path * y
    along, across = max(0.0, along + max(0.0, free)), max(-1.0, min(1.0, across))
    half = across / (1.0 + along) * math.exp(-(path - max(0.0, free)))
    along, across = (1.0 - half * half) / (1.0 + half * half), 2.0 * half / (1.0 + half * half)
    return along * x - across * y, along * y + across * x


def follow(
    z: tuple[float, float], v: np.ndarray, a: np.ndarray, slope: np.ndarray, h: float, chords: int = CHORDS
) -> tuple[float, float]:
    """Return the stretch after a step of h s on the path v s + a s^2 / 2 + slope s^3 / 6, in chords."""
    s = h / chords * np.arange(chords + 1)[:, None]
    for x, y in (np.diff(s * (v + s * (0.5 * a + s * slope / 6.0)), axis=0) / YIELD).tolist():
        z = slide(z, x, y)
    return z


def pull_of(isolator: dict[str, float], weight: float, x: np.ndarray, v: np.ndarray, z: Any) -> np.ndarray:
    """Return the force of the isolators on the slab at x m, v m/s, N; z: stretch of the slider, weight: what slides
    carries, N.
    """
    pull: np.ndarray = -isolator["stiffness"] * x - isolator["damping"] * v
    return pull - isolator["friction"] * weight * np.asarray(z)


def couple(
    structure: Structure, model: np.ndarray, mass: float, isolator: dict[str, float], h: float, order: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacements of the slab, and of the last block relative to it, every 0.02 s, m (rows, 2).

    mass: of the slab, kg. order: 1: held, 2: the line from the step before, 3: the parabola through two before. Raises
    SolverError where it diverges, and warns as the FMUs do.
    """
    slopes = {1: SLOPE_HELD, 2: SLOPE_LINE, 3: SLOPE_PARABOLA}
    body = DrivenStructure(structure, model, Chosen(TOLERANCE, drive=HORIZONTAL, slope=slopes[order]))
    weight, n = structure.weight + mass * structure.g, structure.n
    places = slice(-6, -4)  # of the reaction in a row
    x, v, z = np.zeros(2), np.zeros(2), (0.0, 0.0)
    before: list[np.ndarray] = []
    watch, stable = Alternation(2), True
    slab, top = [], []
    every = round(EVERY / h)
    for k in range(round(DURATION / h)):
        t = k * h
        row = body.observe(t)
        if k % every == 0:
            slab.append(x.copy())
            top.append(np.array([row[n - 1], row[2 * n - 1]]))
        pull = pull_of(isolator, weight, x, v, z)
        a = (pull + row[places]) / mass
        slope = np.zeros(2)
        if order > 1 and before:
            slope = (a - before[-1]) / h
        if order == 3 and len(before) > 1:  # the line that has the parabola's area over the step
            slope = (11.0 * slope - 5.0 * (before[-1] - before[-2]) / h) / 6.0
        before = [*before[-1:], a]
        if stable and (axis := watch.found(t, a.tolist())) >= 0:
            stable = False
            warnings.warn(rules.UNSTABLE % (f"base.a{'xy'[axis]}", a[axis], "m/s2", t), RuntimeWarning, stacklevel=2)
        below, its_slope = ground_over(t, h)
        apart, bends = a - below, slope - its_slope
        z = follow(z, v, apart, bends, h)
        x, v = x + h * v + h * h * (0.5 * apart + h * bends / 6.0), v + h * (apart + 0.5 * h * bends)
        body.drive(t, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, pull[0], pull[1], 0.0, mass)
        body.advance(t, h)
    return np.array(slab), np.array(top)


def as_one(structure: Structure, mass: float, isolator: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the same as one system of equations, by scipy: phase of the structure, place, velocity and stretch of the
    slab.

    The stretch of what slides keeps its size and turns with the path. Joints must not slide.
    """
    stepper, rest = SpatialStepper(structure), rest_of(structure)
    stepper.phase[:] = rest.phase
    weight, n = structure.weight + mass * structure.g, structure.n
    size = PHASE.size(n)
    reaction = places_of(OUTPUTS, structure.sizes)["base"].start

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        stepper.phase[:size] = y[:size]
        x, v, z = y[size:].reshape(3, 2)
        stepper.observe()
        a = (pull_of(isolator, weight, x, v, z) + stepper.row[reaction : reaction + 2]) / mass
        found = stepper.rates[:size].copy()
        moves = PHASE.see(found, n)
        moves.vx[:] -= a[0]
        moves.vy[:] -= a[1]
        turns = v / YIELD
        if (outward := float(z @ turns)) > 0.0 and z @ z >= 1.0:
            turns = turns - outward * z / (z @ z)
        return np.concatenate([found, v, a - ground(t), turns])

    times = EVERY * np.arange(round(DURATION / EVERY))
    made = solve_ivp(rates, (0.0, DURATION), np.append(rest.phase[:size], np.zeros(6)), "DOP853", times, **CLOSE)
    return made.y[size : size + 2].T, made.y[[n - 1, 2 * n - 1]].T


def errors(found: tuple[np.ndarray, np.ndarray], one: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return the errors of slab and beam, in parts of their peaks."""
    return np.array([np.max(np.abs(a - b)) / np.max(np.abs(b)) for a, b in zip(found, one, strict=True)])


def main() -> None:
    """Print the table of docs/notes/coupling.md."""
    structure = held()
    model = packed(structure)
    blocks = sum(block.mass for block in structure.blocks)
    print("| slab / structure | isolators | step, ms | held | line | parabola |\n|---|---|---|---|---|---|")
    for share, isolator in ((0.1, LINEAR), (1.0, LINEAR), (10.0, LINEAR), (1.0, PENDULUM)):
        mass = share * blocks
        one = as_one(structure, mass, isolator)
        for h in (4e-3, 2e-3, 1e-3, 0.5e-3):
            cells = []
            for order in (1, 2, 3):
                try:
                    slab, top = errors(couple(structure, model, mass, isolator, h, order), one)
                except ValueError:
                    cells.append("diverges")
                    continue
                cells.append(f"{top:.1e}, {slab:.1e}" if max(slab, top) < 1.0 else "diverges")
            kind = "linear" if isolator is LINEAR else "pendulum"
            print(f"| {share:g} | {kind} | {1e3 * h:g} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
