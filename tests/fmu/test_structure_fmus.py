"""FMUs of structures in space: their table, and runs under FMPy against `simulate`, in processes of their own."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import extract, read_model_description
from support.child import call, ended, returned
from support.fmus import REFUSED, ROOT, Fmus, c_host, run
from support.inside import steps
from support.inside import structures as inside

import build_fmu
from fmu_src.references import FAMILIES, FAMILY, REFERENCES
from fmu_src.structure_variables import structure_variables
from solver import Motion, simulate
from solver.kernels.structure import layout
from solver.models.outputs import places_of
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.model import Structure
from solver.models.structure.outputs import OUTPUTS

FOLDER = ROOT / "examples" / "structures"
TRILITH = FOLDER / "trilith.toml"
KEPT = Path(__file__).with_name("value_references_in_space.txt")
H, DURATION = 0.01, 2.0  # s


def shaking(duration: float = DURATION) -> np.ndarray:
    """Return the samples of three components every H s, that make the trilith rock, (rows, 3) m/s2."""
    t = H * np.arange(round(duration / H) + 1)
    ax, ay, az = 2.0 * np.sin(8.8 * t), 0.9 * np.sin(7.1 * t), 0.3 * np.sin(26.0 * t)
    return np.column_stack([ax, ay, az])


def motion_of(samples: np.ndarray) -> Motion:
    return Motion.from_samples(H, samples[:, 0], ay=samples[:, 1], az=samples[:, 2])


def followed(fmu: Path, folder: Path, values: dict[str, Any]) -> np.ndarray:
    """Return all outputs of an FMU after each step under `shaking`."""
    output = folder / f"{fmu.stem}.npy"
    call(inside.follow, fmu, shaking().tolist(), H, values, output)
    return np.load(output)


def test_value_references_never_change() -> None:
    """Compare with the file, which is added to, never changed."""
    kept = {name: int(number) for name, number in map(str.split, KEPT.read_text(encoding="utf-8").splitlines())}
    files = [FOLDER / f"{name}.toml" for name in ("colonnade", "statue-on-pendulums", "casks")]
    table = list(
        {item.name: item for file in files for item in structure_variables(Structure.from_toml(file))}.values()
    )
    found = {item.name: item.reference for item in table if "[" not in item.name or "[1]" in item.name}
    assert found == kept
    references = [item.reference for item in table]
    assert len(set(references)) == len(references)
    for item in table:
        owner, _, rest = item.name.partition("[")
        number, _, quantity = rest.partition("].")
        rule = FAMILY * FAMILIES[f"{owner}.{quantity}"] + int(number) if rest else REFERENCES[item.name]
        assert item.reference == rule, item.name


def test_fmpy_finds_no_problems(trilith: Path) -> None:
    assert "No problems found" in run("fmpy", "validate", trilith)


def test_agrees_with_a_run(trilith: Path, tmp_path: Path) -> None:
    """Compare histories and peaks of everything, under the same lines between the same samples."""
    seen = followed(trilith, tmp_path, {"solver.tolerance": 1e-8})
    structure = Structure.from_toml(TRILITH)
    response = simulate(structure, motion_of(shaking()), DURATION, tolerance=1e-8, output_step=H)
    size = response.rows.shape[1]
    largest = np.max(np.abs(response.rows), axis=0)
    assert np.all(largest[: 6 * structure.n] > 0.0)  # it moves in every direction
    apart = np.max(np.abs(seen[:, :size] - response.rows[1:]), axis=0)
    assert np.max(apart[largest > 0.0] / largest[largest > 0.0]) < 1e-6  # measured 2e-7, a twisting moment
    peaks = np.concatenate([response.peaks[output.field] for output in OUTPUTS])
    assert seen[-1, size : 2 * size] == pytest.approx(peaks, rel=1e-6)


@pytest.mark.long
def test_a_record_inside_is_followed_whatever_the_steps(tmp_path: Path, trilith: Path) -> None:
    """Follow steps that do not coincide with the samples, and the whole run at once; outputs at the end, by the
    tolerance.
    """
    motion = motion_of(shaking())
    motion.to_csv(tmp_path / "record.csv")
    values = {"base.record": str(tmp_path / "record.csv"), "base.record_scale": 0.8, "solver.tolerance": 1e-8}
    structure, ends = Structure.from_toml(TRILITH), []
    for h in (DURATION, DURATION / 7, 0.004):
        call(inside.simulate, trilith, DURATION, h, values, tmp_path / "out.npy")
        result = np.load(tmp_path / "out.npy")
        ends.append([result[f"block[{i}].{name}"][-1] for i in (1, 2, 3) for name in ("ux", "uy", "rz")])
    response = simulate(structure, motion.scaled(0.8), DURATION, tolerance=1e-8, output_step=DURATION)
    one = np.column_stack([response.ux[-1], response.uy[-1], response.rotation[-1, :, 2]]).ravel()
    largest = float(np.max(response.peaks["ux"]))
    assert np.max(np.abs(np.array(ends) - one)) < 1e-6 * largest


def test_states_parameters_and_reset(trilith: Path) -> None:
    found = call(inside.life, trilith)
    assert all(found.values()), found


def test_wrong_values_and_steps_are_refused_in_one_line(trilith: Path) -> None:
    done = ended(inside.refused, trilith)
    assert done.returncode == 0, done.stderr
    *answers, last = returned(done.stdout)
    assert [f"({REFUSED})" in answer for answer in answers[:4]] == [True] * 4
    assert all("status 2 (discard)" in answer for answer in answers[4:7])
    assert f"({REFUSED})" in answers[7]
    assert last == "ok"
    lines = done.stderr.strip().splitlines()
    reasons = [
        "joints.damping_scale = -1.0: must be a factor from 0 to 1e6",
        "solver.tolerance = 7.0: must be a number",
        "solver.without = 'peeks': must be one of peaks",
        "base.record_scale = nan: must be a finite number",
        "base.ay = inf: must be a finite number in m/s2",
        "larger than 1e6 (m/s2)",
        "larger than 1e6 (m/s2)",
        "the last step ended at t = 0.0 s",
    ]
    assert [reason for reason, line in zip(reasons, lines, strict=True) if reason not in line] == []


def test_a_fall_is_told_and_held(trilith: Path) -> None:
    standing, fallen, held = call(inside.fall, trilith)
    assert standing == [0, -1.0, 0, 2]  # at rest on a base that is still
    assert fallen[0] == 1
    assert 0.01 < fallen[1] < 5.01
    assert fallen[2:] == [3, 1]  # the beam
    assert held


def test_a_motion_in_a_plane_stays_in_it() -> None:
    """Check that it does exactly, until something pushes across."""
    structure = Structure.from_toml(FOLDER / "doric-in-space.toml")
    driven = DrivenStructure(structure, packed(structure), Chosen(1e-5))
    n = structure.n

    def uy(t: float, ay: float) -> np.ndarray:
        driven.drive(t, 3.0, ay, 0.0, 0.0, 0.0, 0.0)
        driven.advance(t, 0.3)
        return driven.observe(t + 0.3)[n : 2 * n].copy()

    assert not np.any(uy(0.0, 0.0))
    assert np.all(uy(0.3, 1e-3) != 0.0)
    assert np.all(uy(0.6, 0.0) != 0.0)


BOX = {"name": "a", "on": "base", "width": 0.4, "depth": 0.5, "height": 1.6, "density": 2400.0}
LAW = {"stiffness": 1e9, "damping": 2e-3, "friction": 0.5}


def driven_by(structure: Structure, chosen: Chosen, ax: np.ndarray, retuned: tuple[int, float] = (-1, 1.0)) -> Any:
    """Return the output rows under samples every H s; retuned: a step, and the factor on the damping from then on."""
    driven, rows = DrivenStructure(structure, packed(structure), chosen), []
    for k, (a, b) in enumerate(pairwise(ax)):
        if k == retuned[0]:
            driven.retune(chosen._replace(damping_scale=retuned[1]))
        driven.drive(H * k, a, 0.0, 0.0, (b - a) / H, 0.0, 0.0)
        driven.advance(H * k, H)
        rows.append(driven.observe(H * (k + 1)).copy())
    return np.array(rows)


def rocked(size: float, end: float, duration: float) -> np.ndarray:
    t = H * np.arange(round(duration / H) + 1)
    return size * 9.80665 * np.sin(2.6 * np.pi * t) * (t < end)


@pytest.mark.parametrize("scale", [0.0, 0.01])
def test_the_damping_scale_chooses_the_method_as_the_file_would(scale: float) -> None:
    """Compare with the run of a file with this damping: integrated as with the damping of the file it was 50 to 80
    tolerances off.
    """
    ax, law = rocked(0.2, 1.0, 4.0), LAW | {"damping": LAW["damping"] * scale}
    model = Structure.from_dict({"name": "box", "joints": law, "block": [BOX]})
    right = simulate(model, Motion.from_samples(H, ax), settle=0.0, output_step=H, tolerance=1e-9)
    structure = Structure.from_dict({"name": "box", "joints": LAW, "block": [BOX]})
    rows = driven_by(structure, Chosen(1e-4, damping_scale=scale), ax)
    error = np.max(np.abs(rows[:, 0] - right.ux[1:, 0])) / np.max(np.abs(right.ux))
    assert error < 0.2 * 1e-4  # measured 0.05 tolerances at most


@pytest.mark.parametrize("damping", [0.0, 1e-6, 2e-3])
@pytest.mark.parametrize("scale", [0.1, 100.0])
def test_the_damping_scale_gives_the_joints_of_a_file_with_this_damping(damping: float, scale: float) -> None:
    """Compare bit for bit: what sliding needs in addition is not scaled."""
    models = []
    for law, factor in ((damping, scale), (damping * scale, 1.0)):
        text = {"name": "box", "joints": LAW | {"damping": law}, "block": [BOX]}
        structure = Structure.from_dict(text)
        driven = DrivenStructure(structure, packed(structure), Chosen(1e-4, damping_scale=factor))
        made = layout.MODEL.see(driven.arrays.model, driven.sizes)
        models.append((made.joints.damping[0], made.joints.shear_damping[0], made.settings.order))
    assert models[0] == models[1]
    assert models[0][1] >= made.settings.relaxation > 0.0


def test_a_larger_damping_during_a_run_bounds_the_steps() -> None:
    """Compare forces with those at a fine tolerance: with the bound of the damping before they were 25 % off."""
    drums = {"name": "d", "shape": "drum", "repeat": 2, "on": "base", "diameter": 0.6, "height": 0.9, "density": 2400.0}
    structure = Structure.from_dict({"name": "drums", "joints": LAW | {"friction": 0.4}, "block": [drums]})
    ax, place = rocked(0.5, 2.0, 2.0), places_of(OUTPUTS, structure.sizes)["Tx"]
    for before, after in ((0.1, 10.0), (1.0, 10.0)):
        rows = [
            driven_by(structure, Chosen(tolerance, damping_scale=before), ax, (50, after))[50:, place]
            for tolerance in (1e-3, 1e-7)
        ]
        assert np.max(np.abs(rows[0] - rows[1])) < 0.02 * np.max(np.abs(rows[1]))  # measured 0.5 %


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("height = 4.0", "height = -4.0"), "block[1].height = -4.0: must be a positive length in m"),
        (("at = [1.5, 0.0]", "at = [4.5, 0.0]"), "block"),
        (('on = "base"', 'on = "bases"'), "block[1].on = 'bases': must be one of base"),
    ],
)
def test_a_wrong_file_ends_the_build_with_2_and_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str], said: str
) -> None:
    file = tmp_path / "structure.toml"
    file.write_text(TRILITH.read_text().replace(*change, 1))
    assert build_fmu.main([str(file), "-o", str(tmp_path / "x.fmu")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"structure.toml: {said}" in line


def test_a_column_refuses_a_record_that_leaves_its_plane(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    motion_of(shaking(0.1)).to_csv(tmp_path / "record.csv")
    options = ["--record", str(tmp_path / "record.csv"), "-o", str(tmp_path / "x.fmu")]
    assert build_fmu.main(options) == 2
    assert "ay: a column moves in its plane" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["column", "structure"])
def test_steps_of_rounding_errors_leave_the_peaks(fmus: Fmus, trilith: Path, kind: str) -> None:
    """Follow each step by one of the length by which times differ that a master adds up."""
    fmu, values = trilith if kind == "structure" else fmus.damped, {"solver.tolerance": 1e-6}
    whole, cut = (np.array(call(steps.peaks, fmu, sliver, values)) for sliver in (0.0, 1e-16))
    assert np.max(whole) > 1e3
    assert cut == pytest.approx(whole, rel=1e-5, abs=1e-9)  # measured 2.1e-7; 0.28 before


@pytest.mark.long  # builds native FMUs
def test_the_native_fmu_has_the_same_bits(trilith: Path, native_trilith: Path, tmp_path: Path) -> None:
    for values in ({}, {"joints.damping_scale": 0.0, "solver.tolerance": 1e-8}, {"solver.without": "peaks"}):
        one, other = (followed(fmu, tmp_path, values) for fmu in (trilith, native_trilith))
        assert np.array_equal(one, other)
    found = call(inside.life, native_trilith)
    assert all(found.values()), found
    assert call(inside.fall, native_trilith) == call(inside.fall, trilith)


@pytest.mark.long
def test_a_host_in_c_runs_it(native_trilith: Path, tmp_path: Path) -> None:
    """Return to a saved and serialized state on its way; the displacement is that of a run."""
    guid = read_model_description(str(native_trilith)).guid
    library = Path(extract(str(native_trilith), unzipdir=tmp_path / "files")) / "binaries" / "linux64" / "trilith.so"
    once, again = map(float, run(c_host(tmp_path), library, "file:///nowhere", guid, "1", "10001").split())
    assert once == again
    pushed = Motion.from_samples(H, np.full(201, 0.5), hold=True)
    response = simulate(Structure.from_toml(TRILITH), pushed, DURATION, output_step=H)
    assert once == pytest.approx(response.ux[-1, 0], rel=1e-5)


@pytest.mark.long
def test_joints_that_slide(tmp_path: Path) -> None:
    """Compare the bits; and a run, which has other steps, by the error of both."""
    pytest.importorskip("ziglang", reason="needs the extra native")
    file = tmp_path / "slippery.toml"
    file.write_text(TRILITH.read_text().replace("friction = 0.7", "friction = 0.2"))
    python = Fmus.build(file, tmp_path / "python.fmu")
    native = Fmus.build(file, tmp_path / "native.fmu", "--native", "--platforms", "linux64")
    values = {"solver.tolerance": 1e-8}
    one, other = (followed(fmu, tmp_path, values) for fmu in (python, native))
    assert np.array_equal(one, other)
    structure = Structure.from_toml(file)
    response = simulate(structure, motion_of(shaking()), DURATION, tolerance=1e-8, output_step=H)
    assert np.max(response.slip) > 1e-3  # m
    apart = np.max(np.abs(one[:, : structure.n] - response.ux[1:]))
    assert apart < 1e-6 * np.max(response.peaks["ux"])  # measured 9e-9


@pytest.mark.long
def test_derivatives_of_outputs_of_the_native_fmu(native_trilith: Path) -> None:
    rates, differences = map(np.array, call(inside.rates, native_trilith))
    assert np.max(np.abs(rates - differences) / np.maximum(np.abs(differences), 1e-6)) < 1e-4  # measured 3e-6
    assert np.count_nonzero(differences) > 40


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    ["doric-in-space", pytest.param("colonnade", marks=pytest.mark.campaign), "statue-on-pendulums", "statue-mesh"],
)
def test_other_structures_have_the_same_bits(name: str, tmp_path: Path) -> None:
    """Round sections, ties that yield, many blocks, bearings, meshes; a scaled record; FMI 3.0 too of the first."""
    pytest.importorskip("ziglang", reason="needs the extra native")
    motion_of(shaking(0.5)).to_csv(tmp_path / "record.csv")
    record = ("--record", tmp_path / "record.csv")
    kinds = {"python": (), "native": ("--native", "--platforms", "linux64")}
    if name == "doric-in-space":
        kinds["third"] = ("--native", "--fmi", "3", "--platforms", "x86_64-linux")
    fmus = [
        Fmus.build(FOLDER / f"{name}.toml", tmp_path / f"{kind}.fmu", *options, *record)
        for kind, options in kinds.items()
    ]
    results = []
    for fmu in fmus:
        assert "No problems found" in run("fmpy", "validate", fmu)
        call(inside.simulate, fmu, 0.5, 0.007, {"base.record_scale": 0.8}, tmp_path / "out.npy")
        results.append(np.load(tmp_path / "out.npy", max_header_size=1_000_000))
    assert len(results[0]) > 60
    names = results[0].dtype.names or ()
    one, other = ([list(row) for row in found.tolist()] for found in results[:2])
    assert one == other
    of_blocks = [key for key in names if key.startswith("block[") and key.endswith("].ux")]
    if len(results) == 3:
        assert np.array_equal(results[2]["block.ux"], np.column_stack([results[0][key] for key in of_blocks]))
