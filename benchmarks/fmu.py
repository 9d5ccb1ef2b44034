"""Costs of the FMU, and its behaviour in a master: `python -m benchmarks.fmu [PART ...]`.

calls       us to set an input, step 1 ms and read an output, through FMPy, beside a slave that does nothing
state       us to get and set the state of a column of three blocks
getters     8000 steps with all outputs of seven blocks against an FMU of the same table that does nothing
cold        a whole `fmpy simulate` process on a fresh user account
threads     two instances in two threads against one after the other
exits       exit status of 200 `fmpy simulate` processes
memory      what 1000 instances leave behind in one process
inputs      error against communication step, held, with slopes, with a record inside
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from build_fmu import build_fmu, build_native_fmu
from solver import Column, Motion, simulate

from .scenes import ROOT

FMPY = Path(sys.executable).parent / "fmpy"
PHOCAS = ROOT / "examples" / "columns" / "phocas-damped.toml"
SEVEN_BLOCKS = (
    'name = "seven"\n'
    + "[[block]]\nheight = 2.0\nwidth = 1.5\ndepth = 1.5\ndensity = 2500.0\n" * 7
    + "[joint]\nstiffness = 5e9\ndamping = 1e-3\n"
)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} (default: all)")
    parser.add_argument("--rounds", type=int, default=15, help="of which the shortest time counts")
    parser.add_argument("--processes", type=int, default=200, help="of the part exits")
    parser.add_argument("--plot", type=Path, help="picture of the part inputs")
    parser.add_argument("--fmu", type=Path, nargs="*", default=[], help="of the part calls: others, of the same column")
    return print_parts(parser, PARTS, arguments)


def print_parts(
    parser: argparse.ArgumentParser, parts: dict[str, Callable[..., str]], arguments: list[str] | None
) -> int:
    """Print a line of figures for each of the parts that the command line asks for; returns the exit code."""
    options = parser.parse_args(arguments)
    unknown = set(options.parts) - set(parts)
    if unknown:
        parser.error(f"{', '.join(sorted(unknown))}: must be of {', '.join(parts)}")
    with tempfile.TemporaryDirectory() as folder:
        for part in options.parts or parts:
            print(f"{part:10}", parts[part](Path(folder), options), flush=True)
    return 0


def measured(function: str, *arguments: object) -> Any:
    """Return what a function of in_host.py returns in a process of its own."""
    modules = os.pathsep.join((str(ROOT), str(ROOT / "tests")))
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.in_host", function, json.dumps(arguments, default=str)],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": modules},
    )
    return json.loads(done.stdout.splitlines()[-1])


# --- calls

NOTHING = """
    def do_step(self, current_time, step_size):
        return True

    def get_real(self, vrs):
        return [0.0] * len(vrs)

    def set_real(self, vrs, values):
        pass
"""


def calls(folder: Path, options: argparse.Namespace) -> str:
    """Time calls of the PythonFMU, one whose slave does nothing, and the native FMU; others by --fmu."""
    fmus = {"PythonFMU": build_fmu(PHOCAS, folder / "phocas.fmu")}
    fmus["a slave that does nothing"] = _with_slave_methods(fmus["PythonFMU"], folder / "nothing.fmu", NOTHING)
    if importlib.util.find_spec("ziglang"):
        fmus["native"] = build_native_fmu(PHOCAS, folder / "native.fmu", platforms=["linux64"])
    fmus |= {file.name: file for file in options.fmu}
    best = dict.fromkeys(fmus, np.inf)
    for _ in range(5):  # by turns, in processes of their own
        for name, fmu in fmus.items():
            best[name] = min(best[name], measured("calls", fmu, 30 * options.rounds))
    return ", ".join(f"{name} {1e6 * seconds:.1f} us" for name, seconds in best.items()) + " (n = 3, one output)"


# --- state


def state(folder: Path, options: argparse.Namespace) -> str:
    """Get and set, through FMPy."""
    fmu = build_fmu(PHOCAS, folder / "phocas.fmu")
    found = measured("state", fmu, options.rounds)
    return f"get + set + free {1e6 * found['seconds']:.1f} us (n = 3), serialized {found['bytes']} bytes"


# --- getters

# the same table and getters, and no column in it
EMPTY = """
    def do_step(self, current_time, step_size):
        return True

    def _update(self):
        pass
