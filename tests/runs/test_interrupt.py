"""Ctrl-C, callbacks, and the line that shows how far a run is."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from support.fmus import ROOT
from support.probe import G, phocas

from solver import Motion, simulate
from solver.commands import progress
from solver.kernels.machine.groups import GROUPS
from solver.models.column.run import Glance
from solver.models.column.stepper import Stepper
from solver.runs.many import begin_phase

if sys.platform == "win32":
    pytest.skip("signals of POSIX", allow_module_level=True)

BLOCK = """
[[block]]
height = 0.4
width = 1.0
depth = 1.0
density = 2500.0
[block.joint]
stiffness = 1e11
damping = 1e-5
"""


@pytest.fixture
def tall(tmp_path: Path) -> Path:
    """Return a folder with a column and a motion that take minutes."""
    (tmp_path / "tall.toml").write_text('name = "tall"\n' + 12 * BLOCK)
    t = 0.01 * np.arange(20000)
    rows = np.column_stack([t, 2.0 * np.sin(2.0 * np.pi * 1.3 * t)])
    np.savetxt(tmp_path / "motion.csv", rows, delimiter=",", header="time,base.ax", comments="")
    return tmp_path


def interrupted(
    folder: Path, *arguments: str, after: float = 5.0, from_line: bool = False, **variables: str
) -> tuple[subprocess.Popen[str], float, str, str]:
    """Return a command that gets SIGINT `after` s from its start, or from its first line; s until it ended, stdout,
    stderr.
    """
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    command = [sys.executable, *arguments]
    with subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        first = process.stdout.readline() if from_line and process.stdout else ""
        time.sleep(after)
        assert process.poll() is None, process.communicate()
        process.send_signal(signal.SIGINT)
        begin = time.monotonic()
        out, err = process.communicate(timeout=60.0)
        return process, time.monotonic() - begin, first + out, err


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    """Compile first, so that the interrupt hits a run, not the compilation."""
    simulate(phocas(1e-3), Motion.harmonic(1.0, 1.0, 0.1), check=True, ensemble=2).observe()


MANY = """
import sys
from solver import Column, Motion, simulate_many

