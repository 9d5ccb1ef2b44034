"""Checks of structures in space: against runs made apart, the same block in its plane, and symmetry."""

import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT

from multiblock import (
    Block,
    Check,
    Column,
    InputError,
    Joint,
    Motion,
    Plan,
    Structure,
    check,
    simulate,
    spectra,
    spectrum,
    wavelets,
)
from solver.checks.action import ARTIFICIAL, Level, action_on
from solver.checks.check import check_limits
from solver.checks.kinematic import rocking_period
from solver.checks.limits import Limits
from solver.checks.margin import NARROW
from solver.checks.of_column import InPlane
from solver.checks.runs import span_of
from solver.checks.scaling import horizontal_pga, horizontal_psa, scaled_to_pga, scaled_to_sa, scaled_to_spectrum
from solver.checks.subject import subject_of
from solver.checks.table import Row, _overlap
from solver.checks.verdicts import falls, verdicts_of
from solver.commands.check_report import check_lines
from solver.commands.command_line import main
from solver.common.digits import three_digits
from solver.models.protocol import SETTLE, WORDS
from solver.models.structure.blocks.faces import Face
from solver.models.structure.blocks.shapes import rectangle
from solver.models.structure.overlap import Overlap
from solver.models.structure.stack import column_of
from solver.runs.table import Table

G = 9.80665
TRILITH = ROOT / "examples" / "structures" / "trilith.toml"
COLUMN = Column("block", (Block(2.0, 0.5, 0.5, 1200.0, Joint(2e9, 2e-3, strength=2e6)),))
BLOCK = Structure.stack(COLUMN)
ALONG, ACROSS = wavelets.one_sine(G, 1.2), wavelets.one_sine(G, 2.0)
BOTH = ALONG.with_across(ACROSS)
NOISE = wavelets.filtered_noise(1.0, 2.5, 8.0, 1).with_across(wavelets.filtered_noise(0.7, 2.0, 8.0, 2))
QUICK = Plan(ensemble=2, margin=False, joints=False)


def row(made: Check, name: str) -> Row:
    return next(one for one in made.rows if one.name == name)


@pytest.fixture(scope="module")
def found() -> Check:
    """Return the trilith, one joint of which has a strength, under one short motion in two directions."""
    trilith = Structure.from_toml(TRILITH)
    beds = [replace(trilith.joints[0].bed, strength=15e6), *(joint.bed for joint in trilith.joints[1:])]
    joints = tuple(replace(joint, bed=bed) for joint, bed in zip(trilith.joints, beds, strict=True))
    return check(replace(trilith, joints=joints), {"pulse": BOTH}, pga=0.2 * G, plan=QUICK)


def test_rows_have_the_worse_of_both_ways(found: Check) -> None:
    motion = found.action.motions[0].motion
    ways, span = (motion, motion.mirrored()), span_of(motion)
    runs = [simulate(found.subject.model, way, duration=span, settle=SETTLE) for way in ways]
    assert "overturned" not in [run.verdict for run in runs]
    assert row(found, "displacement").demand == max(np.max(run.peaks["u"]) for run in runs)
    pressure = row(found, "pressure at the edge")
    assert (pressure.where, pressure.capacity) == ("left-base", 15e6)  # the only one that has a strength
    assert pressure.demand == max(run.peaks["sigma_max"][0] for run in runs)
    assert row(found, "opening").demand == 1.0 - min(np.min(run.peaks["contact"]) for run in runs)
    assert row(found, "slip").demand == pytest.approx(max(np.max(np.abs(run.slip - run.slip[0])) for run in runs))
    assert row(found, "slip").capacity == pytest.approx(0.05 * 0.9)
    assert found.by_hand is None
    assert found.agreement == ()
    assert "of 2 varied structures" in found.verdict


