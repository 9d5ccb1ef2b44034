"""Results that must have equal bits under every version of numba, one a line: a run, lanes, and a PythonFMU.

    python tests/project/numba_smoke.py [--fmu FILE [--only-fmu] | --without-fmu]

With --fmu, that FMU is run, and built there first if it does not exist.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))  # the packages need not be installed
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))

import numba  # noqa: E402
import numpy as np  # noqa: E402
from fmpy import simulate_fmu  # noqa: E402

from build_fmu import build_fmu  # noqa: E402
from multiblock import Column, Motion, simulate, simulate_many  # noqa: E402
from solver.ground.motion import STANDARD_GRAVITY  # noqa: E402

COLUMN = ROOT / "examples" / "columns" / "phocas-damped.toml"
RUNS = 16
OTHER_INPUTS = ("base.az", "base.jx", "base.jz", "base.theta", "base.omega", "base.alpha")


def main() -> None:
    """Print the numbers; what may differ between versions goes to stderr."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--fmu", type=Path)
    parser.add_argument("--only-fmu", action="store_true")
    parser.add_argument("--without-fmu", action="store_true")
    options = parser.parse_args()
    print(f"numba {numba.__version__}, numpy {np.__version__}", file=sys.stderr)
    if not options.only_fmu:
        run_and_lanes()
    if not options.without_fmu:
        with tempfile.TemporaryDirectory() as folder:
            run_fmu(options.fmu or Path(folder) / "smoke.fmu")


def run_and_lanes() -> None:
    """Return a run of one column, and of many in lanes."""
    column = Column.from_toml(COLUMN)
    run = simulate(column, Motion.harmonic(0.05 * STANDARD_GRAVITY, 2.0, 20.0))
    say("run", run.peak_top_ux[0], math.fsum(run.ux.ravel()))  # numpy's sums differ between its versions
    motions = [Motion.harmonic(0.01 * (k + 1) * STANDARD_GRAVITY, 2.0, 5.0) for k in range(RUNS)]
    table = simulate_many(column, motions, threads=1)
    say("lanes", *table["peak_top_ux"].ravel())


def run_fmu(fmu: Path) -> None:
    """Return the sums over the outputs of an FMU, which is built if it does not exist."""
    if not fmu.exists():
        build_fmu(COLUMN, fmu)
    found = simulate_fmu(str(fmu), stop_time=1.0, output_interval=0.05, input=ramp())
    for name in sorted(found.dtype.names):
        say(f"fmu {name}", math.fsum(np.abs(found[name])))


def ramp() -> np.ndarray:
    """Return a ramp of the base acceleration, m/s2, as FMPy takes inputs; the others are 0."""
    given = np.zeros(2, dtype=[(name, np.float64) for name in ("time", "base.ax", *OTHER_INPUTS)])
    given["time"] = given["base.ax"] = (0.0, 1.0)
    return given


def say(what: str, *numbers: float) -> None:
    """Print the numbers, all digits; the processor time so far, with that of child processes, goes to stderr."""
    print(what, *(repr(float(number)) for number in numbers), flush=True)
    if not what.startswith("fmu"):
        print(f"{what}: {sum(os.times()[:4]):.1f} s of processor time so far", file=sys.stderr)


if __name__ == "__main__":
    main()
