"""The column on isolators and on soil, FMU by FMU, against the same systems solved as one and against closed form."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from graphlib import TopologicalSorter
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy import read_model_description
from fmus import REFUSED, ROOT, environment, run

EXAMPLE = ROOT / "examples" / "coupling"


def script(text: str, *arguments: object) -> str:
    """What a script prints that has the modules of the example in reach."""
    there = environment()
    there["PYTHONPATH"] = f"{EXAMPLE}:{there['PYTHONPATH']}"
    done = subprocess.run(
        [sys.executable, "-c", text, *map(str, arguments)], capture_output=True, text=True, env=there, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the FMUs and the SSP of the example, built by its own command."""
    folder = tmp_path_factory.mktemp("coupled")
    run(sys.executable, EXAMPLE / "build.py", "-o", folder)
    return folder


@pytest.mark.parametrize("partner", ["isolator", "soil"])
def test_initialization_has_no_algebraic_loop(built: Path, partner: str) -> None:
    """Outputs of initialization and what they follow, within the FMUs and through the connections."""
    follows: dict[tuple[str, str], set[tuple[str, str]]] = {}
    variables = {}
    for part in ("column", partner):
        description = read_model_description(str(built / f"{part}.fmu"))
        variables[part] = {variable.name for variable in description.modelVariables}
        for unknown in description.initialUnknowns:
            assert unknown.dependencies is not None
            names = {(part, variable.name) for variable in unknown.dependencies}
            follows[part, unknown.variable.name] = names
            if part == "column":
                reaction = unknown.variable.name.removeprefix("base.")
                follows[partner, f"column.{reaction}"] = {(part, unknown.variable.name)}
    for name in ("ax", "az", "jx", "jz", "theta", "omega", "alpha"):
        if f"base.{name}" in variables[partner]:
            follows["column", f"base.{name}"] = {(partner, f"base.{name}")}
    TopologicalSorter(follows).prepare()  # raises CycleError


CASES = """
import json, sys
from pathlib import Path
from accuracy import PARTNERS, SCENES, Case, harmonic, linear
fmus = {name: Path(sys.argv[1]) / f"{name}.fmu" for name in ("column", "isolator", "soil")}

def seen(case, *ways):
    found = []
    for h, way in ways:
        run = case.couple(h, way)
        found.append([*case.errors(run), run["work_given"], run["work_taken"]])
    return found
"""


def test_the_split_reaction_couples_what_the_plain_one_blows_up(built: Path) -> None:
    printed = script(
        CASES + "for eta in (1e-3, 0.0):\n"
        "    case = Case(fmus, eta, 'linear', linear(0.01), harmonic('0.2 g 2 Hz', 0.8))\n"
        "    ways = [(h, 'line') for h in (2e-3, 1e-3, 5e-4)]\n"
        "    ways = (1e-3, 'plain'), *ways, (1e-3, 'iterated'), (1e-3, 'parabola')\n"
        "    print(json.dumps([case.window, case.agreement, seen(case, *ways)]))\n"
        "case = Case(fmus, 1e-3, 'linear', linear(100.0), harmonic('0.2 g 2 Hz', 0.8))\n"
        "print(json.dumps([case.window, case.agreement, seen(case, (1e-3, 'plain'), (1e-3, ''))]))\n",
        built,
    )
    light, undamped, heavy = (json.loads(line) for line in printed.splitlines())
    for window, agreement, (plain, coarse, middle, fine, iterated, parabola) in (light, undamped):
        assert window > 400
        assert agreement < 1e-5
        assert plain[0] > 10.0
        assert middle[0] < 2e-3
        assert middle[1] < 2e-3
        assert np.log2(coarse[0] / fine[0]) / 2.0 > 1.6
        assert iterated[0] < 0.5 * middle[0]
        assert parabola[0] < 0.3 * middle[0]
        assert middle[2] == pytest.approx(middle[3], rel=1e-3)
        assert iterated[2] == pytest.approx(iterated[3], rel=1e-4)
    window, _, (plain, split) = heavy
    assert plain[0] < 1.0  # stable
    assert split[0] < 2e-3


def test_every_partner_agrees_with_the_system_solved_as_one(built: Path) -> None:
    printed = script(
        CASES + "for name in PARTNERS:\n"
        "    case = Case(fmus, 1e-3, *PARTNERS[name], harmonic('0.1 g 1 Hz', 0.8))\n"
        "    print(json.dumps([name, seen(case, (1e-3, ''), (5e-4, ''), (1e-3, 'iterated'))]))\n",
        built,
    )
    for line in printed.splitlines():
        name, ((top, other, given, taken), (finer, _, _, _), (again, _, _, _)) = json.loads(line)
        assert top < 2e-3, name
        assert other < (2e-2 if "soil" in name else 2e-3), name  # the foundation hardly rotates
        assert finer < 0.5 * top, name
        assert again < 2e-3, name
        assert given == pytest.approx(taken, rel=2e-3), name