column = Column.from_toml("tall.toml")
motions = [Motion.harmonic(0.1, 2.0 + 0.01 * k, 2.0) for k in range(40)]
table = simulate_many(column, motions, tolerance=float(sys.argv[1]), duration=0.01, keep=("path",))
motion = Motion.from_csv("motion.csv")
motions = [motion.scaled(1.0 + 0.01 * k) for k in range(40)]
print(table["path"][0], flush=True)
simulate_many(column, motions, tolerance=float(sys.argv[1]))
"""


@pytest.mark.long
@pytest.mark.parametrize(("tolerance", "path"), [("1e-4", "lanes"), ("1e-8", "scalar")])
def test_ctrl_c_ends_many_runs_at_once(tall: Path, tolerance: str, path: str) -> None:
    (tall / "many.py").write_text(MANY)
    process, took, out, err = interrupted(tall, "many.py", tolerance, after=2.0, from_line=True)
    assert out.split() == [path]
    assert process.returncode == -signal.SIGINT, err
    assert err.rstrip().endswith("KeyboardInterrupt")
    assert took < 5.0


@pytest.mark.parametrize(
    "options",
    [
        (),
        pytest.param(("--ensemble", "8"), marks=pytest.mark.long),
        pytest.param(("--formulation", "paper", "--step", "5e-5", "--no-check"), marks=pytest.mark.long),
    ],
)
def test_ctrl_c_ends_a_run_at_once(tall: Path, options: tuple[str, ...]) -> None:
    before = sorted(tall.iterdir())
    process, took, _, err = interrupted(
        tall, "-m", "solver", "simulate", "tall.toml", "motion.csv", "-o", "out.csv", *options
    )
    assert process.returncode == 130, err
    assert err == "python -m solver: interrupted\n"
    assert sorted(tall.iterdir()) == before
    # asked for: 0.5 s; the rest is for a machine on which several tests run at once
    assert took < 5.0


@pytest.mark.long  # processes that run for seconds before they are interrupted, as the next
def test_ctrl_c_while_kernels_are_compiled_ends_at_once(tall: Path) -> None:
    """Begin with an empty cache, so that the command compiles first."""
    process, took, out, err = interrupted(
        tall, "-m", "solver", "simulate", "tall.toml", "motion.csv", MULTIBLOCK_CACHE_DIR=str(tall / "cache")
    )
    assert (process.returncode, err) == (130, "python -m solver: interrupted\n")
    assert f"compiling the kernels of columns, once: about {GROUPS['column'].seconds} s\n" in out
    assert took < 5.0


@pytest.mark.long
def test_ctrl_c_while_the_results_are_written_leaves_nothing(tall: Path) -> None:
    """Check that a file takes its name once it is whole."""
    before = sorted(tall.iterdir())
    options = ("--duration", "1", "--output-step", "2e-6", "--no-check", "--settle", "0", "-o", "out.csv")
    process, _, _, err = interrupted(tall, "-m", "solver", "simulate", "tall.toml", "motion.csv", *options, after=12.0)
    assert (process.returncode, err) == (130, "python -m solver: interrupted\n")
    assert sorted(tall.iterdir()) == before


# --- from Python


def test_callback_sees_the_run_and_changes_nothing() -> None:
    column, motion = phocas(1e-3), Motion.harmonic(0.05 * G, 2.0, 20.0)
    seen: list[tuple[float, Glance]] = []
    run = simulate(column, motion, callback=lambda t, glance: seen.append((t, glance)))
    times = [t for t, _ in seen]
    assert times == sorted(times)
    assert len(times) > 2
    assert times[-1] == 20.0
    last = seen[-1][1]
    assert np.array_equal(last.peak_top_ux, run.peak_top_ux)
    assert last.ux == pytest.approx(run.ux[-1], abs=1e-14)
    assert last.ry == pytest.approx(run.ry[-1], abs=1e-15)
    assert np.array_equal(run.ux, simulate(column, motion).ux)


class EnoughError(Exception):
    pass


def test_what_a_callback_raises_ends_the_run() -> None:
    def stop(t: float, glance: Glance) -> None:
        raise EnoughError

    with pytest.raises(EnoughError):
        simulate(phocas(1e-3), Motion.harmonic(0.05 * G, 2.0, 20.0), callback=stop)


def test_chunks_change_a_run_by_less_than_the_tolerance(monkeypatch: pytest.MonkeyPatch) -> None:
    column, motion = phocas(1e-3), Motion.harmonic(0.05 * G, 2.0, 10.0)
    runs = []
    for chunk in (1e12, 4e5, 1e4):
        monkeypatch.setattr("solver.models.column.stepper.CHUNK", chunk)
        runs.append(simulate(column, motion))
    for run in runs[1:]:
        assert run.peak_top_ux == pytest.approx(runs[0].peak_top_ux, rel=1e-5)  # the tolerance
        assert run.ux == pytest.approx(runs[0].ux, abs=1e-5 * np.max(run.peak_top_ux))
    assert runs[1].stats["steps"] < 1.02 * runs[0].stats["steps"]


def test_chunks_end_alike_in_every_run() -> None:
    motion = Motion.harmonic(0.05 * G, 2.0, 10.0)
    ends: list[list[float]] = [[], []]
    for found in ends:
        Stepper(phocas(1e-3)).run(motion, 10.0, np.empty(0), found.append)
    assert ends[0] == ends[1]


def test_rows_of_a_fallen_column_are_there_to_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("solver.models.column.stepper.CHUNK", 1e4)
    monkeypatch.setattr("solver.models.column.stepper.ROWS_AT_ONCE", 7)
    run = simulate(phocas(1e-3), Motion.harmonic(0.1 * G, 0.25, 20.0))
    assert run.overturned
    after = run.time > run.overturn_time
    assert np.all(run.ux[after] == run.ux[-1])
    assert np.min(np.abs(run.ux[after, 0])) > 1.0


# --- on a terminal


@contextmanager
def patience(seconds: float) -> Iterator[io.StringIO]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(progress, "PATIENCE", seconds)
        shown = io.StringIO()
        patch.setattr(sys, "stderr", shown)
        yield shown


def test_a_long_run_shows_how_far_it_is_and_a_short_one_nothing() -> None:
    motion = Motion.harmonic(0.05 * G, 2.0, 20.0)
    for seconds, shows in ((0.0, True), (60.0, False)):
        with patience(seconds) as shown, pytest.MonkeyPatch.context() as patch:
            patch.setattr(shown, "isatty", lambda: True)
            progress.simulated(phocas(1e-3), motion, None)
        assert ("100%" in shown.getvalue() and "of 20 s" in shown.getvalue()) == shows


def test_in_a_pipe_a_long_study_says_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("solver.commands.progress.clock.monotonic", lambda: now[0])
    with patience(2.0) as shown, progress.PlainLine() as line:
        for done in range(101):
            now[0] = 1.0 * done
            line(done, 100)
    lines = shown.getvalue().splitlines()
    assert lines[0] == "10 of 100 runs, 10 %, after 10 s, 90 s left"
    assert [int(text.split()[0]) for text in lines] == [10, 15, 23, 35, 53, 80]


def test_a_phase_begins_anew_and_has_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("solver.commands.progress.clock.monotonic", lambda: now[0])
    with patience(2.0) as shown, progress.PlainLine() as line:
        for phase, start in (("varied runs", 0.0), ("margin, 1.4 times the motions", 100.0)):
            now[0] = start
            begin_phase(line, phase)
            for done in range(13):
                now[0] = start + done
                line(done, 40)
    begin_phase(None, "nothing is told")
    assert shown.getvalue().splitlines() == [
        "varied runs: 10 of 40 runs, 25 %, after 10 s, 30 s left",
        "margin, 1.4 times the motions: 10 of 40 runs, 25 %, after 10 s, 30 s left",
    ]
    with patience(0.0) as shown, progress.RunsLine() as bar:
        for phase, total in (("varied runs", 8), ("margin", 3)):
            bar.begin(phase)
            now[0] += 1.0
            bar(1, total)
    assert "varied runs" in shown.getvalue()
    assert "1/3" in shown.getvalue()  # each phase has its own number of runs
