"""The FMU without Python: the same numbers as the PythonFMU, and what only it can do."""

from __future__ import annotations

import math
import re
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from support.child import call, command, ended, returned
from support.fmus import DAMPED, LINUX, PHOCAS, ROOT, Fmus, finish, run
from support.inside import failures, inputs, states
from support.inside import native as inside

from solver import Motion

pytestmark = pytest.mark.long  # builds native FMUs

UNDAMPED: dict[str, object] = {f"joint[{i}].damping": 0.0 for i in (1, 2, 3)}


def stack(folder: Path, n: int, joint: str) -> Path:
    """Return a column of n blocks, no two alike, 14 m high; one FMU of each sort would be too many to name by hand."""
    blocks = "".join(
        f"[[block]]\nheight = {14.0 / n * (0.8 + 0.4 * (k % 3) / 2)}\nwidth = {1.5 + 0.02 * (k % 5)}\ndepth = 1.5\n"
        "density = 2400.0\n"
        for k in range(n)
    )
    path = folder / f"stack{n}.toml"
    path.write_text(f'name = "stack{n}"\n{blocks}[joint]\nstiffness = 4e9\n{joint}\n')
    return path


def compare(first: Path, second: Path, *values: dict[str, object]) -> list[tuple[bool, float]]:
    """Return for each set of start values whether all outputs have the same bits, and how far they are apart."""
    return [(same, apart) for same, apart in call(inside.compare, first, second, values)]


def test_three_blocks_give_the_numbers_of_the_pythonfmu(fmus: Fmus, native: Path) -> None:
    results = compare(
        native,
        fmus.damped,
        {"push": 0.05},
        {"solver.tolerance": 1e-9, "joint[2].damping": 2e-2},
        {"block[1].mass": 2e4, "block[2].centroid": 2.0, "block[3].inertia": 1e5, "joint[3].width": 1.2, "g": 9.0},
        {"solver.without": "elastic, dashpots", "joint[1].damping": 0.0},
        {"joint[1].offset": 0.1, "joint[2].inclination": 0.01, "block[1].tilt": -0.01, "joint[1].friction": 0.4},
        {"joint[1].rim": 0.05, "joint[3].rim": 0.2, "joint[1].friction": 0.4},
        UNDAMPED,
    )
    assert all(same for same, _ in results), results


def test_faces_of_other_shapes_and_sizes(tmp_path: Path) -> None:
    """Compare a square on a smaller drum on a plank, all of which slide; contact faces that become too large."""
    column = tmp_path / "mixed.toml"
    column.write_text(
        'name = "mixed"\njoint = {stiffness = 4e9, damping = 2e-3, friction = 0.3}\n'
        "[[block]]\nheight = 1.0\nwidth = 1.3\ndepth = 1.2\ndensity = 2600.0\n"
        '[[block]]\nsection = "annulus"\nheight = 1.0\ndiameter = 1.2\nbore = 0.4\ndensity = 2600.0\n'
        "[[block]]\nheight = 0.5\nwidth = 1.4\ndepth = 0.9\ndensity = 2600.0\n"
    )
    native = Fmus.build(column, tmp_path / "native.fmu", *LINUX)
    python = Fmus.build(column, tmp_path / "python.fmu")
    results = compare(
        native, python, {}, {"block[1].width": 1.0, "joint[2].offset": 0.05}, {"block[2].width": 1.1, "push": 0.5}
    )
    assert all(same for same, _ in results), results
    reason = "joint[2].width = 1.0: must not exceed that of the face below = 0.9 m"
    for fmu in (native, python):
        done = ended(failures.wrong_values, fmu, [("joint[2].width", 1.0)])
        assert reason in done.stdout + done.stderr, fmu


@pytest.mark.parametrize(("n", "joint"), [(1, "damping = 2e-3"), (50, "damping = 1e-2\nwidth = 1.2")])
def test_one_and_fifty_blocks(tmp_path: Path, n: int, joint: str) -> None:
    column = stack(tmp_path, n, joint)
    native = Fmus.build(column, tmp_path / "native.fmu", *LINUX)
    ((same, apart),) = compare(native, Fmus.build(column, tmp_path / "python.fmu"), {})
    assert same, apart


