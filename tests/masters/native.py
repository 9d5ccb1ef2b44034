"""A native FMU outside Python, on this machine: `python tests/masters/native.py FILE.fmu`. Exit code 1 if a run fails.

The same small host (host.c) for each: as it is, under valgrind, and the Windows one under wine.
What is not installed is skipped with a reason. The outputs of all are to agree.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import extract, read_model_description

HOST = Path(__file__).resolve().parent / "host.c"


def main(fmu: str) -> int:
    """Try every host; returns the exit code."""
    description = read_model_description(fmu)
    name = description.coSimulation.modelIdentifier
    reference = {variable.name: str(variable.valueReference) for variable in description.modelVariables}
    words = ["file:///nowhere", description.guid, reference["base.ax"], reference["block[1].ux"]]
    failures = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        binaries = Path(extract(fmu, unzipdir=temporary)) / "binaries"
        linux, windows = binaries / "linux64" / f"{name}.so", binaries / "win64" / f"{name}.dll"
        host, host_exe = folder / "host", folder / "host.exe"
        _compile(host, "-target", "x86_64-linux-gnu", "-ldl")  # valgrind does not know the newest instructions
        runs = {"plain": ([host, linux], {}, "")}
        check = ["valgrind", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite,possible"]
        runs["valgrind"] = ([*check, host, linux], {}, "" if shutil.which("valgrind") else "valgrind is not installed")
        quiet = {"WINEDEBUG": "-all", "WINEPREFIX": str(folder / "wine")}
        wine = shutil.which("wine64") or shutil.which("wine")
        if wine and windows.is_file():
            _compile(host_exe, "-target", "x86_64-windows-gnu")
        why = "wine is not installed" if not wine else "" if windows.is_file() else "the FMU holds no win64"
        runs["wine"] = ([wine or "wine", host_exe, windows], quiet, why)
        for label, (command, environment, absent) in runs.items():
            if absent:
                print(f"{label:10} skipped: {absent}")
                continue
            done = subprocess.run(
                [str(word) for word in (*command, *words)],
                capture_output=True,
                text=True,
                env=os.environ | environment,
                timeout=600,
                check=False,
            )
            summary = [line for line in done.stderr.splitlines() if "ERROR SUMMARY" in line or "in use at exit" in line]
            print(f"{label:10} status {done.returncode}: {done.stdout.strip()} {' '.join(summary)}")
            failures += done.returncode != 0
    return 1 if failures else 0


def _compile(output: Path, *options: str) -> None:
    subprocess.run(
        [sys.executable, "-m", "ziglang", "cc", "-O1", "-g", str(HOST), "-o", str(output), *options], check=True
    )


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1]))
