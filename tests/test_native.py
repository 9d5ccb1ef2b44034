"""The FMU without Python: the same numbers as the PythonFMU, and what only it can do."""

from __future__ import annotations

import importlib.util
import json
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmus import LIVES, ROOT, Fmus, finish, run

from solver import Column, Motion
from solver.modes import longest_stable_step

if importlib.util.find_spec("ziglang") is None:
    pytest.skip("needs ziglang, the extra native", allow_module_level=True)

DAMPED = ROOT / "examples/columns/phocas-damped.toml"
LINUX = ("--native", "--platforms", "linux64")


@pytest.fixture(scope="module")
def native(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The damped example as a native FMU."""
    return Fmus.build(DAMPED, tmp_path_factory.mktemp("native") / "damped.fmu", *LINUX)


def stack(folder: Path, n: int, joint: str) -> Path:
    """A column of n blocks, no two alike, 14 m high; one FMU of each sort would be too many to name by hand."""
    blocks = "".join(
        f"[[block]]\nheight = {14.0 / n * (0.8 + 0.4 * (k % 3) / 2)}\nwidth = {1.5 + 0.02 * (k % 5)}\ndepth = 1.5\n"
        "density = 2400.0\n"
        for k in range(n)
    )
    path = folder / f"stack{n}.toml"
    path.write_text(f'name = "stack{n}"\n{blocks}[joint]\nstiffness = 4e9\n{joint}\n')
    return path


# argv: FMUs, then values; prints whether every output of every step has the same bits, and the largest difference
SIDE_BY_SIDE = """
import json, sys
from math import sin
from instance import Instance
values = [json.loads(text) for text in sys.argv[3:]]
for given in values:
    push = given.pop("push", 1.5)
    columns = [Instance(fmu, given) for fmu in sys.argv[1:3]]
    worst, peak, same = {}, {}, True
    for k in range(400):
        seen = []
        for column in columns:
            ax = push * sin(12.6 * 0.005 * k)
            column.set({"base.ax": ax, "base.az": 0.2 * ax, "base.jx": 12.6 * push - 0.1 * push * k})
            if k == 200:
                column.set({"g": 9.7, "joint[1].damping": 4e-3})
            column.step(0.005 * k, 0.005)
            seen.append(column.get())
        same = same and seen[0] == seen[1]
        for i, (a, b) in enumerate(zip(*seen)):
            worst[i] = max(worst.get(i, 0.0), abs(a - b))
            peak[i] = max(peak.get(i, 1e-300), abs(b))
    print(json.dumps([same, max(worst[i] / peak[i] for i in worst)]))
"""


def compare(first: Path, second: Path, *values: dict[str, object]) -> list[tuple[bool, float]]:
    """For each set of start values: whether all outputs have the same bits, and how far they are apart."""
    printed = run(sys.executable, "-c", SIDE_BY_SIDE, first, second, *(json.dumps(item) for item in values))
    return [tuple(json.loads(line)) for line in printed.splitlines()]


def test_three_blocks_give_the_numbers_of_the_pythonfmu(fmus: Fmus, native: Path) -> None:
    results = compare(
        native,
        fmus.damped,
        {},
        {"push": 0.05},
        {"solver.tolerance": 1e-9, "joint[2].damping": 2e-2},
        {"block[1].mass": 2e4, "block[2].centroid": 2.0, "block[3].inertia": 1e5, "joint[3].width": 1.2, "g": 9.0},
        {"solver.without": "elastic, dashpots", "joint[1].damping": 0.0},
        {"solver.formulation": "paper"},
        {"solver.formulation": "paper", "solver.integrator": "central-difference", "solver.step": 5e-5},
    )
    assert all(apart <= 1e-12 for _, apart in results), results  # measured 0: the same bits


@pytest.mark.parametrize(("n", "joint"), [(1, "damping = 2e-3"), (50, "damping = 1e-2\nwidth = 1.2")])
def test_one_and_fifty_blocks(tmp_path: Path, n: int, joint: str) -> None:
    column = stack(tmp_path, n, joint)
    native = Fmus.build(column, tmp_path / "native.fmu", *LINUX)
    ((_, apart),) = compare(native, Fmus.build(column, tmp_path / "python.fmu"), {})
    assert apart <= 1e-12  # measured 0


def test_fmpy_is_content_and_python_is_not_needed(native: Path) -> None:
    assert "No problems found" in run("fmpy", "validate", native)
    with zipfile.ZipFile(native) as archive:
        description = archive.read("modelDescription.xml").decode()
        names = archive.namelist()
        account = archive.read("documentation/binaries.txt").decode()
    assert native.stat().st_size < 1e6  # measured 0.11e6 for one platform
    assert 'needsExecutionTool="false"' in description
    assert 'canInterpolateInputs="true"' in description
    assert not [name for name in names if name.endswith(".py")]
    assert "x86_64-linux-gnu.2.17" in account


def test_the_two_fmus_differ_in_capabilities_only(fmus: Fmus, native: Path) -> None:
    def variables(fmu: Path) -> str:
        with zipfile.ZipFile(fmu) as archive:
            text = archive.read("modelDescription.xml").decode()
        return text[text.index("<ModelVariables") :].replace(" />", "/>").replace("\n", "").replace("  ", "")

    def joined(text: str) -> str:
        return "".join(part.strip() for part in text.replace("\t", "").splitlines())

    assert joined(variables(native)) == joined(variables(fmus.damped))


def test_command_line(native: Path, tmp_path: Path) -> None:
    Motion.harmonic(0.5, 2.0, 2.0).to_csv(tmp_path / "motion.csv", step=0.005)
    options = ("--input-file", tmp_path / "motion.csv", "--output-interval", 0.005, "--stop-time", 2.0)
    run("fmpy", "simulate", native, *options, "--output-file", tmp_path / "out.csv")
    assert (tmp_path / "out.csv").stat().st_size > 50_000


# --- what the PythonFMU cannot do

PRELUDE = """
import ctypes, json, sys
from math import pi, sin
from pathlib import Path
from instance import Instance
from fmpy.fmi2 import fmi2Boolean, fmi2Integer, fmi2Real, fmi2Status, fmi2String, fmi2ValueReference

def references(column, *names):
    return (fmi2ValueReference * len(names))(*(column.variables[name].valueReference for name in names))

def input_derivative(column, name, value, order=1):
    one = references(column, name), 1, (fmi2Integer * 1)(order), (fmi2Real * 1)(value)
    return column.fmi.dll.fmi2SetRealInputDerivatives(column.fmi.component, *one)

def output_derivatives(column, *names):
    values = (fmi2Real * len(names))()
    orders = (fmi2Integer * len(names))(*[1] * len(names))
    status = column.fmi.dll.fmi2GetRealOutputDerivatives(
        column.fmi.component, references(column, *names), len(names), orders, values)
    assert status == 0, status
    return list(values)

def directional(column, outputs, inputs, seeds):
    of, by = (list(references(column, *names)) for names in (outputs, inputs))
    return column.fmi.getDirectionalDerivative(of, by, seeds)

def rocking():
    column = Instance(sys.argv[1], {"solver.tolerance": 1e-9})
    for k in range(60):
        column.set({"base.ax": 1.5 * sin(0.126 * k), "base.az": 0.3})
        column.step(0.01 * k, 0.01)
    return column

OUTPUTS = [f"{owner}[{i}].{name}" for i in (1, 2, 3) for owner, names in
           (("block", ("ux", "uz", "theta")), ("joint", ("N", "M", "S"))) for name in names]
OUTPUTS += ["base.Fx", "base.Fz", "base.My"]
"""


def test_input_derivatives_are_the_slopes_of_the_inputs(native: Path) -> None:
    script = PRELUDE + (
        "def follow(derivative):\n"
        "    column, seen = Instance(sys.argv[1]), []\n"
        "    for k in range(100):\n"
        "        slope = 15.0 - 0.3 * k\n"
        "        column.set({'base.ax': 1.5 * sin(0.126 * k)} | ({} if derivative else {'base.jx': slope}))\n"
        "        if derivative:\n            assert input_derivative(column, 'base.ax', slope) == 0\n"
        "        column.step(0.01 * k, 0.01)\n        seen += column.get()\n"
        "    return seen\n"
        "print(follow(True) == follow(False))\n"
        "column = Instance(sys.argv[1])\n"
        "print(input_derivative(column, 'base.ax', 1.0, order=2), input_derivative(column, 'base.jx', 1.0),\n"
        "      input_derivative(column, 'g', 1.0), input_derivative(column, 'base.jx', 0.0))\n"
    )
    same, statuses = [line for line in run(sys.executable, "-c", script, native).splitlines() if line[0] != "["]
    assert same == "True"
    assert statuses == "3 3 3 0"


def test_input_derivatives_are_an_order_better_than_held_inputs(native: Path) -> None:
    script = PRELUDE + (
        "def last(h, derivative):\n"
        "    column = Instance(sys.argv[1], {'solver.tolerance': 1e-9})\n"
        "    a = lambda k: 0.6 * sin(4.0 * pi * k * h)\n"
        "    for k in range(round(1.6 / h)):\n"
        "        column.set({'base.ax': a(k)})\n"
        "        if derivative:\n            input_derivative(column, 'base.ax', (a(k + 1) - a(k)) / h)\n"
        "        column.step(k * h, h)\n"
        "    return column.get('block[1].ux')[0]\n"
        "exact = last(0.0005, True)\n"
        "print(json.dumps([abs(last(h, d) - exact) / abs(exact) for d in (False, True) for h in (0.01, 0.005)]))"
    )
    coarse, fine, coarse_linear, fine_linear = json.loads(run(sys.executable, "-c", script, native).splitlines()[-1])
    assert 1.7 < coarse / fine < 2.4  # measured 2.0
    assert 3.3 < coarse_linear / fine_linear < 5.0  # measured 4.0
    assert coarse_linear < coarse / 10.0


def test_output_derivatives_are_the_rates_of_the_outputs(native: Path) -> None:
    script = PRELUDE + (
        "column = rocking()\n"
        "column.set({'base.ax': 0.4, 'base.jx': 3.0})\n"
        "state, h, seen = column.fmi.getFMUState(), 1e-5, []\n"
        "column.step(0.6, h)\n"
        "found = output_derivatives(column, *OUTPUTS)\n"
        "for length in (0.0, 2 * h):\n"
        "    column.fmi.setFMUState(state)\n"
        "    if length:\n        column.step(0.6, length)\n"
        "    seen.append(column.get(*OUTPUTS))\n"
        "print(json.dumps([found, [(b - a) / (2 * h) for a, b in zip(*seen)]]))"
    )
    found, differences = (np.array(part) for part in json.loads(run(sys.executable, "-c", script, native)))
    sizes = np.abs(differences) + 1e-6 * np.max(np.abs(differences))
    assert np.max(np.abs(found - differences) / sizes) < 1e-3, (found, differences)


def test_directional_derivatives_are_the_effective_mass(native: Path) -> None:
    script = PRELUDE + (
        "column = rocking()\n"
        "for given in ({}, {'base.ax': 0.7, 'base.jz': 2.0}):\n"
        "    column.set(given)\n"
        "    before = column.get(*OUTPUTS)\n"
        "    found = directional(column, OUTPUTS, ['base.ax', 'base.az'], [2.0, -3.0])\n"
        "    column.set({name: column.get(name)[0] + by for name, by in (('base.ax', 2.0), ('base.az', -3.0))})\n"
        "    after = column.get(*OUTPUTS)\n"
        "    print(json.dumps([found, [b - a for a, b in zip(before, after)]]))"
    )
    for line in run(sys.executable, "-c", script, native).splitlines():
        found, differences = (np.array(part) for part in json.loads(line))
        size = np.max(np.abs(differences))
        assert size > 1e4
        assert np.max(np.abs(found - differences)) < 1e-10 * size, (found, differences)


SPLIT = [f"base.{name}" for name in ("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt")]


@pytest.mark.parametrize(
    ("name", "step", "least"), [("alpha", 1.0, 1e-4), ("theta", 1e-8, 1e-3), ("omega", 1e-5, 1e-3)]
)
def test_directional_derivatives_by_the_rotation_of_the_base(
    native: Path, name: str, step: float, least: float
) -> None:
    """Against differences of what the instance shows; by alpha, in which it is linear, they round to 8e-6."""
    script = PRELUDE + (
        f"name, step, outputs = 'base.{name}', {step}, OUTPUTS + {SPLIT}\n"
        "column = rocking()\n"
        "column.set({'base.theta': 1e-4, 'base.omega': 2e-3, 'base.alpha': 0.05})\n"
        "found = directional(column, outputs, [name], [1.0])\n"
        "at = column.get(name)[0]\n"
        "seen = []\n"
        "for value in (at - step, at + step):\n"
        "    column.set({name: value})\n"
        "    seen.append(column.get(*outputs))\n"
        "print(json.dumps([found, [(b - a) / (2.0 * step) for a, b in zip(*seen)]]))"
    )
    found, differences = (np.array(part) for part in json.loads(run(sys.executable, "-c", script, native)))
    size = np.abs(differences) + 1e-6 * np.max(np.abs(differences))
    assert np.max(np.abs(differences)) > 1.0
    assert np.max(np.abs(found - differences) / size) < least, (found, differences)


def test_status_is_answered(native: Path) -> None:
    script = PRELUDE + (
        "column = rocking()\n"
        "dll, c = column.fmi.dll, column.fmi.component\n"
        "status, time, flag, text = fmi2Status(), fmi2Real(), fmi2Boolean(), fmi2String()\n"
        "column.attempt('step', 0.0, 0.1)\n"
        "print(dll.fmi2GetStatus(c, 0, ctypes.byref(status)), status.value)\n"
        "print(dll.fmi2GetRealStatus(c, 2, ctypes.byref(time)), round(time.value, 9))\n"
        "print(dll.fmi2GetBooleanStatus(c, 3, ctypes.byref(flag)), flag.value)\n"
        "print(dll.fmi2GetStringStatus(c, 1, ctypes.byref(text)), text.value)\n"
        "print(dll.fmi2CancelStep(c))\n"
    )
    lines = [line for line in run(sys.executable, "-c", script, native).splitlines() if line[0] != "["]
    assert lines == ["0 2", "0 0.6", "0 0", "0 b''", "3"]


# --- faults


WRONG_CALLS = [
    ("fresh()", "'get', 'block[1].ux'", "error", "outputs can be read from initialization on"),
    ("fresh()", "'step', 0.0, 0.1", "discard", "the slave is not initialized"),
    ("fresh()", "'setupExperiment', None, nan", "error", "start time = nan: must be a finite time"),
    ("fresh()", "'exitInitializationMode'", "error", "not in the state instantiated"),
    ("fresh()", "'terminate'", "error", "not in the state instantiated"),
    ("fresh()", "'getReal', [4294967295]", "error", "is not that of a Real variable"),
    ("fresh()", "'setReal', [100000], [1.0]", "error", "value reference 100000: is not an input or a parameter"),
    ("fresh()", "'set', {'block[1].ux': 1.0}", "error", "is not an input or a parameter"),
    ("fresh()", "'set', {'base.record': 'x' * 300}", "error", "base.record: must be a text of less than 256 bytes"),
    ("started()", "'enterInitializationMode'", "error", "not in the state stepping"),
    ("started()", "'setupExperiment'", "error", "not in the state stepping"),
    ("started()", "'set', {'block[1].mass': 1.0}", "error", "block[1].mass: can be set before the end"),
    ("started()", "'step', 0.1, 0.0", "discard", "the step must be a positive time"),
    ("started()", "'step', 0.05, 0.1", "discard", "the last step ended at t = 0.1 s"),
    ("ended()", "'step', 0.1, 0.1", "discard", "the run is terminated"),
    ("ended()", "'set', {'base.ax': 1.0}", "error", "nothing can be set, the run is terminated"),
]
WRONG_VALUES = [
    ({"block[1].height": -1.0}, "block[1].height = -1.0: must be a positive length in m"),
    ({"joint[2].stiffness": 0.0}, "joint[2].stiffness = 0.0: must be a positive"),
    ({"block[3].mass": float("nan")}, "block[3].mass = nan: must be a positive mass"),
    ({"block[2].centroid": 5.0}, "block[2].centroid = 5.0: must lie below the top face, height = 4.69 m"),
    ({"joint[1].width": 2.0}, "joint[1].width = 2.0: must not exceed the block's width = 1.56 m"),
    ({"solver.tolerance": 7.0}, "solver.tolerance = 7.0: must be a number from 1e-13 to 0.1"),
    ({"solver.integrator": "rk4"}, "solver.integrator = 'rk4': must be one of auto, central-difference"),
    ({"solver.without": "rest,  nothing"}, "solver.without = 'nothing': must be one of elastic, rest, dashpots"),
    ({"base.record": "some.csv"}, "base.record = 'some.csv': this FMU reads no files"),
    ({"solver.integrator": "central-difference", "solver.step": 0.01}, "solver.step = 0.01: must be at most"),
]

FAULTS = (
    LIVES
    + """
expected = usual(fresh())
for made, call in json.loads(sys.argv[2]):
    column = eval(made)
    heard = column.attempt(*eval(f"({call},)"))
    print(f"== {heard} {usual(column) == expected}")
for values in json.loads(sys.argv[3]):
    column = fresh()
    column.set(values)
    heard = column.attempt("initialize")
    print(f"== {heard} {usual(column) == expected}")
"""
)


def test_faults_are_told_and_the_instance_lives_on(native: Path) -> None:
    calls = json.dumps([(made, call) for made, call, _, _ in WRONG_CALLS])
    printed = run(sys.executable, "-c", FAULTS, native, calls, json.dumps([values for values, _ in WRONG_VALUES]))
    logged = printed.split("== ")
    told = [(status, said) for _, _, status, said in WRONG_CALLS] + [("error", said) for _, said in WRONG_VALUES]
    for (status, said), before, answer in zip(told, logged[:-1], logged[1:], strict=True):
        assert said in before, said
        assert f"({status})" in answer.splitlines()[0], said
        assert answer.splitlines()[0].endswith("True"), said


def test_the_stability_limit_is_that_of_the_solver(native: Path) -> None:
    for formulation in ("exact", "paper"):
        column = Column.from_toml(DAMPED).with_settings(integrator="central-difference", formulation=formulation)
        limit = longest_stable_step(column)
        script = (
            "import sys\nfrom instance import Instance\n"
            f"values = {{'solver.integrator': 'central-difference', 'solver.formulation': '{formulation}'}}\n"
            "for part in (1.0 - 1e-8, 1.0 + 3e-6):\n"
            "    column = Instance(sys.argv[1], initialize=False)\n"
            f"    column.set(values | {{'solver.step': part * {limit!r}}})\n"
            "    print(column.attempt('initialize'))"
        )
        lines = run(sys.executable, "-c", script, native).splitlines()
        assert lines[0] == "ok", lines  # measured: the two limits agree to 1e-9
        assert f"must be at most {limit:.4g} s" in lines[1]


def test_random_calls_never_break_an_instance(native: Path) -> None:
    done = finish(sys.executable, ROOT / "tests/random_calls.py", native, 5000)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.splitlines()[-1].startswith("5000 calls"), done.stdout[-500:]


# --- state

DRIVE = """
import json, sys
from math import sin
from pathlib import Path
from instance import Instance

def drive(column, first, last):
    for k in range(first, last):
        column.set({"base.ax": 1.5 * sin(0.06 * k), "base.az": 0.2 * sin(0.2 * k), "base.jx": 5.0 * sin(0.02 * k)})
        column.step(0.005 * k, 0.005)
    return [float(value).hex() for value in column.get()]
"""


def test_a_state_goes_on_here_and_in_another_process_with_the_same_bits(native: Path, tmp_path: Path) -> None:
    values = {"block[2].mass": 2e4, "joint[1].damping": 5e-3}
    here = DRIVE + (
        "column = Instance(sys.argv[1], json.loads(sys.argv[3]))\n"
        "drive(column, 0, 150)\n"
        "saved = column.fmi.getFMUState()\n"
        "Path(sys.argv[2]).write_bytes(column.fmi.serializeFMUstate(saved))\n"
        "first = drive(column, 150, 300)\n"
        "column.set({'joint[1].damping': 1e-2})\n"
        "drive(column, 300, 310)\n"
        "column.fmi.setFMUState(saved)\n"
        "print(drive(column, 150, 300) == first)\n"
        "print(first)"
    )
    there = DRIVE + (
        "column = Instance(sys.argv[1], initialize=False)\n"
        "column.fmi.setFMUState(column.fmi.deSerializeFMUstate(Path(sys.argv[2]).read_bytes()))\n"
        "print(drive(column, 150, 300))"
    )
    same, first = run(sys.executable, "-c", here, native, tmp_path / "state", json.dumps(values)).splitlines()
    assert same == "True"
    assert run(sys.executable, "-c", there, native, tmp_path / "state").strip() == first
    for change, said in (
        (lambda data: data[:-1] + bytes([data[-1] ^ 1]), "damaged"),
        (lambda data: data[:-8], "not all"),
        (lambda data: data.replace(b"{", b"("), "another column"),
        (lambda data: b"nonsense", "not those"),
    ):
        (tmp_path / "other").write_bytes(change((tmp_path / "state").read_bytes()))
        script = DRIVE + (
            "column = Instance(sys.argv[1])\n"
            "print(column.attempt('deSerializeFMUstate', Path(sys.argv[2]).read_bytes()))"
        )
        printed = run(sys.executable, "-c", script, native, tmp_path / "other")
        assert said in printed
        assert "(error)" in printed


# --- record


def test_a_record_inside_gives_the_numbers_of_the_pythonfmu(tmp_path: Path) -> None:
    time = 0.01 * np.arange(161)
    record = tmp_path / "pulse.csv"
    Motion.from_samples(0.01, 1.2 * np.sin(12.6 * time), 0.3 * np.cos(9.0 * time)).to_csv(record)
    pair = [Fmus.build(DAMPED, tmp_path / "native.fmu", *LINUX, "--record", record)]
    pair.append(Fmus.build(DAMPED, tmp_path / "python.fmu", "--record", record))
    script = (
        "import json, sys\nfrom instance import Instance\n"
        "def follow(fmu, values, h):\n"
        "    column = Instance(fmu, values)\n"
        "    seen = column.get()\n"
        "    for k in range(round(1.8 / h)):\n        column.step(k * h, h)\n        seen += column.get()\n"
        "    column.close()\n"
        "    return seen\n"
        "weaker = {'base.record_scale': 0.7, 'base.ax': 0.1}\n"
        "for values, h in (({}, 0.1), (weaker, 0.0075), ({'base.record': ''}, 0.1)):\n"
        "    print(follow(sys.argv[1], values, h) == follow(sys.argv[2], values, h))"
    )
    done = finish(sys.executable, "-c", script, *pair)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line for line in lines if line in ("True", "False")] == ["True"] * 3
    assert [line for line in lines if "the record's is 0.01 s" in line]


# --- life


def test_ten_thousand_lives_leave_nothing_behind(native: Path) -> None:
    if not Path("/proc/self/statm").exists():
        pytest.skip("no /proc to read the size of a process from")
    script = (
        "import sys\nfrom fmpy.fmi2 import fmi2CallbackFunctions\nfrom instance import Instance\nimport ctypes\n"
        "column = Instance(sys.argv[1])\n"
        "dll, callbacks = column.fmi.dll, column.fmi.callbacks\n"
        "guid = column.fmi.guid.encode()\n"
        "def resident():\n    return int(open('/proc/self/statm').read().split()[1]) * 4096\n"
        "state = ctypes.c_void_p()\n"
        "def live():\n"
        "    c = dll.fmi2Instantiate(b'column', 1, guid, b'', ctypes.byref(callbacks), 0, 0)\n"
        "    assert dll.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == 0\n"
        "    assert dll.fmi2EnterInitializationMode(c) == 0 and dll.fmi2ExitInitializationMode(c) == 0\n"
        "    assert dll.fmi2DoStep(c, 0.0, 0.01, 1) == 0\n"
        "    assert dll.fmi2GetFMUstate(c, ctypes.byref(state)) == 0\n"
        "    assert dll.fmi2FreeFMUstate(c, ctypes.byref(state)) == 0\n"
        "    dll.fmi2FreeInstance(c)\n"
        "for _ in range(100): live()\n"
        "before = resident()\n"
        "for _ in range(10000): live()\n"
        "print(resident() - before)"
    )
    assert int(run(sys.executable, "-c", script, native).splitlines()[-1]) < 1e6  # measured 0
