"""The benchmarks of the FMU: that they run and print what they say, not how fast anything is."""

from __future__ import annotations

import re
import sys

import pytest
from support.fmus import run


@pytest.mark.long
def test_prints_a_figure_for_each_part() -> None:
    parts = ("state", "getters", "threads", "exits")
    out = run(sys.executable, "-m", "benchmarks.fmu", *parts, "--rounds", 1, "--processes", 4)
    lines = out.splitlines()
    assert [line.split()[0] for line in lines] == list(parts)
    state, getters, threads, exits = lines
    assert re.search(r"get \+ set \+ free [\d.]+ us \(n = 3\)", state)
    assert re.search(r"\d+ outputs: [\d.]+ s, empty [\d.]+ s, [\d.]+ times", getters)
    assert re.search(r"in two threads [\d.]+ s: [\d.]+ times as fast", threads)
    assert "status 0 in 4 of 4 processes, 1 different result" in exits
