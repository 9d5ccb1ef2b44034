"""What the native FMU costs: `python -m benchmarks.native [PART ...]`.

step        ns of fmi2DoStep through ctypes: column at rest, column that rocks; of the other calls of a master
getters     8000 steps of FMPy's simulate_fmu against an FMU in C of the same variables that does nothing
cold        a whole `fmpy simulate` process against one that only imports FMPy
lives       10000 times from instantiation to the end: time and what is left behind
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

from .fmu import FMPY, PHOCAS, RACE, SEVEN_BLOCKS, _run, errors_of_inputs, print_parts

PLATFORM = ("linux64",)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} (default: all)")
    parser.add_argument("--rounds", type=int, default=15, help="of which the shortest time counts")
    parser.add_argument("--plot", type=Path, help="picture of the part inputs")
    return print_parts(parser, PARTS, arguments)


STEP = """
import ctypes, sys, time
from instance import Instance

def best(call, rounds, count=2000):
    shortest = 1.0
    for _ in range(rounds):
        begin = time.perf_counter()
        for _ in range(count):
            call()
        shortest = min(shortest, (time.perf_counter() - begin) / count)
    return 1e9 * shortest

rounds = int(sys.argv[2])
found = []
for push in (0.0, 0.3):
    column = Instance(sys.argv[1], {"base.ax": push})
    dll, c = column.fmi.dll, column.fmi.component
    step = dll.fmi2DoStep
    step.argtypes, step.restype = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int], ctypes.c_int
    now = 0.0
    def one():
        global now
        assert step(c, now, 1e-3, 1) == 0
        now += 1e-3
    found.append(best(one, rounds, 1000))
reset = ctypes.c_void_p()
state = ctypes.c_void_p()
named = {name: variable.valueReference for name, variable in column.variables.items()}
outputs_of = [name for name, variable in column.variables.items() if variable.causality == "output"][:27]
reference = (ctypes.c_uint * 27)(*(named[name] for name in outputs_of))
values = (ctypes.c_double * 27)()
get_real, set_real = dll.fmi2GetReal, dll.fmi2SetReal
def outputs():
    set_real(c, reference_ax, 1, one_value)
    get_real(c, reference, 27, values)
reference_ax, one_value = (ctypes.c_uint * 1)(named["base.ax"]), (ctypes.c_double * 1)(0.3)
found.append(best(outputs, rounds))
def around():
    dll.fmi2GetFMUstate(c, ctypes.byref(state))
    dll.fmi2SetFMUstate(c, state)
found.append(best(around, rounds))
version = dll.fmi2GetVersion
found.append(best(lambda: version(), rounds))
print(*found)
"""


def step(folder: Path, options: argparse.Namespace) -> str:
    """Calls through ctypes; the last is one that does nothing."""
    fmu = build_native_fmu(PHOCAS, folder / "phocas.fmu", platforms=PLATFORM)
    rest, rocks, outputs, state, nothing = (float(word) for word in _run(STEP, fmu, options.rounds).split())
    return (
        f"at rest {rest:.0f} ns, under 0.3 m/s2 {rocks:.0f} ns a step of 1 ms; input set and 27 outputs read "
        f"{outputs:.0f} ns; state got and set {state:.0f} ns; an empty call through ctypes {nothing:.0f} ns"
    )


def getters(folder: Path, options: argparse.Namespace) -> str:
    """A whole run against the cheapest FMU of the same variables that there can be."""
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
    told = []
    for scene, push in (("at rest", 0.0), ("in full contact", 0.05), ("rocking now and then", 0.5)):
        script = RACE.replace("0.5 * np.sin", f"{push} * np.sin")
        ours, nothing, outputs = (float(word) for word in _run(script, 8000, options.rounds, fmu, empty).split())
        told.append(f"{scene} {ours:.3f} s, empty {nothing:.3f} s, {ours / nothing:.2f} times")
    return f"{outputs:.0f} outputs: " + "; ".join(told)


def cold(folder: Path, options: argparse.Namespace) -> str:
    """20 s of the damped Phocas by `fmpy simulate`, home new each time."""
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


LIVES = """
import ctypes, sys, time
from instance import Instance
column = Instance(sys.argv[1])
dll, callbacks, guid = column.fmi.dll, column.fmi.callbacks, column.fmi.guid.encode()

def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096

def live():
    c = dll.fmi2Instantiate(b"column", 1, guid, b"", ctypes.byref(callbacks), 0, 0)
    assert dll.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == 0
    assert dll.fmi2EnterInitializationMode(c) == 0 and dll.fmi2ExitInitializationMode(c) == 0
    assert dll.fmi2DoStep(c, 0.0, 0.01, 1) == 0
    dll.fmi2FreeInstance(c)

for _ in range(100):
    live()
before, begin = resident(), time.perf_counter()
for _ in range(10000):
    live()
print(resident() - before, time.perf_counter() - begin)
"""


def lives(folder: Path, options: argparse.Namespace) -> str:
    """Resident memory before and after."""
    fmu = build_native_fmu(PHOCAS, folder / "phocas.fmu", platforms=PLATFORM)
    grown, spent = (float(word) for word in _run(LIVES, fmu).split())
    return f"10000 instances: {grown:.0f} bytes more, {1e2 * spent:.1f} us each"


# --- inputs

WAYS = {"held": "base.ax held", "derivative": "input derivative"}


def inputs(folder: Path, options: argparse.Namespace) -> str:
    """As in benchmarks/fmu.py, with fmi2SetRealInputDerivatives."""
    return errors_of_inputs(folder, options, build_native_fmu(PHOCAS, folder / "phocas.fmu", platforms=PLATFORM), WAYS)


PARTS = {"step": step, "getters": getters, "cold": cold, "lives": lives, "inputs": inputs}


if __name__ == "__main__":
    raise SystemExit(main())
