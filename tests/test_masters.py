"""The FMU in masters that others wrote; those that are not installed are skipped (pip install -e ".[masters]")."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from fmus import Fmus, environment, run

H, STOP, AX = 0.01, 2.0, 0.5  # s, s, m/s2

# 200 steps under a held acceleration; prints the displacement of the top block and the force under it
ALONE = """
import sys
from instance import Instance
column = Instance(sys.argv[1], {"base.ax": 0.5})
for k in range(200):
    column.step(0.01 * k, 0.01)
print(*column.get("block[1].ux", "joint[1].N"))
"""

LIBCOSIM = """
import sys
from fmpy import read_model_description
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
references = {v.name: v.valueReference for v in read_model_description(sys.argv[1]).modelVariables}
execution = CosimExecution.from_step_size(10_000_000)  # ns
index = execution.add_local_slave(CosimLocalSlave(sys.argv[1], "column"))
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.real_initial_value(index, references["base.ax"], 0.5)
assert execution.simulate_until(2_000_000_000)
print(*observer.last_real_values(index, [references["block[1].ux"], references["joint[1].N"]]))
"""

ECOS = """
import sys
from ecospy import EcosSimulation, EcosSimulationStructure
from ecospy.EcosParameterSet import EcosParameterSet
structure = EcosSimulationStructure()
structure.add_model("column", sys.argv[1])
values = EcosParameterSet()
values.add_real("column::base.ax", 0.5)
structure.add_parameter_set("initial", values)
simulation = EcosSimulation(structure=structure, step_size=0.01)
simulation.init(parameter_set="initial")
simulation.step(200)
print(simulation.get_real("column::block[1].ux"), simulation.get_real("column::joint[1].N"))
simulation.terminate()
"""

COMPLAINTS = ("error", "warn", "fatal", "fail")


@pytest.fixture(scope="module")
def alone(fmus: Fmus) -> list[float]:
    """What the column does under FMPy."""
    return [float(word) for word in run(sys.executable, "-c", ALONE, fmus.damped).split()]


def said(*command: object, cwd: Path | None = None, **variables: str) -> tuple[str, str]:
    """Output and error output of a process; fails unless it ends with 0."""
    done = subprocess.run(
        [str(part) for part in command],
        capture_output=True,
        text=True,
        env=environment() | variables,
        cwd=cwd,
        check=False,
    )
    assert done.returncode == 0, f"exit code {done.returncode}: {done.stderr}"
    return done.stdout, done.stderr


def libraries() -> str:
    """Where pip puts shared libraries, such as the tbb that ecos is linked with."""
    return os.pathsep.join((str(Path(sys.prefix) / "lib"), os.environ.get("LD_LIBRARY_PATH", "")))


def package(name: str) -> Path:
    """Folder of an installed package; skips where it is absent."""
    spec = importlib.util.find_spec(name)
    if spec is None or spec.origin is None:
        pytest.skip(f"{name} is not installed")
    return Path(spec.origin).parent


def test_what_pip_does_not_install_is_tried_or_skipped_with_a_reason(fmus: Fmus) -> None:
    out = run(sys.executable, Path(__file__).parent / "masters" / "run.py", fmus.damped, fmus.phocas)
    lines = out.splitlines()
    assert len(lines) == 12
    assert all(any(word in line for word in ("skipped: ", "the same twice", "runs", "no ")) for line in lines)
    if not any("C host: skipped" in line for line in lines):
        for _ in range(4):  # without the clean exit every such process aborts
            run(sys.executable, Path(__file__).parent / "masters" / "run.py", fmus.damped)


def test_libcosim(fmus: Fmus, alone: list[float]) -> None:
    package("libcosimpy")
    out, err = said(sys.executable, "-c", LIBCOSIM, fmus.damped)
    log = [line for line in (out + err).splitlines() if line.startswith("[")]
    ignored = [line for line in log if "Enumeration variable type not supported" in line]  # they stay as built
    assert len(ignored) == 2
    log = [line for line in log if line not in ignored]
    assert not [line for line in log if any(f"[{word}" in line for word in COMPLAINTS)]
    (numbers,) = [line for line in out.splitlines() if not line.startswith("[")]
    assert [float(word) for word in numbers.split()] == pytest.approx(alone, rel=1e-9)


def test_ecos_inside_python(fmus: Fmus, alone: list[float]) -> None:
    package("ecospy")
    if importlib.util.find_spec("ecospy") and not list((Path(sys.prefix) / "lib").glob("libtbb.so.12")):
        pytest.skip("ecospy needs libtbb.so.12, which pip install tbb brings")
    out, err = said(sys.executable, "-c", ECOS, fmus.damped, LD_LIBRARY_PATH=libraries())
    assert not any(word in err.lower() for word in COMPLAINTS)
    assert [float(word) for word in out.split()] == pytest.approx(alone, rel=1e-9)


def test_ecos_on_the_command_line_starts_python_itself(fmus: Fmus, tmp_path: Path) -> None:
    binary = tmp_path / "ecos"
    shutil.copy(package("ecospy") / "binaries" / "ecos", binary)
    binary.chmod(0o755)  # the wheel forgets it
    python = Path(sysconfig.get_config_var("LIBDIR")) / (sysconfig.get_config_var("INSTSONAME") or "")
    if not python.is_file() or not list((Path(sys.prefix) / "lib").glob("libtbb.so.12")):
        pytest.skip("needs a shared libpython and libtbb.so.12")
    out, err = said(
        *(binary, "simulate", "--path", fmus.damped, "--stopTime", STOP, "--stepSize", H),
        cwd=tmp_path,
        LD_PRELOAD=str(python),
        LD_LIBRARY_PATH=libraries(),
        PYTHONPATH=sysconfig.get_paths()["purelib"],
    )
    assert "[error]" not in out + err
    assert "zero for the whole run" in err  # ecos has no way to set an input here: our own warning, and no other
    assert err.count("\n") == 1
    assert (tmp_path / "phocas-damped.csv").stat().st_size > 1000


@pytest.mark.parametrize("n", [1, 3, 40])
def test_fmu_manipulation_toolbox_checks_any_column(fmus: Fmus, tmp_path: Path, n: int) -> None:
    package("fmu_manipulation_toolbox")
    block = "[[block]]\nheight = 1.0\nwidth = 1.0\ndepth = 1.0\ndensity = 2000.0\n"
    column = tmp_path / "stack.toml"
    column.write_text('name = "stack"\n' + block * n + "[joint]\nstiffness = 1e9\ndamping = 1e-3\n")
    out, err = said("fmutool", "-input", fmus.build(column, tmp_path / "stack.fmu"), "-check")
    assert "seems to be compliant" in out + err
    assert "No semantic error" in out + err
    assert not any(word in (out + err) for word in ("ERROR", "WARNING"))


def test_two_columns_merged_into_one_fmu(fmus: Fmus, tmp_path: Path, alone: list[float]) -> None:
    package("fmu_manipulation_toolbox")
    shutil.copy(fmus.damped, tmp_path / "damped.fmu")
    shutil.copy(fmus.phocas, tmp_path / "phocas.fmu")
    (tmp_path / "both.json").write_text(
        '{"name": "both.fmu", "fmu": ["damped.fmu", "phocas.fmu"], "step_size": 0.01, "auto_link": false,'
        '"auto_input": false, "auto_output": false, "auto_parameter": false, "link": [], "start": [],'
        '"input": [["ax", "damped.fmu", "base.ax"], ["ax", "phocas.fmu", "base.ax"]],'
        '"output": [["damped.fmu", "block[1].ux", "damped"], ["phocas.fmu", "block[1].ux", "phocas"]]}'
    )
    said("fmucontainer", "-container", "both.json", cwd=tmp_path)
    assert "No problems found" in run("fmpy", "validate", tmp_path / "both.fmu")
    script = (
        "import sys\nimport numpy as np\nfrom fmpy import simulate_fmu\n"
        "result = simulate_fmu(sys.argv[1], stop_time=2.0, output_interval=0.01, start_values={'ax': 0.5})\n"
        "np.save(sys.argv[2], result[['damped', 'phocas']][-1].tolist())"
    )
    run(sys.executable, "-c", script, tmp_path / "both.fmu", tmp_path / "both.npy")
    damped, phocas = np.load(tmp_path / "both.npy")
    assert damped == pytest.approx(alone[0], rel=1e-9)
    assert phocas == pytest.approx(float(run(sys.executable, "-c", ALONE, fmus.phocas).split()[0]), rel=1e-6)
