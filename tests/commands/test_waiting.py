"""Who waits for the compiler reads why: once, on a terminal only."""

from __future__ import annotations

import io
import sys
from types import SimpleNamespace

import pytest

from solver.common import waiting


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def compiled(monkeypatch: pytest.MonkeyPatch, shown: io.StringIO, *entries: tuple[str, str]) -> list[str]:
    """Lines that are shown where these are compiled, each with a function that it calls."""
    monkeypatch.setattr(sys, "stderr", shown)
    monkeypatch.setattr(waiting, "_said", set())
    listener = waiting._Compiling()
    inner = event("solver.kernels.joint.law", "force")
    for module, name in entries:
        listener.on_start(event(module, name))
        listener.on_start(inner)
        listener.on_end(inner)
        listener.on_end(event(module, name))
    return shown.getvalue().splitlines()


def event(module: str, name: str) -> SimpleNamespace:
    entry = SimpleNamespace(__module__=module, __name__=name)
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=entry)})


RUN = "solver.kernels.api.entries", "run"
LANES = "solver.kernels.batch.entries"


def test_a_terminal_says_it_once_for_each_kind_of_run(monkeypatch: pytest.MonkeyPatch) -> None:
    assert compiled(monkeypatch, Terminal(), RUN, RUN, (LANES, "run_round"), (LANES, "run_lanes")) == [
        "compiling the kernels of columns, once: about 30 s",
        "compiling the kernels of columns in lanes, once: about 10 s",
    ]


def test_what_is_quick_or_of_others_is_not_announced(monkeypatch: pytest.MonkeyPatch) -> None:
    others = ("solver.kernels.api.entries", "joint_energies"), ("copy.kernels.api.entries", "run"), ("mine", "run")
    assert compiled(monkeypatch, Terminal(), *others) == []


def test_a_pipe_stays_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    assert compiled(monkeypatch, io.StringIO(), RUN) == []
