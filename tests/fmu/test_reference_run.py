"""Reference results inside FMUs, and the command that repeats them."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from support.fmus import DAMPED, LINUX, ROOT, finish, run

from build_fmu import build_fmu, write_archive
from fmu_src.drive import Drive
from fmu_src.reference_run import FOLDER

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
        files = {name: archive.read(name) for name in archive.namelist()}
    name = f"{FOLDER}/phocas_damped_out.csv"
    header, *rows = files[name].decode().splitlines()
    table = np.array([row.split(",") for row in rows], dtype=float)
    table[50, 1] += 1e-3 * np.max(np.abs(table[:, 1]))
    files[name] = "\n".join([header, *(",".join(map(repr, row)) for row in table.tolist())]).encode()
    write_archive(tmp_path / "other.fmu", files)
    done = finish(*REPLAY, tmp_path / "other.fmu")
    assert done.returncode == 2
    assert "must be at most 1e-05" in done.stderr


def test_an_fmu_without_them_says_so(tmp_path: Path) -> None:
    done = finish(*REPLAY, build_fmu(DAMPED, tmp_path / "without.fmu"))
    assert done.returncode == 2
    assert "build-fmu --reference" in done.stderr


def test_the_manifest_names_the_files(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        inside = set(archive.namelist())
        manifest = archive.read(f"{FOLDER}/fmi-ls-manifest.xml").decode()
    for end in ("in", "out"):
        assert f"{FOLDER}/phocas_damped_{end}.csv" in inside
        assert f'source="phocas_damped_{end}.csv"' in manifest


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
