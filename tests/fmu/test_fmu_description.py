"""The FMU describes itself: model description, documentation, archive."""

from __future__ import annotations

import re
import zipfile
from datetime import UTC, datetime, timedelta
from pathlib import Path
from xml.etree import ElementTree

import pytest
from fmpy import read_model_description
from support.child import call
from support.fmus import DAMPED, ROOT, Fmus, read_results, run
from support.inside import initialization

from build_fmu import build_fmu, build_native_fmu
from fmu_src.documentation import drawing
from fmu_src.native.platforms import Form
from solver import Column

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time

FACTORS = {"mm": 1e3, "g": 1.0 / 9.80665, "deg": 57.29577951308232, "kN": 1e-3, "MPa": 1e-6}


@pytest.fixture(scope="module")
def archive(fmus: Fmus) -> dict[str, bytes]:
    """Return the files of the FMU."""
    with zipfile.ZipFile(fmus.damped) as file:
        assert all(entry.compress_type == zipfile.ZIP_DEFLATED for entry in file.infolist())
        return {name: file.read(name) for name in file.namelist()}


@pytest.fixture(scope="module")
def root(archive: dict[str, bytes]) -> ElementTree.Element:
    """Return the model description."""
    return ElementTree.fromstring(archive["modelDescription.xml"])


def test_says_who_made_it_and_what_it_can_do(root: ElementTree.Element) -> None:
    assert root.get("author") == "The multiblock-fmu authors"
    assert root.get("license") == "MIT"
    made = datetime.strptime(root.get("generationDateAndTime") or "", "%Y-%m-%dT%H:%M:%S%z")
    assert timedelta(0) <= datetime.now(UTC) - made < timedelta(hours=2)
    simulation = root.find("CoSimulation")
    assert simulation is not None
    for flag in ("canGetAndSetFMUstate", "canSerializeFMUstate", "canHandleVariableCommunicationStepSize"):
        assert simulation.get(flag) == "true", flag
    for flag in ("needsExecutionTool", "canInterpolateInputs", "providesDirectionalDerivative"):
        assert simulation.get(flag) == "false", flag


def test_display_units_belong_to_their_units(root: ElementTree.Element) -> None:
    shown = {
        (unit.get("name"), display.get("name")): float(display.get("factor", "nan"))
        for unit in root.iter("Unit")
        for display in unit.iter("DisplayUnit")
    }
    factors = {display: factor for (_, display), factor in shown.items()}
    for display, factor in FACTORS.items():
        assert factors[display] == pytest.approx(factor, rel=1e-15), display
    for variable in root.iter("ScalarVariable"):
        value = variable[0]
        if value.get("displayUnit"):
            assert (value.get("unit"), value.get("displayUnit")) in shown


def test_limits_nominals_and_starts_fit_together(root: ElementTree.Element) -> None:
    for variable in root.iter("ScalarVariable"):
        value = variable[0]
        assert variable.get("description"), variable.get("name")
        least, most = float(value.get("min", "-inf")), float(value.get("max", "inf"))
        assert least < most
        if variable.get("causality") != "output" and value.tag == "Real":
            assert least <= float(value.get("start", "nan")) <= most, variable.get("name")
        if variable.get("causality") in ("input", "output") and variable.get("variability") == "continuous":
            assert float(value.get("nominal", "nan")) > 0.0, variable.get("name")
    tunable = {v.get("name") for v in root.iter("ScalarVariable") if v.get("variability") == "tunable"}
    assert tunable == {"g", "joint[1].damping", "joint[2].damping", "joint[3].damping"}


def test_unknowns_stand_in_order_and_feedthrough_is_declared(root: ElementTree.Element) -> None:
    names = [variable.get("name") for variable in root.iter("ScalarVariable")]
    outputs = [k for k, v in enumerate(root.iter("ScalarVariable"), start=1) if v.get("causality") == "output"]
    for part in ("Outputs", "InitialUnknowns"):
        assert [int(u.get("index", "0")) for u in root.iterfind(f"ModelStructure/{part}/Unknown")] == outputs
    for unknown in root.iterfind("ModelStructure/Outputs/Unknown"):
        name = names[int(unknown.get("index", "0")) - 1]
        inputs = {names[int(index) - 1] for index in (unknown.get("dependencies") or "").split()}
        assert inputs == direct_inputs(name or ""), name


def test_initial_unknowns_follow_what_is_declared_and_nothing_else(fmus: Fmus, root: ElementTree.Element) -> None:
    names = [variable.get("name") or "" for variable in root.iter("ScalarVariable")]
    declared = {
        names[int(unknown.get("index", "0")) - 1]: {names[int(k) - 1] for k in unknown.get("dependencies", "").split()}
        for unknown in root.iterfind("ModelStructure/InitialUnknowns/Unknown")
    }
    followed = call(initialization.followers, fmus.damped, fmus.phocas)
    for given, outputs in followed.items():
        for output in outputs:
            assert given in declared[output], f"{output} follows {given}"
    for output in ("base.Fx", "joint[1].S"):
        assert {"base.ax", "base.theta"} <= {given for given, outputs in followed.items() if output in outputs}, output
    assert "joint[3].S" in followed["base.az"]
    assert followed["base.jx"] == followed["solver.tolerance"] == []
    assert "block[1].theta" in followed["base.theta"]
    for given in ("joint[2].offset", "joint[1].inclination", "block[3].tilt"):
        assert "block[1].theta" in followed[given], given


