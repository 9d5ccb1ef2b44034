"""The FMU under FMPy, every run in a process of its own, judged by exit code and by results."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmus import ROOT, Fmus, environment, read_results, run

from solver import Column, Motion, simulate

G = 9.80665

# Simulates argv[1] for argv[2] s at a communication step of argv[3] s under argv[4] g at argv[5] Hz, saves to argv[6].
SIMULATE = """
import json, sys
import numpy as np
from fmpy import simulate_fmu
fmu, duration, h, amplitude, frequency, output, start_values = sys.argv[1:]
duration, h = float(duration), float(h)
time = h * np.arange(round(duration / h) + 1)
motion = np.zeros(time.size, dtype=[("time", float), ("base.ax", float), ("base.az", float)])
motion["time"] = time
motion["base.ax"] = float(amplitude) * 9.80665 * np.sin(2 * np.pi * float(frequency) * time)
result = simulate_fmu(fmu, stop_time=duration, output_interval=h, input=motion, start_values=json.loads(start_values))
np.save(output, np.asarray(result))
"""


def fmpy_run(
    tmp_path: Path,
    fmu: Path,
    duration: float,
    h: float,
    amplitude: float,
    frequency: float,
    start_values: dict[str, float | str] | None = None,
) -> np.ndarray:
    """Histories of a harmonic run under fmpy; fails unless the process ends with 0 and the run with its duration."""
    output = tmp_path / "result.npy"
    values = json.dumps(start_values or {})
    run(sys.executable, "-c", SIMULATE, fmu, duration, h, amplitude, frequency, output, values)
    result = np.load(output)
    assert result["time"][-1] == pytest.approx(duration, abs=1e-12)
    return result


def held_harmonic(duration: float, h: float, amplitude: float, frequency: float) -> Motion:
    """The samples that SIMULATE hands to the FMU."""
    time = h * np.arange(round(duration / h) + 1)
    return Motion.from_samples(h, amplitude * G * np.sin(2 * np.pi * frequency * time), hold=True)


def test_fmpy_finds_no_problems_in_columns_of_1_3_and_200_blocks(fmus: Fmus, tmp_path: Path) -> None:
    block = "[[block]]\nheight = 1.0\nwidth = 1.0\ndepth = 1.0\ndensity = 2000.0\n"
    for n in (1, 200):
        column = tmp_path / f"stack{n}.toml"
        column.write_text(f'name = "stack{n}"\n' + block * n + "[joint]\nstiffness = 1e9\ndamping = 1e-3\n")
        fmu = fmus.build(column, tmp_path / f"stack{n}.fmu")
        assert "No problems found" in run("fmpy", "validate", fmu)
    assert "No problems found" in run("fmpy", "validate", fmus.phocas)


def test_declares_what_a_master_needs_to_know(fmus: Fmus) -> None:
    description = read_model_description(str(fmus.phocas))
    by_name = {variable.name: variable for variable in description.modelVariables}
    assert description.coSimulation.modelIdentifier == "phocas"
    assert description.coSimulation.needsExecutionTool is False
    for i in (1, 2, 3):
        for name, unit in (("ux", "m"), ("uz", "m"), ("theta", "rad")):
            variable = by_name[f"block[{i}].{name}"]
            assert (variable.causality, variable.unit) == ("output", unit)
        for name, unit in (("N", "N"), ("M", "N.m"), ("S", "N"), ("contact", ""), ("sigma_max", "Pa")):
            variable = by_name[f"joint[{i}].{name}"]
            assert (variable.causality, variable.unit or "") == ("output", unit)
        for name in ("height", "width", "depth", "mass", "centroid", "inertia"):
            assert by_name[f"block[{i}].{name}"].causality == "parameter"
        for name in ("stiffness", "damping", "width", "depth"):
            assert by_name[f"joint[{i}].{name}"].causality == "parameter"
    assert {by_name[name].unit for name in ("base.Fx", "base.Fz")} == {"N"}
    assert by_name["overturned"].type == "Boolean"
    assert by_name["base.ax"].causality == by_name["base.az"].causality == "input"
    assert float(by_name["joint[1].stiffness"].start) == 533 * 9.80665e6
    assert {name for name in by_name if name.startswith("solver.")} == {
        "solver.formulation",
        "solver.integrator",
        "solver.step",
        "solver.tolerance",
        "solver.without",
    }
    ax = by_name["base.ax"]
    feedthrough = {u.variable.name for u in description.outputs if ax in (u.dependencies or [])}
    assert feedthrough == {"joint[1].S", "joint[2].S", "joint[3].S", "base.Fx", "base.Fz", "base.My"}


def test_agrees_with_python_on_the_same_held_samples(fmus: Fmus, tmp_path: Path) -> None:
    result = fmpy_run(tmp_path, fmus.damped, 20.0, 1e-3, 0.05, 2.0, {"solver.tolerance": 1e-8})
    column = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml")
    response = simulate(column, held_harmonic(20.0, 1e-3, 0.05, 2.0), 20.0, tolerance=1e-8, output_step=1e-3)
    for i in (1, 2, 3):
        for owner, names in (("block", ("ux", "uz", "theta")), ("joint", ("N", "M", "S", "contact", "sigma_max"))):
            for name in names:
                history = getattr(response, name)[:, i - 1]
                difference = np.max(np.abs(result[f"{owner}[{i}].{name}"] - history)) / np.max(np.abs(history))
                assert difference < 1e-6, f"{owner}[{i}].{name}"  # measured 2e-14 (ux) to 3e-10 (S)
    for name in ("Fx", "Fz", "My"):
        history = getattr(response, name)
        assert np.max(np.abs(result[f"base.{name}"] - history)) < 1e-6 * np.max(np.abs(history))
    assert not result["overturned"].any()


def test_the_papers_example_agrees_with_python_while_it_can_be_predicted(fmus: Fmus, tmp_path: Path) -> None:
    result = fmpy_run(tmp_path, fmus.phocas, 2.0, 1e-3, 0.05, 2.0)
    column = Column.from_toml(ROOT / "examples/columns/phocas.toml")
    response = simulate(column, held_harmonic(2.0, 1e-3, 0.05, 2.0), 2.0, output_step=1e-3)
    assert np.max(np.abs(result["block[1].ux"] - response.ux[:, 0])) < 1e-9 * response.peak_ux[0]  # measured 0


def test_start_values_change_the_column(fmus: Fmus, tmp_path: Path) -> None:
    changes: dict[str, float | str] = {
        "block[1].height": 3.0,
        "block[2].mass": 3e4,
        "joint[3].width": 1.2,
        "joint[2].damping": 2e-3,
        "g": 9.0,
        "solver.formulation": "paper",
        "solver.integrator": "central-difference",
        "solver.step": 2e-4,
    }
    result = fmpy_run(tmp_path, fmus.damped, 1.0, 1e-2, 0.02, 2.0, changes)
    data = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml").to_dict()
    data["g"] = 9.0
    data["block"][0]["height"] = 3.0
    data["block"][1]["mass"] = 3e4
    data["block"][1]["joint"]["damping"] = 2e-3
    data["block"][2]["joint"]["width"] = 1.2
    data["solver"] |= {"formulation": "paper", "integrator": "central-difference", "step": 2e-4}
    response = simulate(Column.from_dict(data), held_harmonic(1.0, 1e-2, 0.02, 2.0), 1.0, output_step=1e-2)
    assert np.max(np.abs(result["block[1].ux"] - response.ux[:, 0])) < 1e-9 * response.peak_ux[0]  # measured 0


def test_an_overturned_column_is_held_and_flagged(fmus: Fmus, tmp_path: Path) -> None:
    result = fmpy_run(tmp_path, fmus.damped, 12.0, 1e-2, 0.1, 0.25)
    after = result[result["overturned"]]
    assert after.size > 100
    assert after["time"][0] - after["overturn_time"][0] <= 1e-2
    assert np.all(result["overturn_time"][~result["overturned"]] == -1.0)
    assert set(after["overturn_joint"]) <= {1, 2, 3}
    assert len(set(after["overturn_joint"])) == 1
    for name in (result.dtype.names or ())[1:]:
        assert np.all(np.isfinite(result[name]))
        assert np.all(after[name] == after[name][0])


def test_command_line_simulates_a_motion_file_and_exits_with_0_every_time(fmus: Fmus, tmp_path: Path) -> None:
    h, duration = 0.005, 2.0
    motion = Motion.harmonic(0.05 * G, 2.0, duration)
    motion.to_csv(tmp_path / "motion.csv", step=h)

    def simulate_once(k: int) -> Path:
        output = tmp_path / f"out{k}.csv"
        options = ("--input-file", tmp_path / "motion.csv", "--output-interval", h, "--stop-time", duration)
        run("fmpy", "simulate", fmus.damped, *options, "--output-file", output)
        return output

    with ThreadPoolExecutor(2) as pool:  # without the clean exit 30-90 % of such processes abort
        outputs = list(pool.map(simulate_once, range(10)))
    texts = {output.read_text() for output in outputs}
    assert len(texts) == 1
    result = read_results(outputs[0])
    column = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml")
    response = simulate(column, held_harmonic(duration, h, 0.05, 2.0), duration, output_step=h)
    assert np.max(np.abs(result["block[1].ux"] - response.ux[:, 0])) < 1e-5 * response.peak_ux[0]  # measured 3e-13


@pytest.mark.parametrize(
    ("name", "interval"),
    [
        ("elcentro-1940-ns", 0.005),
        ("northridge-1994-arleta-360", 0.005),
        ("kobe-1995-nishi-akashi-090", 0.005),
        ("cape-mendocino-1992-cpm000", 0.005),
        ("chi-chi-1999-tcu052-n", 0.005),
    ],
)
def test_recorded_motions_run_on_the_command_line(
    fmus: Fmus, tmp_path: Path, records: Path, name: str, interval: float
) -> None:
    motion = Motion.from_at2(records / f"{name}.AT2")
    motion.to_csv(tmp_path / "motion.csv")
    duration = round(motion.duration / interval) * interval
    options = ("--input-file", tmp_path / "motion.csv", "--output-interval", interval, "--stop-time", duration)
    run("fmpy", "simulate", fmus.damped, *options, "--output-file", tmp_path / "out.csv")
    result = read_results(tmp_path / "out.csv")
    assert result["time"][-1] == pytest.approx(duration, abs=1e-9)
    assert all(np.all(np.isfinite(history)) for history in result.values())
    # the same samples in Python, compared while both can be predicted: the first 3 s
    held = Motion.from_samples(interval, motion.acceleration(result["time"])[0], hold=True)
    column = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml")
    response = simulate(column, held, 3.0, output_step=interval)
    early = result["block[1].ux"][: response.time.size]
    assert np.max(np.abs(early - response.ux[:, 0])) < 1e-4 * response.peak_ux[0]  # measured 1e-9 at most
    assert 0.0 < np.max(np.abs(result["block[1].ux"])) < 14.07


SIDE_BY_SIDE = """
import json, sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

