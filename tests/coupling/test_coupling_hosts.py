"""The coupled systems as SSP and without Python: in masters that open SSP, and under a host in C."""

from __future__ import annotations

import importlib.util
import json
import math
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.ssp.ssd import read_ssd
from numpy.typing import NDArray
from support.child import call_with_example as example
from support.fmus import ROOT, built_once, run
from support.inside import coupled as inside
from support.inside import systems

pytestmark = pytest.mark.long  # builds native FMUs

if not sys.platform.startswith("linux"):
    pytest.skip("the libraries are built for Linux", allow_module_level=True)

FloatArray = NDArray[np.float64]
EXAMPLE = ROOT / "examples" / "coupling"
SPACES = {"ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription", "ssc": f"{systems.VALUES[1:-16]}Common"}
PARTNERS = ("isolator", "soil")
STEPS = 300
IN_C = 3000

Solved = Callable[[str, int], FloatArray]


@pytest.fixture(scope="module")
def as_one(native_coupled: Path, tmp_path_factory: pytest.TempPathFactory) -> Solved:
    """Return a function of partner and steps: the system solved as one, solved once, for it compiles kernels."""

    def solved(partner: str, steps: int) -> FloatArray:
        def solve(path: Path) -> None:
            path.write_text(json.dumps(example(systems.as_one, native_coupled, partner, IN_C)))

        return np.array(json.loads(built_once(tmp_path_factory, f"{partner}.json", solve).read_text())[:steps])

    return solved


def test_partners_without_python_give_the_bits_of_those_with(native_coupled: Path, coupled: Path) -> None:
    ways: list[tuple[str, dict[str, Any]]] = [
        ("isolator", {"slope": "line"}),
        ("isolator", {"kind": "lead-rubber"}),
        ("isolator", {"kind": "friction-pendulum", "damping": 1e3}),
        ("soil", {"weight": 7.9e5}),
    ]
    for partner, parameters in ways:
        same, moved = example(inside.same, native_coupled, coupled, partner, parameters)
        assert same, (partner, parameters)
        assert moved > 1e-5


def test_partners_without_python_are_sound_fmus(native_coupled: Path) -> None:
    for name in (*PARTNERS, "ground"):
        assert "No problems found" in run("fmpy", "validate", native_coupled / f"{name}.fmu")
    for name in PARTNERS:
        found = example(inside.kept_state, native_coupled / f"{name}.fmu")
        assert found["same"]
        assert found["moved"]
        assert "(error)" in found["backwards"]
        assert "discard" in found["no number"].lower()


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("isolator", {"kind": "linea"}),
        ("isolator", {"mass": 0.0}),
        ("soil", {"poisson": 0.4}),
        ("soil", {"mass": math.inf}),
    ],
)
def test_what_a_partner_cannot_be_is_refused(native_coupled: Path, coupled: Path, name: str, parameters: Any) -> None:
    for folder in (native_coupled, coupled):
        assert "error" in example(inside.refused, folder / f"{name}.fmu", parameters).lower()
    assert example(inside.refused, native_coupled / f"{name}.fmu", {}) == ""


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
def test_on_partners_without_python_the_system_is_as_if_solved_as_one(native_coupled: Path) -> None:
    for name, seen in example(inside.on_every_partner, native_coupled, [(1e-3, "")]).items():
        ((top, other, given, taken),) = seen
        assert top < 2e-3, name
        assert other < (2e-2 if "soil" in name else 2e-3), name  # the foundation hardly rotates
        assert given == pytest.approx(taken, rel=2e-3), name


def test_the_ground_is_the_record(native_coupled: Path) -> None:
    table = np.loadtxt(native_coupled / "waves.csv", delimiter=",", skiprows=1)

    def record(t: Any) -> Any:
        return np.interp(t, table[:, 0], table[:, 1])

    for step, given in ((1e-3, 1e-3), (1e-3, 0.0), (0.025, 0.025), (0.003, 0.0)):
        seen = np.array(example(inside.ground, native_coupled / "ground.fmu", step, given, 200))
        t = step * np.arange(200)
        assert seen[:, 0] == pytest.approx(record(t), abs=1e-14)
        begin = 0 if given else 1  # the length of the first step is not known
        slopes = (record(t + step) - record(t)) / step
        assert seen[begin:, 1] == pytest.approx(slopes[begin:], abs=1e-10)
    assert seen[0, 1] == pytest.approx(table[1, 1] / 0.01, rel=1e-12)


