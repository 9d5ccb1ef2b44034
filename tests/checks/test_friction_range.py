"""Checks over a range of friction: against checks of files with that friction, and the lines made of them."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multiblock import InputError, Motion, Plan, Structure, check, wavelets
from solver.checks.friction import Envelope, friction_values, with_friction
from solver.checks.table import rows_of
from solver.commands.check_report import friction_lines
from solver.commands.command_line import main
from solver.runs.table import Table

PLAN = Plan(ensemble=2, margin=False, joints=False)
FRICTIONS = (0.2, 0.7)
FILE = """name = "pair"
[joints]
stiffness = 1e9
damping = 3e-3
friction = 0.5
[neighbours]
reach = 1.0
line_stiffness = 1e8
restitution = 0.4
friction = 0.3
[[block]]
name = "first"
on = "base"
at = [0.0, 0.0]
shape = "drum"
diameter = 1.0
height = 3.0
density = 2000.0
[[block]]
name = "second"
on = "base"
at = [1.05, 0.0]
shape = "drum"
diameter = 1.0
height = 2.0
density = 2000.0
"""


def pair(friction: float) -> Structure:
    """Return two casks 50 mm apart, of which the taller one rocks against the other."""
    data = tomllib.loads(FILE)
    data["joints"]["friction"] = friction
    return Structure.from_dict(data)


@pytest.fixture(scope="module")
def envelope() -> Envelope:
    """Check the pair at both values of friction, under a pulse of 0.37 g."""
    pulse = wavelets.ricker(3.6, 0.8)
    return Envelope(FRICTIONS, [check(with_friction(pair(0.5), one), {"pulse": pulse}, plan=PLAN) for one in FRICTIONS])


def test_each_value_is_the_check_of_a_file_with_that_friction(envelope: Envelope) -> None:
    for value, found in zip(FRICTIONS, envelope.checks, strict=True):
        apart = check(pair(value), {"pulse": wavelets.ricker(3.6, 0.8)}, plan=PLAN)
        assert found.name == f"pair {value:g}"
        assert repr(found.rows) == repr(apart.rows)


def test_the_envelope_is_the_worst_of_all_runs(envelope: Envelope) -> None:
    sliding, rocking = envelope.checks
    for k, one in enumerate((sliding, rocking)):
        own = [run for signs in one.by_sign for run in signs]
        assert len(own) == 2  # both signs of the motion
        gaps = [float(run.peaks["gap"][0]) for run in own] + one.runs["least_gap"][:, 0].tolist()
        assert envelope.least_gaps[k, 0] == min(gaps)
        assert envelope.hits[k, 0] == sum(gap < 0.0 for gap in gaps)
        moved = [float(np.max(run.displacements)) for run in own] + np.max(one.runs["peak_u"], axis=1).tolist()
        assert envelope.moved[k] == max(moved)
    # with little friction the casks slide alike, with much the taller one rocks against the other
    assert not envelope.hits[0].any()
    assert envelope.hits[1].any()
    assert envelope.worst == 0
    assert envelope.answer == "FAILS at friction 0.2, of 2 values of friction from 0.2 to 0.7."


def test_the_lines_have_gaps_hits_and_first_contacts(envelope: Envelope) -> None:
    lines = friction_lines(envelope)
    assert [line.split()[0] for line in lines[:3]] == ["friction", "0.2", "0.7"]
    firsts = [one.first for run in envelope.checks[1].by_sign[0] for one in run.impacts if one.gap < 0.0]
    assert len(firsts) == 2  # both signs of the motion
    row = next(line for line in lines if line.startswith("first-second"))
    assert f"{envelope.hits[1, 0]} at 0.7" in row
    assert row.endswith(f"{min(firsts):.4g}")
    assert any("No vertical motion acts" in line for line in lines)


@pytest.mark.parametrize("text", ["0.2", "0.8:0.2:0.1", "0.2:0.8:0", "0.2:0.8:x", "0:1:0.1", "0.2:0.8:0.001"])
def test_a_wrong_range_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=re.escape(f"--friction {text}: must be FROM:TO:STEP")):
        friction_values(text)


def test_both_bounds_are_values() -> None:
    assert friction_values("0.2:0.8:0.2") == [0.2, 0.4, 0.6, 0.8]
    assert friction_values("0.2:0.7:0.2") == [0.2, 0.4, 0.6, 0.7]
    assert friction_values("0.5:0.5:0.1") == [0.5]


@pytest.mark.long  # takes seconds
def test_the_command_prints_and_reports_the_range(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pair.toml").write_text(FILE, encoding="utf-8")
    pulse = wavelets.ricker(3.6, 0.8)
    samples = np.interp(np.arange(0.0, 6.0, 0.01), pulse.time, pulse.ax)
    Motion.from_samples(0.01, samples).to_csv("pulse.csv")
    words = ["check", "pair.toml", "pulse.csv", "--friction", "0.2:0.7:0.5", "--no-margin", "--no-joints"]
    assert main([*words, "--ensemble", "1", "--report", "report.html"]) == 0
    printed = capsys.readouterr().out
    assert printed.index("pair 0.2, first period") < printed.index("FAILS at friction 0.2, of 2 values")
    page = Path("report.html").read_text(encoding="utf-8")
    assert "Over the friction of the joints" in page
    assert 'alt="Displacements, falls and least gaps over the friction"' in page
    # the second value is compared with the governing one, with its hits
    assert "As given these neighbours hit each other: first-second" in page
    assert main([*words, "--variant", "pair.toml"]) == 2
    assert "--friction 0.2:0.7:0.5: must be left out with --both and --variant" in capsys.readouterr().err


def test_at_most_fifty_values() -> None:
    assert len(friction_values("0.2:0.69:0.01")) == 50
    with pytest.raises(InputError, match="at most 50 values"):
        friction_values("0.2:0.699:0.01")  # 49.9 steps, and the upper bound


def test_a_run_without_gaps_changes_no_gap_and_no_share(envelope: Envelope) -> None:
    """Check the envelope and the rows of a check with the last varied run not finished."""
    whole = envelope.checks[1]
    table = Table(dict(whole.runs._columns), whole.runs.stats, of=whole.runs._of, kind=whole.runs._kind)
    gaps = table._columns["least_gap"] = whole.runs._columns["least_gap"].copy()
    gaps[-1] = np.nan
    cut = Envelope((0.7,), [replace(whole, runs=table)])
    every = [run.peaks["gap"][0] for runs in whole.by_sign for run in runs] + gaps[:-1, 0].tolist()
    assert cut.least_gaps[0, 0] == min(every)  # was nan
    assert cut.rows[0][-1] == f"{sum(gap < 0.0 for gap in every)} of 3 runs"
    assert "nan" not in " ".join(cut.pairs[0])
    rows = rows_of(whole.subject, whole.by_sign, table, whole.plan.limits, None, whole.verdicts)
    share = next(row for row in rows if row.name == "hits its neighbour")
    assert share.demand == np.mean(np.array(every) < 0.0)
    assert "of 3 runs, as given and varied, without 1 that have no gaps" in share.note