def test_the_sign_that_moves_less_may_govern_ties_and_neighbours() -> None:
    """Check a cask that slides freely one way, and the other way stretches a tie and hits a wall 20 mm away."""
    cask = {
        "name": "cask",
        "on": "base",
        "at": [0.0, 0.0],
        "width": 1.0,
        "depth": 1.0,
        "height": 1.0,
        "density": 2500.0,
    }
    tie = {
        "between": ["cask", "base"],
        "from": [-0.5, 0.0, 0.0],
        "to": [-1.5, 0.0, 0.5],
        "stiffness": 2e6,
        "yield": 5e3,
    }
    wall = {"at": [0.52, 0.0, 0.0], "normal": [-1.0, 0.0], "width": 4.0, "height": 3.0}
    data = {"name": "cask", "joints": {"stiffness": 5e8, "damping": 2e-3, "friction": 0.15}, "block": [cask]}
    data |= {"tie": [tie], "neighbours": {"stiffness": 1e9, "restitution": 0.5, "friction": 0.4, "wall": [wall]}}
    push = 0.4 * G * np.sin(2.0 * np.pi * 0.8 * np.arange(0.0, 0.626, 0.005))  # the half of a sine
    structure, motion = Structure.from_dict(data), Motion.from_samples(0.005, push)
    plan = replace(QUICK, ensemble=1, limits=Limits(hits=0.0, slip=0.5, residual=0.5))
    ways, span = (motion, motion.mirrored()), span_of(motion)
    free, stopped = (simulate(structure, way, duration=span, settle=SETTLE) for way in ways)
    assert np.max(free.peaks["u"]) > np.max(stopped.peaks["u"])
    for way in (motion, motion.mirrored()):
        made = check(structure, {"sine": way}, plan=plan)
        assert made.responses[0].peaks["u"] == free.peaks["u"]
        assert row(made, "displacement").demand == free.peaks["u"][0]
        assert row(made, "force of a tie").demand == stopped.peaks["tie"][0] > 1e6 * free.peaks["tie"][0]
        assert row(made, "gap that is left").demand == stopped.peaks["gap"][0] < 0.0 < free.peaks["gap"][0]
        assert row(made, "force between neighbours").demand == stopped.peaks["hit"][0] > 0.0 == free.peaks["hit"][0]
        assert made.answer == "FAILS by: hits its neighbour."
        assert made.impacts_sentence.startswith("As given these neighbours hit each other: cask-wall 1 under 1 of 1 ")


def test_limits_that_no_row_of_a_structure_has_are_refused() -> None:
    """Check slips of bearings, which have no width, and slips of joints that cannot slide, also with `friction`."""
    rubber = subject_of(Structure.from_toml(ROOT / "examples" / "structures" / "statue-on-rubber.toml"))
    check_limits(Limits(slip=0.01), [rubber])
    bearings = SimpleNamespace(
        joints=SimpleNamespace(friction=np.zeros(2), width=np.full(2, math.nan), names=("a", "b")), model=rubber.model
    )
    for limits, name in ((Limits(slip=0.01), "slip"), (Limits(residual=0.01), "residual")):
        with pytest.raises(InputError, match=f"limits.{name}: must be left out, no joint has friction"):
            check_limits(limits, [bearings])  # type: ignore[list-item]
    stiff = subject_of(replace(BLOCK, described=None))
    with pytest.raises(InputError, match=r"limits\.slip: must be left out, no joint has friction"):
        check_limits(Limits(slip=0.01, friction=0.5), [stiff])


def test_each_motion_has_its_own_overlap() -> None:
    """Check a table in which a block slides off its joints under the second of three motions only."""
    deep = Overlap(0.3, ("a", "base"), 1.0, "ended")
    subject = SimpleNamespace(overlap=lambda run: run)
    demands = SimpleNamespace(subject=subject, by_sign=[[None], [None, deep], [Overlap()]])
    (found,) = _overlap(demands, Limits())  # type: ignore[arg-type]
    assert (found.values, found.demand) == ((0.0, 0.3, 0.0), 0.3)


@pytest.mark.long  # takes seconds
def test_a_block_has_the_margin_that_it_has_in_its_plane() -> None:
    """Check that the same factors are drawn for both; in space its joint gives along itself."""
    plan = Plan(ensemble=4, joints=False)
    flat, made = (check(model, [ALONG], pga=0.2 * G, plan=plan) for model in (COLUMN, BLOCK))
    assert flat.margin is not None
    assert made.margin is not None
    assert made.margin.falls == pytest.approx(flat.margin.falls, rel=NARROW - 1.0)  # measured: the same
    assert made.action.motions[0].factor == flat.action.motions[0].factor
    assert row(made, "pressure at the edge").demand == pytest.approx(row(flat, "pressure at the edge").demand, rel=5e-3)
    asked, planar = (row(one, "friction asked for").demand for one in (made, flat))
    assert asked == pytest.approx(planar, rel=1e-3)  # measured: 9e-5; of the pressure 1.5e-3
    assert math.isnan(row(made, "displacement").capacity)
    assert made.subject.longest == pytest.approx(flat.subject.longest, rel=0.01)  # rigid against elastic: 5e-3


