"""Accuracy and stability of the coupling against the same systems solved as one (reference.py).

    python examples/coupling/accuracy.py [--quick] [--record RECORD.AT2]

Column of Phocas on a slab with isolators, and on soil. Errors are the largest of the history, in parts of its peak;
those of undamped columns within the window in which two references (steps of 1e-5 and 2e-5 s) agree to 1e-5.
"""

from __future__ import annotations

import argparse
import math
import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

os.environ["MULTIBLOCK_COMPILES"] = "1"  # reference.py has kernels of its own: before the solver is imported

from build import build_all
from master import Fmu, Run, couple
from master import by_state as wires
from master import run as lead
from reference import solve_as_one

from multiblock import Column, Motion

G = 9.80665
HERE = Path(__file__).resolve().parent
COLUMN = HERE.parent / "columns" / "phocas-damped.toml"
SPACING = 1e-3  # s, between the samples of the ground motion and of the reference
COLUMNS = (("plain", 0), ("held", 0), ("line", 0), ("line", 1), ("parabola", 0), ("parabola", 1))
AGREE = 1e-5  # of the peak
RATIOS = (0.01, 0.1, 0.5, 1.0, 2.0, 10.0, 100.0)
SCENES = {"0.1 g 1 Hz": (0.1 * G, 1.0), "0.2 g 2 Hz": (0.2 * G, 2.0)}
MEFF = 8211.0  # kg, of the column at rest
TOTAL = 81e3  # kg
PERIOD, DAMPING = 2.0, 0.1  # s, of critical: linear isolators under slab and column


def linear(ratio: float) -> dict[str, float]:
    """Return slab of `ratio` times the effective mass on linear isolators."""
    mass = ratio * MEFF
    stiffness = (mass + TOTAL) * (2.0 * math.pi / PERIOD) ** 2
    return {"mass": mass, "stiffness": stiffness, "damping": 2.0 * DAMPING * math.sqrt(stiffness * (mass + TOTAL))}


# what the column stands on: kind, parameters
PARTNERS: dict[str, tuple[str, dict[str, float]]] = {
    "linear": ("linear", linear(1.0)),
    "lead-rubber": ("lead-rubber", linear(0.2) | {"damping": 0.0, "strength": 4e4, "yield": 8e-3}),
    "friction pendulum": ("friction-pendulum", {"mass": 5e3, "radius": 1.0, "friction": 0.05, "yield": 1e-3}),
    "soil, Vs = 250 m/s": ("soil", {}),
    "soil, Vs = 120 m/s": ("soil", {"shear_velocity": 120.0, "mass": 3e4, "inertia": 4e4}),
}


def column_with(eta: float) -> Column:
    """Return the Column of Phocas, joints damped by eta s."""
    column = Column.from_toml(COLUMN)
    blocks = [replace(block, joint=replace(block.joint, damping=eta)) for block in column.blocks]
    return replace(column, blocks=tuple(blocks))


def harmonic(scene: str, stop: float) -> np.ndarray:
    """Return the samples of a scene every SPACING, m/s2."""
    amplitude, frequency = SCENES[scene]
    return amplitude * np.sin(2.0 * np.pi * frequency * SPACING * np.arange(round(stop / SPACING) + 1))


