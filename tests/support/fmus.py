"""FMUs for the tests, built as a user builds them, and processes to run them in."""

from __future__ import annotations

import csv
import importlib.util
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
# the status of what a PythonFMU refuses, with its guard and without
REFUSED = "error" if importlib.util.find_spec("ziglang") and sys.platform.startswith("linux") else "fatal"


def environment() -> dict[str, str]:
    """The environment of a child process, with project, tests and the scripts of this interpreter in reach."""
    scripts = str(Path(sys.executable).parent)
    modules = os.pathsep.join((str(ROOT), str(ROOT / "tests")))
    return os.environ | {"PYTHONPATH": modules, "PATH": scripts + os.pathsep + os.environ.get("PATH", "")}


def finish(*command: object, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, whatever it exits with, with more variables in its environment."""
    return subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, env=environment() | variables, check=False
    )


def run(*command: object, **variables: str) -> str:
    """Run a command to its end and return what it printed; fails unless it exits with 0."""
    done = finish(*command, **variables)
    assert done.returncode == 0, f"exit code {done.returncode}: {done.stderr}"
    return done.stdout


def read_results(path: Path) -> dict[str, np.ndarray]:
    """Columns of an FMPy result file, Booleans as 0 and 1 (FMPy itself cannot read those back)."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    words = {"False": 0.0, "True": 1.0}
    numbers = np.array([[words[text] if text in words else float(text) for text in row] for row in rows])
    return dict(zip(header, numbers.T, strict=True))


@dataclass(frozen=True)
class Fmus:
    """The FMUs of the two example columns."""

    phocas: Path
    damped: Path

    @staticmethod
    def build(column: Path, output: Path, *options: object, **variables: str) -> Path:
        """Build one more with the project's own command, with more variables in its environment."""
        run(sys.executable, ROOT / "build_fmu.py", column, "-o", output, *options, **variables)
        return output