def test_a_square_block_does_not_know_the_direction() -> None:
    turned = replace(ALONG, ax=np.zeros_like(ALONG.ax), ay=ALONG.ax)
    made = [check(BLOCK, [motion], pga=0.25 * G, plan=QUICK) for motion in (ALONG, turned, ALONG.mirrored())]
    tops = [row(one, "displacement").demand for one in made]
    assert tops[0] == tops[2]
    assert tops[1] == pytest.approx(tops[0], rel=1e-9)  # measured: 1e-15
    assert [one.action.motions[0].factor for one in made] == [made[0].action.motions[0].factor] * 3


def test_the_action_says_what_is_scaled() -> None:
    subject, level = subject_of(BLOCK), Level(None, 0.1 * G, None, None, None, 0.9, ARTIFICIAL, False, 0)
    along, of_both = (
        "largest horizontal acceleration of 0.1 g",
        "geometric mean of its largest horizontal accelerations",
    )
    assert action_on(subject, [ALONG], level).how == f"each to a {along}"
    turned = replace(ALONG, ax=np.zeros_like(ALONG.ax), ay=ALONG.ax)
    assert action_on(subject, [turned], level).how == f"each to a {along}"
    assert action_on(subject, [ALONG, NOISE], level).how == f"each to a {of_both} of 0.1 g"
    level = replace(level, pga=None, sa=0.2 * G)
    assert "each to a spectral acceleration of 0.2 g at" in action_on(subject, [ALONG], level).how
    assert (
        "a geometric mean of its horizontal spectral accelerations of 0.2 g" in action_on(subject, [NOISE], level).how
    )


def test_two_components_are_scaled_together_by_their_geometric_mean() -> None:
    target, periods = spectra.eurocode8(2.0, "B"), np.geomspace(0.1, 1.5, 40)
    (peak,) = scaled_to_pga({"a": NOISE}, 3.0)
    assert np.max(np.abs(peak.motion.ax)) * np.max(np.abs(peak.motion.ay)) == pytest.approx(9.0, rel=1e-12)
    (one,) = scaled_to_sa({"a": NOISE}, 0.4, 5.0)
    psa = [spectrum(one.motion, [0.4], component=name).psa[0] for name in ("ax", "ay")]
    assert math.sqrt(psa[0] * psa[1]) == pytest.approx(5.0, rel=1e-12)
    (fitted,) = scaled_to_spectrum({"a": NOISE}, target, (0.1, 1.5), least=0.0)
    ratio = horizontal_psa(fitted.motion, periods) / target.psa(periods)
    assert np.mean(np.log(ratio)) == pytest.approx(0.0, abs=1e-12)
    for scaled in (peak, one, fitted):
        np.testing.assert_allclose(scaled.motion.ay, scaled.factor * NOISE.ay, rtol=1e-14)
    assert horizontal_pga(replace(NOISE, ax=np.zeros_like(NOISE.ax))) == np.max(np.abs(NOISE.ay))


def test_artificial_motions_follow_the_target_along_both_directions() -> None:
    target, periods = spectra.eurocode8(0.05 * G, "A"), np.geomspace(0.05, 2.0, 20)
    made = check(BLOCK, target=target, artificial=1, plan=Plan(ensemble=1, margin=False, joints=False))
    motion = made.action.motions[0].motion
    for name in ("ax", "ay"):
        ratio = spectrum(motion, periods, component=name).psa / target.psa(periods)
        assert 0.8 < ratio.min() < ratio.max() < 1.2
    assert abs(np.corrcoef(motion.ax, motion.ay)[0, 1]) < 0.1
    assert made.passes


