"""Two independent references for each scene, and the part of it over which they agree: its predictable window.

One is a general integrator of order 8 at a tolerance near rounding, on the equations as a first-order system; the other
is the solver's own `auto` at its tightest, with its own error control, scales and interpolation. Beyond the window
rounding errors have grown so far that no history is right, and no error is measured there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from solver import simulate
from solver.models.column.stepper import Stepper

from .competitors import OUTPUT_STEP, MeasurementError, Prepare, grid, numbalsoda, scipy
from .right_hand_side import Array, Problem
from .scenes import Scene

TOLERANCE = 1e-13  # of the first reference
OWN_TOLERANCE = 1e-12  # of the second
AGREEMENT = 1e-8  # of the peak so far: within which both must agree
LEAST_WINDOW = 0.25  # s
BEYOND = 0.5  # s that the first reference follows a column beyond the fall that the second found


@dataclass(frozen=True, eq=False)
class Reference:
    """A scene within its predictable window."""

    scene: Scene
    times: Array  # s, of the window
    ux: Array  # m (nt, n), of the first reference
    names: tuple[str, str]
    disagreement: float  # of the two, largest over the window, part of the peak
    whole_disagreement: float  # over the whole duration, or until the column falls
    overturn_times: tuple[float, float]  # s, of the two; NaN if the column stands for the whole duration
    regimes: dict[str, float]  # parts of the window: full_contact, rocking, flight

    @property
    def window(self) -> float:
        """S."""
        return float(self.times[-1])

    @property
    def peak(self) -> float:
        """M."""
        return float(np.max(np.abs(self.ux)))

    @property
    def overturns(self) -> bool:
        """The verdict on the whole duration. Raises MeasurementError where the two references differ in it."""
        verdicts = {not math.isnan(time) for time in self.overturn_times}
        if len(verdicts) > 1:
            raise MeasurementError("the references do not agree in the verdict")
        return verdicts.pop()

    def error(self, ux: Array) -> float:
        """Return the largest deviation over the window and all blocks, part of the peak.

        Raises MeasurementError without one.
        """
        if ux.shape != self.ux.shape:
            raise MeasurementError("stops before the end")
        deviation = float(np.max(np.abs(ux - self.ux))) / self.peak
        if not math.isfinite(deviation):
            raise MeasurementError("is not finite")
        return deviation


def order_8() -> tuple[str, Prepare]:
    """Run the integrator of the first reference, compiled where available."""
    try:
        return "DOP853 (numbalsoda)", numbalsoda("dop853")
    except (ImportError, OSError):
        return "DOP853 (scipy)", scipy("DOP853")


def window(first: Array, second: Array) -> int:
    """Return the number of leading rows over which the histories agree to AGREEMENT of the peak so far."""
    deviation = np.maximum.accumulate(np.max(np.abs(first - second), axis=1))
    peak = np.maximum.accumulate(np.max(np.abs(first), axis=1))
    good = np.flatnonzero(deviation <= AGREEMENT * peak)
    return int(good[-1]) + 1 if good.size else 0


def overturn_time(scene: Scene, problem: Problem, states: Array) -> float:
    """Return the first output time at which a block or its joint has turned beyond its angle of no return, s; NaN if
    none.
    """
    limit = Stepper(scene.column).model.blocks.fall_angle
    turn = states[:, : problem.n] * problem.sizes[: problem.n]
    relative = turn - np.hstack([turn[:, 1:], np.zeros((len(turn), 1))])
    fallen = np.any((np.abs(turn) > limit) | (np.abs(relative) > limit), axis=1)
    return float(problem.times[np.argmax(fallen)]) if np.any(fallen) else math.nan


@cache
def reference(scene: Scene) -> Reference:
    """Return both references of a scene. Raises MeasurementError where no window is left."""
    own = simulate(
        scene.column,
        scene.motion,
        scene.duration,
        "exact",
        "auto",
        tolerance=OWN_TOLERANCE,
        output_step=OUTPUT_STEP,
        settle=0.0,
    )
    times = grid(scene.duration)
    if own.overturned:  # the solver holds the state of a column that has fallen, others do not
        times = times[times < own.overturn_time + BEYOND]
    name, prepare = order_8()
    problem = Problem(scene, times)
    states = prepare(problem, TOLERANCE)()
    fallen = overturn_time(scene, problem, states)
    standing = times < min(value for value in (own.overturn_time, fallen, math.inf) if not math.isnan(value))
    first, second = problem.ux(states)[standing], own.ux[: len(times)][standing]
    count = window(first, second)
    if times[max(count, 1) - 1] < LEAST_WINDOW:
        raise MeasurementError("the references do not agree even at the beginning")
    deviation = np.max(np.abs(first - second), axis=1)
    inside = simulate(scene.column, scene.motion, float(times[count - 1]), "exact", "auto", tolerance=1e-8, settle=0.0)
    return Reference(
        scene=scene,
        times=times[:count],
        ux=first[:count],
        names=(f"{name} at {TOLERANCE:g}", f"auto at {OWN_TOLERANCE:g}"),
        disagreement=float(np.max(deviation[:count]) / np.max(np.abs(first[:count]))),
        whole_disagreement=float(np.max(deviation) / np.max(np.abs(first))),
        overturn_times=(fallen, own.overturn_time),
        regimes={key: inside.stats[key] for key in ("full_contact", "rocking", "flight")},
    )
