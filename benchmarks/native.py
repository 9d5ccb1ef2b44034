"""Costs of the native FMU: `python -m benchmarks.native [PART ...]`.

step        time of fmi2DoStep through ctypes (ns): column at rest, column that rocks; and of a master's other calls
getters     8000 steps of FMPy's simulate_fmu against an FMU in C of the same variables that does nothing
cold        a whole `fmpy simulate` process against one that only imports FMPy
lives       10000 instances, each from instantiation to the end: time, and memory not released
inputs      error against communication step, held and with derivatives of the input
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

from build_fmu import build_native_fmu
from fmu_src.native import library

from .fmu import FMPY, PHOCAS, SEVEN_BLOCKS, errors_of_inputs, measured, print_parts

PLATFORM = ("linux64",)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} (default: all)")
    parser.add_argument("--rounds", type=int, default=15, help="rounds, the shortest of which counts")
    parser.add_argument("--plot", type=Path, help="picture of the part inputs")
    return print_parts(parser, PARTS, arguments)


def step(folder: Path, options: argparse.Namespace) -> str:
    """Time calls through ctypes; the last one does nothing."""
    fmu = build_native_fmu(PHOCAS, folder / "phocas.fmu", platforms=PLATFORM)
    found = {name: 1e9 * seconds for name, seconds in measured("native_calls", fmu, options.rounds).items()}
    return (
        f"at rest {found['rest']:.0f} ns, under 0.3 m/s2 {found['rocks']:.0f} ns a step of 1 ms; input set and 27 "
        f"outputs read {found['outputs']:.0f} ns; state got and set {found['state']:.0f} ns; "
        f"an empty call through ctypes {found['nothing']:.0f} ns"
    )


def getters(folder: Path, options: argparse.Namespace) -> str:
    """Time a whole run against the cheapest possible FMU with the same variables."""
    toml = folder / "seven.toml"
    toml.write_text(SEVEN_BLOCKS)
    fmu = build_native_fmu(toml, folder / "seven.fmu", platforms=PLATFORM)
    empty = folder / "empty.fmu"
    binary = folder / "empty.so"
    source = Path(__file__).with_name("reference_fmu.c")
    command = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-linux-gnu.2.17", "-O2", "-shared", "-fPIC"]
    command += ["-DVARIABLES=100000", f"-I{library.headers()}", str(source), "-o", str(binary)]
    subprocess.run(command, check=True)
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(empty, "w") as new:
        for name in old.namelist():
            new.writestr(name, binary.read_bytes() if name.endswith(".so") else old.read(name))
    lines = []
    for scene, push in (("at rest", 0.0), ("in full contact", 0.05), ("rocking now and then", 0.5)):
        found = measured("race", [fmu, empty], 8000, options.rounds, push)
        ours, nothing = found["seconds"]
        lines.append(f"{scene} {ours:.3f} s, empty {nothing:.3f} s, {ours / nothing:.2f} times")
    return f"{found['outputs']} outputs: " + "; ".join(lines)


def cold(folder: Path, options: argparse.Namespace) -> str:
    """Time 20 s of the damped Phocas by `fmpy simulate`, with a new home folder each time."""
    fmu = build_native_fmu(PHOCAS, folder / "phocas.fmu", platforms=PLATFORM)
    ours = min(_command_line(fmu, Path(tempfile.mkdtemp(dir=folder))) for _ in range(options.rounds))
    bare = min(_command_line(None, folder) for _ in range(options.rounds))
    return f"fresh account {ours:.2f} s; Python with fmpy's simulation module alone {bare:.2f} s"


def _command_line(fmu: Path | None, home: Path) -> float:
    command = [sys.executable, "-c", "import fmpy, fmpy.simulation, fmpy.util"]
    if fmu is not None:
        options = ["--stop-time", "20", "--output-interval", "0.02", "--start-values", "base.ax", "0.3"]
        command = [str(FMPY), "simulate", str(fmu), *options, "--output-file", str(home / "out.csv")]
    begin = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=os.environ | {"HOME": str(home)})
    return time.perf_counter() - begin


def lives(folder: Path, options: argparse.Namespace) -> str:
    """Measure the resident memory before and after."""
    fmu = build_native_fmu(PHOCAS, folder / "phocas.fmu", platforms=PLATFORM)
    found = measured("native_lives", fmu, 10000)
    return f"10000 instances: {found['bytes']:.0f} bytes more, {1e6 * found['seconds']:.1f} us each"


# --- inputs

WAYS = {"held": "base.ax held", "derivative": "input derivative"}


def inputs(folder: Path, options: argparse.Namespace) -> str:
    """Measure as benchmarks/fmu.py does, with fmi2SetRealInputDerivatives."""
    return errors_of_inputs(folder, options, build_native_fmu(PHOCAS, folder / "phocas.fmu", platforms=PLATFORM), WAYS)


PARTS = {"step": step, "getters": getters, "cold": cold, "lives": lives, "inputs": inputs}


if __name__ == "__main__":
    raise SystemExit(main())
