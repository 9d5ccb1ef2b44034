"""Machine code of the kernels: made for the sources as they are, kept where the user alone can write, checked."""

from __future__ import annotations

import importlib
import io
import os
import pickle
import shutil
import struct
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from support import disc
from support.fmus import ROOT, finish_in

from fmu_src.native import table
from solver.kernels.column.api import entries
from solver.kernels.machine import entry as machine_entry
from solver.kernels.machine import folders, level, library, making, packaging
from solver.kernels.machine.entry import ENTRIES, Entry
from solver.kernels.machine.groups import GROUPS
from solver.kernels.machine.kinds import Int, Reals
from solver.kernels.machine.messages import MachineCodeError, announcing
from solver.kernels.machine.zig import LINUX
from solver.kernels.paper import entries as of_paper


def loaded_kernel_says(project: Path) -> float:
    """Return the area of a disc over pi by a process of its own that keeps its code in the project."""
    places = {"PYTHONPATH": str(project), "MULTIBLOCK_CACHE_DIR": str(project / "cache")}
    done = finish_in(project, sys.executable, "-c", disc.PROGRAM, **places)
    assert done.returncode == 0, done.stderr
    return float(done.stdout)


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
@pytest.mark.long  # compiles a group of kernels twice
def test_a_change_in_any_kernel_file_is_compiled_again(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "solver", tmp_path / "solver", ignore=shutil.ignore_patterns("__pycache__"))
    assert loaded_kernel_says(tmp_path) == pytest.approx(1.0, rel=1e-14)
    circle = tmp_path / "solver" / "kernels" / "engine" / "circle.py"
    text = circle.read_text()
    changed = text.replace("area += sign * a", "area += 2.0 * sign * a")
    assert changed != text
    circle.write_text(changed)
    assert loaded_kernel_says(tmp_path) == pytest.approx(2.0, rel=1e-14)


# --- entries


def test_every_entry_belongs_to_a_group_whose_module_defines_it() -> None:
    for of in GROUPS.values():
        importlib.import_module(of.whole_module)
    assert {group for group, _ in ENTRIES} == set(GROUPS)
    for group, name in ENTRIES:
        assert ENTRIES[group, name].__module__ == GROUPS[group].whole_module, (group, name)


@pytest.mark.parametrize("module", [entries, of_paper])
def test_a_column_needs_no_group_but_its_own(module: ModuleType) -> None:
    """Check that an FMU carries that group, and the one of joints."""
    used = {item.group for item in vars(module).values() if isinstance(item, Entry)}
    assert used - {"statics"} == {module.run.group, *(group for group in used if "lanes" in group)}


@pytest.mark.parametrize("group", ["column_driven", "structure_driven"])
def test_a_native_fmu_names_all_slots_of_a_call(group: str) -> None:
    for name in table.CALLED:
        entry = ENTRIES[group, name]
        assert 8 * len(table.arguments(entry)) == entry.slots.size
        assert table.arguments(entry).keys() <= table.given_to(name).keys()


def test_an_entry_is_pickled_by_its_name() -> None:
    assert pickle.loads(pickle.dumps(entries.run)) is entries.run


ROW = np.zeros(4)


@pytest.mark.parametrize(
    ("edges", "what"),
    [
        (np.zeros(8)[::2], r"an array of shape \(4,\) with gaps: must be contiguous"),
        (np.zeros(4, dtype=np.float32), "an array of float32: must be of float64"),
        (np.zeros(4, dtype=np.int64), "an array of int64: must be of float64"),
    ],
)
def test_an_array_of_another_kind_is_refused(edges: Any, what: str) -> None:
    with pytest.raises(TypeError, match=what):
        entries.rings_beyond(ROW, ROW, edges, ROW, ROW)


def test_other_arguments_are_refused() -> None:
    with pytest.raises(TypeError, match="rings_beyond: takes 5 arguments, got 4"):
        entries.rings_beyond(ROW, ROW, ROW, ROW)
    with pytest.raises(TypeError, match="joint_energies: required argument is not an integer"):
        entries.joint_energies(1, ROW, 0.5, 0.0, ROW, ROW, ROW)


def test_an_argument_without_a_kind_is_refused() -> None:
    def sum_of(n: Int, numbers) -> Int:
        return n

    with pytest.raises(TypeError, match="sum_of: each argument needs a kind, the result Int, Real or None"):
        Entry(sum_of, "statics", __name__)


def test_the_numbers_of_a_call_can_be_replaced() -> None:
    first, second = np.zeros(1), np.zeros(1)
    call = machine_entry.Call(entries.rings_beyond, (np.ones(1), np.zeros(1), np.array([-1.0]), first, second))
    call()
    assert first[0] / np.pi == pytest.approx(1.0, rel=1e-12)  # a circle beyond an edge that touches it
    twice = np.full(1, 2.0)
    struct.pack_into("=q", call.buffer, machine_entry.offset(entries.rings_beyond, "outer"), twice.ctypes.data)
    call()
    assert first[0] > np.pi