@pytest.mark.parametrize("partner", PARTNERS)
def test_a_host_in_c_runs_the_coupled_system(
    native_coupled: Path, as_one: Solved, tmp_path: Path, partner: str
) -> None:
    host = tmp_path / "master"
    options = ("-target", "x86_64-linux-gnu", "-std=gnu11", "-Wall", "-Wextra", "-Werror", "-O1")
    run(sys.executable, "-m", "ziglang", "cc", *options, EXAMPLE / "master.c", "-o", host, "-ldl")
    wiring = native_coupled / "in_c" / f"{systems.NAMES[partner]}.txt"
    stop = str(IN_C * systems.STEP)
    done = subprocess.run([host, wiring, "0.001", stop], capture_output=True, text=True, env={}, check=False)
    assert done.returncode == 0, done.stderr
    rows = np.array([[float(word) for word in line.split(",")] for line in done.stdout.splitlines()])[1:, 1:]
    expected = np.array(example(systems.one_pass, native_coupled, partner, IN_C))[:, :2]
    assert np.max(np.abs(expected), axis=0) == pytest.approx(np.max(np.abs(rows), axis=0))
    assert np.all(np.max(np.abs(rows - expected), axis=0) < 1e-9 * np.max(np.abs(expected), axis=0))
    truth = as_one(partner, IN_C)
    top, other = np.max(np.abs(rows - truth), axis=0) / np.max(np.abs(truth), axis=0)
    assert top < 1e-4  # measured 2e-6, 2e-5
    assert other < (2e-2 if partner == "soil" else 1e-6)  # measured 5e-3, of a tenth of a millimetre, and 5e-8
    missing = subprocess.run([host, tmp_path / "none", "0.001", "1"], capture_output=True, text=True, check=False)
    assert missing.returncode == 1
    assert "cannot be read" in missing.stderr


# --- SSP


# tag -> the tags within that the importer of OMSimulator knows (src/OMSimulatorLib, August 2026); it refuses a file
# with any other one
KNOWN_TO_OMSIMULATOR = {
    "SystemStructureDescription": "System Units Enumerations DefaultExperiment",
    "System": "ElementGeometry ParameterBindings Connections Connectors Elements Annotations",
    "Elements": "System Component",
    "Component": "Connectors ElementGeometry ParameterBindings",
    "ParameterBindings": "ParameterBinding",
    "ParameterBinding": "ParameterValues ParameterMapping",
    "Connectors": "Connector",
    "Connector": "ConnectorGeometry Real Integer Boolean String Enumeration Binary",
    "Connections": "Connection",
    "Connection": "ConnectionGeometry",
    "Units": "Unit",
    "Unit": "BaseUnit",
    "Annotation": "Annotations",
    "Annotations": "Annotation SimulationInformation Buses Connections SignalFilter",
    "SimulationInformation": "FixedStepMaster VariableStepMaster VariableStepSolver",
}


@pytest.mark.parametrize("partner", PARTNERS)
@pytest.mark.parametrize("inside", [True, False])
def test_the_importer_of_omsimulator_knows_every_tag(native_coupled: Path, partner: str, inside: bool) -> None:
    name = {"isolator": "isolated", "soil": "on_soil"}[partner] + ("" if inside else "_inputs")
    with zipfile.ZipFile(native_coupled / f"{name}.ssp") as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    unknown = {
        (parent.tag.rpartition("}")[2], child.tag.rpartition("}")[2]) for parent in root.iter() for child in parent
    } - {(parent, child) for parent, known in KNOWN_TO_OMSIMULATOR.items() for child in known.split()}
    assert not unknown


