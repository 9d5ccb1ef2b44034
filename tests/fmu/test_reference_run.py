"""Reference results inside FMUs, and the command that repeats them."""

from __future__ import annotations

import math
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from support.fmus import DAMPED, LINUX, ROOT, run

from build_fmu import build_fmu
from fmu_src.drive import Drive
from fmu_src.reference_run import FOLDER, _difference

TRILITH = ROOT / "examples" / "structures" / "trilith.toml"
REPLAY = sys.executable, "-m", "multiblock", "replay"


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_fmu(DAMPED, tmp_path_factory.mktemp("fmu") / "with.fmu", reference=True)


def test_the_results_are_repeated(fmu: Path) -> None:
    """Compare with the stored results: measured 1.5e-10 of the largest value, by times that FMPy adds up; 1e-5 asked by
    the command.
    """
    assert "33 outputs at 101 instants" in run(*REPLAY, fmu)


def test_results_of_something_else_are_not(fmu: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith(FOLDER)]
        files = {name: archive.read(name).decode() for name in names}
        words = archive.read("documentation/fmi-ls-ref.txt").decode()
    related = ElementTree.fromstring(files[f"{FOLDER}/fmi-ls-manifest.xml"]).findall("Related")
    roles = {one.attrib["source"]: (one.attrib["role"], one.attrib["type"]) for one in related}
    assert roles["phocas_damped.exp"] == ("experiment/smoke-test", "application/x-ma-hs-experiments")
    assert roles["phocas_damped_out.csv"] == ("result", "text/csv")
    assert roles["../../documentation/fmi-ls-ref.txt"] == ("document", "text/plain")
    root = ElementTree.fromstring(files[f"{FOLDER}/phocas_damped.exp"])
    (experiment,) = root
    assert (root.tag, experiment.tag, set(root.attrib)) == ("Experiments", "Experiment", {"name", "description"})
    assert [child.tag for child in experiment] == ["TransientSimulation", "Stimuli", "References"]
    assert experiment[0].attrib == {"startTime": "0.0", "stopTime": "1.0", "stepSize": "0.01"}
    assert [child.attrib["source"] for child in experiment[1:]] == ["phocas_damped_in.csv", "phocas_damped_out.csv"]
    assert "beyond 1e-05 is a fault" in words
    # rules for CSV files of compatibility information: names in quotes, numbers without
    header, row, *_ = files[f"{FOLDER}/phocas_damped_out.csv"].splitlines()
    assert header.startswith('"time","')
    assert '"' not in row


def test_the_preferred_step_is_said(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode()
        description = ElementTree.fromstring(archive.read("modelDescription.xml"))
    usual = description.find("DefaultExperiment")
    assert usual is not None
    assert f"The preferred communication step is {float(usual.attrib['stepSize']):g} s" in page


@pytest.mark.long
@pytest.mark.parametrize(
    "options",
    [
        ("--native", "--fmi", "3", "--scalars", "--platforms", "x86_64-linux"),
        ("--native", "--fmi", "3", "--platforms", "x86_64-linux"),
        LINUX,
    ],
)
def test_native_fmus_repeat_them(options: tuple[str, ...], tmp_path: Path) -> None:
    file = tmp_path / "native.fmu"
    run(sys.executable, "-m", "multiblock", "build-fmu", TRILITH, "--reference", *options, "-o", file)
    assert "outputs at 101 instants" in run(*REPLAY, file)


@pytest.mark.long
@pytest.mark.parametrize(
    ("model", "drive"),
    [
        (DAMPED, Drive("body", "parabola", 2)),
        (DAMPED, Drive("horizontal", "line", 1)),
        (TRILITH, Drive("body", "parabola", 1, True)),
        (TRILITH, Drive(turns=True)),
    ],
)
def test_fmus_that_bodies_drive_repeat_them(model: Path, drive: Drive, tmp_path: Path) -> None:
    file = build_fmu(model, tmp_path / "driven.fmu", drive=drive, plain_names=True, reference=True)
    found = run(*REPLAY, file)
    assert "outputs at 101 instants" in found
    assert model == TRILITH or "33 outputs" in found


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_number_that_is_none_is_no_agreement(wrong: float) -> None:
    """Compare with a result that holds it: the largest of differences, one of which is NaN, may leave that out."""
    assert _difference(np.array([1.0, wrong]), np.array([1.0, 2.0]), 2.0) == math.inf