def test_force_of_a_tie_beside_its_yield() -> None:
    data: dict[str, Any] = {
        "name": "tied",
        "joints": {"stiffness": 2e9, "damping": 2e-3, "strength": 3e6},
        "block": [{"name": "a", "on": "base", "width": 0.5, "depth": 0.5, "height": 2.0, "mass": 1200.0}],
        "tie": [
            {"between": ["a", "base"], "from": [0, 0, 0.9], "to": [2.0, 0.0, 0.0], "stiffness": 1e5, "yield": 5e3},
            {"between": ["a", "base"], "from": [0, 0, 0.9], "to": [-2.0, 0.0, 0.0], "stiffness": 1e6},
        ],
    }
    structure = Structure.from_dict(data)
    made = check(structure, [ALONG], pga=0.25 * G, plan=QUICK)
    force = row(made, "force of a tie")
    assert (force.where, force.capacity) == ("tie 1", 5e3)  # the only one that yields
    motion = made.action.motions[0].motion
    pulls = [simulate(structure, way, settle=SETTLE).peaks["tie"][0] for way in (motion, motion.mirrored())]
    assert force.demand in pulls
    assert force.demand > 0.0
    assert row(made, "pressure at the edge").capacity == 3e6
    other = Structure.from_dict({**data, "joints": {**data["joints"], "strength": 4e6}})
    assert subject_of(other).digest() != made.subject.digest()


def test_the_turned_motion_is_named_where_it_alone_overturns() -> None:
    data: dict[str, Any] = {
        "name": "held",
        "joints": {"stiffness": 2e9, "damping": 2e-3},
        "block": [{"name": "a", "on": "base", "width": 0.5, "depth": 0.5, "height": 2.0, "mass": 1200.0}],
        "tie": [{"between": ["a", "base"], "from": [0, 0, 0.9], "to": [2.0, 0.0, 0.0], "stiffness": 1e6, "yield": 1e6}],
    }
    motion = wavelets.one_sine(0.4 * G, 1.0)  # it falls from 0.38 g with one sign, beyond 0.45 g with the other
    for way, name in ((motion, "pulse turned by 180 degrees"), (motion.mirrored(), "pulse")):
        made = check(Structure.from_dict(data), {"pulse": way}, plan=QUICK)
        assert f" under {name} (block a)" in made.falls_sentence
        assert f" under {name}: under this motion it falls first" in made.governing_sentence


def test_hits_of_neighbours_and_the_gap_that_is_left() -> None:
    """Count the hits of two drums, of which the higher one rocks under the second motion, from the runs themselves."""
    drum = {"on": "base", "shape": "drum", "diameter": 1.0, "density": 2000.0}
    blocks = [
        {**drum, "name": "low", "at": [0.0, 0.0], "height": 2.0},
        {**drum, "name": "high", "at": [1.03, 0.0], "height": 4.0},
    ]
    neighbours = {"reach": 0.1, "line_stiffness": 1e8, "restitution": 0.3, "friction": 0.3}
    data = {"name": "two", "joints": {"stiffness": 1e9, "damping": 3e-3}, "block": blocks, "neighbours": neighbours}
    structure = Structure.from_dict(data)
    motions = {"weak": wavelets.one_sine(0.1 * G, 1.2), "strong": wavelets.one_sine(0.33 * G, 1.5)}
    made = check(structure, motions, plan=replace(QUICK, ensemble=4))
    hits, gap = row(made, "hits its neighbour"), row(made, "gap that is left")
    least = made.runs["least_gap"]
    own = [run.peaks["gap"] for signs in made.by_sign for run in signs]
    assert len(own) == 4  # both signs of two motions
    assert hits.demand == np.mean(np.vstack([own, least]) < 0.0)
    assert 0.0 < hits.demand < 1.0
    assert np.all(least[:4] > 0.0)  # of the weak motion
    assert made.runs.stats["lanes"] == 8
    assert hits.passes is None
    assert "no limit is given" in hits.note
    low, high, _ = (float(part) for part in re.findall(r"([\d.]+) %", hits.note))  # the last: the confidence
    assert low <= 100.0 * hits.demand <= high
    assert gap.where == "low-high"
    assert gap.values[0] > 0.0 > gap.values[1] == gap.demand
    nearest = [min(signs, key=lambda run: run.peaks["gap"][0]) for signs in made.by_sign]
    run, hard = nearest
    assert gap.values[0] == run.peaks["gap"][0] == pytest.approx(np.min(run.gap), abs=1e-5)
    assert "overlap of blocks" in [one.name for one in made.rows]
    # forces by pair, and the sentence of both
    force = row(made, "force between neighbours")
    assert (force.where, force.values[0], force.passes) == ("low-high", 0.0, None)
    (weak,), (strong,) = (run.impacts for run in nearest)
    assert (weak.between, weak.gap, weak.force, math.isnan(weak.first)) == ("low-high", gap.values[0], 0.0, True)
    assert (strong.gap, strong.force) == (gap.demand, force.demand)
    assert 0.0 < hard.time[np.flatnonzero(hard.hit[:, 0])[0]] - strong.first < hard.time[1]
    assert made.impacts_sentence == (
        f"As given these neighbours hit each other: low-high under 1 of 2 motions "
        f"({three_digits(1e-3 * force.demand)} kN under strong, first contact at {strong.first:.4g} s)."
    )
    assert made.impacts_sentence in check_lines(made)
    limited = check(structure, motions, plan=replace(QUICK, limits=Limits(hits=0.0)))
    assert row(limited, "hits its neighbour").passes is False
    assert limited.answer == "FAILS by: hits its neighbour."


