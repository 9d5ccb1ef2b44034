"""The risk in a check: its fragility against a known law, and the command with a hazard."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from solver import InputError, Motion
from solver.checks.margin import Margin, Trial
from solver.checks.risk import risk_of
from solver.checks.scaling import ScaledMotion
from solver.checks.verdicts import Verdicts
from solver.commands.command_line import main
from solver.studies import Hazard

G = 9.80665
MEDIAN, DEVIATION, MODELS = 0.4, 0.3, 40
HAZARD = Hazard.power_law("pga", 2.0, 0.02, 10.0)


def checked(median: float = MEDIAN, margin: bool = True) -> Any:
    """Return what `risk_of` needs of a check whose models fall by a lognormal law of the PGA."""
    rng = np.random.default_rng(3)
    sizes = np.array([0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5])
    motions = [ScaledMotion(f"{s} g", Motion.harmonic(G * s, 1.0, 2.0)) for s in sizes]
    # each model of a motion falls beyond a capacity of its own
    capacity = median * np.exp(DEVIATION * rng.standard_normal((len(sizes), MODELS + 1)))

    def verdicts(factor: float, places: Any) -> Any:
        return np.where(factor * sizes[places, None] > capacity[places], "overturned", "standing")

    every = np.arange(len(sizes))
    own = verdicts(1.0, every)
    trials = tuple(
        Trial(factor, places, verdicts(factor, places)) for factor, places in ((0.6, every), (1.5, every[2:]))
    )
    found = Verdicts([one.name for one in motions], own[:, 0], own[:, 1:].ravel())
    return SimpleNamespace(
        action=SimpleNamespace(ground=(), motions=motions),
        by_sign=[[SimpleNamespace(verdict=one)] for one in found.own],
        verdicts=found,
        margin=Margin(0.5, 0.6, 0, trials) if margin else None,
    )


def test_the_law_of_the_falls_is_found() -> None:
    found = risk_of(checked(), HAZARD)
    # 1.6 % and 6 % off were measured, of 779 runs in 7 groups
    assert found.fragility.median == pytest.approx(MEDIAN, rel=0.05)
    assert found.fragility.deviation == pytest.approx(DEVIATION, rel=0.2)
    assert found.fragility.runs == (7 + 7 + 5) * (MODELS + 1)
    low, high = found.fragility.median_bounds
    assert low < MEDIAN < high
    # the ground's motions count, those as applied are of a floor
    floor = checked()
    floor.action = SimpleNamespace(ground=floor.action.motions, motions=())
    assert risk_of(floor, HAZARD).rate == found.rate


@pytest.mark.parametrize("measure", ["pga", "pgv", "sa(0.6)", "rotd100(0.6)"])
def test_of_two_components_the_geometric_mean_counts(measure: str) -> None:
    """Compare components of twice and half the size, in either order, with one component alone."""

    def median(x: float, y: float) -> float:
        made = checked()
        for k, one in enumerate(made.action.motions):
            wave = one.motion.amplitude
            motion = replace(one.motion, amplitude=x * wave, amplitude_y=y * wave)
            made.action.motions[k] = one._replace(motion=motion)
        return risk_of(made, Hazard.power_law(measure, 2.0, 0.02, 10.0)).fragility.median

    if measure.startswith("rotd"):  # of all directions: of both components as they are
        assert median(2.0, 0.5) == pytest.approx(math.hypot(2.0, 0.5) * median(1.0, 0.0), rel=1e-6)  # measured: 2e-7
    else:
        assert median(2.0, 0.5) == median(0.5, 2.0) == pytest.approx(median(1.0, 0.0), rel=1e-6)  # measured: 0
    assert median(0.0, 1.0) == pytest.approx(median(1.0, 0.0), rel=1e-6)  # measured: 0


def test_too_few_falls_are_refused() -> None:
    for of, said in ((checked(50.0), "0 of 779 runs failed: a fragility needs some of both"),):
        with pytest.raises(
            InputError, match=f"hazard: the runs of the check have no fragility, make a study: PGA: {said}"
        ):
            risk_of(of, HAZARD)
    said = "the runs allow a rate above that of the hazard's least intensity, 2e-09 per year: too few motions"
    with pytest.raises(InputError, match=said):
        risk_of(checked(), Hazard.from_table("pga", [10.0, 20.0], [2e-9, 1e-9]))


@pytest.mark.long  # takes seconds
def test_the_command_says_the_risk_or_why_there_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    block = "[[block]]\nheight = 2.0\nwidth = 0.5\ndepth = 0.5\nmass = 1200.0\n"
    block += "joint = { stiffness = 2e9, damping = 2e-3 }\n"
    Path("block.toml").write_text(f'name = "block"\n{block}', encoding="utf-8")
    Path("hazard.csv").write_text("pga,rate\n0.01,50\n0.1,0.01\n0.4,0.0005\n", encoding="utf-8")
    time = np.arange(0.0, 3.0, 0.01)
    files = []
    for frequency, size in ((0.8, 4.0), (1.0, 3.2), (1.2, 3.8), (0.9, 2.6), (1.1, 4.4)):
        files.append(f"{frequency}.csv")
        Motion.from_samples(0.01, size * np.sin(2.0 * np.pi * frequency * time)).to_csv(files[-1])
    words = ["check", "block.toml", *files, "--plane", "--no-joints", "--ensemble", "4", "--hazard", "hazard.csv"]
    assert main([*words, "--report", "report.html"]) == 0
    said = capsys.readouterr().out
    page = Path("report.html").read_text(encoding="utf-8")
    for words_of in ("risk, hazard PGA from 0.01 g", "fragility: median PGA", "in 50 years"):
        assert words_of in said
        assert words_of in page
    assert "Risk of overturning" in page
    # both directions: a risk of each
    Path("slab.toml").write_text(f'name = "slab"\n{block.replace("depth = 0.5", "depth = 0.6")}', encoding="utf-8")
    assert main(["check", "slab.toml", *(word for word in words[2:] if word != "--plane"), "--both"]) == 0
    risks = [line for line in capsys.readouterr().out.splitlines() if line.startswith("risk of slab")]
    assert [line.partition(",")[0].partition(":")[0] for line in risks] == ["risk of slab", "risk of slab across"]
    # one motion: no fragility follows, and the check is as without a hazard
    words = ["check", "block.toml", files[0], "--plane", "--no-joints", "--no-margin", "--pga", "0.01"]
    assert main([*words, "--hazard", "hazard.csv", "--report", "report.html", "--force"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    assert "PASSES" in captured.out
    (line,) = [line for line in captured.out.splitlines() if line.startswith("risk: ")]
    assert "the runs of the check have no fragility, make a study: PGA: 0 of 9 runs failed" in line
    assert line in Path("report.html").read_text(encoding="utf-8")
