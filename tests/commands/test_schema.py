"""The command `schema`: the files of the examples are valid, and files with a wrong key, type or number are not."""

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from support.fmus import ROOT

from multiblock import Building, Column, InputError, Structure, Study
from solver.commands.command_line import main
from solver.commands.schema import SCHEMAS, schema_of
from solver.common.ranges import NUMBERS
from solver.models.column import file as column_file
from solver.models.structure.bearing_tables import RANGES as OF_BEARINGS
from solver.models.structure.file import OF_TIES, OWN_RANGES
from solver.models.structure.neighbours import RANGES as OF_NEIGHBOURS

KIND_OF = {"columns": "column", "structures": "structure", "bearings": "structure", "studies": "study"}
FILES = [path for folder in KIND_OF for path in sorted((ROOT / "examples" / folder).glob("*.toml"))]
READERS: dict[str, Any] = {"column": Column.from_toml, "structure": Structure.from_toml, "study": Study.from_toml}


def faults(kind: str, data: dict[str, Any]) -> list[str]:
    """Return where a file differs from its schema, and how."""
    errors = jsonschema.Draft202012Validator(schema_of(kind)).iter_errors(data)
    return [f"{error.json_path}: {error.message}" for error in errors]


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_examples_are_valid(path: Path) -> None:
    assert faults(KIND_OF[path.parent.name], tomllib.loads(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize(
    ("file", "old", "new", "place"),
    [
        ("columns/phocas.toml", "height = ", "hight = ", "$.block[0]"),
        ("columns/phocas.toml", "height = ", "height = -", "$.block[0].height"),
        ("columns/phocas.toml", 'name = "phocas"', "name = 3", "$.name"),
        ("columns/phocas.toml", '"paper"', '"papers"', "$.solver.formulation"),
        ("columns/doric.toml", '"circle"', '"round"', "$.block[0].joint.section"),
        ("columns/portico.toml", "at = [0.0, 0.178]", 'at = "top"', "$.port[0].at"),
        ("structures/casks.toml", "reach = 0.3", 'reach = "0.3"', "$.neighbours.reach"),
        ("structures/casks.toml", "diameter = 1.6", "width = 1.6", "$.block[1]"),
        ("structures/arch.toml", 'between = ["voussoir1", "base"]', 'between = "voussoir1"', "$.joint[6].between"),
        ("bearings/lead-rubber-lrb600.toml", "yield = 63e3", "radius = 1.0", "$.bearing[0]"),
        ("bearings/lead-rubber-lrb600.toml", "tension = true", 'tension = "yes"', "$.bearing[0].tension"),
        ("studies/casks.toml", '"least_gap"', '"gap"', "$.keep[2]"),
        ("studies/casks.toml", "samples = 60", "samples = 0", "$.samples"),
        ("studies/ida.toml", 'formula = "ricker"\n', 'formula = "ricker"\nmagnitude = 6.0\n', "$.motion[4]"),
        ("studies/ida.toml", 'formula = "ricker"\n', 'formula = "ricker"\nfloor = 2\n', "$.motion[4]"),
        ("studies/ida.toml", "count = 20", "counts = 20", "$.grid.intensity"),
        ("studies/fragility.toml", 'distribution = "uniform"\n', "", "$.random.intensity"),
    ],
)
def test_a_wrong_file_is_not_valid(tmp_path: Path, file: str, old: str, new: str, place: str) -> None:
    """Compare with the program, which refuses the same file."""
    path = ROOT / "examples" / file
    kind, text = KIND_OF[path.parent.name], path.read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new, 1).replace('"../', f'"{(ROOT / "examples").as_posix()}/')
    found = faults(kind, tomllib.loads(text))
    assert any(line.startswith(f"{place}: ") for line in found), found
    (tmp_path / "wrong.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError):
        READERS[kind](tmp_path / "wrong.toml")


@pytest.mark.parametrize(
    ("at", "is_valid"),
    [
        ([0.0, 0.0, 0.3], True),
        ([[0.0, 0.0, 0.3]], True),
        ([[-1.0, 0.0, 0.3], [1.0, 0.0, 0.3]], True),
        ([], False),
        ([0.0, 0.3], False),
        (["base", [0.0, 0.0, 0.3]], False),
        ([1.5, [0.0, 0.0, 0.3]], False),
        ([[0.0, 0.0, 0.3], 1.5], False),
        ([["0.0", "0.0", "0.3"]], False),
        ([[0.0, 0.0, 0.3, 0.0]], False),
    ],
)
def test_places_of_bearings_are_valid_where_the_program_reads_them(at: Any, is_valid: bool) -> None:
    data = tomllib.loads((ROOT / "examples" / "bearings" / "pendulum-bdqz1000.toml").read_text(encoding="utf-8"))
    data["bearing"][0]["at"] = at
    assert [line.startswith("$.bearing[0].at: ") for line in faults("structure", data)] == [True] * (not is_valid)
    if is_valid:
        assert len(Structure.from_dict(data).bearings) == (1 if isinstance(at[0], float) else len(at))
    else:
        with pytest.raises(InputError, match=r"bearing\[1\]\.at"):
            Structure.from_dict(data)


@pytest.mark.parametrize(
    ("foot", "is_valid"),
    [
        ([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1]], True),
        ([[[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1]], [[-0.3, 0.2], [0.3, 0.2], [0.0, 0.3]]], True),
        ([[-0.1, -0.1], [0.1, -0.1]], False),
        ([[-0.1, -0.1], [0.1, -0.1], "base"], False),
        ([[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0]], False),
    ],
)
def test_feet_are_valid_where_the_program_reads_them(foot: Any, is_valid: bool) -> None:
    points = [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)]
    block = {"shape": "hull", "points": points, "on": "base", "density": 2e3, "foot": foot}
    data = {"name": "statue", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": [block]}
    assert [line.startswith("$.block[0].foot: ") for line in faults("structure", data)] == [True] * (not is_valid)
    if is_valid:
        Structure.from_dict(data)
    else:
        with pytest.raises(InputError, match=r"block\[1\]\.foot"):
            Structure.from_dict(data)


def properties(part: Any) -> Iterator[tuple[str, Any]]:
    """Yield each key with its schema, of all tables."""
    for name, value in part.items() if isinstance(part, dict) else enumerate(part) if isinstance(part, list) else ():
        if name == "properties":
            yield from value.items()
        yield from properties(value)


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_key_has_a_type(kind: str) -> None:
    found = schema_of(kind)
    jsonschema.Draft202012Validator.check_schema(found)
    keys = list(properties(found))
    assert len(keys) > (10 if kind == "building" else 30)
    assert [key for key, value in keys if not {"type", "enum", "const"} & value.keys()] == []


def test_keys_units_ranges_and_defaults_come_from_the_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    found = schema_of("column")["properties"]
    joint = found["joint"]["properties"]
    assert set(joint) == set(column_file._JOINT_KEYS)
    known = {"type": "number", "minimum": 1e-3, "maximum": 1e20}
    assert joint["stiffness"] == {**known, "description": "a positive Winkler modulus in N/m3, from 1e-3 to 1e20"}
    assert (found["g"]["default"], found["solver"]["properties"]["tolerance"]["default"]) == (9.80665, 1e-5)
    # a new key of a table
    monkeypatch.setattr(column_file, "_LOAD_KEYS", ("mass", "above", "speed"))
    monkeypatch.setitem(NUMBERS, "speed", ((0.0, 2.0), "a speed in m/s"))
    load = schema_of("column")["properties"]["block"]["items"]["properties"]["load"]["properties"]
    assert load["speed"] == {"type": "number", "minimum": 0.0, "maximum": 2.0, "description": "a speed in m/s"}


def test_the_command_prints_one_schema_or_all(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "study"]) == 0
    assert json.loads(capsys.readouterr().out) == schema_of("study")
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out) == {kind: schema_of(kind) for kind in SCHEMAS}
    assert main(["schema", "bridge"]) == 2
    assert "invalid choice: 'bridge'" in capsys.readouterr().err


