"""Fixtures shared by the tests."""

import os
import signal
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import settings

# before numpy is imported: each worker has one core, and threads of BLAS that wait by spinning take three times as long
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ["MULTIBLOCK_COMPILES"] = "1"  # of this process, whose tests compile kernels: numba_ext/jit.py takes it out

from support.fmus import DAMPED, HERE, LINUX, PHOCAS, ROOT, Fmus, building, built_once, run
from support.groups import OF_LONG_TESTS
from support.inside.this_processor import carry_for_this_processor

from solver.kernels.machine.groups import GROUPS
from solver.kernels.machine.making import make


def pytest_configure(config: pytest.Config) -> None:
    """Restore the action of SIGINT: a shell's background job hands on SIGINT as ignored, and a child would
    ignore it.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if is_quick(config):
        os.environ[HERE] = "1"
        carry_for_this_processor()
    # many columns of the tests are drawn at random, or odd on purpose; pytest would import the solver too early for it
    config.addinivalue_line("filterwarnings", "ignore::solver.common.errors.InputWarning")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Make the machine code of most tests once, before each worker begins to."""
    if session.config.getoption("numprocesses", None):
        make([group for group in GROUPS if not (is_quick(session.config) and group in OF_LONG_TESTS)])


def is_quick(config: pytest.Config) -> bool:
    """Return True if no long test is asked for."""
    return "not long" in config.getoption("markexpr")


settings.register_profile("any machine", deadline=None)  # however busy it is: nothing is timed here
settings.load_profile("any machine")


@pytest.fixture(scope="session")
def records() -> Path:
    """Return the folder of the recorded ground motions, which are not part of the project."""
    folder = ROOT.parent / "shared" / "records"
    if not folder.is_dir():
        pytest.skip(f"no recorded ground motions in {folder}")
    return folder


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Fmus:
    """Return the FMUs of the two example columns."""
    tmp_path_factory.getbasetemp()  # made before two threads ask for it

    def built(name: str, file: Path) -> Path:
        return built_once(tmp_path_factory, name, lambda path: Fmus.build(file, path))

    with ThreadPoolExecutor(2) as pool:  # at once: the other workers wait for both
        phocas, damped = pool.map(built, ("phocas.fmu", "damped.fmu"), (PHOCAS, DAMPED))
    return Fmus(phocas=phocas, damped=damped)


@pytest.fixture(scope="session")
def trilith(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the FMU of a structure in space."""
    file = ROOT / "examples" / "structures" / "trilith.toml"
    return built_once(tmp_path_factory, "trilith.fmu", lambda path: Fmus.build(file, path))


@pytest.fixture(scope="session")
def native_trilith(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the same without Python, for Linux."""
    pytest.importorskip("ziglang", reason="needs the extra native")
    file = ROOT / "examples" / "structures" / "trilith.toml"
    return built_once(tmp_path_factory, "native_trilith.fmu", lambda path: Fmus.build(file, path, *LINUX))


@pytest.fixture(scope="session")
def native(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the damped example as a native FMU of FMI 2.0, for Linux, with its base as a terminal."""
    pytest.importorskip("ziglang", reason="needs the extra native")
    return built_once(tmp_path_factory, "native.fmu", lambda path: Fmus.build(DAMPED, path, *LINUX, "--terminals"))


@pytest.fixture(scope="session")
def native3(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the same of FMI 3.0, for all platforms."""
    pytest.importorskip("ziglang", reason="needs the extra native")
    return built_once(tmp_path_factory, "native3.fmu", lambda path: Fmus.build(DAMPED, path, "--native", "--fmi", "3"))


@pytest.fixture(scope="session")
def coupled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the FMUs and SSPs of examples/coupling, with Python but for the ground."""
    return built_once(tmp_path_factory, "coupled", lambda path: coupling(path))


@pytest.fixture(scope="session")
def native_coupled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the same without Python."""
    return built_once(tmp_path_factory, "native_coupled", lambda path: coupling(path, "--native"))


def coupling(folder: Path, *options: str) -> str:
    """Build the coupled systems by the example's own command, for Linux."""
    program = ROOT / "examples" / "coupling" / "build.py"
    return run(*building(program), "-o", folder, "--platforms", "linux64", *options)
