"""Programs of this machine and functions of tests/support/inside/, each in a process of its own."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from .child import command, returned
from .fmus import ROOT

EXAMPLE = ROOT / "examples" / "coupling"
TESTS = ROOT / "tests"


class AbsentError(Exception):
    """Why a master cannot be tried here."""


class ComplaintError(Exception):
    """A master did something that it should not have done."""


def run(*command: object, environment: dict[str, str] | None = None, cwd: str | None = None, bad: str = "") -> str:
    """Return the output of a process.

    Raises ComplaintError unless it ends with 0 and prints none of the words in `bad`.
    """
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, cwd=cwd, check=False)
    text = (done.stdout + done.stderr).strip()
    if done.returncode or any(word in text.lower() for word in bad.split()):
        raise ComplaintError(f"exit code {done.returncode}: {text[-400:]}")
    return text


def called(function: Callable[..., object], *arguments: object, **named: object) -> Any:
    """Call a function of tests/support/inside/ in a process that has the example's modules and pip's libraries."""
    return returned(run(*command(function, *arguments, **named), environment=with_example()))


def with_example() -> dict[str, str]:
    libraries = os.pathsep.join((str(Path(sys.prefix) / "lib"), os.environ.get("LD_LIBRARY_PATH", "")))
    modules = os.pathsep.join(map(str, (EXAMPLE, ROOT, TESTS)))
    return os.environ | {"PYTHONPATH": modules, "LD_LIBRARY_PATH": libraries}


def found(name: str) -> str:
    path = shutil.which(name, path=os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", ""))))
    if path is None:
        raise AbsentError(f"no {name} on the PATH")
    return path


def needs(package: str) -> None:
    if importlib.util.find_spec(package) is None:
        raise AbsentError(f"{package} is not installed")


def needs_ecos() -> None:
    needs("ecospy")
    if not list((Path(sys.prefix) / "lib").glob("libtbb.so.12")):
        raise AbsentError("needs libtbb.so.12, which pip install tbb brings")


def versioned(name: str, package: str | None) -> str:
    """Return the name of a master, with its version where pip knows it."""
    with suppress(importlib.metadata.PackageNotFoundError):
        return f"{name} ({importlib.metadata.version(package)})" if package else name
    return name