def test_a_slab_alone_is_an_oscillator(built: Path) -> None:
    printed = script(
        "import json, sys\nimport numpy as np\nfrom master import Fmu\n"
        "slab = Fmu(sys.argv[1], mass=1e4, stiffness=1e4 * 40.0, damping=1e4 * 1.0)\n"
        "h, x = 1e-3, []\n"
        "for k in range(4000):\n"
        "    slab.set(**{'ground.ax': np.sin(5.0 * k * h),\n"
        "                'ground.jx': (np.sin(5.0 * (k + 1) * h) - np.sin(5.0 * k * h)) / h})\n"
        "    slab.step(k * h, h)\n"
        "    x += slab.get('x')\n"
        "print(json.dumps(x))",
        built / "isolator.fmu",
    )
    t = 1e-3 * np.arange(1, 4001)
    # x'' + x' + 40 x = -sin 5 t from rest
    steady = np.imag(-np.exp(5j * t) / (40.0 - 25.0 + 5j))
    start = np.imag(-1.0 / (15.0 + 5j)), np.imag(-5j / (15.0 + 5j))
    omega = np.sqrt(40.0 - 0.25)
    free = np.exp(-0.5 * t) * (start[0] * np.cos(omega * t) + (start[1] + 0.5 * start[0]) / omega * np.sin(omega * t))
    exact = steady - free
    assert np.max(np.abs(np.array(json.loads(printed)) - exact)) < 1e-4 * np.max(np.abs(exact))


def test_a_foundation_alone_follows_the_cones(built: Path) -> None:
    printed = script(
        "import json, sys\nfrom master import Fmu\n"
        "ends = []\n"
        "for port in ('R0x', 'R0z', 'R0m'):\n"
        "    soil = Fmu(sys.argv[1])\n"
        "    soil.set(**{f'column.{port}': 1e6})\n"
        "    for k in range(2000):\n"
        "        soil.step(k * 1e-3, 1e-3)\n"
        "    ends.append(soil.get('x', 'uz', 'base.theta'))\n"
        "    soil.close()\n"
        "print(json.dumps(ends))",
        built / "soil.fmu",
    )
    shear, r, nu = 1900.0 * 250.0**2, 3.0, 0.3
    springs = [8 * shear * r / (2 - nu), 4 * shear * r / (1 - nu), 8 * shear * r**3 / (3 * (1 - nu))]
    assert np.array(json.loads(printed)) == pytest.approx(np.diag(1e6 / np.array(springs)), rel=1e-6, abs=1e-12)


def test_partners_are_sound_fmus_whose_state_can_be_kept(built: Path) -> None:
    for name in ("isolator", "soil"):
        assert "No problems found" in run("fmpy", "validate", built / f"{name}.fmu")
        printed = script(
            "import math, sys\nfrom master import Fmu\n"
            "part = Fmu(sys.argv[1])\n"
            "def drive(first, last):\n"
            "    for k in range(first, last):\n"
            "        part.set(**{'ground.ax': math.sin(0.1 * k), 'column.R0x': 1e4 * math.cos(0.2 * k)})\n"
            "        part.step(k * 1e-3, 1e-3)\n"
            "    return part.get('x', 'v', 'base.ax', 'base.jx', 'work')\n"
            "drive(0, 50)\n"
            "saved = part.slave.serializeFMUstate(part.slave.getFMUState())\n"
            "first = drive(50, 100)\n"
            "part.slave.setFMUState(part.slave.deSerializeFMUstate(saved))\n"
            "print(first == drive(50, 100), first[0] != 0.0)\n"
            "for ax, h in ((0.0, -1e-3), (math.nan, 1e-3)):\n"
            "    part.set(**{'ground.ax': ax})\n"
            "    try:\n        part.step(0.1, h)\n    except Exception as error:\n        print(error)\n"
            "part.close()",
            built / f"{name}.fmu",
        )
        kept, wrong, refused = printed.splitlines()
        assert kept == "True True"
        assert f"({REFUSED})" in wrong
        assert "discard" in refused.lower()


def test_the_ssp_connects_what_there_is(built: Path) -> None:
    with zipfile.ZipFile(built / "isolated.ssp") as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
        names = set(archive.namelist())
    space = {"ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription"}
    variables = {}
    for component in root.iterfind(".//ssd:Component", space):
        name, source = component.get("name") or "", component.get("source") or ""
        assert source in names
        description = read_model_description(str(built / f"{name}.fmu"))
        variables[name] = {variable.name: variable.causality for variable in description.modelVariables}
    connections = root.findall(".//ssd:Connection", space)
    assert len(connections) == 12
    for connection in connections:
        start, end = connection.get("startElement"), connection.get("endElement") or ""
        if start:
            assert variables[start][connection.get("startConnector") or ""] == "output"
        assert variables[end][connection.get("endConnector") or ""] == "input"


def test_the_ssp_runs_in_fmpy(built: Path) -> None:
    printed = script(
        "import json, sys\nimport numpy as np\nfrom fmpy.ssp.simulation import simulate_ssp\n"
        "from master import Fmu, couple\n"
        "h, folder = 1e-3, sys.argv[1]\n"
        "def ground(t):\n    return np.sin(2.0 * np.pi * t)\n"
        "given = {'ground.ax': ground, 'ground.jx': lambda t: (ground(t + h) - ground(t)) / h}\n"
        "table = simulate_ssp(folder + '/isolated.ssp', stop_time=0.5, step_size=h, input=given)\n"
        "parts = Fmu(folder + '/column.fmu'), Fmu(folder + '/isolator.fmu')\n"
        "run = couple(*parts, ground, h, 0.5, watch=('base.R0x',))\n"
        "print(json.dumps([table['column.base.R0x'].tolist(), run['base.R0x'].tolist()]))",
        built,
    )
    ssp, master = (np.array(part) for part in json.loads(printed.splitlines()[-1]))
    count = min(len(ssp), len(master)) - 1
    late = ssp[:count] - master[1 : count + 1]  # of its time it shows the end of the step
    assert np.max(np.abs(late)) < 0.1 * np.max(np.abs(master))