"""


def getters(folder: Path, options: argparse.Namespace) -> str:
    """Time a whole run against the cheapest PythonFMU of the same variables that there can be."""
    toml = folder / "seven.toml"
    toml.write_text(SEVEN_BLOCKS)
    fmu = build_fmu(toml, folder / "seven.fmu")
    empty = _with_slave_methods(fmu, folder / "empty.fmu", EMPTY)
    found = measured("race", [fmu, empty], 8000, options.rounds, 0.5)
    ours, nothing = found["seconds"]
    return f"{found['outputs']} outputs: {ours:.3f} s, empty {nothing:.3f} s, {ours / nothing:.2f} times"


def _with_slave_methods(fmu: Path, target: Path, methods: str) -> Path:
    """Return the FMU with other methods in the class of its script, under another name of the script."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        script = old.read("resources/slavemodule.txt").decode()
        for name in old.namelist():
            content = old.read(name)
            if name == f"resources/{script}.py":
                name, content = f"resources/{script}_changed.py", content + methods.encode()
            if name == "resources/slavemodule.txt":
                content = f"{script}_changed".encode()
            new.writestr(name, content)
    return target


# --- cold start


def cold(folder: Path, options: argparse.Namespace) -> str:
    """Time 20 s of the damped Phocas by `fmpy simulate`, home and caches new each time; then with the caches kept."""
    fmu = build_fmu(PHOCAS, folder / "phocas.fmu")
    fresh = min(_command_line(fmu, Path(tempfile.mkdtemp(dir=folder))) for _ in range(options.rounds))
    home = Path(tempfile.mkdtemp(dir=folder))
    warm = min(_command_line(fmu, home) for _ in range(options.rounds + 1))
    bare = min(_command_line(None, home) for _ in range(options.rounds))
    return f"fresh account {fresh:.2f} s, afterwards {warm:.2f} s; Python with fmpy and numpy alone {bare:.2f} s"


def _command_line(fmu: Path | None, home: Path) -> float:
    """Return the seconds of a process at home in a folder; without an FMU, of one that only imports."""
    command = [sys.executable, "-c", "import fmpy, numpy"]
    if fmu is not None:
        options = ["--stop-time", "20", "--output-interval", "0.02", "--start-values", "base.ax", "0.3"]
        command = [str(FMPY), "simulate", str(fmu), *options]
        command += ["--output-file", str(home / "out.csv")]
    kept = {key: value for key, value in os.environ.items() if key not in ("XDG_CACHE_HOME", "MULTIBLOCK_CACHE_DIR")}
    begin = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=kept | {"HOME": str(home)})
    return time.perf_counter() - begin


# --- threads


def threads(folder: Path, options: argparse.Namespace) -> str:
    """Time two instances of one FMU, each with one long communication step."""
    fmu = build_fmu(PHOCAS, folder / "phocas.fmu")
    found = measured("threads", fmu, options.rounds)
    one, both = found["one"], found["both"]
    return f"one after the other {one:.3f} s, in two threads {both:.3f} s: {one / both:.2f} times as fast"


# --- exits


