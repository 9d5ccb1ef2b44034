"""The cached machine code is that of the sources as they are."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from fmus import ROOT

LOAD = """
from solver import Column
from solver.stepper import Stepper
import solver.kernels.layout as at
column = Column.from_toml("phocas.toml")
print(at.ROW.see(Stepper(column).observe(0.0), 3).joints.N[0])
"""


def loaded_kernel_says(project: Path) -> float:
    """Normal force of the top joint at rest, from a process of its own that caches beside the sources."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, "-c", LOAD], cwd=project, capture_output=True, text=True, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    return float(done.stdout)


def test_a_change_in_any_kernel_file_is_compiled_anew(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "solver", tmp_path / "solver", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "examples" / "columns" / "phocas-damped.toml", tmp_path / "phocas.toml")
    first = loaded_kernel_says(tmp_path)
    assert loaded_kernel_says(tmp_path) == first
    joint = tmp_path / "solver" / "kernels" / "joint" / "law.py"
    text = joint.read_text()
    changed = text.replace("area = rigidity * length", "area = 2.0 * rigidity * length")
    assert changed != text
    joint.write_text(changed)  # the entry's own file stays as it was
    assert loaded_kernel_says(tmp_path) == 2.0 * first
