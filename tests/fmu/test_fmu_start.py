"""The start of an FMU where the machine code fits and where not, where nothing can be kept, and in a race."""

from __future__ import annotations

import marshal
import os
import re
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support.child import call, command, returned
from support.fmus import DAMPED, REFUSED, Fmus, environment, run
from support.inside import starts

from solver import Motion

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time


def call_with(home: Path, function: Callable[..., object], *arguments: object) -> Any:
    """The value that a function returns in a process on an account whose home is a folder."""
    return returned(run(*command(function, *arguments), HOME=str(home), XDG_CACHE_HOME="", MULTIBLOCK_CACHE_DIR=""))


def start(fmu: Path, home: Path, hindrance: str = "", record: object = "", **variables: str) -> subprocess.Popen[str]:
    """A process on an account whose home is a folder."""
    others = ("XDG_CACHE_HOME", "NUMBA_CACHE_DIR", "MULTIBLOCK_CACHE_DIR", "PYTHONDONTWRITEBYTECODE")
    kept = {key: value for key, value in environment().items() if key not in others}
    return subprocess.Popen(
        command(starts.start, fmu, hindrance, record),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=kept | {"HOME": str(home)} | variables,
    )


def counts(process: subprocess.Popen[str]) -> tuple[int, int, float]:
    """Kernels found compiled, kernels compiled, displacement; fails unless the process ends with 0.

    It has to say that it compiles before it does, in one line, and nothing else.
    """
    assert process.stderr is not None
    first, began = process.stderr.readline(), time.monotonic()
    out, err = process.communicate()
    assert process.returncode == 0, first + err
    hits, misses, ux = returned(out)
    assert err == ""
    if misses:
        assert re.search(r"the solver is compiled next, .*Python 3\.\d+.*numba .* takes about \d", first), first
        assert time.monotonic() - began > 5.0  # s
        assert "[WARNING] the solver is compiled next" in out or REFUSED != "error"
    else:
        assert first == ""
    return hits, misses, ux


def test_a_fresh_account_compiles_nothing(fmus: Fmus, tmp_path: Path) -> None:
    assert counts(start(fmus.damped, tmp_path))[:2] == (3, 0)
    assert counts(start(fmus.damped, tmp_path))[:2] == (3, 0)


def test_a_column_and_a_structure_in_one_process_compile_nothing(fmus: Fmus, trilith: Path, tmp_path: Path) -> None:
    """Each has a solver of its own, with its own kernels; with one for both the second compiles, for a minute."""
    assert call_with(tmp_path, starts.both, fmus.damped, trilith) == [0, 0]


@pytest.mark.parametrize("variable", ["NUMBA_CACHE_DIR", "MULTIBLOCK_CACHE_DIR"])
def test_another_cache_folder_compiles_nothing(fmus: Fmus, tmp_path: Path, variable: str) -> None:
    chosen = tmp_path / "chosen"
    assert counts(start(fmus.damped, tmp_path, **{variable: str(chosen)}))[:2] == (3, 0)
    assert chosen.exists() == (variable == "MULTIBLOCK_CACHE_DIR")  # numba's is for machine code made here


def test_a_record_compiles_nothing_more(fmus: Fmus, tmp_path: Path) -> None:
    Motion.from_samples(0.2, [0.0, 1.0, 0.0]).to_csv(tmp_path / "record.csv")
    assert counts(start(fmus.damped, tmp_path, record=tmp_path / "record.csv"))[:2] == (3, 0)


def test_the_account_that_builds_compiles_nothing_more(tmp_path: Path) -> None:
    home = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / ".cache")}
    assert counts(start(Fmus.build(DAMPED, tmp_path / "own.fmu", **home), tmp_path))[:2] == (3, 0)


def test_python_finds_what_the_builder_has_compiled(fmus: Fmus) -> None:
    assert call(starts.simulate) == [0, 0]


def test_another_processor_compiles_once(fmus: Fmus, tmp_path: Path) -> None:
    other = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    first = counts(start(fmus.damped, tmp_path, **other))
    assert first[:2] == (0, 3)
    again = counts(start(fmus.damped, tmp_path, **other))
    assert again[:2] == (3, 0)
    here = counts(start(fmus.damped, tmp_path))
    assert here[:2] == (3, 0)
    assert first[2] == again[2] == pytest.approx(here[2], rel=1e-6)


