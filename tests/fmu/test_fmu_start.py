"""The start of an FMU: it compiles nothing, needs numpy alone, and leaves nothing behind."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

import pytest
from support.child import call, command, returned
from support.fmus import Fmus, environment
from support.inside import starts

from solver import Motion
from solver.kernels.machine.level import X86


def start(fmu: Path, home: Path, hindrance: str = "", record: object = "", **variables: str) -> subprocess.Popen[str]:
    """Return a process on an account whose home is a folder."""
    others = ("XDG_CACHE_HOME", "MULTIBLOCK_CACHE_DIR", "PYTHONDONTWRITEBYTECODE")
    kept = {key: value for key, value in environment().items() if key not in others}
    return subprocess.Popen(
        command(starts.start, fmu, hindrance, record),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=kept | {"HOME": str(home)} | variables,
    )


def displacement(process: subprocess.Popen[str]) -> float:
    """Return the displacement that the process prints; fails unless it ends with 0 and says nothing else."""
    out, err = process.communicate()
    assert (process.returncode, err) == (0, "")
    return float(returned(out))


# each marked one takes a second or more
@pytest.mark.parametrize("hindrance", ["", pytest.param("read-only", marks=pytest.mark.long)])
def test_a_fresh_account_compiles_nothing_and_keeps_nothing(fmus: Fmus, tmp_path: Path, hindrance: str) -> None:
    home = tmp_path / "home"
    home.mkdir()
    assert displacement(start(fmus.damped, home, hindrance)) != 0.0
    assert [*home.rglob("*")] == []


@pytest.mark.long  # takes seconds
def test_without_a_home_it_starts_all_the_same(fmus: Fmus, tmp_path: Path) -> None:
    ux = displacement(start(fmus.damped, Path("/nonexistent")))
    assert ux == displacement(start(fmus.damped, tmp_path))


def test_fmus_in_one_process_start_after_the_folder_of_the_first_is_gone(fmus: Fmus, trilith: Path) -> None:
    assert call(starts.both, fmus.damped, trilith) == [True, True, True]


@pytest.mark.long
def test_a_record_is_followed(fmus: Fmus, tmp_path: Path) -> None:
    Motion.from_samples(0.2, [0.0, 1.0, 0.0]).to_csv(tmp_path / "record.csv")
    assert displacement(start(fmus.damped, tmp_path, record=tmp_path / "record.csv")) != 0.0


@pytest.mark.long
def test_processes_that_start_together_do_not_disturb_each_other(fmus: Fmus, tmp_path: Path) -> None:
    processes = [start(fmus.damped, tmp_path) for _ in range(4)]
    assert len({displacement(process) for process in processes}) == 1


@pytest.mark.long  # quick tests build them for this processor alone
def test_it_carries_libraries_for_every_platform(fmus: Fmus) -> None:
    pytest.importorskip("ziglang", reason="needs the extra native")
    with zipfile.ZipFile(fmus.damped) as archive:
        carried = {Path(name).name for name in archive.namelist() if name.startswith("resources/code/")}
    found = {(name.split(".")[0], name.split(".")[1], Path(name).suffix) for name in carried}
    for group in ("column", "statics"):
        assert {level for of, level, suffix in found if (of, suffix) == (group, ".so")} >= set(X86)
        assert {suffix for of, _, suffix in found if of == group} == {".so", ".dll", ".dylib"}


@pytest.mark.parametrize(
    "fixture",
    ["trilith", *(pytest.param(name, marks=pytest.mark.long) for name in ("damped", "native", "native_trilith"))],
)
def test_extremes_before_the_first_step_are_the_outputs(request: pytest.FixtureRequest, fixture: str) -> None:
    fmu = request.getfixturevalue("fmus").damped if fixture == "damped" else request.getfixturevalue(fixture)
    found, same = call(starts.extremes_before_a_step, fmu)
    assert len(found) > 30
    wrong = {name: pair for name, pair in found.items() if abs(pair[0]) != pair[1]}
    assert not wrong
    assert found["joint[1].N_peak"][1] > 0.0
    assert same