@pytest.mark.parametrize("name", ["isolated", "on_soil", "isolated_inputs", "on_soil_inputs"])
def test_an_ssp_connects_what_there_is(native_coupled: Path, name: str) -> None:
    file = native_coupled / f"{name}.ssp"
    read_ssd(str(file))  # checks it by the schema
    with zipfile.ZipFile(file) as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
        names = set(archive.namelist())
        sets = {each: ElementTree.fromstring(archive.read(each)) for each in names if each.endswith(".ssv")}
    variables = {}
    for component in root.iterfind(".//ssd:Component", SPACES):
        part, source = component.get("name") or "", component.get("source") or ""
        assert source in names
        partner = "soil" if "soil" in name else "isolator"
        description = read_model_description(systems.path_of(str(native_coupled), partner, part))
        variables[part] = {variable.name: variable for variable in description.modelVariables}
        for connector in component.iterfind("ssd:Connectors/ssd:Connector", SPACES):
            variable = variables[part][connector.get("name") or ""]
            assert (variable.causality, variable.unit) == (connector.get("kind"), connector[0].get("unit"))
            assert connector.find("ssd:ConnectorGeometry", SPACES) is not None
        shown = {item.get("name") for item in component.iterfind("ssd:Connectors/ssd:Connector", SPACES)}
        looked_at = {f"block[{i}].ux" for i in (1, 2, 3)} | {f"joint[{i}].{name}" for i in (1, 2, 3) for name in "NMT"}
        assert part != "column" or looked_at <= shown
        outputs = {each.name for each in description.modelVariables if each.causality == "output"}
        assert part in ("column", "ground") or outputs <= shown
        assert component.find("ssd:ElementGeometry", SPACES) is not None
        for binding in component.iterfind(".//ssd:ParameterBinding", SPACES):
            given = sets.pop(binding.get("source") or "").iter(f"{systems.VALUES}Parameter")
            assert all(variables[part][item.get("name") or ""].causality == "parameter" for item in given)
    assert not sets
    own = {
        connector.get("name") or "" for connector in root.iterfind("ssd:System/ssd:Connectors/ssd:Connector", SPACES)
    }
    inputs = {item for item in own if item.startswith("ground_")}
    assert inputs == ({"ground_ax", "ground_az", "ground_jx", "ground_jz"} if "inputs" in name else set())
    assert not any("." in item for item in own)  # OMSimulator takes what stands before it for an element
    assert {"column_block1_ux", "column_joint3_M", f"{'soil' if 'soil' in name else 'isolator'}_x"} <= own or not own
    connections = root.findall(".//ssd:Connection", SPACES)
    to_outside = [connection for connection in connections if connection.get("endElement") is None]
    assert {connection.get("endConnector") for connection in to_outside} == own - inputs
    assert len(connections) - len(to_outside) == (19 if "soil" in name else 12)
    for connection in connections:
        if connection in to_outside:
            continue
        start, end = connection.get("startElement"), connection.get("endElement") or ""
        source = connection.get("startConnector") or ""
        target = variables[end][connection.get("endConnector") or ""]
        assert target.causality == "input"
        if start:
            assert (variables[start][source].causality, variables[start][source].unit) == ("output", target.unit)
        else:
            assert source in own
    (master,) = (item for item in root.iter() if item.tag.endswith("}FixedStepMaster"))  # OMSimulator aborts without
    assert float(master.get("stepSize") or "") == systems.STEP


@pytest.fixture(scope="module", params=["native_coupled", "coupled"])
def folder(request: pytest.FixtureRequest) -> Path:
    found: Path = request.getfixturevalue(request.param)
    return found


