"""The native FMU outside Python, on this machine: `python tests/masters/native.py [FILE.toml] [--sequences N]`.

The same small host (host.c) runs it as it is, under valgrind, and the Windows library under wine; calls in any order
(tests/support/random_calls.py) are made to a library whose C layer is compiled with AddressSanitizer and
UndefinedBehaviorSanitizer: N sequences of 20000 calls, each in a process of its own. What is not installed is skipped
with a reason. Exit code 1 if a run fails; the outputs are printed and are to agree.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from fmpy import extract, read_model_description

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
HOST = HERE / "host.c"
sys.path.insert(0, str(ROOT))

from build_fmu import DEFAULT_COLUMN, build_native_fmu  # noqa: E402
from fmu_src.body import read_body  # noqa: E402
from fmu_src.native import library  # noqa: E402
from fmu_src.native.package import contents_of  # noqa: E402
from fmu_src.native.platforms import PLATFORMS  # noqa: E402
from fmu_src.native.table import headers  # noqa: E402
from solver.kernels.machine.packaging import object_code  # noqa: E402

CALLS = 20000  # of a sequence
PATIENCE = 900.0  # s
REPORTS = ("ERROR: AddressSanitizer", "runtime error")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=undefined")


def main(arguments: list[str] | None = None) -> int:
    """Try every host; returns the exit code."""
    parser = argparse.ArgumentParser(description="The native FMU outside Python.")
    parser.add_argument("column", nargs="?", type=Path, default=DEFAULT_COLUMN)
    parser.add_argument("--sequences", type=int, default=1)
    options = parser.parse_args(arguments)
    column = options.column
    with tempfile.TemporaryDirectory() as temporary:
        fmu = build_native_fmu(column, Path(temporary) / "column.fmu")
        failures = _sanitized(column, fmu, Path(temporary), options.sequences)
        return int(_hosts(str(fmu)) + failures > 0)


def _sanitized(column: Path, fmu: Path, folder: Path, sequences: int) -> int:
    """Call a library with sanitizers in any order."""
    if not shutil.which("gcc"):
        print(f"{'sanitizers':10} skipped: gcc is not installed")
        return 0
    contents = contents_of(read_body(column))
    for name, text in headers(contents).items():
        (folder / name).write_text(text, encoding="utf-8")
    (code,) = object_code(contents.subject.group, PLATFORMS[2]["linux64"].targets)
    (folder / "kernels.o").write_bytes(code)
    output = folder / "sanitized.so"
    command = ["gcc", "-std=c11", "-g", "-O1", "-shared", "-fPIC", *SANITIZERS, f"-I{folder}", f"-I{library.headers()}"]
    subprocess.run(
        [*command, "-Wall", "-Wextra", "-Werror", *library.sources(2), folder / "kernels.o", "-lm", "-o", output],
        check=True,
    )
    changed = folder / "sanitized.fmu"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(changed, "w") as new:
        for name in old.namelist():
            new.writestr(name, output.read_bytes() if name.endswith(".so") else old.read(name))
    runtime = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
    environment = os.environ | {
        "LD_PRELOAD": runtime.stdout.strip(),
        "ASAN_OPTIONS": "detect_leaks=0",
        "PYTHONPATH": os.pathsep.join((str(ROOT), str(ROOT / "tests"))),
        "TMPDIR": str(folder),
    }
    failed, reports, last = 0, [], ""
    for seed in range(3, 3 + sequences):
        command = [
            sys.executable,
            str(ROOT / "tests" / "support" / "random_calls.py"),
            str(changed),
            str(CALLS),
            str(seed),
        ]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, env=environment, timeout=PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            failed += 1
            print(f"{'sanitizers':10} seed {seed}: no end within {PATIENCE} s")
            continue
        found = [line for line in done.stderr.splitlines() if any(sign in line for sign in REPORTS)]
        last = (done.stdout.strip().splitlines() or [""])[-1]
        failed += done.returncode != 0
        reports += found
        if done.returncode or found:
            print(f"{'sanitizers':10} seed {seed}: status {done.returncode}: {last} {' '.join(found[:3])}")
    print(f"{'sanitizers':10} {sequences} sequences, {failed} failed, {len(reports)} reports; the last: {last}")
    return int(failed > 0 or bool(reports))


def _hosts(fmu: str) -> int:
    description = read_model_description(fmu)
    name = description.coSimulation.modelIdentifier
    reference = {variable.name: str(variable.valueReference) for variable in description.modelVariables}
    moved = next(name for name in reference if name.startswith("block[") and name.endswith("].ux"))
    words = ["file:///nowhere", description.guid, reference["base.ax"], reference[moved]]
    failures = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        binaries = Path(extract(fmu, unzipdir=temporary)) / "binaries"
        linux, windows = binaries / "linux64" / f"{name}.so", binaries / "win64" / f"{name}.dll"
        host, host_exe = folder / "host", folder / "host.exe"
        _compile(host, "-target", "x86_64-linux-gnu", "-ldl")  # valgrind does not know the newest instructions
        runs: dict[str, tuple[list[Path | str], dict[str, str], str]] = {"plain": ([host, linux], {}, "")}
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
    return failures


def _compile(output: Path, *options: str) -> None:
    subprocess.run(
        [sys.executable, "-m", "ziglang", "cc", "-O1", "-g", str(HOST), "-o", str(output), *options], check=True
    )


if __name__ == "__main__":
    raise SystemExit(main())