def slave(path, name):
    description = read_model_description(path)
    made = FMU2Slave(guid=description.guid, unzipDirectory=extract(path),
                     modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name)
    made.instantiate()
    made.setupExperiment(startTime=0.0)
    made.enterInitializationMode()
    made.exitInitializationMode()
    return made, {v.name: v.valueReference for v in description.modelVariables}

def step(pair, k):
    made, vr = pair
    made.setReal([vr["base.ax"]], [0.5 if k % 100 < 50 else -0.5])
    made.doStep(k * 1e-2, 1e-2)

def read(pair):
    made, vr = pair
    return made.getReal([vr[name] for name in ("block[1].ux", "joint[1].N", "base.My")])

paths = sys.argv[1:]
alone = []
for path in paths:
    pair = slave(path, "alone")
    for k in range(100):
        step(pair, k)
    alone.append(read(pair))
    pair[0].terminate()
    pair[0].freeInstance()
pairs = [slave(path, "together") for path in paths]
for k in range(100):
    for pair in pairs:
        step(pair, k)
together = [read(pair) for pair in pairs]
for made, _ in pairs:
    made.terminate()
    made.freeInstance()
print(json.dumps([alone, together]))
"""


def test_columns_in_one_process_do_not_run_each_others_code(fmus: Fmus, tmp_path: Path) -> None:
    text = (ROOT / "examples/columns/phocas-damped.toml").read_text()
    other = tmp_path / "other.toml"
    other.write_text(text.replace("27000.0", "20000.0"))  # the same name, another column
    second = fmus.build(other, tmp_path / "second.fmu")
    printed = run(sys.executable, "-c", SIDE_BY_SIDE, fmus.damped, second, fmus.phocas, fmus.damped)
    alone, together = json.loads(printed)
    assert alone == together
    assert alone[0] == alone[3]
    assert alone[0] != alone[1]


BY_HAND = """
import json, sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
description = read_model_description(sys.argv[1])
vr = {v.name: v.valueReference for v in description.modelVariables}
made = FMU2Slave(guid=description.guid, unzipDirectory=extract(sys.argv[1]),
                 modelIdentifier=description.coSimulation.modelIdentifier, instanceName="column")
