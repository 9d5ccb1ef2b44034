"""The cached machine code is that of the sources as they are, in a folder that suits how they were installed."""

from __future__ import annotations

import os
import pickle
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import pytest
from support.child import command, returned
from support.fmus import DAMPED, ROOT, finish_in
from support.inside import loads

from solver.kernels.numba_ext import cache, jit


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
        ("solver/kernels/api/entries.py", "solver.kernels", {"NUMBA_CACHE_DIR": "NUMBA"}, "NUMBA/multiblock-fmu"),
        ("solver/kernels/api/entries.py", "solver.kernels", {"MULTIBLOCK_CACHE_DIR": "CHOSEN"}, "CHOSEN/code"),
        (SITE, "solver.kernels", {}, "CACHE/multiblock-fmu/code"),
        (SITE, "solver.kernels", {"NUMBA_CACHE_DIR": "NUMBA"}, "NUMBA/multiblock-fmu"),
        (SITE, "solver.kernels", {"NUMBA_CACHE_DIR": "NUMBA", "MULTIBLOCK_CACHE_DIR": "CHOSEN"}, "CHOSEN/code"),
        ("solver_0123/kernels/api/entries.py", "solver_0123.kernels", {"NUMBA_CACHE_DIR": "NUMBA"}, ""),  # an FMU's
        ("missing/entries.py", "solver.kernels", {}, "CACHE/multiblock-fmu/code"),  # nor can be written to
        ("missing/entries.py", "solver_0123.kernels", {}, ""),
        ("missing/entries.py", "solver_0123.kernels", {"NUMBA_CACHE_DIR": "NUMBA"}, "NUMBA/multiblock-fmu"),
    ],
)
def test_machine_code_stays_out_of_what_a_package_manager_looks_after(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, file: str, package: str, variables: dict[str, str], folder: str
) -> None:
    def here(text: str) -> str:
        return (
            text.replace("CACHE/", f"{tmp_path}/cache/")
            .replace("CHOSEN", f"{tmp_path}/chosen")
            .replace("NUMBA", f"{tmp_path}/numba")
        )

    place(monkeypatch, XDG_CACHE_HOME=here("CACHE/"), **{name: here(text) for name, text in variables.items()})
    monkeypatch.setattr(sys, "platform", "linux")
    source = tmp_path / file
    if "missing" not in file:
        source.parent.mkdir(parents=True)
    assert cache.code_folder(source, package, here(variables.get("NUMBA_CACHE_DIR", ""))) == here(folder)


def made() -> Any:
    """An entry that is new to this process; a call reads its machine code from the disk, or compiles it."""

    def small(x: float) -> float:
        return x + 1.0

    return jit.entry(small)


def counts(entry: Any) -> tuple[int, int]:
    """How often a call found the machine code, and how often it made it; fails if the result is wrong."""
    assert entry(1.0) == 2.0
    return sum(entry.stats.cache_hits.values()), sum(entry.stats.cache_misses.values())


def test_entries_that_one_function_makes_have_machine_code_each(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))

    def made_for(package: str, by: float) -> Any:
        @jit.leaf
        def more(x: float) -> float:
            return x + by

        def small(x: float) -> float:
            return more(x)

        return jit.entry(small, f"solver.kernels.{package}.entries")

    for hits, misses in ((0, 1), (1, 0)):  # what they close over is new each time, as in another process
        for package, by in (("one", 1.0), ("other", 2.0)):
            entry = made_for(package, by)
            assert entry(1.0) == 1.0 + by
            assert (sum(entry.stats.cache_hits.values()), sum(entry.stats.cache_misses.values())) == (hits, misses)


def replaced(file: Path, put: Callable[[Path], object]) -> None:
    file.unlink()
    put(file)