def exits(folder: Path, options: argparse.Namespace) -> str:
    """Exit status of whole processes, two at a time."""
    fmu = build_fmu(PHOCAS, folder / "phocas.fmu")

    def status(k: int) -> int:
        home = folder / f"home{k % 2}"
        home.mkdir(exist_ok=True)
        command = [str(FMPY), "simulate", str(fmu), "--stop-time", "1"]
        command += ["--start-values", "base.ax", "0.3", "--output-file", str(folder / f"out{k}.csv")]
        done = subprocess.run(command, capture_output=True, env=os.environ | {"HOME": str(home)}, check=False)
        return done.returncode

    with ThreadPoolExecutor(2) as pool:
        codes = list(pool.map(status, range(options.processes)))
    results = {path.read_bytes() for path in folder.glob("out*.csv")}
    return f"status 0 in {codes.count(0)} of {len(codes)} processes, {len(results)} different result(s)"


# --- memory


def memory(folder: Path, options: argparse.Namespace) -> str:
    """Measure the resident memory before and after."""
    fmu = build_fmu(PHOCAS, folder / "phocas.fmu")
    found = measured("memory", fmu, 1000)
    grown, entries = found["bytes"] / 1e6, found["entries"]
    return f"1000 instances: {grown:.1f} MB more, {entries} more entries on the search path"


# --- inputs

WAYS = {"held": "base.ax held", "slope": "base.ax with base.jx", "record": "base.record"}
INPUT_STEPS = (0.1, 0.05, 0.04, 0.02, 0.01, 0.005, 0.0025, 0.00125)


def inputs(folder: Path, options: argparse.Namespace) -> str:
    """Follow a motion of noise up to 5 Hz that makes the column rock, sampled at 0.01 s; error at every 0.2 s
    of 4 s.
    """
    return errors_of_inputs(folder, options, build_fmu(PHOCAS, folder / "phocas.fmu"), WAYS)


def errors_of_inputs(folder: Path, options: argparse.Namespace, fmu: Path, ways: dict[str, str]) -> str:
    """Return the errors for these ways of handing the motion over."""
    time_ = 0.01 * np.arange(401)
    phases = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 20)
    noise = sum(np.sin(2.0 * np.pi * 0.25 * (k + 1) * time_ + phase) for k, phase in enumerate(phases))
    motion = Motion.from_samples(0.01, 0.25 * noise * np.sin(np.pi * time_ / 4.0))
    motion.to_csv(folder / "motion.csv")
    response = simulate(Column.from_toml(PHOCAS), motion, 4.0, tolerance=1e-10, output_step=0.2)
    table: dict[str, list[float]] = {}
    for way in ways:
        table[way] = []
        for h in INPUT_STEPS:
            seen = measured("inputs", fmu, folder / "motion.csv", way, h, motion.ax.tolist())
            table[way].append(float(np.max(np.abs(np.array(seen) - response.ux[1:, 0])) / response.peak_top_ux[0]))
    if options.plot:
        _plot(table, options.plot, ways)
    lines = [f"error of ux in parts of the peak, {1e3 * response.peak_top_ux[0]:.1f} mm"]
    lines.append("step, s   " + "".join(f"{name:>22}" for name in ways.values()))
    for k, h in enumerate(INPUT_STEPS):
        lines.append(f"{h:<10g}" + "".join(f"{table[way][k]:22.1e}" for way in ways))
    return "\n".join(lines)


def _plot(table: dict[str, list[float]], path: Path, ways: dict[str, str]) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    axes = figure.subplots()
    for (way, errors), colour, marker in zip(table.items(), ("#D55E00", "#0072B2", "#009E73"), "osD", strict=False):
        axes.loglog(INPUT_STEPS, errors, color=colour, marker=marker, markersize=4, label=ways[way])
    axes.axvline(0.01, color="0.6", linewidth=0.8)
    axes.text(0.01, 0.02, " record's dt", transform=axes.get_xaxis_transform(), fontsize=8, color="0.4")
    axes.set(xlabel="communication step, s", ylabel="largest error of ux, parts of the peak")
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=130)


PARTS = {
    "calls": calls,
    "state": state,
    "getters": getters,
    "cold": cold,
    "threads": threads,
    "exits": exits,
    "memory": memory,
    "inputs": inputs,
}


if __name__ == "__main__":
    raise SystemExit(main())
