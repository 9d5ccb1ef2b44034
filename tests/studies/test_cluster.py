"""Studies on Dask: a worker dies, the scheduler goes away; no run is lost and none is there twice."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.columns import BLOCK
from support.fmus import ROOT
from support.study import TEXT, finished, same, start

from solver import InputError
from solver.studies import Results, Study, run_study
from solver.studies.cluster import Cluster
from solver.studies.journal import read_journal

pytestmark = [
    pytest.mark.long,  # processes of Dask take seconds to start
    pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL on Windows"),
]
RUNS = 1200


class Site:
    """A scheduler and two workers on this machine, each a process of its own."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "scheduler.json"
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0")
        self.workers = [self._start("worker", "--nthreads", "1", "--no-nanny") for _ in range(2)]
        self.address = self._address()

    def _start(self, *words: str) -> subprocess.Popen[bytes]:
        line = [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:], "--no-dashboard"]
        environment = os.environ | {"PYTHONPATH": str(ROOT), "DASK_TEMPORARY_DIRECTORY": str(self._file.parent)}
        return subprocess.Popen(
            [*line, "--scheduler-file", str(self._file)],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=self._file.parent,
        )

    def _address(self) -> str:
        for _ in range(600):
            # The scheduler does not write its file in one go: it may be missing, empty or begun.
            with contextlib.suppress(FileNotFoundError, json.JSONDecodeError):
                address: str = json.loads(self._file.read_text(encoding="utf-8"))["address"]
                return address
            time.sleep(0.1)
        raise TimeoutError("no scheduler")

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    found = Site(tmp_path)
    yield found
    found.close()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a study of 1200 runs of a single block."""
    (tmp_path / "block.toml").write_text(BLOCK, encoding="utf-8")
    (tmp_path / "study.toml").write_text(TEXT.format(samples=RUNS // 2), encoding="utf-8")
    return tmp_path


def run_until(folder: Path, site: Site, count: int) -> subprocess.Popen[str]:
    """Return a study on the site, of which some runs are finished, but not all."""
    process = start(folder, "run", "study.toml", "--dask", site.address, "--chunk", 0.05)
    while finished(folder) < count:
        assert process.poll() is None, process.communicate()
        time.sleep(0.005)
    assert finished(folder) < RUNS
    return process


def check(folder: Path) -> None:
    """Check that each run is there, once, to the bit."""
    _, rows = read_journal(folder / "small.journal")
    assert sorted(row[0] for row in rows) == list(range(RUNS))
    assert finished(folder) == RUNS
    assert same(Results.from_journal(folder / "small.journal"), run_study(Study.from_toml(folder / "study.toml")))


def test_a_worker_that_dies_has_its_chunks_redone(folder: Path, site: Site) -> None:
    process = run_until(folder, site, 100)
    site.workers[0].send_signal(signal.SIGKILL)
    out, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    assert f"{RUNS} of {RUNS} runs" in out
    check(folder)


def test_a_scheduler_that_goes_away_leaves_what_was_finished(folder: Path, site: Site) -> None:
    process = run_until(folder, site, 100)
    site.scheduler.send_signal(signal.SIGKILL)
    before = finished(folder)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 2
    assert "finished runs are kept" in errors.splitlines()[-1]
    kept = finished(folder)
    assert before <= kept < RUNS
    process = start(folder, "run", "study.toml")
    _, errors = process.communicate()
    assert (process.returncode, errors) == (0, "")
    check(folder)


def test_a_local_cluster(folder: Path) -> None:
    process = start(folder, "run", "study.toml", "--dask", "local")
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    check(folder)


def test_nobody_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("solver.studies.cluster.CONNECT", "1s")
    with pytest.raises(InputError, match=r"--dask tcp://127\.0\.0\.1:9: no scheduler answers"):
        Cluster("tcp://127.0.0.1:9")
    with pytest.raises(InputError, match=r"address = 5: must be of type str"):
        Cluster(5)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"workers = 0: must be a number of workers"):
        Cluster("local", 0)
