"""The FMU under FMPy, every run in a process of its own, judged by exit code and by results."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from support.child import call, command, ended, returned
from support.fmus import DAMPED, PHOCAS, REFUSED, Fmus, read_results, run, stack_file
from support.inside import failures, runs
from support.inside import native as inside
from support.probe import G

import build_fmu
from solver import Column, Motion, simulate


def fmpy_run(
    tmp_path: Path,
    fmu: Path,
    duration: float,
    h: float,
    amplitude: float,
    frequency: float,
    start_values: dict[str, float | str] | None = None,
) -> np.ndarray:
    """Return the histories of a harmonic run under fmpy; fails unless the process ends with 0 and the run with its
    duration.
    """
    output = tmp_path / "result.npy"
    call(runs.simulate, fmu, duration, h, amplitude, frequency, output, start_values or {})
    result = np.load(output)
    assert result["time"][-1] == pytest.approx(duration, abs=1e-12)
    return result


def held_harmonic(duration: float, h: float, amplitude: float, frequency: float) -> Motion:
    """Return the samples that `runs.simulate` hands to the FMU."""
    time = h * np.arange(round(duration / h) + 1)
    return Motion.from_samples(h, amplitude * G * np.sin(2 * np.pi * frequency * time), hold=True)


def test_fmpy_finds_no_problems(fmus: Fmus) -> None:
    assert validate_fmu(str(fmus.damped)) == []


@pytest.mark.parametrize(
    ("n", "text"),
    [
        pytest.param(1, "g = 0.0\n", marks=pytest.mark.long),  # builds FMUs
        pytest.param(10, "", marks=pytest.mark.long),
        pytest.param(200, "", marks=pytest.mark.campaign),
    ],
)
def test_fmpy_finds_no_problems_with_other_columns(fmus: Fmus, tmp_path: Path, n: int, text: str) -> None:
    """Check it without weight too, where nothing gives nominals."""
    fmu = fmus.build(stack_file(tmp_path, n, text), tmp_path / "stack.fmu")
    assert "No problems found" in run("fmpy", "validate", fmu)


def test_declares_units_and_causality(fmus: Fmus) -> None:
    """Check units and causality; value_references.txt has the names, test_fmu_description.py the dependencies."""
    description = read_model_description(str(fmus.phocas))
    by_name = {variable.name: variable for variable in description.modelVariables}
    assert description.coSimulation.modelIdentifier == "phocas"
    units = {"ux": "m", "uz": "m", "theta": "rad", "N": "N", "M": "N.m", "S": "N", "T": "N", "sigma_max": "Pa"}
    for name, variable in by_name.items():
        owner, _, key = name.rpartition(".")
        if owner.startswith(("block", "joint")) and key in (*units, "contact"):
            assert (variable.causality, variable.unit or "") == ("output", units.get(key, "")), name
        elif owner.startswith(("block", "joint")) and not key.endswith(("_peak", "_least", "slip")):
            assert variable.causality == "parameter", name
    assert {by_name[name].unit for name in ("base.Fx", "base.Fz")} == {"N"}
    assert by_name["overturned"].type == "Boolean"
    assert by_name["base.ax"].causality == by_name["base.az"].causality == "input"
    assert float(by_name["joint[1].stiffness"].start) == 533 * 9.80665e6


@pytest.mark.long  # takes seconds
def test_agrees_with_python_on_the_same_held_samples(fmus: Fmus, tmp_path: Path) -> None:
    result = fmpy_run(tmp_path, fmus.damped, 20.0, 1e-3, 0.05, 2.0, {"solver.tolerance": 1e-8})
    column = Column.from_toml(DAMPED)
    response = simulate(column, held_harmonic(20.0, 1e-3, 0.05, 2.0), 20.0, tolerance=1e-8, output_step=1e-3)
    compared = [one for one in response.outputs if one.owner in ("block", "joint", "base") and not one.only_peak]
    assert len(compared) == 13
    for output in compared:
        for i, history in enumerate(getattr(response, output.field).T.reshape(-1, len(response.time)), start=1):
            difference, most = np.max(np.abs(result[output.name_of(i)] - history)), np.max(np.abs(history))
            print(f"{output.name_of(i)}: {difference:.1e} of {most:.1e}")
            # measured 2e-14 or, by the machine code of another processor, 2e-11 (ux) to 4e-10 (M)
            assert difference <= (2e-10 if output.field == "ux" else 4e-9) * most, output.name_of(i)
    assert not result["overturned"].any()


@pytest.mark.parametrize("solver", [{"tolerance": 1e-6}, {"tolerance": 1e-6, "step": 2e-4}], ids=["exact", "paper"])
def test_start_values_change_the_column(fmus: Fmus, tmp_path: Path, solver: dict[str, float]) -> None:
    file, fmu = (PHOCAS, fmus.phocas) if "step" in solver else (DAMPED, fmus.damped)
    changes: dict[str, float | str] = {
        "block[1].height": 3.0,
        "block[2].mass": 3e4,
        "joint[3].width": 1.2,
        "joint[2].damping": 2e-3,
        "g": 9.0,
    }
    changes |= {f"solver.{name}": value for name, value in solver.items()}
    result = fmpy_run(tmp_path, fmu, 1.0, 1e-2, 0.02, 2.0, changes)
    data = Column.from_toml(file).to_dict()
    data["g"] = 9.0
    data["block"][0]["height"] = 3.0
    data["block"][1]["mass"] = 3e4
    data["block"][1]["joint"]["damping"] = 2e-3
    data["block"][2]["joint"]["width"] = 1.2
    data["solver"] |= solver
    response = simulate(Column.from_dict(data), held_harmonic(1.0, 1e-2, 0.02, 2.0), 1.0, output_step=1e-2)
    assert np.max(np.abs(result["block[1].ux"] - response.ux[:, 0])) < 1e-9 * response.peak_top_ux[0]  # measured 0


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


@pytest.mark.parametrize("times", [1, pytest.param(10, marks=pytest.mark.long)])
def test_command_line_simulates_a_motion_file_and_exits_with_0_every_time(
    fmus: Fmus, tmp_path: Path, times: int
) -> None:
    h, duration = 0.005, 2.0
    motion = Motion.harmonic(0.05 * G, 2.0, duration)
    motion.to_csv(tmp_path / "motion.csv", step=h)

    def simulate_once(k: int) -> Path:
        output = tmp_path / f"out{k}.csv"
        options = ("--input-file", tmp_path / "motion.csv", "--output-interval", h, "--stop-time", duration)
        run("fmpy", "simulate", fmus.damped, *options, "--output-file", output)
        return output

    with ThreadPoolExecutor(2) as pool:  # without the clean exit 30-90 % of such processes abort
        outputs = list(pool.map(simulate_once, range(times)))
    texts = {output.read_text() for output in outputs}
    assert len(texts) == 1
    result = read_results(outputs[0])
    column = Column.from_toml(DAMPED)
    response = simulate(column, held_harmonic(duration, h, 0.05, 2.0), duration, output_step=h)
    assert np.max(np.abs(result["block[1].ux"] - response.ux[:, 0])) < 1e-5 * response.peak_top_ux[0]  # measured 3e-13


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("name", ["elcentro-1940-ns", "chi-chi-1999-tcu052-n"])
def test_recorded_motions_run_on_the_command_line(fmus: Fmus, tmp_path: Path, records: Path, name: str) -> None:
    interval = 0.005
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
    column = Column.from_toml(DAMPED)
    response = simulate(column, held, 3.0, output_step=interval)
    early = result["block[1].ux"][: response.time.size]
    assert np.max(np.abs(early - response.ux[:, 0])) < 1e-4 * response.peak_top_ux[0]  # measured 1e-9 at most
    assert 0.0 < np.max(np.abs(result["block[1].ux"])) < 14.07


@pytest.mark.long  # as of native FMUs
def test_a_free_name_becomes_an_identifier(tmp_path: Path) -> None:
    text = (DAMPED).read_text(encoding="utf-8")
    (tmp_path / "column.toml").write_text(text.replace('"phocas_damped"', '"my-doric 2"'), encoding="utf-8")
    printed = run(sys.executable, "-c", BUILD_THERE, tmp_path)
    assert printed.split() == ["my_doric_2.fmu"]
    fmu = tmp_path / "my_doric_2.fmu"
    description = read_model_description(str(fmu))
    assert (description.modelName, description.coSimulation.modelIdentifier) == ("my-doric 2", "my_doric_2")
    run("fmpy", "simulate", fmu, "--stop-time", 0.02, "--output-interval", 0.01, "--output-file", tmp_path / "out.csv")
    assert len(read_results(tmp_path / "out.csv")["time"]) == 3


BUILD_THERE = "import os, sys; os.chdir(sys.argv[1]); import build_fmu; sys.exit(build_fmu.main(['column.toml']))"


@pytest.mark.long
def test_a_converted_record_gives_what_the_record_itself_gives(fmus: Fmus, tmp_path: Path) -> None:
    interval, duration = 0.005, 3.0
    time = 0.02 * np.arange(151)
    motion = Motion.from_samples(0.02, 0.35 * G * np.sin(2.0 * np.pi * (1.0 + 0.4 * time) * time))
    motion.to_csv(tmp_path / "record.csv")
    run(sys.executable, "-m", "solver", "convert", tmp_path / "record.csv", tmp_path / "motion.csv")
    options = ("--input-file", tmp_path / "motion.csv", "--output-interval", interval, "--stop-time", duration)
    run("fmpy", "simulate", fmus.damped, *options, "--output-file", tmp_path / "out.csv")
    result = read_results(tmp_path / "out.csv")
    column = Column.from_toml(DAMPED)
    response = simulate(column, motion, duration, output_step=interval)
    error = np.max(np.abs(result["block[1].ux"] - response.ux[:, 0])) / response.peak_top_ux[0]
    assert error < 1e-3  # 6e-5 measured; 4e-2 without slopes


WRONG_VALUES = [
    ("block[1].height", -1.0, "block[1].height = -1.0: must be a positive length in m"),
    ("joint[2].stiffness", 0.0, "joint[2].stiffness = 0.0: must be a positive"),
    ("block[3].mass", float("nan"), "block[3].mass = nan: must be a positive mass"),
    ("base.record_scale", float("nan"), "base.record_scale = nan: must be a finite number"),
    ("solver.tolerance", 7.0, "solver.tolerance = 7.0: must be"),
]


def test_a_wrong_parameter_is_refused_in_one_line_and_the_instance_lives_on(fmus: Fmus) -> None:
    done = ended(failures.wrong_values, fmus.damped, [(name, value) for name, value, _ in WRONG_VALUES])
    assert done.returncode == 0, done.stderr
    lines = done.stderr.strip().splitlines()
    for (_, _, said), (refused, accepted, stepped), line in zip(
        WRONG_VALUES, returned(done.stdout), lines, strict=True
    ):
        assert "fmi2ExitInitializationMode failed" in refused
        assert (accepted, stepped) == ("ok", "ok")
        assert said in line


def test_impossible_steps_are_refused_with_a_reason_and_possible_ones_still_work(fmus: Fmus) -> None:
    done = ended(failures.impossible_steps, fmus.damped)
    assert done.returncode == 0, done.stderr
    first, *refused, last = returned(done.stdout)
    assert (first, last) == ("ok", "ok")
    assert len(refused) == 5
    assert all(f"({REFUSED})" in answer for answer in refused[:4])
    assert "status 2 (discard)" in refused[4]  # another input may do
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 5
    for line, reason in zip(
        lines, ("positive time", "positive time", "last step ended", "positive time", "base.ax = inf"), strict=True
    ):
        assert reason in line


def test_shear_and_reaction_follow_the_input_of_the_same_instant(fmus: Fmus) -> None:
    still, pushed = call(failures.instant, fmus.damped)
    assert still[:3] == pushed[:3]
    assert pushed[3] < still[3] - 5e3  # N at 1 m/s2; the effective mass at rest measured 8211 kg
    assert pushed[3] == pushed[4]
    assert pushed[5] != still[5]


@pytest.mark.long
def test_the_same_input_builds_the_same_bytes_with_the_date_that_is_given(fmus: Fmus, tmp_path: Path) -> None:
    one, other = (
        fmus.build(PHOCAS, tmp_path / f"{name}.fmu", SOURCE_DATE_EPOCH="1700000000") for name in ("once", "again")
    )
    assert one.read_bytes() == other.read_bytes()
    assert read_model_description(str(one)).generationDateAndTime == "2023-11-14T22:13:20Z"


def test_without_a_writable_cache_it_works(fmus: Fmus, tmp_path: Path) -> None:
    blocked = tmp_path / "blocked"
    blocked.write_text("a file where a folder should be")
    output = tmp_path / "result.npy"
    elsewhere = {"XDG_CACHE_HOME": str(blocked)}
    run(*command(runs.simulate, fmus.damped, 0.1, 1e-2, 0.05, 2.0, output, {}), **elsewhere)
    assert np.load(output)["time"][-1] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text.replace("4.69", "-4.69", 1), "block[1].height = -4.69: must be a positive length in m"),
        (lambda text: text.replace("stiffness", "stifness"), "stifness"),
        (lambda text: text.replace('"phocas_damped"', '"not/a name"'), "not/a name"),
        (lambda text: text + "[", "column.toml"),
    ],
)
def test_a_wrong_column_file_ends_the_build_with_2_and_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: Callable[[str], str], said: str
) -> None:
    column = tmp_path / "column.toml"
    column.write_text(change(DAMPED.read_text()))
    assert build_fmu.main([str(column), "-o", str(tmp_path / "x.fmu")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert not (tmp_path / "x.fmu").exists()


@pytest.mark.long
def test_the_native_fmu_has_the_same_bits(fmus: Fmus, native: Path) -> None:
    """Compare it as built, and of a column off its axis that slides; test_native.py compares others."""
    values = [{}, {"joint[1].offset": 0.1, "joint[2].inclination": 0.01, "joint[1].friction": 0.4}]
    values += [{"joint[1].rim": 0.05, "joint[3].rim": 0.2, "joint[1].friction": 0.3}]
    for same, apart in call(inside.compare, native, fmus.damped, values):
        assert same, apart
