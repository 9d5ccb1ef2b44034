"""The cached machine code is that of the sources as they are, in a folder that suits how they were installed."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from support.child import command, returned
from support.fmus import DAMPED, ROOT, finish_in
from support.inside import loads

from solver.kernels.numba_ext import cache


def loaded_kernel_says(project: Path) -> float:
    """Normal force of the top joint at rest, from a process of its own that caches beside the sources."""
    done = finish_in(project, *command(loads.normal_force, "phocas.toml"), PYTHONPATH=str(project))
    assert done.returncode == 0, done.stderr
    return float(returned(done.stdout))


@pytest.mark.long  # compiles the kernels twice
def test_a_change_in_any_kernel_file_is_compiled_again(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "solver", tmp_path / "solver", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(DAMPED, tmp_path / "phocas.toml")
    first = loaded_kernel_says(tmp_path)
    assert loaded_kernel_says(tmp_path) == first
    outputs = tmp_path / "solver" / "kernels" / "formulations" / "outputs.py"
    text = outputs.read_text()
    changed = text.replace("joints.N[i] = normal", "joints.N[i] = 2.0 * normal")
    assert changed != text
    outputs.write_text(changed)  # the entry's own file stays as it was
    assert loaded_kernel_says(tmp_path) == 2.0 * first


@pytest.mark.long  # compiles the kernels
def test_the_first_run_compiles_one_entry_and_finds_the_others_on_the_disk(tmp_path: Path) -> None:
    done = finish_in(tmp_path, *command(loads.entries_compiled_here), NUMBA_CACHE_DIR=str(tmp_path))
    assert done.returncode == 0, done.stderr
    compiled = returned(done.stdout)
    assert compiled == {"run": 1, "assemble_column": 0, "observe_snapshots": 0, "observe_state": 0}


HOME = Path("/home/ada")
SITE = "lib/python3.11/site-packages/solver/kernels/api/entries.py"


@pytest.mark.parametrize(
    ("platform", "variables", "folder"),
    [
        ("linux", {}, HOME / ".cache" / "multiblock-fmu"),
        ("linux", {"XDG_CACHE_HOME": "/cache"}, Path("/cache/multiblock-fmu")),
        ("darwin", {}, HOME / "Library" / "Caches" / "multiblock-fmu"),
        ("win32", {}, HOME / "AppData" / "Local" / "multiblock-fmu"),
        ("win32", {"LOCALAPPDATA": "/local"}, Path("/local/multiblock-fmu")),
        ("linux", {"MULTIBLOCK_CACHE_DIR": "/chosen", "XDG_CACHE_HOME": "/cache"}, Path("/chosen")),
    ],
)
def test_the_folder_of_the_user_follows_the_platform(
    monkeypatch: pytest.MonkeyPatch, platform: str, variables: dict[str, str], folder: Path
) -> None:
    place(monkeypatch, HOME=str(HOME), USERPROFILE=str(HOME), **variables)
    monkeypatch.setattr(sys, "platform", platform)
    assert cache.user_folder() == folder


@pytest.mark.parametrize(
    ("file", "package", "variables", "folder"),
    [
        ("solver/kernels/api/entries.py", "solver.kernels", {}, ""),  # a checkout
        ("solver/kernels/api/entries.py", "solver.kernels", {"NUMBA_CACHE_DIR": "/numba"}, "/numba"),
        ("solver/kernels/api/entries.py", "solver.kernels", {"MULTIBLOCK_CACHE_DIR": "/chosen"}, "/chosen/kernels"),
        (SITE, "solver.kernels", {}, "/cache/multiblock-fmu/kernels"),
        (SITE, "solver.kernels", {"NUMBA_CACHE_DIR": "/numba"}, "/numba"),
        (SITE, "solver.kernels", {"NUMBA_CACHE_DIR": "/numba", "MULTIBLOCK_CACHE_DIR": "/chosen"}, "/chosen/kernels"),
        ("solver_0123/kernels/api/entries.py", "solver_0123.kernels", {"NUMBA_CACHE_DIR": "/numba"}, ""),  # an FMU's
        ("missing/entries.py", "solver.kernels", {}, "/cache/multiblock-fmu/kernels"),  # nor can be written to
        ("missing/entries.py", "solver_0123.kernels", {"NUMBA_CACHE_DIR": "/numba"}, "/numba"),
    ],
)
def test_machine_code_stays_out_of_what_a_package_manager_looks_after(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, file: str, package: str, variables: dict[str, str], folder: str
) -> None:
    place(monkeypatch, XDG_CACHE_HOME="/cache", **variables)
    monkeypatch.setattr(sys, "platform", "linux")
    source = tmp_path / file
    if "missing" not in file:
        source.parent.mkdir(parents=True)
    assert cache.code_folder(source, package, variables.get("NUMBA_CACHE_DIR", "")) == folder


def place(monkeypatch: pytest.MonkeyPatch, **variables: str) -> None:
    """Let the environment name these folders and no others."""
    for name in ("MULTIBLOCK_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