def test_what_breaks_of_joints_that_bear_tension() -> None:
    """Check a pier that cracks in part, on a dry footing that has no row."""
    pier = {"name": "pier", "on": "foot", "width": 0.5, "depth": 1.0, "height": 2.0, "density": 2000.0}
    pier["joint"] = {"tensile_strength": 2e4, "cohesion": 1e6}
    foot = {"name": "foot", "on": "base", "width": 1.5, "depth": 1.5, "height": 0.3, "density": 2000.0}
    law = {"stiffness": 2e9, "damping": 2e-3, "friction": 0.8}
    structure = Structure.from_dict({"name": "pier", "joints": law, "block": [foot, pier]})
    made = check(structure, {"sine": wavelets.one_sine(0.15 * G, 3.0)}, plan=QUICK)
    cracked = row(made, "joint that cracks")
    assert cracked.where == "pier-foot"
    assert 0.0 < cracked.demand == 1.0 - made.responses[0].peaks["bond"][0] < 1.0
    assert cracked.passes is None


def test_what_still_rocks_is_undecided_and_what_fails_is_unfinished() -> None:
    """Check that a run without a rest has fallen, whatever else is said of it."""
    words = ("undecided", "undecided", "overturned", "standing")
    numbers = np.array([WORDS["verdict"].index(word) for word in words])
    table = Table({"verdict": numbers}, {"failures": {1: "why", 2: "no rest"}})
    assert verdicts_of(table).tolist() == ["undecided", "unfinished", "overturned", "standing"]
    assert falls(verdicts_of(table)).tolist() == [False, True, True, False]


def test_varied_structures_that_do_not_even_rest_count_as_fallen() -> None:
    """Check a slender block whose modulus is just above that at which it does not stand: every other one has less."""
    tall = {"name": "tall", "on": "base", "width": 0.2, "depth": 0.2, "height": 4.0, "density": 2000.0}
    weight, inertia = 2000.0 * 0.16 * G, 0.2**4 / 12.0
    law = {"stiffness": 1.05 * weight * 2.0 / inertia, "damping": 2e-3}
    data = {"name": "tall", "joints": law, "block": [tall]}
    slow = Motion.from_samples(0.5, [0.0, 1e-6, 0.0])
    found = check(Structure.from_dict(data), {"slow": slow}, plan=Plan(ensemble=8, margin=False, joints=False))
    fallen, undecided, size = found.fallen
    assert (size, undecided) == (8, 0)
    assert 0 < fallen < 8
    note = row(found, "overturning").note
    assert f"{fallen} of 8 runs fall, {fallen} of them under their weight alone (tall: " in note
    assert f"{fallen} of 8 varied structures fell" in found.verdict
    assert np.isfinite(found.subject.tops(found.runs)[found.runs["verdict"] == "standing"]).all()
    assert len(found.runs.stats["failures"]) == fallen