class Case:
    """A column on a partner under a ground motion: solved as one, then coupled in any way."""

    def __init__(self, fmus: dict[str, Path], eta: float, kind: str, parameters: dict[str, float], samples: np.ndarray):
        self.fmus, self.eta, self.kind, self.parameters = fmus, eta, kind, parameters
        self.samples = samples
        self.stop = SPACING * (len(samples) - 1)
        column = column_with(eta)
        fine, coarse = (
            solve_as_one(column, kind, parameters, SPACING, samples, self.stop, SPACING, h) for h in (1e-5, 2e-5)
        )
        self.truth = fine
        if kind != "soil":
            self.truth["force"] = self._force(fine)
        self.peak = float(np.max(np.abs(fine["top"])))
        apart = np.abs(fine["top"] - coarse["top"]) > AGREE * self.peak
        self.window = int(np.argmax(apart)) if apart.any() else len(apart)  # samples that can be predicted
        self.agreement = float(np.max(np.abs(fine["top"] - coarse["top"])[: self.window])) / self.peak

    def _force(self, truth: dict[str, Any]) -> np.ndarray:
        p = self.parameters
        if self.kind == "friction-pendulum":
            return np.asarray(truth["x"])  # the force follows a weight that changes; the displacement tells as much
        force = p["stiffness"] * truth["x"] + p["damping"] * truth["v"]
        return np.asarray(-force - (p["strength"] * truth["z"] if self.kind == "lead-rubber" else 0.0))

    def ground(self, t: float) -> float:
        """Return ground acceleration, m/s2."""
        past = t / SPACING
        k = min(int(past + 1e-9), len(self.samples) - 2)
        return float(self.samples[k] + (past - k) * (self.samples[k + 1] - self.samples[k]))

    def couple(self, h: float, way: str = "", stop: float | None = None) -> Run:
        """Couple both: way is plain, held, line, parabola or iterated; empty for the partner's own."""
        damping = {f"joint[{i}].damping": self.eta for i in (1, 2, 3)}
        column = Fmu(self.fmus["column"], **{"base.drive": "acceleration"}, **damping)
        own: dict[str, Any] = dict(self.parameters)
        if way:
            own["slope"] = {"plain": "held", "iterated": "given"}.get(way, way)
        if self.kind == "soil":
            partner = Fmu(self.fmus["soil"], weight=-column.get("base.Fz")[0], **own)
            seen: tuple[str, ...] = ("x", "base.theta")
        else:
            partner = Fmu(self.fmus["isolator"], kind=self.kind, **own)
            seen = ("x", "force")
        try:
            return couple(
                column,
                partner,
                self.ground,
                h,
                self.stop if stop is None else stop,
                iterations=3 if way == "iterated" else 0,
                plain=way == "plain",
                watch_partner=seen,
            )
        finally:
            column.close()
            partner.close()

    def by_state(self, h: float, stop: float | None = None) -> Run:
        """Exchange once a step what each side says of its state."""
        damping = {f"joint[{i}].damping": self.eta for i in (1, 2, 3)}
        on_soil = self.kind == "soil"
        column = Fmu(self.fmus["column_on_soil" if on_soil else "column"], **damping)
        own: dict[str, Any] = {"weight": -column.get("base.Fz")[0]} if on_soil else {"kind": self.kind}
        partner = Fmu(self.fmus["soil" if on_soil else "isolator"], **own, **self.parameters)
        seen = ("x", "base.theta" if on_soil else "force")
        watch = [("column", "block[1].ux"), *(("partner", name) for name in seen)]

        def shake(t: float) -> dict[tuple[str, str], float]:
            slope = (self.ground(t + h) - self.ground(t)) / h
            return {("partner", "ground.ax"): self.ground(t), ("partner", "ground.jx"): slope}

        try:
            rows = lead(
                {"column": column, "partner": partner}, wires(column, partner), h, stop or self.stop, watch, shake
            )
        except Exception:  # FMPy's, when an FMU cannot follow what has diverged
            return Run(diverged=0.0)
        finally:
            column.close()
            partner.close()
        return Run(zip(("time", "block[1].ux", *seen), rows.T, strict=True), diverged=None)

    def errors(self, run: Run) -> tuple[float, float]:
        """Return the largest error of the top displacement, and of the isolator force or the foundation's rotation."""
        if run["diverged"] is not None:
            return math.inf, math.inf
        every = round((run["time"][1] - run["time"][0]) / SPACING * 1e6)
        here = slice(None, None, max(1, round(1e6 / every)))
        there = slice(0, self.window, max(1, round(every / 1e6)))
        pairs = [("block[1].ux", "top")]
        if self.kind == "soil":
            pairs.append(("base.theta", "theta"))
        else:
            pairs.append(("x", "force") if self.kind == "friction-pendulum" else ("force", "force"))
        found = []
        for mine, other in pairs:
            truth = self.truth[other]
            seen = run[mine][here][: len(truth[there])]
            found.append(float(np.max(np.abs(seen - truth[there][: len(seen)])) / np.max(np.abs(truth))))
        return found[0], found[1]


