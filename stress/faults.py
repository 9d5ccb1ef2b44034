"""Faults of the machine during work: killed processes, full disks, read-only folders, clocks that jump.

Each check returns (number of trials or of kills that hit a process, problems). No data may be lost, no half-written
file may look whole, and the next run must work.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COLUMN = ROOT / "examples" / "columns" / "phocas-damped.toml"
PATIENCE = 600.0  # s
Outcome = tuple[int, list[str]]


def environment(**changes: str) -> dict[str, str]:
    """Return the environment of a child process that finds project and tests."""
    return os.environ | {"PYTHONPATH": os.pathsep.join((str(ROOT), str(ROOT / "tests")))} | changes


def calling(function: str, *arguments: object) -> list[str]:
    """Return Python's arguments for a function of in_process.py."""
    return ["-m", "stress.in_process", function, json.dumps(arguments, default=str)]


def launch(*arguments: object, **changes: str) -> subprocess.Popen[str]:
    """Start Python with these arguments."""
    command = [sys.executable, *map(str, arguments)]
    return subprocess.Popen(
        command, cwd=ROOT, env=environment(**changes), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def finish(*arguments: object, **changes: str) -> tuple[int, str, str]:
    """Exit code, standard output, standard error."""
    process = launch(*arguments, **changes)
    out, err = process.communicate(timeout=PATIENCE)
    return process.returncode, out, err


def killed_after(delay: float, *arguments: object, **changes: str) -> bool:
    """Start and kill after `delay` seconds; whether it was still running."""
    process = launch(*arguments, **changes)
    time.sleep(delay)
    running = process.poll() is None
    process.kill()
    process.communicate()
    return running


def timed(*arguments: object, **changes: str) -> tuple[float, str, str]:
    """Return the wall-clock time, s, of a process that must succeed, its standard output, and its error or ""."""
    begin = time.monotonic()
    code, out, err = finish(*arguments, **changes)
    return time.monotonic() - begin, out, (err or f"exit code {code}") if code else ""


def _none_hit(kills: int) -> list[str]:
    return [] if kills else ["no process was still running when it was to be killed"]


def killed_while_writing(folder: Path, times: int, chance: random.Random) -> Outcome:
    """Overwrite a response by another one, and kill the writer: the file is the older or the newer, whole."""
    output = folder / "response.csv"
    commands, whole = [], []
    for amplitude in (0.1, 0.2):
        motion = folder / f"motion-{amplitude}.csv"
        motion.write_text(f"time,base.ax\n0,0\n5,{amplitude}\n")
        commands.append(["-m", "solver", "simulate", COLUMN, motion, "--output-step", "1e-4", "--force", "-o", output])
    length = 0.0
    for command in (*commands, commands[0]):  # the first one fills the cache
        length, _, err = timed(*command)
        if err:
            return 0, [err]
        whole.append(output.read_bytes())
    if whole[0] == whole[1] or whole[0] != whole[2]:
        return 0, ["the two motions must give two responses, always the same"]
    problems, kills, now = [], 0, whole[0]
    for k in range(times):
        kills += killed_after(length * chance.uniform(0.4, 1.0), *commands[(k + 1) % 2])
        found = output.read_bytes()
        if found not in (now, whole[(k + 1) % 2]):
            problems.append("the file is neither the previous nor the next one")
            finish(*commands[0])
            found = whole[0]
        now = found
    return kills, problems + _none_hit(kills)


def killed_while_building(folder: Path, times: int, chance: random.Random) -> Outcome:
    """Check that a build ended at any time leaves no FMU or a whole one, and the next one works."""
    output = folder / "killed.fmu"
    command = ["build_fmu.py", COLUMN, "--force", "-o", output]
    finish(*command)  # fills the cache
    length, _, err = timed(*command)
    if err:
        return 0, [err]
    whole = output.read_bytes()
    problems, kills = [], 0
    for _ in range(times):
        output.unlink(missing_ok=True)
        kills += killed_after(length * chance.uniform(0.1, 1.0), *command)
        if output.exists() and zipfile.ZipFile(output).testzip() is not None:
            problems.append("a part of an FMU was left")
    code, _, err = finish(*command)
    if code or not _same_but_for_the_date(output.read_bytes(), whole, folder):
        problems.append(f"the next build: {err or 'another FMU'}")
    return kills, problems + _none_hit(kills)


def _one_line(code: int, err: str) -> bool:
    """Return True if a command ended with one line of error; matplotlib may complain of its own cache before it."""
    last = err.strip().splitlines()[-1:]
    return code == 2 and "Traceback" not in err and any(f"{name}: " in last[0] for name in ("solver", "build_fmu.py"))


def _same_but_for_the_date(one: bytes, other: bytes, folder: Path) -> bool:
    contents = []
    for data in (one, other):
        (folder / "compared.fmu").write_bytes(data)
        with zipfile.ZipFile(folder / "compared.fmu") as archive:
            contents.append({n: archive.read(n) for n in archive.namelist() if n != "modelDescription.xml"})
    return contents[0] == contents[1]


def killed_while_starting(fmu: Path, folder: Path, times: int, chance: random.Random) -> Outcome:
    """End the first start on an account while the FMU or its code is extracted: the next start works."""
    length, reference, err = timed(*calling("start", fmu), XDG_CACHE_HOME=str(folder / "whole"))
    if err:
        return 0, [err]
    problems, kills = [], 0
    for k in range(times):
        home = str(folder / f"killed-{k % 5}")  # some are killed several times
        kills += killed_after(length * chance.uniform(0.1, 1.0), *calling("start", fmu), XDG_CACHE_HOME=home)
        if k % 5 == 4 or k >= times - 5:
            code, out, err = finish(*calling("start", fmu), XDG_CACHE_HOME=home)
            if code or out != reference:
                problems.append(f"the next start: {err or 'other numbers'}")
    return kills, problems + _none_hit(kills)


def full_disk(fmu: Path, folder: Path) -> Outcome:
    """Let no file grow beyond a few kB: exit code 2 and one line, the previous file as it was; the FMU runs."""
    motion, output = folder / "motion.csv", folder / "full.csv"
    motion.write_text("time,base.ax\n0,0\n1,0.1\n")
    output.write_text("previous")
    commands = {
        "solver": ["simulate", COLUMN, motion, "--force", "-o", output],
        "build_fmu": [COLUMN, "--force", "-o", folder / "full.fmu"],
    }
    problems = []
    for name, arguments in commands.items():
        module, script, *call = calling("command", name, arguments)
        full = str(folder / "full")
        code, _, err = finish(module, script, "--largest-file", 5000, *call, XDG_CACHE_HOME=full)
        if not _one_line(code, err):
            problems.append(f"{name} on a full disk: exit code {code}, {err.strip()[-300:]!r}")
    if output.read_text() != "previous" or (folder / "full.fmu").exists():
        problems.append("a part was written over the whole")
    expected = finish(*calling("start", fmu))[1]
    for limit in (100, 20_000, 500_000):
        home = str(folder / f"full-{limit}")
        code, out, err = finish(*calling("start", fmu, limit), XDG_CACHE_HOME=home)
        if code or not _close(out, expected):
            problems.append(f"FMU on a full disk ({limit}): exit code {code}, {err[-300:]!r}")
    return 5, problems


def _close(one: str, other: str) -> bool:
    pairs = zip(json.loads(one), json.loads(other), strict=True)
    return all(abs(a - b) <= 1e-6 * max(abs(a), abs(b)) for a, b in pairs)


def read_only(fmu: Path, folder: Path) -> Outcome:
    """Check folders that cannot be written to or made: exit code 2 and one line; the FMU runs without its own cache."""
    motion = folder / "motion.csv"
    motion.write_text("time,base.ax\n0,0\n1,0.1\n")
    (folder / "file").write_text("no folder")
    problems = []
    for nowhere in (folder / "file" / "below", Path("/proc") / "nowhere"):
        for command in (
            ["-m", "solver", "simulate", COLUMN, motion, "-o", nowhere / "out.csv"],
            ["build_fmu.py", COLUMN, "-o", nowhere / "out.fmu"],
        ):
            code, _, err = finish(*command)
            if not _one_line(code, err):
                problems.append(f"{command[1:3]} into {nowhere}: exit code {code}, {err.strip()[-300:]!r}")
        code, out, err = finish(*calling("start", fmu), XDG_CACHE_HOME=str(nowhere))
        if code or not _close(out, finish(*calling("start", fmu))[1]):
            problems.append(f"FMU with its cache in {nowhere}: exit code {code}, {err[-300:]!r}")
    return 6, problems


def clocks(fmu: Path, folder: Path) -> Outcome:
    """Check clocks that jump by days at every call, machine code kept in the future and the past: equal bits."""
    problems = []
    module, script, *run = calling("simulate", COLUMN)
    start = calling("start", fmu)[2:]
    home = folder / "clock"
    changed = {"XDG_CACHE_HOME": str(home)}
    expected = finish(module, script, *run, **changed)[:2]  # compiles
    files = {file for file in home.rglob("*") if file.is_file()}
    if not files:
        problems.append("the first run leaves no machine code in its cache")
    if finish(module, script, "--jumping-clock", *run)[:2] != expected:
        problems.append("a run depends on the clock")
    if finish(module, script, "--jumping-clock", *start)[:2] != finish(module, script, *start)[:2]:
        problems.append("the FMU depends on the clock")
    for stamp in (0.0, 4e9):
        for file in files:
            os.utime(file, (stamp, stamp))
        if finish(module, script, "--jumping-clock", *run, **changed)[:2] != expected:
            problems.append(f"a run depends on the time of its machine code ({stamp:g})")
        if {file for file in home.rglob("*") if file.is_file()} != files:
            problems.append(f"other machine code was made for its time ({stamp:g})")
    return 4, problems


def together(folder: Path, builders: int = 3) -> Outcome:
    """Make several builds of one FMU into one file: all succeed and the file is whole."""
    output = folder / "together.fmu"
    processes = [launch("build_fmu.py", COLUMN, "--force", "-o", output) for _ in range(builders)]
    problems = []
    for process in processes:
        _, err = process.communicate(timeout=PATIENCE)
        if process.returncode:
            problems.append(f"a build beside others: {err.strip()[-300:]}")
    if not problems and zipfile.ZipFile(output).testzip() is not None:
        problems.append("the FMU of several builds is damaged")
    if list(folder.glob(".together*")):
        problems.append("something was left behind")
    return builders, problems


def checks(fmu: Path, folder: Path, number: int, times: int) -> dict[str, Callable[[], Outcome]]:
    """Return all checks by name."""
    chance = random.Random(number)
    return {
        "killed while a response is written": lambda: killed_while_writing(folder, times, chance),
        "killed while an FMU is built": lambda: killed_while_building(folder, times, chance),
        "killed while an FMU is extracted and started": lambda: killed_while_starting(fmu, folder, times, chance),
        "full disk": lambda: full_disk(fmu, folder),
        "folders that cannot be written to": lambda: read_only(fmu, folder),
        "clocks that jump": lambda: clocks(fmu, folder),
        "builds at once": lambda: together(folder),
    }


def run(number: int, times: int) -> Iterator[dict[str, object]]:
    """Return {"name", "tried", "failures"} of each, as it ends."""
    with tempfile.TemporaryDirectory(prefix="stress_") as name:
        folder = Path(name)
        fmu = folder / "column.fmu"
        code, _, err = finish("build_fmu.py", COLUMN, "-o", fmu)
        if code:
            yield {"name": "build", "tried": 1, "failures": [err]}
            return
        for name, check in checks(fmu, folder, number, times).items():
            tried, failures = check()
            yield {"name": name, "tried": tried, "failures": failures}