def test_a_rigid_block_rocks_with_the_period_of_its_mechanism() -> None:
    """Check (C8.7.1.10) of stiff blocks of any width: the mechanism has it from the whole curve of pushes."""
    for width in (0.2, 0.3):
        stiff = Column("stiff", (Block(2.0, width, 0.5, 1200.0, Joint(2e12, 1e-6)),))
        assert InPlane(stiff, 1.35).mechanism.period == pytest.approx(rocking_period(1.0, G, 1.35), rel=2e-3)  # 6e-4


def test_least_width_of_a_face() -> None:
    wide = Face(np.zeros(3), np.eye(3), rectangle(0.9, 0.4))
    angle = np.pi / 3.0 * np.arange(6)
    hexagon = Face(np.zeros(3), np.eye(3), np.column_stack([np.cos(angle), np.sin(angle)]))
    assert wide.width == pytest.approx(0.4, rel=1e-14)
    assert hexagon.width == pytest.approx(math.sqrt(3.0), rel=1e-14)
    assert Face(np.zeros(3), np.eye(3), np.empty((0, 2)), 0.3, 0.1).width == 0.6


def test_strength_goes_to_space_and_back() -> None:
    back = column_of(BLOCK)
    assert back is not None
    assert back.blocks[0].joint.strength == 2e6


def test_a_structure_without_weight_or_peaks_is_refused() -> None:
    with pytest.raises(InputError, match=r"g = 0.0: must be positive, without weight nothing falls"):
        check(replace(BLOCK, g=0.0), [ALONG], pga=1.0)
    with pytest.raises(InputError, match=r'solver.without has "peaks", must not in a check'):
        check(BLOCK.with_settings(without=("peaks",)), [ALONG], pga=1.0)
    with pytest.raises(InputError, match="column = 3: must be a Column or a Structure"):
        check(3, [ALONG], pga=1.0)  # type: ignore[arg-type]


@pytest.mark.long  # takes 10 s and more
def test_command_and_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    ALONG.to_csv("along.csv")
    ACROSS.to_csv("across.csv")
    words = ["check", str(TRILITH), "along.csv", "--across", "across.csv", "--pga", "0.2", "--no-margin"]
    assert main([*words, "--ensemble", "1", "--report", "report.html"]) == 0
    printed = capsys.readouterr().out
    for said in ("across across.csv: CSV", "across (g)", "by hand: nothing", "1 varied structures"):
        assert said in printed
    # both posts are pressed alike: which one more, the last digits of the linear algebra of a machine decide
    assert re.search(r"pressure at the edge +(left|right)-base ", printed)
    text = Path("report.html").read_text(encoding="utf-8")
    assert text.count("data:image/png;base64,") == 4
    for said in ("The structure", "3.9 x 0.9 x 0.7", "left-base to beam-right", "The blocks move in space"):
        assert said in text
    assert main(["check", str(TRILITH), "along.csv", "--across", "across.csv", "across.csv"]) == 2
    assert "--across: 2 files, must be 1, one for each record" in capsys.readouterr().err


def test_a_column_refuses_a_second_component() -> None:
    with pytest.raises(InputError, match="ay"):
        check(COLUMN, [BOTH], pga=1.0)


def test_motion_has_measures_across() -> None:
    across = spectrum(BOTH, [0.5], component="ay").sd[0]  # over the instants of both: measured 1e-10 apart
    assert across == pytest.approx(spectrum(ACROSS, [0.5]).sd[0], rel=1e-8)
    harmonic = Motion.harmonic(2.0, 1.0, 3.0, direction=0.5)
    sizes = [spectrum(harmonic, [0.7], component=name).psa[0] for name in ("ax", "ay")]
    assert sizes[1] / sizes[0] == pytest.approx(math.tan(0.5), rel=1e-12)
    assert horizontal_pga(harmonic) == pytest.approx(2.0 * math.sqrt(math.cos(0.5) * math.sin(0.5)), rel=1e-12)
    behind = BOTH.mirrored()
    np.testing.assert_array_equal(behind.ay, -BOTH.ay)
    np.testing.assert_array_equal(behind.mirrored().ay, BOTH.ay)