def test_a_function_that_is_not_in_the_code_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_such_function(numbers):
        return

    no_such_function.__annotations__ = {"numbers": Reals}
    monkeypatch.setitem(ENTRIES, ("statics", "no_such_function"), Entry(no_such_function, "statics", __name__))
    monkeypatch.setitem(library.NAMES, "statics", [*library.NAMES["statics"], "no_such_function"])
    monkeypatch.delitem(library._loaded, "statics", raising=False)
    with pytest.raises((MachineCodeError, AttributeError), match="no_such_function"):
        library.load("statics")


# --- where it is kept


HOME = Path("/home/ada")


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
    assert folders.user_folder() == folder


def replaced(file: Path, put: Callable[[Path], object]) -> None:
    file.unlink()
    put(file)


DAMAGES: dict[str, Callable[[Path], object]] = {
    "empty": lambda file: file.write_bytes(b""),
    "truncated": lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
    "garbage": lambda file: file.write_bytes(bytes(range(256)) * 40),
    "unreadable": lambda file: replaced(file, lambda it: it.symlink_to(it)),  # for root, too
    "a folder": lambda file: replaced(file, Path.mkdir),
}


def test_what_is_kept_is_whole_or_not_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))
    for damage in DAMAGES.values():
        assert folders.kept("guard", "name") is None
        folders.keep("guard", "name", b"content")
        assert folders.kept("guard", "name") == b"content"
        damage(tmp_path / "cache" / "guard" / "name")
    assert folders.kept("guard", "name") is None
    folders.keep("guard", "name", b"content")  # not into a folder, and without a word
    assert [file.name for file in (tmp_path / "cache" / "guard").iterdir()] == ["name"]


def opened(folder: Path) -> None:
    folder.chmod(0o770)


def given_away(folder: Path) -> None:
    if os.getuid() != 0:
        pytest.skip("only root can give a folder away")
    os.chown(folder, 12345, -1)


def made_now(monkeypatch: pytest.MonkeyPatch) -> bytes:
    """Return the object code that `making` makes of a group, by a stand-in for the compiler."""

    def quick(command: list[str]) -> tuple[int, str]:
        for word in command:
            if "=" in word:
                Path(word.partition("=")[2]).write_bytes(b"made")
        return 0, ""

    monkeypatch.setattr(making, "_run", quick)
    monkeypatch.setattr(making, "kept", lambda *_: None)
    return making.made(["statics"])[0]


