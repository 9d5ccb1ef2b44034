"""FMUs for the tests, built as a user builds them and once for all workers, and processes to run them in."""

from __future__ import annotations

import csv
import fcntl
import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = ROOT / "examples" / "columns"
PHOCAS, DAMPED = COLUMNS / "phocas.toml", COLUMNS / "phocas-damped.toml"
LINUX = ("--native", "--platforms", "linux64")
# in the environment: PythonFMUs that tests build carry libraries for this processor alone
HERE = "MULTIBLOCK_TESTS_OF_THIS_PROCESSOR"
# the status of what a PythonFMU refuses, with its guard and without
REFUSED = "error" if importlib.util.find_spec("ziglang") and sys.platform.startswith("linux") else "fatal"


def environment() -> dict[str, str]:
    """Return the environment of a child process, with project, tests and the scripts of this interpreter in reach."""
    scripts = str(Path(sys.executable).parent)
    modules = os.pathsep.join((str(ROOT), str(ROOT / "tests")))
    return os.environ | {"PYTHONPATH": modules, "PATH": scripts + os.pathsep + os.environ.get("PATH", "")}


def finish(*command: object, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, whatever it exits with, with more variables in its environment."""
    return finish_in(None, *command, **variables)


def finish_in(folder: Path | None, *command: object, **variables: str) -> subprocess.CompletedProcess[str]:
    """Finish a process as `finish` does, in a folder."""
    words, given = [str(part) for part in command], environment() | variables
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, env=given, check=False)


def run(*command: object, **variables: str) -> str:
    """Run a command to its end and return what it printed; fails unless it exits with 0."""
    done = finish(*command, **variables)
    assert done.returncode == 0, f"exit code {done.returncode}: {done.stderr}"
    return done.stdout


def building(script: Path) -> list[object]:
    """Return the command that runs a script which builds FMUs, for this processor alone in quick tests."""
    alone = [ROOT / "tests" / "support" / "inside" / "this_processor.py"] if HERE in os.environ else []
    return [sys.executable, *alone, script]


def read_results(path: Path) -> dict[str, np.ndarray]:
    """Return columns of an FMPy result file, Booleans as 0 and 1 (FMPy itself cannot read those back)."""
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
        run(*building(ROOT / "build_fmu.py"), column, "-o", output, *options, **variables)
        return output


def built_once(made: pytest.TempPathFactory, name: str, build: Callable[[Path], object]) -> Path:
    """Return a file or folder that the first worker which needs it builds for all of them; `build` takes its path."""
    root = made.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root
    built = root / f"{name}.built"
    with (root / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not built.exists():
            build(root / name)
            built.touch()
    return root / name


def c_host(folder: Path, target: str = "x86_64-linux-gnu") -> Path:
    """Return the host in C (tests/masters/host.c), compiled for a target."""
    source, host = ROOT / "tests" / "masters" / "host.c", folder / "host"
    run(sys.executable, "-m", "ziglang", "cc", "-target", target, "-O1", source, "-o", host, "-ldl")
    return host


def stack_file(folder: Path, n: int, text: str = "") -> Path:
    """Return the file of a column of n equal blocks, which begins with `text`."""
    block = "[[block]]\nheight = 1.0\nwidth = 1.0\ndepth = 1.0\ndensity = 2000.0\n"
    path = folder / "stack.toml"
    path.write_text(f'name = "stack"\n{text}{block * n}[joint]\nstiffness = 1e12\ndamping = 1e-3\n')
    return path
