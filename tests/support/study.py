"""A small study, its files and its processes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from solver.studies import Results
from support.fmus import environment

TEXT = """
name = "small"
kind = "fragility"
column = "block.toml"
samples = {samples}
seed = 3
tolerance = 1e-3
keep = ["peak_ux", "verdict", "overturn_time"]
[[motion]]
formula = "ricker"
[intensity]
measure = "pga"
[grid]
intensity = [0.2, 0.6]
[random."joint.stiffness"]
distribution = "lognormal"
median = 1.0
deviation = 0.3
relative = true
[random."motion.frequency"]
distribution = "uniform"
low = 0.5
high = 2.0
"""


def same(one: Results, other: Results) -> bool:
    """Return True if two tables are the same to the last bit."""
    return list(one) == list(other) and all(
        one[name].dtype.kind == other[name].dtype.kind and one[name].tobytes() == other[name].tobytes() for name in one
    )


def command(folder: Path, *words: object) -> list[str]:
    return [sys.executable, "-m", "solver", "study", *map(str, words), "--output-folder", str(folder)]


def start(folder: Path, *words: object, **variables: str) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    its_own = environment() | variables
    return subprocess.Popen(command(folder, *words), env=its_own, stdout=pipe, stderr=pipe, text=True, cwd=folder)


def finished(folder: Path) -> int:
    """Return whole lines of runs in the journal."""
    path = folder / "small.journal"
    return max(0, path.read_bytes().count(b"\n") - 1) if path.exists() else 0