def percent(error: float) -> str:
    """Format a number in per cent, as printed."""
    if not error < 10.0:
        return "diverges"
    return f"{100.0 * error:.2g} %"


def plain_limit(fmus: dict[str, Path]) -> float:
    """Return slab mass over effective mass below which the plain reaction diverges, by bisection: 0.3 s of gentle
    shaking.
    """
    lo, hi = 0.5, 2.0
    samples = 0.01 * np.sin(2.0 * np.pi * SPACING * np.arange(601))
    for _ in range(7):
        middle = math.sqrt(lo * hi)
        case = Case.__new__(Case)
        case.fmus, case.eta, case.kind, case.parameters, case.samples = fmus, 1e-3, "linear", linear(middle), samples
        run = case.couple(2.5e-4, "plain", stop=0.6)
        grows = run["diverged"] is not None or np.max(np.abs(run["force"][-100:])) > 1e3 * MEFF
        lo, hi = (middle, hi) if grows else (lo, middle)
    return math.sqrt(lo * hi)


def mass_ratios(fmus: dict[str, Path], stop: float, say: Callable[[str], None]) -> list[dict[str, Any]]:
    """Print every mass ratio, damped and undamped, both scenes, at 1 ms: plain, and R0/Meff with slope."""
    rows = []
    say("slab / Meff   eta   scene        window       plain        held   line: top, force   parabola: the same")
    for eta in (1e-3, 0.0):
        for ratio in RATIOS:
            for scene in SCENES:
                case = Case(fmus, eta, "linear", linear(ratio), harmonic(scene, stop))
                ways = {way: case.errors(case.couple(1e-3, way)) for way in ("plain", "held", "line", "parabola")}
                rows.append({"ratio": ratio, "eta": eta, "scene": scene, "ways": ways})
                errors = [percent(ways[way][k]) for way, k in COLUMNS]
                say(
                    f"{ratio:8g}   {eta:6g}   {scene}   {case.window * SPACING:5.2f} s  "
                    + "".join(f"{text:>12}" for text in errors)
                )
    return rows


def orders(fmus: dict[str, Path], stop: float, say: Callable[[str], None]) -> list[dict[str, Any]]:
    """Print the error against communication step, for everything that the column can stand on."""
    steps = (4e-3, 2e-3, 1e-3, 5e-4)
    rows = []
    listed = ", ".join(f"{1e3 * h:g}" for h in steps)
    say(f"column on              top at {listed} ms; isolator or rotation, top iterated, at 1 ms; order; energy")
    for name, (kind, parameters) in PARTNERS.items():
        case = Case(fmus, 1e-3, kind, parameters, harmonic("0.1 g 1 Hz", stop))
        runs = [case.couple(h) for h in steps]
        errors = [case.errors(run) for run in runs]
        again = case.errors(case.couple(1e-3, "iterated"))
        order = math.log2(errors[1][0] / errors[3][0]) / 2.0
        run = runs[2]
        rows.append({"name": name, "errors": errors, "order": order, "work": (run["work_given"], run["work_taken"])})
        say(
            f"{name:20}   "
            + "  ".join(f"{percent(error):>8}" for error, _ in errors)
            + f"   {percent(errors[2][1]):>8}   {percent(again[0]):>8}   {order:.2f};   "
            f"energy given {run['work_given']:.3f} J, taken {run['work_taken']:.3f} J"
        )
    return rows


