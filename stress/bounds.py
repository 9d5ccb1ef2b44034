"""Scenes run by kernels that check the bounds of every row, and by the usual ones: no fault, and equal bits.

A fault ends the process of the checked kernels with a line (kernels/numba_ext/bounds.py); the campaign goes on.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

from . import scenes

ROOT = Path(__file__).resolve().parent.parent
CHECKED = {"MULTIBLOCK_BOUNDS": "1"}


class Checked:
    """A process with checked kernels that runs scenes one after the other."""

    def __init__(self, said: IO[str]) -> None:
        command = [sys.executable, "-W", "ignore", "-m", "stress.in_process", "serve_scenes", "[]"]
        self._process = subprocess.Popen(
            command,
            cwd=ROOT,
            env=os.environ | CHECKED,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=said,
            text=True,
        )

    def digest(self, kind: str, seed: int, number: int) -> str | None:
        """Hash of what a scene gives (scenes.py); None if the process ended."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(json.dumps([kind, seed, number]), file=self._process.stdin, flush=True)
        answer = self._process.stdout.readline()
        return str(json.loads(answer)) if answer else None

    def end(self) -> int:
        """Let the process end; returns its exit code, below 0 of a signal."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        return self._process.wait()


def campaign(kind: str, seed: int, first: int, count: int) -> dict[str, Any]:
    """Return the findings of the scenes first, first + 1, ... of a kind: faults, and bits unlike usual ones."""
    failures: list[str] = []
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as said:
        checked, read = Checked(said), 0
        for number in range(first, first + count):
            found = checked.digest(kind, seed, number)
            if found is None:
                code = checked.end()
                said.seek(read)
                lines = said.read().strip().splitlines() or [""]
                read = said.tell()
                failures.append(f"{kind} {seed}-{number}: {lines[-1]} (exit {code})")
                checked = Checked(said)
            elif found != scenes.digest(kind, seed, number):
                failures.append(f"{kind} {seed}-{number}: other bits than those of the usual kernels")
        checked.end()
    return {"name": kind, "seed": seed, "first": first, "tried": count, "failures": failures}


def run(seed: int, first: int, count: int, only: str | None = None) -> Iterator[dict[str, Any]]:
    """Return the findings of every kind of scenes, or of one."""
    for kind in scenes.KINDS:
        if only in (None, kind):
            yield campaign(kind, seed, first, count)