@pytest.mark.parametrize("times", [1, 3])
def test_processes_that_start_together_do_not_disturb_each_other(fmus: Fmus, tmp_path: Path, times: int) -> None:
    for k in range(times):
        home = tmp_path / str(k)
        processes = [start(fmus.damped, home) for _ in range(4)]
        assert len({counts(process) for process in processes}) == 1


@pytest.mark.parametrize("hindrance", ["read-only", pytest.param("full", marks=pytest.mark.campaign)])
def test_where_nothing_can_be_kept_it_starts_all_the_same(fmus: Fmus, tmp_path: Path, hindrance: str) -> None:
    if os.name == "nt" and hindrance == "full":
        pytest.skip("Windows has no limit on the size of files")
    hits, misses, ux = counts(start(fmus.damped, tmp_path, hindrance))
    assert hits + misses == 3
    assert ux == counts(start(fmus.damped, tmp_path / "usual"))[2]


def copy_of(home: Path) -> Path:
    """The lasting copy of the solver on an account."""
    (found,) = (home / ".cache" / "multiblock-fmu").glob("solver_*")
    return found


def cut(copy: Path, pattern: str) -> None:
    """Leave half of a file."""
    file = sorted(copy.rglob(pattern))[0]
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def plant(copy: Path, marker: Path, cached: bool) -> None:
    """Put code into a copy that leaves a marker when it runs: into a module, or into what Python keeps of one."""
    module = copy / "__init__.py"
    text = module.read_text() + f"\nopen({str(marker)!r}, 'w').close()\n"
    if not cached:
        module.write_text(text)
        return
    (kept,) = copy.glob("__pycache__/__init__.*.pyc")
    kept.write_bytes(kept.read_bytes()[:16] + marshal.dumps(compile(text, str(module), "exec")))


HARMS: dict[str, Callable[[Path], object]] = {
    "module missing": lambda copy: (copy / "models/column/model.py").unlink(),
    "code cut": lambda copy: cut(copy, "*.nbc"),
    "code missing": lambda copy: sorted(copy.rglob("*.nbc"))[0].unlink(),
    "index cut": lambda copy: cut(copy, "*.nbi"),
    "bytecode cut": lambda copy: cut(copy, "__init__.*.pyc"),
    "module cut": lambda copy: cut(copy, "models/column/model.py"),
    "library added": lambda copy: (copy / "errors.so").write_bytes(b"no library"),
}


@pytest.mark.parametrize("harm", HARMS)
def test_a_damaged_copy_is_passed_over(fmus: Fmus, tmp_path: Path, harm: str) -> None:
    usual = counts(start(fmus.damped, tmp_path))
    HARMS[harm](copy_of(tmp_path))
    assert counts(start(fmus.damped, tmp_path)) == usual
    assert counts(start(fmus.damped, tmp_path)) == usual
    copies = sorted(folder.name for folder in (tmp_path / ".cache" / "multiblock-fmu").iterdir())
    assert len(copies) == 2  # one beside the damaged one
    assert copies[1] == f"{copies[0]}.1"


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
@pytest.mark.parametrize(("cached", "opened"), [(True, "copy"), (False, "copy"), (True, "cache")])
def test_code_that_others_may_have_planted_does_not_run(fmus: Fmus, tmp_path: Path, cached: bool, opened: str) -> None:
    usual = counts(start(fmus.damped, tmp_path))
    copy = copy_of(tmp_path)
    plant(copy, tmp_path / "ran", cached)
    folder = copy if opened == "copy" else copy.parent
    copy.chmod(0o755)
    folder.chmod(0o777)
    assert counts(start(fmus.damped, tmp_path)) == usual
    assert not (tmp_path / "ran").exists()


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
def test_where_others_can_write_to_the_cache_nothing_of_it_is_used(fmus: Fmus, tmp_path: Path) -> None:
    home = tmp_path / "home"
    (home / ".cache").mkdir(parents=True)
    (home / ".cache").chmod(0o777)
    assert counts(start(fmus.damped, home))[:2] == (3, 0)
    assert not [*home.rglob("solver_*")]


@pytest.mark.skipif(os.name == "nt", reason="folders of a user on Windows are his own")
def test_what_python_adds_to_a_copy_under_any_umask_does_not_spoil_it(fmus: Fmus, tmp_path: Path) -> None:
    mask = os.umask(0o002)  # as where every user has a group of his own
    try:
        usual = counts(start(fmus.damped, tmp_path))
        assert counts(start(fmus.damped, tmp_path)) == usual
    finally:
        os.umask(mask)
    assert copy_of(tmp_path).stat().st_mode & 0o777 == 0o700
