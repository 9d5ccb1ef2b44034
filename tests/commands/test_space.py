"""A column's file as a structure in space: --space, and structure = FILE of a study."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.fmus import ROOT

from fmu_src.body import StructureBody, body_of, read_body
from multiblock import Column, InputError, Structure, Study, simulate
from solver.commands.command_line import main
from solver.common.files import toml_of
from solver.studies.pictures import caption

COLUMNS = ROOT / "examples" / "columns"
STORAGE = COLUMNS / "storage.toml"
RECORD = "time,base.ax\n0,0\n0.4,2\n0.8,0\n"
STUDY = f"""
name = "stack"
kind = "montecarlo"
structure = "{STORAGE.as_posix()}"
samples = 2
tolerance = 1e-3
[[motion]]
formula = "ricker"
frequency = 1.0
amplitude = 2.0
[grid]
"motion.direction" = [0.7]
"""


@pytest.fixture
def record(tmp_path: Path) -> str:
    path = tmp_path / "record.csv"
    path.write_text(RECORD)
    return str(path)


def test_a_column_under_two_components(record: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["simulate", str(STORAGE), record, "--across", record, "--no-check", "--settle", "0"]
    assert main(given) == 2
    err = capsys.readouterr().err
    assert "a column moves in its plane" in err
    assert "--space" in err
    assert err.count("\n") == 1
    table = tmp_path / "response.csv"
    assert main([*given, "--space", "-o", str(table)]) == 0
    rows = np.genfromtxt(table, delimiter=",", names=True, deletechars="")
    assert np.max(np.abs(rows["block[block1].uy"])) > 0.1 * np.max(np.abs(rows["block[block1].ux"])) > 0.0


def test_names_of_joints_are_printed_in_full(record: str, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["simulate", str(COLUMNS / "doric.toml"), record, "--space", "--no-check", "--settle", "0"]
    assert main([*given, "--duration", "0.05"]) == 0
    lines = capsys.readouterr().out.splitlines()
    (head,) = (k for k, line in enumerate(lines) if line.startswith("joint "))
    assert [line.split()[0] for line in lines[head + 10 : head + 13]] == [
        *("block10-block11", "block11-block12", "block12-base")
    ]
    assert len({len(line) for line in lines[head : head + 13]}) == 1


def test_modes_without_weight_are_refused_as_in_the_plane(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "light.toml"
    file.write_text("g = 0.0\n" + STORAGE.read_text(encoding="utf-8"), encoding="utf-8")
    said = []
    for space in ((), ("--space",)):
        assert main(["modes", str(file), *space]) == 2
        said.append(capsys.readouterr().err)
    assert "light.toml: g = 0.0: must be positive for joints that are in contact at rest" in said[0]
    assert said[0] == said[1]


@pytest.mark.long  # takes seconds
def test_check_modes_and_statics(record: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["modes", str(STORAGE), "--space"]) == 0
    assert "12 of 18 modes" in capsys.readouterr().out
    assert main(["statics", str(STORAGE), "--space", "--direction", "90"]) == 0
    assert "towards 90 degrees" in capsys.readouterr().out
    given = ["check", str(STORAGE), record, "--across", record, "--no-margin", "--ensemble", "2"]
    for space in ([], ["--space"]):  # two components need it
        assert main([*given, *space]) == 0
        assert "of 2 varied structures" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("file", "options", "message"),
    [
        ("statue", [], "block[1]: must stand on its axis"),
        ("phocas", [], "solver.formulation = paper"),
        ("storage", ["--plane", "auto"], "not allowed with argument --plane"),
        ("storage", ["--step", "0.1"], "--step: must be left out"),
    ],
)
def test_what_has_no_such_form(
    file: str, options: list[str], message: str, record: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", str(COLUMNS / f"{file}.toml"), record, *options, "--space"]) == 2
    assert message in capsys.readouterr().err


def test_a_column_needs_no_plane(record: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(STORAGE), record, "--plane", "auto"]) == 2
    assert "--plane auto: must be left out, a column is solved in its plane" in capsys.readouterr().err


def test_a_stack_is_read_and_written() -> None:
    column = Column.from_toml(STORAGE)
    for made in (Structure.from_toml(STORAGE), Structure.from_dict(column.in_space().to_dict())):
        assert made.is_stack
        assert np.array_equal(made.model.numbers, column.in_space().model.numbers)
    changed = column.in_space().with_settings(tolerance=1e-3)
    assert Structure.from_dict(changed.to_dict()).tolerance == 1e-3
    with pytest.raises(InputError, match="name: unknown key"):
        Structure.from_dict({"column": toml_of(STORAGE), "name": "other"})


def test_an_fmu_carries_it() -> None:
    body = read_body(STORAGE, space=True)
    assert isinstance(body, StructureBody)
    again = body_of(body.text)
    assert isinstance(again, StructureBody)
    assert again.model.names == ("block1", "block2", "block3")
    assert np.array_equal(again.packed, body.packed)


def test_a_study_varies_the_numbers_of_the_columns_file(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(
        STUDY + '[random."block[1].height"]\ndistribution = "uniform"\nlow = 0.9\nhigh = 1.1\nrelative = true\n'
    )
    study = Study.from_toml(path)
    planned = study.run(1)
    factor = planned.values["block[1].height"]
    column = Column.from_toml(STORAGE)
    top = planned.run.model.blocks[0]
    assert np.ptp(top.corners[:, 2]) == pytest.approx(factor * column.blocks[0].height)
    assert math.hypot(*planned.run.motion.ay.shape) > 0.0
    run = planned.run
    assert simulate(run.model, run.motion, settle=0).peaks["uy"].max() > 0.0


def test_joints_of_a_stack_have_the_law_of_structures() -> None:
    stack = Structure.from_toml(STORAGE)
    found = stack.kind.with_numbers(
        stack, {"column.size": (2.0, False), "joint.shear_ratio": (0.3, False), "joint[2].damping": (2.0, True)}
    )
    assert isinstance(found, Structure)
    assert [joint.bed.shear_ratio for joint in found.joints] == [0.3, 0.3, 0.3]
    assert found.joints[1].bed.damping == 2.0 * stack.joints[1].bed.damping
    assert found.blocks[0].mass == pytest.approx(8.0 * stack.blocks[0].mass)


def test_names_of_a_study_of_a_stack(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(STUDY + '[random."structure.size"]\ndistribution = "uniform"\nlow = 0.9\nhigh = 1.1\n')
    with pytest.raises(InputError, match=r"structure\.size: unknown name, must be of the column"):
        Study.from_toml(path)


def test_a_study_is_shown(tmp_path: Path) -> None:
    from multiblock import run_study

    path = tmp_path / "study.toml"
    path.write_text(
        STUDY + '[random."joint.stiffness"]\ndistribution = "uniform"\nlow = 0.9\nhigh = 1.1\nrelative = true\n'
    )
    results = run_study(Study.from_toml(path), threads=1)
    assert results["peak_u"].shape == (2, 3)
    assert "storage (3 blocks)" in caption(results)[0]
    assert "in space" in caption(results)[-1]


@pytest.mark.parametrize("name", ["columns/mortar", "structures/trilith", "structures/showcase"])
def test_a_run_without_peaks_is_summed_up_without_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    """Simulate a model that leaves out peaks: displacements, hits and the verdict are printed, no forces of joints."""
    file, motion = tmp_path / "model.toml", tmp_path / "motion.csv"
    text = (ROOT / "examples" / f"{name}.toml").read_text(encoding="utf-8")
    given = '[solver]\nwithout = ["peaks"]\n'
    file.write_text(text.replace("[solver]\n", given) if "[solver]" in text else text.replace("\n[", f"\n{given}[", 1))
    motion.write_text(RECORD)
    assert main(["simulate", str(file), str(motion), "--settle", "0"]) == 0
    shown = capsys.readouterr().out
    assert "peak |ux| (mm)" in shown
    assert "peak N" not in shown
