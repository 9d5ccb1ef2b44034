"""The native FMU of FMI 3.0: valid, bit for bit that of FMI 2.0, arrays, motion within a step, what it refuses."""

from __future__ import annotations

import importlib.util
import re
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import read_model_description
from lxml import etree  # type: ignore[import-untyped]
from support.child import call, command, ended, returned
from support.fmus import DAMPED, LINUX, Fmus, finish, run, stack_file
from support.inside import fmi3, masters
from support.shaft import ROCKING

from fmu_src.body import ColumnBody
from fmu_src.drive import Drive
from fmu_src.model_description3 import terminals
from fmu_src.native import library, symbols
from fmu_src.native.platforms import PLATFORMS
from fmu_src.variables import Variable
from multiblock import Column

pytestmark = pytest.mark.long  # builds native FMUs

if not sys.platform.startswith("linux"):
    pytest.skip("the libraries are built for Linux", allow_module_level=True)

BASE_PORT = 7 + 9  # motion; reaction and effective mass


def test_it_is_valid(native3: Path) -> None:
    assert "No problems found" in run("fmpy", "validate", native3)
    description = read_model_description(str(native3))
    assert description.fmiVersion == "3.0"
    with zipfile.ZipFile(native3) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    given = [item.get("name") for item in root.find("ModelVariables") if item.get("intermediateUpdate") == "true"]
    assert given == ["base.ax", "base.az"]
    interface = root.find("CoSimulation")
    for claim in ("providesIntermediateUpdate", "providesDirectionalDerivatives", "canSerializeFMUState"):
        assert interface.get(claim) == "true"
    for claim in ("hasEventMode", "mightReturnEarlyFromDoStep", "canReturnEarlyAfterIntermediateUpdate"):
        assert interface.get(claim) == "false"
    variables = {variable.name: variable for variable in description.modelVariables}
    assert [int(item.start) for item in variables["block.ux"].dimensions] == [3]
    assert variables["block.ux"].valueReference == 10001
    assert not [name for name in variables if "[" in name]
    assert len(variables["block.mass"].start.split()) == 3


@pytest.mark.parametrize("n", [1, 12])
def test_columns_of_other_sizes_are_valid(tmp_path: Path, n: int) -> None:
    options = ("--native", "--fmi", "3", "--platforms", "x86_64-linux")
    assert "No problems found" in run(
        "fmpy", "validate", Fmus.build(stack_file(tmp_path, n), tmp_path / "stack.fmu", *options)
    )


def test_the_base_is_one_terminal(native: Path, native3: Path) -> None:
    folder = Path(fmpy.__file__).parent / "schema" / "fmi3"
    schema = etree.XMLSchema(etree.parse(str(folder / "fmi3TerminalsAndIcons.xsd")))
    for fmu in (native, native3):
        with zipfile.ZipFile(fmu) as archive:
            root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        assert schema.validate(root), schema.error_log
        (terminal,) = root.iter("Terminal")
        members = [member.get("variableName") for member in terminal]
        assert len(members) == BASE_PORT
        assert {f"base.{member.get('memberName')}" for member in terminal} == set(members)
        known = {variable.name for variable in read_model_description(str(fmu)).modelVariables}
        assert set(members) <= known


def test_bodies_at_the_base_are_terminals_too() -> None:
    """Check that an FMU built for two bodies has a terminal for each, with every input of it and nothing else."""
    table = ColumnBody(Column.from_toml(DAMPED), Drive("body", "parabola", 2)).table()
    ports = terminals(table).iter("Terminal")
    found = {port.get("name"): [part.get("variableName") for part in port] for port in ports}
    assert list(found) == ["base", "body", "body2"]
    for body in ("body", "body2"):
        assert found[body] == [row.name for row in table if row.name.startswith(f"{body}.")]
        assert len(found[body]) == 9


def test_a_base_that_bodies_alone_move_takes_no_motion() -> None:
    ports = {part.get("name"): part for part in terminals(driven_table("body"), drive=Drive("body")).iter("Terminal")}
    members = [part.get("memberName") for part in ports["base"]]
    assert members == ["R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt"]
    assert "bodies that move the base" in (ports["base"].get("description") or "")
    ports = {part.get("name"): part for part in terminals(driven_table("horizontal"), drive=Drive("horizontal"))[0]}
    assert "base.az" in [part.get("variableName") for part in ports["base"]]


def driven_table(drive: str) -> list[Variable]:
    return ColumnBody(Column.from_toml(DAMPED), Drive(drive)).table()


