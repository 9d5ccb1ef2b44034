"""Effect of an isolator: the isolated column beside this column on its fixed base.

    python examples/coupling/isolated.py [--record RECORD.AT2] [--isolator friction-pendulum] [-o results]

Without a record the ground moves by a near-fault pulse. Writes isolated.png and prints the numbers.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from build import DEFAULT_COLUMN, build_all
from master import Fmu, Run, couple

from multiblock import Column, InputError, Motion
from solver.plotting.largest import length
from solver.plotting.lines import thinned
from solver.plotting.plots import draw_ground
from solver.plotting.style import BLUE, RED, Figure, header, save, show_names, tidy
from solver.plotting.words import setting_of

STEP = 1e-3  # s
AFTER = 6.0  # s that are followed after the motion has ended
FIXED, ISOLATED = RED, BLUE
SLAB = 20e3  # kg
# under 100 t: about 3 s beyond yielding, 5 % of the weight
ISOLATORS: dict[str, dict[str, float]] = {
    "friction-pendulum": {"radius": 2.2, "friction": 0.05, "yield": 1e-3},
    "lead-rubber": {"stiffness": 4.4e5, "strength": 5e4, "yield": 8e-3},
    "linear": {"stiffness": 4.4e5, "damping": 4.2e4},
}


def pulse(velocity: float = 0.6, period: float = 1.2, cycles: float = 2.0) -> Motion:
    """Return a near-fault ground motion of G. P. Mavroeidis and A. S. Papageorgiou, Bull. Seism. Soc.
    Am. 93 (2003) 1099-1131.

    velocity: m/s, amplitude; period: s, prevailing; cycles: gamma.
    """
    time = np.arange(round(cycles * period / STEP) + 1) * STEP
    past = 2.0 * np.pi / period * (time - 0.5 * cycles * period)
    wave = velocity * 0.5 * (1.0 + np.cos(past / cycles)) * np.sin(past)
    return Motion.from_samples(STEP, np.gradient(wave, STEP)).named("a near-fault pulse")


def ground_of(record: Path) -> Motion:
    """Return the motion of a record along x. Raises InputError."""
    motion = Motion.from_file(record)
    if motion.has_ay or np.any(motion.az):
        raise InputError(f"{record}: ay, az: the ground moves along x alone, must be zero")
    return motion


def run_both(column: Column, fmus: dict[str, Path], motion: Motion, isolator: str) -> tuple[Run, Run]:
    """Return histories of the fixed and of the isolated column, every STEP."""
    stop = motion.duration + AFTER
    n = column.n
    ends = "block[{}].ux", "block[{}].theta", "joint[{}].contact"
    watch = (*(end.format(i) for i in range(1, n + 1) for end in ends), "base.Fx", "overturn_time")

    def ground(t: float) -> float:
        return float(motion.acceleration(motion.start + t)[0])

    fixed = Fmu(fmus["column"], **{"base.drive": "acceleration"})
    rows = []
    for k in range(round(stop / STEP) + 1):
        t = k * STEP
        fixed.set(**{"base.ax": ground(t), "base.jx": (ground(t + STEP) - ground(t)) / STEP})
        rows.append([t, *fixed.get(*watch)])
        fixed.step(t, STEP)
    fixed.close()
    standing = Run(zip(("time", *watch), np.array(rows).T, strict=True))
    upper = Fmu(fmus["column"], **{"base.drive": "acceleration"})
    lower = Fmu(fmus["isolator"], mass=SLAB, kind=isolator, **ISOLATORS[isolator])
    floating = couple(upper, lower, ground, STEP, stop, watch=watch, watch_partner=("x", "force"))
    upper.close()
    lower.close()
    return standing, floating


def openings(column: Column, run: Run) -> np.ndarray:
    """Return the largest opening of each joint at its edge, m, (n,) from the top."""
    theta = np.array([run[f"block[{i}].theta"] for i in range(1, column.n + 1)] + [np.zeros(len(run["time"]))])
    found = []
    for i, block in enumerate(column.blocks):
        open_part = 1.0 - run[f"joint[{i + 1}].contact"]
        found.append(np.max(np.abs(theta[i] - theta[i + 1]) * block.joint_width * open_part))
    return np.array(found)


def report(column: Column, fixed: Run, isolated: Run) -> str:
    """Return the numbers an engineer wants."""

    def verdict(run: Run) -> str:
        late = run["overturn_time"][-1]
        return f"at {late:.2f} s" if late >= 0.0 else "no"

    def line(what: str, value: Any, unit: str) -> str:
        return f"{what:36}{value(fixed):>14}{value(isolated):>14}  {unit}"

    lines = [
        f"{'':36}{'fixed base':>14}{'isolated':>14}",
        line("overturned", verdict, ""),
        line("peak displacement of the top", lambda run: f"{1e3 * np.max(np.abs(run['block[1].ux'])):.2f}", "mm"),
        line("largest base shear", lambda run: f"{1e-3 * np.max(np.abs(run['base.Fx'])):.1f}", "kN"),
    ]
    for i in range(column.n):
        lines.append(line(f"opening of joint {i + 1}", lambda run, i=i: f"{1e3 * openings(column, run)[i]:.3f}", "mm"))
    given, taken = isolated["work_given"], isolated["work_taken"]
    lines += [
        f"{'displacement of the isolator':50}{1e3 * np.max(np.abs(isolated['x'])):>14.1f}  mm",
        f"{'left when all is over':50}{1e3 * abs(isolated['x'][-1]):>14.1f}  mm",
        f"{'force of the isolator':50}{1e-3 * np.max(np.abs(isolated['force'])):>14.1f}  kN",
        f"energy through the interface: the slab gives {given:.2f} J, the column takes {taken:.2f} J",
    ]
    return "\n".join(lines)


def draw(column: Column, fixed: Run, isolated: Run, motion: Motion, isolator: str, path: Path) -> None:
    """Draw the column response, ground and isolator loop."""
    figure = Figure(figsize=(10.0, 6.4), layout="constrained")
    (ground, loop), (top, contact) = figure.subplots(2, 2, width_ratios=(1.8, 1.0))
    runs = ((fixed, FIXED, "fixed base"), (isolated, ISOLATED, "isolated"))
    draw_ground(ground, motion)
    for run, color, _ in runs:
        top.plot(*thinned(run["time"], 1e3 * run["block[1].ux"]), color=color, linewidth=1.2)
        contact.plot(*thinned(run["time"], run[f"joint[{column.n}].contact"]), color=color, linewidth=0.8)
    reach = 1.3 * max(1e3 * np.max(np.abs(isolated["block[1].ux"])), 20.0)
    if np.max(np.abs(fixed["block[1].ux"])) > 2.0:  # m: it has fallen
        reach = max(reach, 600.0)
        top.set_ylim(-reach, reach)
    loop.plot(1e3 * isolated["x"], -1e-3 * isolated["force"], color=ISOLATED, linewidth=0.9)
    ground.set_title("(a) acceleration of the ground", loc="left")
    top.set(title="(c) displacement of the top", ylabel="$u_x$ (mm)", xlabel="time (s)")
    loop.set(title="(b) isolator", xlabel="displacement (mm)", ylabel="force (kN)")
    contact.set(title="(d) base joint, width in contact", ylabel="part", xlabel="time (s)", ylim=(-0.05, 1.05))
    for axes in (ground, top, loop, contact):
        tidy(axes)
    for axes in (ground, top, contact):
        axes.set_xlim(fixed["time"][0], fixed["time"][-1])
    peaks = [f"{length(np.max(np.abs(run['block[1].ux'])))} {name}" for run, _, name in runs]
    line = (
        f"Largest displacement of the top: {', '.join(peaks)}. {length(abs(isolated['x'][-1]))} left in the isolator."
    )
    show_names(figure, [name for _, _, name in runs], [color for _, color, _ in runs])
    header(figure, f"{setting_of(column, motion)}, {isolator}", line)
    save(figure, path)


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="An isolated column against the same one on its fixed base.")
    parser.add_argument("column", nargs="?", type=Path, default=DEFAULT_COLUMN, help="TOML file (default: %(default)s)")
    parser.add_argument(
        "--record", type=Path, metavar="FILE", help="record of one component (default: a near-fault pulse)"
    )
    parser.add_argument("--scale", type=float, default=1.0, help="factor on the ground motion")
    parser.add_argument("--isolator", choices=ISOLATORS, default="friction-pendulum")
    parser.add_argument("-o", "--output-folder", type=Path, default=Path("results"))
    options = parser.parse_args()
    try:
        column = Column.from_toml(options.column)
        motion = (ground_of(options.record) if options.record else pulse()).scaled(options.scale)
        options.output_folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            fixed, isolated = run_both(column, build_all(Path(folder), options.column), motion, options.isolator)
    except (InputError, OSError) as error:
        print(f"isolated.py: {error}", file=sys.stderr)
        return 2
    picture = options.output_folder / "isolated.png"
    draw(column, fixed, isolated, motion, options.isolator, picture)
    print(report(column, fixed, isolated))
    print(picture)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