def test_a_motion_of_a_floor_is_valid() -> None:
    data = tomllib.loads((ROOT / "examples" / "studies" / "ida.toml").read_text(encoding="utf-8"))
    data["motion"] = [motion | {"building": "hall.toml", "floor": 2} for motion in data["motion"]]
    assert faults("study", data) == []


BEAM = {"storeys": 4, "period": 0.5, "alpha": 3.0, "height": 16.0, "damping": 0.03, "alpha_y": 5.0}
MODE = {"period": 0.5, "x": [0.3, 1.2], "y": [0.4, 1.1]}


@pytest.mark.parametrize(
    ("building", "is_valid"),
    [
        (BEAM, True),
        ({"mode": [MODE, {"period": 0.1, "y": [0.1, -0.2]}], "name": "hall"}, True),
        ({**BEAM, "storey": 4}, False),
        ({**BEAM, "storeys": 2.5}, False),
        ({**BEAM, "period": -0.5}, False),
        ({"period": 0.5, "alpha": 3.0}, False),
        ({"mode": [{"period": 0.5}]}, False),
        ({"mode": [{**MODE, "z": [1.0, 1.0]}]}, False),
        ({"mode": [MODE], "storeys": 4}, False),
        ({"mode": [{**MODE, "x": "top"}]}, False),
    ],
)
def test_buildings_are_valid_where_the_program_reads_them(building: dict[str, Any], is_valid: bool) -> None:
    data = {"building": building}
    assert (faults("building", data) == []) == is_valid
    if is_valid:
        Building.from_dict(data)
    else:
        with pytest.raises(InputError, match="building"):
            Building.from_dict(data)


@pytest.mark.parametrize("ranges", [NUMBERS, OWN_RANGES, OF_TIES, OF_BEARINGS, OF_NEIGHBOURS])
def test_messages_name_a_least_value_above_zero(ranges: dict[str, tuple[tuple[float, float], str]]) -> None:
    """Find 1e-6 in "a positive ratio, from 1e-6 to 1e6": 1e-9 is positive too."""
    for key, ((least, _), meaning) in ranges.items():
        named = {float(number) for number in re.findall(r"\d+(?:\.\d+)?(?:e-?\d+)?", meaning)}
        assert least <= 0.0 or least in named, key
