"""The command `gallery`: its outcomes against runs made one by one, its files, and its end after an interruption."""

import csv
import hashlib
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT

from multiblock import InputError, Motion, simulate, wavelets
from solver.checks.action import Action
from solver.checks.limits import TOLERANCE, Plan
from solver.checks.runs import run_all, varied
from solver.checks.scaling import ScaledMotion
from solver.checks.subject import subject_of
from solver.commands.command_line import main
from solver.gallery.mounts import Mount, mounted
from solver.gallery.objects import Exhibit
from solver.gallery.survey import Outcome, outcome_of, survey
from solver.models.protocol import SETTLE, WORDS
from solver.runs.table import Table

THIN = Exhibit(
    "thin", "marble", {"width": 0.2, "depth": 0.2, "height": 1.2, "mass": 60.0, "centroid": 0.6}, "", {}, True, 0
)
MOUNTS = (Mount("free"), Mount("wide", foot=3.0))
PLAN = Plan(ensemble=3, margin=False, joints=False)


def action() -> Action:
    """Return two pulses, the first of which overturns the thin object."""
    pulses = {"strong": wavelets.ricker(4.0, 0.7), "weak": wavelets.ricker(0.5, 0.7)}
    return Action(tuple(ScaledMotion(*pair) for pair in pulses.items()), "as given")


def test_an_outcome_is_that_of_runs_made_one_by_one() -> None:
    acting = action()
    for mount in MOUNTS:
        subject = subject_of(mounted(THIN, mount))
        found = outcome_of(subject, acting, PLAN)
        runs = []
        for place, scaled in enumerate(acting.motions):
            pairs = [(subject.model, scaled.motion), *varied(subject, None, scaled, PLAN, place)]
            for model, motion in pairs:
                run = simulate(model, motion, tolerance=TOLERANCE, settle=SETTLE, check=False)
                runs.append((scaled.name, run))
        fallen = [(run.overturn_time, name) for name, run in runs if run.overturned]
        assert (found.fallen, found.undecided, found.runs) == (len(fallen), 0, 8)
        assert found.holds == (not fallen)
        moved = max(float(np.max(run.displacements)) for _, run in runs if not run.overturned)
        # in lanes and alone agree to the tolerance of 1e-3 of the peak
        assert found.moved == pytest.approx(moved, rel=5e-3)
        if fallen:
            time, name = min(fallen)
            assert found.first.startswith("object at ")
            assert found.first.endswith(f" s under {name}")
            assert float(found.first.split()[2]) == pytest.approx(time, rel=5e-3)
    assert not outcome_of(subject_of(mounted(THIN, MOUNTS[0])), acting, PLAN).holds
    assert found.holds


def test_displacements_are_unknown_if_every_run_falls() -> None:
    strong = replace(action(), motions=action().motions[:1])
    found = outcome_of(subject_of(mounted(THIN, MOUNTS[0])), strong, PLAN)
    assert (found.fallen, found.runs) == (4, 4)
    assert math.isnan(found.moved)


def test_an_interrupted_gallery_goes_on_to_the_same_outcomes(tmp_path: Path) -> None:
    subjects = [subject_of(mounted(THIN, mount)) for mount in MOUNTS]
    given = [THIN], MOUNTS, subjects, {0: action()}, PLAN
    whole = survey(*given, tmp_path / "whole.journal")
    assert whole.first_mount(0) == "wide"
    # cut off within the last line
    lines = (tmp_path / "whole.journal").read_bytes().splitlines(keepends=True)
    (tmp_path / "cut.journal").write_bytes(b"".join(lines[:2]) + lines[2][:20])
    seen: list[tuple[int, int | None]] = []
    again = survey(*given, tmp_path / "cut.journal", lambda done, total: seen.append((done, total)))
    assert seen == [(8, 16), (16, 16)]
    assert repr(again.outcomes) == repr(whole.outcomes)
    with pytest.raises(InputError, match="holds another study"):
        survey(*given[:-1], replace(PLAN, ensemble=2), tmp_path / "whole.journal")


def test_words_of_an_outcome() -> None:
    holds = Outcome(0, 0, 8, 0.0, 0.1, math.nan, math.nan, 0.01, math.nan, math.nan, "")
    assert holds.text == "holds"
    assert replace(holds, fallen=3).text == "3 fall"
    assert replace(holds, undecided=2).text == "2 undecided"
    assert replace(holds, stands=1.5, falls=1.6).text == "holds, 1.5"
    assert replace(holds, stands=3.84, falls=math.inf).text == "holds, over 3.84"
    assert replace(holds, fallen=1, stands=0.7, falls=0.72).text == "1 fall, 0.7"