@pytest.mark.parametrize("partner", PARTNERS)
@pytest.mark.parametrize(("way", "package"), [("libcosim", "libcosimpy"), ("ecos", "ecospy")])
def test_the_ssp_runs_where_every_value_is_handed_over_once_a_step(
    folder: Path, as_one: Solved, partner: str, way: str, package: str
) -> None:
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed: the extra masters")
    libraries = Path(sys.prefix) / "lib"
    if way == "ecos" and not list(libraries.glob("libtbb.so.12")):
        pytest.skip("ecospy needs libtbb.so.12, which pip install tbb brings")
    if way == "ecos" and folder.name == "coupled":
        pytest.skip("ecos in Python loads PythonFMUs as tests/coupling/test_masters.py shows")
    seen = np.array(example(getattr(systems, way), folder, partner, STEPS, LD_LIBRARY_PATH=str(libraries)))
    once = np.array(example(systems.one_pass, folder, partner, STEPS))
    size = np.max(np.abs(once), axis=0)
    assert np.all(np.max(np.abs(seen - once), axis=0) < 1e-9 * size)
    truth = as_one(partner, STEPS)
    top, other = np.max(np.abs(seen[:, :2] - truth), axis=0) / np.max(np.abs(truth), axis=0)
    assert top < 1e-4
    assert other < (2e-2 if partner == "soil" else 1e-5)


@pytest.mark.parametrize("partner", PARTNERS)
def test_no_output_is_read_between_a_set_and_the_step(folder: Path, as_one: Solved, partner: str) -> None:
    seen = np.array(example(systems.strict_master, folder, partner, STEPS))
    truth = as_one(partner, STEPS)
    top, other = np.max(np.abs(seen - truth), axis=0) / np.max(np.abs(truth), axis=0)
    assert top < 1e-5  # measured 1e-7, 3e-7
    assert other < (2e-2 if partner == "soil" else 1e-6)


@pytest.mark.parametrize("partner", PARTNERS)
def test_the_ssp_runs_in_fmpy(folder: Path, partner: str) -> None:
    seen = np.array(example(systems.fmpy, folder, partner, STEPS))
    once = np.array(example(systems.one_pass, folder, partner, STEPS, True))
    assert seen.shape == once.shape
    assert np.all(np.max(np.abs(seen - once), axis=0) < 1e-9 * np.max(np.abs(once), axis=0))


@pytest.mark.campaign
def test_the_table_of_hosts_has_a_row_for_each_system(native_coupled: Path) -> None:
    script = ROOT / "tests" / "masters" / "coupled_hosts.py"
    host = "steps in parallel, FMPy"
    text = run(sys.executable, script, "--folder", native_coupled, "--host", host, "--stop", "0.1")
    rows = [[cell.strip() for cell in line.strip("| ").split("|")] for line in text.splitlines() if line[:1] == "|"]
    assert rows[0] == ["host", "on", "by", "2 ms", "1 ms", "0.5 ms", "order", "up to"]
    assert [row[1] for row in rows[2:]] == ["linear isolators", "soil, 250 m/s"]
    for row in rows[2:]:
        assert row[0].startswith(host)
        assert float(row[4]) < 1e-4
        assert row[7] in ("1 ms", "2 ms", "5 ms", "10 ms")


def test_the_ssp_runs_in_omsimulator(native_coupled: Path, tmp_path: Path) -> None:
    binary = shutil.which("OMSimulator")
    if binary is None:
        pytest.skip("OMSimulator is not installed: its package on PyPI fetches the program from its own server")
    result = tmp_path / "result.csv"
    stop = STEPS * systems.STEP
    run(binary, "--mode=cs", f"--stopTime={stop}", f"--resultFile={result}", native_coupled / "isolated.ssp")
    header = result.read_text(encoding="utf-8").splitlines()[0].replace('"', "").split(",")
    table = np.loadtxt(result, delimiter=",", skiprows=1)
    table = table[np.append(np.diff(table[:, 0]) > 0.0, True)]  # two rows an instant: the last has the values after it
    (place,) = (k for k, name in enumerate(header) if name.endswith("column.block[1].ux"))
    expected = np.array(example(systems.sorted_master, native_coupled, "isolator", STEPS))[:, 0]
    count = min(len(table) - 1, STEPS)
    assert table[1 : count + 1, place] == pytest.approx(expected[:count], abs=1e-9 * np.max(np.abs(expected)))