def test_a_module_is_kept_only_if_code_was_made_of_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Check that what a compiler that was stopped has left is not used again: every later start would fail."""
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))

    def stopped(command: list[str]) -> tuple[int, str]:
        Path(command[command.index("-m") + 3]).write_bytes(b"half a mod")
        return -9, "it was ended"

    monkeypatch.setattr(making, "_run", stopped)
    with pytest.raises(MachineCodeError, match="it was ended"):
        making.made(["statics"])
    assert [*tmp_path.rglob("*.bc")] == []
    (tmp_path / "statics.o").write_bytes(b"")  # code of it follows: the module is whole
    with pytest.raises(MachineCodeError, match="it was ended"):
        making.run_make({"statics": {"x86-64-v3": tmp_path / "statics.o"}})
    assert len([*tmp_path.rglob("*.bc")]) == 1


def test_code_that_cannot_be_stored_is_made_with_a_warning(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))

    def full(file: Path, content: bytes) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(folders, "write_whole", full)
    with pytest.warns(RuntimeWarning, match="not kept, and made in every process: .*No space left on device"):
        assert made_now(monkeypatch) == b"made"


def test_code_of_one_system_is_not_found_on_another(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "shared"))
    folders.keep(making.KEPT, making._key("statics"), b"of this system")
    assert making.kept_code("statics") == b"of this system"
    monkeypatch.setattr(making, "HOST", "darwin-arm64")
    assert making.kept_code("statics") is None


def test_the_compiler_imports_what_lies_beside_the_script_last(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys.modules["__main__"], "__file__", str(tmp_path / "run.py"), raising=False)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    assert making.environment()["PYTHONPATH"].split(os.pathsep).index(str(tmp_path)) == len([*filter(None, sys.path)])


@pytest.mark.parametrize(("cores", "processes"), [(1, [["column", "statics"]]), (2, [["column"], ["statics"]])])
def test_groups_needed_together_are_made_at_the_same_time(
    monkeypatch: pytest.MonkeyPatch, cores: int, processes: list[list[str]]
) -> None:
    made: list[list[str]] = []

    def quick(groups: list[str]) -> list[bytes]:
        made.append(groups)
        return [name.encode() for name in groups]

    monkeypatch.setattr(making, "kept_code", {"lanes": b"kept"}.get)
    monkeypatch.setattr(making, "made", quick)
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    assert making.code_with("column", ["statics", "lanes"]) == {"column": b"column", "statics": b"statics"}
    assert sorted(made) == processes
    assert making.code_with("lanes", ["statics"]) == {"lanes": b"kept"}
    assert making.code_with("statics", []) == {"statics": b"statics"}
    assert sorted(made) == sorted([*processes, ["statics"]])


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
@pytest.mark.parametrize("harm", [opened, given_away])
@pytest.mark.parametrize("inside", ["", "code"])
def test_machine_code_that_others_may_have_planted_is_not_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, harm: Callable[[Path], None], inside: str
) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))
    assert made_now(monkeypatch) == b"made"
    assert folders.kept(making.KEPT, making._key("statics")) == b"made"
    for folder in (tmp_path / "cache", tmp_path / "cache" / "code"):
        if folder.name == "cache" or inside:
            harm(folder)
    if harm is opened and not inside:  # it is closed again; nothing could get into the private folder
        assert folders.kept(making.KEPT, making._key("statics")) == b"made"
        assert (tmp_path / "cache").stat().st_mode & 0o022 == 0
        return
    assert folders.kept(making.KEPT, making._key("statics")) is None
    with pytest.warns(RuntimeWarning, match="machine code is not kept, and made in every process: .*: others c"):
        made_now(monkeypatch)


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
def test_no_native_fmu_is_linked_with_planted_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    place(monkeypatch, MULTIBLOCK_CACHE_DIR=str(tmp_path / "cache"))
    for content, found in ((b"first", b"first"), (b"second", b"first"), (b"third", b"third")):

        def quick(wanted: dict[str, dict[str, Path]], content: bytes = content) -> None:
            for file in wanted["column"].values():
                file.write_bytes(content)

        monkeypatch.setattr(packaging, "run_make", quick)
        if content == b"third":
            opened(tmp_path / "cache" / packaging.KEPT)
        assert packaging.object_code("column", [LINUX]) == [found]


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
def test_a_folder_that_all_may_add_to_stays_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Check a folder as /tmp, whose owner would close it to all others."""
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o1777)
    place(monkeypatch)
    assert folders.private_folder("multiblock-fmu", shared) == shared / "multiblock-fmu"
    assert shared.stat().st_mode & 0o7777 == 0o1777
    assert (shared / "multiblock-fmu").stat().st_mode & 0o7777 == 0o700


# --- which, and what is said


def test_the_level_is_one_that_this_processor_has() -> None:
    assert level.levels()[-1] in ("x86-64-v2", "arm64")
    assert set(level.levels()) <= {*level.X86, *level.ARM}


def test_a_lower_level_can_be_chosen_and_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    lowest = level.levels()[-1]
    for name, found in ((lowest, (lowest,)), ("x86-64-v9", None)):
        monkeypatch.setenv("MULTIBLOCK_LEVEL", name)
        level.levels.cache_clear()
        if found:
            assert level.levels() == found
        else:
            with pytest.raises(ValueError, match="MULTIBLOCK_LEVEL=x86-64-v9: must be of "):
                level.levels()
    monkeypatch.undo()
    level.levels.cache_clear()


def test_what_cannot_be_made_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(making, "_python", lambda: sys.executable)
    with pytest.raises(MachineCodeError, match=r"^the kernels of columns at rest cannot be compiled: LLVM ERROR: .*"):
        making.run_make({"statics": {"no such": Path("/nonexistent/x.o")}})


def test_an_error_of_numba_is_shown_with_its_innermost_place() -> None:
    output = "TypingError: failed\n  wrong length\n  During: typing of call at /a/b.py (7)\n\n  During: Pass x\n"
    output += "  During: typing of call at /a/c.py (9)\nDuring: Pass nopython_type_inference\n"
    assert making.reason_in(output) == "/a/b.py, line 7: wrong length"
    assert making.reason_in("Traceback\nValueError: no\n") == "ValueError: no"
    assert making.reason_in("") == "it was ended"


COMPILING = f"compiling the kernels of columns at rest, once: about {GROUPS['statics'].seconds} s\n"


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_says_what_is_compiled_and_a_pipe_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    for shown, said in (
        (Terminal(), COMPILING),
        (io.StringIO(), ""),
    ):
        monkeypatch.setattr(sys, "stderr", shown)
        monkeypatch.setattr(making, "store", lambda *_: None)
        made_now(monkeypatch)
        assert shown.getvalue() == said


def test_a_command_says_it_in_a_pipe_too_and_nothing_stays(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(making, "store", lambda *_: None)
    with announcing(print):
        made_now(monkeypatch)
    assert capsys.readouterr().out == COMPILING
    made_now(monkeypatch)
    assert capsys.readouterr() == ("", "")


def place(monkeypatch: pytest.MonkeyPatch, **variables: str) -> None:
    """Let the environment name these folders and no others."""
    for name in ("MULTIBLOCK_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
