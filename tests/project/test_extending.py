"""Every format, section, output, method and message is in all the places that docs/extending.md names.

A test fails with lines that begin with the file to change.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from support.fmus import COLUMNS, ROOT
from support.record_files import CASES

from fmu_src.native.table import REFUSALS
from fmu_src.structure_variables import structure_variables
from fmu_src.variables import variables
from multiblock import Block, Column, InputError, Joint, SolverError, Structure
from solver.ground import records
from solver.kernels.column.api.entries import lay_joint
from solver.kernels.column.model import description
from solver.kernels.column.sections.faces import (
    SECTIONS,
    FaceShape,
    across,
    common,
    deepest,
    face_of,
    lies_within,
)
from solver.kernels.column.sections.section import face
from solver.kernels.layout import spaces
from solver.kernels.structure import layout
from solver.models.column import outputs as of_column
from solver.models.column import packing
from solver.models.column.contact import BASE
from solver.models.column.stepper import REASONS, Stepper
from solver.models.outputs import BASE as OF_BASE
from solver.models.outputs import Output
from solver.models.structure import outputs as of_structure
from solver.plotting.scene.bodies import OUTLINES

PHOCAS = Column.from_toml(COLUMNS / "phocas-damped.toml")
RECORDS = ROOT / "solver" / "ground" / "records"
INTEGRATORS = ROOT / "solver" / "kernels" / "integrators"


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def modules_with(function: str, folder: Path) -> list[str]:
    """Return the names of the modules in a folder that define a function."""
    return sorted(file.stem for file in folder.glob("*.py") if f"\ndef {function}(" in file.read_text(encoding="utf-8"))


def test_files_named_here_are_in_the_recipes() -> None:
    page = text_of("docs/extending.md")
    path = r"[\"'](?:solver|fmu_src|tests|stress)/[\w/.]+\.(?:py|c|txt)(?=[:\"'])"
    named = {found[1:] for found in re.findall(path, text_of(__file__))}
    assert len(named) > 10
    assert [name for name in sorted(named) if f"`{name}`" not in page] == []


# --- records


def test_formats_of_records_are_complete() -> None:
    forgotten = []
    for name in modules_with("recognised", RECORDS):
        module = importlib.import_module(f"solver.ground.records.{name}")
        if getattr(module, "NAME", "CSV") not in records.NAMES:
            forgotten.append(f"solver/ground/records/reader.py: _FORMATS or _OF_CHANNELS lacks {name}")
    for name in records.NAMES:
        if name not in {case.format for case in CASES.values()}:
            forgotten.append(f"tests/support/record_files.py: CASES has no file of {name}")
        if f"\n| {name} " not in text_of("docs/records.md"):
            forgotten.append(f"docs/records.md: the table has no row of {name}")
    assert not forgotten, "\n".join(forgotten)


# --- sections


def moments(whole: FaceShape) -> tuple[float, float, float]:
    """Return the area, second moment and largest distance of two points, by the depths of a face."""
    s = whole.width * ((np.arange(4000) + 0.5) / 4000 - 0.5)
    depth = np.array([deepest(whole, place, place) for place in s])
    weight = depth * whole.width / len(s)
    return float(np.sum(weight)), float(weight @ s**2), float(np.max(np.hypot(2.0 * s, depth)))


@pytest.mark.parametrize("name", [name for name in SECTIONS if name != "strips"])
def test_functions_of_a_section_fit_together(name: str) -> None:
    """Compare area and diameter of a whole face by its depths; the contact on the base by its parts; a part of its
    picture.
    """
    forgotten = []
    whole = face_of(float(SECTIONS.index(name)), 0.8, 0.6, 0.3)
    area, second = face(*whole)
    if moments(whole) != pytest.approx((area, second, across(whole)), rel=1e-3):
        forgotten.append("solver/kernels/column/sections/faces.py: `deepest` or `across`, or `face` in section.py")
    if common(whole, BASE) != whole or not lies_within(whole, whole):
        forgotten.append("solver/kernels/column/sections/faces.py: `common` or `lies_within`")
    model, found = np.zeros(spaces.MODEL.size(1)), np.zeros(3)
    lay_joint(np.array(whole), np.zeros(1), 0.0, np.array(BASE), 0.0, model, found)
    if found != pytest.approx((area, 0.0, second), rel=1e-12, abs=1e-15):
        forgotten.append("solver/kernels/column/sections/section.py: `_part_of_outline` or `lay_out`")
    if name not in OUTLINES:
        forgotten.append("solver/plotting/scene/bodies.py: OUTLINES")
    if name != "rectangle" and f'section="{name}"' not in text_of("tests/joints/test_sections.py"):
        forgotten.append("tests/joints/test_sections.py: JOINTS")
    assert not forgotten, f"{name}:\n" + "\n".join(forgotten)


def test_kernels_refuse_a_section_that_they_do_not_know() -> None:
    block = Block(2.0, 1.0, 1.0, 1e4, Joint(1e9, 1e-3))
    column = Column("two", (block, block))
    place = spaces_of_block(1)
    for name in ("section", "joint_section"):
        given = packing.described(column)
        given[place + description.GIVEN.fields.index(name)] = 99.0
        with pytest.raises(InputError, match=r"^block\[2\]: solver/kernels/sections has no kernels of its section"):
            packing._assemble(column, given)


def spaces_of_block(i: int) -> int:
    """Return the index of the numbers of block i, from 0, in the description of a column."""
    return description.GIVEN_SETTINGS.beside + description.GIVEN.beside * i


# --- outputs


def test_outputs_of_a_column_are_complete() -> None:
    forgotten = []
    for file in ("solver/kernels/column/formulations/outputs.py", "solver/kernels/paper/outputs.py"):
        shared = text_of("solver/kernels/column/formulations/outputs.py").split("def show_joint(")[1]  # by both
        filled = text_of(file) + shared
        for name in spaces.OUTPUTS.fields:
            if name != "ux" and f"joints.{name}[i] = " not in filled:
                forgotten.append(f"{file}: nothing fills joints.{name}")
        forgotten += [f"{file}: nothing fills base.{k}" for k in spaces.REACTION.fields if f"base.{k} = " not in filled]
    forgotten += described("solver/models/column/outputs.py", of_column.OUTPUTS)
    names = [item.name for item in variables(PHOCAS)]
    forgotten += numbered("tests/fmu/value_references.txt", names)
    assert not forgotten, "\n".join(forgotten)


def test_outputs_of_a_structure_are_complete() -> None:
    file, forgotten = "solver/kernels/structure/evaluate.py", []
    text = text_of(file)
    for row, count, i, fields in (
        ("row", "n", "i", layout.OF_BLOCK),
        ("of_joints", "m", "j", layout.OF_JOINT),
        ("base", "", "", layout.OF_BASE),
    ):
        filled = re.findall(rf"\b{row}\[(.*?)\]", text)
        for k, name in enumerate(fields):
            place = str(k) if not count else i if k == 0 else f"{count} + {i}" if k == 1 else f"{k} * {count} + {i}"
            if place not in filled:
                forgotten.append(f"{file}: nothing fills {row}[{place}] of {name}")
    forgotten += described("solver/models/structure/outputs.py", of_structure.OUTPUTS)
    trilith = Structure.from_toml(ROOT / "examples" / "structures" / "trilith.toml")
    forgotten += numbered(
        "tests/fmu/value_references_in_space.txt", [item.name for item in structure_variables(trilith)]
    )
    assert not forgotten, "\n".join(forgotten)


def described(file: str, outputs: Sequence[Output]) -> list[str]:
    """Return the rows of a table of outputs that lack a sentence, or the owner in it."""
    rows = [one for output in outputs for one in output.each]
    texts = [f"{file}: {one.name} has no sentence" for one in rows if not one.text]
    unnamed = [one for one in rows if one.owner != OF_BASE and one.text == one.text.format(i="", it="")]
    return texts + [f"{file}: the sentence of {one.name} lacks {{i}} or {{it}}" for one in unnamed]


def numbered(file: str, names: Sequence[str]) -> list[str]:
    kept = {line.split()[0] for line in text_of(file).splitlines()}
    return [f"{file}: lacks {name}" for name in names if name not in kept and re.search(r"\[1\]|^[^\[]*$", name)]


# --- methods


def test_methods_are_complete() -> None:
    file, forgotten = "solver/kernels/column/integrators/traits.py", []
    traits = text_of(file)
    steps = "".join(text_of(f"solver/kernels/column/stepping/{name}.py") for name in ("control", "advance"))
    for name in modules_with("attempt", INTEGRATORS):
        shared = re.search(rf"from \.\.\.engine import {name} as (\w+)", traits)  # its coefficients
        own = shared[1] if shared else name
        if f" {name}.attempt(" not in traits or f"{own}.ORDER" not in traits + "modal.ORDER":
            forgotten.append(f"{file}: `traits_of` or `attempt_by` lacks {name}")
        if f"order == {own}.ORDER" in traits:
            if name not in text_of("tests/dynamics/test_integrators.py"):
                forgotten.append(f"tests/dynamics/test_integrators.py: no tableau of {name}")
            package = "engine" if shared else "column.integrators"
            order = importlib.import_module(f"solver.kernels.{package}.{name}").ORDER
            if not re.search(rf"explicit_order = .*\b{order}\.0", text_of("solver/kernels/column/model/assembly.py")):
                forgotten.append(f"solver/kernels/column/model/assembly.py: `derive` never takes {name}")
    for number in re.findall(r"^([A-Z_\d]+) = [1-9]\d*$", traits, re.MULTILINE):
        if not re.search(rf"return {number}\b", traits) and not re.search(rf"\b{number}\b", steps):
            forgotten.append(f"solver/kernels/column/stepping/control.py: `general_step` never takes {number}")
    assert not forgotten, "\n".join(forgotten)


def test_a_step_by_a_method_that_is_not_there_is_refused() -> None:
    stepper = Stepper(PHOCAS.with_settings(without=("elastic", "rest")))
    stepper.model.settings.explicit_order = 3.0
    with pytest.raises(SolverError, match=r"solver/kernels/column/integrators/traits\.py"):
        stepper.advance(0.0, 0.01)


# --- messages


def test_codes_of_kernels_have_messages() -> None:
    codes = {name: code for name, code in vars(spaces).items() if isinstance(code, int) and code < 0}
    forgotten = [
        f"solver/models/column/stepper.py: REASONS lacks {name}" for name in codes if codes[name] not in REASONS
    ]
    refused = {name: code for name, code in vars(description).items() if isinstance(code, int) and code < 0}
    forgotten += [f"fmu_src/native/table.py: REFUSALS lacks {name}" for name in refused if name not in REFUSALS]
    core = text_of("fmu_src/native/core.c")
    forgotten += [f"fmu_src/native/core.c: no sentence of {n}" for n in REFUSALS if n not in core and n != "NOT_LINEAR"]
    both = [*codes.values(), *refused.values()]
    assert len(set(both)) == len(both), "solver/kernels/layout/spaces.py: a code is given twice"
    assert not forgotten, "\n".join(forgotten)