def test_joints_of_mortar(tmp_path: Path) -> None:
    """Compare through cracks, a joint that breaks and one that slides."""
    column = ROOT / "examples" / "columns" / "mortar.toml"
    native = Fmus.build(column, tmp_path / "native.fmu", *LINUX)
    python = Fmus.build(column, tmp_path / "python.fmu")
    results = compare(
        native,
        python,
        {"push": 3.0},
        {"push": 6.0, "joint[2].tensile_strength": 3e5, "joint[4].tensile_strength": 2e4},
        {"push": 8.0, "joint[1].tensile_strength": 1.0, "joint[3].cohesion": 1e3, "solver.tolerance": 1e-8},
        {"joint[2].offset": 0.15, "joint[3].cohesion": 0.0},
    )
    assert all(same for same, _ in results), results
    wrong = [
        (
            "joint[2].tensile_strength",
            0.0,
            "joint[2].tensile_strength = 0.0: must be at least 1 Pa and at most 1e12 Pa",
        ),
        ("joint[3].cohesion", -1.0, "joint[3].cohesion = -1.0: must be a shear stress in Pa"),
        (
            "joint[1].friction",
            0.0,
            "joint[1].cohesion = 150000.0: needs friction; a joint without friction never slides",
        ),
    ]
    for name, value, reason in wrong:
        for fmu in (native, python):
            done = ended(failures.wrong_values, fmu, [(name, value)])
            assert reason in done.stdout + done.stderr, (name, fmu)


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
def test_round_hollow_and_chipped_joints(tmp_path: Path) -> None:
    column = tmp_path / "drums.toml"
    column.write_text(
        'name = "drums"\njoint = {stiffness = 4e9, damping = 2e-3}\n'
        '[[block]]\nsection = "circle"\nheight = 4.0\ndiameter = 1.3\ntop_diameter = 1.1\ndensity = 2600.0\n'
        'joint = {section = "annulus", bore = 0.45}\n'
        '[[block]]\nsection = "annulus"\nheight = 4.0\ndiameter = 1.4\nbore = 0.4\ndensity = 2600.0\n'
        '[[block]]\nsection = "circle"\nheight = 4.0\ndiameter = 1.5\ndensity = 2600.0\n'
        'joint = {section = "strips", strips = [0.0, 1.2, 1.4, 1.2, 0.0]}\n'
    )
    native = Fmus.build(column, tmp_path / "native.fmu", *LINUX)
    python = Fmus.build(column, tmp_path / "python.fmu")
    results = compare(
        native,
        python,
        {},
        {"joint[3].width": 1.3, "block[2].mass": 9e3},
        {"block[1].width": 1.35, "block[1].height": 3.8, "block[3].inertia": 5e4, "block[2].centroid": 1.9},
        {"push": 0.5},
        {"joint[1].rim": 0.1, "joint[2].rim": 0.2, "joint[2].friction": 0.3},
    )
    assert all(same for same, _ in results), results
    wrong = [
        ("joint[1].rim", -0.1, "joint[1].rim = -0.1: must be a positive length in m, from 1e-6 to 1e6: the band along"),
        ("joint[3].rim", 0.1, 'joint[3].rim = 0.1: must be left out beside section = "strips", which says where'),
        ("block[2].width", 0.35, "block[2].bore = 0.4: must be less than the outer diameter = 0.35 m"),
        ("joint[1].width", 0.2, "joint[1].bore = 0.45: must be less than the outer diameter = 0.2 m"),
        ("joint[2].width", 0.4, "joint[2].bore = 0.4: must be less than the outer diameter = 0.4 m"),
        ("joint[1].friction", -0.5, "joint[1].friction = -0.5: must be a positive coefficient of friction"),
        ("joint[2].offset", math.nan, "joint[2].offset = nan: must be"),
        ("block[3].depth", 1.3, "joint[3].strips[2] = 1.4: must not exceed the block's depth = 1.3 m"),
        ("joint[2].dowel", 100.0, "joint[2].dowel = 100.0: needs friction; a joint without friction never slides"),
    ]
    for fmu in (native, python):
        done = ended(failures.wrong_values, fmu, [(name, value) for name, value, _ in wrong])
        for (_, _, reason), (refused, again, goes_on) in zip(wrong, returned(done.stdout), strict=True):
            assert reason in done.stdout + done.stderr, fmu
            assert "error" in refused
            assert (again, goes_on) == ("ok", "ok")


