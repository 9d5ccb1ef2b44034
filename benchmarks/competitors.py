"""The integrators that are compared: the solver's own, and general ones that integrate the same compiled equations.

A competitor turns a scene and the value of its accuracy knob into the displacements on a grid of times. The time
measured is that of the integration with its output on that grid, compiled beforehand; the conversion of unknowns into
displacements afterwards is not counted. `simulate` is timed from call to return, with its resultants, peaks and checks.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver import simulate

from . import timing
from .right_hand_side import Array, Problem, address
from .scenes import Scene

# kinds of competitors
OWN = "own"
COMPILED = "compiled"  # general, with the compiled equations and nothing interpreted in between
CONTEXT = "context"  # general, written in Python or called from there

# `auto` without the peaks of anything but ux, which no other competitor gives: a row of tables, not of pictures
UX_ONLY = "auto, peaks of ux only"

MOST_STEPS = 10_000_000  # between two outputs; so large that the count stops no competitor
OUTPUT_STEP = 0.005  # s


class MeasurementError(Exception):
    """A competitor did not reach the end, or a scene has no window."""


@dataclass(frozen=True)
class Result:
    """The result of a competitor in a scene."""

    ux: Array  # m (nt, n)
    evaluations: int  # of the accelerations
    seconds: float  # the shortest run
    runs: int


# (scene, output times s, value of the knob, seconds to spend on repeats)
Solve = Callable[[Scene, Array, float, float], Result]
# (problem, tolerance) -> function to be timed: () -> scaled unknowns (nt, 4n)
Prepare = Callable[[Problem, float], Callable[[], Array]]


@dataclass(frozen=True)
class Competitor:
    """An integrator with the values of its accuracy knob from loose to tight."""

    name: str
    kind: str
    knob: str
    values: tuple[float, ...]
    solve: Solve


def grid(duration: float) -> Array:
    """Return the output times of a scene, s."""
    times: Array = OUTPUT_STEP * np.arange(math.floor(duration / OUTPUT_STEP + 1e-9) + 1, dtype=np.float64)
    return times


# --- the solver's own


def own(**options: Any) -> Solve:
    """Return `simulate` at a tolerance, with other options of it."""

    def solve(scene: Scene, times: Array, value: float, budget: float) -> Result:
        given: dict[str, Any] = {
            "output_step": OUTPUT_STEP,
            "settle": 0.0,
            "tolerance": value,
            **options,
        }
        response, seconds, runs = timing.fastest(
            lambda: simulate(scene.column, scene.motion, float(times[-1]), **given), budget
        )
        return Result(response.ux, response.stats["evaluations"], seconds, runs)

    return solve


# --- general integrators


def general(prepare: Prepare) -> Solve:
    """Return a competitor from its way of preparing a problem."""

    def solve(scene: Scene, times: Array, value: float, budget: float) -> Result:
        problem = Problem(scene, times)
        integrate = prepare(problem, value)

        def counted() -> Array:
            problem.reset()
            return integrate()

        states, seconds, runs = timing.fastest(counted, budget)
        return Result(problem.ux(states), problem.calls, seconds, runs)

    return solve


def numbalsoda(name: str) -> Prepare:
    """Return integrators of the package numbalsoda, Fortran and C++, called with the address of the right-hand side."""
    import numbalsoda as package

    integrator = getattr(package, name)

    def prepare(problem: Problem, tolerance: float) -> Callable[[], Array]:
        def integrate() -> Array:
            states, success = integrator(
                address(), problem.start, problem.times, problem.data, rtol=tolerance, atol=tolerance, mxstep=MOST_STEPS
            )
            if not success:
                raise MeasurementError("reports no success")
            return np.asarray(states)

        return integrate

    return prepare


def sundials(method: str) -> Prepare:
    """Return CVODE of SUNDIALS with one of its methods."""
    from .cvode import Cvode

    cvode = Cvode(method)

    def prepare(problem: Problem, tolerance: float) -> Callable[[], Array]:
        run = cvode.prepare(problem, tolerance, MOST_STEPS)

        def integrate() -> Array:
            states, code = run()
            if code < 0:
                raise MeasurementError(f"CVODE returns {code}")
            return states

        return integrate

    return prepare


def scipy(method: str) -> Prepare:
    """Return integrators of scipy, which call the right-hand side from Python."""
    from scipy.integrate import solve_ivp

    def prepare(problem: Problem, tolerance: float) -> Callable[[], Array]:
        def integrate() -> Array:
            span = (problem.times[0], problem.times[-1])
            solution = solve_ivp(
                problem.rates, span, problem.start, method, problem.times, rtol=tolerance, atol=tolerance
            )
            if not solution.success:
                raise MeasurementError(str(solution.message))
            return np.asarray(solution.y.T)

        return integrate

    return prepare


# --- all competitors


def tolerances(loosest: int, tightest: int, per_decade: int = 2) -> tuple[float, ...]:
    """Return tolerances from 10^loosest down to 10^tightest."""
    return tuple(10.0 ** (k / per_decade) for k in range(per_decade * loosest, per_decade * tightest - 1, -1))


def competitors(quick: bool = False) -> tuple[list[Competitor], dict[str, str]]:
    """Return all competitors, and those not available here with the reason; a quick run leaves out the context."""
    every = tolerances(-2, -12)
    some = tolerances(-3, -7, per_decade=1)
    wanted: list[tuple[str, str, str, tuple[float, ...], Callable[[], Solve]]] = [
        ("auto", OWN, "tolerance", tolerances(-1, -10), lambda: own()),
        (UX_ONLY, OWN, "tolerance", tolerances(-1, -10), lambda: own(without=("peaks",))),
        ("DOP853 (numbalsoda)", COMPILED, "tolerance", every, lambda: general(numbalsoda("dop853"))),
        ("LSODA (numbalsoda)", COMPILED, "tolerance", every, lambda: general(numbalsoda("lsoda"))),
        ("CVODE BDF (SUNDIALS)", COMPILED, "tolerance", every, lambda: general(sundials("BDF"))),
        ("CVODE Adams (SUNDIALS)", COMPILED, "tolerance", every, lambda: general(sundials("Adams"))),
        ("DOP853 (scipy)", CONTEXT, "tolerance", some, lambda: general(scipy("DOP853"))),
        ("LSODA (scipy)", CONTEXT, "tolerance", some, lambda: general(scipy("LSODA"))),
        ("Radau (scipy)", CONTEXT, "tolerance", some, lambda: general(scipy("Radau"))),
    ]
    found: list[Competitor] = []
    absent: dict[str, str] = {}
    for name, kind, knob, values, make in wanted:
        if quick and kind == CONTEXT:
            continue
        try:
            found.append(Competitor(name, kind, knob, values, make()))
        except (ImportError, OSError, RuntimeError) as error:
            absent[name] = f"not available: {error}"
    return found, absent
