"""Studies that are killed: nothing is lost, nothing is repeated, and no worker stays."""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from pathlib import Path

import pytest
from support.fmus import ROOT
from support.study import TEXT, finished, same, start

from solver.studies import Results, Study, run_study
from solver.studies.journal import read_journal


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL on Windows")
def test_killed_at_any_moment_it_loses_nothing_and_repeats_nothing(folder: Path) -> None:
    """Kill it some times at random moments while it works, then leave it alone: each run is there, once, to the bit."""
    (folder / "study.toml").write_text(TEXT.format(samples=2000), encoding="utf-8")
    runs = Study.from_toml(folder / "study.toml").runs  # of seconds in all: it is killed long before its end
    dice = random.Random(7)
    before, kills = 0, 0
    for _ in range(12):
        process = start(folder, "run", "study.toml", "--threads", 2, "--chunk", 0.02)
        while process.poll() is None and finished(folder) == before:
            time.sleep(0.002)
        time.sleep(0.15 * dice.random())
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
            kills += 1
        process.communicate()
        after = finished(folder)
        assert after >= before  # what was finished before is still there
        before = after
        if before == runs:
            break
    assert kills >= 3
    process = start(folder, "run", "study.toml")
    out, errors = process.communicate()
    assert process.returncode == 0, errors
    assert f"{runs} of {runs} runs" in out
    _, rows = read_journal(folder / "small.journal")
    assert sorted(row[0] for row in rows) == list(range(runs))
    assert finished(folder) == runs  # none twice
    study = Study.from_toml(folder / "study.toml")
    assert same(Results.from_journal(folder / "small.journal"), run_study(study))


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="children are looked for in /proc")
@pytest.mark.parametrize(
    "how", [signal.SIGKILL, *(pytest.param(one, marks=pytest.mark.long) for one in (signal.SIGINT, signal.SIGTERM))]
)
def test_workers_end_with_the_process_that_started_them(folder: Path, how: signal.Signals) -> None:
    """Wait for their end: measured 0.1 s.

    Ctrl-C, which a terminal sends to all of them, does not wait for the runs under way either.
    """
    (folder / "study.toml").write_text(TEXT.format(samples=200_000), encoding="utf-8")
    process = start(folder, "run", "study.toml", "--processes", 2)
    while finished(folder) < 20:
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    workers = children(process.pid)
    assert len(workers) >= 2
    begin = time.monotonic()
    process.send_signal(how)
    if how == signal.SIGINT:
        for worker in workers:
            os.kill(worker, how)
    _, errors = process.communicate()
    if how == signal.SIGINT:
        assert time.monotonic() - begin < 2.0  # measured: 0.2 s; when it waited for the runs sent: 4 to 11 s
        assert process.returncode == 130
        last = errors.splitlines()[-1]
        assert last.startswith("python -m solver: interrupted; finished runs are kept in ")
        assert last.endswith(".journal, the same command makes the others")
        assert "Traceback" not in errors
        assert len(list(read_journal(folder / "small.journal")[1])) == finished(folder)  # whole
    begin = time.monotonic()
    while any(map(is_running, workers)) and time.monotonic() - begin < 5.0:
        time.sleep(0.05)
    left = [worker for worker in workers if is_running(worker)]
    for worker in left:
        os.kill(worker, signal.SIGKILL)
    assert left == []


# in a worker: results of runs are sent by half, in the middle of which Ctrl-C finds it
HALF = """
import multiprocessing.connection, os, pathlib, sys, time
if "--multiprocessing-fork" in sys.orig_argv:
    whole = multiprocessing.connection.Connection._send
    def half(self, buffer, write=os.write):
        if len(buffer) < 500:
            return whole(self, buffer)
        write(self._handle, buffer[: len(buffer) // 2])
        pathlib.Path("half").touch()
        time.sleep(60.0)
    multiprocessing.connection.Connection._send = half
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends results in another way")
def test_ctrl_c_while_a_worker_sends_its_results(folder: Path) -> None:
    (folder / "study.toml").write_text(TEXT.format(samples=2000), encoding="utf-8")
    (folder / "sitecustomize.py").write_text(HALF, encoding="utf-8")
    modules = {"PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)])}
    process = start(folder, "run", "study.toml", "--processes", 2, **modules)
    while not (folder / "half").exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30.0)  # measured: 2.3 s; it waited for the other half
    assert process.returncode == 130
    assert any(
        line.startswith("python -m solver: interrupted; finished runs are kept in ") for line in errors.splitlines()
    )


def status(process: int) -> list[str]:
    """State and parent of a process."""
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[:2]


def children(process: int) -> list[int]:
    numbers = [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]
    return [number for number in numbers if is_running(number) and status(number)[1] == str(process)]


def is_running(process: int) -> bool:
    try:
        return status(process)[0] != "Z"
    except OSError:
        return False