def test_joints_that_slide(fmus: Fmus, native: Path) -> None:
    """Set friction as a parameter: outputs, parameters and a state kept while a joint slides, in both FMUs."""
    results = compare(
        native,
        fmus.damped,
        {"joint[2].friction": 0.08},
        {"joint[1].friction": 0.1, "joint[1].dowel": 1e4, "joint[3].friction": 0.05, "joint[3].width": 1.3},
        {"joint[2].friction": 0.2, "push": 4.0},
    )
    assert all(same for same, _ in results), results
    values = {"joint[2].friction": 0.08, "joint[2].damping": 2e-3}
    found = [call(states.sliding, fmu, values) for fmu in (native, fmus.damped)]
    assert found[0] == found[1]
    assert found[0]["slid"] > 1e-3  # m, after the state was kept
    kept = [found[0][key] for key in ("at once", "further on", "elsewhere", "parameters elsewhere")]
    assert kept == [True] * 4


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
    """Check the words about `base.record`: the native one reads no files."""

    def variables(fmu: Path) -> str:
        with zipfile.ZipFile(fmu) as archive:
            text = archive.read("modelDescription.xml").decode()
        return text[text.index("<ModelVariables") :].replace(" />", "/>").replace("\n", "").replace("  ", "")

    def joined(text: str) -> str:
        return re.sub(
            r'(name="base.record"[^>]*?description=)"[^"]*"', r"\1", "".join(text.replace("\t", "").splitlines())
        )

    assert joined(variables(native)) == joined(variables(fmus.damped))


def test_command_line(native: Path, tmp_path: Path) -> None:
    Motion.harmonic(0.5, 2.0, 2.0).to_csv(tmp_path / "motion.csv", step=0.005)
    options = ("--input-file", tmp_path / "motion.csv", "--output-interval", 0.005, "--stop-time", 2.0)
    run("fmpy", "simulate", native, *options, "--output-file", tmp_path / "out.csv")
    assert (tmp_path / "out.csv").stat().st_size > 50_000


# --- what the PythonFMU cannot do


def test_input_derivatives_are_the_slopes_of_the_inputs(native: Path) -> None:
    same, statuses = call(inside.slopes, native)
    assert same
    shown = call(inputs.slopes, native)
    assert shown[1] == shown[2] != shown[0]  # a parameter that is set leaves them as they run
    assert statuses == [3, 3, 3, 0]


def test_output_derivatives_are_the_rates_of_the_outputs(native: Path) -> None:
    found, differences = np.array(call(inside.output_derivatives, native))
    sizes = np.abs(differences) + 1e-6 * np.max(np.abs(differences))
    assert np.max(np.abs(found - differences) / sizes) < 1e-3, (found, differences)


def test_directional_derivatives_are_the_effective_mass(native: Path) -> None:
    for found, differences in np.array(call(inside.by_acceleration, native)):
        size = np.max(np.abs(differences))
        assert size > 1e4
        assert np.max(np.abs(found - differences)) < 1e-10 * size, (found, differences)


@pytest.mark.parametrize(
    ("name", "step", "least"), [("alpha", 1.0, 1e-4), ("theta", 1e-8, 1e-3), ("omega", 1e-5, 1e-3)]
)
def test_directional_derivatives_by_the_rotation_of_the_base(
    native: Path, name: str, step: float, least: float
) -> None:
    """Compare with differences of what the instance shows; by alpha, in which it is linear, they round to 8e-6."""
    found, differences = np.array(call(inside.by_rotation, native, f"base.{name}", step))
    size = np.abs(differences) + 1e-6 * np.max(np.abs(differences))
    assert np.max(np.abs(differences)) > 1.0
    assert np.max(np.abs(found - differences) / size) < least, (found, differences)


def test_status_is_answered(native: Path) -> None:
    assert call(inside.status, native) == [[[0] * 4, 3, 0.6, 0, ""], 3]


# --- faults


WRONG_VALUES: list[tuple[dict[str, object], str]] = [
    ({"block[1].height": -1.0}, "block[1].height = -1.0: must be a positive length in m"),
    ({"joint[2].stiffness": 0.0}, "joint[2].stiffness = 0.0: must be a positive"),
    ({"block[3].mass": float("nan")}, "block[3].mass = nan: must be a positive mass"),
    ({"block[2].centroid": 5.0}, "block[2].centroid = 5.0: must lie below the top face, height = 4.69 m"),
    ({"joint[1].width": 2.0}, "joint[1].width = 2.0: must not exceed the block's width = 1.56 m"),
    (
        {"block[2].width": 1.0, "joint[1].width": 1.2},
        "joint[1].width = 1.2: must not exceed that of the face below = 1.0 m",
    ),
    ({"solver.tolerance": 7.0}, "solver.tolerance = 7.0: must be a number from 1e-13 to 0.1"),
    ({"solver.without": "rest,  nothing"}, "solver.without = 'nothing': must be one of elastic, rest, dashpots"),
    ({"base.record": "some.csv"}, "base.record = 'some.csv': this FMU reads no files"),
]