DAMAGES: dict[str, Callable[[Path], object]] = {
    "empty": lambda file: file.write_bytes(b""),
    "truncated": lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
    "garbage": lambda file: file.write_bytes(bytes(range(256)) * 40),
    "of another version": lambda file: file.write_bytes(pickle.dumps("0.1") + b"of that version"),
    "unreadable": lambda file: replaced(file, lambda it: it.symlink_to(it)),  # for root, too
    "a folder": lambda file: replaced(file, Path.mkdir),
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("kind", ["nbi", "nbc"])
def test_damaged_machine_code_is_made_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, damage: str, kind: str
) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))
    assert counts(made()) == (0, 1)
    assert counts(made()) == (1, 0)
    (file,) = tmp_path.rglob(f"*.{kind}")
    DAMAGES[damage](file)
    assert counts(made()) == (0, 1)
    assert counts(made()) == ((0, 1) if damage == "a folder" else (1, 0))  # which is left where it is


def test_what_is_kept_is_whole_or_not_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))
    for damage in DAMAGES.values():
        assert cache.kept("guard", "name") is None
        cache.keep("guard", "name", b"content")
        assert cache.kept("guard", "name") == b"content"
        damage(tmp_path / "cache" / "guard" / "name")
    assert cache.kept("guard", "name") is None
    cache.keep("guard", "name", b"content")  # not into a folder, and without a word
    assert [file.name for file in (tmp_path / "cache" / "guard").iterdir()] == ["name"]


def opened(folder: Path) -> None:
    folder.chmod(0o770)


def given_away(folder: Path) -> None:
    if os.getuid() != 0:
        pytest.skip("only root can give a folder away")
    os.chown(folder, 12345, -1)


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
@pytest.mark.parametrize("harm", [opened, given_away])
@pytest.mark.parametrize("inside", ["", "code"])
def test_machine_code_that_others_may_have_planted_is_not_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, harm: Callable[[Path], None], inside: str
) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))
    assert counts(made()) == (0, 1)
    for folder in (tmp_path / "cache", tmp_path / "cache" / "code"):
        if folder.name == "cache" or inside:
            harm(folder)
    if harm is opened and not inside:  # it is closed again; nothing could get into the private folder
        assert counts(made()) == (1, 0)
        assert (tmp_path / "cache").stat().st_mode & 0o022 == 0
        return
    with pytest.warns(RuntimeWarning, match="machine code is not kept, and made in every process: .*: others c"):
        entry = made()
    assert entry.stats.cache_path is None
    assert entry(1.0) == 2.0
    assert cache.kept("code", "name") is None


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
def test_machine_code_that_others_may_have_planted_for_numba_is_not_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Others wrote to NUMBA_CACHE_DIR while all could: numba itself would load their code by the name of its file."""
    numbas = tmp_path / "numba"
    place(monkeypatch)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(numbas), raising=False)
    assert counts(made()) == (0, 1)
    assert counts(made()) == (1, 0)
    own = numbas / cache.NUMBAS_FOLDER
    (planted,) = own.iterdir()
    shutil.copytree(planted, numbas / planted.name)
    shutil.rmtree(own)
    numbas.chmod(0o777)
    assert counts(made()) == (0, 1)
    assert numbas.stat().st_mode & 0o022 == 0  # closed, as MULTIBLOCK_CACHE_DIR is
    own.chmod(0o777)
    with pytest.warns(RuntimeWarning, match="machine code is not kept, and made in every process: .*: others c"):
        assert made().stats.cache_path is None


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
def test_a_folder_that_all_may_add_to_stays_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """As /tmp, whose owner would close it to all others."""
    numbas = tmp_path / "shared"
    numbas.mkdir()
    numbas.chmod(0o1777)
    place(monkeypatch)
    assert cache.code_folder(tmp_path / "solver.py", "solver.kernels", str(numbas)) == str(numbas / cache.NUMBAS_FOLDER)
    assert numbas.stat().st_mode & 0o7777 == 0o1777
    assert (numbas / cache.NUMBAS_FOLDER).stat().st_mode & 0o7777 == 0o700


def place(monkeypatch: pytest.MonkeyPatch, **variables: str) -> None:
    """Let the environment name these folders and no others."""
    for name in ("MULTIBLOCK_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