def test_objects_are_not_overwritten_by_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("objects.csv").write_text("name,material,width,depth,height,mass,centroid\nA,marble,1,1,1,2700,0.5\n")
    Path("mounts.toml").write_text('[[mount]]\nname = "free"\n')
    before = Path("objects.csv").read_text()
    words = ["gallery", "objects.csv", "--mounts", "mounts.toml", "--pga", "0.1", "--no-margin", "--ensemble", "1"]
    Motion.from_samples(0.01, np.sin(np.arange(0.0, 0.3, 0.01))).to_csv("pulse.csv")
    assert main([*words, "pulse.csv"]) == 2
    assert "objects.csv: is there already, without objects.journal: must be moved" in capsys.readouterr().err
    assert Path("objects.csv").read_text() == before
    assert not Path("objects.journal").exists()


@pytest.mark.long  # takes 10 s and more
def test_the_example_is_written_as_table_and_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    pulse = wavelets.ricker(1.0, 1.0)
    Motion.from_samples(0.01, np.interp(np.arange(0.0, 3.0, 0.01), pulse.time, pulse.ax)).to_csv("pulse.csv")
    example = ROOT / "examples" / "gallery"
    files = [str(example / "objects.csv"), "--mounts", str(example / "mounts.toml")]
    words = ["gallery", *files, "--pga", "0.15", "--ensemble", "1", "--no-margin", "--note", "Hall <3>", "pulse.csv"]
    assert main(words) == 2
    assert "Bust of a poet: floor = 2: needs --building" in capsys.readouterr().err
    words += ["--building", str(example / "hall.toml"), "--floor", "0", "--output-folder", "results"]
    assert main(words) == 0
    printed = capsys.readouterr().out
    assert "object          first that holds  free" in printed
    rows = list(csv.DictReader(Path("results/objects.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 6 * 6
    assert {row["runs"] for row in rows} == {"2"}
    page = Path("results/objects.html").read_text(encoding="utf-8")
    assert page.count("<img") == 1
    assert "Hall &lt;3&gt;" in page
    assert "Floors are those of" in page
    assert "none falls" not in page  # of the margins
    for name in ("Kore", "Athlete", "Bust of a poet", "Head", "Stele", "Mesh statue"):
        assert f"<h2>{name}</h2>" in page
    # the same again makes no run, and another command refuses the journal
    assert main(words) == 0
    assert capsys.readouterr().out == printed
    again = Path("results/objects.html").read_text(encoding="utf-8")
    assert "had made 36 of the 36 pairs" in again
    assert "had made" not in page
    for path in (example / "objects.csv", example / "mounts.toml", example / "hall.toml", Path("pulse.csv")):
        assert hashlib.sha256(path.read_bytes()).hexdigest() in page
    assert "bearing (kind pendulum, period 2.5" in page  # of a mount
    assert main([*words, "--spread-seed", "1"]) == 2
    assert "holds another study" in capsys.readouterr().err
    assert main(["gallery", *files, "--sa", "0.2", "pulse.csv"]) == 2
    assert "--sa: must be left out, first periods differ" in capsys.readouterr().err


@pytest.mark.parametrize("only", [False, True])
def test_the_first_fall_is_one_that_was_seen(only: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Check a pair one run of which could not be finished, and another fell under its weight alone."""
    codes = [WORDS["verdict"].index(word) for word in ("undecided", "standing" if only else "overturned")]

    def made(*arguments: Any, **options: Any) -> Table:
        table = run_all(*arguments, **options)
        columns = table._columns
        columns["verdict"][:] = WORDS["verdict"].index("standing")
        columns["verdict"][:2], columns["overturn_time"][:2], columns["fallen"][:2] = codes, (math.nan, 0.0), 0
        table.stats["failures"] = {0: "why"} if only else {0: "why", 1: "no rest"}
        return table

    monkeypatch.setattr("solver.gallery.survey.run_all", made)
    found = outcome_of(subject_of(mounted(THIN, MOUNTS[1])), action(), PLAN)
    assert found.fallen == (1 if only else 2)
    said = "none, but 1 run could not be finished" if only else "all of it, under its weight alone, at 0 s under strong"
    assert found.first == said  # was "bearing at nan s under strong"
