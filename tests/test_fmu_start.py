"""How the FMU starts where the machine code fits and where it does not, where nothing can be kept, and in a race."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from child import command, returned
from fmus import ROOT, Fmus, environment
from inside import starts

from solver import Motion


def start(fmu: Path, home: Path, hindrance: str = "", record: object = "", **variables: str) -> subprocess.Popen[str]:
    """A process on an account whose home is a folder."""
    kept = {key: value for key, value in environment().items() if key not in ("XDG_CACHE_HOME", "NUMBA_CACHE_DIR")}
    return subprocess.Popen(
        command(starts.start, fmu, hindrance, record),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=kept | {"HOME": str(home)} | variables,
    )


def counts(process: subprocess.Popen[str]) -> tuple[int, int, float]:
    """Kernels found compiled, kernels compiled, displacement; fails unless the process ends with 0 and says nothing."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    assert err == ""
    hits, misses, ux = returned(out)
    return hits, misses, ux


def test_a_fresh_account_compiles_nothing(fmus: Fmus, tmp_path: Path) -> None:
    assert counts(start(fmus.damped, tmp_path))[:2] == (3, 0)
    assert counts(start(fmus.damped, tmp_path))[:2] == (3, 0)


def test_a_record_compiles_nothing_more(fmus: Fmus, tmp_path: Path) -> None:
    Motion.from_samples(0.2, [0.0, 1.0, 0.0]).to_csv(tmp_path / "record.csv")
    assert counts(start(fmus.damped, tmp_path, record=tmp_path / "record.csv"))[:2] == (3, 0)


def test_the_account_that_builds_compiles_nothing_more(fmus: Fmus, tmp_path: Path) -> None:
    column = ROOT / "examples" / "columns" / "phocas-damped.toml"
    home = environment() | {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / ".cache")}
    build = [sys.executable, str(ROOT / "build_fmu.py"), str(column), "-o", str(tmp_path / "own.fmu")]
    subprocess.run(build, env=home, check=True, capture_output=True)
    assert counts(start(tmp_path / "own.fmu", tmp_path))[:2] == (3, 0)


def test_python_finds_what_the_builder_has_compiled(fmus: Fmus) -> None:
    done = subprocess.run(command(starts.simulate), env=environment(), check=True, capture_output=True, text=True)
    assert returned(done.stdout) == [0, 0]


@pytest.mark.long
def test_another_processor_compiles_once(fmus: Fmus, tmp_path: Path) -> None:
    other = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    first = counts(start(fmus.damped, tmp_path, **other))
    assert first[:2] == (0, 3)
    again = counts(start(fmus.damped, tmp_path, **other))
    assert again[:2] == (3, 0)
    here = counts(start(fmus.damped, tmp_path))
    assert here[:2] == (3, 0)
    assert first[2] == again[2] == pytest.approx(here[2], rel=1e-6)


@pytest.mark.parametrize("times", [1, pytest.param(3, marks=pytest.mark.long)])
def test_processes_that_start_together_do_not_disturb_each_other(fmus: Fmus, tmp_path: Path, times: int) -> None:
    for k in range(times):
        home = tmp_path / str(k)
        processes = [start(fmus.damped, home) for _ in range(4)]
        assert len({counts(process) for process in processes}) == 1


@pytest.mark.long
@pytest.mark.parametrize("hindrance", ["read-only", "full"])
def test_where_nothing_can_be_kept_it_starts_all_the_same(fmus: Fmus, tmp_path: Path, hindrance: str) -> None:
    if os.name == "nt" and hindrance == "full":
        pytest.skip("Windows has no limit on the size of files")
    hits, misses, ux = counts(start(fmus.damped, tmp_path, hindrance))
    assert hits + misses == 3
    assert ux == counts(start(fmus.damped, tmp_path / "usual"))[2]