def test_faults_are_reported_and_the_instance_lives_on(native: Path) -> None:
    printed = run(*command(failures.native_answers, native, [values for values, _ in WRONG_VALUES]))
    expected = [reason for _, _, reason in failures.NATIVE] + [reason for _, reason in WRONG_VALUES]
    logged = printed.split("==\n")[:-1]
    for reason, entry, (heard, lives) in zip(expected, logged, returned(printed), strict=True):
        assert reason in entry, reason
        assert "(error)" in heard, reason
        assert lives, reason


def test_the_papers_formulation_is_refused_in_one_line(tmp_path: Path) -> None:
    done = finish(sys.executable, ROOT / "build_fmu.py", PHOCAS, "-o", tmp_path / "phocas.fmu", *LINUX)
    assert done.returncode == 2
    assert done.stderr.strip().endswith(f"--native: {PHOCAS} has solver.formulation = paper, must be exact")


def test_random_calls_never_break_an_instance(native: Path) -> None:
    done = finish(sys.executable, ROOT / "tests/support/random_calls.py", native, 5000)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.splitlines()[-1].startswith("5000 calls"), done.stdout[-500:]


# --- state


def test_a_state_goes_on_here_and_in_another_process_with_the_same_bits(native: Path, tmp_path: Path) -> None:
    values = {"block[2].mass": 2e4, "joint[1].damping": 5e-3}
    same, first = call(states.back_and_on, native, tmp_path / "state", values)
    assert same
    assert call(states.other_half, native, tmp_path / "state") == first
    for change, said in (
        (lambda data: data[:-1] + bytes([data[-1] ^ 1]), "damaged"),
        (lambda data: data[:-8], "not all"),
        (lambda data: data.replace(b"{", b"("), "another column"),
        (lambda data: b"nonsense", "not those"),
    ):
        (tmp_path / "other").write_bytes(change((tmp_path / "state").read_bytes()))
        printed = run(*command(states.unreadable, native, tmp_path / "other"))
        assert said in printed
        assert "(error)" in printed


# --- record


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
def test_a_record_inside_gives_the_numbers_of_the_pythonfmu(tmp_path: Path) -> None:
    time = 0.01 * np.arange(161)
    record = tmp_path / "pulse.csv"
    Motion.from_samples(0.01, 1.2 * np.sin(12.6 * time), 0.3 * np.cos(9.0 * time)).to_csv(record)
    pair = [Fmus.build(DAMPED, tmp_path / "native.fmu", *LINUX, "--record", record)]
    pair.append(Fmus.build(DAMPED, tmp_path / "python.fmu", "--record", record))
    weaker: dict[str, object] = {"base.record_scale": 0.7, "base.ax": 0.1}
    mixed: dict[str, object] = {"joint[1].damping": 0.0, "joint[2].damping": 5e-2, "joint[3].width": 1.2}
    cases: list[tuple[dict[str, object], float]] = [({}, 0.1), (weaker, 0.0075), ({"base.record": ""}, 0.1)]
    still: dict[str, object] = {"base.record_scale": 0.0, "base.ax": 0.1}
    cases += [(change, 0.0137) for change in (weaker, UNDAMPED, mixed, still)]
    for values, h in cases:  # the samples are 0.01 s apart: no step falls in with them
        first, second = (ended(inputs.whole_history, fmu, values, h) for fmu in pair)
        assert (first.returncode, second.returncode) == (0, 0), first.stderr + second.stderr
        assert returned(first.stdout) == returned(second.stdout)
        coarse = h > 0.01 and "base.record" not in values and values.get("base.record_scale") != 0.0
        for done in (first, second):
            assert ("the record's is 0.01 s" in done.stdout + done.stderr) == coarse
    for fmu in pair:
        done = ended(inputs.whole_history, fmu, {"base.record_scale": 1e6}, 0.1)
        assert done.returncode == 1
        assert "base.record_scale = 1000000" in done.stdout + done.stderr or "at most 1e6" in done.stdout + done.stderr


# --- life


def test_ten_thousand_lives_leave_nothing_behind(native: Path) -> None:
    if not Path("/proc/self/statm").exists():
        pytest.skip("no /proc to read the size of a process from")
    assert call(inside.left_behind, native) < 1e6  # measured 0