def direct_inputs(name: str) -> set[str]:
    """Return inputs that an output of a column of three blocks follows without delay."""
    if name.endswith(("_peak", "_least", ".slip")):
        return set()
    if name.endswith((".ux", ".uz")) or name.startswith("base.m"):
        return {"base.theta"}
    if name.startswith(("joint[3].", "base.R0")) and not name.endswith((".S", ".T")):
        return {"base.theta", "base.omega"}
    if name in ("base.Fx", "base.Fz", "base.My") or name.endswith((".S", ".T")):
        return {"base.ax", "base.az", "base.theta", "base.omega", "base.alpha"}
    return set()


def test_the_documentation_explains_every_variable(archive: dict[str, bytes], root: ElementTree.Element) -> None:
    page = archive["documentation/index.html"].decode()
    for variable in root.iter("ScalarVariable"):
        assert f"<code>{variable.get('name')}</code>" in page
    for picture in re.findall(r'src="([^"]+)"', page):
        assert archive[f"documentation/{picture}"].startswith(b"\x89PNG"), picture
    assert archive["model.png"].startswith(b"\x89PNG")


def test_says_what_is_inside_and_what_it_needs(archive: dict[str, bytes]) -> None:
    """Find licences where FMI looks for them; what `pythonfmu deploy` installs is what the project itself needs."""
    needed = re.findall(r'^RUNS = \["(numpy[^"]*)"', (ROOT / "setup.py").read_text(encoding="utf-8"), re.MULTILINE)
    assert archive["resources/scene.glb"].startswith(b"glTF")
    assert archive["resources/requirements.txt"].decode().split() == needed
    assert archive["documentation/licenses/license.txt"] == (ROOT / "LICENSE").read_bytes()
    assert b"Permission is hereby granted" in archive["documentation/licenses/pythonfmu.txt"]
    assert b"numpy" in archive["documentation/externalDependencies.txt"]


def test_plain_names_have_no_brackets(tmp_path: Path) -> None:
    fmu = build_fmu(DAMPED, tmp_path / "plain.fmu", plain_names=True)
    assert "No problems found" in run("fmpy", "validate", fmu)
    names = {variable.name for variable in read_model_description(str(fmu)).modelVariables}
    assert {"block1.ux", "joint3.N_peak", "block2.height", "base.ax"} <= names
    assert not any("[" in name for name in names)
    results = tmp_path / "rows.csv"
    values = ("--start-values", "joint1.damping", "2e-3", "base.jx", "1.0")
    run("fmpy", "simulate", fmu, "--stop-time", "0.1", *values, "--output-file", results)
    assert abs(read_results(results)["block1.ux"][-1]) > 1e-6


ALL_PARTS = """
name = "parts"
joints = { stiffness = 1e9, damping = 1e-3, friction = 0.5 }
neighbours = { reach = 0.3, stiffness = 1e8, restitution = 0.5, friction = 0.4 }
tie = [{ between = ["post", "wall"], from = [0.1, 0.0, 0.3], to = [-0.1, 0.0, 0.3], stiffness = 1e6 }]
port = [{ name = "top", block = "post" }]
block = [
    { name = "post", on = "base", width = 0.4, depth = 0.4, height = 1.0, mass = 400.0, joint = { cohesion = 1e5 } },
    { name = "wall", position = [0.6, 0.0, 0.1], width = 0.4, depth = 0.4, height = 1.0, mass = 400.0 },
]
[[bearing]]
kind = "elastomeric"
between = ["wall", "base"]
at = [[0.45, -0.15, 0.1], [0.75, -0.15, 0.1], [0.75, 0.15, 0.1], [0.45, 0.15, 0.1]]
diameter = 0.1
capacity = 0.3
stiffness = 1e6
damping = 1e3
vertical_stiffness = 1e9
vertical_damping = 1e-3
"""


@pytest.mark.parametrize("form", [None, Form(2), Form(3, scalars=True)], ids=["python", "native", "fmi3"])
@pytest.mark.parametrize(
    ("text", "named"),
    [
        ((ROOT / "examples" / "columns" / "mortar.toml").read_text(encoding="utf-8"), {"bond1.share"}),
        (ALL_PARTS, {"bond1.share", "contact1.gap", "bearing4.dx", "tie1.F", "port1.Fx"}),
    ],
    ids=["column", "structure"],
)
def test_plain_names_of_every_part_have_no_brackets(
    tmp_path: Path, text: str, named: set[str], form: Form | None
) -> None:
    file, fmu = tmp_path / "model.toml", tmp_path / "plain.fmu"
    file.write_text(text, encoding="utf-8")
    if form is None:
        build_fmu(file, fmu, plain_names=True)
    else:
        platform = "linux64" if form.fmi == 2 else "x86_64-linux"
        build_native_fmu(file, fmu, platforms=[platform], form=form, plain_names=True)
    names = {variable.name for variable in read_model_description(str(fmu)).modelVariables}
    assert {"block1.ux", *named} <= names
    assert not [name for name in names if "[" in name]


def test_carries_both_binaries_and_only_what_it_needs(archive: dict[str, bytes]) -> None:
    binaries = {name for name in archive if name.startswith("binaries/")}
    assert binaries - {"binaries/linux64/pythonfmu.so"} == {
        "binaries/linux64/phocas_damped.so",
        "binaries/win64/phocas_damped.dll",
    }
    here = (str(ROOT), str(Path.home()))
    for name, content in archive.items():
        if name.startswith(("modelDescription", "documentation")):
            assert not any(path.encode() in content for path in here if len(path) > 1), name
    assert not any(name.endswith(("plots.py", "documentation.py", ".pyc")) for name in archive)


def test_the_picture_is_of_the_column(tmp_path: Path) -> None:
    (tmp_path / "squat.toml").write_text(DAMPED.read_text().replace("height = 4.69", "height = 2.0", 1))
    column, squat = Column.from_toml(DAMPED), Column.from_toml(tmp_path / "squat.toml")
    assert drawing(column) == drawing(column)
    assert drawing(column) != drawing(squat)