@pytest.mark.parametrize("scalars", [True, False])
def test_points_of_blocks_are_terminals(tmp_path: Path, scalars: bool) -> None:
    """Find one for each port, or one of arrays; its signals are loads, their slopes and the motion."""
    file = tmp_path / "table.toml"
    block = "[[block]]\nheight = 1.0\nwidth = 1.0\ndepth = 1.0\ndensity = 2000.0\n"
    port = '[[port]]\nname = "{}"\nblock = "block{}"\nat = [0.0, 0.5]\n'
    joint = "[joint]\nstiffness = 1e9\ndamping = 1e-3\n"
    file.write_text(f'name = "pair"\n{2 * block}{port.format("top", 1)}{port.format("low", 2)}{joint}')
    options = ("--native", "--fmi", "3", "--platforms", "x86_64-linux", *(["--scalars"] * scalars))
    fmu = Fmus.build(file, tmp_path / "table.fmu", *options)
    assert "No problems found" in run("fmpy", "validate", fmu)
    with zipfile.ZipFile(fmu) as archive:
        root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    schema = etree.XMLSchema(etree.parse(str(Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd")))
    assert schema.validate(root), schema.error_log
    ports = {part.get("name"): part for part in root.iter("Terminal") if part.get("name") != "base"}
    assert list(ports) == (["port[1]", "port[2]"] if scalars else ["port"])
    known = {variable.name: variable.causality for variable in read_model_description(str(fmu)).modelVariables}
    for name, part in ports.items():
        members = {member.get("memberName"): member.get("variableName") for member in part}
        assert members == {member: f"{name}.{member}" for member in members}
        roles = {member: known[f"{name}.{member}"] for member in members}
        assert [member for member, role in roles.items() if role == "input"] == ["Fx", "Fz", "My", "dFx", "dFz", "dMy"]
        assert [member for member, role in roles.items() if role == "output"] == ["x", "z", "vx", "vz", "ax", "az"]
    assert ("(low)" in (ports["port[2]"].get("description") or "")) if scalars else True
    if not scalars:
        found = call(fmi3.along_an_array, fmu)
        first, second, both = (np.array(found[key]) for key in ("first", "second", "both"))
        assert first[0] > 1e-4  # m/s2 by N
        assert first[1] == pytest.approx(second[0], rel=1e-9)  # reciprocity: measured 2e-15
        assert both == pytest.approx(2.0 * first - 3.0 * second, rel=1e-9)
        assert "not enough values" in found["short"]
        assert "3 values are too many" in found["long"]


def test_fmi_3_has_an_icon_and_fmi_2_no_terminals_by_default(native3: Path, tmp_path: Path) -> None:
    plain = Fmus.build(DAMPED, tmp_path / "plain.fmu", *LINUX)
    with zipfile.ZipFile(plain) as archive:
        assert not [name for name in archive.namelist() if name.startswith("terminalsAndIcons")]
        assert "model.png" in archive.namelist()
    with zipfile.ZipFile(native3) as archive:
        assert archive.read("terminalsAndIcons/icon.png").startswith(b"\x89PNG")
        assert "model.png" not in archive.namelist()
    for fmu in (plain, native3):
        variables = {variable.name: variable for variable in read_model_description(str(fmu)).modelVariables}
        assert "no file is read" in variables["base.record"].description


def test_it_gives_the_bits_of_fmi_2(native: Path, native3: Path) -> None:
    found = call(fmi3.beside, native, native3)
    assert found["same"]
    assert found["moved"] > 1.0
    assert found["time"] == [0.5]  # where the state was saved
    assert found["time in between"] == 0.5
    assert found["direct"]
    assert found["restored"]
    assert found["elsewhere"] == [0.5, 2e-3, 1e-3, 3e-3]
    assert found["size"] == 3
    assert found["overturned"] == [False, 0, ""] or found["overturned"] == [False, 0, b""]


def test_a_motion_given_within_a_step_is_followed(native: Path, native3: Path) -> None:
    exact = np.array(call(fmi3.followed, native, native3, 1e-3, 300))
    assert np.array_equal(exact[:, 0], exact[:, 1])
    # the values of the end of a step are kept
    kept = np.array(call(fmi3.followed, native, native3, 1e-3, 300, False))
    # the times of both differ by their rounding
    assert np.max(np.abs(kept - exact)) < 1e-10 * np.max(np.abs(exact))
    coarse = np.array(call(fmi3.followed, native, native3, 0.02, 25))
    assert np.max(np.abs(coarse[:, 0] - coarse[:, 1])) < 1e-9 * np.max(np.abs(coarse))  # 1e-13 was seen


LENGTH = 0.02  # s, of a step that is made in 20 pieces


def test_inputs_that_are_not_given_within_a_step_continue_by_their_slopes(native: Path, native3: Path) -> None:
    """Compare with one step of FMI 2.0: rotation with rate and acceleration, vertical motion with its slope."""
    steps = []
    for k in range(3):
        t, later = LENGTH * k, LENGTH * (k + 1)
        turned = {"base.theta": 0.05 * t + 0.5 * t * t, "base.omega": 0.05 + t, "base.alpha": 1.0}
        slopes = {"base.jx": (3.0 * np.sin(9.0 * later) - 3.0 * np.sin(9.0 * t)) / LENGTH, "base.jz": 20.0}
        steps.append({"base.ax": 3.0 * float(np.sin(9.0 * t)), "base.az": 20.0 * t, **turned, **slopes})
    outputs = ["base.Fz", "base.Fx", "base.My", "block.theta", "block.ux", "joint.N"]
    found = call(fmi3.continued, native, native3, {"base.ax": "base.jx"}, steps, outputs, LENGTH)
    assert found["kept"]
    assert found["pieces"] == 3 * round(LENGTH / 1e-3)
    three, two = np.array(found["rows"]).transpose(1, 0, 2)
    assert np.max(np.abs(two[:, 3])) > 1e-4  # rad, of the upper block; the base turns by 5e-3 rad beneath
    assert np.all(np.max(np.abs(three - two), axis=0) < 1e-6 * np.max(np.abs(two), axis=0))


TURNING = f"""{ROCKING}
[[port]]
name = "top"
block = "shaft"
"""


def test_all_inputs_of_a_structure_that_are_marked_can_be_given_within_a_step(tmp_path: Path) -> None:
    """Check nine of them, and that the rotation, which is not marked, continues."""
    (tmp_path / "shaft.toml").write_text(TURNING, encoding="utf-8")
    two = Fmus.build(tmp_path / "shaft.toml", tmp_path / "two.fmu", *LINUX, "--turns")
    options = ("--native", "--fmi", "3", "--scalars", "--platforms", "x86_64-linux", "--turns")
    three = Fmus.build(tmp_path / "shaft.toml", tmp_path / "three.fmu", *options)
    with zipfile.ZipFile(three) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    marked = [item.get("name") for item in root.find("ModelVariables") if item.get("intermediateUpdate") == "true"]
    lines = {name: name.replace(".a", ".j") if "base" in name else name.replace("].", "].d") for name in marked}
    assert len(lines) == 9
    steps = []
    for k in range(3):
        t = LENGTH * k
        turned = {"base.theta_x": 0.05 * t + 0.5 * t * t, "base.omega_x": 0.05 + t, "base.alpha_x": 1.0}
        turned |= {"base.theta_y": 0.1 * t, "base.omega_y": 0.1, "base.alpha_y": 0.0}
        slopes = {slope: (1e4 if "port" in slope else 10.0) * (1.0 - k) for slope in lines.values()}
        values = {name: slopes[slope] * LENGTH * (k > 0) for name, slope in lines.items()}
        steps.append({**values, **slopes, **turned})
    outputs = ["base.Fz", "base.Mx", "base.My", "block[1].rx", "block[1].ry", "block[1].ux"]
    found = call(fmi3.continued, two, three, lines, steps, outputs, LENGTH)
    assert found["kept"]
    ends = np.array(found["rows"]).transpose(1, 0, 2)
    assert np.all(np.max(np.abs(ends[0] - ends[1]), axis=0) < 1e-6 * np.max(np.abs(ends[1]), axis=0))


def test_no_input_is_given_within_a_step_where_bodies_may_drive_the_base(tmp_path: Path) -> None:
    """Check that, because they exchange once per step, no input is marked, and none can be required."""
    options = ("--native", "--fmi", "3", "--platforms", "x86_64-linux", "--drive", "horizontal")
    fmu = Fmus.build(DAMPED, tmp_path / "driven.fmu", *options)
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read("modelDescription.xml").decode()
    assert "intermediateUpdate" not in text
    assert 'providesIntermediateUpdate="false"' in text
    done = ended(fmi3.continued, fmu, fmu, {"base.ax": "base.jx"}, [], ["base.Fz"], LENGTH)
    assert done.returncode != 0
    assert "Failed to instantiate" in done.stderr


def test_what_it_refuses(native3: Path) -> None:
    found = call(fmi3.refusals, native3)
    assert found.pop("answers")
    assert [found.pop(name) for name in ("exchange", "nothing")] == [None, 3]
    assert all("Failed to instantiate" in found.pop(name) for name in ("events", "token", "unnamed"))
    assert "10002: is not that of a variable" in found["element"]
    assert "not enough values" in found["short"]
    assert "4 values are too many" in found["long"]
    assert "is not offered" in found["event mode"]
    assert "positive time" in found["backwards"]
    assert "must be a finite number" in found["no number"]
    assert "base.ax = nan: must be a finite number" in found["no number within"]  # not its slope
    assert "serialized state" in found["state"]
    assert [name for name, said in found.items() if said == "ok"] == []


def test_fmpy_simulates_it(native3: Path, tmp_path: Path) -> None:
    result = tmp_path / "result.csv"
    assert finish("fmpy", "simulate", native3, "--stop-time", "0.5", "--output-file", result).returncode == 0
    header = result.read_text(encoding="utf-8").splitlines()[0]
    assert "block.ux" in header


def test_libraries_for_five_systems_offer_the_whole_interface(native3: Path) -> None:
    with zipfile.ZipFile(native3) as archive:
        names = [name for name in archive.namelist() if name.startswith("binaries/")]
        parts = {name.split("/")[1]: symbols.read(archive.read(name)) for name in names}
    assert set(parts) == set(PLATFORMS[3])
    header = (library.headers() / "fmi3Functions.h").read_text(encoding="utf-8")
    wanted = set(re.findall(r"^FMI3_Export fmi3\w+TYPE\s+(fmi3\w+);", header, re.MULTILINE))
    assert len(wanted) > 70
    for platform, found in parts.items():
        (part,) = found
        assert {name for name in part.offered if name.startswith("fmi3")} == wanted, platform
        assert part.foreign == []


def test_without_arrays_it_has_the_variables_of_fmi_2(native: Path, tmp_path: Path) -> None:
    options = ("--native", "--fmi", "3", "--scalars", "--platforms", "x86_64-linux")
    scalars = Fmus.build(DAMPED, tmp_path / "scalars.fmu", *options)
    assert "No problems found" in run("fmpy", "validate", scalars)
    two, three = (read_model_description(str(fmu)).modelVariables for fmu in (native, scalars))
    references = {variable.name: variable.valueReference for variable in three}
    assert {variable.name: variable.valueReference for variable in two} | {"time": 0} == references
    assert not any(variable.dimensions for variable in three)
    outputs = ["block[1].ux", "block[3].theta", "joint[2].N", "base.Fx", "joint[3].contact"]
    expected = call(masters.alone, native, outputs)
    assert call(masters.alone3, scalars, outputs) == expected
    if importlib.util.find_spec("ecospy") and list((Path(sys.prefix) / "lib").glob("libtbb.so.12")):
        libraries = {"LD_LIBRARY_PATH": str(Path(sys.prefix) / "lib")}
        found = run(*command(masters.ecos, scalars, outputs), **libraries)  # reads one value where there is an array
        assert returned(found) == pytest.approx(expected, rel=1e-12)


def test_a_free_name_becomes_an_identifier(tmp_path: Path) -> None:
    text = DAMPED.read_text(encoding="utf-8").replace('"phocas_damped"', '"2nd my-doric.v1"')
    (tmp_path / "column.toml").write_text(text, encoding="utf-8")
    outputs = ["block[1].ux", "base.Fx"]
    found = []
    for fmi, platform, way in (("2", "linux64", masters.alone), ("3", "x86_64-linux", masters.alone3)):
        fmu = tmp_path / f"{fmi}.fmu"
        Fmus.build(tmp_path / "column.toml", fmu, "--native", "--fmi", fmi, "--source", "--platforms", platform)
        assert "No problems found" in run("fmpy", "validate", fmu)
        description = read_model_description(str(fmu))
        assert description.modelName == "2nd my-doric.v1"
        assert description.coSimulation.modelIdentifier == "_2nd_my_doric_v1"
        with zipfile.ZipFile(fmu) as archive:
            assert f"binaries/{platform}/_2nd_my_doric_v1.so" in archive.namelist()
        found.append(call(way, fmu, outputs[1:]))
    assert found[0] == found[1]
