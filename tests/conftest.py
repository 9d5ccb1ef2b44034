"""Fixtures shared by the tests."""

import signal
from pathlib import Path

import pytest
from hypothesis import settings
from support.fmus import ROOT, Fmus

from solver.dynamics.first_run import make_kernels


def pytest_configure() -> None:
    """Whatever started the tests: a shell's background job hands on SIGINT as ignored, and a child would ignore it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_sessionstart(session: pytest.Session) -> None:
    """What most tests need is compiled once, on two cores, before workers begin that would each do so."""
    if session.config.getoption("numprocesses", None):
        make_kernels()


settings.register_profile("any machine", deadline=None)  # however busy it is: nothing is timed here
settings.load_profile("any machine")


@pytest.fixture(scope="session")
def records() -> Path:
    """Folder of the recorded ground motions, which are not part of the project."""
    folder = ROOT.parent / "shared" / "records"
    if not folder.is_dir():
        pytest.skip(f"no recorded ground motions in {folder}")
    return folder


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Fmus:
    """The FMUs of the two example columns, built once."""
    folder = tmp_path_factory.mktemp("fmus")
    columns = ROOT / "examples" / "columns"
    return Fmus(
        phocas=Fmus.build(columns / "phocas.toml", folder / "phocas.fmu"),
        damped=Fmus.build(columns / "phocas-damped.toml", folder / "phocas-damped.fmu"),
    )