made.instantiate()
heard = []

def attempt(call, *arguments):
    try:
        call(*arguments)
        return "ok"
    except Exception as error:
        return str(error)

def initialize():
    made.setupExperiment(startTime=0.0)
    made.enterInitializationMode()
    return attempt(made.exitInitializationMode)
"""


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("made.setReal([vr['block[1].height']], [-1.0])", "block[1].height = -1.0: must be a positive length in m"),
        ("made.setReal([vr['joint[2].stiffness']], [0.0])", "joint[2].stiffness = 0.0: must be a positive"),
        ("made.setReal([vr['block[3].mass']], [float('nan')])", "block[3].mass = nan: must be a positive mass"),
        ("made.setReal([vr['solver.tolerance']], [7.0])", "solver.tolerance = 7.0: must be"),
        ("made.setString([vr['solver.integrator']], ['rk4'])", "solver.integrator = 'rk4': must be one of"),
    ],
)
def test_a_wrong_parameter_is_refused_in_one_line_and_the_instance_lives_on(fmus: Fmus, call: str, said: str) -> None:
    script = BY_HAND + (
        f"{call}\nheard.append(initialize())\nmade.reset()\nheard.append(initialize())\n"
        "made.setReal([vr['base.ax']], [1.0])\n"
        "heard.append(attempt(made.doStep, 0.0, 1e-2))\nmade.terminate()\nmade.freeInstance()\nprint(json.dumps(heard))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, fmus.damped], capture_output=True, text=True, env=environment(), check=False
    )
    assert done.returncode == 0, done.stderr
    refused, accepted, stepped = json.loads(done.stdout)
    assert "fmi2ExitInitializationMode failed" in refused
    assert (accepted, stepped) == ("ok", "ok")
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_impossible_steps_are_discarded_with_a_reason_and_possible_ones_still_work(fmus: Fmus) -> None:
    script = BY_HAND + (
        "initialize()\n"
        "heard.append(attempt(made.doStep, 0.0, 1e-2))\n"
        "for t, h in ((1e-2, 0.0), (1e-2, -1e-2), (0.0, 1e-2), (1e-2, float('nan'))):\n"
        "    heard.append(attempt(made.doStep, t, h))\n"
        "made.setReal([vr['base.ax']], [float('inf')])\n"
        "heard.append(attempt(made.doStep, 1e-2, 1e-2))\n"
        "made.setReal([vr['base.ax']], [1.0])\n"
        "heard.append(attempt(made.doStep, 1e-2, 1e-2))\n"
        "made.freeInstance()\nprint(json.dumps(heard))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, fmus.damped], capture_output=True, text=True, env=environment(), check=False
    )
    assert done.returncode == 0, done.stderr
    first, *refused, last = json.loads(done.stdout)
    assert (first, last) == ("ok", "ok")
    assert len(refused) == 5
    assert all("status 2 (discard)" in answer for answer in refused)
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 5
    for line, reason in zip(
        lines, ("positive time", "positive time", "last step ended", "positive time", "base.ax = inf"), strict=True
    ):
        assert reason in line


def test_shear_and_reaction_follow_the_input_of_the_same_instant(fmus: Fmus) -> None:
    script = BY_HAND + (
        "initialize()\nmade.doStep(0.0, 1e-2)\n"
        "names = ['block[1].ux', 'joint[1].N', 'joint[3].M', 'joint[3].S', 'base.Fx', 'base.My']\n"
        "for ax in (0.0, 1.0):\n"
        "    made.setReal([vr['base.ax']], [ax])\n"
        "    heard.append(made.getReal([vr[name] for name in names]))\n"
        "made.freeInstance()\nprint(json.dumps(heard))"
    )
    still, pushed = json.loads(run(sys.executable, "-c", script, fmus.damped))
    assert still[:3] == pushed[:3]
    assert pushed[3] < still[3] - 5e3  # N at 1 m/s2; the effective mass at rest measured 8211 kg
    assert pushed[3] == pushed[4]
    assert pushed[5] != still[5]


def test_the_same_input_builds_the_same_bytes(fmus: Fmus, tmp_path: Path) -> None:
    again = fmus.build(ROOT / "examples/columns/phocas.toml", tmp_path / "again.fmu")
    assert again.read_bytes() == fmus.phocas.read_bytes()


def test_without_a_writable_cache_it_is_slower_but_works(fmus: Fmus, tmp_path: Path) -> None:
    blocked = tmp_path / "blocked"
    blocked.write_text("a file where a folder should be")
    output = tmp_path / "result.npy"
    command = [sys.executable, "-c", SIMULATE, fmus.damped, "0.1", "1e-2", "0.05", "2.0", output, "{}"]
    env = environment() | {"XDG_CACHE_HOME": str(blocked), "NUMBA_CACHE_DIR": str(blocked)}
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, env=env, check=False)
    assert done.returncode == 0, done.stderr
    assert np.load(output)["time"][-1] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text.replace("4.69", "-4.69", 1), "block[1].height = -4.69: must be a positive length in m"),
        (lambda text: text.replace("stiffness", "stifness"), "stifness"),
        (lambda text: text.replace('"phocas_damped"', '"not a name"'), "not a name"),
        (lambda text: text + "[", "column.toml"),
    ],
)
def test_a_wrong_column_file_ends_the_build_with_2_and_one_line(
    tmp_path: Path, change: Callable[[str], str], said: str
) -> None:
    column = tmp_path / "column.toml"
    column.write_text(change((ROOT / "examples/columns/phocas-damped.toml").read_text()))
    done = subprocess.run(
        [sys.executable, ROOT / "build_fmu.py", column, "-o", tmp_path / "x.fmu"],
        capture_output=True,
        text=True,
        env=environment(),
        check=False,
    )
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "x.fmu").exists()


def test_the_solver_needs_neither_pythonfmu_nor_fmpy_nor_matplotlib() -> None:
    script = "import sys, solver; print([m for m in ('pythonfmu', 'fmpy', 'matplotlib') if m in sys.modules])"
    assert run(sys.executable, "-c", script).strip() == "[]"
