"""The cached machine code is that of the sources as they are."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from support.child import command, returned
from support.fmus import DAMPED, ROOT, finish_in
from support.inside import loads


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