def once_a_step(fmus: dict[str, Path], stop: float, say: Callable[[str], None]) -> list[dict[str, Any]]:
    """Print the error against communication step where everything is exchanged once a step."""
    steps = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)
    rows = []
    listed = ", ".join(f"{1e3 * h:g}" for h in steps)
    say(f"column on, exchanged once a step: error of the top at {listed} ms; of isolator or rotation at 1 ms")
    for name, (kind, parameters) in PARTNERS.items():
        case = Case(fmus, 1e-3, kind, parameters, harmonic("0.1 g 1 Hz", stop))
        errors = [case.errors(case.by_state(h)) for h in steps]
        rows.append({"name": name, "errors": errors})
        say(f"{name:20}   " + "  ".join(f"{top:8.1e}" for top, _ in errors) + f"   {errors[2][1]:8.1e}")
    return rows


def longest_steps(fmus: dict[str, Path], stop: float, say: Callable[[str], None]) -> None:
    """Print the longest step at which it stays stable."""
    steps = (1e-3, 2e-3, 3e-3, 4e-3, 6e-3, 8e-3)
    listed = ", ".join(f"{1e3 * h:g}" for h in steps)
    say(f"slab / Meff   eta   slope        error of the top at {listed} ms")
    for eta in (1e-3, 0.0):
        for ratio in (0.01, 1.0, 100.0):
            case = Case(fmus, eta, "linear", linear(ratio), harmonic("0.1 g 1 Hz", stop))
            for way in ("line", "parabola", "iterated"):
                seen = [case.errors(case.couple(h, way))[0] for h in steps]
                say(f"{ratio:8g}   {eta:6g}   {way:9}" + "".join(f"{percent(error):>12}" for error in seen))


def recorded(fmus: dict[str, Path], record: Path, say: Callable[[str], None]) -> list[dict[str, Any]]:
    """Print the errors under a recorded motion, as long as it can be predicted, at 1 ms."""
    motion = Motion.from_at2(record)
    stop = min(motion.duration, 12.0)
    samples = motion.acceleration(motion.start + SPACING * np.arange(round(stop / SPACING) + 1))[0]
    rows = []
    say(f"{record.name}: column on, window, top and isolator or rotation, both iterated, energy given and taken")
    for name, (kind, parameters) in PARTNERS.items():
        case = Case(fmus, 1e-3, kind, parameters, samples)
        run = case.couple(1e-3)
        error = case.errors(run)
        again = case.errors(case.couple(1e-3, "iterated"))
        rows.append({"name": name, "window": case.window * SPACING, "errors": error})
        say(
            f"{name:20}   {case.window * SPACING:6.2f} s   {percent(error[0]):>8} {percent(error[1]):>8}"
            f"   {percent(again[0]):>8} {percent(again[1]):>8}"
            f"   {run['work_given']:.2f} J, {run['work_taken']:.2f} J;   peak {1e3 * case.peak:.2f} mm"
        )
    return rows


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Errors of the coupled column against the same system solved as one.")
    parser.add_argument("--quick", action="store_true", help="1.5 s of each scene instead of 6 s")
    parser.add_argument("--record", type=Path, metavar="FILE", help=".AT2 record to follow as well")
    options = parser.parse_args()
    stop = 1.5 if options.quick else 6.0

    def say(line: str) -> None:
        print(line, flush=True)

    with tempfile.TemporaryDirectory() as folder:
        fmus = build_all(Path(folder), COLUMN)
        once_a_step(fmus, min(stop, 3.0), say)
        say("")
        say(f"plain reaction: stable above slab / Meff = {plain_limit(fmus):.3f} (theory: 1)\n")
        orders(fmus, min(stop, 3.0), say)
        say("")
        mass_ratios(fmus, stop, say)
        say("")
        longest_steps(fmus, min(stop, 3.0), say)
        if options.record:
            say("")
            recorded(fmus, options.record, say)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
